//! One point, from specification to answer; whatever goes wrong becomes part of the answer.

use super::build::{BuildError, Parts, affordable, horizon, initial, orbits, probes, questions};
use crate::analysis::{
    CalledOff, Class, HorizonError, HorizonOutcome, HorizonQuestion, MultistabilityOutcome,
    MultistabilityQuestion, OrbitQuestion, OrbitSurvey, PointOutcome, Questions, Status,
    investigate_onward, predictability, probe_basins, survey_orbits,
};
use crate::manifest::{KernelSpec, Ladder, PointSpec};
use crate::model::{Model, TrajectoryState};
use crate::propagate::{
    DenseError, Dyadic, Fused, Hermite, Interruptible, Kernel, Spectral, Stepping, Volterra,
};
use crate::store::{ChainEnd, KeptKernel, Placement, PointRow};
use crate::topology::Topology;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Who computes.
#[derive(Debug, Clone, Copy)]
pub struct Worker<'a> {
    /// Its number, from 0.
    pub index: u32,
    /// The machine, where it is known.
    pub topology: Option<&'a Topology>,
}

/// What was found of a point.
#[derive(Debug)]
pub(super) struct Answer {
    pub outcome: PointOutcome,
    pub multistability: Option<MultistabilityOutcome>,
    pub orbits: Option<OrbitSurvey>,
    pub horizon: Option<HorizonOutcome>,
    /// Where the march ended; none where it diverged or was never begun.
    pub end: Option<ChainEnd>,
}

impl Answer {
    fn failed(reason: String) -> Self {
        Self {
            outcome: PointOutcome::unanswered(Status::Failed, reason),
            multistability: None,
            orbits: None,
            horizon: None,
            end: None,
        }
    }
}

/// Answers a point, from `run.initial` or from where another point ended. A model that
/// cannot be built, and a panic, give the status `failed` and the reason.
pub(super) fn attempt(
    point: &PointSpec,
    start: Option<&ChainEnd>,
    seed: u64,
    parts: &Parts,
    called_off: &AtomicBool,
) -> Result<Answer, CalledOff> {
    let attempt = catch_unwind(AssertUnwindSafe(|| {
        answer(point, start, seed, parts, called_off)
    }));
    match attempt {
        Ok(Ok(answered)) => answered,
        Ok(Err(error)) => Ok(Answer::failed(error.to_string())),
        Err(panic) => {
            let message = panic
                .downcast_ref::<String>()
                .map(String::as_str)
                .or_else(|| panic.downcast_ref::<&str>().copied())
                .unwrap_or("no message");
            Ok(Answer::failed(format!("the program panicked: {message}")))
        }
    }
}

/// The row of an answered point that belongs to no chain.
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
        kernel: kernel_name(&point.run.kernel).to_owned(),
        placement: Placement {
            worker: worker.index,
            numa_node: worker.topology.and_then(Topology::current_numa_node),
            wall_time: clock.elapsed().as_secs_f64(),
        },
    }
}

/// A kernel's name as manifests and result files have it.
pub fn kernel_name(kernel: &KernelSpec) -> &'static str {
    match kernel {
        KernelSpec::Volterra { .. } => "volterra",
        KernelSpec::Stepping { .. } => "stepping",
        KernelSpec::Tables { ladder, .. } => ladder.name(),
    }
}

