//! Which directions grow by themselves, and how near do those that grow and those that shrink come?
//!
//! Covariant Lyapunov vectors of a motion that does not repeat, by Ginelli's algorithm: tangents are
//! taken forward and orthonormalised once a mesh cycle, what orthonormalising took is kept, and
//! coefficients are taken back through it ([`ginelli`]). Each vector grows by its own exponent, its local
//! exponents those of single cycles. Where the spaces of growing and of shrinking directions come to
//! touch, motion is not hyperbolic, and orbits next to it need not have shadows.

mod ginelli;
#[cfg(test)]
mod tests;

use super::averages::CYCLES_PER_AVERAGE;
use super::called_off::CalledOff;
use super::lyapunov::TangentGrowth;
use super::norm::EnergyNorm;
use crate::model::{Model, TrajectoryState};
use crate::numerics::random::PointSeed;
use crate::numerics::statistics::{mean, quantile, standard_error};
use crate::propagate::{Counters, Kernel, Stop};
use ginelli::{Coefficients, entries};
use serde::{Deserialize, Serialize};
use std::sync::atomic::AtomicBool;

/// Stream of a point that starts its tangents and coefficients.
const STREAM: u64 = 1 << 35;

/// Standard errors by which an exponent clears zero.
const SIGMAS: f64 = 2.0;

/// Shares of angles at which their quantiles are taken.
pub const ANGLE_SHARES: [f64; 5] = [0.01, 0.1, 0.5, 0.9, 0.99];

/// Most memory that factors may take \[bytes\].
pub const MOST_MEMORY: u64 = 1 << 30;

/// How covariant vectors are asked for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CovariantConfig {
    /// Vectors, at least 1; a model has twice as many as modes that are not neutral.
    pub vectors: usize,
    /// Mesh cycles that are measured.
    pub cycles: u64,
    /// Mesh cycles in which tangents, and at the other end coefficients, turn into their directions,
    /// discarded.
    pub align: u64,
}

impl CovariantConfig {
    /// Memory that the factors of a record take \[bytes\]: `v(v + 1)/2` numbers a cycle.
    pub fn memory(&self) -> u64 {
        let numbers = entries(self.vectors) as u64;
        (self.cycles.saturating_add(self.align)).saturating_mul(8 * numbers)
    }
}

/// Angles between the space of growing directions and that of shrinking ones, once a cycle \[rad\].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AngleOutcome {
    /// The smallest.
    pub min: f64,
    /// The mean.
    pub mean: f64,
    /// Its standard error, from block averages.
    pub stderr: f64,
    /// At [`ANGLE_SHARES`].
    pub quantiles: Vec<f64>,
}

/// What is known of a point's covariant vectors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CovariantOutcome {
    /// Mean growth of each vector \[1/cycle\], largest first.
    pub exponents: Vec<f64>,
    /// Their standard errors, from block averages.
    pub errors: Vec<f64>,
    /// Standard deviations of the growth over a single cycle.
    pub spreads: Vec<f64>,
    /// Vectors whose exponent is above zero by two standard errors.
    pub unstable: u32,
    /// Vectors whose exponent is below zero by as much.
    pub stable: u32,
    /// Angles between them, where there are both.
    pub angle: Option<AngleOutcome>,
    /// Mesh cycles integrated.
    pub cycles: u64,
}

