//! Computes one point, from specification to answer; every failure becomes part of the answer.

use super::build::{BuildError, questions};
use super::carried::CarriedState;
use super::parts::Prepared;
use super::point_kernel::PointKernel;
use crate::analysis::{
    Analyses, CalledOff, Class, CovariantError, CovariantOutcome, HorizonError, HorizonOutcome,
    MultistabilityOutcome, OrbitSurvey, PointConfig, PointOutcome, Probes, Status,
    covariant_vectors, investigate_onward, predictability, probe_basins, survey_orbits,
};
use crate::manifest::PointSpec;
use crate::model::{Model, TrajectoryState};
use crate::numerics::random::PointSeed;
use crate::propagate::{Interruptible, Kernel, KernelUse};
use crate::store::{ChainEnd, MeshUnderLoad, Placement, PointRow};
use crate::topology::{ProcessorClock, Topology};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// The worker that computes a point.
#[derive(Debug, Clone, Copy)]
pub struct Worker<'a> {
    /// Number, from 0.
    pub index: u32,
    /// The machine, if known.
    pub topology: Option<&'a Topology>,
}

/// The results of a point.
#[derive(Debug)]
pub(super) struct Answer {
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
pub(super) type Times = [f64; 6];

/// Measures the times of steps.
struct Laps {
    clock: ProcessorClock,
    last: f64,
    times: Times,
}

impl Laps {
    fn new(clock: ProcessorClock) -> Self {
        Self {
            clock,
            last: clock.now(),
            times: Times::default(),
        }
    }

