//! The harmonics of the transmission error of a mesh.

/// One component of the transmission error of a mesh: a harmonic of the mesh frequency, or an order of a
/// shaft.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct MeshHarmonic {
    /// Number of periods in `cycles` cycles of the mesh, ≥ 1.
    pub harmonic: u32,
    /// 1 for a multiple of the mesh frequency; the number of teeth of a gear for an order of this gear's shaft.
    pub cycles: u32,
    /// Amplitude \[m\].
    pub amplitude: f64,
    /// Phase \[rad\].
    pub phase: f64,
}

impl MeshHarmonic {
    /// A harmonic of the mesh frequency, with an amplitude \[m\] and a phase \[rad\].
    pub const fn new(harmonic: u32, amplitude: f64, phase: f64) -> Self {
        Self {
            harmonic,
            cycles: 1,
            amplitude,
            phase,
        }
    }

    /// This harmonic with the angle `turned` \[rad\] added to its phase.
    #[must_use]
    pub fn with_phase_lead(self, turned: f64) -> Self {
        Self {
            phase: self.phase + turned,
            ..self
        }
    }

    /// Turns of its phase in a mesh cycle.
    pub fn turns_per_cycle(&self) -> f64 {
        f64::from(self.harmonic) / f64::from(self.cycles)
    }
}
