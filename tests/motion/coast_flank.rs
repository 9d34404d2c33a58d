//! The two flanks compared with rigid-body kinematics: the effect of the mesh force and its friction on either of them,
//! on a drive whose bodies rotate and move in their plane.

#![allow(clippy::unwrap_used)]

use crate::default_drive;
use default_drive::{DENSITY, gears, shafts};
use gearatlas::gear::{MeshTable, MeshTableInputs, friction_direction};
use gearatlas::model::{
    COAST_FLANK, CoastFlank, DRIVE_FLANK, Division, Drive, MeshHarmonic, Model, OperatingPoint,
    Release, Stiffness,
};
use gearatlas::shaft::{RigidDrive, Tier};
use gearatlas::structure::ModalStructure;
use nalgebra::{Matrix6, Vector6};
use proptest::prelude::*;

const FRICTION: f64 = 0.07;
const HALF_GAP: f64 = 10e-6;

fn structure(tier: Tier) -> ModalStructure {
    let drive = RigidDrive {
        tier,
        gears: gears(),
        shafts: shafts(),
        pedestals: None,
        density: DENSITY,
        damping: 0.01,
        damping_overrides: Vec::new(),
        gyroscopic: false,
    };
    let all = tier.freedoms();
    drive.modes(all, all, false).unwrap()
}

/// Velocities of the bodies: x and y of the pinion, of the wheel \[m/s\], rotation of the pinion, and of the wheel in
/// its direction of running \[rad/s\].
type Motion = [f64; 6];

/// The modal velocities of a motion of the bodies, from the loads of bearings and shafts.
fn modal(structure: &ModalStructure, motion: Motion) -> Vec<f64> {
    let shafts = shafts();
    let bearing = |name: &str, stiffness: f64| {
        let found = structure.bearings.iter().find(|b| b.name == name);
        found.unwrap().gain.iter().map(|g| g / stiffness).collect()
    };
    let rows: [Vec<f64>; 6] = [
        bearing("pinion 1 x", shafts[0].bearings[0].x),
        bearing("pinion 1 y", shafts[0].bearings[0].y),
        bearing("wheel 1 x", shafts[1].bearings[0].x),
        bearing("wheel 1 y", shafts[1].bearings[0].y),
        structure.pinion_torque.clone().unwrap(),
        structure.wheel_torque.clone().unwrap(),
    ];
    let shape = Matrix6::from_fn(|row, mode| rows[row][mode]);
    let solved = shape.lu().solve(&Vector6::from(motion)).unwrap();
    solved.iter().copied().collect()
}

fn drive(mesh: Vec<Division>, coast: Option<Vec<Division>>) -> Drive {
    Drive {
        half_gap: HALF_GAP,
        mesh,
        damping: 0.0,
        friction: FRICTION,
        release: Release::Deflection,
        coast: coast.map(|mesh| CoastFlank {
            mesh,
            transmission_error: Vec::new(),
            further: Vec::new(),
        }),
        transmission_error: Vec::new(),
        torque_ripple: Vec::new(),
        further: Vec::new(),
        imposed_motion: Vec::new(),
        film: None,
        tooth_cycles: Default::default(),
    }
}

const POINT: OperatingPoint = OperatingPoint {
    load: 1.0,
    speed: 120.0,
};

/// A division with one pair, at s \[m\] from the pitch point on the drive flanks' line.
fn pair_at(s: f64) -> Division {
    let friction = friction_direction(&[s], &[1.0]);
    Division {
        friction: [friction.direction, friction.lever],
        ..Division::level(1.0, 4e8)
    }
}

