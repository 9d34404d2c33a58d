//! Which attractors coexist, and how large are their basins?
//!
//! Probe 0 starts at the initial state of the point. Every other probe starts at a distance `A = √E` from
//! there in the energy norm, in units of the half gap. Its direction in state space is random, without the
//! neutral pair. The logarithms of the energies E are stratified over the requested decades, with one probe
//! per stratum, around the energy that closes the half gap (`E = 1`). Each probe is investigated like a
//! separate point.
//!
//! Basin shares refer to this distribution of initial states. Their 95 % intervals (Wilson 1927) treat
//! probes as independent draws. Because of the strata, the intervals are rather too wide than too narrow.
//!
//! A slice ([`plane`]) divides a plane through the initial state of the point into square cells, each
//! with its own initial state. Cells are computed after the probes, in rounds. A cell that approaches an
//! orbit from a probe or an earlier round needs no further investigation ([`capture`]).
//!
//! Idle threads of the pool integrate probes and the cells of a round in parallel. Known attractors are
//! added only between rounds, in order of number, so that results do not depend on the threads.

mod attractors;
mod capture;
mod field;
mod outcome;
mod plane;
mod same;
#[cfg(test)]
mod tests;

use super::config::{Effort, LyapunovConfig, NvhConfig, PointConfig, Signals};
use super::evidence::ChaosOutcome;
use super::interrupt::Interrupted;
use super::lyapunov::displaced;
use super::norm::EnergyNorm;
use super::outcome::{PointOutcome, Status};
use super::poincare::Section;
use crate::model::{Model, TrajectoryState};
use crate::numerics::random::PointSeed;
use crate::propagate::{Kernel, map_side_by_side};
use attractors::Attractors;
use capture::CellEnding;
use field::{IntegrationContext, InvestigatedMotion};
use serde::Serialize;
use std::sync::atomic::AtomicBool;

pub use outcome::{AttractorOutcome, BasinShare, CellOutcome, MultistabilityOutcome, ProbeOutcome};
pub use plane::{Plane, SliceConfig, SliceError, SliceOf};

/// Number of a point's first random stream for its probes. Smaller numbers are for its tangents and twin.
const FIRST_STREAM: u64 = 1 << 32;

/// Cycles of alignment of a probe's tangent, discarded.
const ALIGN: u64 = 100;

/// Maximum number of strobe samples for the statistics of a motion that does not repeat.
const MOST_SAMPLES: u64 = 2048;

/// Number of probes, or of cells, that are computed before their results are evaluated. It bounds the memory.
const ROUND: usize = 256;

/// Smallest number of rounds of a slice. In the first round that finds a new orbit, every cell on this orbit
/// is investigated in full, so rounds must be small.
const FEWEST_ROUNDS: usize = 16;

/// Settings of the search for coexisting attractors.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MultistabilityConfig {
    /// Number of probes, including the initial state of the point; ≥ 1.
    pub initial_conditions: u32,
    /// Decades of energy of the other probes, around the energy that closes the half gap.
    pub decades: f64,
    /// Discarded mesh cycles of each probe.
    pub transient: u64,
    /// Maximum number of measured mesh cycles of each probe.
    pub cycles: u64,
    /// A slice of initial states, if requested.
    pub slice: Option<SliceConfig>,
}

/// The probes of a point.
#[derive(Debug, Clone, PartialEq)]
pub struct Probes {
    /// The point.
    pub point: PointSeed,
    /// Whether Newton's method searches for periodic orbits before the motion has settled.
    pub settle: bool,
    /// Settings of the probes.
    pub config: MultistabilityConfig,
    /// The requested slice.
    plane: Option<Plane>,
}

impl Probes {
    /// The probes of a point of a model.
    ///
    /// # Errors
    /// The requested slice is impossible for the model.
    pub fn new(
        model: &Model,
        config: MultistabilityConfig,
        point: PointSeed,
        settle: bool,
    ) -> Result<Self, SliceError> {
        let plane = config.slice.map(|slice| Plane::new(model, &slice));
        Ok(Self {
            point,
            settle,
            config,
            plane: plane.transpose()?,
        })
    }

