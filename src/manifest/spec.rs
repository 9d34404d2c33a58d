//! The resolved specification of a job: what the program uses, after the text has been
//! validated. Everything is SI; nothing here knows how it was typed.

mod mesh;

pub use mesh::{CourseSpec, DampingSpec, MeshSpec, StiffnessSpec, TableSpec, TwoLevels};

use super::axis::AxisValues;
use super::expand::Between;
use super::points::Points;
use crate::gear::GearPair;
use crate::shaft::{FlexibleDrive, ModalStructure, RigidDrive};
use std::sync::Arc;

/// A whole job.
#[derive(Debug, Clone)]
pub struct Job {
    /// Name; results go to `results/<name>` by default.
    pub name: String,
    /// Root of every random stream.
    pub seed: u64,
    /// The manifest as the user wrote it.
    pub text: String,
    /// Hash over what matters to physics, as lower-case hexadecimal.
    pub hash: String,
    /// Axes of the grid: model keys first, by name, then `load`, then `speed`; the order of
    /// the text is of no effect. `point_id` counts row-major over them, unless the state is
    /// carried along one.
    pub axes: Vec<Axis>,
    /// How points follow from each other; none where each starts from `run.initial`.
    pub carried: Option<Carried>,
    /// The grid's points, in `point_id` order.
    pub points: Points,
    /// Resolves points between those of the grid, where they are asked for.
    pub between: Option<Between>,
}

impl Job {
    /// Whether results are to have the same bits on every processor.
    pub fn portable(&self) -> bool {
        let mut variants = self.points.variants().iter();
        variants.any(|variant| variant.run.portable)
    }

    /// Points of a chain: each starts where the one before it ended, and all chains are
    /// equally long. 1 where points are independent.
    pub fn chain_length(&self) -> usize {
        self.carried.as_ref().map_or(1, |carried| carried.length)
    }

    /// The point like `point` with another value on the swept axis; none where no state is
    /// carried, where the manifest does not ask for refinement, or where the key takes no
    /// such value (a whole number between two).
    pub fn point_between(&self, point: &PointSpec, value: f64) -> Option<PointSpec> {
        let axis = self.carried.as_ref()?.axis;
        let mut between = point.clone();
        between.axis_values[axis] = value;
        match self.axes[axis].name.as_str() {
            "load" => between.load = value,
            "speed" => between.speed = value,
            _ => self.between.as_ref()?.resolve(&mut between)?,
        }
        Some(between)
    }
}

/// Points that follow from each other: the state is carried along one axis.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Carried {
    /// The swept axis, an index into [`Job::axes`].
    pub axis: usize,
    /// How many values it has: points of a chain.
    pub length: usize,
    /// The directions in which it is swept. `point_id` counts over the other axes, slowest
    /// first, then over these, then over the values in marching order: a chain is a range.
    pub directions: Vec<Direction>,
}

/// Which way a sweep marches along its axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
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
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Column name: `load`, `speed`, or the dotted key (`mesh.half_gap`).
    pub name: String,
    /// SI unit as text, `1` when dimensionless.
    pub unit: String,
    /// Values in SI.
    pub values: AxisValues,
}

/// One operating point: a complete description of one simulation. Points share what they
/// have in common.
#[derive(Debug, Clone, PartialEq)]
pub struct PointSpec {
    /// Its number, from 0.
    pub point_id: u64,
    /// Which way its sweep marches; none where points are independent.
    pub direction: Option<Direction>,
    /// Value of each axis at this point, in the order of [`Job::axes`].
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
    /// How to march.
    pub run: Arc<RunSpec>,
    /// What to compute.
    pub analyses: Arc<AnalysesSpec>,
    /// Why the values of its axes make no drive, where a grid was too large for every
    /// combination to be judged; everything else is then another point's.
    pub fault: Option<String>,
}

/// The structure and its reduction.
#[derive(Debug, Clone, PartialEq)]
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
    /// Modes that are kept and not neutral: half the number of Lyapunov exponents.
    pub fn felt(&self) -> usize {
        self.retained
            - match &self.source {
                // The rotation of the whole drive.
                StructureSource::Rigid(_) | StructureSource::Flexible(_) => 1,
                StructureSource::Modal(structure) => structure.neutral_modes(),
            }
    }
}

