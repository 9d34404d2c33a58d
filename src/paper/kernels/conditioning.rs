//! Is a spectral basis accurate enough?

use crate::propagate::TableError;

/// Numerical quality of one basis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conditioning {
    /// Index of a mesh segment that uses the basis.
    pub segment: usize,
    /// Whether the basis is for contact, not for free flight.
    pub touching: bool,
    /// Condition number of the eigenvector basis of the diagonalised blocks, with each velocity in units of its
    /// frequency.
    pub condition: f64,
    /// Largest error of a cell's propagator rebuilt from the basis, relative to its largest
    /// entry, against the Taylor series.
    pub reconstruction: f64,
}

/// Largest accepted error of a rebuilt propagator. A drive with forty modes has 1e-15, nearly parallel eigenvectors
/// have about 1e-16 times their condition number.
const WORST_RECONSTRUCTION: f64 = 1e-11;

impl Conditioning {
    /// Checks that the basis is accurate enough.
    pub(super) fn check(&self) -> Result<(), TableError> {
        // The comparison also refuses NaN.
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
