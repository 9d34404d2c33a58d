//! Computes one point, from specification to result; every failure becomes part of the result.

use super::build::{BuildError, point_config};
use super::carried::CarriedState;
use super::parts::Prepared;
use super::point_kernel::PointKernel;
use crate::analysis::{
    Analyses, Class, CovariantError, CovariantOutcome, EndedEarly, HorizonOutcome, Interrupted,
    MultistabilityOutcome, OrbitSurvey, PointConfig, PointOutcome, Probes, Status,
    covariant_vectors, investigate_onward, predictability, probe_basins, survey_orbits,
};
use crate::manifest::PointSpec;
use crate::model::{Model, TrajectoryState};
use crate::numerics::random::PointSeed;
use crate::propagate::{Interruptible, Kernel, KernelUse, Seat, SideBySide};
use crate::store::{ChainEnd, MeshUnderLoad, Placement, PointRow};
use crate::topology::{ProcessorClock, Topology};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// The worker that computes a point.
#[derive(Clone, Copy)]
pub struct Worker<'a> {
    /// Number, from 0.
    pub index: u32,
    /// The machine, if known.
    pub topology: Option<&'a Topology>,
    /// Its seat if one thread computes several points side by side.
    pub seat: Option<&'a Seat<'a>>,
}

/// The results of a point.
#[derive(Debug)]
pub(super) struct PointResult {
    pub outcome: PointOutcome,
    pub multistability: Option<MultistabilityOutcome>,
    pub orbits: Option<OrbitSurvey>,
    pub horizon: Option<HorizonOutcome>,
    pub covariant: Option<CovariantOutcome>,
    /// The mesh under the mean load, if computed from the gears.
    pub mesh: Option<MeshUnderLoad>,
    /// State at the end of the integration; `None` if it diverged or never started.
    pub end: Option<ChainEnd>,
    /// Name of the kernel that integrated the point, or of the setting that should have chosen it.
    pub kernel: &'static str,
    /// Processor time of each [`Step`].
    pub times: Times,
}

/// The steps of a point's work, in order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Step {
    Integration,
    Multistability,
    Orbits,
    Horizon,
    Covariant,
}

/// Processor time of each [`Step`] \[s\]: of this thread, or of all threads if they share the point.
pub(super) type Times = [f64; Step::Covariant as usize + 1];

/// Measures the times of steps.
struct StepTimer {
    clock: ProcessorClock,
    last: f64,
    times: Times,
}

impl StepTimer {
    fn new(clock: ProcessorClock) -> Self {
        Self {
            clock,
            last: clock.now(),
            times: Times::default(),
        }
    }

    /// Ends `step` and starts the next one. Reading the clock takes time, so it is omitted if the step was not
    /// requested.
    fn end(&mut self, step: Step, requested: bool) {
        if !requested {
            return;
        }
        let now = self.clock.now();
        self.times[step as usize] = now - self.last;
        self.last = now;
    }
}

impl PointResult {
    fn failed(point: &PointSpec, reason: String) -> Self {
        Self {
            outcome: PointOutcome::without_results(Status::Failed, reason),
            multistability: None,
            orbits: None,
            horizon: None,
            covariant: None,
            mesh: None,
            end: None,
            kernel: point.run.kernel.name(),
            times: Times::default(),
        }
    }
}

/// Computes a point, from `run.initial` or from the end of another point. If it has a seat, the thread
/// computes other points side by side with it. A model that cannot be built, or a panic, gives the status
/// `failed` and the reason.
pub(super) fn compute_point(
    point: &PointSpec,
    start: Option<CarriedState<'_>>,
    parts: &Prepared,
    seat: Option<&Seat<'_>>,
    interrupt: &AtomicBool,
) -> Result<PointResult, Interrupted> {
    let computed = catch_unwind(AssertUnwindSafe(|| {
        build_and_compute(point, start, parts, seat, interrupt)
    }));
    match computed {
        Ok(Ok(result)) => result,
        Ok(Err(error)) => Ok(PointResult::failed(point, error.to_string())),
        Err(panic) => {
            let message = panic
                .downcast_ref::<String>()
                .map(String::as_str)
                .or_else(|| panic.downcast_ref::<&str>().copied())
                .unwrap_or("no message");
            let reason = format!("the program panicked: {message}");
            Ok(PointResult::failed(point, reason))
        }
    }
}

/// The row of a computed point, without its part in a chain.
pub(super) fn row(
    point: &PointSpec,
    result: PointResult,
    worker: Worker<'_>,
    clock: Instant,
) -> PointRow {
    PointRow {
        point_id: point.point_id,
        axis_values: point.axis_values.clone(),
        outcome: result.outcome,
        multistability: result.multistability,
        orbits: result.orbits,
        chain: None,
        horizon: result.horizon,
        covariant: result.covariant,
        mesh: result.mesh,
        kernel: result.kernel.to_owned(),
        placement: Placement {
            worker: worker.index,
            numa_node: worker.topology.and_then(Topology::current_numa_node),
            wall_time: clock.elapsed().as_secs_f64(),
        },
    }
}

