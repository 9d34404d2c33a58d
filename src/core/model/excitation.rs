//! Transmission error, torque ripple and other harmonic loads as functions of time.

use super::basis::Basis;
use super::error::{ModelError, check_in_range};
use super::{DriveShaft, MeshHarmonic, TorqueRipple};
use crate::structure::{HarmonicLoad, ModalStructure};
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
    /// The harmonic at a mesh period \[s\].
    pub(super) fn of_mesh(harmonic: &MeshHarmonic, period: f64) -> Self {
        let turns_per_cycle = harmonic.turns_per_cycle();
        Self {
            angular_frequency: TAU * turns_per_cycle / period,
            turns_per_cycle,
            amplitude: harmonic.amplitude,
            phase: harmonic.phase,
        }
    }

    /// ω t \[rad\] at a time \[s\] within a mesh cycle.
    pub fn turned(&self, cycle: u64, time: f64) -> f64 {
        turned(self.angular_frequency, self.turns_per_cycle, cycle, time)
    }
}

/// ω t \[rad\] at a time \[s\] within a mesh cycle, for an angular frequency \[rad/s\] and its turns per mesh
/// cycle. Whole turns of the previous mesh cycles are dropped, so that the angle stays small.
pub fn turned(angular_frequency: f64, turns_per_cycle: f64, cycle: u64, time: f64) -> f64 {
    TAU * (cycle as f64 * turns_per_cycle).fract() + angular_frequency * time
}

/// One harmonic of a torque or another load, as its input to every block.
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
    /// Whether the input is a second derivative in time: its amplitude then grows with the square of the
    /// speed.
    pub of_motion: bool,
}

impl Ripple {
    /// The ripple of a torque on one of the shafts, at a mesh period \[s\].
    pub(super) fn of_torque(
        structure: &ModalStructure,
        torque: &TorqueRipple,
        period: f64,
        basis: &Basis,
    ) -> Result<Self, ModelError> {
        let (_, participation, cycles_per_turn) = shaft_of(structure, torque.shaft)?;
        let turns_per_cycle = torque.order / cycles_per_turn;
        let scaled = |p: &f64| p * torque.amplitude;
        let force: Vec<f64> = basis.turn(participation).iter().map(scaled).collect();
        Ok(Self {
            angular_frequency: TAU * turns_per_cycle / period,
            turns_per_cycle,
            phase: torque.phase,
            input: basis.input(&force),
            of_motion: false,
        })
    }

    /// The ripple of a load of the structure.
    pub(super) fn of_load(
        load: &HarmonicLoad,
        period: f64,
        basis: &Basis,
    ) -> Result<Self, ModelError> {
        let turns = load.turns_per_cycle;
        check_in_range(
            "turns of a harmonic load per mesh cycle",
            turns,
            turns > 0.0,
            "above 0",
        )?;
        Ok(Self {
            angular_frequency: TAU * turns / period,
            turns_per_cycle: turns,
            phase: load.phase,
            input: basis.input(&basis.turn(&load.force)),
            of_motion: false,
        })
    }

    /// Phase \[rad\] at a time \[s\] within a mesh cycle.
    pub fn phase_at(&self, cycle: u64, time: f64) -> f64 {
        // Drop the whole turns of the previous mesh cycles, so that the angle stays small.
        let turns = (cycle as f64 * self.turns_per_cycle).fract();
        self.phase + TAU * turns + self.angular_frequency * time
    }
}

/// Name of a shaft, participation of a torque on it, and mesh cycles per revolution.
///
/// # Errors
/// [`ModelError::UnknownShaft`].
pub(super) fn shaft_of(
    structure: &ModalStructure,
    shaft: DriveShaft,
) -> Result<(&'static str, &[f64], f64), ModelError> {
    let (name, participation, cycles_per_turn) = match shaft {
        DriveShaft::Pinion => (
            "pinion",
            &structure.pinion_torque,
            Some(structure.cycles_per_turn()),
        ),
        DriveShaft::Wheel => (
            "wheel",
            &structure.wheel_torque,
            structure.wheel_teeth.map(f64::from),
        ),
    };
    match (participation, cycles_per_turn) {
        (Some(participation), Some(cycles)) => Ok((name, participation, cycles)),
        _ => Err(ModelError::UnknownShaft { shaft: name }),
    }
}

#[cfg(test)]
mod tests {
    use crate::model::{Model, ModelError, fixtures};
    use crate::structure::HarmonicLoad;

    /// A load with zero turns per mesh cycle is constant, not a harmonic.
    #[test]
    fn a_harmonic_load_turns_forwards() {
        let mut structure = fixtures::structure(&[0.0, 900.0], 0.01, &[1.0, 0.5], &[1.0, 0.5]);
        for (turns, legal) in [(1e-3, true), (0.0, false), (-1.0, false), (f64::NAN, false)] {
            structure.harmonic_loads = vec![HarmonicLoad {
                name: "shaker".to_owned(),
                force: vec![1.0, 0.2],
                turns_per_cycle: turns,
                phase: 0.3,
            }];
            let drive = fixtures::two_level_mesh(1e-5);
            match Model::new(&structure, &drive, fixtures::strong_rattle()) {
                Ok(model) => assert!(legal && model.ripple[0].turns_per_cycle == turns),
                Err(ModelError::OutOfRange { name, .. }) => {
                    assert!(!legal && name.contains("harmonic load"), "{name}");
                }
                Err(other) => panic!("{other}"),
            }
        }
    }
}
