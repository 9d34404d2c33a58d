//! The kinds of pictures.

use clap::ValueEnum;
use strum::{IntoStaticStr, VariantArray};

/// A kind of picture.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, IntoStaticStr, VariantArray, ValueEnum,
)]
#[strum(serialize_all = "lowercase")]
pub enum PictureKind {
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
    /// Basin shares over one axis, one colour per branch of attractors.
    Shares,
    /// Slices of initial states, one colour per attractor.
    Basins,
    /// Multipliers of a point's periodic orbits, about the unit circle.
    Multipliers,
    /// Growth of a kick from each periodic orbit of a point, return by return.
    Kicks,
    /// Deflection and force of a point over mesh orders.
    Spectrum,
    /// Spectra over one axis: orders or frequencies upwards, levels in colour.
    Waterfall,
    /// Levels of chosen mesh orders over one axis.
    Orders,
    /// Natural frequencies, orders and resonances over the speed, from the manifest.
    Campbell,
    /// Separation of twin trajectories of a point, and standard errors of its averages.
    Horizon,
    /// Lyapunov exponents of a point over the measured cycles.
    Convergence,
    /// Phase portrait of a trace, or strobe samples of a point.
    Phase,
    /// Deflection, force and contact of a trace over time.
    Trace,
    /// Spectra of a run-up over its speed: frequencies upwards, levels in colour.
    Spectrogram,
    /// Amplitudes of orders of a run-up over its speed.
    Tracks,
    /// Stiffness, load centre and transmission error of a mesh table.
    Mesh,
    /// Load shares of the pairs of teeth of a mesh table.
    Sharing,
    /// Contact pattern of a mesh table.
    Contact,
}

impl PictureKind {
    /// Its name on the command line and at the start of file names.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// The names of all kinds.
    pub(super) fn names() -> impl Iterator<Item = String> {
        Self::VARIANTS.iter().map(|kind| kind.name().to_owned())
    }
}
