//! All that a manifest may ask of an operating point.

use super::covariant::CovariantQuestion;
use super::horizon::HorizonQuestion;
use super::multistability::MultistabilityQuestion;
use super::orbits::survey::OrbitQuestion;
use super::poincare::PoincareQuestion;
use super::questions::{LyapunovQuestion, NvhQuestion};
use serde::Serialize;

/// The analyses of an operating point, as manifests have them; what is absent is not computed.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Analyses {
    /// Lyapunov exponents.
    pub lyapunov: Option<LyapunovQuestion>,
    /// Poincaré samples.
    pub poincare: Option<PoincareQuestion>,
    /// Noise, vibration and harshness statistics.
    pub nvh: Option<NvhQuestion>,
    /// Coexisting attractors.
    pub multistability: Option<MultistabilityQuestion>,
    /// Periodic orbits, stable or not.
    pub orbits: Option<OrbitQuestion>,
    /// Predictability of chaotic motion.
    pub horizon: Option<HorizonQuestion>,
    /// Covariant Lyapunov vectors.
    pub covariant: Option<CovariantQuestion>,
}
