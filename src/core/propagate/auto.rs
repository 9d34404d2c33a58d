//! Which kernel does `run.kernel = "auto"` choose for a drive, and why?

use super::table_error::megabytes;
use super::{ClosedModes, KernelChoice, TableError, TableSize};
use crate::model::Model;
use serde::{Serialize, Serializer};
use std::fmt;
use strum::EnumCount;

/// The value of `run.kernel`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum KernelSetting {
    /// Closed modes if they support the drive and cost less ([`Why::of`]), else the structured kernel (`volterra`).
    Auto,
    /// A given kernel.
    Named(KernelChoice),
}

impl KernelSetting {
    /// The value of `run.kernel` that lets the program choose the kernel.
    pub const AUTO: &'static str = "auto";

    /// All values, each with its settings in `[run]`.
    pub const SETTINGS: [(&'static str, &'static [&'static str]); KernelChoice::COUNT + 1] = {
        let mut all = [(Self::AUTO, &[] as &[&str]); KernelChoice::COUNT + 1];
        let mut kernel = 0;
        while kernel < KernelChoice::COUNT {
            all[kernel] = KernelChoice::SETTINGS[kernel];
            kernel += 1;
        }
        all
    };

    /// Its name in manifests.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Auto => Self::AUTO,
            Self::Named(kernel) => kernel.name(),
        }
    }
}

impl Serialize for KernelSetting {
    /// A named kernel is serialized as [`KernelChoice`].
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Auto => Self::AUTO.serialize(serializer),
            Self::Named(kernel) => kernel.serialize(serializer),
        }
    }
}

/// Largest number of modes at which a cycle of closed modes costs less than one of the structured kernel
/// (`benches/runs/2026-11-26-closed-modes-a68263b`).
const MOST_MODES: usize = 24;

/// As [`MOST_MODES`], for more than [`ClosedModes::MOST_PRECOMPUTED`] contact sets. Measured at 24 modes
/// (`benches/runs/2026-11-26-meshes-9b525da8`), an estimate above.
const MOST_MODES_MET: usize = 80;

/// Largest number of contact sets at which closed modes cost less in measured runs. With more sets, a motion
/// reaches too many of them.
const MOST_SETS_MET: usize = 1 << 20;

/// Why `auto` chooses a kernel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Why {
    /// Closed modes: the drive is small enough.
    Small {
        /// Modes of the structure.
        modes: usize,
        /// Size of the tables.
        size: TableSize,
    },
    /// Closed modes: there are many contacts, but a motion will reach few of their sets.
    Met {
        /// Modes of the structure.
        modes: usize,
        /// Sets of closed contacts.
        sets: usize,
    },
    /// A motion has reached a set of closed contacts without a table.
    NoTable,
    /// Gyroscopic terms change the structure with the speed: every speed would need separate tables.
    Gyroscopic,
    /// The structured kernel costs less.
    ManyModes {
        /// Modes of the structure.
        modes: usize,
        /// Largest number of modes for which `auto` chooses closed modes.
        most: usize,
    },
    /// The structured kernel costs less: a motion reaches many sets, and closed modes compute each of them on
    /// demand.
    ManySets {
        /// Sets of closed contacts.
        sets: usize,
        /// Largest number of sets for which `auto` chooses closed modes.
        most: usize,
    },
    /// Results must have the same bits on every processor, but tables differ between processors.
    Portable,
    /// Closed modes do not support the drive.
    Refused(TableError),
}

impl Why {
    /// The reason for or against closed modes: [`Why::Small`] and [`Why::Met`] are for them.
    ///
    /// * `portable`: whether the bits must be the same on every processor.
    pub fn of(model: &Model, portable: bool) -> Self {
        let modes = model.modes();
        if portable {
            return Self::Portable;
        }
        let is_gyroscopic = model.basis.coupled().is_some_and(|coupled| coupled.turns);
        match ClosedModes::suits(model) {
            Err(error) => Self::Refused(error),
            Ok(_) if is_gyroscopic => Self::Gyroscopic,
            Ok(size) if size.systems > MOST_SETS_MET => Self::ManySets {
                sets: size.systems,
                most: MOST_SETS_MET,
            },
            Ok(size) => {
                let few = size.systems <= ClosedModes::MOST_PRECOMPUTED;
                let most = if few { MOST_MODES } else { MOST_MODES_MET };
                if modes <= most {
                    Self::of_tables(modes, size)
                } else {
                    Self::ManyModes { modes, most }
                }
            }
        }
    }

    /// Whether closed modes compute all tables at once ([`Why::Small`]) or on demand ([`Why::Met`]), for a
    /// structure with `modes` modes.
    pub fn of_tables(modes: usize, size: TableSize) -> Self {
        let sets = size.systems;
        if sets <= ClosedModes::MOST_PRECOMPUTED {
            Self::Small { modes, size }
        } else {
            Self::Met { modes, sets }
        }
    }
}

impl fmt::Display for Why {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Small { modes, size } => write!(
                f,
                "{modes} mode{}, {} sets of closed contacts, {:.3} MB of tables",
                if *modes == 1 { "" } else { "s" },
                size.systems,
                megabytes(size.bytes)
            ),
            Self::Met { modes, sets } => write!(
                f,
                "{modes} modes, {sets} sets of closed contacts, with tables computed on demand"
            ),
            Self::NoTable => f.write_str("no table for a set of closed contacts in the motion"),
            Self::Gyroscopic => f.write_str("gyroscopic terms change the structure with the speed"),
            Self::ManyModes { modes, most } => write!(f, "{modes} modes, more than {most}"),
            Self::ManySets { sets, most } => {
                write!(f, "{sets} sets of closed contacts, more than {most}")
            }
            Self::Portable => f.write_str("instructions = \"portable\""),
            Self::Refused(error) => f.write_str(&error.cause()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Release, fixtures};

    /// Three modes are suitable, and the reported size of their tables is the actual one. Twenty-five modes are too
    /// many. A contact that opens by force is refused. Portable bits take precedence.
    #[test]
    fn drives_get_a_kernel_by_their_shape() {
        let model = |modes: usize, release| {
            let frequency: Vec<f64> = (0..modes).map(|mode| 900.0 * mode as f64).collect();
            let ones = vec![1.0; modes];
            let structure = fixtures::structure(&frequency, 0.01, &ones, &ones);
            let mut drive = fixtures::two_level_mesh(1e-5);
            drive.release = release;
            Model::new(&structure, &drive, fixtures::strong_rattle()).unwrap()
        };
        let small = model(3, Release::Deflection);
        let Why::Small { modes: 3, size } = Why::of(&small, false) else {
            panic!("{:?}", Why::of(&small, false));
        };
        let arrays = ClosedModes::arrays(&small).unwrap();
        let numbers: usize = arrays.iter().map(|array| array.values.len()).sum();
        assert_eq!((size.systems, size.bytes), (9, 8 * numbers));
        let why = |model: &Model, portable| Why::of(model, portable).to_string();
        assert_eq!(
            why(&small, false),
            "3 modes, 9 sets of closed contacts, 0.035 MB of tables"
        );
        assert_eq!(why(&small, true), "instructions = \"portable\"");
        let many = model(25, Release::Deflection);
        assert_eq!(why(&many, false), "25 modes, more than 24");
        assert_eq!(
            why(&model(3, Release::Force), false),
            "tables cannot represent contacts that open when their force vanishes"
        );
    }
}
