//! The periodic orbit next to a sequence of states, each an iteration of the map after the one
//! before, by Newton's method on all of them at once (multiple shooting).
//!
//! ```text
//! Δ_{i+1} = M_i Δ_i + r_i,     r_i = P(x_i) − x_{i+1},     Δ_n = Δ_0
//! ```
//!
//! The tangents that give the product of the M_i carry on through all iterations, and one more
//! carries the r_i, so that it costs no more than shooting from the first state. States that a
//! trajectory has passed have the event sequences of an orbit nearby already, and round-off and
//! curvature grow over one iteration, not over the period.

use crate::analysis::norm::EnergyNorm;
use crate::model::{Model, TrajectoryState};
use crate::numerics::linalg::{eigenvalues, solve};
use crate::propagate::{Counters, Kernel, Stop, Tangents};
use faer::Mat;
use num_complex::Complex64;

/// Most Newton steps; a good guess needs three to five.
const MOST_STEPS: usize = 10;

/// Largest miss of an iteration, in half gaps, at which an orbit counts as found.
const CONVERGED: f64 = 1e-11;

/// Longest step, in half gaps, from a state that is worth following.
const LONGEST_STEP: f64 = 30.0;

/// A sequence of states that closes on itself.
#[derive(Debug, Clone)]
pub struct Closed {
    /// The states, an iteration apart.
    pub points: Vec<TrajectoryState>,
    /// Floquet multipliers of the period.
    pub multipliers: Vec<Complex64>,
}

/// Seeks the orbit next to `points`, each `unit` mesh cycles after the one before and the last as
/// long before the first. None where Newton's method does not converge within a few steps.
///
/// # Errors
/// [`Stop`] where an iterate diverges or storms.
pub fn close<K: Kernel>(
    model: &Model,
    kernel: &K,
    norm: &EnergyNorm,
    mut points: Vec<TrajectoryState>,
    unit: u32,
    workspace: &mut K::Workspace,
    counters: &mut Counters,
) -> Result<Option<Closed>, Stop> {
    let mut last = f64::INFINITY;
    for _ in 0..MOST_STEPS {
        let turn = Turn::of(model, kernel, norm, &points, unit, workspace, counters)?;
        if turn.residual.is_nan() || turn.residual > 2.0 * last.max(1.0) {
            return Ok(None);
        }
        let Some((whole, _)) = turn.after.last() else {
            return Ok(None);
        };
        if turn.residual <= CONVERGED {
            return Ok(eigenvalues(whole.as_ref()).map(|multipliers| Closed {
                points,
                multipliers,
            }));
        }
        last = turn.residual;
        if !turn.step(model, norm, &mut points) {
            return Ok(None);
        }
    }
    Ok(None)
}

/// One turn along a sequence of states.
struct Turn {
    /// Largest distance of an image from the next state, in half gaps.
    residual: f64,
    /// After each iteration the product of the maps' derivatives so far and what the misses have
    /// grown to, in energy coordinates.
    after: Vec<(Mat<f64>, Vec<f64>)>,
}

impl Turn {
    fn of<K: Kernel>(
        model: &Model,
        kernel: &K,
        norm: &EnergyNorm,
        points: &[TrajectoryState],
        unit: u32,
        workspace: &mut K::Workspace,
        counters: &mut Counters,
    ) -> Result<Self, Stop> {
        let (weights, felt) = (norm.weights(), norm.felt());
        let missed = felt.len();
        let mut tangents = Tangents::zeros(model.modes(), missed + 1);
        for (column, &i) in felt.iter().enumerate() {
            tangents.vector_mut(column)[i] = 1.0;
        }
        let mut turn = Self {
            residual: 0.0,
            after: Vec::with_capacity(points.len()),
        };
        for (place, point) in points.iter().enumerate() {
            let next = &points[(place + 1) % points.len()];
            let mut end = point.clone();
            for _ in 0..unit {
                kernel.advance_cycle(&mut end, &mut tangents, workspace, &mut (), counters)?;
            }
            let distance = norm.distance(&end.state, &next.state) / norm.unit();
            // Written so that a state that is no number is not close.
            turn.residual = match distance <= turn.residual {
                true => turn.residual,
                false => distance,
            };
            let sum = tangents.vector_mut(missed);
            for ((sum, a), b) in sum.iter_mut().zip(&end.state).zip(&next.state) {
                *sum += a - b;
            }
            for column in 0..=missed {
                norm.project(tangents.vector_mut(column));
            }
            let product = Mat::from_fn(missed, missed, |row, column| {
                let (i, j) = (felt[row], felt[column]);
                weights[i] * tangents.vector(column)[i] / weights[j]
            });
            let grown = tangents.vector(missed);
            turn.after.push((
                product,
                felt.iter().map(|&i| weights[i] * grown[i]).collect(),
            ));
        }
        Ok(turn)
    }

    /// A Newton step of all states; false where it leads too far.
    fn step(&self, model: &Model, norm: &EnergyNorm, points: &mut [TrajectoryState]) -> bool {
        let (weights, felt) = (norm.weights(), norm.felt());
        let Some((whole, grown)) = self.after.last() else {
            return false;
        };
        let n = felt.len();
        let system = Mat::from_fn(n, n, |i, j| f64::from(u8::from(i == j)) - whole[(i, j)]);
        let first = solve(system.as_ref(), grown);
        let count = points.len();
        let mut longest: f64 = 0.0;
        for (place, (product, grown)) in self.after.iter().enumerate() {
            let point = &mut points[(place + 1) % count];
            let mut length = 0.0;
            for (row, &i) in felt.iter().enumerate() {
                let along: f64 = (first.iter().enumerate())
                    .map(|(column, d)| product[(row, column)] * d)
                    .sum();
                let by = along + grown[row];
                length += by * by;
                point.state[i] += by / weights[i];
            }
            let state = std::mem::take(&mut point.state);
            *point = TrajectoryState::new(model, state, point.cycle);
            longest = match length.sqrt() <= longest {
                true => longest,
                false => length.sqrt(),
            };
        }
        longest <= LONGEST_STEP * norm.unit()
    }
}
