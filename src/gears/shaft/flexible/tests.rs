mod coupling;

use super::*;
use crate::gear::{GearError, GearPair, TiltCompliance, ToothForm};
use crate::shaft::beam::Section;
use crate::shaft::{Bearing, Disc, Drag, Shaft};

const RIGID_MODES: usize = 2;

pub(in crate::shaft) fn drive() -> FlexibleDrive {
    let bearing = |axial| Bearing {
        x: 2e8,
        y: 1e8,
        axial,
        tilt: 1e4,
        ..Bearing::default()
    };
    let shaft = |diameter| Shaft {
        diameter,
        inner_diameter: 0.0,
        span: 0.15,
        overhang: 0.03,
        gear_position: 0.4,
        end_inertia: 1e-3,
        bearings: [bearing(1e8), bearing(0.0)],
        drag: Drag::default(),
    };
    FlexibleDrive {
        gears: GearPair {
            teeth: [19, 31],
            module: 3e-3,
            pressure_angle: 20f64.to_radians(),
            helix_angle: 0.0,
            face_width: 20e-3,
            body_length: [30e-3, 20e-3],
            rated_torque: 40.0,
            form: ToothForm::default(),
        },
        shafts: [shaft(20e-3), shaft(24e-3)],
        young_modulus: 206e9,
        shear_modulus: 79e9,
        density: 7850.0,
        shear_coefficient: 0.9,
        elements: [2, 3, 3],
        damping: 0.02,
        damping_overrides: vec![(5, 0.07)],
        gyroscopic: false,
    }
}

/// The drive with dampers, drag and gyroscopic moments.
pub(in crate::shaft) fn damped() -> FlexibleDrive {
    let mut drive = drive();
    for (i, shaft) in drive.shafts.iter_mut().enumerate() {
        shaft.bearings[0].damping = [[400.0, 0.0], [0.0, 300.0]];
        shaft.bearings[1].damping = [[100.0 + i as f64, -30.0], [-30.0, 200.0]];
        shaft.drag = Drag {
            viscous: 2e-3 + 1e-3 * i as f64,
            constant: 0.4 + 0.1 * i as f64,
        };
    }
    drive.gyroscopic = true;
    drive
}

/// Inertia of one shaft about its axis, from its parts.
fn polar_inertia(drive: &FlexibleDrive, index: usize) -> f64 {
    let shaft = &drive.shafts[index];
    let rod = Section::solid(shaft.diameter).unwrap().polar_moment()
        * drive.density
        * (shaft.span + shaft.overhang);
    let body = Disc::annulus(
        2.0 * drive.gears.pitch_radii()[index],
        shaft.diameter,
        drive.gears.body_length[index],
        drive.density,
    )
    .unwrap();
    rod + body.polar_inertia + shaft.end_inertia
}

#[test]
fn rigid_rotations_in_closed_form() {
    let drive = drive();
    let structure = drive.modes(12, 12, false).unwrap();
    let [base_1, base_2] = drive.gears.base_radii();
    let mass_1 = polar_inertia(&drive, 0) / base_1.powi(2);
    let mass_2 = polar_inertia(&drive, 1) / base_2.powi(2);
    let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-10, "{a} {b}");
    assert_eq!(structure.frequency[..2], [0.0, 0.0]);
    // Neutral rotation: both gears roll with the same pitch-line velocity, so mesh and load do not participate.
    let [pinion, wheel] =
        [&structure.pinion_torque, &structure.wheel_torque].map(|c| c.as_ref().unwrap());
    let velocity = 1.0 / (mass_1 + mass_2).sqrt();
    close(pinion[0], velocity / base_1);
    close(wheel[0], velocity / base_2);
    assert_eq!([structure.mesh[0], structure.torque[0]], [0.0, 0.0]);
    assert!(structure.friction[0].abs() < 1e-12);
    close(
        structure.friction_lever[0],
        -velocity * (1.0 / base_1 + 1.0 / base_2),
    );
    // Relative: reduced mass of the pair.
    let reduced = (1.0 / mass_1 + 1.0 / mass_2).sqrt();
    close(structure.mesh[1], reduced);
    close(structure.torque[1], reduced);
    let tangent = drive.gears.pressure_angle.tan();
    close(structure.friction[1], -tangent * reduced);
}

