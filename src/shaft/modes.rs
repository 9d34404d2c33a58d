//! Natural modes of a symmetric pair: `K φ = ω² M φ`, `φᵀ M φ = 1`.
//!
//! With `M = L Lᵀ` the dense symmetric eigenproblem of `L⁻¹ K L⁻ᵀ` gives every mode, but
//! each ω² with the error of the *largest*, which is many decades above the modes of
//! interest. One block step of shifted inverse iteration with a Rayleigh–Ritz projection
//! (Parlett, *The Symmetric Eigenvalue Problem*, chapters 11 and 14) on the requested
//! modes alone,
//!
//! ```text
//! (K + σ M) X = M Φ,   then   (XᵀMΦ) y = (ω² + σ)(XᵀMX) y,   φ ← X y
//! ```
//!
//! leaves the round-off of the largest *requested* ω² and that of the entries of K; the
//! projected stiffness needs no product with K, whose cancellation would hurt again.

use super::error::ShaftError;
use crate::numerics::linalg::{cholesky, product, solve_lower, solve_upper, symmetric_eigen};
use faer::{Mat, MatRef};

/// Largest accepted relative residual of a mode. Round-off leaves 1e-16 to 1e-12 of the
/// moduli summed; a failed solution leaves far more.
const RESIDUAL_BOUND: f64 = 1e-9;

/// Largest difference of two entries that symmetry makes equal, relative to the geometric mean
/// of the diagonal entries of their row and column: beyond what sums in another order leave.
const ASYMMETRY_BOUND: f64 = 1e-10;

/// The lowest modes of a structure.
#[derive(Debug, Clone)]
pub struct Modes {
    /// Squared frequencies ω² \[rad²/s²\], ascending; exactly 0 for rigid-body modes.
    pub squared_frequency: Vec<f64>,
    /// Mass-normalised shapes, freedoms × modes \[1/√kg\] for displacements.
    pub shape: Mat<f64>,
}

impl Modes {
    /// The `requested` lowest modes of the symmetric pair `(mass, stiffness)`, of which
    /// exactly `rigid` are rigid-body motions.
    ///
    /// # Errors
    /// [`ShaftError::Shape`], [`ShaftError::NonFinite`], [`ShaftError::Asymmetric`],
    /// [`ShaftError::ModeCount`],
    /// [`ShaftError::MassNotPositiveDefinite`], [`ShaftError::StiffnessIndefinite`],
    /// [`ShaftError::RigidModes`] when the eigenvalues that are zero within round-off are
    /// not `rigid` in number, [`ShaftError::NoConvergence`], [`ShaftError::Residual`].
    pub fn lowest(
        mass: &Mat<f64>,
        stiffness: &Mat<f64>,
        requested: usize,
        rigid: usize,
    ) -> Result<Self, ShaftError> {
        let size = check(mass, stiffness)?;
        if requested == 0 || requested > size {
            return Err(ShaftError::ModeCount {
                requested,
                least: 1,
                available: size,
            });
        }
        let lower = cholesky(mass).ok_or(ShaftError::MassNotPositiveDefinite)?;
        let (estimate, shape) = dense(&lower, stiffness)?;
        let largest = estimate[size - 1].max(0.0);
        // Backward error of the dense solution, with room for the constant in O(n eps).
        let dense_error = 8.0 * size as f64 * f64::EPSILON * largest;
        if estimate[0] < -dense_error {
            return Err(ShaftError::StiffnessIndefinite {
                eigenvalue: estimate[0],
            });
        }
        // One mode beyond the rigid ones shows whether there are more of them than expected.
        let block = requested.max(rigid + 1).min(size);
        // The shift makes K + σM definite and is no larger than the first elastic ω² needs.
        let shift = estimate[rigid.min(size - 1)].max(2.0 * dense_error);
        let refined = if shift > 0.0 {
            refine(
                mass,
                stiffness,
                &estimate[..block],
                shape.subcols(0, block),
                shift,
            )?
        } else {
            // K = 0: every mode is rigid and there is nothing to refine.
            Self {
                squared_frequency: vec![0.0; block],
                shape: shape.subcols(0, block).to_owned(),
            }
        };
        refined.check_residual(mass, stiffness, shift)?;
        refined.finish(mass, stiffness, shift, requested, rigid)
    }

