//! The signals that have spectra and orders.

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
    /// Unit of the signal.
    pub unit: &'static str,
    place: Place,
}

/// Source of a signal in a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    Deflection,
    Force,
    /// Index among the computed outputs.
    Output(usize),
}

impl Signal {
    /// The `requested` signals that a model has, if the outputs in `computed` are available.
    pub fn requested(model: &Model, requested: Signals, computed: Signals) -> Vec<Self> {
        let signal = |name: &str, unit, place| Self {
            name: name.to_owned(),
            unit,
            place,
        };
        let deflection =
            (requested.deflection).then(|| signal("deflection", "m", Place::Deflection));
        let force = (requested.force).then(|| signal("force", "N", Place::Force));
        let outputs = (named(model, computed).enumerate())
            .filter(|(_, (_, quantity))| requested.has(*quantity))
            .map(|(index, (name, quantity))| signal(&name, quantity.unit(), Place::Output(index)));
        (deflection.into_iter().chain(force).chain(outputs)).collect()
    }

    /// Series of the signal on a window with known outputs.
    pub fn series(&self, window: &Window<'_>, outputs: &[Series]) -> Series {
        match self.place {
            Place::Deflection => padded(window.deflection),
            Place::Force => padded(window.force),
            Place::Output(index) => outputs[index],
        }
    }
}
