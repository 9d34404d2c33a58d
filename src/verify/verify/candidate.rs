//! The kernels under test, by name, and the methods that the checks need.
//!
//! The methods of a kernel are generic over observers, so that a list cannot contain kernels as trait
//! objects. [`Propagator`] is their interface for the checks, with one method per quantity.

use super::CheckError;
use crate::analysis::orbits::floquet;
use crate::analysis::{
    Effort, EnergyAudit, EnergyNorm, LyapunovConfig, LyapunovOutcome, MultistabilityOutcome, Nvh,
    NvhOutcome, PointConfig, Probes, Section, TangentGrowth, investigate, probe_basins,
};
use crate::model::{InitialState, Model, TrajectoryState};
use crate::numerics::random::{PointSeed, Stream};
use crate::propagate::{
    ClosedModes, Counters, Event, InstructionSet, Kernel, Observer, Stop, Tangents, Volterra,
};
use num_complex::Complex64;
use std::sync::atomic::AtomicBool;

/// Largest number of events allowed in a mesh cycle.
const EVENT_LIMIT: u32 = 10_000;

/// A kernel by name.
pub struct Candidate {
    /// Its name in the report.
    pub name: String,
    /// Whether it follows stiffness that varies within a segment, and rigid stops.
    follows_all: bool,
    /// Allowed round-off, relative to that of the kernel `volterra`.
    pub round_off: f64,
    /// Divisor of the number of cycles in long checks.
    pub one_of: u64,
    prepare: Box<Prepare>,
}

/// Allowed round-off of a kernel with tables. Products with dense matrices add about a hundred terms per
/// step, and the round-off of a table is the same in every cycle.
const TABLE_ROUND_OFF: f64 = 10.0;

/// Divisor of the number of cycles for a kernel with tables, which takes several times as long.
const ONE_OF_TABLE_CYCLES: u64 = 5;

type Prepared<'m> = Result<Box<dyn Propagator + 'm>, CheckError>;
type Prepare = dyn for<'m> Fn(&'m Model) -> Prepared<'m> + Send + Sync;

impl Candidate {
    /// A kernel that `prepare` builds for a model.
    pub fn new(
        name: impl Into<String>,
        prepare: impl for<'m> Fn(&'m Model) -> Box<dyn Propagator + 'm> + Send + Sync + 'static,
    ) -> Self {
        Self {
            name: name.into(),
            follows_all: true,
            round_off: 1.0,
            one_of: 1,
            prepare: Box::new(move |model| Ok(prepare(model))),
        }
    }

    /// A kernel whose tables `prepare` builds for a model. It does not support stiffness that varies within a segment, or
    /// rigid stops.
    pub fn of_tables(
        name: impl Into<String>,
        prepare: impl for<'m> Fn(&'m Model) -> Prepared<'m> + Send + Sync + 'static,
    ) -> Self {
        Self {
            name: name.into(),
            follows_all: false,
            round_off: TABLE_ROUND_OFF,
            one_of: ONE_OF_TABLE_CYCLES,
            prepare: Box::new(prepare),
        }
    }

    /// Whether the kernel supports a model.
    pub fn supports(&self, model: &Model) -> bool {
        let constant = || (model.first_cycle().segments.iter()).all(|s| s.stiffness.is_constant());
        self.follows_all || (constant() && model.stops.is_empty())
    }

    /// The kernel of a model.
    ///
    /// # Errors
    /// The tables of the kernel cannot be built.
    pub fn on<'m>(&self, model: &'m Model) -> Result<Box<dyn Propagator + 'm>, CheckError> {
        (self.prepare)(model)
    }
}

/// The kernels that are exact between events: `closed_modes`, and `volterra` with every instruction set that
/// the machine and the code support. The last kernel supports every drive.
pub fn kernels() -> Vec<Candidate> {
    let volterra = |set: InstructionSet| {
        Candidate::new(format!("volterra {}", set.name()), move |model| {
            Box::new(Volterra::with_instructions(
                model,
                f64::EPSILON,
                EVENT_LIMIT,
                set,
            ))
        })
    };
    let closed_modes = Candidate::of_tables("closed_modes", |model| {
        let set = InstructionSet::best();
        Ok(Box::new(ClosedModes::new(model, EVENT_LIMIT, set)?))
    });
    let sets = InstructionSet::available().into_iter();
    [closed_modes]
        .into_iter()
        .chain(sets.map(volterra))
        .collect()
}

/// End and events of an integration.
#[derive(Debug, Clone)]
pub struct Passage {
    /// The trajectory at its end.
    pub end: TrajectoryState,
    /// Every change of contact state.
    pub events: Vec<Event>,
    /// The work, as counted by the kernel.
    pub counters: Counters,
}

/// Growth of a volume of tangent space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VolumeGrowth {
    /// Sum of all exponents, per mesh cycle.
    pub exponent_sum: f64,
    /// Fraction of the time in contact.
    pub contact_fraction: f64,
}

/// A quantity from a kernel; `None` if it does not exist.
type Found<T> = Result<Option<T>, Stop>;

/// The interface of a kernel for one model, for the checks.
pub trait Propagator {
    /// Advances whole mesh cycles.
    ///
    /// # Errors
    /// [`Stop`], for all methods of this trait.
    fn passage(&self, start: &TrajectoryState, cycles: u64) -> Result<Passage, Stop>;

    /// Advances tangents over one mesh cycle.
    fn carry(&self, start: &TrajectoryState, tangents: &mut Tangents) -> Result<(), Stop>;

    /// Relative residual of the energy balance over some cycles; `None` if nothing moved.
    fn energy_residual(&self, model: &Model, start: &TrajectoryState, cycles: u64) -> Found<f64>;