    /// Natural frequencies ω \[rad/s\].
    pub fn frequencies(&self) -> Vec<f64> {
        self.squared_frequency.iter().map(|s| s.sqrt()).collect()
    }

    /// Value of a linear functional of the freedoms in every mode.
    pub fn participation(&self, functional: &[f64]) -> Vec<f64> {
        (0..self.shape.ncols())
            .map(|mode| {
                (functional.iter().enumerate())
                    .map(|(row, c)| c * self.shape[(row, mode)])
                    .sum()
            })
            .collect()
    }

    /// Sets the rigid ω² to zero, checks their number, keeps the requested modes.
    fn finish(
        mut self,
        mass: &Mat<f64>,
        stiffness: &Mat<f64>,
        shift: f64,
        requested: usize,
        rigid: usize,
    ) -> Result<Self, ShaftError> {
        let block = self.squared_frequency.len();
        let top = self.squared_frequency[block - 1].abs() + shift;
        let projection_error = 8.0 * block as f64 * f64::EPSILON * top;
        let found = (0..block)
            .take_while(|&mode| {
                let rounding =
                    rounding_of_quotient(mass, stiffness, shift, self.shape.as_ref(), mode);
                self.squared_frequency[mode] <= rounding + projection_error
            })
            .count();
        if found != rigid {
            return Err(ShaftError::RigidModes {
                expected: rigid,
                found,
            });
        }
        self.squared_frequency[..rigid].fill(0.0);
        self.squared_frequency.truncate(requested);
        self.shape = self.shape.subcols(0, requested).to_owned();
        Ok(self)
    }

    /// Holds every mode to its equation, row by row in units of the freedom's own inertia,
    /// against the moduli of what the shifted equation sums: without the shift a rigid motion
    /// that no spring couples to anything would be held to the round-off of its own zero.
    fn check_residual(
        &self,
        mass: &Mat<f64>,
        stiffness: &Mat<f64>,
        shift: f64,
    ) -> Result<(), ShaftError> {
        let size = mass.nrows();
        for (mode, &squared) in self.squared_frequency.iter().enumerate() {
            let (mut residual, mut scale) = (0.0, 0.0);
            for row in 0..size {
                let (mut sum, mut moduli) = (0.0, 0.0);
                for column in 0..size {
                    let value = self.shape[(column, mode)];
                    let (elastic, inertial) = (
                        stiffness[(row, column)] * value,
                        squared * mass[(row, column)] * value,
                    );
                    sum += elastic - inertial;
                    let shifted = shift * mass[(row, column)] * value;
                    moduli += elastic.abs() + inertial.abs() + shifted.abs();
                }
                residual += sum * sum / mass[(row, row)];
                scale += moduli * moduli / mass[(row, row)];
            }
            let relative = (residual / scale).sqrt();
            // A mode without stiffness sums nothing and is exact; a NaN must fail.
            let holds = scale == 0.0 || relative <= RESIDUAL_BOUND;
            if !holds {
                return Err(ShaftError::Residual {
                    mode: mode + 1,
                    size,
                    residual: relative,
                });
            }
        }
        Ok(())
    }
}

/// Sizes, finiteness and symmetry; returns the number of freedoms.
fn check(mass: &Mat<f64>, stiffness: &Mat<f64>) -> Result<usize, ShaftError> {
    let size = mass.nrows();
    if [mass.ncols(), stiffness.nrows(), stiffness.ncols()] != [size; 3] {
        return Err(ShaftError::Shape {
            mass_rows: size,
            mass_columns: mass.ncols(),
            stiffness_rows: stiffness.nrows(),
            stiffness_columns: stiffness.ncols(),
        });
    }
    for (name, matrix) in [("mass", mass), ("stiffness", stiffness)] {
        for column in 0..size {
            for row in 0..size {
                if !matrix[(row, column)].is_finite() {
                    return Err(ShaftError::NonFinite {
                        matrix: name,
                        row,
                        column,
                    });
                }
            }
        }
        for column in 0..size {
            for row in column + 1..size {
                let (below, above) = (matrix[(row, column)], matrix[(column, row)]);
                let scale = (matrix[(row, row)].abs() * matrix[(column, column)].abs()).sqrt();
                if (below - above).abs() > ASYMMETRY_BOUND * scale {
                    return Err(ShaftError::Asymmetric {
                        matrix: name,
                        row,
                        column,
                        entries: [below, above],
                    });
                }
            }
        }
    }
    Ok(size)
}

