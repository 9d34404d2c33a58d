//! Which pictures are asked for?

use clap::ValueEnum;
use strum::{IntoStaticStr, VariantArray};

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
    /// How twins of a point part, and how its averages settle.
    Horizon,
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

/// What to draw.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct PlotRequest {
    /// Kinds of pictures; empty for all that the data allow.
    pub what: Vec<What>,
    /// Axis of pictures over one axis; else the one with most values.
    pub over: Option<String>,
    /// `point_id` of pictures of one point; else the loudest or most chaotic one.
    pub point: Option<u64>,
}