/// Where the structure comes from; points with equal structure share one.
#[derive(Debug, Clone, PartialEq)]
pub enum StructureSource {
    /// Assembled from rigid bodies: one of the four tiers.
    Rigid(Arc<RigidDrive>),
    /// Assembled from shafts, bearings and gear bodies.
    Flexible(Arc<FlexibleDrive>),
    /// Read from a modal file (already checked).
    Modal(Arc<ModalStructure>),
}

impl StructureSource {
    /// The drawing of the gears, their bores the shafts' diameters; none of a modal file.
    pub fn gears(&self) -> Option<GearPair> {
        let (gears, shafts) = match self {
            Self::Rigid(drive) => (&drive.gears, &drive.shafts),
            Self::Flexible(drive) => (&drive.gears, &drive.shafts),
            Self::Modal(_) => return None,
        };
        Some(gears.on_shafts(shafts.each_ref().map(|shaft| shaft.diameter)))
    }

    /// Mesh force at load 1 \[N\], where it is known without the drawing: of a modal file.
    pub fn rated_force(&self) -> Option<f64> {
        match self {
            Self::Modal(structure) => Some(structure.rated_force),
            Self::Rigid(_) | Self::Flexible(_) => None,
        }
    }

    /// The model kind, as in the manifest.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Rigid(drive) => drive.tier.name(),
            Self::Flexible(_) => "flexible",
            Self::Modal(_) => "modal",
        }
    }
}

/// Transmission error and torque ripple.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ExcitationSpec {
    /// `e(φ) = Σ amplitude cos(2π harmonic φ + phase)`, φ the mesh phase in cycles.
    pub transmission_error: Vec<TransmissionErrorHarmonic>,
    /// So many harmonics stand for the error that a mesh table finds of its flanks under load;
    /// none: the error belongs to the law, as it is.
    pub table_harmonics: Option<u32>,
    /// `T(t) = Σ amplitude cos(order Ω_shaft t + phase)`.
    pub torque_ripple: Vec<TorqueRipple>,
}

/// One harmonic of the static transmission error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransmissionErrorHarmonic {
    /// Multiple of the mesh frequency, ≥ 1.
    pub harmonic: u32,
    /// Amplitude \[m\].
    pub amplitude: f64,
    /// Phase \[rad\].
    pub phase: f64,
}

/// One harmonic of the torque on a shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TorqueRipple {
    /// Which shaft.
    pub shaft: ShaftName,
    /// Multiple of that shaft's speed, > 0 (need not be an integer: firing orders).
    pub order: f64,
    /// Amplitude \[N m\].
    pub amplitude: f64,
    /// Phase \[rad\].
    pub phase: f64,
}

/// One of the two shafts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShaftName {
    /// The driving shaft.
    Pinion,
    /// The driven shaft.
    Wheel,
}

/// How to march.
#[derive(Debug, Clone, PartialEq)]
pub struct RunSpec {
    /// Mesh cycles discarded before anything is measured.
    pub transient: u64,
    /// Most mesh cycles measured; a point stops earlier once its answers are settled.
    pub cycles: u64,
    /// The kernel.
    pub kernel: KernelSpec,
    /// Where the state starts.
    pub initial: InitialSpec,
    /// Whether attracting periodic orbits are sought by Newton's method instead of marched
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

/// Kernel and its own settings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum KernelSpec {
    /// The structured kernel.
    Volterra {
        /// Relative truncation of a window's series; `roundoff` is 2⁻⁵².
        tolerance: f64,
    },
    /// Fixed small steps.
    Stepping {
        /// Steps a mesh cycle.
        steps: u32,
    },
    /// A kernel of dense tables.
    Tables {
        /// Which.
        ladder: Ladder,
        /// Fewest unit steps a mesh cycle.
        cells: u32,
    },
}

/// The kernels of dense tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ladder {
    /// Halving down to an event.
    Dyadic,
    /// Certificates and Hermite guesses.
    Hermite,
    /// Closed forms in eigenvectors.
    Spectral {
        /// Events are put off to the next of so many equal parts of the cycle.
        event_grid: Option<u32>,
    },
    /// Closed forms, and certified runs of cells in one product.
    Fused,
}

impl Ladder {
    /// Its name in a manifest.
    pub fn name(self) -> &'static str {
        match self {
            Self::Dyadic => "dyadic",
            Self::Hermite => "hermite",
            Self::Spectral { .. } => "spectral",
            Self::Fused => "fused",
        }
    }
}

