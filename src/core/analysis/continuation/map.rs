//! The map over whole mesh cycles, the interface between continuation and a system.
//!
//! The coordinates u are those of the energy norm in half gaps, without the neutral pair. Distances are
//! relative to the size of the orbit ([`Details::size`]), because an orbit may be much smaller than the gap.
//! The map is that of a drive ([`super::drive::DriveMap`]) or, in tests, a map with a known normal form.

use super::touches::Touches;
use faer::Mat;

/// Two parameters of a map.
pub type MapParameters = [f64; 2];

/// Reasons why the map cannot be evaluated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MapError {
    /// There is no model with these parameters.
    #[error("{0}")]
    NoModel(String),
    /// The excitation is not periodic.
    #[error("the excitation is not periodic, so there are no periodic orbits")]
    NeverRepeats,
    /// A trajectory cannot be integrated.
    #[error("{0}")]
    Stop(#[from] crate::propagate::Stop),
}

/// The image of a point after some cycles.
#[derive(Debug, Clone)]
pub struct Image {
    /// The end point.
    pub end: Vec<f64>,
    /// Derivative of the end point with respect to the start.
    pub monodromy: Mat<f64>,
}

/// Properties of an orbit over its period.
#[derive(Debug, Clone, Default)]
pub struct Details {
    /// u at the start of every cycle.
    pub strobes: Vec<Vec<f64>>,
    /// Modal displacement \[m √kg\] and velocity \[m √kg/s\] at the start of the first cycle, one entry per mode.
    pub start: [Vec<f64>; 2],
    /// The contact sequence, and the extremes of every contact's depth.
    pub touches: Touches,
    /// Motion of the mesh over a period.
    pub motion: Motion,
    /// Size of the motion in the unit of u: half the range of δ, or of a contact's depth if that is larger. Zero if
    /// the map does not specify it; u is then of the order of 1.
    pub size: f64,
}

/// Motion of the mesh over a period.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Motion {
    /// Root mean square of δ about its mean \[m\].
    pub rms: f64,
    /// Mean of δ \[m\].
    pub mean: f64,
    /// Smallest δ \[m\].
    pub smallest: f64,
    /// Largest δ \[m\].
    pub largest: f64,
    /// Largest \|F\| \[N\].
    pub force_peak: f64,
}

/// A map over mesh cycles that depends on two parameters.
pub trait CycleMap {
    /// Number of coordinates.
    fn dimension(&self) -> usize;

    /// Period of the excitation in cycles. Periods of orbits are multiples of it.
    fn unit(&self) -> u32 {
        1
    }

    /// The image of u after `period` cycles.
    ///
    /// # Errors
    /// [`MapError`].
    fn image(&mut self, u: &[f64], at: MapParameters, period: u32) -> Result<Image, MapError>;

    /// The derivative of that image with respect to the parameter `axis`, per unit.
    ///
    /// # Errors
    /// [`MapError`].
    fn by_parameter(
        &mut self,
        u: &[f64],
        at: MapParameters,
        period: u32,
        axis: usize,
    ) -> Result<Vec<f64>, MapError>;

    /// The same derivative for Newton's method, for which a low accuracy is sufficient. It may be a
    /// difference quotient over `step`.
    ///
    /// # Errors
    /// [`MapError`].
    fn near_derivative(
        &mut self,
        u: &[f64],
        at: MapParameters,
        period: u32,
        (axis, _step): (usize, f64),
    ) -> Result<Vec<f64>, MapError> {
        self.by_parameter(u, at, period, axis)
    }

    /// The properties of the trajectory over `period` cycles from u.
    ///
    /// # Errors
    /// [`MapError`].
    fn details(&mut self, u: &[f64], at: MapParameters, period: u32) -> Result<Details, MapError>;
}
