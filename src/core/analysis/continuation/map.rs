//! What continuation needs to know of a system: its map over whole cycles.
//!
//! Coordinates u are those of the energy norm in half gaps, the neutral pair left out. What is far and
//! near is told by the size of the orbit itself ([`Details::size`]): a gap may never be met. A planted map with a known normal form serves as well as a
//! drive ([`super::drive::DriveMap`]).

use super::touches::Touches;
use faer::Mat;

/// Two parameters of a map.
pub type At = [f64; 2];

/// Where a map has no value.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MapError {
    /// There is no model with these parameters.
    #[error("{0}")]
    NoModel(String),
    /// What drives the system does not repeat.
    #[error("the excitation is not periodic, so there are no periodic orbits")]
    NeverRepeats,
    /// A trajectory cannot be integrated.
    #[error("{0}")]
    Stop(#[from] crate::propagate::Stop),
}

/// The image of a point after some cycles.
#[derive(Debug, Clone)]
pub struct Image {
    /// Where it ends.
    pub end: Vec<f64>,
    /// Derivative of the end by the start.
    pub monodromy: Mat<f64>,
}

/// What an orbit is like on its way.
#[derive(Debug, Clone, Default)]
pub struct Details {
    /// u at the start of every cycle.
    pub strobes: Vec<Vec<f64>>,
    /// Modal displacement \[m √kg\] and velocity \[m √kg/s\] at the start of the first cycle, one entry a mode each.
    pub start: [Vec<f64>; 2],
    /// How contacts are touched.
    pub touches: Touches,
    /// Motion of the mesh over a period.
    pub motion: Motion,
    /// Size of the motion, in the unit of u: half of what the depth of a contact, or δ, swings by. Zero where
    /// the map does not say; u is of the order of 1 then.
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

/// A map of cycles that depends on two parameters.
pub trait CycleMap {
    /// Number of coordinates.
    fn dimension(&self) -> usize;

    /// Cycles after which what drives the system repeats: periods are its multiples.
    fn unit(&self) -> u32 {
        1
    }

    /// The image of u after `period` cycles.
    ///
    /// # Errors
    /// [`MapError`].
    fn image(&mut self, u: &[f64], at: At, period: u32) -> Result<Image, MapError>;

    /// The derivative of that image by the parameter `axis`, per unit.
    ///
    /// # Errors
    /// [`MapError`].
    fn by_parameter(
        &mut self,
        u: &[f64],
        at: At,
        period: u32,
        axis: usize,
    ) -> Result<Vec<f64>, MapError>;

    /// What the way of `period` cycles from u is like.
    ///
    /// # Errors
    /// [`MapError`].
    fn details(&mut self, u: &[f64], at: At, period: u32) -> Result<Details, MapError>;
}
