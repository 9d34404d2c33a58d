//! Natural modes of a symmetric pair: `K φ = ω² M φ`, `φᵀ M φ = 1`.
//!
//! With `M = L Lᵀ` the dense symmetric eigenproblem of `L⁻¹ K L⁻ᵀ` gives every mode. But
//! each ω² has the error of the *largest*, which is many decades above the modes of
//! interest. The remedy is one block step of shifted inverse iteration with a Rayleigh–Ritz projection
//! (Parlett, *The Symmetric Eigenvalue Problem*, chapters 11 and 14) on the requested
//! modes only,
//!
//! ```text
//! (K + σ M) X = M Φ,   then   (XᵀMΦ) y = (ω² + σ)(XᵀMX) y,   φ ← X y
//! ```
//!
//! The step leaves the round-off of the largest *requested* ω² and that of the entries of K. The projected stiffness
//! needs no product with K, which would cancel again.

mod lanczos;
mod pencil;
mod statics;

use super::assembly::AssembledMatrices;
use super::banded::Banded;
use super::error::ShaftError;
use crate::numerics::linalg::{cholesky, product, solve_lower, solve_upper, symmetric_eigen};
use crate::structure::{ModeCount, ModeShapes};
use faer::{Mat, MatRef};
use pencil::Pencil;

/// Largest accepted relative residual of a mode. Round-off leaves 1e-16 to 1e-12 of the
/// sum of moduli; a failed solution leaves far more.
const RESIDUAL_BOUND: f64 = 1e-9;

/// Largest difference of two entries that symmetry makes equal, relative to the geometric mean
/// of the diagonal entries of their row and column: more than a different order of summation causes.
const ASYMMETRY_BOUND: f64 = 1e-10;

/// Smallest number of freedoms for which only the lowest modes are computed.
const LARGE: usize = 400;

/// The band must be this many times narrower than the matrix, and the modes this many times fewer than freedoms, for
/// a banded solution to be less work.
const NARROW: usize = 8;

/// The lowest modes of a structure.
#[derive(Debug, Clone)]
pub struct Modes {
    /// Squared frequencies ω² \[rad²/s²\], ascending; exactly 0 for rigid-body modes.
    pub squared_frequency: Vec<f64>,
    /// Mass-normalised shapes, freedoms × modes \[1/√kg\] for displacements.
    pub shape: Mat<f64>,
}

