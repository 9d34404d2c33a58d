//! Signals at even instants.

/// Signals at even instants, the first at time 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Instants {
    /// Samples a second.
    pub rate: f64,
    /// Signal after signal, a value an instant.
    pub values: Vec<Vec<f64>>,
}
