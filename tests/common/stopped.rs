//! An oscillator with a stop on one side and known solutions, as a family for continuation.

// Every test binary uses a part of it; benches also use it, outside any test.
#![allow(dead_code)]

use gearatlas::analysis::continuation::drive::ParametricDrive;
use gearatlas::analysis::continuation::map::MapParameters;
use gearatlas::model::{Basis, Division, Drive, Model, ModelDerivative, OperatingPoint, Release};
use gearatlas::structure::{Coupling, HarmonicLoad, ModalStructure};

/// Distance that keeps the oscillator away from the other flank.
pub const OFF: f64 = 50.0;

/// Amplitude of the published motion at ω = 0.8.
pub const PUBLISHED: f64 = 0.9 * 0.64 / 1.26;

/// `x'' + 2ζ x' + x = A cos(ωt) − κ (x − gap)` beyond the gap, over (ω, A).
pub struct Stopped {
    /// Damping ratio ζ.
    pub damping: f64,
    /// Stiffness of the stop κ.
    pub stop: f64,
    /// Whether the body whirls: gyroscopic terms proportional to ω, and a damper, couple modes of frequencies 1 and 1.3.
    /// Both deflect the stop, and forces act on the first one.
    pub whirls: bool,
}

impl Stopped {
    fn structure(&self) -> ModalStructure {
        let of_modes = ModalStructure::of_modes;
        if !self.whirls {
            return of_modes(&[1.0], self.damping, &[1.0], &[1.0]);
        }
        ModalStructure {
            coupling: Some(Coupling {
                damping: vec![0.02, 0.03, 0.03, 0.05],
                gyroscopic: vec![0.0, 0.4, -0.4, 0.0],
                stiffness: vec![0.0; 4],
            }),
            ..of_modes(&[1.0, 1.3], self.damping, &[1.0, 0.6], &[1.0, 0.0])
        }
    }
}

impl ParametricDrive for Stopped {
    fn model(&self, [omega, amplitude]: MapParameters) -> Result<Model, String> {
        let mut structure = self.structure();
        structure.harmonic_loads = vec![HarmonicLoad {
            name: "force".to_owned(),
            force: structure.torque.iter().map(|t| t * amplitude).collect(),
            turns_per_cycle: 1.0,
            phase: 0.0,
        }];
        // A static load shifts the oscillator, so that only one flank is near.
        let drive = Drive {
            half_gap: 1.0 + OFF,
            mesh: Division::levels(&[self.stop], &[]),
            damping: 0.0,
            friction: 0.0,
            release: Release::Deflection,
            coast: None,
            transmission_error: Vec::new(),
            torque_ripple: Vec::new(),
            further: Vec::new(),
            imposed_motion: Vec::new(),
            film: None,
            tooth_cycles: Default::default(),
        };
        let point = OperatingPoint {
            load: OFF,
            speed: omega,
        };
        Model::new(&structure, &drive, point).map_err(|error| error.to_string())
    }

    /// Central differences of the sixth order.
    fn derivative(
        &self,
        at: MapParameters,
        axis: usize,
        through: &Basis,
    ) -> Result<ModelDerivative, String> {
        let h = 1e-3;
        let models: Vec<(f64, Model)> = [
            (0.0, 0.0),
            (1.0, 45.0),
            (2.0, -9.0),
            (3.0, 1.0),
            (-1.0, -45.0),
            (-2.0, 9.0),
            (-3.0, -1.0),
        ]
        .into_iter()
        .map(|(steps, weight)| {
            let mut there = at;
            there[axis] += steps * h;
            Ok((weight / (60.0 * h), self.model(there)?))
        })
        .collect::<Result<_, String>>()?;
        let models: Vec<(f64, &Model)> = models.iter().map(|(w, m)| (*w, m)).collect();
        Model::combined(&models, through).map_err(|error| error.to_string())
    }

    fn event_limit(&self) -> u32 {
        1000
    }
}
