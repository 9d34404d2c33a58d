//! Which pictures are asked for?

use clap::ValueEnum;
use strum::{IntoStaticStr, VariantArray};

use super::column::Asked;
use super::display::Display;

/// A kind of picture.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, IntoStaticStr, VariantArray, ValueEnum,
)]
#[strum(serialize_all = "lowercase")]
pub enum What {
    /// Largest Lyapunov exponent: a map, or a curve over one axis.
    Lambda,
    /// Map of the kind of motion.
    Classes,
    /// Strobed deflection over one axis, with the exponent.
    Bifurcation,
    /// Followed orbits over their axis, stable and not, with their bifurcations.
    Branches,
    /// Bifurcation curves in the plane of both followed axes.
    Curves,
    /// Basin shares over one axis, a colour a branch of attractors.
    Shares,
    /// Slices of initial states, a colour an attractor.
    Basins,
    /// Multipliers of a point's periodic orbits, about the unit circle.
    Multipliers,
    /// How a kick off each periodic orbit of a point grows from return to return.
    Kicks,
    /// Deflection and force of a point over mesh orders.
    Spectrum,
    /// Spectra over one axis: orders or frequencies upwards, levels in colour.
    Waterfall,
    /// Levels of chosen mesh orders over one axis.
    Orders,
    /// Natural frequencies, orders and resonances over the speed, from the manifest.
    Campbell,
    /// How twins of a point part, and how its averages settle.
    Horizon,
    /// How the exponents of a point settled over the cycles measured.
    Convergence,
    /// Phase portrait of a trace, or strobe samples of a point.
    Phase,
    /// Deflection, force and contact of a trace over time.
    Trace,
    /// Stiffness, load centre and transmission error of a mesh table.
    Mesh,
    /// Load shares of the pairs of teeth of a mesh table.
    Sharing,
    /// Contact pattern of a mesh table.
    Contact,
}

impl What {
    /// Its name on the command line and at the start of file names.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

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
    /// How values are shown.
    pub display: Display,
}

impl PlotRequest {
    /// The signal of spectral lines.
    pub fn signal(&self) -> &str {
        self.signal.as_deref().unwrap_or("deflection")
    }
}
