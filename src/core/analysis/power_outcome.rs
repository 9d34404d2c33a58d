//! What the vibration takes in and gives off.

use serde::{Deserialize, Serialize};

/// Mean power of the vibration, of all contacts and the whole structure \[W\]:
/// `loads + error + stiffness = contact + structure + friction + stored`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct PowerOutcome {
    /// In, by mean torques, torque ripple and other loads.
    pub loads: f64,
    /// In, by transmission errors, flank errors and load centroids that are prescribed.
    pub error: f64,
    /// In, by stiffness that varies.
    pub stiffness: f64,
    /// Out, by the dampers of the contacts and springs let go compressed.
    pub contact: f64,
    /// Out, by damping of the structure, less what its cross-coupled springs feed.
    pub structure: f64,
    /// Out, by friction of the contacts at the speeds of vibration.
    pub friction: f64,
    /// Gain of stored energy over the record.
    pub stored: f64,
}

impl PowerOutcome {
    /// The largest power that comes in or goes out \[W\].
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