/// Velocity of the pinion relative to the wheel at a contact: along the line of action, and the sliding across it.
/// `lean` is +1 for the drive flanks' line, −1 for the coast flanks'.
fn at_contact(motion: Motion, lean: f64, s: f64) -> (f64, f64) {
    let [x1, y1, x2, y2, turn_1, turn_2] = motion;
    let pair = gears();
    let (sin, cos) = pair.operating_pressure_angle().unwrap().sin_cos();
    let radius = pair.operating_pitch_radii().unwrap()[0];
    let distance = pair.centre_distance().unwrap();
    let line = [lean * sin, cos];
    let place = [radius + s * line[0], s * line[1]];
    // ω e_z × r; the wheel rotates in the opposite direction about its axis.
    let pinion = [x1 - turn_1 * place[1], y1 + turn_1 * place[0]];
    let wheel = [x2 + turn_2 * place[1], y2 - turn_2 * (place[0] - distance)];
    let relative = [pinion[0] - wheel[0], pinion[1] - wheel[1]];
    let along = relative[0] * line[0] + relative[1] * line[1];
    let across = relative[0] * line[1] - relative[1] * line[0];
    (along, across)
}

/// Velocity along a contact's line, and the power \[W\] of friction per newton of |F|.
fn powers(model: &Model, contact: usize, velocity: &[f64]) -> (f64, f64) {
    let contact = &model.contacts[contact];
    let gains = model.gains(&contact.cycles[0].segments[0]);
    let (mut rate, mut friction) = (0.0, 0.0);
    let state = model.basis.state(&vec![0.0; velocity.len()], velocity);
    for (gain, v) in gains.iter().zip(&state[velocity.len()..]) {
        rate += gain.deflection[0] * v;
        // The force acts along −g; F has the sign of the side.
        friction -= contact.side * (gain.mesh_input[1] - gain.deflection[0]) * v;
    }
    (rate, friction)
}

proptest! {
    #[test]
    fn friction_takes_its_power_on_both_flanks(
        s in 0.2e-3f64..9e-3,
        behind in any::<bool>(),
        lateral in prop::array::uniform4(-1.0f64..1.0),
        symmetry in 0.0f64..1.0,
    ) {
        let s = if behind { s } else { -s };
        let structure = structure(Tier::Translational);
        let mesh = vec![pair_at(s)];
        let coast = Division::mirrored(&mesh, symmetry);
        let model = Model::new(&structure, &drive(mesh, Some(coast)), POINT).unwrap();
        // The motion is the uniform rotation, with lateral velocities that do not reverse the sliding.
        let turn = POINT.speed;
        let wheel = turn * 20.0 / 30.0;
        let slides = s.abs() * (turn + wheel);
        let [a, b, c, d] = lateral.map(|part| 0.2 * slides * part);
        let motion = [a, b, c, d, turn, wheel];
        let velocity = modal(&structure, motion);
        // On the mirrored flank the pair is at the mirror image of its position.
        for (contact, lean, s) in [(DRIVE_FLANK, 1.0, s), (COAST_FLANK, -1.0, -s)] {
            let (along, sliding) = at_contact(motion, lean, s);
            let (rate, friction) = powers(&model, contact, &velocity);
            prop_assert!((rate - along).abs() < 1e-9 * slides, "{rate} {along}");
            let expected = -FRICTION * sliding.abs();
            prop_assert!(
                (friction - expected).abs() < 1e-9 * slides,
                "contact {contact}: {friction} {expected}"
            );
        }
    }

    #[test]
    fn flanks_close_and_push_apart_as_wedges(dx in 0.1e-6f64..5e-6) {
        let structure = structure(Tier::Translational);
        let mesh = vec![Division::level(1.0, 4e8)];
        let coast = Division::mirrored(&mesh, 0.1);
        let model = Model::new(&structure, &drive(mesh, Some(coast)), POINT).unwrap();
        let sin = gears().operating_pressure_angle().unwrap().sin();
        let nearer = modal(&structure, [0.3 * dx, 0.0, -0.7 * dx, 0.0, 0.0, 0.0]);
        let state = model.basis.state(&nearer, &[0.0; 6]);
        for contact in &model.contacts {
            let segment = &contact.cycles[0].segments[0];
            let (deflection, _) = model.deflection_on(segment, 0, &state, 0.0);
            let margin = contact.margin(false, deflection, HALF_GAP);
            let left = HALF_GAP - dx * sin;
            prop_assert!((margin - left).abs() < 1e-12 * HALF_GAP, "{margin} {left}");
        }
        // One newton on either flank does work when the axes separate.
        for contact in [DRIVE_FLANK, COAST_FLANK] {
            let (rate, _) = powers(&model, contact, &nearer);
            let work = model.contacts[contact].side * rate;
            prop_assert!((work - dx * sin).abs() < 1e-12 * HALF_GAP);
        }
    }
}

