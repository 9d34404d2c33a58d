//! The resolved specification of a job: the data that the program uses after the text has been validated. Everything is
//! SI and independent of the text's form.

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
use crate::numerics::random::PointSeed;
use crate::propagate::KernelSetting;
use crate::shaft::{Drag, FlexibleDrive, RigidDrive, TrainDrive};
use crate::structure::ModalStructure;
use serde::Serialize;
use std::sync::Arc;

/// The order of points if the state is carried along one axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Carried {
    /// The swept axis, an index into [`Job::axes`](super::Job::axes).
    pub axis: usize,
    /// Number of its values, which is the number of points in a chain.
    pub length: usize,
    /// The directions in which it is swept. `point_id` counts over the other axes, slowest first, then over
    /// these, then over the values in sweep order. A chain is therefore a range of `point_id`.
    pub directions: Vec<Direction>,
    /// Displacement of the state before the next point, in half gaps.
    pub displacement: f64,
}

/// Direction of a sweep along its axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
pub enum Direction {
    /// Towards larger values.
    Up,
    /// Towards smaller values.
    Down,
}

impl Direction {
    /// Name in manifests, result files and on the command line.
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
    /// The quantity that it varies.
    pub key: AxisKey,
    /// SI unit as text, `1` if dimensionless.
    pub unit: String,
    /// Values in SI.
    pub values: AxisValues,
}

impl Axis {
    /// Name in manifests and result files.
    pub fn name(&self) -> &str {
        self.key.name()
    }
}

/// One operating point: a complete description of one simulation. Points share equal parts.
#[derive(Debug, Clone, PartialEq)]
pub struct PointSpec {
    /// Number, from 0.
    pub point_id: u64,
    /// Direction of its sweep; `None` if points are independent.
    pub direction: Option<Direction>,
    /// Seed of its random streams.
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
    /// Settings of the integration.
    pub run: Arc<RunSpec>,
    /// Requested analyses.
    pub analyses: Arc<Analyses>,
    /// Why the values of its axes are inconsistent, in a grid too large for judging every combination.
    /// `model`, `mesh`, `excitation`, `run` and `analyses` are then those of another point.
    pub fault: Option<String>,
}

impl PointSpec {
    /// Seed and `point_id`, on which its random streams depend.
    pub fn random(&self) -> PointSeed {
        PointSeed {
            seed: self.seed,
            point_id: self.point_id,
        }
    }
}

/// Everything about a point except its load and speed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Variant {
    /// The structure.
    pub model: ModelSpec,
    /// The gear mesh.
    pub mesh: MeshSpec,
    /// Transmission error and torque ripple.
    pub excitation: Arc<ExcitationSpec>,
    /// Settings of the integration.
    pub run: Arc<RunSpec>,
    /// Requested analyses.
    pub analyses: Arc<Analyses>,
}

/// The structure and its reduction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ModelSpec {
    /// Source of the structure.
    pub source: StructureSource,
    /// Number of computed modes; for `modal` those of the file.
    pub modes: usize,
    /// Number of retained modes, at most `modes`.
    pub retained: usize,
    /// Whether residual flexibility represents the omitted modes.
    pub mta: bool,
}

impl ModelSpec {
    /// The load of a torque on the pinion \[N m\]; NaN if the rated torque is unknown.
    pub fn load_of_torque(&self, torque: f64) -> f64 {
        (self.source.rated_torque()).map_or(f64::NAN, |rated| torque / rated)
    }

    /// Number of neutral rotations: rotations of the whole drive that deflect no contact.
    pub fn neutral(&self) -> usize {
        match &self.source {
            StructureSource::Rigid(_) | StructureSource::Flexible(_) => 1,
            StructureSource::Train(train) => train.neutral_rotations(),
            StructureSource::Modal(structure) => structure.neutral_modes(),
        }
    }

