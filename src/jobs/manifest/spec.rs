//! The resolved specification of a job: what the program uses, after the text has been
//! validated. Everything is SI; nothing here knows how it was typed.

mod continuation;
mod mesh;
mod refine;
mod run_up;
mod samples;

pub use continuation::ContinuationSpec;
pub use mesh::{CoastSpec, DampingSpec, FrictionSpec, MeshSpec, StiffnessSpec, TwoLevels};
pub use refine::{Criterion, Refine};
pub use run_up::{RunUpLoad, RunUpSpec};
pub use samples::{Design, Samples};

use super::axis::{AxisKey, AxisValues};
use crate::analysis::Analyses;
use crate::gear::GearPair;
use crate::model::{ImposedMotion, InitialState, MeshHarmonic, TorqueRipple};
use crate::propagate::KernelSetting;
use crate::shaft::{Drag, FlexibleDrive, RigidDrive, TrainDrive};
use crate::structure::ModalStructure;
use serde::Serialize;
use std::sync::Arc;

/// Points that follow from each other: the state is carried along one axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Carried {
    /// The swept axis, an index into [`Job::axes`](super::Job::axes).
    pub axis: usize,
    /// How many values it has: points of a chain.
    pub length: usize,
    /// The directions in which it is swept. `point_id` counts over the other axes, slowest
    /// first, then over these, then over the values in sweep order: a chain is a range.
    pub directions: Vec<Direction>,
    /// By how much the state is displaced before it is taken over, in half gaps.
    pub displacement: f64,
}

/// Which way a sweep runs along its axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
pub enum Direction {
    /// Towards larger values.
    Up,
    /// Towards smaller values.
    Down,
}

impl Direction {
    /// The word used in manifests, result files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Up => "up",
            Self::Down => "down",
        }
    }
}

/// One axis of the grid.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Axis {
    /// What it varies.
    pub key: AxisKey,
    /// SI unit as text, `1` when dimensionless.
    pub unit: String,
    /// Values in SI.
    pub values: AxisValues,
}

impl Axis {
    /// Its name in manifests and result files.
    pub fn name(&self) -> &str {
        self.key.name()
    }
}

/// One operating point: a complete description of one simulation. Points share what they
/// have in common.
#[derive(Debug, Clone, PartialEq)]
pub struct PointSpec {
    /// Its number, from 0.
    pub point_id: u64,
    /// Which way its sweep runs; none where points are independent.
    pub direction: Option<Direction>,
    /// Root of its random streams.
    pub seed: u64,
    /// Value of each axis at this point, in the order of [`Job::axes`](super::Job::axes).
    pub axis_values: Vec<f64>,
    /// Fraction of the rated mesh force.
    pub load: f64,
    /// Pinion speed Ω \[rad/s\].
    pub speed: f64,
    /// The structure.
    pub model: ModelSpec,
    /// The gear mesh.
    pub mesh: MeshSpec,
    /// Transmission error and torque ripple.
    pub excitation: Arc<ExcitationSpec>,
    /// How to integrate.
    pub run: Arc<RunSpec>,
    /// What to compute.
    pub analyses: Arc<Analyses>,
    /// Why the values of its axes make no drive, where a grid was too large for every
    /// combination to be judged; everything else is then another point's.
    pub fault: Option<String>,
}

/// Everything about a point but its load and speed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Variant {
    /// The structure.
    pub model: ModelSpec,
    /// The gear mesh.
    pub mesh: MeshSpec,
    /// Transmission error and torque ripple.
    pub excitation: Arc<ExcitationSpec>,
    /// How to integrate.
    pub run: Arc<RunSpec>,
    /// What to compute.
    pub analyses: Arc<Analyses>,
}

/// The structure and its reduction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ModelSpec {
    /// Where the structure comes from.
    pub source: StructureSource,
    /// Modes computed; the file's own count for `modal`.
    pub modes: usize,
    /// Modes kept, at most `modes`.
    pub retained: usize,
    /// Whether the modes left out return as residual flexibility.
    pub mta: bool,
}

impl ModelSpec {
    /// The load of a torque on the pinion \[N m\]; not a number where no rated torque is known.
    pub fn load_of_torque(&self, torque: f64) -> f64 {
        (self.source.rated_torque()).map_or(f64::NAN, |rated| torque / rated)
    }

    /// Rotations of the whole drive, which no contact feels.
    pub fn neutral(&self) -> usize {
        match &self.source {
            StructureSource::Rigid(_) | StructureSource::Flexible(_) => 1,
            StructureSource::Train(train) => train.neutral_rotations(),
            StructureSource::Modal(structure) => structure.neutral_modes(),
        }
    }

