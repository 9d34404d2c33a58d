//! The leading multiplier of a periodic orbit from full trajectories.
//!
//! Twins start a small distance to both sides of the orbit along the leading eigenvector u of
//! its monodromy matrix (real and imaginary part in turn) and are marched over one period.
//! They know nothing of tangents and saltations. With `D u = (P(x + εu) − P(x − εu)) / 2ε`
//!
//! ```text
//! μ = uᴴ (D u) / uᴴ u,       D u = μ u  where the monodromy matrix is right
//! ```

use crate::analysis::norm::EnergyNorm;
use crate::model::{Model, TrajectoryState};
use crate::propagate::{Counters, Kernel, Stop, Tangents};

/// Distance of a twin from the orbit, in half gaps: between round-off of a period over it
/// and the curvature of the map.
const DISTANCE: f64 = 1e-6;

/// Part of the distance by which twins may miss the eigenvector's image whatever their own
/// error: round-off of a period, a few 1e-14 half gaps, over the distance.
const ROUND_OFF: f64 = 1e-6;

/// The leading exponent as twins have it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TwinExponent {
    /// `ln|μ| / k` \[1/cycle\].
    pub exponent: f64,
    /// What one-sided differences change of it.
    pub error: f64,
    /// Whether the twins' image of the eigenvector is μ times itself.
    pub agrees: bool,
}

/// The leading exponent of the orbit of `period` mesh cycles through `start`, along the leading
/// eigenvector of its monodromy matrix, `direction`, of unit norm in energy coordinates as real
/// and imaginary part.
///
/// # Errors
/// [`Stop`] as for any march.
pub fn leading_exponent<K: Kernel>(
    model: &Model,
    kernel: &K,
    norm: &EnergyNorm,
    start: &TrajectoryState,
    period: u32,
    direction: &[Vec<f64>; 2],
    workspace: &mut K::Workspace,
) -> Result<TwinExponent, Stop> {
    let (weights, felt) = (norm.weights(), norm.felt());
    let distance = DISTANCE * norm.unit();
    let mut image = |along: &[f64], side: f64| -> Result<Vec<f64>, Stop> {
        let mut state = start.state.clone();
        for (&i, u) in felt.iter().zip(along) {
            state[i] += side * distance * u / weights[i];
        }
        let mut twin = TrajectoryState::new(model, state, start.cycle);
        for _ in 0..period {
            kernel.march(
                &mut twin,
                &mut Tangents::none(),
                workspace,
                &mut (),
                &mut Counters::default(),
            )?;
        }
        Ok(felt.iter().map(|&i| weights[i] * twin.state[i]).collect())
    };
    let end = image(&direction[0], 0.0)?;
    // Images of both parts, from both sides and from one.
    let mut central = [vec![0.0; felt.len()], vec![0.0; felt.len()]];
    let mut forward = central.clone();
    for (part, along) in direction.iter().enumerate() {
        if along.iter().all(|u| *u == 0.0) {
            continue;
        }
        let (ahead, behind) = (image(along, 1.0)?, image(along, -1.0)?);
        for i in 0..felt.len() {
            central[part][i] = (ahead[i] - behind[i]) / (2.0 * distance);
            forward[part][i] = (ahead[i] - end[i]) / distance;
        }
    }
    let multiplier = quotient(direction, &central);
    let exponent = |(re, im): (f64, f64)| re.hypot(im).ln() / f64::from(period);
    let error = (exponent(quotient(direction, &forward)) - exponent(multiplier)).abs();
    let (re, im) = multiplier;
    let missed: f64 = (0..felt.len())
        .map(|i| {
            let x = re * direction[0][i] - im * direction[1][i];
            let y = re * direction[1][i] + im * direction[0][i];
            (central[0][i] - x).hypot(central[1][i] - y).powi(2)
        })
        .sum::<f64>()
        .sqrt();
    Ok(TwinExponent {
        exponent: exponent(multiplier),
        error,
        agrees: missed <= ROUND_OFF + 3.0 * error,
    })
}

/// `uᴴ v` of complex vectors given as parts; u has unit norm.
fn quotient(u: &[Vec<f64>; 2], v: &[Vec<f64>; 2]) -> (f64, f64) {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    (
        dot(&u[0], &v[0]) + dot(&u[1], &v[1]),
        dot(&u[0], &v[1]) - dot(&u[1], &v[0]),
    )
}
