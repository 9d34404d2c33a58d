//! Which kernel integrates a point, with which tables? Which kernels has a run used?

use super::build::{BuildError, check_window_count};
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
    /// The chosen kernel.
    pub choice: KernelChoice,
    /// Reason for the choice, if the program chose it.
    pub why: Option<Why>,
    /// Setting in the manifest.
    setting: KernelSetting,
    /// The tables that were read when closed modes were chosen.
    systems: Option<Arc<KernelArrays>>,
    event_limit: u32,
}

impl PointKernel {
    /// The kernel that a point names, or the one for its model: the choice depends on the model alone, not on other
    /// points.
    ///
    /// # Errors
    /// The kernel takes too long for a mesh cycle of the model, or stored tables cannot be used.
    pub fn of(point: &PointSpec, model: &Model, parts: &Prepared) -> Result<Self, BuildError> {
        let run = &point.run;
        let (choice, why, systems) = match run.kernel {
            KernelSetting::Named(kernel) => (kernel, None, None),
            KernelSetting::Auto => {
                let (why, systems) = systems(model, run.portable, parts)?;
                let choice = match systems {
                    Some(_) => KernelChoice::ClosedModes,
                    None => KernelChoice::Volterra,
                };
                (choice, Some(why), systems)
            }
        };
        check_window_count(model, &choice)?;
        Ok(Self {
            choice,
            why,
            setting: run.kernel,
            systems,
            event_limit: run.event_limit,
        })
    }

    /// Another kernel for a point that reaches a set of closed contacts without a table, if the program may choose.
    fn instead(&self) -> Option<Self> {
        let (Some(Why::Met { .. }), KernelSetting::Auto) = (self.why, self.setting) else {
            return None;
        };
        Some(Self {
            choice: KernelChoice::Volterra,
            why: Some(Why::NoTable),
            systems: None,
            ..*self
        })
    }

    /// Builds the kernel for the model and uses it. If the motion reaches a set of closed contacts without a table,
    /// and the program may choose, the kernel `volterra` repeats the work.
    ///
    /// # Errors
    /// The kernel has no tables for the model.
    pub fn apply<U: KernelUse>(
        &self,
        model: &Model,
        parts: &Prepared,
        user: impl Fn(&Self) -> U,
    ) -> Result<U::Output, BuildError> {
        match (self.apply_once(model, parts, user(self)), self.instead()) {
            (Err(BuildError::Tables { .. }), Some(other)) => {
                other.apply_once(model, parts, user(&other))
            }
            (done, _) => done,
        }
    }

    fn apply_once<U: KernelUse>(
        &self,
        model: &Model,
        parts: &Prepared,
        user: U,
    ) -> Result<U::Output, BuildError> {
        let tables = || match &self.systems {
            Some(systems) => Ok(systems.clone()),
            None => parts.kernels().get(model),
        };
        let output = self.choice.apply(model, self.event_limit, tables, user);
        output.map_err(|error| BuildError::tables(error, model))
    }
}

/// Why closed modes suit a model, with their tables, or why they do not.
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
        ClosedModes::check_kept(model, &*systems)?;
        Ok(systems)
    };
    match parts.kernels().get(model).and_then(fits) {
        Ok(systems) => Ok((why, Some(systems))),
        Err(error) if error.concerns_the_model() => Ok((Why::Refused(error), None)),
        Err(error) => Err(BuildError::tables(error, model)),
    }
}

/// The kernels that integrated the points of a run, each with the number of points and the first of them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct KernelTally(BTreeMap<String, (u64, u64)>);

impl KernelTally {
    /// Counts a finished point, whether computed now or read from a journal.
    pub(super) fn count(&mut self, row: &PointRow) {
        // A point without a drive has no kernel.
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

    /// The kernels for the record of a run; empty if the manifest names one.
    pub(super) fn records(&self, job: &Job, parts: &Prepared) -> Vec<KernelRecord> {
        let record = |(kernel, &(points, first)): (&String, &(u64, u64))| {
            let point = job.points.at(first as usize);
            if let KernelSetting::Named(_) = point.run.kernel {
                return None;
            }
            let point_kernel = PointKernel::of(&point, &parts.model(&point).ok()?, parts).ok()?;
            let point_kernel = if point_kernel.choice.name() == kernel {
                point_kernel
            } else {
                point_kernel.instead()?
            };
            Some(KernelRecord {
                kernel: kernel.clone(),
                points,
                first_point: first,
                why: point_kernel.why?.to_string(),
            })
        };
        self.0.iter().filter_map(record).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::manifest;
    use crate::model::Release;
    use crate::propagate::Kernel;
    use crate::store::TableStore;
    use std::cell::RefCell;
    use std::path::Path;

    struct Nothing;

    impl KernelUse for Nothing {
        type Output = ();

        fn with<K: Kernel + Sync>(self, _: &K) {}
    }

    /// Without a table, the other kernel repeats the work if the program may choose. A named kernel reports the error.
    #[test]
    fn another_kernel_repeats_what_has_no_table() {
        let text = include_str!("../../../tests/data/oscillator.toml");
        let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data");
        let job = manifest::parse(text, "m.toml", &data).unwrap();
        let parts = Prepared::new(TableStore::in_memory());
        let mut model = parts.model(&job.points.at(0)).unwrap();
        // Tables cannot represent such contacts.
        for contact in &mut model.contacts {
            contact.release = Release::Force;
        }
        let tried = |setting| {
            let kernel = PointKernel {
                choice: KernelChoice::ClosedModes,
                why: Some(Why::Met { modes: 1, sets: 2 }),
                setting,
                systems: None,
                event_limit: 100,
            };
            let names = RefCell::new(Vec::new());
            let user = |kernel: &PointKernel| {
                names.borrow_mut().push(kernel.choice.name());
                Nothing
            };
            let done = kernel.apply(&model, &parts, user);
            (done.is_ok(), names.into_inner())
        };
        let both = vec!["closed_modes", "volterra"];
        assert_eq!(tried(KernelSetting::Auto), (true, both));
        let named = KernelSetting::Named(KernelChoice::ClosedModes);
        assert_eq!(tried(named), (false, vec!["closed_modes"]));
    }
}
