//! Two parallel shafts as a train, each with a gear between two bearings and an end inertia on an overhang.

use super::body::GearBody;
use super::disc::Disc;
use super::drive::{Motion, Shaft};
use super::error::ShaftError;
use super::train::{GearPlace, TrainDrive, TrainGear, TrainShaft};
use crate::gear::GearPair;

/// Common part of flexible and rigid drives.
pub(super) struct TwoShafts<'a> {
    pub gears: &'a GearPair,
    pub shafts: &'a [Shaft; 2],
    /// \[kg/m³\]
    pub density: f64,
    pub damping: f64,
    pub damping_overrides: &'a [(usize, f64)],
    pub gyroscopic: bool,
}

impl TwoShafts<'_> {
    /// The body of the gear on a shaft.
    pub fn body(&self, index: usize) -> Result<GearBody, ShaftError> {
        GearBody::new(self.gears, index, self.shafts[index].diameter, self.density)
    }

    /// A shaft without sections, with its first bearing at a position \[m\] and a gear body on it.
    pub fn shaft(
        &self,
        index: usize,
        first_bearing: f64,
        body: Disc,
    ) -> Result<TrainShaft, ShaftError> {
        let shaft = &self.shafts[index];
        let gears = self.gears;
        let at = first_bearing + shaft.gear_position * shaft.span;
        let end = first_bearing - shaft.overhang;
        let inertia = Disc {
            polar_inertia: shaft.end_inertia,
            ..Disc::default()
        };
        let name = ["pinion", "wheel"][index].to_owned();
        let gear = TrainGear {
            name: name.clone(),
            at,
            teeth: gears.teeth[index],
            internal: false,
            module: gears.module,
            pressure_angle: gears.pressure_angle,
            helix_angle: [1.0, -1.0][index] * gears.helix_angle,
            width: gears.face_width,
            body,
            hub: None,
            loose: None,
        };
        let across = [0.0, gears.centre_distance()?][index];
        let bearings = [first_bearing, first_bearing + shaft.span];
        Ok(TrainShaft {
            name,
            origin: [across, 0.0, -at],
            direction: [0.0, 0.0, 1.0],
            sections: Vec::new(),
            element: None,
            motion: Motion::All,
            discs: vec![(end, inertia)],
            gears: vec![gear],
            bearings: bearings.into_iter().zip(shaft.bearings).collect(),
            torque_at: end,
            output: [0.0, 1.0][index],
            drag: shaft.drag,
        })
    }

    /// The train of two shafts, with moduli of 0, as for shafts that do not bend.
    pub fn train(&self, shafts: [TrainShaft; 2]) -> TrainDrive {
        TrainDrive {
            shafts: shafts.into(),
            gears: [0, 1].map(|shaft| GearPlace { shaft, gear: 0 }),
            pair: self.gears.clone(),
            meshes: Vec::new(),
            couplings: Vec::new(),
            stops: Vec::new(),
            planetary: Vec::new(),
            housing: None,
            driver: 0,
            young_modulus: 0.0,
            shear_modulus: 0.0,
            density: self.density,
            shear_coefficient: 0.0,
            damping: self.damping,
            damping_overrides: self.damping_overrides.to_vec(),
            gyroscopic: self.gyroscopic,
            bearing_load: None,
        }
    }
}
