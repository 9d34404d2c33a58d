//! Which frequencies does the motion hold? Spectra of deflection, force and outputs of the structure:
//! exact lines of a motion that repeats ([`Lines`]), averaged power of any other ([`Welch`]).

mod lines;
mod welch;

pub use lines::Lines;
pub use welch::Welch;

use super::modal_series::Series;
use super::outcome::Spectrum;
use crate::propagate::Window;

/// Spectra that are taken while a trajectory is integrated.
#[derive(Clone)]
pub enum Spectra {
    /// Of a motion that repeats.
    Lines(Lines),
    /// Of any other.
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

    /// Adds the record of another trajectory of the same model behind this one. Exact lines of a
    /// motion that repeats stay those of one trajectory.
    pub(in crate::analysis) fn append(&mut self, other: &Self) {
        if let (Self::Welch(welch), Self::Welch(other)) = (self, other) {
            welch.append(other);
        }
    }

    /// Takes a window in, with the series of the outputs.
    pub fn window(&mut self, window: &Window<'_>, outputs: &[Series]) {
        match self {
            Self::Lines(lines) => lines.window(window, outputs),
            Self::Welch(welch) => welch.window(window, outputs),
        }
    }

    /// Whether there is something to tell of every signal.
    pub fn begun(&self) -> bool {
        match self {
            Self::Lines(_) => true,
            Self::Welch(welch) => welch.begun(),
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
