//! The powers that the vibration takes in and gives off.

use serde::{Deserialize, Serialize};

/// Mean power of the vibration, over all contacts and the whole structure \[W\]:
/// `loads + error + stiffness = contact + structure + friction + stored`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct PowerOutcome {
    /// Input by mean torques, torque ripple and other loads.
    pub loads: f64,
    /// Input by prescribed transmission errors, flank errors, half gaps, load centroids and motions of stops.
    pub error: f64,
    /// Input by varying stiffness.
    pub stiffness: f64,
    /// Output by the dampers of the contacts, by springs released while compressed, by slipping dry sliders, and by
    /// impacts on rigid stops.
    pub contact: f64,
    /// Output by damping of the structure, minus the input by its cross-coupled springs.
    pub structure: f64,
    /// Output by friction on the flanks at the speeds of vibration, and by dry friction.
    pub friction: f64,
    /// Gain of stored energy over the record.
    pub stored: f64,
}

impl PowerOutcome {
    /// The largest input or output \[W\].
    pub fn largest(&self) -> f64 {
        let Self {
            loads,
            error,
            stiffness,
            contact,
            structure,
            friction,
            stored: _,
        } = *self;
        [loads, error, stiffness, contact, structure, friction]
            .into_iter()
            .fold(0.0, |largest, power| power.abs().max(largest))
    }
}
