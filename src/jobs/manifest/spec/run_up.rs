//! What a run-up is, and what of it is recorded.

use crate::analysis::Signals;

/// What `[runup]` asks for.
#[derive(Debug, Clone, PartialEq)]
pub struct RunUpSpec {
    /// Speeds of the pinion at start and end \[rad/s\].
    pub speed: [f64; 2],
    /// Time between them \[s\].
    pub duration: f64,
    /// Load at start and end, as a fraction of the rated one; none for that of the operating point.
    pub load: Option<[f64; 2]>,
    /// Time at the first speed before \[s\].
    pub settle: f64,
    /// Samples a second.
    pub sample_rate: u32,
    /// Revolutions of the pinion over which orders and levels are taken.
    pub revolutions: u32,
    /// Orders of the pinion's rotation; none for the first of the mesh.
    pub orders: Option<Vec<f64>>,
    /// Distance of lines of the spectrogram \[Hz\].
    pub frequency_step: u32,
    /// What is recorded.
    pub signals: Signals,
}