    /// Number of Lyapunov exponents of these rotations: one of each that drag damps.
    pub fn neutral_exponents(&self) -> usize {
        let dragged = |drag: [Drag; 2]| usize::from(drag.iter().any(|drag| drag.viscous > 0.0));
        match &self.source {
            StructureSource::Rigid(drive) => dragged(drive.shafts.each_ref().map(|s| s.drag)),
            StructureSource::Flexible(drive) => dragged(drive.shafts.each_ref().map(|s| s.drag)),
            // Why a train cannot be laid out is said elsewhere.
            StructureSource::Train(train) => train.dragged_rotations().unwrap_or(0),
            StructureSource::Modal(structure) => structure.felt_of_neutral(),
        }
    }

    /// Number of Lyapunov exponents: two of each mode that is kept, but for neutral rotations, and one of each dry slider.
    pub fn exponents(&self) -> usize {
        2 * (self.retained - self.neutral()) + self.neutral_exponents() + self.source.sliders()
    }
}

/// Where the structure comes from; points with equal structure share one.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum StructureSource {
    /// Assembled from rigid bodies: one of the four tiers.
    Rigid(Arc<RigidDrive>),
    /// Assembled from shafts, bearings and gear bodies.
    Flexible(Arc<FlexibleDrive>),
    /// Assembled from any number of shafts, gears and couplings.
    Train(Arc<TrainDrive>),
    /// Read from a modal file (already checked).
    Modal(Arc<ModalStructure>),
}

impl StructureSource {
    /// The drawing of the gears, their bores the shafts' diameters; none of a modal file and of bevel
    /// gears.
    pub fn gears(&self) -> Option<GearPair> {
        let (gears, shafts) = match self {
            Self::Rigid(drive) => (&drive.gears, &drive.shafts),
            Self::Flexible(drive) => (&drive.gears, &drive.shafts),
            Self::Train(train) => return train.spur_pair(),
            Self::Modal(_) => return None,
        };
        Some(gears.on_shafts(shafts.each_ref().map(|shaft| shaft.diameter)))
    }

    /// Number of rigid stops.
    pub fn rigid_stops(&self) -> usize {
        match self {
            Self::Modal(structure) => structure.rigid_stops(),
            _ => 0,
        }
    }

    /// Number of elements of dry friction.
    pub fn dry_frictions(&self) -> usize {
        match self {
            Self::Modal(structure) => structure.dry_frictions(),
            _ => 0,
        }
    }

    /// Number of dry sliders.
    pub fn sliders(&self) -> usize {
        match self {
            Self::Train(train) => train.sliders(),
            Self::Modal(structure) => structure.sliders(),
            Self::Rigid(_) | Self::Flexible(_) => 0,
        }
    }

    /// Torque on the pinion at load 1 \[N m\]; a modal file knows none.
    pub fn rated_torque(&self) -> Option<f64> {
        match self {
            Self::Rigid(drive) => Some(drive.gears.rated_torque),
            Self::Flexible(drive) => Some(drive.gears.rated_torque),
            Self::Train(train) => Some(train.pair.rated_torque),
            Self::Modal(_) => None,
        }
    }

    /// Mesh force at load 1 \[N\], where it is known without the drawing.
    pub fn rated_force(&self) -> Option<f64> {
        match self {
            Self::Modal(structure) => Some(structure.rated_force),
            Self::Train(train) => Some(train.pair.rated_force()),
            Self::Rigid(_) | Self::Flexible(_) => None,
        }
    }

    /// The model kind, as in the manifest.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Rigid(drive) => drive.tier.name(),
            Self::Flexible(_) => "flexible",
            Self::Train(_) => "train",
            Self::Modal(_) => "modal",
        }
    }
}

/// Transmission error and torque ripple.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct ExcitationSpec {
    /// What is imposed.
    pub transmission_error: Vec<MeshHarmonic>,
    /// What is imposed on the coast flanks; none: the same.
    pub coast_transmission_error: Option<Vec<MeshHarmonic>>,
    /// So many harmonics stand for the error that a mesh table finds of its flanks under load;
    /// none: the error belongs to the law, as it is.
    pub table_harmonics: Option<u32>,
    /// On either shaft.
    pub torque_ripple: Vec<TorqueRipple>,
    /// Uneven rotation that is imposed.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub imposed_motion: Vec<ImposedMotion>,
}

/// How to integrate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunSpec {
    /// Mesh cycles discarded before anything is measured.
    pub transient: u64,
    /// Most mesh cycles measured; a point stops earlier once its answers are settled.
    pub cycles: u64,
    /// The kernel, or how it is chosen.
    pub kernel: KernelSetting,
    /// Where the state starts.
    pub initial: InitialState,
    /// Whether attracting periodic orbits are sought by Newton's method instead of integrated
    /// out.
    pub settle: bool,
    /// Cycles over which the energy balance is audited.
    pub audit_cycles: u64,
    /// Most events in one mesh cycle before the point ends as `event_storm`.
    pub event_limit: u32,
    /// Whether only instructions are used that every processor has, so that results have the
    /// same bits everywhere.
    pub portable: bool,
}
