//! How far ahead can a chaotic motion be predicted, and how precise are its averages?
//!
//! At successive points along a trajectory, twins start a small distance away in random directions. The
//! mean logarithm of their distance grows with the largest exponent, and levels off once they have
//! forgotten the common start. The *saturation* is that level, the mean logarithm of the distance of
//! unrelated points of the motion. The *horizon* is the time when the separation reaches a tenth of it.
//!
//! Along the same trajectory the growth of a tangent over n cycles gives the spread of finite-time
//! exponents. Averages of force and deflection over n cycles give the standard error of an average of that
//! length. Distances are energy norms in half gaps.

mod measure;
#[cfg(test)]
mod tests;

use super::interrupt::{EndedEarly, Interrupted};
use super::lyapunov::{displaced, random_direction};
use super::norm::EnergyNorm;
use super::recurrence::excitation_period;
use crate::model::{Model, TrajectoryState};
use crate::numerics::random::PointSeed;
use crate::propagate::{Counters, Kernel, Observer, Stop, Tangents, Window};
use measure::{Crossing, decay, ladder, mean_logarithms, spread};
use serde::{Deserialize, Serialize};
use std::sync::atomic::AtomicBool;
use strum::IntoStaticStr;

/// Number of the random stream of a point for the tangent. The twins have the next numbers.
const FIRST_STREAM: u64 = 1 << 33;

/// Discarded mesh cycles in which the tangent aligns with the direction of strongest growth.
const ALIGN: u64 = 100;

/// Separation at the horizon, divided by the saturation. Up to this share, separations grow with the exponent.
/// Above it, slow modes of the structure separate at different rates.
const HORIZON_SHARE: f64 = 0.1;

/// Smallest number of averages over the largest number of cycles. The spread of the averages follows from
/// these.
const LONGEST_AVERAGES: u64 = 16;

/// Maximum number of strobe states for the saturation.
const MOST_STATES: u64 = 256;

/// Number of strobe states that is sufficient for the saturation.
const ENOUGH_STATES: u64 = 32;

/// Numbers of periods of the excitation. The distance between strobe states is a multiple of the first one that leaves
/// enough states.
const BANDS: [u64; 6] = [12, 6, 4, 3, 2, 1];

/// Settings for the measurement of predictability.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct HorizonConfig {
    /// Number of twins, at least 2.
    pub twins: u32,
    /// Distance of a twin from the trajectory at its start, in half gaps.
    pub separation: f64,
    /// Mesh cycles per twin.
    pub cycles: u64,
    /// Mesh cycles in the longest averages.
    pub averages: u64,
}

/// A quantity measured over a number of cycles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
pub enum HorizonQuantity {
    /// Geometric mean of the distance of twins \[half gaps\], with the spread of its logarithm.
    Separation,
    /// Growth of a tangent per cycle \[1/cycle\].
    Exponent,
    /// Average of the mesh force \[N\]. Conservation of momentum ties this average to the load. Its error
    /// therefore falls as 1/n, not as 1/√n.
    Force,
    /// Average of the force that presses flanks together, on either side \[N\].
    ContactForce,
    /// Average of the mesh deflection \[m\].
    Deflection,
}

impl HorizonQuantity {
    /// The word stored in result files.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// A quantity over a number of mesh cycles.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HorizonMeasure {
    /// The quantity.
    pub quantity: HorizonQuantity,
    /// Number of cycles.
    pub cycles: u64,
    /// Mean of the quantity.
    pub value: f64,
    /// Standard deviation of one sample.
    pub spread: f64,
    /// Number of samples.
    pub samples: u64,
}

/// Predictability of a point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HorizonOutcome {
    /// Mesh cycles until the separation is a tenth of the saturation; `None` if it stays below.
    pub horizon: Option<f64>,
    /// Standard error of the horizon, by leaving out one twin at a time (jackknife).
    pub stderr: Option<f64>,
    /// Level at which the separation saturates \[half gaps\].
    pub saturation: f64,
    /// Exponent of n in the standard error of the mean contact force over n cycles; −1/2 for independent
    /// values.
    pub averaging_exponent: Option<f64>,
    /// Mesh cycles integrated, including those of the twin trajectories.
    pub cycles: u64,
    /// All measurements.
    pub measures: Vec<HorizonMeasure>,
}

