//! The leading multiplier of a periodic orbit from full trajectories.
//!
//! Twins start at a small distance on both sides of the orbit along the leading eigenvector u of its monodromy
//! matrix: one pair along the real part, one along the imaginary part. They are integrated over one period and use no
//! tangents or saltations. With `D u = (P(x + εu) − P(x − εu)) / 2ε`
//!
//! ```text
//! μ = uᴴ (D u) / uᴴ u,       D u = μ u  if the monodromy matrix is right
//! ```
//!
//! If the orbit contracts, twins that come too near in a cycle are rescaled along their difference; the factors
//! multiply.

use crate::analysis::norm::EnergyNorm;
use crate::analysis::twin::ROUND_OFF as ROUND_OFF_OF_A_CYCLE;
use crate::model::{Model, TrajectoryState};
use crate::propagate::{Counters, Kernel, Stop};
use num_complex::{Complex64, c64};

/// Distance of a twin from the orbit, in half gaps. A smaller distance would increase the effect of
/// round-off, a larger one the effect of the map's curvature.
const DISTANCE: f64 = 1e-6;

/// Tolerance on the eigenvector's image, relative to the distance. It covers the round-off of a period, which
/// is a few 1e-14 half gaps. It adds to the error of the twins.
const ROUND_OFF: f64 = 1e-6;

/// Fraction of the initial distance below which twins are rescaled.
const RESCALING_DISTANCE: f64 = 1e-2;

/// Largest round-off of a cycle, relative to the distance between twin and orbit after the cycle.
const MOST_ROUND_OFF: f64 = 1e-2;

/// The leading exponent from twins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TwinExponent {
    /// `ln|μ| / k` \[1/cycle\].
    pub exponent: f64,
    /// Change of the exponent if one-sided differences are used.
    pub error: f64,
    /// Whether the eigenvector's image by the twins is μ times the eigenvector.
    pub agrees: bool,
}

/// The leading exponent of the orbit of `period` mesh cycles through `start`. `direction` is the leading eigenvector
/// of its monodromy matrix, of unit norm in energy coordinates, as real and imaginary part. `None` if the orbit
/// contracts so strongly that only round-off remains after a cycle.
///
/// # Errors
/// [`Stop`] as for any integration.
pub fn leading_exponent<K: Kernel>(
    model: &Model,
    kernel: &K,
    norm: &EnergyNorm,
    start: &TrajectoryState,
    period: u32,
    direction: &[Vec<f64>; 2],
    workspace: &mut K::Workspace,
) -> Result<Option<TwinExponent>, Stop> {
    let mut twins = Twins::new(model, norm, start, direction.clone());
    // Growth, as a natural logarithm, before the twins were last rescaled, and its change with one-sided differences.
    let (mut logarithm, mut error) = (0.0, 0.0);
    // Round-off of all cycles, relative to the distance.
    let mut round_off = 0.0;
    for cycle in 1..=period {
        twins.advance_cycle(kernel, workspace)?;
        let [central, forward] = twins.images();
        let [size, one_sided] = [&central, &forward].map(length);
        let states = norm.length(&twins.orbit.state) / norm.unit();
        let blurred = ROUND_OFF_OF_A_CYCLE * states / DISTANCE;
        round_off += blurred;
        if size.is_nan() || size * MOST_ROUND_OFF < blurred {
            return Ok(None);
        }
        if cycle < period && size < RESCALING_DISTANCE {
            logarithm += size.ln();
            error += (one_sided / size).ln().abs();
            let apart = central.map(|part| part.iter().map(|x| x / size).collect());
            twins = Twins::new(model, norm, &twins.orbit, apart);
        }
    }
    let [central, forward] = twins.images();
    let multiplier = quotient(direction, &central);
    let exponent = |multiplier: Complex64| (multiplier.norm().ln() + logarithm) / f64::from(period);
    let error = (exponent(quotient(direction, &forward)) - exponent(multiplier)).abs()
        + error / f64::from(period);
    let missed: f64 = (0..central[0].len())
        .map(|i| {
            let linear = multiplier * c64(direction[0][i], direction[1][i]);
            (c64(central[0][i], central[1][i]) - linear).norm().powi(2)
        })
        .sum::<f64>()
        .sqrt();
    Ok(Some(TwinExponent {
        exponent: exponent(multiplier),
        error,
        agrees: missed <= ROUND_OFF + round_off + 3.0 * error,
    }))
}

/// Trajectories on both sides of an orbit, along the real and the imaginary part of a direction.
struct Twins<'a> {
    norm: &'a EnergyNorm,
    orbit: TrajectoryState,
    /// Twins on both sides, displaced along the real and along the imaginary part; `None` for a part that is zero.
    sides: [Option<[TrajectoryState; 2]>; 2],
}

impl<'a> Twins<'a> {
    fn new(
        model: &Model,
        norm: &'a EnergyNorm,
        orbit: &TrajectoryState,
        direction: [Vec<f64>; 2],
    ) -> Self {
        let distance = DISTANCE * norm.unit();
        let sides = direction.map(|along| {
            along.iter().any(|u| *u != 0.0).then(|| {
                [1.0, -1.0].map(|side| {
                    let mut state = orbit.state.clone();
                    norm.displace(&mut state, side * distance, &along);
                    TrajectoryState::new(model, state, orbit.cycle)
                })
            })
        });
        Self {
            norm,
            orbit: TrajectoryState::new(model, orbit.state.clone(), orbit.cycle),
            sides,
        }
    }

    /// Advances the orbit and all twins by a cycle.
    fn advance_cycle<K: Kernel>(
        &mut self,
        kernel: &K,
        workspace: &mut K::Workspace,
    ) -> Result<(), Stop> {
        let twins = self.sides.iter_mut().flatten().flatten();
        for state in twins.chain([&mut self.orbit]) {
            kernel.advance(1, state, workspace, &mut (), &mut Counters::default())?;
        }
        Ok(())
    }

    /// Images of both parts in energy coordinates, by central and by one-sided differences.
    fn images(&self) -> [[Vec<f64>; 2]; 2] {
        let distance = DISTANCE * self.norm.unit();
        let apart = |one: &TrajectoryState, other: &TrajectoryState, by: f64| -> Vec<f64> {
            let apart = self.norm.difference(&one.state, &other.state);
            apart.into_iter().map(|part| part / by).collect()
        };
        let image = |from: &dyn Fn(&[TrajectoryState; 2]) -> Vec<f64>| {
            (self.sides.each_ref()).map(|sides| {
                (sides.as_ref()).map_or_else(|| vec![0.0; self.norm.dimension()], from)
            })
        };
        [
            image(&|[ahead, behind]| apart(ahead, behind, 2.0 * distance)),
            image(&|[ahead, _]| apart(ahead, &self.orbit, distance)),
        ]
    }
}

/// Norm of a complex vector given as parts.
fn length(parts: &[Vec<f64>; 2]) -> f64 {
    parts.iter().flatten().map(|x| x * x).sum::<f64>().sqrt()
}

/// `uᴴ v` of complex vectors given as parts; u has unit norm.
fn quotient(u: &[Vec<f64>; 2], v: &[Vec<f64>; 2]) -> Complex64 {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    c64(
        dot(&u[0], &v[0]) + dot(&u[1], &v[1]),
        dot(&u[0], &v[1]) - dot(&u[1], &v[0]),
    )
}
