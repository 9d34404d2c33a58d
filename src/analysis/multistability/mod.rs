//! Which attractors coexist, and how large are their basins?
//!
//! Probe 0 starts where the point itself does. Every other probe starts a distance
//! `A = √E` away from there in the energy norm (in units of the half gap), in a random
//! direction of state space, the neutral pair left out. The logarithms of their energies E
//! are stratified, one probe a stratum, over the decades asked for, about the energy that
//! closes the half gap (`E = 1`). Each probe is investigated like a point of its own.
//!
//! Shares are those of this measure on initial states. Their 95 % intervals (Wilson 1927)
//! take probes as independent draws; strata make them, if anything, too wide.

mod same;
#[cfg(test)]
mod tests;

use super::lyapunov::random_direction;
use super::norm::EnergyNorm;
use super::outcome::{Class, PointOutcome, Status};
use super::point::{CalledOff, investigate_onward};
use super::questions::{LyapunovQuestion, NvhQuestion, Questions};
use crate::model::{Model, TrajectoryState};
use crate::numerics::proportion::wilson_interval;
use crate::numerics::random::Stream;
use crate::propagate::Kernel;
use same::Attractor;
use serde::{Deserialize, Serialize};
use std::sync::atomic::AtomicBool;

/// Streams of a point below this number belong to its own tangents and twin.
const FIRST_STREAM: u64 = 1 << 32;

/// Cycles of alignment of a probe's tangent, discarded.
const ALIGN: u64 = 100;

/// Most strobe samples that statistics of a motion that does not repeat are taken from; a
/// settled one is measured over as many cycles.
const MOST_SAMPLES: u64 = 2048;

/// How coexisting attractors are probed for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MultistabilityQuestion {
    /// Root seed of the random streams.
    pub seed: u64,
    /// The point, as the streams know it.
    pub point_id: u64,
    /// Probes, the point's own initial state included.
    pub initial_conditions: u32,
    /// Decades of energy that the others are spread over.
    pub decades: f64,
    /// Mesh cycles of each probe discarded.
    pub transient: u64,
    /// Most mesh cycles of each probe measured.
    pub cycles: u64,
    /// Whether periodic orbits are sought by Newton's method instead of waited for.
    pub settle: bool,
}

/// A share of a point's probes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct BasinShare {
    /// The share itself \[1\].
    pub share: f64,
    /// Lower end of its 95 % interval.
    pub low: f64,
    /// Upper end of its 95 % interval.
    pub high: f64,
}

/// What became of one initial condition.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ProbeOutcome {
    /// From 0; 0 is the point's own initial state.
    pub probe_id: u32,
    /// Distance of the initial state from the point's own in the energy norm, in units of
    /// the half gap; the energy is its square.
    pub amplitude: f64,
    /// The attractor, numbered by first probe; none for a probe that settled on none.
    pub attractor: Option<u32>,
    /// How the work ended.
    pub status: Status,
    /// Why this status and this class.
    pub reason: String,
    /// Kind of motion.
    pub class: Option<Class>,
    /// Largest exponent \[1/cycle\].
    pub lambda: Option<f64>,
    /// Its standard error.
    pub lambda_stderr: Option<f64>,
    /// Root mean square of the deflection about its mean \[m\].
    pub dte_rms: Option<f64>,
    /// Largest |mesh force| \[N\].
    pub force_peak: Option<f64>,
    /// Contact-state changes per measured cycle.
    pub events_per_cycle: Option<f64>,
    /// Mesh cycles marched, transient included.
    pub cycles: u64,
    /// Share of the probes that end on this attractor, or with this status where they settle
    /// on none.
    pub basin: BasinShare,
}

/// What the probes of a point found.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct MultistabilityOutcome {
    /// Different attractors.
    pub attractors: u32,
    /// The probes, in order.
    pub probes: Vec<ProbeOutcome>,
}

impl MultistabilityOutcome {
    /// Mesh cycles marched by all probes.
    pub fn cycles(&self) -> u64 {
        self.probes.iter().map(|probe| probe.cycles).sum()
    }
}

