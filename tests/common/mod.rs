//! Hand-built drives from one degree of freedom to forty modes, and comparisons of states. All drives rattle from the
//! equilibrium of their mean stiffness (asserted in `tests/motion/reference.rs`).
//!
//! Mesh data are those of a 20/30-tooth steel pair of module 4 mm and 20 mm face width: single- and double-pair
//! stiffness 3.333e8 and 4.444e8 N/m with contact ratio 1.6, transmission error 5 µm at the mesh frequency, pinion
//! speed 1200 rad/s.

// Every test binary uses a part of it; benches also use it, outside any test.
#![allow(dead_code, clippy::unwrap_used)]

pub mod advance;
pub mod default_drive;
#[path = "../../src/core/model/fixtures.rs"]
pub mod fixtures;
pub mod motions;
pub mod skipped;

pub use fixtures::*;

use gearatlas::model::{
    Division, Drive, DriveShaft, MeshHarmonic, Model, OperatingPoint, TorqueRipple,
};
use gearatlas::store::TableStore;
use gearatlas::structure::{FlankParticipation, ModalStructure};
use gearatlas::sweep::Prepared;
use std::path::Path;

/// A drive at an operating point.
pub type Case = (ModalStructure, Drive, OperatingPoint);

/// All drives, with their names.
pub fn drives() -> Vec<(&'static str, Case)> {
    vec![
        ("one degree", one_degree()),
        ("two modes", two_modes()),
        ("six modes", six_modes()),
        ("twenty modes", twenty_modes()),
        ("forty modes", forty_modes()),
    ]
}

/// The model of a drive.
pub fn model(case: &Case) -> Model {
    Model::new(&case.0, &case.1, case.2).unwrap()
}

/// The model of a drive at another load and speed.
pub fn model_at((structure, drive, _): &Case, load: f64, speed: f64) -> Model {
    Model::new(structure, drive, OperatingPoint { load, speed }).unwrap()
}

/// Only the relative rotation, rigid: one degree of freedom.
pub fn one_degree() -> Case {
    let structure = structure(&[0.0], 0.0, &[1.3], &[1.3]);
    (structure, two_level_mesh(10e-6), strong_rattle())
}

/// Two rigid bodies: a neutral and a relative rotation, not yet separated.
pub fn two_modes() -> Case {
    let mesh = [0.98, -0.86];
    let structure = structure(&[0.0, 0.0], 0.0, &mesh, &mesh);
    (structure, two_level_mesh(9e-6), strong_rattle())
}

/// A line of the coast flank of [`six_modes`], with the opposite sign in two of the elastic modes.
pub fn coast_line(structure: &ModalStructure) -> FlankParticipation {
    let mut mesh = structure.mesh.clone();
    for i in [2, 4] {
        mesh[i] = -mesh[i];
    }
    FlankParticipation {
        mesh,
        tilt: vec![0.0; 6],
        friction: structure.friction.iter().map(|f| -0.7 * f).collect(),
        lever: structure.friction_lever.clone(),
        residual_flexibility: 0.0,
    }
}

/// Rigid pair and four elastic modes, with friction and torque ripple on both shafts.
pub fn six_modes() -> Case {
    let mut structure = structure(
        &[0.0, 0.0, 4288.0, 4864.0, 8171.0, 19757.0],
        0.01,
        &[0.61, -0.49, 0.72, 0.64, -0.48, 0.21],
        &[0.61, -0.49, 0.33, -0.21, 0.05, 0.0],
    );
    structure.friction = vec![0.1, 0.2, -0.17, 0.56, 0.3, -0.1];
    structure.pinion_torque = Some(vec![16.0, 0.0, 8.0, -5.0, 1.0, 0.0]);
    structure.wheel_torque = Some(vec![0.0, 8.0, 3.0, 2.0, -1.0, 0.5]);
    let mut drive = two_level_mesh(10e-6);
    drive.friction = 0.1;
    drive
        .transmission_error
        .push(MeshHarmonic::new(2, 1e-6, 0.7));
    drive.torque_ripple = vec![
        TorqueRipple {
            shaft: DriveShaft::Pinion,
            order: 2.0,
            amplitude: 1.5,
            phase: 0.3,
        },
        TorqueRipple {
            shaft: DriveShaft::Wheel,
            order: 1.5,
            amplitude: 0.8,
            phase: -1.1,
        },
    ];
    let point = OperatingPoint {
        load: 0.1,
        ..strong_rattle()
    };
    (structure, drive, point)
}

