//! How are the modes of a whole drive coupled?

use super::*;
use crate::numerics::linalg::symmetric_eigen;
use crate::shaft::{RigidDrive, Tier};
use crate::structure::Coupling;
use faer::Mat;

const MODES: usize = 20;

fn structure(drive: &FlexibleDrive) -> ModalStructure {
    drive.modes(MODES, MODES, false).unwrap()
}

/// The structure without coupling of its modes and without loads besides the rated load.
fn bare(mut structure: ModalStructure) -> ModalStructure {
    for bearing in &mut structure.bearings {
        bearing.rate_gain.clear();
        bearing.left_out.constant_load = 0.0;
        bearing.left_out.load_by_speed = 0.0;
    }
    ModalStructure {
        coupling: None,
        constant_load: Vec::new(),
        load_by_speed: Vec::new(),
        ..structure
    }
}

/// Whether damping is modal and all loads are proportional to the rated one.
fn is_uncoupled(of: &ModalStructure) -> bool {
    of.coupling.is_none() && of.constant_load.is_empty() && of.load_by_speed.is_empty()
}

/// Coupling of the modes leaves all other parts of the structure bit-identical. Modes are uncoupled unless the drive
/// requests coupling.
#[test]
fn the_rest_of_the_structure_stays_in_every_bit() {
    let plain = structure(&drive());
    assert!(is_uncoupled(&plain));
    assert_eq!(bare(structure(&damped())), plain);
    assert!(!is_uncoupled(&structure(&damped())));
}

fn matrix(rows: &[f64]) -> Mat<f64> {
    Mat::from_fn(MODES, MODES, |i, j| rows[i * MODES + j])
}

fn form(rows: &[f64], velocity: &[f64]) -> f64 {
    let image = |row: &[f64]| row.iter().zip(velocity).map(|(c, v)| c * v).sum::<f64>();
    (rows.chunks(MODES).zip(velocity))
        .map(|(row, v)| v * image(row))
        .sum()
}

/// The power of the modal damping matrix equals the power of the bearings' dampers and of the drag at the shafts' ends.
/// The velocity at a damper follows from the forces of the parallel springs.
#[test]
fn dampers_take_the_power_of_their_velocities() {
    let drive = damped();
    let structure = structure(&drive);
    let Coupling {
        damping, stiffness, ..
    } = structure.coupling.as_ref().unwrap();
    assert!(stiffness.iter().all(|entry| *entry == 0.0));
    let (values, _) = symmetric_eigen(&matrix(damping)).unwrap();
    assert!(values[0] > -1e-12 * values[MODES - 1], "{values:?}");
    let largest = damping.iter().fold(0.0_f64, |most, c| most.max(c.abs()));
    for i in 0..MODES {
        for j in 0..i {
            let difference = damping[i * MODES + j] - damping[j * MODES + i];
            assert!(difference.abs() < 1e-13 * largest);
        }
    }
    let sum = |column: &[f64], v: &[f64]| column.iter().zip(v).map(|(c, v)| c * v).sum::<f64>();
    for seed in 1..6 {
        let velocity: Vec<f64> = (0..MODES)
            .map(|i| (f64::from(seed) * (i as f64 + 0.3)).sin())
            .collect();
        let ends = [&structure.pinion_torque, &structure.wheel_torque];
        let mut power = 0.0;
        for (i, name) in ["pinion", "wheel"].into_iter().enumerate() {
            let shaft = &drive.shafts[i];
            power += shaft.drag.viscous * sum(ends[i].as_ref().unwrap(), &velocity).powi(2);
            for (number, bearing) in (1..).zip(&shaft.bearings) {
                let along = |direction: &str, stiffness: f64| {
                    let wanted = format!("{name} {number} {direction}");
                    let mut gains = structure.bearings.iter();
                    let gain = gains.find(|bearing| bearing.name == wanted).unwrap();
                    sum(&gain.gain, &velocity) / stiffness
                };
                let (x, y) = (along("x", bearing.x), along("y", bearing.y));
                let [[xx, xy], [yx, yy]] = bearing.damping;
                power += xx * x * x + (xy + yx) * x * y + yy * y * y;
            }
        }
        assert!((form(damping, &velocity) / power - 1.0).abs() < 1e-10);
    }
}