    /// Ends `step` and starts the next one. Reading the clock takes time, so it is omitted if the step was not
    /// requested.
    fn end(&mut self, step: Step, asked: bool) {
        if !asked {
            return;
        }
        let now = self.clock.now();
        self.times[step as usize] = now - self.last;
        self.last = now;
    }
}

impl Answer {
    fn failed(point: &PointSpec, reason: String) -> Self {
        Self {
            outcome: PointOutcome::unanswered(Status::Failed, reason),
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

/// Computes a point, from `run.initial` or from the end of another point. A model that cannot be built, or a panic,
/// gives the status `failed` and the reason.
pub(super) fn attempt(
    point: &PointSpec,
    start: Option<CarriedState<'_>>,
    parts: &Prepared,
    called_off: &AtomicBool,
) -> Result<Answer, CalledOff> {
    let attempt = catch_unwind(AssertUnwindSafe(|| answer(point, start, parts, called_off)));
    match attempt {
        Ok(Ok(answered)) => answered,
        Ok(Err(error)) => Ok(Answer::failed(point, error.to_string())),
        Err(panic) => {
            let message = panic
                .downcast_ref::<String>()
                .map(String::as_str)
                .or_else(|| panic.downcast_ref::<&str>().copied())
                .unwrap_or("no message");
            let reason = format!("the program panicked: {message}");
            Ok(Answer::failed(point, reason))
        }
    }
}

/// The row of a computed point that belongs to no chain.
pub(super) fn row(
    point: &PointSpec,
    answer: Answer,
    worker: Worker<'_>,
    clock: Instant,
) -> PointRow {
    PointRow {
        point_id: point.point_id,
        axis_values: point.axis_values.clone(),
        outcome: answer.outcome,
        multistability: answer.multistability,
        orbits: answer.orbits,
        chain: None,
        horizon: answer.horizon,
        covariant: answer.covariant,
        mesh: answer.mesh,
        kernel: answer.kernel.to_owned(),
        placement: Placement {
            worker: worker.index,
            numa_node: worker.topology.and_then(Topology::current_numa_node),
            wall_time: clock.elapsed().as_secs_f64(),
        },
    }
}

fn answer(
    point: &PointSpec,
    start: Option<CarriedState<'_>>,
    parts: &Prepared,
    called_off: &AtomicBool,
) -> Result<Result<Answer, CalledOff>, BuildError> {
    let (model, mesh) = parts.model_and_mesh(point)?;
    let kernel = PointKernel::of(point, &model, parts)?;
    let own = model.start(&point.run.initial);
    let seed = PointSeed {
        seed: point.seed,
        point_id: point.point_id,
    };
    let start = match start {
        Some(carried) => carried.start(&model, seed),
        None => own.clone(),
    };
    let probes = (point.analyses.multistability)
        .map(|asked| Probes::new(&model, asked, seed, point.run.settle))
        .transpose()?;
    let ask = |kernel: &PointKernel| Ask {
        model: &model,
        kernel: kernel.taken.name(),
        start: start.clone(),
        own: own.clone(),
        mesh,
        questions: questions(point, seed),
        probes: probes.clone(),
        analyses: &point.analyses,
        seed,
        called_off,
    };
    match (kernel.apply(&model, parts, ask(&kernel)), kernel.instead()) {
        (Err(BuildError::Tables { .. }), Some(other)) => other.apply(&model, parts, ask(&other)),
        (done, _) => done,
    }
}

/// All requests to a point.
struct Ask<'a> {
    model: &'a Model,
    /// Name of its kernel.
    kernel: &'static str,
    /// Its mesh under the mean load.
    mesh: Option<MeshUnderLoad>,
    /// Start of the point's trajectory.
    start: TrajectoryState,
    /// The start from `run.initial`, around which probes start.
    own: TrajectoryState,
    questions: PointConfig,
    probes: Option<Probes>,
    analyses: &'a Analyses,
    seed: PointSeed,
    called_off: &'a AtomicBool,
}

impl KernelUse for Ask<'_> {
    type Output = Result<Answer, CalledOff>;

    fn with<K: Kernel + Sync>(self, kernel: &K) -> Self::Output {
        let Self {
            model, called_off, ..
        } = self;
        let kernel = &Interruptible::new(kernel, called_off);
        let mut laps = Laps::new(match self.probes {
            Some(_) => ProcessorClock::Process,
            None => ProcessorClock::Thread,
        });
        let mut trajectory = self.start;
        let mut outcome =
            investigate_onward(model, kernel, &mut trajectory, &self.questions, called_off)?;
        laps.end(Step::Integration, true);
        let multistability = (self.probes.as_ref())
            .map(|probes| probe_basins(model, kernel, &self.own, probes, called_off))
            .transpose()?;
        outcome.cycles += multistability.iter().map(|m| m.cycles()).sum::<u64>();
        laps.end(Step::Multistability, self.probes.is_some());
        let whole = matches!(outcome.status, Status::Ok | Status::NotConverged);
        // The integration of the survey is not part of the chain.
        let orbits = match &self.analyses.orbits {
            Some(question) if whole => {
                let mut onward = trajectory.clone();
                let found = survey_orbits(model, kernel, &mut onward, question, called_off)?;
                outcome.cycles += found.cycles;
                Some(found)
            }
            _ => None,
        };
        laps.end(Step::Orbits, orbits.is_some());
        let chaotic = whole && outcome.class.is_some_and(|class| class.is_chaos());
        let asked = self.analyses.horizon.filter(|_| chaotic);
        let measured = asked.map(|question| {
            predictability(model, kernel, &trajectory, &question, self.seed, called_off)
        });
        let horizon = match measured {
            None => None,
            Some(Ok(found)) => Some(found),
            Some(Err(HorizonError::CalledOff(called_off))) => return Err(called_off),
            Some(Err(HorizonError::Stop(stop))) => {
                outcome.reason.push_str(&format!(" (no horizon: {stop})"));
                None
            }
        };
        outcome.cycles += horizon.iter().map(|h| h.cycles).sum::<u64>();
        laps.end(Step::Horizon, horizon.is_some());
        let aperiodic = chaotic || whole && outcome.class == Some(Class::QuasiPeriodic);
        let asked = self.analyses.covariant.filter(|_| aperiodic);
        let found = asked.map(|question| {
            covariant_vectors(model, kernel, &trajectory, &question, self.seed, called_off)
        });
        let covariant = match found {
            None => None,
            Some(Ok(found)) => Some(found),
            Some(Err(CovariantError::CalledOff(called_off))) => return Err(called_off),
            Some(Err(error)) => {
                let reason = &mut outcome.reason;
                reason.push_str(&format!(" (no covariant vectors: {error})"));
                None
            }
        };
        outcome.cycles += covariant.iter().map(|c| c.cycles).sum::<u64>();
        laps.end(Step::Covariant, covariant.is_some());
        // An interrupted integration may look like one without results.
        CalledOff::check(called_off)?;
        Ok(Answer {
            outcome,
            multistability,
            orbits,
            horizon,
            covariant,
            mesh: self.mesh,
            kernel: self.kernel,
            times: laps.times,
            end: whole.then_some(ChainEnd {
                state: trajectory.state,
                cycle: trajectory.cycle,
            }),
        })
    }
}
