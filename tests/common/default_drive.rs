//! The default drive from its drawing: gears, shafts on bearings, and both together.

// Every test binary uses a part of it.
#![allow(dead_code)]

use gearatlas::gear::{GearPair, ToothForm};
use gearatlas::shaft::{Bearing, Drag, FlexibleDrive, Shaft};

/// Density of steel \[kg/m³\].
pub const DENSITY: f64 = 7850.0;

/// The gears of the default drive: module 4 mm, 20 mm wide, 50 N m.
pub fn gears() -> GearPair {
    GearPair {
        teeth: [20, 30],
        module: 4e-3,
        pressure_angle: 20f64.to_radians(),
        helix_angle: 0.0,
        face_width: 20e-3,
        body_length: [70e-3, 40e-3],
        rated_torque: 50.0,
        form: ToothForm::default(),
    }
}

/// A bearing of the shafts; only the first bearing of each shaft has an axial stiffness.
pub fn bearing(axial: f64) -> Bearing {
    Bearing {
        x: 1.25e8,
        y: 1e8,
        axial,
        tilt: 2e4,
        ..Bearing::default()
    }
}

/// The shafts of the default drive.
pub fn shafts() -> [Shaft; 2] {
    [(22e-3, 2e-3), (26e-3, 5e-3)].map(|(diameter, end_inertia)| Shaft {
        diameter,
        inner_diameter: 0.0,
        span: 0.12,
        overhang: 0.04,
        gear_position: 0.45,
        end_inertia,
        bearings: [bearing(1e8), bearing(0.0)],
        drag: Drag::default(),
    })
}

/// Gears on shafts as beams of few elements.
pub fn flexible() -> FlexibleDrive {
    FlexibleDrive {
        gears: gears(),
        shafts: shafts(),
        young_modulus: 206e9,
        shear_modulus: 79e9,
        density: DENSITY,
        shear_coefficient: 0.9,
        elements: [3, 5, 7],
        damping: 0.01,
        damping_overrides: Vec::new(),
        gyroscopic: false,
    }
}