fn build_and_compute(
    point: &PointSpec,
    start: Option<CarriedState<'_>>,
    parts: &Prepared,
    seat: Option<&Seat<'_>>,
    interrupt: &AtomicBool,
) -> Result<Result<PointResult, Interrupted>, BuildError> {
    let (model, mesh) = parts.model_and_mesh(point)?;
    let kernel = PointKernel::of(point, &model, parts)?;
    let initial = model.start(&point.run.initial);
    let seed = point.random();
    let start = match start {
        Some(carried) => carried.start(&model, seed),
        None => initial.clone(),
    };
    let probes = (point.analyses.multistability)
        .map(|config| Probes::new(&model, config, seed, point.run.settle))
        .transpose()?;
    let task = |kernel: &PointKernel| PointTask {
        model: &model,
        kernel: kernel.choice.name(),
        start: start.clone(),
        initial: initial.clone(),
        mesh,
        config: point_config(point, seed),
        probes: probes.clone(),
        analyses: &point.analyses,
        seed,
        seat,
        interrupt,
    };
    kernel.apply(&model, parts, task)
}

/// The computation of a point whose model and starts are known.
struct PointTask<'a> {
    model: &'a Model,
    /// Name of the kernel.
    kernel: &'static str,
    /// The point's mesh under the mean load.
    mesh: Option<MeshUnderLoad>,
    /// Start of the point's trajectory.
    start: TrajectoryState,
    /// The start from `run.initial`, around which probes start.
    initial: TrajectoryState,
    config: PointConfig,
    probes: Option<Probes>,
    analyses: &'a Analyses,
    seed: PointSeed,
    seat: Option<&'a Seat<'a>>,
    interrupt: &'a AtomicBool,
}

impl KernelUse for PointTask<'_> {
    type Output = Result<PointResult, Interrupted>;

    fn with<K: Kernel + Sync>(self, kernel: &K) -> Self::Output {
        let Self {
            model, interrupt, ..
        } = self;
        let kernel = &Interruptible::new(kernel, interrupt);
        let mut laps = StepTimer::new(match self.probes {
            Some(_) => ProcessorClock::Process,
            None => ProcessorClock::Thread,
        });
        let mut trajectory = self.start;
        let beside = &SideBySide::new(kernel, self.seat);
        let mut outcome =
            investigate_onward(model, beside, &mut trajectory, &self.config, interrupt)?;
        laps.end(Step::Integration, true);
        let multistability = (self.probes.as_ref())
            .map(|probes| probe_basins(model, kernel, &self.initial, probes, interrupt))
            .transpose()?;
        outcome.cycles += multistability.iter().map(|m| m.cycles()).sum::<u64>();
        laps.end(Step::Multistability, self.probes.is_some());
        let whole = matches!(outcome.status, Status::Ok | Status::NotConverged);
        // The survey integrates a copy, so the chain does not include its cycles.
        let orbits = match &self.analyses.orbits {
            Some(config) if whole => {
                let mut onward = trajectory.clone();
                let survey = survey_orbits(model, kernel, &mut onward, config, interrupt)?;
                outcome.cycles += survey.cycles;
                Some(survey)
            }
            _ => None,
        };
        laps.end(Step::Orbits, orbits.is_some());
        let chaotic = whole && outcome.class.is_some_and(|class| class.is_chaos());
        let horizon_config = self.analyses.horizon.filter(|_| chaotic);
        let measured = horizon_config.map(|config| {
            predictability(model, kernel, &trajectory, &config, self.seed, interrupt)
        });
        let horizon = match measured {
            None => None,
            Some(Ok(found)) => Some(found),
            Some(Err(EndedEarly::Interrupted(interrupt))) => return Err(interrupt),
            Some(Err(EndedEarly::Stop(stop))) => {
                outcome.reason.push_str(&format!(" (no horizon: {stop})"));
                None
            }
        };
        outcome.cycles += horizon.iter().map(|h| h.cycles).sum::<u64>();
        laps.end(Step::Horizon, horizon.is_some());
        let aperiodic = chaotic || whole && outcome.class == Some(Class::QuasiPeriodic);
        let covariant_config = self.analyses.covariant.filter(|_| aperiodic);
        let vectors = covariant_config.map(|config| {
            covariant_vectors(model, kernel, &trajectory, &config, self.seed, interrupt)
        });
        let covariant = match vectors {
            None => None,
            Some(Ok(vectors)) => Some(vectors),
            Some(Err(CovariantError::Interrupted(interrupt))) => return Err(interrupt),
            Some(Err(error)) => {
                let reason = &mut outcome.reason;
                reason.push_str(&format!(" (no covariant vectors: {error})"));
                None
            }
        };
        outcome.cycles += covariant.iter().map(|c| c.cycles).sum::<u64>();
        laps.end(Step::Covariant, covariant.is_some());
        // An interrupted integration may look like one without results.
        Interrupted::check(interrupt)?;
        Ok(PointResult {
            outcome,
            multistability,
            orbits,
            horizon,
            covariant,
            mesh: self.mesh,
            kernel: self.kernel,
            times: laps.times,
            end: whole.then_some(ChainEnd {
                state: self.model.basis.turned_modes(&trajectory.state),
                cycle: trajectory.cycle,
            }),
        })
    }
}
