//! The request for pictures.

use super::column::PictureRequest;
use super::display::Display;
use crate::manifest::Measured;

/// Default mesh orders.
pub const DEFAULT_ORDERS: [f64; 3] = [1.0, 2.0, 3.0];

/// The requested pictures.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PlotRequest {
    /// Kinds of pictures and columns; empty for all kinds that the data allow.
    pub what: Vec<PictureRequest>,
    /// Axis of pictures over one axis; default: a map over two axes, else the swept axis or the one with most values.
    pub over: Option<String>,
    /// Axis whose values become the curves of one picture.
    pub by: Option<String>,
    /// `point_id` of pictures of one point; default: the most chaotic point, or the one with the largest RMS. Basins,
    /// multipliers and kicks have a picture of every point by default.
    pub point: Option<u64>,
    /// Mesh orders of order cuts; empty for [`DEFAULT_ORDERS`].
    pub orders: Vec<f64>,
    /// Signal of spectral lines, as in spectra.parquet; default: the deflection.
    pub signal: Option<String>,
    /// Whether a waterfall shows frequencies instead of orders.
    pub frequency: bool,
    /// Measured points, drawn over the curves of their column.
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