    /// NVH statistics over some cycles.
    fn nvh(&self, model: &Model, start: &TrajectoryState, cycles: u64) -> Found<NvhOutcome>;

    /// Multipliers of the one-cycle map at a state.
    fn multipliers(&self, model: &Model, start: &TrajectoryState) -> Found<Vec<Complex64>>;

    /// Growth of a volume of the whole tangent space over `cycles`, a multiple of ten.
    fn volume_growth(
        &self,
        model: &Model,
        start: &TrajectoryState,
        cycles: u64,
    ) -> Found<VolumeGrowth>;

    /// Exponents from tangents and from a twin trajectory.
    ///
    /// # Errors
    /// The kernel stops.
    fn lyapunov(
        &self,
        model: &Model,
        start: &TrajectoryState,
        cycles: u64,
    ) -> Result<Option<LyapunovOutcome>, CheckError>;

    /// Coexisting attractors, probed on the threads of the current rayon pool.
    ///
    /// # Errors
    /// The kernel stops.
    fn probes(&self, model: &Model, probes: &Probes) -> Result<MultistabilityOutcome, CheckError>;
}

/// Stores every event.
#[derive(Debug, Default)]
struct Events(Vec<Event>);

impl Observer for Events {
    const WINDOWS: bool = false;

    fn event(&mut self, event: &Event) {
        self.0.push(*event);
    }
}

/// Advances whole cycles without tangents.
fn advance_observed<K: Kernel, O: Observer>(
    kernel: &K,
    start: &TrajectoryState,
    cycles: u64,
    observer: &mut O,
) -> Result<(TrajectoryState, Counters), Stop> {
    let (mut workspace, mut trajectory) = (kernel.workspace(), start.clone());
    let mut counters = Counters::default();
    kernel.advance(
        cycles,
        &mut trajectory,
        &mut workspace,
        observer,
        &mut counters,
    )?;
    Ok((trajectory, counters))
}

impl<K: Kernel + Sync> Propagator for K {
    fn passage(&self, start: &TrajectoryState, cycles: u64) -> Result<Passage, Stop> {
        let mut events = Events::default();
        let (end, counters) = advance_observed(self, start, cycles, &mut events)?;
        Ok(Passage {
            end,
            events: events.0,
            counters,
        })
    }

    fn carry(&self, start: &TrajectoryState, tangents: &mut Tangents) -> Result<(), Stop> {
        self.advance_cycle(
            &mut start.clone(),
            tangents,
            &mut self.workspace(),
            &mut (),
            &mut Counters::default(),
        )
    }

    fn energy_residual(&self, model: &Model, start: &TrajectoryState, cycles: u64) -> Found<f64> {
        let mut audit = EnergyAudit::new(model);
        let (end, _) = advance_observed(self, start, cycles, &mut audit)?;
        Ok(audit.residual(&end))
    }

    fn nvh(&self, model: &Model, start: &TrajectoryState, cycles: u64) -> Found<NvhOutcome> {
        let mut nvh = Nvh::new(model, 0);
        advance_observed(self, start, cycles, &mut nvh)?;
        Ok(nvh.outcome())
    }

    fn multipliers(&self, model: &Model, start: &TrajectoryState) -> Found<Vec<Complex64>> {
        floquet::multipliers(
            model,
            self,
            &EnergyNorm::new(model),
            &mut start.clone(),
            1,
            &mut self.workspace(),
            &mut Counters::default(),
        )
    }

    fn volume_growth(
        &self,
        model: &Model,
        start: &TrajectoryState,
        cycles: u64,
    ) -> Found<VolumeGrowth> {
        let norm = EnergyNorm::new(model);
        let mut stream = Stream::new(3, 1, 4);
        let mut growth = TangentGrowth::new(&norm, model.modes(), norm.dimension(), &mut stream);
        let (mut workspace, mut trajectory) = (self.workspace(), start.clone());
        let mut nvh = Nvh::new(model, 0);
        for _ in 0..cycles {
            self.advance_cycle(
                &mut trajectory,
                growth.tangents(),
                &mut workspace,
                &mut nvh,
                &mut Counters::default(),
            )?;
            growth.cycle(&norm);
        }
        let (Some(exponents), Some(nvh)) = (growth.exponents(), nvh.outcome()) else {
            return Ok(None);
        };
        let [drive, _, coast, both] = nvh.values.fractions;
        Ok(Some(VolumeGrowth {
            exponent_sum: exponents.iter().sum(),
            contact_fraction: drive + coast + both,
        }))
    }

    fn lyapunov(
        &self,
        model: &Model,
        start: &TrajectoryState,
        cycles: u64,
    ) -> Result<Option<LyapunovOutcome>, CheckError> {
        let config = PointConfig {
            point: PointSeed {
                seed: 1,
                point_id: 2,
            },
            transient: 200,
            cycles,
            settle: false,
            audit_cycles: 0,
            lyapunov: Some(LyapunovConfig {
                align: 50,
                effort: Effort::Survey,
                ..LyapunovConfig::default()
            }),
            poincare_samples: 0,
            section: Section::default(),
            nvh: None,
        };
        let never = AtomicBool::new(false);
        let outcome = investigate(model, self, start.clone(), &config, &never)?;
        Ok(outcome.lyapunov)
    }

    fn probes(&self, model: &Model, probes: &Probes) -> Result<MultistabilityOutcome, CheckError> {
        let start = model.start(&InitialState::Static);
        let never = AtomicBool::new(false);
        Ok(probe_basins(model, self, &start, probes, &never)?)
    }
}
