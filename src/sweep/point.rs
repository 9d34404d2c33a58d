//! One point, from specification to row; whatever goes wrong becomes part of the row.

use super::build::{BuildError, StructureCache, affordable, initial, model, probes, questions};
use crate::analysis::{
    CalledOff, MultistabilityOutcome, MultistabilityQuestion, PointOutcome, Questions, Status,
    investigate, probe_basins,
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
    let (outcome, multistability) = match attempt {
        Ok(Ok(answered)) => answered?,
        Ok(Err(error)) => (
            PointOutcome::unanswered(Status::Failed, error.to_string()),
            None,
        ),
        Err(panic) => {
            let message = panic
                .downcast_ref::<String>()
                .map(String::as_str)
                .or_else(|| panic.downcast_ref::<&str>().copied())
                .unwrap_or("no message");
            (
                PointOutcome::unanswered(
                    Status::Failed,
                    format!("the program panicked: {message}"),
                ),
                None,
            )
        }
    };
    Ok(PointRow {
        point_id: point.point_id,
        axis_values: point.axis_values.clone(),
        outcome,
        multistability,
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

/// What was found of a point and, where asked for, of its probes.
type Answer = (PointOutcome, Option<MultistabilityOutcome>);

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
    let asked = (questions(point, seed), probes(&model, point, seed)?);
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

/// All questions to a point, then its probes.
fn ask<K: Kernel + Sync>(
    model: &Model,
    kernel: &K,
    start: TrajectoryState,
    (questions, probes): &(Questions, Option<MultistabilityQuestion>),
    called_off: &AtomicBool,
) -> Result<Answer, CalledOff> {
    let mut outcome = investigate(model, kernel, start.clone(), questions, called_off)?;
    let multistability = probes
        .as_ref()
        .map(|probes| probe_basins(model, kernel, &start, probes, called_off))
        .transpose()?;
    outcome.cycles += multistability.iter().map(|m| m.cycles()).sum::<u64>();
    Ok((outcome, multistability))
}