/// `Σ f_b + m a + F sin α = 0` along the line of centres of a shaft that only moves in the plane: springs and dampers
/// of its bearings, its inertia and the mesh force. The mass m of the shaft follows from `Σ φ² = 1/m` with the
/// displacement φ of the modes.
#[test]
fn bearing_forces_balance_the_accelerations() {
    let mut drive = damped();
    drive.shafts[0].bearings[1].x = 6e7;
    let rigid = RigidDrive {
        tier: Tier::Translational,
        gears: drive.gears.clone(),
        shafts: drive.shafts.clone(),
        pedestals: None,
        density: drive.density,
        damping: 0.0,
        damping_overrides: Vec::new(),
        gyroscopic: false,
    };
    let structure = rigid.modes(6, 6, false).unwrap();
    let damping = &structure.coupling.as_ref().unwrap().damping;
    let sin = drive.gears.operating_pressure_angle().unwrap().sin();
    let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let pinion: Vec<_> = (structure.bearings.iter())
        .filter(|b| b.name.starts_with("pinion") && b.name.ends_with(" x"))
        .collect();
    assert_eq!(pinion.len(), 2);
    let shape: Vec<f64> = pinion[0].gain.iter().map(|g| g / 2e8).collect();
    let mass = 1.0 / sum(&shape, &shape);
    for seed in 1..6 {
        let wave = |i: usize, turn: f64| (f64::from(seed) * (i as f64 + turn)).sin();
        let position: Vec<f64> = (0..6).map(|i| 1e-5 * wave(i, 0.3)).collect();
        let velocity: Vec<f64> = (0..6).map(|i| 5e-2 * wave(i, 1.7)).collect();
        let mesh_force = 500.0 * wave(7, 0.1);
        let acceleration: Vec<f64> = (0..6)
            .map(|i| {
                -structure.frequency[i].powi(2) * position[i]
                    - sum(&damping[6 * i..][..6], &velocity)
                    - structure.mesh[i] * mesh_force
            })
            .collect();
        let forces =
            (pinion.iter()).map(|b| sum(&b.gain, &position) + sum(&b.rate_gain, &velocity));
        let forces: f64 = forces.sum();
        let dampers: f64 = pinion.iter().map(|b| sum(&b.rate_gain, &velocity)).sum();
        let inertia = mass * sum(&shape, &acceleration);
        let left = forces + inertia + sin * mesh_force;
        assert!(left.abs() < 1e-9 * inertia.abs(), "{left} {inertia}");
        assert!(dampers.abs() > 0.1, "{dampers}");
    }
}

/// The gyroscopic matrix is skew in every bit, so its moments do no work. They do not affect the rigid
/// rotations or torsion, and they do not couple different shafts.
#[test]
fn the_gyroscopic_matrix_is_skew_and_sparse() {
    let gyroscopic = structure(&damped()).coupling.unwrap().gyroscopic;
    let mut nonzero = 0;
    for i in 0..MODES {
        for j in 0..MODES {
            let (entry, mirror) = (gyroscopic[i * MODES + j], gyroscopic[j * MODES + i]);
            assert_eq!(entry, -mirror);
            nonzero += usize::from(entry != 0.0);
            if i < 2 {
                assert_eq!(entry, 0.0);
            }
        }
    }
    // Modes bend one shaft in one plane: at most a quarter of all pairs can couple.
    assert!(nonzero > 0 && nonzero <= MODES * MODES / 4, "{nonzero}");
}

/// Drag `T_d` of the wheel's shaft loads the mesh by `T_d/r_b2`: the torque of the motor increases
/// by `T_d r_b1/r_b2`. The motor balances the drag of the pinion's shaft directly.
#[test]
fn drag_of_the_wheel_loads_the_mesh() {
    let mut drive = drive();
    drive.shafts[1].drag.constant = 0.7;
    let [base_1, base_2] = drive.gears.base_radii();
    let loaded = structure(&drive);
    assert!(loaded.coupling.is_none() && loaded.load_by_speed.is_empty());
    let ends = [&loaded.pinion_torque, &loaded.wheel_torque].map(|c| c.as_ref().unwrap());
    for mode in 0..MODES {
        let torques = 0.7 * (base_1 / base_2 * ends[0][mode] - ends[1][mode]);
        let scale = ends[0][mode].abs() + ends[1][mode].abs();
        assert!((loaded.constant_load[mode] - torques).abs() < 1e-12 * scale);
    }
    // In equilibrium of the relative rotation the mesh carries the drag; the neutral rotation is not driven.
    let force = loaded.constant_load[1] / loaded.mesh[1];
    assert!((force * base_2 / 0.7 - 1.0).abs() < 1e-12);
    assert_eq!(loaded.constant_load[0], 0.0);

    drive.shafts[1].drag = Drag {
        viscous: 3e-3,
        constant: 0.0,
    };
    let viscous = structure(&drive);
    assert!(viscous.constant_load.is_empty());
    let force = 1200.0 * viscous.load_by_speed[1] / viscous.mesh[1];
    let torque = 3e-3 * 1200.0 * 19.0 / 31.0;
    assert!((force * base_2 / torque - 1.0).abs() < 1e-12);
    // Response of the drag to a change of speed.
    let coupling = viscous.coupling.unwrap();
    let end = viscous.wheel_torque.unwrap();
    for i in 0..MODES {
        for j in 0..MODES {
            let exact = 3e-3 * end[i] * end[j];
            let scale = 3e-3 * end.iter().fold(0.0_f64, |most, e| most.max(e * e));
            assert!((coupling.damping[i * MODES + j] - exact).abs() < 1e-12 * scale);
        }
    }

    drive.shafts[1].drag = Drag::default();
    drive.shafts[0].drag.constant = 0.7;
    assert!(is_uncoupled(&structure(&drive)));
    drive.shafts[0].drag.viscous = 1e-3;
    let pinion = structure(&drive);
    assert!(pinion.load_by_speed.is_empty() && pinion.coupling.is_some());
}

