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
//!
//! A slice ([`plane`]) asks the same of squares of a plane through the point's own initial
//! state. Its cells are worked on after the probes, in rounds; a cell that comes near an
//! orbit found by a probe or in an earlier round is decided there ([`capture`]).
//!
//! Probes and the cells of a round are integrated in parallel by whatever threads of the pool
//! are idle. What is known is added to between rounds only, in order of number, so that
//! nothing depends on the threads.

mod attractors;
mod capture;
mod field;
mod outcome;
mod plane;
mod same;
#[cfg(test)]
mod tests;

use super::called_off::CalledOff;
use super::config::{Effort, LyapunovConfig, NvhConfig, PointConfig, Signals};
use super::evidence::ChaosOutcome;
use super::lyapunov::displaced;
use super::norm::EnergyNorm;
use super::outcome::{PointOutcome, Status};
use super::poincare::Section;
use crate::model::{Model, TrajectoryState};
use crate::numerics::random::PointSeed;
use crate::propagate::Kernel;
use attractors::Attractors;
use capture::Watched;
use field::{Field, Integrated};
use rayon::prelude::*;
use serde::Serialize;
use std::sync::atomic::AtomicBool;

pub use outcome::{AttractorOutcome, BasinShare, CellOutcome, MultistabilityOutcome, ProbeOutcome};
pub use plane::{Plane, SliceConfig, SliceError, SliceOf};

/// Streams of a point below this number belong to its own tangents and twin.
const FIRST_STREAM: u64 = 1 << 32;

/// Cycles of alignment of a probe's tangent, discarded.
const ALIGN: u64 = 100;

/// Most strobe samples that statistics of a motion that does not repeat are taken from; a
/// settled one is measured over as many cycles.
const MOST_SAMPLES: u64 = 2048;

/// Probes, or cells, integrated between two additions to what is known: bounds memory.
const ROUND: usize = 256;

/// Fewest rounds that a slice is worked on in: an orbit that no probe found is investigated
/// in full once a cell of the first round that finds it.
const FEWEST_ROUNDS: usize = 16;

/// How coexisting attractors are probed for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MultistabilityConfig {
    /// Probes, the point's own initial state included; ≥ 1.
    pub initial_conditions: u32,
    /// Decades of energy that the others are spread over, about the energy that closes the half
    /// gap.
    pub decades: f64,
    /// Mesh cycles of each probe discarded.
    pub transient: u64,
    /// Most mesh cycles of each probe measured.
    pub cycles: u64,
    /// A slice of initial states, if asked for.
    pub slice: Option<SliceConfig>,
}

/// The probes of a point.
#[derive(Debug, Clone, PartialEq)]
pub struct Probes {
    /// The point.
    pub point: PointSeed,
    /// Whether periodic orbits are sought by Newton's method instead of waited for.
    pub settle: bool,
    /// How they are asked for.
    pub asked: MultistabilityConfig,
    /// The slice that is asked for.
    plane: Option<Plane>,
}

impl Probes {
    /// The probes asked of a point of a model.
    ///
    /// # Errors
    /// The model has no such slice as is asked for.
    pub fn new(
        model: &Model,
        asked: MultistabilityConfig,
        point: PointSeed,
        settle: bool,
    ) -> Result<Self, SliceError> {
        let plane = asked.slice.map(|slice| Plane::new(model, &slice));
        Ok(Self {
            point,
            settle,
            asked,
            plane: plane.transpose()?,
        })
    }

    /// What is asked of one probe.
    fn questions(&self) -> PointConfig {
        PointConfig {
            point: self.point,
            transient: self.asked.transient,
            cycles: self.asked.cycles,
            settle: self.settle,
            audit_cycles: 0,
            lyapunov: Some(LyapunovConfig {
                align: ALIGN,
                twin: false,
                effort: Effort::Survey,
                ..LyapunovConfig::default()
            }),
            poincare_samples: self.asked.cycles.min(MOST_SAMPLES) as usize,
            section: Section::default(),
            nvh: Some(NvhConfig {
                harmonics: 0,
                outputs: Signals::NONE,
                power: false,
                spectrum: None,
                orders: None,
                stop_at_stderr: None,
            }),
        }
    }
}

