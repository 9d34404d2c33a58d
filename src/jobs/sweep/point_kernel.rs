//! Which kernel integrates a point, with which tables, and which kernels a run has taken.

use super::build::{BuildError, affordable};
use super::parts::Prepared;
use crate::manifest::{Job, PointSpec};
use crate::model::Model;
use crate::propagate::{ClosedModes, KernelChoice, KernelSetting};
use crate::propagate::{KernelUse, Why};
use crate::store::{KernelArrays, KernelRecord, PointRow};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The kernel of a point.
#[derive(Debug)]
pub struct PointKernel {
    /// The one that integrates it.
    pub taken: KernelChoice,
    /// Why, where the manifest leaves it to the program.
    pub why: Option<Why>,
    /// What the manifest says.
    asked: KernelSetting,
    /// The tables that decided for closed modes.
    systems: Option<Arc<KernelArrays>>,
    event_limit: u32,
}

impl PointKernel {
    /// The kernel that a point names, or the one that its model gets: a model decides alone, whatever other points get.
    ///
    /// # Errors
    /// The kernel does not get through a mesh cycle of the model, or kept tables cannot be used.
    pub fn of(point: &PointSpec, model: &Model, parts: &Prepared) -> Result<Self, BuildError> {
        let run = &point.run;
        let (taken, why, systems) = match run.kernel {
            KernelSetting::Named(kernel) => (kernel, None, None),
            KernelSetting::Auto => {
                let (why, systems) = systems(model, run.portable, parts)?;
                let taken = match systems {
                    Some(_) => KernelChoice::ClosedModes,
                    None => KernelChoice::Volterra,
                };
                (taken, Some(why), systems)
            }
        };
        affordable(model, &taken)?;
        Ok(Self {
            taken,
            why,
            asked: run.kernel,
            systems,
            event_limit: run.event_limit,
        })
    }

    /// The kernel of a point that comes to a set of closed contacts without a table, where the program may choose.
    pub fn instead(&self) -> Option<Self> {
        let (Some(Why::Met { .. }), KernelSetting::Auto) = (self.why, self.asked) else {
            return None;
        };
        Some(Self {
            taken: KernelChoice::Volterra,
            why: Some(Why::NoTable),
            systems: None,
            ..*self
        })
    }

    /// Builds the kernel of the same model and uses it.
    ///
    /// # Errors
    /// There are no tables of the kernel for the model.
    pub fn apply<U: KernelUse>(
        &self,
        model: &Model,
        parts: &Prepared,
        user: U,
    ) -> Result<U::Output, BuildError> {
        let kept = || match &self.systems {
            Some(systems) => Ok(systems.clone()),
            None => parts.kernels().get(model),
        };
        let done = self.taken.apply(model, self.event_limit, kept, user);
        done.map_err(|error| BuildError::tables(error, model))
    }
}

/// Why a model gets closed modes, with their tables, or why it does not.
fn systems(
    model: &Model,
    portable: bool,
    parts: &Prepared,
) -> Result<(Why, Option<Arc<KernelArrays>>), BuildError> {
    let why = Why::of(model, portable);
    if !matches!(why, Why::Small { .. } | Why::Met { .. }) {
        return Ok((why, None));
    }
    let fits = |systems: Arc<KernelArrays>| {
        ClosedModes::takes(model, &*systems)?;
        Ok(systems)
    };
    match parts.kernels().get(model).and_then(fits) {
        Ok(systems) => Ok((why, Some(systems))),
        Err(error) if error.concerns_the_model() => Ok((Why::Refused(error), None)),
        Err(error) => Err(BuildError::tables(error, model)),
    }
}

/// Which kernels integrated the points of a run: of how many each, and the first of them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct KernelTally(BTreeMap<String, (u64, u64)>);

impl KernelTally {
    /// Counts a finished point, computed now or taken over.
    pub(super) fn count(&mut self, row: &PointRow) {
        // A point without a drive got no kernel.
        if row.kernel == KernelSetting::AUTO {
            return;
        }
        match self.0.get_mut(&row.kernel) {
            Some((points, first)) => {
                *points += 1;
                *first = row.point_id.min(*first);
            }
            None => {
                self.0.insert(row.kernel.clone(), (1, row.point_id));
            }
        }
    }

    /// What a record says of them; nothing of a kernel that the manifest names.
    pub(super) fn records(&self, job: &Job, parts: &Prepared) -> Vec<KernelRecord> {
        let record = |(kernel, &(points, first)): (&String, &(u64, u64))| {
            let point = job.points.at(first as usize);
            let own = PointKernel::of(&point, &parts.model(&point).ok()?, parts).ok()?;
            let own = if own.taken.name() == kernel { own } else { own.instead()? };
            Some(KernelRecord {
                kernel: kernel.clone(),
                points,
                first_point: first,
                why: own.why?.to_string(),
            })
        };
        self.0.iter().filter_map(record).collect()
    }
}
