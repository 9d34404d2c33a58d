//! Which analyses of an operating point can a manifest request?

use super::config::{LyapunovConfig, NvhConfig};
use super::covariant::CovariantConfig;
use super::horizon::HorizonConfig;
use super::multistability::MultistabilityConfig;
use super::orbits::survey::OrbitConfig;
use super::poincare::PoincareConfig;
use serde::Serialize;

/// The analyses of an operating point, as in the manifest; absent ones are not computed.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Analyses {
    /// Lyapunov exponents.
    pub lyapunov: Option<LyapunovConfig>,
    /// Poincaré samples.
    pub poincare: Option<PoincareConfig>,
    /// Noise, vibration and harshness statistics.
    pub nvh: Option<NvhConfig>,
    /// Coexisting attractors.
    pub multistability: Option<MultistabilityConfig>,
    /// Periodic orbits, stable or not.
    pub orbits: Option<OrbitConfig>,
    /// Predictability of chaotic motion.
    pub horizon: Option<HorizonConfig>,
    /// Covariant Lyapunov vectors.
    pub covariant: Option<CovariantConfig>,
}