/// With hubs the rigid rotations keep their inertia: shaft and body do not overlap.
#[test]
fn hubs_stiffen_and_weigh_what_they_did() {
    let plain = drive();
    let mut hubs = drive();
    for (i, [diameter, length]) in [[36e-3, 30e-3], [60e-3, 20e-3]].into_iter().enumerate() {
        hubs.gears.form.body[i].hub = Some(Hub { diameter, length });
    }
    let [without, with] = [&plain, &hubs].map(|drive| drive.modes(12, 12, false).unwrap());
    for column in [
        |s: &ModalStructure| s.mesh[1],
        |s: &ModalStructure| s.friction_lever[0],
    ] {
        let [a, b] = [&without, &with].map(column);
        assert!((a / b - 1.0).abs() < 1e-10, "{a} {b}");
    }
    for mode in 2..8 {
        assert!(
            with.frequency[mode] > without.frequency[mode],
            "mode {mode}"
        );
    }
    assert!(with.frequency[2] > 1.01 * without.frequency[2]);
    // A hub as thick as the shaft has no effect, except that the shaft's mass below the body is not counted twice.
    for (i, shaft) in plain.shafts.iter().enumerate() {
        let length = plain.gears.body_length[i];
        let diameter = shaft.diameter * (1.0 + 1e-9);
        hubs.gears.form.body[i].hub = Some(Hub { diameter, length });
    }
    hubs.elements = [4, 40, 40];
    let mut fine = drive();
    fine.elements = [4, 40, 40];
    let [thin, none] = [&hubs, &fine].map(|drive| drive.modes(12, 12, false).unwrap());
    for mode in 2..8 {
        let off = thin.frequency[mode] / none.frequency[mode] - 1.0;
        assert!(off.abs() < 1e-5, "mode {mode}: {off:e}");
    }
}

/// A hub that reaches beyond a bearing is rejected. The message states the limit, twice the distance to the nearer one.
#[test]
fn hubs_end_at_the_bearings() {
    for (position, room) in [(0.4, 0.12), (0.7, 0.09)] {
        for gear in 0..2 {
            let of_length = |length: f64| {
                let mut drive = drive();
                drive.shafts[gear].gear_position = position;
                drive.gears.form.body[gear].hub = Some(Hub {
                    diameter: 30e-3,
                    length,
                });
                drive.modes(12, 12, false)
            };
            let Err(ShaftError::HubBeyondBearings {
                shaft,
                length,
                room: largest,
            }) = of_length(0.13)
            else {
                panic!("no end")
            };
            assert_eq!((shaft, length), (gear + 1, 0.13));
            assert!((largest - room).abs() < 1e-15, "{largest} {room}");
            assert!(of_length(largest).is_ok());
            assert!(of_length(largest * (1.0 + 1e-6)).is_err());
        }
    }
}

/// Shafts too stiff to bend or twist on springs that cannot hold a tilt: the complete modal
/// sum is the flexibility of four bearings, `Σ (sin² α/(2 k_x) + cos² α/(2 k_y))` for gears
/// in the middle of their spans.
#[test]
fn the_whole_modal_sum_is_the_static_flexibility() {
    let mut stiff = drive();
    stiff.young_modulus *= 1e5;
    stiff.shear_modulus *= 1e5;
    for shaft in &mut stiff.shafts {
        shaft.gear_position = 0.5;
        for bearing in &mut shaft.bearings {
            bearing.tilt = 0.0;
        }
    }
    // Nine nodes per shaft, all freedoms released.
    let all = 2 * 9 * 6;
    let structure = stiff.modes(all, RIGID_MODES, true).unwrap();
    let (sin, cos) = stiff.gears.pressure_angle.sin_cos();
    let expected = sin * sin / 2e8 + cos * cos / 1e8;
    let relative = structure.residual_flexibility / expected - 1.0;
    assert!(relative > 0.0 && relative < 1e-3, "{relative}");
}

#[test]
fn modes_of_either_count_agree_and_the_rest_returns_as_flexibility() {
    let drive = drive();
    let full = drive.modes(30, 30, true).unwrap();
    let reduced = drive.modes(30, 12, true).unwrap();
    assert_eq!(reduced, full.truncated(12, true).unwrap());
    assert!(reduced.residual_flexibility > 0.0);
    assert_eq!(
        drive.modes(30, 12, false).unwrap().residual_flexibility,
        0.0
    );
    let few = drive.modes(12, 12, false).unwrap();
    for mode in 0..12 {
        assert!((few.frequency[mode] - full.frequency[mode]).abs() < 1e-9 * full.frequency[11]);
        // Same signs, too.
        assert!((few.mesh[mode] - full.mesh[mode]).abs() < 1e-8);
        assert!((few.friction[mode] - full.friction[mode]).abs() < 1e-8);
    }
}