/// Advances all probes of a point, and the cells of its slice, and tells their attractors
/// apart. `start` is the point's own initial state.
///
/// # Errors
/// [`CalledOff`] when `called_off` was raised meanwhile.
pub fn probe_basins<K: Kernel + Sync>(
    model: &Model,
    kernel: &K,
    start: &TrajectoryState,
    probes: &Probes,
    called_off: &AtomicBool,
) -> Result<MultistabilityOutcome, CalledOff> {
    let norm = EnergyNorm::new(model);
    let field = Field {
        model,
        kernel,
        norm: &norm,
        called_off,
    };
    let questions = probes.questions();
    let mut attractors = Attractors::new(&field);
    let mut found = MultistabilityOutcome::default();
    let mut chaos = ChaosOutcome::default();
    let ids: Vec<u32> = (0..probes.asked.initial_conditions).collect();
    for round in ids.chunks(ROUND) {
        let integrated: Vec<(f64, Integrated)> = round
            .par_iter()
            .map(|&probe_id| {
                let (amplitude, trajectory) =
                    initial_condition(model, &norm, start, probes, probe_id);
                Ok((amplitude, field.investigate(trajectory, &questions)?))
            })
            .collect::<Result<_, CalledOff>>()?;
        for (&probe_id, (amplitude, integrated)) in round.iter().zip(integrated) {
            let id = attractors.admit(&field, integrated.attractor, &integrated.found);
            if let Some(seen) = &integrated.found.chaos {
                chaos.cycles += seen.cycles;
                chaos.exits += seen.exits;
            }
            found
                .probes
                .push(outcome(probe_id, amplitude, id, integrated.found));
        }
        attractors.seek_orbits(&field);
    }
    if let Some(plane) = &probes.plane {
        found.cells = slice(&field, start, probes, plane, &mut attractors)?;
    }
    let slice = probes.plane.as_ref().map(|plane| (plane, start));
    found.attractors = attractors.outcomes(field.model, slice);
    let chaotic = found
        .attractors
        .iter_mut()
        .filter(|one| one.class.is_chaos());
    chaotic.for_each(|one| one.chaos_lifetime_low = Some(chaos.interval().0));
    found.share_out();
    Ok(found)
}

/// Works through the cells of a slice. A cell is watched for as long as a probe's transient,
/// and investigated from there on if it has come near no orbit.
fn slice<K: Kernel + Sync>(
    field: &Field<'_, K>,
    start: &TrajectoryState,
    probes: &Probes,
    plane: &Plane,
    attractors: &mut Attractors,
) -> Result<Vec<CellOutcome>, CalledOff> {
    let questions = PointConfig {
        transient: 0,
        ..probes.questions()
    };
    let rounds = plane.cells().div_ceil(ROUND).max(FEWEST_ROUNDS);
    let mut cells = Vec::with_capacity(plane.cells());
    for round in 0..rounds {
        // Every n-th: a round is spread over the slice.
        let round: Vec<usize> = (round..plane.cells()).step_by(rounds).collect();
        let orbits = attractors.orbits();
        let integrated: Vec<(Watched, u64)> = round
            .par_iter()
            .map(|&cell| {
                let trajectory = plane.state(field.model, start, cell);
                orbits.watch(field, trajectory, probes.asked.transient, &questions)
            })
            .collect::<Result<_, CalledOff>>()?;
        for (&cell, (watched, cycles)) in round.iter().zip(integrated) {
            let outcome = cell_outcome(field, plane, cell, watched, cycles, attractors)?;
            cells.push((cell, outcome));
        }
        attractors.seek_orbits(field);
    }
    cells.sort_unstable_by_key(|(cell, _)| *cell);
    Ok(cells.into_iter().map(|(_, outcome)| outcome).collect())
}

fn cell_outcome<K: Kernel>(
    field: &Field<'_, K>,
    plane: &Plane,
    cell: usize,
    watched: Watched,
    cycles: u64,
    attractors: &mut Attractors,
) -> Result<CellOutcome, CalledOff> {
    let in_full = matches!(watched, Watched::Open(_));
    let (attractor, status, class, more) = match watched {
        Watched::Captured(id) => (Some(id), Status::Ok, Some(attractors.class(id)), 0),
        Watched::Stopped(stop) => (None, stop.try_into()?, None, 0),
        Watched::Open(integrated) => {
            let Integrated { found, attractor } = *integrated;
            let id = attractors.admit(field, attractor, &found);
            (id, found.status, found.class, found.cycles)
        }
    };
    let [column, row] = plane.column_row(cell);
    Ok(CellOutcome {
        column,
        row,
        place: plane.centre(cell),
        attractor,
        status,
        class,
        in_full,
        cycles: cycles + more,
    })
}

/// Where a probe starts, and how far from the point's own initial state that is.
fn initial_condition(
    model: &Model,
    norm: &EnergyNorm,
    start: &TrajectoryState,
    probes: &Probes,
    probe_id: u32,
) -> (f64, TrajectoryState) {
    if probe_id == 0 {
        return (0.0, start.clone());
    }
    let stream = FIRST_STREAM + u64::from(probe_id);
    let mut stream = probes.point.stream(stream);
    let strata = f64::from(probes.asked.initial_conditions - 1);
    let position = (f64::from(probe_id - 1) + stream.uniform()) / strata;
    // The energy is 10 to the power decades · (position − 1/2).
    let amplitude = 10f64.powf(0.5 * probes.asked.decades * (position - 0.5));
    let displaced = displaced(model, norm, start, amplitude, &mut stream);
    (amplitude, displaced)
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
        lambda_stderr: lyapunov.map(|l| l.stderr()),
        deflection_rms: nvh.map(|n| n.deflection_rms),
        force_peak: nvh.map(|n| n.force_peak),
        events_per_cycle: found.events_per_cycle,
        cycles: found.cycles,
        status: found.status,
        reason: found.reason,
        class: found.class,
        basin: BasinShare::default(),
    }
}
