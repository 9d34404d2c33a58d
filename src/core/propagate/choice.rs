//! The kernels by name, with their settings and how each is built.

use super::{ClosedModes, InstructionSet, KeptTables, Kernel, Stepping, TableError, Volterra};
use crate::model::Model;
use serde::Serialize;
use std::ops::Deref;
use strum::{EnumCount, IntoStaticStr};

/// A kernel and its settings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, IntoStaticStr, EnumCount)]
#[strum(serialize_all = "snake_case")]
pub enum KernelChoice {
    /// The structured kernel: a Volterra equation for the contact force on each window.
    Volterra,
    /// The motion in the eigenvectors of the system with the present set of closed contacts.
    ClosedModes,
    /// Fixed small steps.
    Stepping {
        /// Steps per mesh cycle.
        steps: u32,
    },
}

/// An operation with any kernel.
pub trait KernelUse {
    /// Its result.
    type Output;

    /// Performs the operation.
    fn with<K: Kernel + Sync>(self, kernel: &K) -> Self::Output;
}

impl KernelChoice {
    /// Names of all kernels, each with its settings in `[run]`.
    pub const SETTINGS: [(&'static str, &'static [&'static str]); Self::COUNT] = [
        ("volterra", &[]),
        ("closed_modes", &[]),
        ("stepping", &["steps"]),
    ];

    /// Its name in manifests and result files.
    pub fn name(&self) -> &'static str {
        self.into()
    }

    /// Whether it reads kept tables.
    pub fn keeps_tables(&self) -> bool {
        *self == Self::ClosedModes
    }

    /// Builds the kernel of a model and uses it.
    ///
    /// * `event_limit`: largest number of events in a mesh cycle before integration stops.
    /// * `kept`: returns the stored tables; called for [`ClosedModes`] only.
    ///
    /// # Errors
    /// The kernel does not support the model, kept tables do not fit it or could not be loaded or computed, or the
    /// motion reached a set of closed contacts without a table.
    pub fn apply<U, T, E>(
        self,
        model: &Model,
        event_limit: u32,
        kept: impl FnOnce() -> Result<T, E>,
        user: U,
    ) -> Result<U::Output, E>
    where
        U: KernelUse,
        T: Deref<Target: KeptTables + Sized>,
        E: From<TableError>,
    {
        Ok(match self {
            Self::Volterra => user.with(&Volterra::new(model, f64::EPSILON, event_limit)),
            Self::ClosedModes => {
                let systems = kept()?;
                let set = InstructionSet::best();
                let kernel = ClosedModes::from_kept(model, event_limit, &*systems, set)?;
                let done = user.with(&kernel);
                // If a set of closed contacts has no table, part of the result is missing.
                kernel.refusal().map_or(Ok(done), Err)?
            }
            Self::Stepping { .. } if !model.sliders.is_empty() => {
                return Err(TableError::Slider.into());
            }
            Self::Stepping { .. } if !model.stops.is_empty() => {
                return Err(TableError::RigidStop.into());
            }
            Self::Stepping { .. } if !model.frictions.is_empty() => {
                return Err(TableError::DryFriction.into());
            }
            Self::Stepping { .. } if model.has_negative_stiffness() => {
                return Err(TableError::Softening.into());
            }
            Self::Stepping { .. } if model.film_layers > 0 => return Err(TableError::Film.into()),
            Self::Stepping { steps } => user.with(&Stepping::new(model, steps, event_limit)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kernel_stands_in_the_list_with_its_own_settings() {
        let all = [
            KernelChoice::Volterra,
            KernelChoice::ClosedModes,
            KernelChoice::Stepping { steps: 16 },
        ];
        for (kernel, (name, settings)) in all.iter().zip(KernelChoice::SETTINGS) {
            assert_eq!(kernel.name(), name);
            let steps = matches!(kernel, KernelChoice::Stepping { .. });
            assert_eq!(settings, if steps { &["steps"][..] } else { &[] });
        }
    }
}
