//! Which frequencies does the motion contain? Spectra of deflection, force and outputs of the structure:
//! exact lines of a periodic motion ([`Lines`]), averaged power of any other ([`Welch`]).

mod lines;
mod welch;

pub use lines::Lines;
pub use welch::Welch;

use super::modal_series::Series;
use super::outcome::Spectrum;
use crate::propagate::Window;

/// Spectra accumulated while a trajectory is integrated.
#[derive(Clone)]
pub enum Spectra {
    /// Exact lines of a periodic motion.
    Lines(Lines),
    /// Averaged power of any other motion.
    Welch(Welch),
}

impl Spectra {
    /// Forgets everything accumulated.
    pub fn restart(&mut self) {
        match self {
            Self::Lines(lines) => lines.restart(),
            Self::Welch(welch) => welch.restart(),
        }
    }

    /// Appends the record of another trajectory of the same model. Exact lines of a periodic motion remain
    /// those of one trajectory.
    pub(in crate::analysis) fn append(&mut self, other: &Self) {
        if let (Self::Welch(welch), Self::Welch(other)) = (self, other) {
            welch.append(other);
        }
    }

    /// Adds a window, with the series of the outputs.
    pub fn window(&mut self, window: &Window<'_>, outputs: &[Series]) {
        match self {
            Self::Lines(lines) => lines.window(window, outputs),
            Self::Welch(welch) => welch.window(window, outputs),
        }
    }

    /// Whether every signal has a spectrum by now.
    pub fn has_segments(&self) -> bool {
        match self {
            Self::Lines(_) => true,
            Self::Welch(welch) => welch.has_segments(),
        }
    }

    /// The spectra so far.
    pub fn spectra(&self) -> Vec<Spectrum> {
        match self {
            Self::Lines(lines) => lines.spectra(),
            Self::Welch(welch) => welch.spectra(),
        }
    }
}
