//! The kernels by name, each with its settings: the one place that tells them apart.

use super::{
    ClosedModes, DenseError, Dyadic, Fused, Hermite, InstructionSet, KeptTables, Kernel, Spectral,
    Stepping, TableArray, Volterra,
};
use crate::model::Model;
use serde::Serialize;
use std::ops::Deref;
use strum::{EnumCount, IntoStaticStr};

/// A kernel and its settings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, IntoStaticStr, EnumCount)]
#[strum(serialize_all = "snake_case")]
pub enum KernelChoice {
    /// The structured kernel.
    Volterra,
    /// Each set of closed contacts in its own eigenvectors.
    ClosedModes,
    /// Fixed small steps.
    Stepping {
        /// Steps a mesh cycle.
        steps: u32,
    },
    /// Dense tables, halved down to an event.
    Dyadic {
        /// Fewest unit steps a mesh cycle.
        cells: u32,
    },
    /// Dense tables, with certificates and Hermite guesses.
    Hermite {
        /// Fewest unit steps a mesh cycle.
        cells: u32,
    },
    /// Dense tables, closed forms in eigenvectors.
    Spectral {
        /// Fewest unit steps a mesh cycle.
        cells: u32,
        /// Events are put off to the next of so many equal parts of the cycle.
        event_grid: Option<u32>,
    },
    /// The same, and certified runs of cells in one product.
    Fused {
        /// Fewest unit steps a mesh cycle.
        cells: u32,
    },
}

/// Tables that are worth keeping.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KernelTable {
    /// Bases of a structure and its mesh: of [`Spectral`] and of [`Fused`], at every speed.
    Bases,
    /// Eigenvectors of each set of closed contacts, at every speed: of [`ClosedModes`].
    Systems,
    /// Products of cells at one speed: of [`Fused`].
    Runs {
        /// Fewest unit steps a mesh cycle.
        cells: u32,
    },
}

impl KernelTable {
    /// Computes a table of a model, as arrays.
    ///
    /// # Errors
    /// Tables do not fit the model.
    pub fn arrays(self, model: &Model) -> Result<Vec<TableArray>, DenseError> {
        match self {
            Self::Bases => Spectral::arrays(model),
            Self::Systems => ClosedModes::arrays(model),
            Self::Runs { cells } => Fused::arrays(model, cells),
        }
    }
}

/// What is done with a kernel, whichever it is.
pub trait KernelUse {
    /// What comes of it.
    type Output;

    /// Does it.
    fn with<K: Kernel + Sync>(self, kernel: &K) -> Self::Output;
}

impl KernelChoice {
    /// Names of all kernels, each with the settings that it has in `[run]`.
    pub const SETTINGS: [(&'static str, &'static [&'static str]); Self::COUNT] = [
        ("volterra", &[]),
        ("closed_modes", &[]),
        ("stepping", &["steps"]),
        ("dyadic", &["cells"]),
        ("hermite", &["cells"]),
        ("spectral", &["cells", "event_grid"]),
        ("fused", &["cells"]),
    ];

    /// Its name in manifests and result files.
    pub fn name(&self) -> &'static str {
        self.into()
    }

    /// Fewest unit steps of its tables a mesh cycle; none of a kernel without tables.
    pub fn cells(&self) -> Option<u32> {
        match *self {
            Self::Volterra | Self::ClosedModes | Self::Stepping { .. } => None,
            Self::Dyadic { cells }
            | Self::Hermite { cells }
            | Self::Spectral { cells, .. }
            | Self::Fused { cells } => Some(cells),
        }
    }

    /// Whether it reads tables that are kept.
    pub fn keeps_tables(&self) -> bool {
        self.cells().is_some() || *self == Self::ClosedModes
    }

    /// Builds the kernel of a model and uses it.
    ///
    /// * `event_limit`: most events in a mesh cycle before integration stops.
    /// * `kept`: hands over kept tables.
    ///
    /// # Errors
    /// Tables do not fit the model, or kept ones cannot be had.
    pub fn apply<U, T, E>(
        self,
        model: &Model,
        event_limit: u32,
        kept: impl Fn(KernelTable) -> Result<T, E>,
        user: U,
    ) -> Result<U::Output, E>
    where
        U: KernelUse,
        T: Deref<Target: KeptTables + Sized>,
        E: From<DenseError>,
    {
        Ok(match self {
            Self::Volterra => user.with(&Volterra::new(model, f64::EPSILON, event_limit)),
            Self::ClosedModes => {
                let systems = kept(KernelTable::Systems)?;
                let set = InstructionSet::best();
                let kernel = ClosedModes::of_kept(model, event_limit, &*systems, set)?;
                let done = user.with(&kernel);
                // Part of what was to be done is missing.
                kernel.refusal().map_or(Ok(done), Err)?
            }
            Self::Stepping { steps } => user.with(&Stepping::new(model, steps, event_limit)),
            Self::Dyadic { cells } => user.with(&Dyadic::new(model, cells, event_limit)?),
            Self::Hermite { cells } => user.with(&Hermite::new(model, cells, event_limit)?),
            Self::Spectral { cells, event_grid } => {
                let bases = kept(KernelTable::Bases)?;
                user.with(&Spectral::of_kept(
                    model,
                    cells,
                    event_limit,
                    event_grid,
                    &*bases,
                )?)
            }
            Self::Fused { cells } => {
                let (bases, runs) = (
                    kept(KernelTable::Bases)?,
                    kept(KernelTable::Runs { cells })?,
                );
                let kernel = Fused::of_kept(model, cells, event_limit, [&*bases, &*runs])?;
                user.with(&kernel)
            }
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
            KernelChoice::Dyadic { cells: 1 },
            KernelChoice::Hermite { cells: 1 },
            KernelChoice::Spectral {
                cells: 1,
                event_grid: None,
            },
            KernelChoice::Fused { cells: 1 },
        ];
        for (kernel, (name, settings)) in all.iter().zip(KernelChoice::SETTINGS) {
            assert_eq!(kernel.name(), name);
            assert_eq!(kernel.cells().is_some(), settings.contains(&"cells"));
        }
    }
}
