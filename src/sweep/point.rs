//! One point, from specification to row; whatever goes wrong becomes part of the row.

use super::build::{
    BuildError, StructureCache, affordable, horizon, initial, model, probes, questions,
};
use crate::analysis::{
    CalledOff, Class, HorizonError, HorizonOutcome, HorizonQuestion, MultistabilityOutcome,
    MultistabilityQuestion, PointOutcome, Questions, Status, investigate_onward, predictability,
    probe_basins,
};
use crate::manifest::{KernelSpec, PointSpec};
use crate::model::{Model, TrajectoryState};
use crate::propagate::{Kernel, Stepping, Volterra};
use crate::store::{Placement, PointRow};
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

/// Computes a point. A model that cannot be built, and a panic, give a row with status
/// `failed` and the reason.
///
/// # Errors
/// [`CalledOff`] when `called_off` was raised meanwhile.
pub fn compute(
    point: &PointSpec,
    seed: u64,
    structures: &StructureCache,
    worker: Worker<'_>,
    called_off: &AtomicBool,
) -> Result<PointRow, CalledOff> {
    let clock = Instant::now();
    let attempt = catch_unwind(AssertUnwindSafe(|| {
        answer(point, seed, structures, called_off)
    }));
    let unanswered = |reason: String| Answer {
        outcome: PointOutcome::unanswered(Status::Failed, reason),
        multistability: None,
        horizon: None,
    };
    let answer = match attempt {
        Ok(Ok(answered)) => answered?,
        Ok(Err(error)) => unanswered(error.to_string()),
        Err(panic) => {
            let message = panic
                .downcast_ref::<String>()
                .map(String::as_str)
                .or_else(|| panic.downcast_ref::<&str>().copied())
                .unwrap_or("no message");
            unanswered(format!("the program panicked: {message}"))
        }
    };
    Ok(PointRow {
        point_id: point.point_id,
        axis_values: point.axis_values.clone(),
        outcome: answer.outcome,
        multistability: answer.multistability,
        horizon: answer.horizon,
        kernel: kernel_name(&point.run.kernel).to_owned(),
        placement: Placement {
            worker: worker.index,
            numa_node: worker.topology.and_then(Topology::current_numa_node),
            wall_time: clock.elapsed().as_secs_f64(),
        },
    })
}

/// A kernel's name as manifests and result files have it.
pub fn kernel_name(kernel: &KernelSpec) -> &'static str {
    match kernel {
        KernelSpec::Volterra { .. } => "volterra",
        KernelSpec::Stepping { .. } => "stepping",
    }
}

/// What was found of a point and, where asked for, of its probes and its predictability.
struct Answer {
    outcome: PointOutcome,
    multistability: Option<MultistabilityOutcome>,
    horizon: Option<HorizonOutcome>,
}

/// What is asked of a point.
struct Asked {
    questions: Questions,
    probes: Option<MultistabilityQuestion>,
    horizon: Option<HorizonQuestion>,
}

fn answer(
    point: &PointSpec,
    seed: u64,
    structures: &StructureCache,
    called_off: &AtomicBool,
) -> Result<Result<Answer, CalledOff>, BuildError> {
    let structure = structures.get(&point.model)?;
    let model: Model = model(&structure, point)?;
    affordable(&model, &point.run.kernel)?;
    let start = model.start(&initial(&point.run.initial));
    let asked = Asked {
        questions: questions(point, seed),
        probes: probes(point, seed),
        horizon: horizon(point, seed),
    };
    let limit = point.run.event_limit;
    Ok(match point.run.kernel {
        KernelSpec::Volterra { tolerance } => {
            let kernel = Volterra::new(&model, tolerance, limit);
            ask(&model, &kernel, start, &asked, called_off)
        }
        KernelSpec::Stepping { steps } => {
            let kernel = Stepping::new(&model, steps, limit);
            ask(&model, &kernel, start, &asked, called_off)
        }
    })
}

/// All questions to a point, then its predictability, then its probes.
fn ask<K: Kernel>(
    model: &Model,
    kernel: &K,
    start: TrajectoryState,
    asked: &Asked,
    called_off: &AtomicBool,
) -> Result<Answer, CalledOff> {
    let mut end = start.clone();
    let mut outcome = investigate_onward(model, kernel, &mut end, &asked.questions, called_off)?;
    let chaotic = outcome.class == Some(Class::Chaotic);
    let horizon = match asked.horizon.filter(|_| chaotic) {
        None => None,
        Some(question) => match predictability(model, kernel, &end, &question, called_off) {
            Ok(found) => Some(found),
            Err(HorizonError::CalledOff(called_off)) => return Err(called_off),
            Err(HorizonError::Stop(stop)) => {
                outcome.reason.push_str(&format!(" (no horizon: {stop})"));
                None
            }
        },
    };
    let multistability = (asked.probes.as_ref())
        .map(|probes| probe_basins(model, kernel, &start, probes, called_off))
        .transpose()?;
    outcome.cycles += multistability.iter().map(|m| m.cycles()).sum::<u64>();
    outcome.cycles += horizon.iter().map(|h| h.cycles).sum::<u64>();
    Ok(Answer {
        outcome,
        multistability,
        horizon,
    })
}
