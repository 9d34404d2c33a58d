//! Multipliers of a periodic orbit.
//!
//! The monodromy matrix of k mesh cycles is the product of the exact tangent maps of windows and the saltation
//! matrices at events. Its columns are tangents that start along the coordinate axes. The neutral pair is omitted: it
//! does not affect the other components, so these form an exact block of the matrix. The matrix is scaled to energy
//! coordinates before its eigenvalues are computed.

use crate::analysis::norm::EnergyNorm;
use crate::model::{Model, TrajectoryState};
use crate::numerics::linalg::eigenvalues;
use crate::propagate::{Counters, Kernel, Stop, Tangents};
use faer::Mat;
use num_complex::Complex64;

/// Monodromy matrix of `period` mesh cycles from `start`, which is advanced by them. It is the derivative of the end
/// with respect to the start in energy coordinates `y = weight x`. Its components are those of
/// [`EnergyNorm::weighted_components`], in this order.
///
/// # Errors
/// [`Stop`] as for any integration.
pub fn monodromy<K: Kernel>(
    model: &Model,
    kernel: &K,
    norm: &EnergyNorm,
    start: &mut TrajectoryState,
    period: u32,
    workspace: &mut K::Workspace,
    counters: &mut Counters,
) -> Result<Mat<f64>, Stop> {
    let weights = norm.weights();
    let weighted = norm.weighted_components();
    let mut tangents = Tangents::zeros(model.modes(), weighted.len());
    for (column, &i) in weighted.iter().enumerate() {
        tangents.vector_mut(column)[i] = 1.0;
    }
    for _ in 0..period {
        kernel.advance_cycle(start, &mut tangents, workspace, &mut (), counters)?;
    }
    for column in 0..weighted.len() {
        norm.project(tangents.vector_mut(column));
    }
    Ok(Mat::from_fn(
        weighted.len(),
        weighted.len(),
        |row, column| {
            let (i, j) = (weighted[row], weighted[column]);
            weights[i] * tangents.vector(column)[i] / weights[j]
        },
    ))
}

/// Floquet multipliers of the orbit through `start` with a period of `period` mesh cycles, largest modulus first.
/// `start` is advanced by one period. `None` if the eigenvalue iteration fails.
///
/// # Errors
/// [`Stop`] as for any integration.
pub fn multipliers<K: Kernel>(
    model: &Model,
    kernel: &K,
    norm: &EnergyNorm,
    start: &mut TrajectoryState,
    period: u32,
    workspace: &mut K::Workspace,
    counters: &mut Counters,
) -> Result<Option<Vec<Complex64>>, Stop> {
    let matrix = monodromy(model, kernel, norm, start, period, workspace, counters)?;
    Ok(eigenvalues(matrix.as_ref()))
}

/// Exponents per mesh cycle `ln|μ| / k` of multipliers over k cycles.
pub fn exponents(multipliers: &[Complex64], period: u32) -> Vec<f64> {
    let exponent = |multiplier: &Complex64| multiplier.norm().ln() / f64::from(period);
    multipliers.iter().map(exponent).collect()
}
