//! Covariant vectors in the basis of orthonormalised tangents.
//!
//! A cycle with the Jacobian J maps the tangents Q to `J Q = Q' R`, with R upper triangular. A prime marks the end of
//! the cycle. Covariant vectors `V = Q C`, with `J V = V' D` and D diagonal, satisfy `R C = C' D`. From any upper
//! triangular C at the end of a record, the backward recursion `C = R⁻¹ C' D` converges to the coefficients of the
//! covariant vectors (Ginelli et al. 2007, 2013). Q is orthonormal, so that angles between the vectors are those
//! between the columns of C.

use crate::numerics::linalg::{product, symmetric_eigen};
use crate::numerics::random::Stream;
use faer::Mat;

/// Number of entries of an upper triangular matrix, stored column by column.
pub(super) fn entries(vectors: usize) -> usize {
    vectors * (vectors + 1) / 2
}

/// Index of the first entry of a column.
fn column(index: usize) -> usize {
    entries(index)
}

/// Coefficients C of unit vectors, propagated backwards in time.
#[derive(Debug, Clone)]
pub(super) struct Coefficients {
    vectors: usize,
    /// Columns of C, upper triangular.
    packed: Vec<f64>,
}

/// Length of a unit vector's part outside a space, below which it counts as a vector of the space.
const DEPENDENT: f64 = 1e-12;

impl Coefficients {
    /// Random coefficients.
    pub fn random(vectors: usize, stream: &mut Stream) -> Self {
        let mut packed: Vec<f64> = (0..entries(vectors)).map(|_| stream.normal()).collect();
        for i in 0..vectors {
            normalise(&mut packed[column(i)..column(i + 1)]);
        }
        Self { vectors, packed }
    }

    /// Sets the coefficients, column by column.
    #[cfg(test)]
    pub fn set(&mut self, packed: &[f64]) {
        self.packed.copy_from_slice(packed);
    }

    /// The first i + 1 coefficients of vector i; the further ones are 0.
    pub fn vector(&self, i: usize) -> &[f64] {
        &self.packed[column(i)..column(i + 1)]
    }

    /// Propagates the vectors backwards through a cycle with the factor R. Writes the logarithm of each
    /// vector's growth over the cycle, forwards in time, to `growth`.
    pub fn back(&mut self, factor: &[f64], growth: &mut [f64]) {
        for (i, growth) in growth.iter_mut().enumerate().take(self.vectors) {
            let c = &mut self.packed[column(i)..column(i + 1)];
            for row in (0..=i).rev() {
                let (above, diagonal) = c.split_at_mut(row);
                let r = &factor[column(row)..column(row + 1)];
                diagonal[0] /= r[row];
                for (x, r) in above.iter_mut().zip(r) {
                    *x -= diagonal[0] * r;
                }
            }
            *growth = -normalise(c).ln();
        }
    }

    /// The smallest angle between the space of the first `unstable` vectors and that of the last `stable`
    /// vectors \[rad\]; `None` if the computation fails.
    pub fn angle(&self, unstable: usize, stable: usize) -> Option<f64> {
        let m = self.vectors;
        // The first vectors span the first coordinates. The component of a unit vector outside these coordinates
        // is the sine of its angle to this space.
        let mut basis: Vec<Vec<f64>> = Vec::with_capacity(stable);
        for i in m - stable..m {
            let mut vector = self.vector(i).to_vec();
            vector.resize(m, 0.0);
            // Orthogonalise twice: one pass leaves large residues if the vectors are nearly parallel.
            for _ in 0..2 {
                for other in &basis {
                    let along: f64 = vector.iter().zip(other).map(|(a, b)| a * b).sum();
                    for (a, b) in vector.iter_mut().zip(other) {
                        *a -= along * b;
                    }
                }
            }
            let length = normalise(&mut vector);
            if length.is_nan() || length <= DEPENDENT {
                return None;
            }
            basis.push(vector);
        }
        let outside = Mat::from_fn(m - unstable, stable, |row, i| basis[i][unstable + row]);
        let square = match stable {
            1 => (0..m - unstable).map(|row| outside[(row, 0)].powi(2)).sum(),
            _ => {
                let gram = product(outside.transpose(), outside.as_ref());
                let (values, _) = symmetric_eigen(&gram)?;
                values.into_iter().fold(f64::INFINITY, f64::min)
            }
        };
        let angle = f64::clamp(square, 0.0, 1.0).sqrt().asin();
        angle.is_finite().then_some(angle)
    }
}

/// Scales a vector to unit length; returns its length before.
fn normalise(x: &mut [f64]) -> f64 {
    let length = x.iter().map(|x| x * x).sum::<f64>().sqrt();
    x.iter_mut().for_each(|x| *x /= length);
    length
}
