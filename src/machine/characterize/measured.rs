//! What one measurement gives.

use super::team::Worked;

/// What one measurement of an item gave.
#[derive(Debug, Default)]
pub struct Measured {
    /// Times of a unit of work, for every figure of the item \[s\].
    pub times: Vec<Vec<f64>>,
    /// Rate over that of one thread, for every team but the first.
    pub gains: Vec<Vec<f64>>,
    /// Bytes of one table, where it has tables.
    pub bytes: usize,
    /// Work of a mesh cycle, where kernels integrate.
    pub work: Work,
    /// Why threads could not be bound, where they could not.
    pub unbound: Option<String>,
}

/// Work of a mesh cycle, counted.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Work {
    /// Numbers of tables read, each for one multiply-add.
    pub numbers: f64,
    /// Bytes of different numbers among them.
    pub distinct: f64,
}

impl<R> From<Worked<R>> for Measured {
    fn from(worked: Worked<R>) -> Self {
        Self {
            times: worked.times,
            unbound: worked.unbound,
            ..Self::default()
        }
    }
}
