//! Which directions grow independently, and how close do growing and shrinking directions come?
//!
//! Covariant Lyapunov vectors of a motion that does not repeat, by Ginelli's algorithm. Tangents are
//! integrated forwards and orthonormalised once per mesh cycle, and the factors R are kept. The coefficients
//! of the vectors are then propagated backwards through these factors ([`ginelli`]). Each vector grows on average
//! by one exponent per cycle. If the spaces of growing and of shrinking
//! directions touch, the motion is not hyperbolic. Trajectories with small errors then need not be shadowed
//! by true ones.

mod ginelli;
#[cfg(test)]
mod tests;

use super::averages::CYCLES_PER_AVERAGE;
use super::interrupt::Interrupted;
use super::lyapunov::TangentGrowth;
use super::norm::EnergyNorm;
use crate::model::{Model, TrajectoryState};
use crate::numerics::random::PointSeed;
use crate::numerics::statistics::{deviation, mean, quantile, standard_error};
use crate::propagate::{Counters, Kernel, Stop};
use ginelli::{Coefficients, entries};
use serde::{Deserialize, Serialize};
use std::sync::atomic::AtomicBool;

/// Number of the random stream of a point for tangents and coefficients.
const STREAM: u64 = 1 << 35;

/// Standard errors by which an exponent must differ from zero.
const SIGMAS: f64 = 2.0;

/// Probabilities at which the quantiles of the angles are given.
pub const ANGLE_SHARES: [f64; 5] = [0.01, 0.1, 0.5, 0.9, 0.99];

/// Maximum memory of the factors \[bytes\].
pub const MOST_MEMORY: u64 = 1 << 30;

/// Settings of covariant vectors.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CovariantConfig {
    /// Number of vectors, at least 1; a model has two per mode that is not neutral.
    pub vectors: usize,
    /// Measured mesh cycles.
    pub cycles: u64,
    /// Discarded mesh cycles at either end of the record. The tangents align before the measurement, and the
    /// coefficients, which are propagated backwards, after it.
    pub align: u64,
}

impl CovariantConfig {
    /// Memory of the factors of a record \[bytes\]: `v(v + 1)/2` numbers per cycle.
    pub fn memory(&self) -> u64 {
        let numbers = entries(self.vectors) as u64;
        (self.cycles.saturating_add(self.align)).saturating_mul(8 * numbers)
    }
}

/// Angles between the spaces of growing and of shrinking directions, once per cycle \[rad\].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AngleOutcome {
    /// Smallest angle.
    pub min: f64,
    /// Mean angle.
    pub mean: f64,
    /// Standard error of the mean angle, from block averages.
    pub stderr: f64,
    /// Quantiles at [`ANGLE_SHARES`].
    pub quantiles: Vec<f64>,
}

/// Covariant vectors of a point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CovariantOutcome {
    /// Mean growth of each vector \[1/cycle\], largest first.
    pub exponents: Vec<f64>,
    /// Standard errors of the exponents, from block averages.
    pub errors: Vec<f64>,
    /// Standard deviation of each vector's growth over a single cycle \[1/cycle\].
    pub spreads: Vec<f64>,
    /// Number of vectors with an exponent above zero by two standard errors.
    pub unstable: u32,
    /// Number of vectors with an exponent below zero by two standard errors.
    pub stable: u32,
    /// Angles between the spaces of growing and shrinking vectors, if both exist.
    pub angle: Option<AngleOutcome>,
    /// Mesh cycles integrated.
    pub cycles: u64,
}

/// Why there are no covariant vectors.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum CovariantError {
    /// The work was interrupted.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
    /// The trajectory cannot be advanced.
    #[error(transparent)]
    Stop(#[from] Stop),
    /// A direction vanishes within a cycle.
    #[error("a direction vanishes within a cycle; set analyses.covariant.vectors below {vectors}")]
    Vanishing {
        /// Number of requested vectors.
        vectors: usize,
    },
}

/// Computes the covariant vectors along a motion from a state on it.
///
/// # Errors
/// [`CovariantError`].
pub fn covariant_vectors<K: Kernel>(
    model: &Model,
    kernel: &K,
    start: &TrajectoryState,
    config: &CovariantConfig,
    point: PointSeed,
    interrupt: &AtomicBool,
) -> Result<CovariantOutcome, CovariantError> {
    let norm = EnergyNorm::new(model);
    let vectors = config.vectors.min(norm.dimension());
    let mut stream = point.stream(STREAM);
    let mut growth = TangentGrowth::new(&norm, model.modes(), vectors, &mut stream);
    let mut trajectory = start.clone();
    let mut workspace = kernel.workspace();
    let mut counters = Counters::default();
    let length = config.cycles + config.align;
    let mut record = Record::new(vectors, length as usize);
    for cycle in 0..config.align + length {
        Interrupted::check(interrupt)?;
        kernel.advance_cycle(
            &mut trajectory,
            growth.tangents(),
            &mut workspace,
            &mut (),
            &mut counters,
        )?;
        if cycle < config.align {
            growth.cycle(&norm);
        } else {
            record.push(&mut growth, &norm)
        }
    }
    let coefficients = Coefficients::random(vectors, &mut stream);
    let found = record.back(coefficients, config.align as usize);
    found
        .map(|found| CovariantOutcome {
            cycles: counters.cycles,
            ..found
        })
        .ok_or(CovariantError::Vanishing { vectors })
}

/// The factors R, cycle by cycle.
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

    /// Adds the factor of a cycle. Must be called after every cycle.
    fn push(&mut self, growth: &mut TangentGrowth, norm: &EnergyNorm) {
        growth.factor(norm, &mut self.factors);
    }

    /// Number of vectors that grow and that shrink beyond their errors, from the diagonals of R.
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
                [
                    mean(&growth),
                    SIGMAS * standard_error(&stretch_means(&growth)),
                ]
            })
            .collect();
        [1.0, -1.0].map(|sign| all.iter().filter(|[g, error]| sign * g > *error).count())
    }

    /// Propagates coefficients backwards through the record and discards its last `align` cycles; `None` if a
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
        let errors = growths.iter().map(|g| standard_error(&stretch_means(g)));
        Some(CovariantOutcome {
            exponents: growths.iter().map(|g| mean(g)).collect(),
            errors: errors.collect(),
            spreads: growths.iter().map(|g| deviation(g)).collect(),
            unstable: unstable as u32,
            stable: stable as u32,
            angle: (!angles.is_empty()).then(|| AngleOutcome {
                min: angles.iter().copied().fold(f64::INFINITY, f64::min),
                mean: mean(&angles),
                stderr: standard_error(&stretch_means(&angles)),
                quantiles: (ANGLE_SHARES.iter())
                    .filter_map(|share| Some(quantile(&angles, *share)?.0))
                    .collect(),
            }),
            cycles: 0,
        })
    }
}

/// Means over stretches of ten cycles.
fn stretch_means(values: &[f64]) -> Vec<f64> {
    let stretches = values.chunks_exact(CYCLES_PER_AVERAGE as usize);
    stretches.map(mean).collect()
}
