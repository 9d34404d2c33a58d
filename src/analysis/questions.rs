//! What may be asked of a trajectory.

use super::poincare::Section;
use crate::numerics::random::PointSeed;
use serde::Serialize;

/// What is asked of one trajectory of a point.
#[derive(Debug, Clone, PartialEq)]
pub struct Questions {
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
    pub lyapunov: Option<LyapunovQuestion>,
    /// Poincaré samples kept.
    pub poincare_samples: usize,
    /// Where they are taken.
    pub section: Section,
    /// NVH statistics, if asked for.
    pub nvh: Option<NvhQuestion>,
}

/// How Lyapunov exponents are asked for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LyapunovQuestion {
    /// Number of exponents, at least 1; a model has twice as many as modes that are not
    /// neutral.
    pub exponents: usize,
    /// Stop once the standard error of the largest exponent is at most this \[1/cycle\].
    pub stop_at_stderr: Option<f64>,
    /// Cycles that align the tangents after the transient, discarded.
    pub align: u64,
    /// Whether a twin trajectory is integrated beside the tangents.
    pub twin: bool,
    /// The norm in which growth is measured.
    pub norm: GrowthNorm,
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
pub struct NvhQuestion {
    /// Mesh harmonics of the deflection, 0 for none.
    pub harmonics: usize,
    /// Whether spectra of deflection and force are stored.
    pub spectrum: bool,
    /// Whether bearing forces are rebuilt from the modes, which costs more than the integration.
    pub bearings: bool,
}