/// Cross-coupled springs load their bearing, and couple x with y in one sense.
#[test]
fn cross_coupled_springs_load_their_bearing() {
    let mut drive = drive();
    drive.shafts[0].bearings[0].cross = [2e6, -2e6];
    let found = structure(&drive);
    let plain = structure(&super::drive());
    let gain = |of: &ModalStructure, name: &str| {
        let mut all = of.bearings.iter();
        all.find(|bearing| bearing.name == name)
            .unwrap()
            .gain
            .clone()
    };
    let [x, y] = ["pinion 1 x", "pinion 1 y"].map(|name| gain(&plain, name));
    let coupled = gain(&found, "pinion 1 x");
    for mode in 2..MODES {
        let exact = x[mode] + 2e6 * y[mode] / 1e8;
        assert!((coupled[mode] - exact).abs() < 1e-9 * (x[mode].abs() + y[mode].abs()));
    }
    let coupling = found.coupling.unwrap();
    assert!(coupling.stiffness.iter().any(|entry| *entry != 0.0));
    for entries in [&coupling.damping, &coupling.gyroscopic] {
        assert!(entries.iter().all(|entry| *entry == 0.0));
    }
    assert!(
        coupling.stiffness[..2 * MODES]
            .iter()
            .all(|entry| *entry == 0.0)
    );
}

/// Tiers that do not tilt have no gyroscopic moments; the tilting tier has those of its bodies.
#[test]
fn rigid_tiers_feel_what_they_release() {
    let drive = damped();
    for tier in Tier::ALL {
        let pedestal = crate::shaft::Pedestal {
            x: 4e8,
            y: 3e8,
            mass: 3.0,
        };
        let rigid = RigidDrive {
            tier,
            gears: drive.gears.clone(),
            shafts: drive.shafts.clone(),
            pedestals: Some([[pedestal; 2]; 2]),
            density: drive.density,
            damping: 0.01,
            damping_overrides: Vec::new(),
            gyroscopic: true,
        };
        let all = tier.freedoms();
        let coupling = rigid.modes(all, all, false).unwrap().coupling.unwrap();
        let tilts = matches!(tier, Tier::Tilting | Tier::Pedestal);
        let moments = coupling.gyroscopic.iter().any(|entry| *entry != 0.0);
        assert_eq!(moments, tilts, "{tier:?}");
        let moves = tier != Tier::Torsional;
        let of_bearings = (2..all).any(|mode| coupling.damping[mode * all + mode] != 0.0);
        assert_eq!(of_bearings, moves, "{tier:?}");
        assert!(coupling.damping[0] > 0.0);
    }
}

/// The force of a damper at its velocity has the same modal pattern as that of a parallel spring at its
/// displacement.
#[test]
fn dampers_of_a_bearing_bear_in_proportion_to_its_springs() {
    let mut drive = drive();
    for shaft in &mut drive.shafts {
        shaft.bearings[0].damping = [[400.0, 0.0], [0.0, 300.0]];
    }
    let structure = structure(&drive);
    let mut compared = 0;
    for bearing in structure
        .bearings
        .iter()
        .filter(|b| !b.rate_gain.is_empty())
    {
        let ratio = match &bearing.name[bearing.name.len() - 1..] {
            "x" => 400.0 / 2e8,
            _ => 300.0 / 1e8,
        };
        for (rate, gain) in bearing.rate_gain.iter().zip(&bearing.gain) {
            assert!(
                (rate - ratio * gain).abs() <= 1e-12 * gain.abs(),
                "{}",
                bearing.name
            );
        }
        compared += 1;
    }
    assert_eq!(compared, 4);
}