    /// Settings of one probe.
    fn point_config(&self) -> PointConfig {
        PointConfig {
            point: self.point,
            transient: self.config.transient,
            cycles: self.config.cycles,
            settle: self.settle,
            audit_cycles: 0,
            lyapunov: Some(LyapunovConfig {
                align: ALIGN,
                twin: false,
                effort: Effort::Survey,
                ..LyapunovConfig::default()
            }),
            poincare_samples: self.config.cycles.min(MOST_SAMPLES) as usize,
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

/// Integrates all probes of a point and the cells of its slice, and finds which of them share an attractor.
/// `start` is the initial state of the point.
///
/// # Errors
/// [`Interrupted`] if `interrupt` was raised.
pub fn probe_basins<K: Kernel + Sync>(
    model: &Model,
    kernel: &K,
    start: &TrajectoryState,
    probes: &Probes,
    interrupt: &AtomicBool,
) -> Result<MultistabilityOutcome, Interrupted> {
    let norm = EnergyNorm::new(model);
    let context = IntegrationContext {
        model,
        kernel,
        norm: &norm,
        interrupt,
    };
    let point_config = probes.point_config();
    let mut attractors = Attractors::new(&context);
    let mut multistability = MultistabilityOutcome::default();
    let mut chaos = ChaosOutcome::default();
    let ids: Vec<u32> = (0..probes.config.initial_conditions).collect();
    for round in ids.chunks(ROUND) {
        let investigated = map_side_by_side(kernel, round, |kernel, &probe_id| {
            let (amplitude, trajectory) = initial_condition(model, &norm, start, probes, probe_id);
            let motion = context
                .with(kernel)
                .investigate(trajectory, &point_config)?;
            Ok((amplitude, motion))
        });
        let integrated = (investigated.into_iter()).collect::<Result<Vec<_>, Interrupted>>()?;
        for (&probe_id, (amplitude, integrated)) in round.iter().zip(integrated) {
            let id = attractors.number_of(&context, integrated.attractor, &integrated.found);
            if let Some(seen) = &integrated.found.chaos {
                chaos.cycles += seen.cycles;
                chaos.exits += seen.exits;
            }
            multistability
                .probes
                .push(outcome(probe_id, amplitude, id, integrated.found));
        }
        attractors.seek_orbits(&context);
    }
    if let Some(plane) = &probes.plane {
        multistability.cells = slice(&context, start, probes, plane, &mut attractors)?;
    }
    let slice = probes.plane.as_ref().map(|plane| (plane, start));
    multistability.attractors = attractors.outcomes(context.model, slice);
    let chaotic = multistability
        .attractors
        .iter_mut()
        .filter(|one| one.class.is_chaos());
    // Cells of a slice may find a chaotic motion that no probe has: its lifetime is then unknown.
    let lifetime = (chaos.cycles > 0).then(|| chaos.interval().0);
    chaotic.for_each(|one| one.chaos_lifetime_low = lifetime);
    multistability.share_out();
    Ok(multistability)
}

/// Computes the cells of a slice. A cell is advanced for as long as a probe's transient. If it approaches no
/// known orbit by then, it is investigated.
fn slice<K: Kernel + Sync>(
    context: &IntegrationContext<'_, K>,
    start: &TrajectoryState,
    probes: &Probes,
    plane: &Plane,
    attractors: &mut Attractors,
) -> Result<Vec<CellOutcome>, Interrupted> {
    let point_config = PointConfig {
        transient: 0,
        ..probes.point_config()
    };
    let rounds = plane.cells().div_ceil(ROUND).max(FEWEST_ROUNDS);
    let mut cells = Vec::with_capacity(plane.cells());
    for round in 0..rounds {
        // Every n-th cell, so that a round covers the slice.
        let round: Vec<usize> = (round..plane.cells()).step_by(rounds).collect();
        let orbits = attractors.orbits();
        let ended = map_side_by_side(context.kernel, &round, |kernel, &cell| {
            orbits.advance_until_captured(
                &context.with(kernel),
                plane.state(context.model, start, cell),
                probes.config.transient,
                &point_config,
            )
        });
        let integrated = (ended.into_iter()).collect::<Result<Vec<_>, Interrupted>>()?;
        for (&cell, (cell_ending, cycles)) in round.iter().zip(integrated) {
            let outcome = cell_outcome(context, plane, cell, cell_ending, cycles, attractors)?;
            cells.push((cell, outcome));
        }
        attractors.seek_orbits(context);
    }
    cells.sort_unstable_by_key(|(cell, _)| *cell);
    Ok(cells.into_iter().map(|(_, outcome)| outcome).collect())
}

fn cell_outcome<K: Kernel>(
    context: &IntegrationContext<'_, K>,
    plane: &Plane,
    cell: usize,
    cell_ending: CellEnding,
    cycles: u64,
    attractors: &mut Attractors,
) -> Result<CellOutcome, Interrupted> {
    let in_full = matches!(cell_ending, CellEnding::Open(_));
    let (attractor, status, class, more) = match cell_ending {
        CellEnding::Captured(id) => (Some(id), Status::Ok, Some(attractors.class(id)), 0),
        CellEnding::Stopped(stop) => (None, stop.try_into()?, None, 0),
        CellEnding::Open(integrated) => {
            let InvestigatedMotion { found, attractor } = *integrated;
            let id = attractors.number_of(context, attractor, &found);
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

/// Distance of a probe from the initial state of the point, and the state from which it starts.
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
    let strata = f64::from(probes.config.initial_conditions - 1);
    let position = (f64::from(probe_id - 1) + stream.uniform()) / strata;
    // The energy is 10 to the power decades · (position − 1/2).
    let amplitude = 10f64.powf(0.5 * probes.config.decades * (position - 0.5));
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
        deflection_rms: nvh.map(|n| n.values.deflection_rms),
        force_peak: nvh.map(|n| n.force_peak),
        events_per_cycle: found.events_per_cycle,
        cycles: found.cycles,
        status: found.status,
        reason: found.reason,
        class: found.class,
        basin: BasinShare::default(),
    }
}