#[test]
fn along_one_line_flanks_do_not_know_that_axes_approach() {
    let structure = structure(Tier::Translational);
    let mesh = vec![Division::level(1.0, 4e8)];
    let model = Model::new(&structure, &drive(mesh, None), POINT).unwrap();
    let nearer = modal(&structure, [1e-6, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let [drive, coast] = [DRIVE_FLANK, COAST_FLANK]
        .map(|contact| model.contacts[contact].side * powers(&model, contact, &nearer).0);
    assert_eq!(drive, -coast);
}

#[test]
fn gears_that_only_turn_have_one_line_where_stiffness_is_constant() {
    let structure = structure(Tier::Torsional);
    let mesh = vec![Division::level(1.0, 4e8)];
    let error = vec![MeshHarmonic::new(1, 5e-6, 0.3)];
    let with = |coast: Option<Vec<Division>>| {
        let mut drive = drive(mesh.clone(), coast);
        drive.friction = 0.0;
        drive.transmission_error.clone_from(&error);
        if let Some(coast) = &mut drive.coast {
            coast.transmission_error.clone_from(&error);
        }
        Model::new(&structure, &drive, POINT).unwrap()
    };
    assert_eq!(with(Some(Division::mirrored(&mesh, 0.3))), with(None));
}

/// The divisions of the coast flanks are compared with the pairs that touch there, one by one.
#[test]
fn coast_flanks_have_what_their_own_pairs_bear() {
    let mut pair = gears();
    pair.form.bore = [Some(48e-3), Some(76e-3)];
    let flanks = gearatlas::gear::Flanks::new(&pair).unwrap();
    let table = MeshTable::build(&flanks, &MeshTableInputs::of_gears(&pair), &|_, _| ()).unwrap();
    let cycle = table.cycle(0, 0);
    let drive: Vec<Division> = (cycle.pieces().iter())
        .map(|piece| Division {
            stiffness: Stiffness::series(piece.stiffness),
            friction: [piece.friction, piece.friction_lever],
            ..Division::level(piece.end, 1.0)
        })
        .collect();
    let symmetry = pair.symmetry().unwrap();
    let coast = Division::mirrored(&drive, symmetry);
    let base_pitch = flanks.path().base_pitch;
    let mut start = 0.0;
    for division in &coast {
        for part in [0.1, 0.5, 0.9] {
            let phase = start + part * (division.end - start);
            // A tooth's coast flank meets its line behind its drive flank by the tooth's thickness along the line. It
            // passes the image of each position as long after the symmetry as the drive flank before it.
            let image = (2.0 * symmetry - phase).rem_euclid(1.0);
            let expected = cycle.value(&cycle.stiffness, image);
            let found = division.stiffness.at(2.0 * part - 1.0);
            assert!((found / expected - 1.0).abs() < 1e-9, "{phase}: {found}");
        }
        start = division.end;
    }
    let means = |divisions: &[Division]| {
        let starts = std::iter::once(0.0).chain(divisions.iter().map(|d| d.end));
        let terms = starts.zip(divisions).map(|(start, d)| {
            let length = d.end - start;
            [
                length * d.stiffness.mean(),
                length * d.friction[0],
                length * d.friction[1],
            ]
        });
        terms.fold([0.0; 3], |sum, term| [0, 1, 2].map(|i| sum[i] + term[i]))
    };
    let (of_drive, of_coast) = (means(&drive), means(&coast));
    assert!((of_coast[0] / of_drive[0] - 1.0).abs() < 1e-12);
    assert!((of_coast[1] + of_drive[1]).abs() < 1e-12);
    assert!((of_coast[2] - of_drive[2]).abs() < 1e-12 * base_pitch);
}