/// Marches all probes of a point and tells their attractors apart. `start` is the point's
/// own initial state.
///
/// # Errors
/// [`CalledOff`] when `called_off` was raised meanwhile.
pub fn probe_basins<K: Kernel>(
    model: &Model,
    kernel: &K,
    start: &TrajectoryState,
    question: &MultistabilityQuestion,
    called_off: &AtomicBool,
) -> Result<MultistabilityOutcome, CalledOff> {
    let norm = EnergyNorm::new(model);
    let questions = Questions {
        seed: question.seed,
        point_id: question.point_id,
        transient: question.transient,
        cycles: question.cycles,
        settle: question.settle,
        audit_cycles: 0,
        lyapunov: Some(LyapunovQuestion {
            exponents: 1,
            stop_at_stderr: None,
            align: ALIGN,
            twin: false,
        }),
        poincare_samples: question.cycles.min(MOST_SAMPLES) as usize,
        nvh: Some(NvhQuestion {
            harmonics: 0,
            spectrum: false,
            bearings: false,
        }),
    };
    let mut known: Vec<Attractor> = Vec::new();
    let mut probes = Vec::with_capacity(question.initial_conditions as usize);
    for probe_id in 0..question.initial_conditions {
        let (amplitude, mut trajectory) =
            initial_condition(model, &norm, start, question, probe_id);
        let mut found = investigate_onward(model, kernel, &mut trajectory, &questions, called_off)?;
        let attractor = match Attractor::of(model, kernel, &norm, &found, trajectory) {
            Ok(attractor) => attractor,
            Err(stop) => {
                found.status = stop.into();
                found.reason = stop.to_string();
                None
            }
        };
        let id = attractor.map(|new| {
            let same = known.iter().position(|old| old.is_same(&new, &norm));
            same.unwrap_or_else(|| {
                known.push(new);
                known.len() - 1
            }) as u32
        });
        probes.push(outcome(probe_id, amplitude, id, found));
    }
    share_out(&mut probes);
    Ok(MultistabilityOutcome {
        attractors: known.len() as u32,
        probes,
    })
}

/// Where a probe starts, and how far from the point's own initial state that is.
fn initial_condition(
    model: &Model,
    norm: &EnergyNorm,
    start: &TrajectoryState,
    question: &MultistabilityQuestion,
    probe_id: u32,
) -> (f64, TrajectoryState) {
    if probe_id == 0 {
        return (0.0, start.clone());
    }
    let stream = FIRST_STREAM + u64::from(probe_id);
    let mut stream = Stream::new(question.seed, question.point_id, stream);
    let strata = f64::from(question.initial_conditions - 1);
    let position = (f64::from(probe_id - 1) + stream.uniform()) / strata;
    // The energy is 10 to the power decades · (position − 1/2).
    let amplitude = 10f64.powf(0.5 * question.decades * (position - 0.5));
    let mut direction = vec![0.0; start.state.len()];
    random_direction(norm, &mut stream, &mut direction);
    let length = norm.length(&direction);
    let scale = if length > 0.0 {
        amplitude * norm.unit() / length
    } else {
        0.0
    };
    let state = start
        .state
        .iter()
        .zip(&direction)
        .map(|(x, d)| x + scale * d)
        .collect();
    (amplitude, TrajectoryState::new(model, state, start.cycle))
}

fn outcome(
    probe_id: u32,
    amplitude: f64,
    attractor: Option<u32>,
    found: PointOutcome,
) -> ProbeOutcome {
    let nvh = found.nvh.as_ref();
    let lyapunov = found.lyapunov.as_ref();
    ProbeOutcome {
        probe_id,
        amplitude,
        attractor,
        lambda: lyapunov.and_then(|l| l.exponents.first().copied()),
        lambda_stderr: lyapunov.map(|l| l.stderr),
        dte_rms: nvh.map(|n| n.dte_rms),
        force_peak: nvh.map(|n| n.force_peak),
        events_per_cycle: found.events_per_cycle,
        cycles: found.cycles,
        status: found.status,
        reason: found.reason,
        class: found.class,
        basin: BasinShare::default(),
    }
}

/// Gives every probe the share of its ending among all probes.
fn share_out(probes: &mut [ProbeOutcome]) {
    let ending = |probe: &ProbeOutcome| (probe.attractor, probe.status.clone());
    let endings: Vec<_> = probes.iter().map(ending).collect();
    for (probe, own) in probes.iter_mut().zip(&endings) {
        // The status of probes on one attractor may differ; the attractor decides.
        let alike = |other: &&(Option<u32>, Status)| match own.0 {
            Some(_) => other.0 == own.0,
            None => *other == own,
        };
        let count = endings.iter().filter(alike).count();
        let [low, high] = wilson_interval(count, endings.len());
        probe.basin = BasinShare {
            share: count as f64 / endings.len() as f64,
            low,
            high,
        };
    }
}
