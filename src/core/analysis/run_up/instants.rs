//! Signals at evenly spaced instants.

/// Signals at evenly spaced instants, the first at time 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Instants {
    /// Samples per second.
    pub rate: f64,
    /// Values by signal and instant.
    pub values: Vec<Vec<f64>>,
}
