//! The periodic orbit next to a state, by Newton's method on the map of k mesh cycles.
//!
//! ```text
//! (M − I) Δ = x − P(x),      M = dP/dx, exact (windows and saltations)
//! ```
//!
//! in energy coordinates, neutral pair left out. The map of a drive with contact damping is
//! continuous with a derivative that jumps where the event sequence changes, so that steps
//! converge quadratically once the sequence is the orbit's own. An orbit that never leaves
//! contact, or never touches, is found in one step: the map is affine.

use super::floquet::monodromy;
use crate::analysis::norm::EnergyNorm;
use crate::model::{Model, TrajectoryState};
use crate::numerics::linalg::{eigenvalues, solve};
use crate::propagate::{Counters, Kernel, Stop};
use faer::Mat;
use num_complex::Complex64;

/// Most Newton steps; a good guess needs three to five.
const MOST_STEPS: usize = 8;

/// Residual, in half gaps, at which an orbit counts as found: round-off of a cycle is some
/// 1e-14, and one more step is made from there.
const CONVERGED: f64 = 1e-11;

/// Residual, in half gaps, at which an orbit counts as found where another step does not halve
/// it: round-off of nearly critically damped modes in tables.
const STAGNANT: f64 = 1e-9;

/// Longest step, in half gaps, from a state that is worth following.
const LONGEST_STEP: f64 = 30.0;

/// A periodic orbit.
#[derive(Debug, Clone)]
pub struct PeriodicOrbit {
    /// Its state at the start of a mesh cycle.
    pub start: TrajectoryState,
    /// Period in mesh cycles.
    pub period: u32,
    /// Distance between start and end of a period, in half gaps.
    pub residual: f64,
    /// Events in a period.
    pub events: u64,
    /// Monodromy matrix in energy coordinates.
    pub monodromy: Mat<f64>,
    /// Floquet multipliers, largest modulus first.
    pub multipliers: Vec<Complex64>,
}

impl PeriodicOrbit {
    /// Largest modulus of the multipliers: below 1 where the orbit attracts.
    pub fn spectral_radius(&self) -> f64 {
        self.multipliers
            .first()
            .map_or(0.0, |leading| leading.norm())
    }
}

/// Seeks an orbit of `period` mesh cycles next to `guess`. None where Newton's method does
/// not converge within a few steps.
///
/// # Errors
/// [`Stop`] where an iterate diverges or storms.
pub fn shoot<K: Kernel>(
    model: &Model,
    kernel: &K,
    norm: &EnergyNorm,
    guess: &TrajectoryState,
    period: u32,
    workspace: &mut K::Workspace,
) -> Result<Option<PeriodicOrbit>, Stop> {
    let mut counters = Counters::default();
    let (weights, felt) = (norm.weights(), norm.felt());
    let mut start = guess.clone();
    let mut last = f64::INFINITY;
    for _ in 0..MOST_STEPS {
        let mut end = start.clone();
        let before = counters.events;
        let matrix = monodromy(
            model,
            kernel,
            norm,
            &mut end,
            period,
            workspace,
            &mut counters,
        )?;
        let residual = norm.distance(&end.state, &start.state) / norm.unit();
        if residual.is_nan() || residual > 2.0 * last.max(1.0) {
            return Ok(None);
        }
        let stagnant = last <= STAGNANT && residual > 0.5 * last;
        if last <= CONVERGED || stagnant {
            return Ok(
                eigenvalues(matrix.as_ref()).map(|multipliers| PeriodicOrbit {
                    start,
                    period,
                    residual,
                    events: counters.events - before,
                    monodromy: matrix,
                    multipliers,
                }),
            );
        }
        last = residual;
        let defect = norm.difference(&start.state, &end.state);
        let n = felt.len();
        let system = Mat::from_fn(n, n, |i, j| matrix[(i, j)] - f64::from(u8::from(i == j)));
        let step = solve(system.as_ref(), &defect);
        let length = step.iter().map(|s| s * s).sum::<f64>().sqrt();
        if length.is_nan() || length > LONGEST_STEP * norm.unit() {
            return Ok(None);
        }
        for (&i, s) in felt.iter().zip(&step) {
            start.state[i] += s / weights[i];
        }
        start = TrajectoryState::new(model, start.state, start.cycle);
    }
    Ok(None)
}

/// Distance, in half gaps, at which two points of an orbit are one.
pub(super) const SAME_POINT: f64 = 1e-7;

/// The orbit with its own, shortest period: a multiple of `unit` cycles that divides the
/// period it was found with. The map of an orbit without events is affine, and has no other orbit.
///
/// # Errors
/// [`Stop`] as for any integration.
pub fn shortest<K: Kernel>(
    model: &Model,
    kernel: &K,
    norm: &EnergyNorm,
    orbit: PeriodicOrbit,
    unit: u32,
    workspace: &mut K::Workspace,
) -> Result<PeriodicOrbit, Stop> {
    if orbit.events == 0 && orbit.period > unit {
        let shorter = shoot(model, kernel, norm, &orbit.start, unit, workspace)?;
        return Ok(shorter.unwrap_or(orbit));
    }
    let mut counters = Counters::default();
    let mut state = orbit.start.clone();
    for cycle in 1..orbit.period {
        kernel.advance(1, &mut state, workspace, &mut (), &mut counters)?;
        let divides = cycle.is_multiple_of(unit) && orbit.period.is_multiple_of(cycle);
        let apart = norm.distance(&state.state, &orbit.start.state) / norm.unit();
        if divides && apart <= SAME_POINT {
            let shorter = shoot(model, kernel, norm, &orbit.start, cycle, workspace)?;
            return Ok(shorter.unwrap_or(orbit));
        }
    }
    Ok(orbit)
}