/// The twenty lowest modes of the default drive, the others as residual flexibility; 30 % load.
pub fn twenty_modes() -> Case {
    let mut s = default_drive();
    s.residual_flexibility = (20..s.modes())
        .map(|i| (s.mesh[i] / s.frequency[i]).powi(2))
        .sum();
    for column in [
        &mut s.frequency,
        &mut s.damping,
        &mut s.mesh,
        &mut s.mesh_tilt,
        &mut s.torque,
        &mut s.friction,
        &mut s.friction_lever,
    ] {
        column.truncate(20);
    }
    let point = OperatingPoint {
        load: 0.3,
        ..strong_rattle()
    };
    (s, two_level_mesh(9e-6), point)
}

/// The default drive with all its forty modes, 5 % load.
pub fn forty_modes() -> Case {
    (default_drive(), two_level_mesh(9e-6), strong_rattle())
}

/// `tests/data/default-drive.modal.toml`.
fn default_drive() -> ModalStructure {
    let table: toml::Table = include_str!("../data/default-drive.modal.toml")
        .parse()
        .unwrap();
    let column = |name: &str| -> Vec<f64> {
        let values = table[name].as_array().unwrap();
        values.iter().map(|v| v.as_float().unwrap()).collect()
    };
    ModalStructure {
        frequency: column("frequency"),
        damping: column("damping"),
        mesh: column("mesh"),
        mesh_tilt: column("mesh_tilt"),
        torque: column("torque"),
        friction: column("friction"),
        friction_lever: column("friction_lever"),
        ..structure(&[], 0.0, &[], &[])
    }
}

/// Structures and tables for models from manifests; the tables are in cargo's folder for files of tests.
pub fn parts() -> Prepared {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/tmp/tables");
    Prepared::new(TableStore::open(folder))
}

/// Largest difference of two states (length 2N), first and second components each relative to their largest entry in
/// `b`; the larger of the two.
pub fn relative_difference(a: &[f64], b: &[f64]) -> f64 {
    let n = b.len() / 2;
    let part = |a: &[f64], b: &[f64]| {
        let scale = b.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let difference = a
            .iter()
            .zip(b)
            .fold(0.0f64, |m, (x, y)| m.max((x - y).abs()));
        assert!(difference.is_finite(), "a state is not finite");
        if difference == 0.0 { 0.0 } else { difference / scale }
    };
    assert_eq!(a.len(), b.len());
    part(&a[..n], &b[..n]).max(part(&a[n..], &b[n..]))
}

/// Largest difference of two states: positions relative to the largest one or the half gap, velocities relative to the
/// largest one or half a gap per mesh radian, so that a state at rest also has a scale.
pub fn state_difference(model: &Model, a: &[f64], b: &[f64]) -> f64 {
    let n = model.modes();
    let floors = [
        model.half_gap,
        model.half_gap * std::f64::consts::TAU / model.period(),
    ];
    let mut worst = 0.0f64;
    for (part, floor) in [0..n, n..2 * n].into_iter().zip(floors) {
        let scale = b[part.clone()].iter().fold(floor, |m, v| m.max(v.abs()));
        for i in part {
            let difference = (a[i] - b[i]).abs() / scale;
            assert!(difference.is_finite(), "a state is not finite");
            worst = worst.max(difference);
        }
    }
    worst
}

/// The same drive at other speeds, with other excitation of the same number of harmonics.
pub fn other_speeds(case: &Case) -> Vec<Case> {
    let scaled = [0.2, 0.5, 0.97, 1.0 + 1e-15, 2.0].map(|factor| {
        let mut case = case.clone();
        case.2.speed *= factor;
        case
    });
    let mut shaken = case.clone();
    shaken.1.transmission_error[0].amplitude *= 1.3;
    shaken.1.transmission_error[0].phase += 0.4;
    for ripple in &mut shaken.1.torque_ripple {
        ripple.amplitude *= 0.7;
    }
    scaled.into_iter().chain([shaken]).collect()
}
