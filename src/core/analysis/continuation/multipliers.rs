//! Floquet multipliers of a followed orbit, and determinants that say the same of single ones.

use super::orbit::{NoOrbit, Orbit};
use crate::numerics::linalg::{determinant, eigenvalues_in_parts};
use faer::Mat;
use num_complex::Complex64;
use std::sync::OnceLock;

/// Multipliers, from when they are first asked for.
#[derive(Debug, Clone, Default)]
pub struct Multipliers(OnceLock<Vec<Complex64>>);

impl Multipliers {
    /// Given ones.
    pub fn known(values: Vec<Complex64>) -> Self {
        Self(values.into())
    }
}

impl Orbit {
    /// Floquet multipliers, largest modulus first; none where the iteration fails, which [`Self::with_multipliers`] refuses.
    pub fn multipliers(&self) -> &[Complex64] {
        (self.multipliers.0).get_or_init(|| {
            let matrix: &Mat<f64> = &self.monodromy;
            eigenvalues_in_parts(matrix.as_ref()).unwrap_or_default()
        })
    }

    /// The same orbit once its multipliers are known.
    ///
    /// # Errors
    /// [`NoOrbit`] where they are not finite.
    pub fn with_multipliers(self) -> Result<Self, NoOrbit> {
        match self.multipliers().len() == self.u.len() {
            true => Ok(self),
            false => Err(NoOrbit::Newton {
                residual: self.residual,
            }),
        }
    }

    /// `det(M − c I)` for a real c: the logarithm of its size, and its sign.
    pub(super) fn determinant(&self, c: f64) -> (f64, f64) {
        match self.multipliers.0.get() {
            Some(known) => product(known.iter().map(|m| m - c)),
            None => determinant(shifted(&self.monodromy, c)),
        }
    }
}

/// `M − c I`.
pub(super) fn shifted(monodromy: &Mat<f64>, c: f64) -> Mat<f64> {
    let mut matrix = monodromy.clone();
    for i in 0..matrix.nrows() {
        matrix[(i, i)] -= c;
    }
    matrix
}

/// The logarithm of a product's size and its sign.
pub(super) fn product(factors: impl Iterator<Item = Complex64>) -> (f64, f64) {
    let (mut size, mut sign) = (0.0, 1.0);
    for factor in factors {
        size += factor.norm().ln();
        // Complex factors come in pairs, whose product is positive.
        if factor.im == 0.0 && factor.re < 0.0 {
            sign = -sign;
        }
    }
    (size, sign)
}
