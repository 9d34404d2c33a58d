//! What spectra and orders are taken of, and where it stands on a window.

use super::config::Signals;
use super::modal_series::{Series, padded};
use super::outputs::named;
use crate::model::Model;
use crate::propagate::Window;

/// A signal by its name and unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Signal {
    /// `deflection`, `force`, or a quantity with its place.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    place: Place,
}

/// Where a signal stands on a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    Deflection,
    Force,
    /// Among the outputs that are computed.
    Output(usize),
}

impl Signal {
    /// Those asked for that a model has, where the outputs of the `computed` are at hand.
    pub fn asked(model: &Model, asked: Signals, computed: Signals) -> Vec<Self> {
        let own = |name: &str, unit, place| Self {
            name: name.to_owned(),
            unit,
            place,
        };
        let deflection = (asked.deflection).then(|| own("deflection", "m", Place::Deflection));
        let force = (asked.force).then(|| own("force", "N", Place::Force));
        let outputs = (named(model, computed).enumerate())
            .filter(|(_, (_, quantity))| asked.has(*quantity))
            .map(|(index, (name, quantity))| own(&name, quantity.unit(), Place::Output(index)));
        (deflection.into_iter().chain(force).chain(outputs)).collect()
    }

    /// Its series on a window whose outputs are known.
    pub fn series(&self, window: &Window<'_>, outputs: &[Series]) -> Series {
        match self.place {
            Place::Deflection => padded(window.deflection),
            Place::Force => padded(window.force),
            Place::Output(index) => outputs[index],
        }
    }
}
