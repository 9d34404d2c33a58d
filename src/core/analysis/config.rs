//! Settings of the analyses of a trajectory.

use super::poincare::Section;
use crate::model::Quantity;
use crate::numerics::random::PointSeed;
use serde::Serialize;
use strum::EnumString;

/// Settings of one trajectory of a point.
#[derive(Debug, Clone, PartialEq)]
pub struct PointConfig {
    /// Identifies the point in random streams.
    pub point: PointSeed,
    /// Mesh cycles discarded.
    pub transient: u64,
    /// Maximum number of mesh cycles measured.
    pub cycles: u64,
    /// Whether Newton's method searches for attracting periodic orbits, so that a settling motion is not
    /// integrated to its end.
    pub settle: bool,
    /// Mesh cycles over which the energy balance is audited; 0 for none.
    pub audit_cycles: u64,
    /// Lyapunov exponents, if requested.
    pub lyapunov: Option<LyapunovConfig>,
    /// Number of Poincaré samples that are kept, the last ones.
    pub poincare_samples: usize,
    /// The section of phase space on which the samples are taken.
    pub section: Section,
    /// NVH statistics, if requested.
    pub nvh: Option<NvhConfig>,
}

impl PointConfig {
    /// How much is measured for error bars; `Verified` if no exponent is requested.
    pub fn effort(&self) -> Effort {
        self.lyapunov
            .map_or(Effort::Verified, |config| config.effort)
    }
}

/// Settings of Lyapunov exponents.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LyapunovConfig {
    /// Number of exponents, at least 1. A model has two per mode that is not neutral, and one more if drag
    /// damps the neutral rotation.
    pub exponents: usize,
    /// Standard error of the largest exponent at which the measurement ends \[1/cycle\]; `None` to use all
    /// cycles.
    pub stop_at_stderr: Option<f64>,
    /// Mesh cycles after the transient in which the tangents align. Their growth is discarded.
    pub align: u64,
    /// Whether a twin trajectory is integrated with the tangents.
    pub twin: bool,
    /// Distance of the twin, in half gaps.
    pub separation: f64,
    /// The norm in which growth is measured.
    pub norm: GrowthNorm,
    /// Number of running estimates of the exponents over the measured cycles; 0 for none.
    pub course: usize,
    /// How much is measured for error bars.
    pub effort: Effort,
    /// Lower bound of the mean life of chaos \[cycles\] that the measurement must demonstrate, if any.
    pub lifetime: Option<u64>,
    /// Whether the averages of growth of every trajectory are stored with the results.
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

/// How much of a motion that does not settle is measured before its error bars are evaluated.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, EnumString)]
#[strum(serialize_all = "snake_case")]
pub enum Effort {
    /// Several trajectories. The error bars are evaluated late and seldom. Their coverage was measured.
    #[default]
    Verified,
    /// One trajectory. The error bars are evaluated early. Their coverage is unknown.
    Survey,
}

impl Effort {
    /// Measured mesh cycles at the first evaluation of the error bars (the first look). The measurement of a
    /// motion that does not settle cannot end earlier, except at the end of its budget.
    pub fn first_look(self) -> u64 {
        match self {
            Self::Verified => 40_000,
            Self::Survey => 2_000,
        }
    }
}

/// The norm in which the growth of tangents and twins is measured. Exponents over many cycles do not depend
/// on it. Estimates over a few cycles do.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, EnumString)]
#[strum(serialize_all = "snake_case")]
pub enum GrowthNorm {
    /// Energy, without the neutral pair.
    #[default]
    Energy,
    /// Unscaled modal displacements and velocities, with the neutral pair.
    Raw,
}

/// Settings of NVH statistics.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct NvhConfig {
    /// Number of mesh orders at which the amplitude of the deflection is computed, 0 for none.
    pub harmonics: usize,
    /// Outputs of the structure whose mean and RMS are computed. Their computation from the modes takes
    /// longer than the integration.
    pub outputs: Signals,
    /// Whether the power input and output of the vibration are computed from the motion of all modes. The
    /// hash of a manifest contains this field only if it is `true`.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub power: bool,
    /// Spectra, if requested.
    pub spectrum: Option<SpectrumConfig>,
    /// Amplitude and phase at orders, if requested.
    pub orders: Option<OrderConfig>,
    /// Largest standard error of every time average, spectral line and order at which the measurement ends, if
    /// any. It is relative to the scale in `analysis::precision`. The hash of a manifest contains this field only if it
    /// is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stop_at_stderr: Option<f64>,
}

impl NvhConfig {
    /// All required outputs: requested directly, or for spectra and orders.
    pub fn computed(&self) -> Signals {
        let spectrum = self.spectrum.map_or(Signals::NONE, |config| config.signals);
        let orders = self.orders.map_or(Signals::NONE, |config| config.signals);
        self.outputs.with(spectrum).with(orders)
    }
}

/// Settings of spectra.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SpectrumConfig {
    /// Signals with a spectrum.
    pub signals: Signals,
    /// Highest mesh order.
    pub highest_order: u32,
    /// Minimum number of mesh cycles per segment of Welch's method, for motion that does not repeat. Lines
    /// are at most 1/`resolution` of the mesh order apart.
    pub resolution: u32,
}

/// Settings of orders.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OrderConfig {
    /// Signals with orders.
    pub signals: Signals,
    /// Number of multiples of every mesh frequency.
    pub mesh: u32,
    /// Number of multiples of every shaft's speed.
    pub shafts: u32,
}

/// A selection of signals.
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
    /// Deflections and forces of every mesh. The hash of a manifest contains this field only if it is `true`.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub meshes: bool,
    /// Rotations of gears, for traces. A manifest cannot request them, and its hash omits this field.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub rotations: bool,
}

impl Signals {
    /// The empty selection.
    pub const NONE: Self = Self {
        deflection: false,
        force: false,
        bearings: false,
        torques: false,
        accelerations: false,
        meshes: false,
        rotations: false,
    };

    /// Whether the selection contains an output of the structure.
    pub fn any(self) -> bool {
        self.bearings || self.torques || self.accelerations || self.meshes || self.rotations
    }

    /// Whether the selection contains outputs of a quantity.
    pub fn has(self, quantity: Quantity) -> bool {
        match quantity {
            Quantity::BearingForce => self.bearings,
            Quantity::Torque => self.torques,
            Quantity::Acceleration | Quantity::AngularAcceleration => self.accelerations,
            Quantity::MeshDeflection | Quantity::MeshForce => self.meshes,
            Quantity::Rotation => self.rotations,
        }
    }

    /// The union with another selection.
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