fn answer(
    point: &PointSpec,
    start: Option<&ChainEnd>,
    seed: u64,
    parts: &Parts,
    called_off: &AtomicBool,
) -> Result<Result<Answer, CalledOff>, BuildError> {
    let model: Model = parts.model(point)?;
    affordable(&model, &point.run.kernel)?;
    let own = model.start(&initial(&point.run.initial));
    let start = match start {
        Some(end) => TrajectoryState::new(&model, end.state.clone(), end.cycle),
        None => own.clone(),
    };
    let asked = Asked {
        questions: questions(point, seed),
        probes: probes(&model, point, seed)?,
        orbits: orbits(point),
        horizon: horizon(point, seed),
    };
    let limit = point.run.event_limit;
    let unfit = |error: DenseError| BuildError::tables(error, &model);
    let kept = |kernel, cells| {
        let fetched = parts.kernels().get(kernel, &model, cells);
        fetched.map_err(|error| BuildError::tables(error, &model))
    };
    Ok(match point.run.kernel {
        KernelSpec::Volterra { tolerance } => {
            let kernel = Volterra::new(&model, tolerance, limit);
            ask(&model, &kernel, [start, own], &asked, called_off)
        }
        KernelSpec::Stepping { steps } => {
            let kernel = Stepping::new(&model, steps, limit);
            ask(&model, &kernel, [start, own], &asked, called_off)
        }
        KernelSpec::Tables { ladder, cells } => match ladder {
            Ladder::Dyadic => {
                let kernel = Dyadic::new(&model, cells, limit).map_err(unfit)?;
                ask(&model, &kernel, [start, own], &asked, called_off)
            }
            Ladder::Hermite => {
                let kernel = Hermite::new(&model, cells, limit).map_err(unfit)?;
                ask(&model, &kernel, [start, own], &asked, called_off)
            }
            Ladder::Spectral { event_grid } => {
                let tables = kept(KeptKernel::Spectral, cells)?;
                let kernel =
                    Spectral::of_kept(&model, cells, limit, event_grid, &*tables).map_err(unfit)?;
                ask(&model, &kernel, [start, own], &asked, called_off)
            }
            Ladder::Fused => {
                let tables = kept(KeptKernel::Fused, cells)?;
                let kernel = Fused::of_kept(&model, cells, limit, &*tables).map_err(unfit)?;
                ask(&model, &kernel, [start, own], &asked, called_off)
            }
        },
    })
}

/// What is asked of a point.
struct Asked {
    questions: Questions,
    probes: Option<MultistabilityQuestion>,
    orbits: Option<OrbitQuestion>,
    horizon: Option<HorizonQuestion>,
}

/// All questions to a point, then its probes (which start about `run.initial` even where the
/// point does not), its orbits and its horizon.
fn ask<K: Kernel + Sync>(
    model: &Model,
    kernel: &K,
    [start, own]: [TrajectoryState; 2],
    asked: &Asked,
    called_off: &AtomicBool,
) -> Result<Answer, CalledOff> {
    let kernel = &Interruptible::new(kernel, called_off);
    let mut trajectory = start;
    let mut outcome =
        investigate_onward(model, kernel, &mut trajectory, &asked.questions, called_off)?;
    let multistability = asked
        .probes
        .as_ref()
        .map(|probes| probe_basins(model, kernel, &own, probes, called_off))
        .transpose()?;
    outcome.cycles += multistability.iter().map(|m| m.cycles()).sum::<u64>();
    let whole = matches!(outcome.status, Status::Ok | Status::NotConverged);
    // The survey's own march is no part of the chain.
    let orbits = match &asked.orbits {
        Some(question) if whole => {
            let mut onward = trajectory.clone();
            let found = survey_orbits(model, kernel, &mut onward, question, called_off)?;
            outcome.cycles += found.cycles;
            Some(found)
        }
        _ => None,
    };
    let chaotic = whole && outcome.class == Some(Class::Chaotic);
    let horizon = match asked.horizon.filter(|_| chaotic) {
        None => None,
        Some(question) => match predictability(model, kernel, &trajectory, &question, called_off) {
            Ok(found) => Some(found),
            Err(HorizonError::CalledOff(called_off)) => return Err(called_off),
            Err(HorizonError::Stop(stop)) => {
                outcome.reason.push_str(&format!(" (no horizon: {stop})"));
                None
            }
        },
    };
    outcome.cycles += horizon.iter().map(|h| h.cycles).sum::<u64>();
    // A march that was cut short may have been taken for one that found nothing.
    CalledOff::check(called_off)?;
    Ok(Answer {
        outcome,
        multistability,
        orbits,
        horizon,
        end: whole.then_some(ChainEnd {
            state: trajectory.state,
            cycle: trajectory.cycle,
        }),
    })
}