/// Measures the predictability of a chaotic motion from a state on it.
///
/// # Errors
/// [`EndedEarly`] if `interrupt` was raised or an integration ended early.
pub fn predictability<K: Kernel>(
    model: &Model,
    kernel: &K,
    start: &TrajectoryState,
    config: &HorizonConfig,
    point: PointSeed,
    interrupt: &AtomicBool,
) -> Result<HorizonOutcome, EndedEarly> {
    let mut record = Record::new(model, kernel, start, (config, point), interrupt);
    for _ in 0..ALIGN {
        record.cycle()?;
    }
    record.restart();
    let followed = u64::from(config.twins) * config.cycles;
    let stride = stride(followed, excitation_period(model).unwrap_or(1) as u64);
    let mut separations = Vec::with_capacity(config.twins as usize);
    let mut states: Vec<(u64, Vec<f64>)> = Vec::new();
    for id in 0..config.twins {
        let mut twin = record.twin(id);
        let mut logarithms = vec![config.separation.ln()];
        for _ in 0..config.cycles {
            if record.means.len().is_multiple_of(stride as usize) {
                let place = record.means.len() as u64;
                states.push((place, record.trajectory.state.clone()));
            }
            record.cycle()?;
            record.advance_twin(&mut twin)?;
            logarithms.push(record.distance(&twin.state, &record.trajectory.state).ln());
        }
        separations.push(logarithms);
    }
    while (record.means.len() as u64) < LONGEST_AVERAGES * config.averages {
        record.cycle()?;
    }
    let saturation = record.saturation(&states, config.cycles);
    Ok(outcome(&record, &separations, saturation, config))
}

/// Distance in cycles between strobe states of a record of `followed` cycles. If enough states remain, all have one
/// phase of the excitation, and lie in one band if the motion passes through several bands in turn, as twins do.
fn stride(followed: u64, period: u64) -> u64 {
    let least = followed.div_ceil(MOST_STATES);
    let multiples = BANDS.map(|bands| least.next_multiple_of(bands * period));
    let has_enough = |stride: &u64| followed / stride >= ENOUGH_STATES;
    multiples.into_iter().find(has_enough).unwrap_or(least)
}

fn outcome<K: Kernel>(
    record: &Record<'_, K>,
    separations: &[Vec<f64>],
    saturation: f64,
    config: &HorizonConfig,
) -> HorizonOutcome {
    let mut measures: Vec<HorizonMeasure> = (0..=config.cycles)
        .map(|n| {
            let at: Vec<f64> = separations.iter().map(|s| s[n as usize]).collect();
            let (mean, deviation) = spread(&at, 1);
            HorizonMeasure {
                quantity: HorizonQuantity::Separation,
                cycles: n,
                value: mean.exp(),
                spread: deviation,
                samples: at.len() as u64,
            }
        })
        .collect();
    let averages = config.averages;
    let series = [
        (HorizonQuantity::Exponent, &record.growth, config.cycles),
        (HorizonQuantity::Force, &record.means_of(1), averages),
        (HorizonQuantity::ContactForce, &record.means_of(2), averages),
        (HorizonQuantity::Deflection, &record.means_of(0), averages),
    ];
    for (quantity, values, longest) in series {
        for n in ladder(longest) {
            let (value, spread) = spread(values, n as usize);
            measures.push(HorizonMeasure {
                quantity,
                cycles: n,
                value,
                spread,
                samples: values.len() as u64 / n,
            });
        }
    }
    let level = (HORIZON_SHARE * saturation).ln();
    let crossing = Crossing::of(separations, level);
    let force = measures
        .iter()
        .filter(|m| m.quantity == HorizonQuantity::ContactForce);
    HorizonOutcome {
        horizon: crossing.place,
        stderr: crossing.stderr,
        saturation,
        averaging_exponent: decay(force),
        cycles: record.counters.cycles,
        measures,
    }
}

/// The trajectory, and the values recorded in every cycle.
struct Record<'a, K: Kernel> {
    model: &'a Model,
    kernel: &'a K,
    config: &'a HorizonConfig,
    point: PointSeed,
    interrupt: &'a AtomicBool,
    norm: EnergyNorm,
    workspace: K::Workspace,
    trajectory: TrajectoryState,
    tangents: Tangents,
    counters: Counters,
    /// Logarithmic growth of the tangent in every cycle.
    growth: Vec<f64>,
    /// Mean deflection \[m\], force and contact force \[N\] of every cycle.
    means: Vec<[f64; 3]>,
}

