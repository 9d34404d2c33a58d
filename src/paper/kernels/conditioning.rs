//! Does a spectral basis serve?

use crate::propagate::TableError;

/// How well one basis behaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conditioning {
    /// A mesh segment it serves.
    pub segment: usize,
    /// Whether it is that of contact.
    pub touching: bool,
    /// Condition number of the eigenvector basis of the blocks that are diagonalised, each
    /// velocity in units of its frequency.
    pub condition: f64,
    /// Largest error of a cell's propagator rebuilt from the basis, relative to its largest
    /// entry, against the Taylor series.
    pub reconstruction: f64,
}

/// Largest error of a rebuilt propagator that is let pass: of a drive of forty modes it is 1e-15,
/// of nearly parallel eigenvectors some 1e-16 times their condition number.
const WORST_RECONSTRUCTION: f64 = 1e-11;

impl Conditioning {
    /// Whether the basis serves.
    pub(super) fn check(&self) -> Result<(), TableError> {
        // Written so that an error that is no number is refused.
        if self.reconstruction <= WORST_RECONSTRUCTION {
            Ok(())
        } else {
            Err(TableError::Defective {
                condition: self.condition,
                error: self.reconstruction,
            })
        }
    }
}
