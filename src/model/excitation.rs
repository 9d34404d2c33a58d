//! Transmission error and torque ripple as functions of time.

use std::f64::consts::TAU;

/// One harmonic of a transmission error, `amplitude cos(ω t + phase)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransmissionErrorHarmonic {
    /// Angular frequency ω \[rad/s\].
    pub angular_frequency: f64,
    /// Turns of its phase per mesh cycle.
    pub turns_per_cycle: f64,
    /// Amplitude \[m\].
    pub amplitude: f64,
    /// Phase \[rad\].
    pub phase: f64,
}

impl TransmissionErrorHarmonic {
    /// ω t \[rad\] at a time \[s\] within a mesh cycle.
    pub fn turned(&self, cycle: u64, time: f64) -> f64 {
        turned(self.angular_frequency, self.turns_per_cycle, cycle, time)
    }
}

/// ω t \[rad\] of an angular frequency \[rad/s\], with its turns a mesh cycle, at a time \[s\] within
/// a mesh cycle. The whole turns are dropped before the product can lose digits.
pub fn turned(angular_frequency: f64, turns_per_cycle: f64, cycle: u64, time: f64) -> f64 {
    TAU * (cycle as f64 * turns_per_cycle).fract() + angular_frequency * time
}

/// One harmonic of a torque, as the input it gives to every block.
#[derive(Debug, Clone, PartialEq)]
pub struct Ripple {
    /// Angular frequency \[rad/s\].
    pub angular_frequency: f64,
    /// Turns of its phase per mesh cycle; need not be rational.
    pub turns_per_cycle: f64,
    /// Phase at the start of mesh cycle 0 \[rad\].
    pub phase: f64,
    /// Amplitude of the input to each block.
    pub input: Vec<[f64; 2]>,
}

impl Ripple {
    /// Phase \[rad\] at a time \[s\] within a mesh cycle.
    pub fn phase_at(&self, cycle: u64, time: f64) -> f64 {
        // The whole turns are dropped before the product can lose digits.
        let turns = (cycle as f64 * self.turns_per_cycle).fract();
        self.phase + TAU * turns + self.angular_frequency * time
    }
}
