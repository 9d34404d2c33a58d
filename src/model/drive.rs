//! Mesh and excitation of a drive, and where it is operated.

use super::{FlankError, Stiffness};
use serde::Serialize;

/// Mesh and excitation of a drive, without its operating point.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// Backlash half gap b \[m\], > 0.
    pub half_gap: f64,
    /// The divisions of the mesh cycle, in order; the last ends at 1.
    pub mesh: Vec<Division>,
    /// Contact damping c \[N s/m\].
    pub damping: f64,
    /// Coulomb friction coefficient μ.
    pub friction: f64,
    /// Transmission error that is imposed, `e(φ) = Σ amplitude cos(2π harmonic φ + phase)`, φ the
    /// mesh phase in cycles.
    pub transmission_error: Vec<MeshHarmonic>,
    /// Torque ripple, `T(t) = Σ amplitude cos(order Ω_shaft t + phase)`.
    pub torque_ripple: Vec<TorqueRipple>,
}

/// A division of the mesh cycle: the stretch from the end of the one before to its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Division {
    /// Mesh phase at its end, in cycles.
    pub end: f64,
    /// Mesh stiffness over it.
    pub stiffness: Stiffness,
    /// What loaded flanks lack over it.
    pub error: FlankError,
    /// Load centroid z_c: where along the face the mesh force acts \[m\].
    pub load_centre: f64,
    /// Friction direction Λ: what μ times the mesh force weighs of the structure's
    /// participation in a friction force at the pitch point \[1\], and of that by the position
    /// along the path of contact \[m\].
    pub friction: [f64; 2],
}

impl Division {
    /// A division of constant stiffness \[N/m\], loaded at mid-face, whose friction acts at the
    /// pitch point in its positive direction.
    pub const fn level(end: f64, stiffness: f64) -> Self {
        Self {
            end,
            stiffness: Stiffness::constant(stiffness),
            error: FlankError::NONE,
            load_centre: 0.0,
            friction: [1.0, 0.0],
        }
    }

    /// Divisions of one stiffness \[N/m\] each.
    ///
    /// * `transitions`: where each stiffness gives way to the next, increasing, inside
    ///   (0, 1), one fewer than `stiffness`; none for equal divisions.
    pub fn levels(stiffness: &[f64], transitions: &[f64]) -> Vec<Self> {
        let count = stiffness.len() as f64;
        let end = |i: usize| match transitions.is_empty() {
            true => (i + 1) as f64 / count,
            false => transitions.get(i).copied().unwrap_or(1.0),
        };
        (stiffness.iter().enumerate())
            .map(|(i, &level)| Self::level(end(i), level))
            .collect()
    }
}

/// One harmonic of the transmission error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MeshHarmonic {
    /// Multiple of the mesh frequency, ≥ 1.
    pub harmonic: u32,
    /// Amplitude \[m\].
    pub amplitude: f64,
    /// Phase \[rad\].
    pub phase: f64,
}

impl MeshHarmonic {
    /// A harmonic of some amplitude \[m\] and phase \[rad\].
    pub const fn new(harmonic: u32, amplitude: f64, phase: f64) -> Self {
        Self {
            harmonic,
            amplitude,
            phase,
        }
    }
}

/// One harmonic of the torque on a shaft.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TorqueRipple {
    /// Which shaft.
    pub shaft: DriveShaft,
    /// Multiple of that shaft's speed, > 0 (need not be whole: firing orders).
    pub order: f64,
    /// Amplitude \[N m\].
    pub amplitude: f64,
    /// Phase \[rad\].
    pub phase: f64,
}

/// One of the two shafts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum DriveShaft {
    /// The driving shaft.
    Pinion,
    /// The driven shaft.
    Wheel,
}

/// Load and speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OperatingPoint {
    /// Fraction of the rated mesh force.
    pub load: f64,
    /// Pinion speed Ω \[rad/s\], > 0.
    pub speed: f64,
}