impl<'a, K: Kernel> Record<'a, K> {
    fn new(
        model: &'a Model,
        kernel: &'a K,
        start: &TrajectoryState,
        (config, point): (&'a HorizonConfig, PointSeed),
        interrupt: &'a AtomicBool,
    ) -> Self {
        let norm = EnergyNorm::new(model);
        let mut tangents = Tangents::zeros(model.modes(), 1);
        let mut stream = point.stream(FIRST_STREAM);
        random_direction(&norm, &mut stream, tangents.vector_mut(0));
        Self {
            model,
            kernel,
            config,
            point,
            interrupt,
            norm,
            workspace: kernel.workspace(),
            trajectory: start.clone(),
            tangents,
            counters: Counters::default(),
            growth: Vec::new(),
            means: Vec::new(),
        }
    }

    fn restart(&mut self) {
        self.growth.clear();
        self.means.clear();
    }

    /// One cycle of the trajectory and its tangent.
    fn cycle(&mut self) -> Result<(), EndedEarly> {
        Interrupted::check(self.interrupt)?;
        let mut means = CycleMeans {
            model: self.model,
            sums: [0.0; 3],
        };
        self.kernel.advance_cycle(
            &mut self.trajectory,
            &mut self.tangents,
            &mut self.workspace,
            &mut means,
            &mut self.counters,
        )?;
        self.means
            .push(means.sums.map(|sum| sum / self.model.period()));
        let tangent = self.tangents.vector_mut(0);
        self.norm.project(tangent);
        let length = self.norm.length(tangent);
        tangent.iter_mut().for_each(|x| *x /= length);
        self.growth.push(length.ln());
        Ok(())
    }

    /// A twin of the trajectory at its present state.
    fn twin(&self, id: u32) -> TrajectoryState {
        let stream = FIRST_STREAM + 1 + u64::from(id);
        let mut stream = self.point.stream(stream);
        let separation = self.config.separation;
        displaced(
            self.model,
            &self.norm,
            &self.trajectory,
            separation,
            &mut stream,
        )
    }

    fn advance_twin(&mut self, twin: &mut TrajectoryState) -> Result<(), Stop> {
        self.kernel
            .advance(1, twin, &mut self.workspace, &mut (), &mut self.counters)
    }

    /// Distance in half gaps, at least the machine precision: two trajectories may become equal to the last
    /// bit.
    fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        (self.norm.distance(a, b) / self.norm.unit()).max(f64::EPSILON)
    }

    /// Geometric mean of the distances \[half gaps\] of states that are at least `least_lag` cycles apart.
    fn saturation(&self, states: &[(u64, Vec<f64>)], least_lag: u64) -> f64 {
        let mut logarithms = Vec::new();
        for (i, (late, a)) in states.iter().enumerate() {
            let unrelated = states[..i]
                .iter()
                .filter(|(early, _)| late - early >= least_lag);
            logarithms.extend(unrelated.map(|(_, b)| self.distance(a, b).ln()));
        }
        mean_logarithms(&logarithms)
    }

    /// One entry of `means`, by its index, for every cycle.
    fn means_of(&self, index: usize) -> Vec<f64> {
        self.means.iter().map(|means| means[index]).collect()
    }
}

/// Time integrals of deflection, force and contact force over a cycle. Only the first term of a series
/// counts, because `∫ P_n = 0` for n > 0.
struct CycleMeans<'a> {
    model: &'a Model,
    sums: [f64; 3],
}

impl Observer for CycleMeans<'_> {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        let first = |series: &[f64]| series.first().copied().unwrap_or(0.0);
        self.sums[0] += window.duration * first(window.deflection);
        self.sums[1] += window.duration * first(window.force);
        let closed = window.closed.iter();
        for closed in closed.filter(|closed| self.model.of_mesh(closed.contact)) {
            let side = self.model.contacts[closed.contact].side;
            self.sums[2] += window.duration * side * first(closed.force);
        }
    }
}