/// All eigenvalues, ascending, and M-orthonormal vectors, accurate to round-off of the
/// largest eigenvalue.
fn dense(lower: &Mat<f64>, stiffness: &Mat<f64>) -> Result<(Vec<f64>, Mat<f64>), ShaftError> {
    let mut half = stiffness.clone();
    solve_lower(lower, &mut half);
    let mut whole = half.transpose().to_owned();
    solve_lower(lower, &mut whole);
    let (values, mut vectors) = eigen(&whole)?;
    solve_upper(lower, &mut vectors);
    Ok((values, vectors))
}

/// One block step of inverse iteration with Rayleigh–Ritz projection; see the module.
fn refine(
    mass: &Mat<f64>,
    stiffness: &Mat<f64>,
    estimate: &[f64],
    shape: MatRef<'_, f64>,
    shift: f64,
) -> Result<Modes, ShaftError> {
    let size = mass.nrows();
    let shifted = Mat::from_fn(size, size, |i, j| stiffness[(i, j)] + shift * mass[(i, j)]);
    let lower = cholesky(&shifted).ok_or(ShaftError::StiffnessIndefinite {
        eigenvalue: estimate[0],
    })?;
    // Columns scaled by ω² + σ: the solution is then close to the shapes themselves, and the
    // Gram matrix below close to the identity.
    let inertia = product(mass.as_ref(), shape);
    let load = Mat::from_fn(size, estimate.len(), |i, j| {
        inertia[(i, j)] * (estimate[j] + shift)
    });
    let mut solution = load.clone();
    solve_lower(&lower, &mut solution);
    solve_upper(&lower, &mut solution);

    let moved = product(mass.as_ref(), solution.as_ref());
    let gram = product(solution.transpose(), moved.as_ref());
    let projected = product(solution.transpose(), load.as_ref());
    let projected = Mat::from_fn(estimate.len(), estimate.len(), |i, j| {
        0.5 * (projected[(i, j)] + projected[(j, i)])
    });
    let gram_factor = cholesky(&gram).ok_or(ShaftError::NoConvergence { size })?;
    let (values, vectors) = dense(&gram_factor, &projected)?;
    Ok(Modes {
        squared_frequency: values.iter().map(|value| value - shift).collect(),
        shape: product(solution.as_ref(), vectors.as_ref()),
    })
}

/// Eigenvalues, ascending, and orthonormal vectors of a symmetric matrix (lower half read).
fn eigen(matrix: &Mat<f64>) -> Result<(Vec<f64>, Mat<f64>), ShaftError> {
    symmetric_eigen(matrix).ok_or(ShaftError::NoConvergence {
        size: matrix.nrows(),
    })
}

/// Round-off of the Rayleigh quotient of one mode, from the moduli of what it sums:
/// `16 eps · |φ|ᵀ (|K| + σ|M|) |φ|`.
fn rounding_of_quotient(
    mass: &Mat<f64>,
    stiffness: &Mat<f64>,
    shift: f64,
    shape: MatRef<'_, f64>,
    mode: usize,
) -> f64 {
    let size = mass.nrows();
    let mut sum = 0.0;
    for j in 0..size {
        for i in 0..size {
            let weight = stiffness[(i, j)].abs() + shift * mass[(i, j)].abs();
            sum += shape[(i, mode)].abs() * weight * shape[(j, mode)].abs();
        }
    }
    16.0 * f64::EPSILON * sum
}

#[cfg(test)]
mod tests;
