//! At which excitation amplitude does an oscillator touch its stop? Unit mass, stiffness k, damping c and a stop at d:
//! the forced vibration `A cos ωt` reaches the stop at
//!
//! ```text
//! A = d √((k − ω²)² + c² ω²)
//! ```
//!
//! The amplitude is bisected between "no event" and "some events" of the kernel.

#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::{advance_with, volterra};
use gearatlas::model::{Drive, DriveShaft, InitialState, Model, OperatingPoint, TorqueRipple};

const GAP: f64 = 10e-6;
const NATURAL: f64 = 4000.0;
const DAMPING: f64 = 0.02;

struct Oscillator {
    speed: f64,
    /// Constant force \[N/√kg\].
    push: f64,
    /// Phase of the excitation, so that the mass reaches the stop within a mesh cycle.
    phase: f64,
}

impl Oscillator {
    fn forcing(&self) -> f64 {
        20.0 * self.speed
    }

    /// `(k − ω²)` and `c ω`.
    fn impedance(&self) -> [f64; 2] {
        let forcing = self.forcing();
        [
            NATURAL * NATURAL - forcing * forcing,
            2.0 * DAMPING * NATURAL * forcing,
        ]
    }

    /// The amplitude at which the vibration, about the deflection under the constant force, reaches the nearer stop.
    fn grazing(&self) -> f64 {
        let [stiff, loss] = self.impedance();
        (GAP - self.push / (NATURAL * NATURAL)) * stiff.hypot(loss)
    }

    fn model(&self, amplitude: f64) -> Model {
        let mut structure = common::structure(&[NATURAL], DAMPING, &[1.0], &[1.0]);
        structure.rated_force = 1.0;
        structure.pinion_torque = Some(vec![1.0]);
        let drive = Drive {
            damping: 480.0,
            torque_ripple: vec![TorqueRipple {
                shaft: DriveShaft::Pinion,
                order: 20.0,
                amplitude,
                phase: self.phase,
            }],
            ..common::constant_mesh(GAP, 1.44e8)
        };
        let point = OperatingPoint {
            load: self.push,
            speed: self.speed,
        };
        Model::new(&structure, &drive, point).unwrap()
    }

    /// Whether the forced vibration reaches a stop within two cycles, if the motion starts on it.
    fn touches(&self, amplitude: f64) -> bool {
        let model = self.model(amplitude);
        let [stiff, loss] = self.impedance();
        let size = amplitude / stiff.hypot(loss);
        let angle = self.phase - loss.atan2(stiff);
        let start = model.start(&InitialState::Modal {
            displacement: vec![self.push / (NATURAL * NATURAL) + size * angle.cos()],
            velocity: vec![-size * self.forcing() * angle.sin()],
        });
        let (_, counters) = advance_with(&volterra(&model), &start, 2, &mut ());
        counters.events > 0
    }
}

#[test]
fn a_stop_is_first_touched_at_the_amplitude_of_the_closed_form() {
    for speed in [120.0, 190.0, 205.0, 300.0] {
        // Without a push the mass reaches both stops at one amplitude; with a push it reaches the nearer stop first.
        for push in [0.0, 40.0, 90.0] {
            for phase in [-2.0, 0.3, 1.7] {
                let case = Oscillator { speed, push, phase };
                let expected = case.grazing();
                let (mut never, mut always) = (0.9 * expected, 1.1 * expected);
                assert!(!case.touches(never) && case.touches(always));
                while always - never > 1e-12 * expected {
                    let middle = 0.5 * (never + always);
                    if case.touches(middle) {
                        always = middle;
                    } else {
                        never = middle;
                    }
                }
                let found = 0.5 * (never + always) / expected - 1.0;
                assert!(found.abs() < 1e-9, "{speed} {push} {phase}: {found:e}");
            }
        }
    }
}