/// Why there are no covariant vectors.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum CovariantError {
    /// The work was called off.
    #[error(transparent)]
    CalledOff(#[from] CalledOff),
    /// The trajectory cannot be advanced.
    #[error(transparent)]
    Stop(#[from] Stop),
    /// A cycle leaves nothing of a direction.
    #[error("a direction vanishes within a cycle; set analyses.covariant.vectors below {vectors}")]
    Vanishing {
        /// Vectors asked for.
        vectors: usize,
    },
}

/// Covariant vectors along a motion from a state on it.
///
/// # Errors
/// [`CovariantError`].
pub fn covariant_vectors<K: Kernel>(
    model: &Model,
    kernel: &K,
    start: &TrajectoryState,
    question: &CovariantConfig,
    point: PointSeed,
    called_off: &AtomicBool,
) -> Result<CovariantOutcome, CovariantError> {
    let norm = EnergyNorm::new(model);
    let vectors = question.vectors.min(norm.dimension());
    let mut stream = point.stream(STREAM);
    let mut growth = TangentGrowth::new(&norm, model.modes(), vectors, &mut stream);
    let mut trajectory = start.clone();
    let mut workspace = kernel.workspace();
    let mut counters = Counters::default();
    let length = question.cycles + question.align;
    let mut record = Record::new(vectors, length as usize);
    for cycle in 0..question.align + length {
        CalledOff::check(called_off)?;
        kernel.advance_cycle(
            &mut trajectory,
            growth.tangents(),
            &mut workspace,
            &mut (),
            &mut counters,
        )?;
        if cycle < question.align {
            growth.cycle(&norm);
        } else {
            record.push(&mut growth, &norm)
        }
    }
    let coefficients = Coefficients::random(vectors, &mut stream);
    let found = record.back(coefficients, question.align as usize);
    found
        .map(|found| CovariantOutcome {
            cycles: counters.cycles,
            ..found
        })
        .ok_or(CovariantError::Vanishing { vectors })
}

/// What orthonormalising took, cycle by cycle.
struct Record {
    vectors: usize,
    factors: Vec<f64>,
}

impl Record {
    fn new(vectors: usize, cycles: usize) -> Self {
        Self {
            vectors,
            factors: Vec::with_capacity(cycles * entries(vectors)),
        }
    }

    /// To be called after every cycle.
    fn push(&mut self, growth: &mut TangentGrowth, norm: &EnergyNorm) {
        growth.factor(norm, &mut self.factors);
    }

    /// How many vectors grow and how many shrink beyond doubt, by the lengths that orthonormalising took.
    fn signs(&self) -> [usize; 2] {
        let grows = |i: usize| -> Vec<f64> {
            let cycles = self.factors.chunks_exact(entries(self.vectors));
            cycles
                .map(|factor| factor[entries(i + 1) - 1].ln())
                .collect()
        };
        let all: Vec<[f64; 2]> = (0..self.vectors)
            .map(|i| {
                let growth = grows(i);
                [mean(&growth), SIGMAS * standard_error(&stretches(&growth))]
            })
            .collect();
        [1.0, -1.0].map(|sign| all.iter().filter(|[g, error]| sign * g > *error).count())
    }

    /// Takes coefficients back through the record, whose last `align` cycles are discarded; none where a
    /// direction vanishes.
    fn back(&self, mut coefficients: Coefficients, align: usize) -> Option<CovariantOutcome> {
        let m = self.vectors;
        let [unstable, stable] = self.signs();
        let cycles = self.factors.chunks_exact(entries(m)).rev();
        let measured = cycles.len().saturating_sub(align);
        let mut growths = vec![Vec::with_capacity(measured); m];
        let mut angles = Vec::new();
        let mut growth = vec![0.0; m];
        for (back, factor) in cycles.enumerate() {
            coefficients.back(factor, &mut growth);
            if growth.iter().any(|g| !g.is_finite()) {
                return None;
            }
            if back < align {
                continue;
            }
            for (all, g) in growths.iter_mut().zip(&growth) {
                all.push(*g);
            }
            if unstable > 0 && stable > 0 {
                angles.push(coefficients.angle(unstable, stable)?);
            }
        }
        let errors = growths.iter().map(|g| standard_error(&stretches(g)));
        Some(CovariantOutcome {
            exponents: growths.iter().map(|g| mean(g)).collect(),
            errors: errors.collect(),
            spreads: growths.iter().map(|g| deviation(g)).collect(),
            unstable: unstable as u32,
            stable: stable as u32,
            angle: (!angles.is_empty()).then(|| AngleOutcome {
                min: angles.iter().copied().fold(f64::INFINITY, f64::min),
                mean: mean(&angles),
                stderr: standard_error(&stretches(&angles)),
                quantiles: (ANGLE_SHARES.iter())
                    .filter_map(|share| Some(quantile(&angles, *share)?.0))
                    .collect(),
            }),
            cycles: 0,
        })
    }
}

/// Averages over stretches of ten cycles.
fn stretches(values: &[f64]) -> Vec<f64> {
    let stretches = values.chunks_exact(CYCLES_PER_AVERAGE as usize);
    stretches.map(mean).collect()
}

/// Standard deviation of a series.
fn deviation(values: &[f64]) -> f64 {
    let centre = mean(values);
    let square: f64 = values.iter().map(|v| (v - centre).powi(2)).sum();
    (square / (values.len() as f64 - 1.0).max(1.0)).sqrt()
}