/// Where the state starts.
#[derive(Debug, Clone, PartialEq)]
pub enum InitialSpec {
    /// Static equilibrium under the mean load, in contact.
    Static,
    /// All modal coordinates and velocities zero.
    Rest,
    /// Modal state in the structure's own coordinates, one entry a retained mode.
    Modal {
        /// \[m √kg\]
        displacement: Vec<f64>,
        /// \[m √kg/s\]
        velocity: Vec<f64>,
    },
}

/// What to compute; absent = not computed.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct AnalysesSpec {
    /// Lyapunov exponents.
    pub lyapunov: Option<LyapunovSpec>,
    /// Poincaré samples.
    pub poincare: Option<PoincareSpec>,
    /// Noise, vibration and harshness statistics.
    pub nvh: Option<NvhSpec>,
    /// Coexisting attractors.
    pub multistability: Option<MultistabilitySpec>,
    /// Periodic orbits, stable or not.
    pub orbits: Option<OrbitsSpec>,
    /// Predictability of chaotic motion.
    pub horizon: Option<HorizonSpec>,
}

/// Periodic orbits sought by Newton's method from near returns of the trajectory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OrbitsSpec {
    /// Periods in mesh cycles, each in 1 …= 64.
    pub periods: Vec<u32>,
    /// Newton searches for each period.
    pub guesses: u32,
    /// Mesh cycles that guesses are taken from.
    pub cycles: u32,
    /// Whether all multipliers are stored.
    pub floquet: bool,
}

/// Lyapunov exponents.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LyapunovSpec {
    /// Number of exponents m, from 1 to twice the modes that are not neutral.
    pub exponents: usize,
    /// Stop once the standard error of the largest exponent is at most this (per cycle).
    pub stop_at_stderr: Option<f64>,
    /// Cycles that align the tangents after the transient, discarded.
    pub align: u64,
    /// Whether a twin trajectory is marched beside the tangents.
    pub twin: bool,
    /// Whether growth is measured in the raw norm instead of the energy norm.
    pub raw_norm: bool,
}

/// Poincaré samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoincareSpec {
    /// Samples kept: the last ones of the measured cycles.
    pub samples: usize,
    /// Where they are taken.
    pub section: SectionSpec,
    /// Halvings of the interval between neighbours of a chain that move differently; 0 for
    /// none.
    pub refine: u32,
}

/// Where Poincaré samples are taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SectionSpec {
    /// Once a mesh cycle.
    Strobe {
        /// Mesh phase in \[0, 1).
        phase: f64,
    },
    /// On every entry into drive contact.
    Entry,
    /// At every extreme of the deflection.
    Turning,
}

/// NVH statistics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NvhSpec {
    /// Mesh harmonics of the deflection, 0 for none.
    pub harmonics: usize,
    /// Whether Welch spectra of deflection and force are stored.
    pub spectrum: bool,
    /// Whether bearing forces are rebuilt from the modes.
    pub bearings: bool,
}

/// Probes for coexisting attractors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MultistabilitySpec {
    /// Probes a point, the first from [`RunSpec::initial`]; ≥ 1.
    pub initial_conditions: u32,
    /// Decades of energy that the other probes are spread over, about the energy that
    /// closes the half gap.
    pub decades: f64,
    /// Mesh cycles of each probe discarded.
    pub transient: u64,
    /// Most mesh cycles of each probe measured.
    pub cycles: u64,
    /// A slice of initial states.
    pub slice: Option<SliceSpec>,
}

/// A slice of initial states along two modes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SliceSpec {
    /// The two modes, different, counted from 0.
    pub modes: [usize; 2],
    /// Whether modal velocities are varied instead of displacements.
    pub velocity: bool,
    /// Half the side of the slice \[m of mesh deflection\].
    pub extent: f64,
    /// Cells along each side.
    pub count: u32,
}

/// Predictability: twins that part, and averages over longer and longer stretches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HorizonSpec {
    /// Twins a point; ≥ 2.
    pub twins: u32,
    /// Distance at which they start, in half gaps.
    pub separation: f64,
    /// Mesh cycles each is followed.
    pub cycles: u64,
    /// Mesh cycles in the longest averages.
    pub averages: u64,
}
