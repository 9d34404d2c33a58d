//! Repeated modes and parallel eigenvectors: kernels that diagonalise a mesh segment compared with `volterra` (the
//! structured kernel), which does not. Cases are modes of equal frequency, drives with two equal shafts, and contacts
//! near critical damping. The kernels must be right or refuse the model.

#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::{advance, volterra};
use common::{default_drive, structure};
use gearatlas::analysis::EnergyNorm;
use gearatlas::gear::GearPair;
use gearatlas::model::{Division, Drive, InitialState, Model, OperatingPoint, TrajectoryState};
use gearatlas::propagate::{Kernel, TableError, Volterra};
use gearatlas::shaft::{Bearing, FlexibleDrive, RigidDrive, Shaft, Tier};
use gearatlas::structure::ModalStructure;
use gearatlas_paper::kernels::{DenseError, Fused, Spectral};

const CELLS: u32 = 60;

/// The model of a structure with a mesh and damping like those of the default drive.
fn operated(structure: &ModalStructure, load: f64, speed: f64) -> Model {
    let drive = common::two_level_mesh(10e-6);
    Model::new(structure, &drive, OperatingPoint { load, speed }).unwrap()
}

/// A rigid rotation, three modes at 3000 rad/s and two at 7000 rad/s. Within each group, neighbours have relative
/// distances of once or twice `apart`.
fn in_groups(apart: f64) -> ModalStructure {
    let shift = |base: f64, k: f64| base * (1.0 + k * apart);
    let frequency = [
        0.0,
        3000.0,
        shift(3000.0, 1.0),
        shift(3000.0, 3.0),
        7000.0,
        shift(7000.0, 1.0),
    ];
    let mesh = [0.8, 0.4, 0.4, -0.3, 0.2, 0.25];
    let torque = [0.8, 0.2, -0.1, 0.3, 0.0, 0.1];
    let mut grouped = structure(&frequency, 0.01, &mesh, &torque);
    for damping in &mut grouped.damping[4..] {
        *damping = 0.02;
    }
    grouped
}

fn lively(model: &Model) -> TrajectoryState {
    let n = model.modes();
    let wave = |i: usize, phase: f64| (1.7 * i as f64 + phase).sin();
    let start = InitialState::Modal {
        displacement: (0..n).map(|i| 1e-6 * wave(i, 0.3)).collect(),
        velocity: (0..n).map(|i| 0.02 * wave(i, 1.1)).collect(),
    };
    model.start(&start)
}

/// Largest differences from the structured kernel after one cycle, over some cycles of its trajectory: of the states
/// \[half gaps\], and of the bearing forces relative to the largest one.
fn departure<K: Kernel>(
    model: &Model,
    kernel: &K,
    bearings: &[Vec<f64>],
    cycles: usize,
) -> [f64; 2] {
    let (exact, norm) = (volterra(model), EnergyNorm::new(model));
    let mut start = lively(model);
    let mut state = 0.0f64;
    let (mut force, mut largest) = (0.0f64, f64::MIN_POSITIVE);
    for _ in 0..cycles {
        let (own, end) = (advance(kernel, &start, 1), advance(&exact, &start, 1));
        state = state.max(norm.distance(&own.state, &end.state) / norm.unit());
        let forces = |at: &TrajectoryState| -> Vec<f64> {
            let [q, _] = model.basis.modes(&at.state);
            let sum = |gain: &Vec<f64>| gain.iter().zip(&q).map(|(g, q)| g * q).sum();
            bearings.iter().map(sum).collect()
        };
        for (a, b) in forces(&own).iter().zip(forces(&end)) {
            force = force.max((a - b).abs());
            largest = largest.max(b.abs());
        }
        start = end;
    }
    [state, force / largest]
}

/// Asserts that both kernels that diagonalise a segment follow the structured kernel.
fn agree(name: &str, structure: &ModalStructure, model: &Model) {
    let bearings: Vec<Vec<f64>> = if structure.bearings.is_empty() {
        // One row per mode, like a bearing that only this mode loads.
        (0..model.modes())
            .map(|i| {
                (0..model.modes())
                    .map(|j| 2e7 * f64::from(u8::from(i == j)))
                    .collect()
            })
            .collect()
    } else {
        structure.bearings.iter().map(|b| b.gain.clone()).collect()
    };
    let spectral = Spectral::new(model, CELLS, 1000, None).unwrap();
    let fused = Fused::new(model, CELLS, 1000).unwrap();
    for [state, force] in [
        departure(model, &spectral, &bearings, 12),
        departure(model, &fused, &bearings, 12),
    ] {
        assert!(
            state < 1e-11 && force < 1e-11,
            "{name}: {state:e} {force:e}"
        );
    }
    // The reported errors are measured for the longest possible cell of a table.
    let longest = 8.0 / Volterra::fastest_structure_rate(model);
    let cells = (longest * f64::from(CELLS) / model.period()).max(1.0);
    for basis in spectral.conditioning() {
        assert!(basis.reconstruction < 1e-12 * cells, "{name}: {basis:?}");
    }
}