impl Modes {
    /// The `requested` lowest modes of the symmetric pair `(mass, stiffness)`, with
    /// exactly `rigid` rigid-body motions.
    ///
    /// # Errors
    /// [`ShaftError::Shape`], [`ShaftError::NonFinite`], [`ShaftError::Asymmetric`],
    /// [`ShaftError::ModeCount`],
    /// [`ShaftError::MassNotPositiveDefinite`], [`ShaftError::StiffnessIndefinite`],
    /// [`ShaftError::RigidModes`] if the number of eigenvalues that are zero within round-off is
    /// not `rigid`, [`ShaftError::NoConvergence`], [`ShaftError::Residual`].
    pub fn lowest(
        mass: &Mat<f64>,
        stiffness: &Mat<f64>,
        requested: usize,
        rigid: usize,
    ) -> Result<Self, ShaftError> {
        let size = check(mass, stiffness)?;
        if requested == 0 || requested > size {
            return Err(ModeCount {
                requested,
                least: 1,
                available: size,
            }
            .into());
        }
        // One mode beyond the rigid ones shows whether there are more of them than expected.
        let block = requested.max(rigid + 1).min(size);
        if size >= LARGE && NARROW * block <= size {
            let band = Banded::width(&[mass, stiffness]);
            if NARROW * band <= size
                && let Some(found) =
                    Self::of_band(mass, stiffness, band, [requested, block, rigid])?
            {
                return Ok(found);
            }
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
        // The shift makes K + σM definite: the first elastic ω², or more if round-off requires it.
        let shift = estimate[rigid.min(size - 1)].max(2.0 * dense_error);
        let pencil = Pencil::Dense(mass, stiffness);
        let refined = if shift > 0.0 {
            refine(pencil, &estimate[..block], shape.subcols(0, block), shift)?
        } else {
            // K = 0: every mode is rigid and there is nothing to refine.
            Self {
                squared_frequency: vec![0.0; block],
                shape: shape.subcols(0, block).to_owned(),
            }
        };
        refined.check_residual(pencil, shift)?;
        refined.finish(pencil, shift, requested, rigid)
    }

    /// As [`Self::lowest`], for banded matrices; `None` if a dense solution is needed.
    fn of_band(
        mass: &Mat<f64>,
        stiffness: &Mat<f64>,
        band: usize,
        [requested, block, rigid]: [usize; 3],
    ) -> Result<Option<Self>, ShaftError> {
        let [mass, stiffness] = [mass, stiffness].map(|matrix| Banded::of(matrix, band));
        let definite = mass.factor().is_some_and(|factor| factor.negative() == 0);
        if !definite {
            return Err(ShaftError::MassNotPositiveDefinite);
        }
        let Some(found) = lanczos::lowest(&mass, &stiffness, block, rigid) else {
            return Ok(None);
        };
        let shift = found.squared_frequency[rigid];
        if shift.is_nan() || shift <= 0.0 {
            return Ok(None);
        }
        let pencil = Pencil::Banded(&mass, &stiffness);
        let refined = refine(
            pencil,
            &found.squared_frequency,
            found.shape.as_ref(),
            shift,
        )?;
        refined.check_residual(pencil, shift)?;
        refined.finish(pencil, shift, requested, rigid).map(Some)
    }

    /// Natural frequencies ω \[rad/s\].
    pub fn frequencies(&self) -> Vec<f64> {
        self.squared_frequency.iter().map(|s| s.sqrt()).collect()
    }

    /// Shapes of the modes in all freedoms. `to_structure_modes` converts values per mode.
    pub fn in_freedoms(
        &self,
        matrices: &AssembledMatrices,
        to_structure_modes: impl Fn(&mut [f64]),
    ) -> ModeShapes {
        let row = |freedom: usize| {
            let mut row: Vec<f64> = self.shape.row(freedom).iter().copied().collect();
            to_structure_modes(&mut row);
            row
        };
        let freedoms = 0..self.shape.nrows();
        ModeShapes {
            inertia: freedoms.clone().map(|i| matrices.mass[(i, i)]).collect(),
            shapes: freedoms.map(row).collect(),
        }
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
        pencil: Pencil<'_>,
        shift: f64,
        requested: usize,
        rigid: usize,
    ) -> Result<Self, ShaftError> {
        let block = self.squared_frequency.len();
        let top = self.squared_frequency[block - 1].abs() + shift;
        let projection_error = 8.0 * block as f64 * f64::EPSILON * top;
        let found = (0..block)
            .take_while(|&mode| {
                let rounding = rounding_of_quotient(pencil, shift, &self.column(mode));
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

    /// Shape of a mode.
    fn column(&self, mode: usize) -> Vec<f64> {
        self.shape.col(mode).iter().copied().collect()
    }

    /// Checks the equation of every mode, row by row in units of the freedom's inertia. The reference is
    /// the sum of moduli in the shifted equation: without the shift a rigid motion that no spring couples
    /// would be compared with the round-off of zero. A mode may hardly move light and stiff parts. The
    /// residual may therefore also have the size of the round-off of a motion of the stiffest parts.
    fn check_residual(&self, pencil: Pencil<'_>, shift: f64) -> Result<(), ShaftError> {
        let size = pencil.size();
        let unit: Vec<f64> = (0..size)
            .map(|row| pencil.inertia(row).sqrt().recip())
            .collect();
        let stiffest = pencil.terms(&unit).stiffness_term_moduli;
        let stiffest: f64 = (0..size)
            .map(|row| stiffest[row].powi(2) / pencil.inertia(row))
            .sum();
        let round_off = 2.0 * f64::EPSILON * stiffest.sqrt();
        for (mode, &squared) in self.squared_frequency.iter().enumerate() {
            let terms = pencil.terms(&self.column(mode));
            let (mut residual, mut scale) = (0.0, 0.0);
            for row in 0..size {
                let sum = terms.stiffness_product[row] - squared * terms.mass_product[row];
                let moduli = terms.stiffness_term_moduli[row]
                    + (squared.abs() + shift) * terms.mass_term_moduli[row];
                residual += sum * sum / pencil.inertia(row);
                scale += moduli * moduli / pencil.inertia(row);
            }
            let relative = (residual / scale).sqrt();
            // The scale is zero only if K = 0: every mode is exact. A NaN must fail.
            let holds =
                scale == 0.0 || residual.sqrt() <= RESIDUAL_BOUND * scale.sqrt() + round_off;
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
    pencil: Pencil<'_>,
    estimate: &[f64],
    shape: MatRef<'_, f64>,
    shift: f64,
) -> Result<Modes, ShaftError> {
    let size = pencil.size();
    let solver = pencil
        .shifted(shift)
        .ok_or(ShaftError::StiffnessIndefinite {
            eigenvalue: estimate[0],
        })?;
    // Columns scaled by ω² + σ: the solution is then close to the shapes, and the
    // Gram matrix below close to the identity.
    let inertia = pencil.mass_product(shape);
    let load = Mat::from_fn(size, estimate.len(), |i, j| {
        inertia[(i, j)] * (estimate[j] + shift)
    });
    let mut solution = load.clone();
    solver.solve(&mut solution);

    let moved = pencil.mass_product(solution.as_ref());
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

/// Round-off of the Rayleigh quotient of one mode, from the moduli of its terms:
/// `16 eps · |φ|ᵀ (|K| + σ|M|) |φ|`.
fn rounding_of_quotient(pencil: Pencil<'_>, shift: f64, shape: &[f64]) -> f64 {
    let terms = pencil.terms(shape);
    let moduli = terms
        .stiffness_term_moduli
        .iter()
        .zip(&terms.mass_term_moduli);
    let sum: f64 = (moduli.zip(shape))
        .map(|((elastic, inertial), value)| (elastic + shift * inertial) * value.abs())
        .sum();
    16.0 * f64::EPSILON * sum
}

/// Sign of every mode after the first `rigid` ones, from its mesh participation.
pub(super) fn orientation(mesh: &[f64], rigid: usize, solution: &Modes) -> Vec<f64> {
    let mesh = &mesh[rigid..];
    let largest = mesh.iter().fold(0.0_f64, |m, w| m.max(w.abs()));
    (mesh.iter().enumerate())
        .map(|(index, &w)| {
            // Below this a participation is round-off of a zero.
            if w.abs() > 1e-8 * largest {
                return w.signum();
            }
            let shape = solution.shape.col(rigid + index);
            let peak = shape.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            // The first of the largest entries, which are equal within round-off.
            shape
                .iter()
                .find(|v| v.abs() > (1.0 - 1e-6) * peak)
                .map_or(1.0, |v| v.signum())
        })
        .collect()
}

#[cfg(test)]
mod tests;

#[cfg(test)]
mod rounding_tests;
