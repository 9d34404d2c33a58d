//! What is asked for?

use super::column::Asked;
use super::display::Display;
use crate::manifest::Measured;

/// Mesh orders shown where none are asked for.
pub const USUAL_ORDERS: [f64; 3] = [1.0, 2.0, 3.0];

/// What to draw.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PlotRequest {
    /// Kinds of pictures and columns; empty for all kinds that the data allow.
    pub what: Vec<Asked>,
    /// Axis of pictures over one axis; else the one with most values.
    pub over: Option<String>,
    /// Axis whose values are curves of one picture.
    pub by: Option<String>,
    /// `point_id` of pictures of one point; else the loudest or most chaotic one.
    pub point: Option<u64>,
    /// Mesh orders of order cuts; empty for [`USUAL_ORDERS`].
    pub orders: Vec<f64>,
    /// Signal of spectral lines, as in spectra.parquet; else the deflection.
    pub signal: Option<String>,
    /// Frequencies instead of orders in a waterfall.
    pub frequency: bool,
    /// Measured points, laid over the curves of the column that they name.
    pub measured: Option<Measured>,
    /// How values are shown.
    pub display: Display,
}

impl PlotRequest {
    /// The signal of spectral lines.
    pub fn signal(&self) -> &str {
        self.signal.as_deref().unwrap_or("deflection")
    }
}
