//! Which frequencies does the motion hold? Spectra of deflection, force and bearing forces:
//! exact lines of a motion that repeats ([`Lines`]), averaged power of any other ([`Welch`]).

mod lines;
mod welch;

pub use lines::Lines;
pub use welch::Welch;

use super::modal_series::Series;
use super::outcome::Spectrum;
use crate::model::Model;
use crate::propagate::Window;

/// Highest multiple of the mesh frequency that spectra reach to.
pub const HIGHEST_ORDER: usize = 32;

/// Spectra that are taken while a trajectory is integrated.
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

    /// Takes a window in, with the series of its bearing forces.
    pub fn window(&mut self, window: &Window<'_>, bearings: &[Series]) {
        match self {
            Self::Lines(lines) => lines.window(window, bearings),
            Self::Welch(welch) => welch.window(window, bearings),
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

/// Names of the signals of a model: deflection, force, and bearing forces where `bearings`.
fn signals(model: &Model, bearings: bool) -> Vec<String> {
    let bearings = model.bearings.iter().filter(|_| bearings);
    ["deflection".to_owned(), "force".to_owned()]
        .into_iter()
        .chain(bearings.map(|bearing| format!("bearing {}", bearing.name)))
        .collect()
}