/// Frequencies fall towards their limit as elements are added. This also holds beyond 252 freedoms for two shafts, the
/// size at which the eigensolver begins to divide the matrix.
#[test]
fn any_number_of_elements_is_solved() {
    let modes = |elements| {
        let drive = FlexibleDrive {
            elements,
            ..drive()
        };
        drive.modes(30, 30, false).unwrap()
    };
    let mut coarser = modes([5, 7, 8]);
    for elements in [[6, 7, 8], [6, 10, 14], [15, 15, 15]] {
        let finer = modes(elements);
        for mode in RIGID_MODES..30 {
            let off = finer.frequency[mode] / coarser.frequency[mode] - 1.0;
            assert!((-0.01..=1e-9).contains(&off), "{elements:?} {mode} {off:e}");
        }
        coarser = finer;
    }
}

#[test]
fn signs_are_settled_and_repeatable() {
    let structure = drive().modes(40, 40, false).unwrap();
    let largest = structure.mesh.iter().fold(0.0_f64, |m, w| m.max(w.abs()));
    assert!(structure.mesh.iter().all(|&w| w > -1e-8 * largest));
    assert_eq!(structure, drive().modes(40, 40, false).unwrap());
}

#[test]
fn damping_is_global_with_overrides_and_rigid_modes_undamped() {
    let structure = drive().modes(6, 6, false).unwrap();
    assert_eq!(structure.damping, [0.0, 0.0, 0.02, 0.02, 0.07, 0.02]);
    assert_eq!(drive().modes(8, 5, false).unwrap().damping[4], 0.07);
    for mode in [0, 2, 7] {
        let mut wrong = drive();
        wrong.damping_overrides = vec![(mode, 0.05)];
        assert_eq!(
            wrong.modes(6, 6, false),
            Err(ShaftError::DampingOverride {
                mode,
                first: 3,
                last: 6
            })
        );
    }
}

#[test]
fn a_shaft_without_overhang_carries_its_end_inertia_at_the_first_bearing() {
    let mut short = drive();
    for shaft in &mut short.shafts {
        shaft.overhang = 0.0;
    }
    short.elements[0] = 0;
    let structure = short.modes(10, 10, false).unwrap();
    let base = short.gears.base_radii()[0];
    let expected = base.powi(2) / polar_inertia(&short, 0);
    let rigid: f64 = (structure.pinion_torque.unwrap()[..2].iter())
        .map(|p| (base * p).powi(2))
        .sum();
    assert!((rigid / expected - 1.0).abs() < 1e-10);
}

#[test]
fn unphysical_drives_are_refused() {
    let refused = |change: fn(&mut FlexibleDrive)| {
        let mut drive = drive();
        change(&mut drive);
        drive.modes(10, 10, false).unwrap_err()
    };
    let axial = refused(|d| d.shafts[1].bearings[0].axial = 0.0);
    assert_eq!(
        axial,
        ShaftError::NotHeld {
            shaft: 2,
            direction: "axially"
        }
    );
    let across = refused(|d| {
        d.shafts[0].bearings[0].y = 0.0;
        for bearing in &mut d.shafts[0].bearings {
            bearing.tilt = 0.0;
        }
    });
    assert!(matches!(across, ShaftError::NotHeld { shaft: 1, .. }));
    assert!(matches!(
        refused(|d| d.shafts[0].diameter = 0.057),
        ShaftError::BodyParts { gear: 1, .. }
    ));
    assert!(matches!(
        refused(|d| d.shafts[1].gear_position = 1.0),
        ShaftError::GearPosition { shaft: 2, .. }
    ));
    assert!(matches!(
        refused(|d| d.elements[1] = 0),
        ShaftError::NoElement { .. }
    ));
    assert!(matches!(
        refused(|d| d.damping = 1.0),
        ShaftError::DampingRatio { .. }
    ));
    assert!(matches!(
        refused(|d| d.shafts[0].bearings[1].y = -1.0),
        ShaftError::Gear(GearError::Negative { .. })
    ));
    assert!(matches!(
        refused(|d| d.density = f64::NAN),
        ShaftError::Gear(GearError::NotPositive { .. })
    ));
    for (modes, retained) in [(1, 1), (109, 10), (10, 11), (10, 1)] {
        assert!(matches!(
            drive().modes(modes, retained, true),
            Err(ShaftError::ModeCount(_))
        ));
    }
}

