//! Result of one measurement.

use super::team::TeamResults;

/// The result of one item of the plan in one round.
#[derive(Debug, Default)]
pub struct Measured {
    /// Times of a unit of work, for every figure of the item \[s\].
    pub times: Vec<Vec<f64>>,
    /// Ratios of the rate to that of one thread, for every team except the first.
    pub gains: Vec<Vec<f64>>,
    /// Bytes of one table; 0 without tables.
    pub bytes: usize,
    /// Work of a mesh cycle, if kernels integrate.
    pub work: Work,
    /// Why threads could not be bound; `None` if they were.
    pub unbound: Option<String>,
}

/// Work of a mesh cycle, counted.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Work {
    /// Numbers read from tables, each for one multiply-add.
    pub numbers: f64,
    /// Bytes of distinct numbers among them.
    pub distinct: f64,
}

impl<R> From<TeamResults<R>> for Measured {
    fn from(results: TeamResults<R>) -> Self {
        Self {
            times: results.times,
            unbound: results.unbound,
            ..Self::default()
        }
    }
}