/// Modes of equal frequency, and of nearly equal frequencies at small distances.
#[test]
fn repeated_modes_are_followed() {
    for apart in [
        0.0, 1e-16, 1e-15, 1e-14, 1e-13, 1e-12, 1e-11, 1e-9, 1e-7, 1e-5,
    ] {
        let structure = in_groups(apart);
        for speed in [800.0, 1000.0, 1200.0] {
            let model = operated(&structure, 0.1, speed);
            agree(&format!("{apart:e} at {speed}"), &structure, &model);
        }
    }
}

/// With friction, the directions of the mesh deflection and of the mesh force differ.
#[test]
fn repeated_modes_with_friction_are_followed() {
    let mut structure = in_groups(0.0);
    structure.friction = vec![0.0, 0.2, -0.1, 0.3, 0.1, -0.2];
    let drive = Drive {
        friction: 0.08,
        mesh: [(0.6, 1.0), (1.0, -1.0)]
            .map(|(end, turn)| Division {
                friction: [turn, 0.0],
                ..Division::level(end, 4e8)
            })
            .to_vec(),
        ..common::two_level_mesh(10e-6)
    };
    let point = OperatingPoint {
        load: 0.1,
        speed: 1000.0,
    };
    let model = Model::new(&structure, &drive, point).unwrap();
    agree("friction", &structure, &model);
}

fn like_shafts() -> ([Shaft; 2], GearPair) {
    let bearing = |axial| Bearing {
        y: 1.25e8,
        ..default_drive::bearing(axial)
    };
    let [pinion, _] = default_drive::shafts();
    let shaft = Shaft {
        bearings: [bearing(1e8), bearing(0.0)],
        ..pinion
    };
    let gears = GearPair {
        teeth: [20, 20],
        body_length: [40e-3; 2],
        ..default_drive::gears()
    };
    ([shaft.clone(), shaft], gears)
}

/// Two equal shafts on isotropic bearings: every mode of a shaft occurs twice, and again in the other plane.
#[test]
fn like_shafts_are_followed() {
    let (shafts, gears) = like_shafts();
    for tier in [Tier::Torsional, Tier::Translational, Tier::Tilting] {
        let all = tier.freedoms();
        let drive = RigidDrive {
            tier,
            gears: gears.clone(),
            shafts: shafts.clone(),
            pedestals: None,
            density: 7850.0,
            damping: 0.01,
            damping_overrides: Vec::new(),
            gyroscopic: false,
        };
        let structure = drive.modes(all, all, false).unwrap();
        for speed in [1000.0, 1200.0] {
            let model = operated(&structure, 0.3, speed);
            agree(tier.name(), &structure, &model);
        }
    }
    let drive = FlexibleDrive {
        gears,
        shafts,
        elements: [2, 3, 3],
        ..default_drive::flexible()
    };
    let structure = drive.modes(40, 40, false).unwrap();
    let model = operated(&structure, 0.1, 1200.0);
    agree("flexible", &structure, &model);
}

/// A nearly critically damped contact has two nearly equal eigenvectors. At any distance from critical damping, the
/// motion is that of the structured kernel, or the tables are refused.
#[test]
fn critical_damping_is_followed_or_refused() {
    let structure = structure(&[0.0], 0.0, &[1.0], &[1.0]);
    let (mut followed, mut refused) = (0, 0);
    for sign in [-1.0, 1.0] {
        for exponent in 0..=16 {
            // c = 2 √k at participation 1.
            let damping = 4e4 * (1.0 + sign * 0.5 * 10f64.powi(-exponent));
            let drive = Drive {
                mesh: Division::levels(&[4e8], &[]),
                damping,
                ..common::two_level_mesh(10e-6)
            };
            let point = OperatingPoint {
                load: 0.1,
                speed: 1200.0,
            };
            let model = Model::new(&structure, &drive, point).unwrap();
            let feels = [vec![1.0]];
            match Spectral::new(&model, CELLS, 1000, None) {
                Ok(kernel) => {
                    let [state, _] = departure(&model, &kernel, &feels, 12);
                    assert!(state < 1e-9, "{damping}: {state:e}");
                    let fused = Fused::new(&model, CELLS, 1000).unwrap();
                    let [state, _] = departure(&model, &fused, &feels, 12);
                    assert!(state < 1e-9, "{damping}: {state:e}");
                    followed += 1;
                }
                Err(error) => {
                    assert!(
                        matches!(error, DenseError::Table(TableError::Defective { error, .. }) if error > 1e-11 || error.is_nan()),
                        "{error:?}"
                    );
                    let fused = Fused::new(&model, CELLS, 1000).map(|_| ());
                    assert!(matches!(
                        fused,
                        Err(DenseError::Table(TableError::Defective { .. }))
                    ));
                    refused += 1;
                }
            }
        }
    }
    assert!(followed > 8 && refused > 8, "{followed} {refused}");
}