    /// Number of Lyapunov exponents of the neutral rotations: one for each rotation that drag damps. For a
    /// modal file, one for each position or speed of a neutral rotation that affects the motion.
    pub fn neutral_exponents(&self) -> usize {
        let dragged = |drag: [Drag; 2]| usize::from(drag.iter().any(|drag| drag.viscous > 0.0));
        match &self.source {
            StructureSource::Rigid(drive) => dragged(drive.shafts.each_ref().map(|s| s.drag)),
            StructureSource::Flexible(drive) => dragged(drive.shafts.each_ref().map(|s| s.drag)),
            // [`TrainDrive::check`] reports why a train has no layout.
            StructureSource::Train(train) => train.dragged_rotations().unwrap_or(0),
            StructureSource::Modal(structure) => structure.restrained_neutral_count(),
        }
    }

    /// Number of Lyapunov exponents: two per retained mode that is no neutral rotation, those of the neutral rotations,
    /// and one per dry slider.
    pub fn exponents(&self) -> usize {
        2 * (self.retained - self.neutral()) + self.neutral_exponents() + self.source.sliders()
    }
}

/// Source of the structure; points with equal structure share one.
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
    /// The drawing of the gears, with the shafts' diameters as bores; `None` for a modal file or bevel gears.
    pub fn gears(&self) -> Option<GearPair> {
        let (gears, shafts) = match self {
            Self::Rigid(drive) => (&drive.gears, &drive.shafts),
            Self::Flexible(drive) => (&drive.gears, &drive.shafts),
            Self::Train(train) => return train.parallel_pair(),
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

    /// The sum of the drags on all shafts and loose gears; zero for a modal file.
    pub fn drag(&self) -> Drag {
        let drags: Vec<Drag> = match self {
            Self::Rigid(drive) => drive.shafts.iter().map(|shaft| shaft.drag).collect(),
            Self::Flexible(drive) => drive.shafts.iter().map(|shaft| shaft.drag).collect(),
            Self::Train(train) => train.drags().collect(),
            Self::Modal(_) => Vec::new(),
        };
        Drag {
            viscous: drags.iter().map(|drag| drag.viscous).sum(),
            constant: drags.iter().map(|drag| drag.constant).sum(),
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

    /// Torque on the pinion at load 1 \[N m\]; `None` for a modal file.
    pub fn rated_torque(&self) -> Option<f64> {
        match self {
            Self::Rigid(drive) => Some(drive.gears.rated_torque),
            Self::Flexible(drive) => Some(drive.gears.rated_torque),
            Self::Train(train) => Some(train.pair.rated_torque),
            Self::Modal(_) => None,
        }
    }

    /// Mesh force at load 1 \[N\], if it is known without the drawing.
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
    /// Imposed error.
    pub transmission_error: Vec<MeshHarmonic>,
    /// Imposed error of the coast flanks; `None` if it equals that of the drive flanks.
    pub coast_transmission_error: Option<Vec<MeshHarmonic>>,
    /// Number of harmonics that represent the error of loaded flanks from a mesh table; `None` if the mesh law contains
    /// the exact error.
    pub table_harmonics: Option<u32>,
    /// Ripple on either shaft.
    pub torque_ripple: Vec<TorqueRipple>,
    /// Imposed uneven rotation.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub imposed_motion: Vec<ImposedMotion>,
}

/// Settings of the integration.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunSpec {
    /// Mesh cycles before the measurement.
    pub transient: u64,
    /// Largest number of measured mesh cycles; a point stops earlier when its results are settled.
    pub cycles: u64,
    /// The kernel, or how it is chosen.
    pub kernel: KernelSetting,
    /// Initial state.
    pub initial: InitialState,
    /// Whether attracting periodic orbits are found by Newton's method instead of by long integration.
    pub settle: bool,
    /// Cycles over which the energy balance is audited.
    pub audit_cycles: u64,
    /// Largest number of events in one mesh cycle before the point ends as `event_storm`.
    pub event_limit: u32,
    /// Whether the program uses only instructions that every x86-64 processor has, so that results have the
    /// same bits everywhere.
    pub portable: bool,
}
