//! What may be asked of a trajectory.

use super::poincare::Section;
use crate::model::Quantity;
use crate::numerics::random::PointSeed;
use serde::Serialize;

/// What is asked of one trajectory of a point.
#[derive(Debug, Clone, PartialEq)]
pub struct PointConfig {
    /// The point, as its random streams know it.
    pub point: PointSeed,
    /// Mesh cycles discarded.
    pub transient: u64,
    /// Most mesh cycles measured.
    pub cycles: u64,
    /// Whether attracting periodic orbits are sought by Newton's method, so that a settling
    /// motion need not be integrated to the end.
    pub settle: bool,
    /// Mesh cycles over which the energy balance is audited; 0 for none.
    pub audit_cycles: u64,
    /// Lyapunov exponents, if asked for.
    pub lyapunov: Option<LyapunovConfig>,
    /// Poincaré samples kept.
    pub poincare_samples: usize,
    /// Where they are taken.
    pub section: Section,
    /// NVH statistics, if asked for.
    pub nvh: Option<NvhConfig>,
}

impl PointConfig {
    /// How much evidence error bars take; verified where no exponent is asked for.
    pub fn effort(&self) -> Effort {
        self.lyapunov.map_or(Effort::Verified, |asked| asked.effort)
    }
}

/// How Lyapunov exponents are asked for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LyapunovConfig {
    /// Number of exponents, at least 1; a model has twice as many as modes that are not
    /// neutral, and one more where drag damps the neutral rotation.
    pub exponents: usize,
    /// Stop once the standard error of the largest exponent is at most this \[1/cycle\].
    pub stop_at_stderr: Option<f64>,
    /// Cycles that align the tangents after the transient, discarded.
    pub align: u64,
    /// Whether a twin trajectory is integrated beside the tangents.
    pub twin: bool,
    /// Its distance, in half gaps.
    pub separation: f64,
    /// The norm in which growth is measured.
    pub norm: GrowthNorm,
    /// Places at which running estimates are kept, 0 for none.
    pub course: usize,
    /// How much evidence an error bar takes.
    pub effort: Effort,
    /// Lower bound of the life of chaos to be shown \[cycles\], if any.
    pub lifetime: Option<u64>,
    /// Whether the growth of every trajectory is kept.
    pub chains: bool,
}

impl Default for LyapunovConfig {
    fn default() -> Self {
        Self {
            exponents: 1,
            stop_at_stderr: None,
            align: 100,
            twin: true,
            separation: super::twin::SEPARATION,
            norm: GrowthNorm::Energy,
            course: 0,
            effort: Effort::Verified,
            lifetime: None,
            chains: false,
        }
    }
}

/// How much of a motion that does not settle is seen before its error bars are read.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub enum Effort {
    /// Several trajectories, a late first look, few looks: the coverage of the errors was measured.
    #[default]
    Verified,
    /// One trajectory and an early first look; the errors are not verified.
    Survey,
}

impl Effort {
    /// Measured mesh cycles at the first look: the fewest that end a point.
    pub fn first_look(self) -> u64 {
        match self {
            Self::Verified => 40_000,
            Self::Survey => 2_000,
        }
    }
}

/// The norm in which the growth of tangents and twins is measured. Exponents do not depend on
/// it in the long run, estimates over a few cycles do.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub enum GrowthNorm {
    /// Energy, the neutral pair left out.
    #[default]
    Energy,
    /// Modal displacements and velocities as they stand, the neutral pair included.
    Raw,
}

/// How NVH statistics are asked for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct NvhConfig {
    /// Mesh harmonics of the deflection, 0 for none.
    pub harmonics: usize,
    /// Mean and RMS of outputs of the structure, which are rebuilt from the modes. That costs more
    /// than the integration.
    pub outputs: Signals,
    /// Power that the vibration takes in and gives off, by the motion of all modes. Left out of the hash of
    /// manifests that do not ask for it.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub power: bool,
    /// Spectra, if asked for.
    pub spectrum: Option<SpectrumConfig>,
    /// Amplitude and phase at orders, if asked for.
    pub orders: Option<OrderConfig>,
    /// Gather until every time average and line is known this well: its standard error relative to
    /// the scale that `analysis::known` takes. Left out of the hash of manifests that do not ask for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stop_at_stderr: Option<f64>,
}

impl NvhConfig {
    /// All outputs that are needed, by themselves or for spectra and orders.
    pub fn computed(&self) -> Signals {
        let spectrum = self.spectrum.map_or(Signals::NONE, |asked| asked.signals);
        let orders = self.orders.map_or(Signals::NONE, |asked| asked.signals);
        self.outputs.with(spectrum).with(orders)
    }
}

/// Which spectra are asked for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SpectrumConfig {
    /// Of what.
    pub signals: Signals,
    /// Highest mesh order.
    pub highest_order: u32,
    /// Mesh cycles in a segment of a motion that does not repeat, at least: its lines are no
    /// further apart than 1/resolution of the mesh order.
    pub resolution: u32,
}

/// Which orders are asked for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OrderConfig {
    /// Of what.
    pub signals: Signals,
    /// Multiples of the mesh frequency.
    pub mesh: u32,
    /// Multiples of the speed of each shaft of the first mesh.
    pub shafts: u32,
}

/// What may be looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Signals {
    /// Mesh deflection.
    pub deflection: bool,
    /// Mesh force.
    pub force: bool,
    /// Bearing forces.
    pub bearings: bool,
    /// Torques in shafts and couplings.
    pub torques: bool,
    /// Accelerations of bearings and angular accelerations of shafts.
    pub accelerations: bool,
    /// Deflections and forces of every mesh. Left out of the hash of manifests that do not ask for them.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub meshes: bool,
    /// Rotations of gears. Trajectories have them; manifests do not ask for them, and their hash does not see them.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub rotations: bool,
}

impl Signals {
    /// Nothing.
    pub const NONE: Self = Self {
        deflection: false,
        force: false,
        bearings: false,
        torques: false,
        accelerations: false,
        meshes: false,
        rotations: false,
    };

    /// Whether any output of the structure is among them.
    pub fn any(self) -> bool {
        self.bearings || self.torques || self.accelerations || self.meshes || self.rotations
    }

    /// Whether outputs of a quantity are among them.
    pub fn has(self, quantity: Quantity) -> bool {
        match quantity {
            Quantity::BearingForce => self.bearings,
            Quantity::Torque => self.torques,
            Quantity::Acceleration | Quantity::AngularAcceleration => self.accelerations,
            Quantity::MeshDeflection | Quantity::MeshForce => self.meshes,
            Quantity::Rotation => self.rotations,
        }
    }

    /// These and others.
    fn with(self, other: Self) -> Self {
        Self {
            deflection: self.deflection || other.deflection,
            force: self.force || other.force,
            bearings: self.bearings || other.bearings,
            torques: self.torques || other.torques,
            accelerations: self.accelerations || other.accelerations,
            meshes: self.meshes || other.meshes,
            rotations: self.rotations || other.rotations,
        }
    }
}