/// The effect of flanks and friction on the modes is that of forces on shafts with four bearings, calculated by hand.
///
/// The drive flanks push the pinion along `−(sin α, cos α, −tan β_b)`, with α in the transverse section. Friction
/// pushes it along `(cos α, −sin α, 0)`. The coast flanks are the image across the line of centres. All forces act at
/// the pitch point, and the opposite forces act on the wheel.
#[test]
fn bearings_bear_the_forces_of_flanks_and_friction() {
    let all = 2 * 9 * 6;
    for (helix, face_middle) in [(0.0, 0.0), (0.3, 2e-3), (-0.3, -3e-3)] {
        let mut drive = drive();
        drive.gears.helix_angle = helix;
        drive.gears.form.face_middle = face_middle;
        // Only the first bearing locates a shaft, and no bearing holds a tilt.
        for bearing in drive
            .shafts
            .iter_mut()
            .flat_map(|shaft| &mut shaft.bearings)
        {
            bearing.tilt = 0.0;
        }
        let structure = drive.modes(all, all, true).unwrap();
        let names: Vec<&str> = structure.bearings.iter().map(|b| b.name.as_str()).collect();
        assert_eq!(
            names[..5],
            [
                "pinion 1 x",
                "pinion 1 y",
                "pinion 1 axial",
                "pinion 2 x",
                "pinion 2 y"
            ]
        );
        assert_eq!(names.len(), 10);
        for bearing in &structure.bearings {
            assert_eq!(bearing.gain[..RIGID_MODES], [0.0, 0.0]);
        }
        let alpha = (20f64.to_radians().tan() / helix.cos()).atan();
        let (sin, cos) = alpha.sin_cos();
        let thrust = helix.tan() * cos;
        let radii = drive.gears.pitch_radii();
        let span = drive.shafts[0].span;
        let mid = 0.4 * span + face_middle;
        // Loads on the bearings of pinion and wheel by a force on the pinion at the pitch point.
        let bearing_forces = |[x, y, z]: [f64; 3]| {
            let shaft = |sign: f64, arm: f64| {
                let [x, y, z] = [sign * x, sign * y, sign * z];
                let second = [(mid * x - arm * z) / span, mid * y / span];
                [x - second[0], y - second[1], z, second[0], second[1]]
            };
            [shaft(1.0, radii[0]), shaft(-1.0, -radii[1])].concat()
        };
        // As the point moves along the face, the transverse part moves with it.
        let turned = |[x, y]: [f64; 2]| {
            let pinion = [-x / span, -y / span, 0.0, x / span, y / span];
            [pinion, pinion.map(|force| -force)].concat()
        };
        let coast = structure.coast.as_ref().unwrap();
        let drive_flank = [
            (&structure.mesh, bearing_forces([sin, cos, -thrust])),
            (&structure.mesh_tilt, turned([sin, cos])),
            (&structure.friction, bearing_forces([cos, -sin, 0.0])),
            (&structure.friction_lever, vec![0.0; 10]),
        ];
        let coast_flank = [
            (&coast.mesh, bearing_forces([-sin, cos, -thrust])),
            (&coast.tilt, turned([-sin, cos])),
            (&coast.friction, bearing_forces([-cos, -sin, 0.0])),
            (&coast.lever, vec![0.0; 10]),
        ];
        for (number, (column, expected)) in drive_flank.iter().chain(&coast_flank).enumerate() {
            // ω² q = w, the static answer to a unit load.
            for (bearing, expected) in structure.bearings.iter().zip(expected) {
                let force: f64 = (RIGID_MODES..all)
                    .map(|i| bearing.gain[i] * column[i] / structure.frequency[i].powi(2))
                    .sum();
                let scale = 1.0 + expected.abs();
                assert!(
                    (force - expected).abs() < 1e-7 * scale,
                    "{helix} {number} {}: {force} {expected}",
                    bearing.name
                );
            }
        }
    }
}

/// The static tilt of the flanks is that of the whole structure, however many modes are computed or retained.
#[test]
fn omitted_modes_tilt_the_flanks_too() {
    let drive = drive();
    let compliance = |modes: usize, retained: usize, flank: usize| {
        let structure = drive.modes(modes, retained, false).unwrap();
        TiltCompliance::of_flank(&structure, flank)
    };
    for flank in [0, 1] {
        let whole = compliance(80, 80, flank);
        for (modes, retained) in [(80, 6), (30, 6), (12, 12)] {
            let reduced = compliance(modes, retained, flank);
            assert!((reduced.by_force / whole.by_force - 1.0).abs() < 1e-9);
            assert!((reduced.by_moment / whole.by_moment - 1.0).abs() < 1e-9);
        }
    }
    let few = drive.modes(12, 6, false).unwrap();
    let kept = TiltCompliance::of_modes(&few.frequency, &few.mesh, &few.mesh_tilt);
    assert!(kept.by_moment < 0.9 * compliance(80, 80, 0).by_moment);
}
