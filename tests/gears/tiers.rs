//! The rigid-body tiers compared with closed forms, and with each other: a tier with stiff springs for its released
//! motions equals the tier below.
// Helpers outside the test functions may also unwrap.
#![allow(clippy::unwrap_used)]

use crate::default_drive;
use default_drive::{DENSITY, gears, shafts};
use gearatlas::gear::GearError;
use gearatlas::shaft::{
    Bearing, Disc, Drag, FlexibleDrive, Pedestal, RigidDrive, Shaft, ShaftError, Tier,
};
use gearatlas::structure::{ModalStructure, ModeCount};
use proptest::prelude::*;
use std::f64::consts::PI;

const PEDESTAL: Pedestal = Pedestal {
    x: 4e8,
    y: 3e8,
    mass: 3.0,
};

fn rigid(tier: Tier, shafts: [Shaft; 2]) -> ModalStructure {
    all_modes(&drive(tier, shafts))
}

fn all_modes(drive: &RigidDrive) -> ModalStructure {
    let all = drive.tier.freedoms();
    drive.modes(all, all, false).unwrap()
}

fn drive(tier: Tier, shafts: [Shaft; 2]) -> RigidDrive {
    RigidDrive {
        tier,
        gears: gears(),
        shafts,
        pedestals: Some([[PEDESTAL; 2]; 2]),
        density: DENSITY,
        damping: 0.01,
        damping_overrides: Vec::new(),
        gyroscopic: false,
    }
}

fn on_pedestals(pedestal: Pedestal) -> RigidDrive {
    RigidDrive {
        pedestals: Some([[pedestal; 2]; 2]),
        ..drive(Tier::Pedestal, shafts())
    }
}

fn flexible(stiffening: f64) -> FlexibleDrive {
    FlexibleDrive {
        young_modulus: 206e9 * stiffening,
        shear_modulus: 79e9 * stiffening,
        ..default_drive::flexible()
    }
}

/// A shaft with its gear, from its parts: mass, polar inertia, inertia about a diameter through the centre of mass, and
/// that centre's distance from the gear.
struct Body {
    mass: f64,
    polar: f64,
    transverse: f64,
    centre: f64,
}

fn body(index: usize, shaft: &Shaft) -> Body {
    let gears = gears();
    let length = shaft.span + shaft.overhang;
    let squares = [shaft.diameter, shaft.inner_diameter].map(|diameter| diameter.powi(2));
    let rod_mass = 0.25 * PI * (squares[0] - squares[1]) * length * DENSITY;
    let rod_polar = rod_mass * (squares[0] + squares[1]) / 8.0;
    let rod_offset = 0.5 * (shaft.span - shaft.overhang) - shaft.gear_position * shaft.span;
    let pitch = gears.module * f64::from(gears.teeth[index]);
    let gear = Disc::annulus(pitch, shaft.diameter, gears.body_length[index], DENSITY).unwrap();
    let mass = rod_mass + gear.mass;
    let centre = rod_mass * rod_offset / mass;
    let rod_transverse = 0.5 * rod_polar + rod_mass * length.powi(2) / 12.0;
    Body {
        mass,
        polar: rod_polar + gear.polar_inertia + shaft.end_inertia,
        transverse: rod_transverse
            + rod_mass * (rod_offset - centre).powi(2)
            + gear.transverse_inertia
            + gear.mass * centre.powi(2),
        centre,
    }
}

/// Frequencies \[rad/s\] of `M u'' + K u = 0`, M diagonal, K symmetric 2 × 2.
fn pair_frequencies(masses: [f64; 2], [[a, b], [_, d]]: [[f64; 2]; 2]) -> [f64; 2] {
    let [a, d] = [a / masses[0], d / masses[1]];
    let half = 0.5 * (a + d);
    let root = (0.25 * (a - d).powi(2) + b * b / (masses[0] * masses[1])).sqrt();
    [half - root, half + root].map(f64::sqrt)
}

fn assert_frequencies(structure: &ModalStructure, expected: &[f64], tolerance: f64) {
    let mut expected = expected.to_vec();
    expected.sort_by(f64::total_cmp);
    assert_eq!(structure.frequency[..2], [0.0, 0.0]);
    assert_eq!(structure.modes(), expected.len() + 2);
    for (found, wanted) in structure.frequency[2..].iter().zip(&expected) {
        assert!((found / wanted - 1.0).abs() < tolerance, "{found} {wanted}");
    }
}

#[test]
fn torsional_drive_on_a_closed_mesh() {
    let structure = rigid(Tier::Torsional, shafts());
    assert_eq!(structure.frequency, [0.0, 0.0]);
    let [base_1, base_2] = gears().base_radii();
    let [one, two] = [0, 1].map(|index| body(index, &shafts()[index]).polar);
    let expected = base_1.powi(2) / one + base_2.powi(2) / two;
    // ω² = k Σ r²/J: only the relative rotation has a mesh deflection.
    assert_eq!(structure.mesh[0], 0.0);
    assert!((structure.mesh[1].powi(2) / expected - 1.0).abs() < 1e-13);
    assert!((structure.torque[1] / structure.mesh[1] - 1.0).abs() < 1e-13);
    assert!(structure.friction[0].abs() < 1e-14);
    assert!(structure.bearings.is_empty());
    println!("closed mesh: {} rad/s", (4e8 * expected).sqrt());
}

/// All tiers describe the same machine: their rigid rotations are those of the flexible drive.
#[test]
fn rigid_rotations_are_those_of_the_flexible_drive() {
    let reference = flexible(1.0).modes(12, 12, false).unwrap();
    for tier in Tier::ALL {
        let structure = rigid(tier, shafts());
        assert_eq!(structure.rigid_modes(), 2);
        let torques = |s: &ModalStructure| {
            [
                s.pinion_torque.clone().unwrap(),
                s.wheel_torque.clone().unwrap(),
            ]
        };
        for (ours, theirs) in [&structure.mesh, &structure.torque, &structure.friction]
            .into_iter()
            .chain(torques(&structure).iter())
            .zip(
                [&reference.mesh, &reference.torque, &reference.friction]
                    .into_iter()
                    .chain(torques(&reference).iter()),
            )
        {
            let scale = theirs[1].abs();
            for mode in 0..2 {
                assert!((ours[mode] - theirs[mode]).abs() < 1e-9 * scale);
            }
        }
    }
}

#[test]
fn translational_bodies_are_masses_on_both_bearings() {
    let structure = rigid(Tier::Translational, shafts());
    let masses = [0, 1].map(|index| body(index, &shafts()[index]).mass);
    let expected: Vec<f64> = (masses.iter())
        .flat_map(|mass| [2.5e8, 2e8].map(|stiffness: f64| (stiffness / mass).sqrt()))
        .collect();
    assert_frequencies(&structure, &expected, 1e-12);
    // Each of the two masses contributes 1/m to Σ mesh² over the elastic modes.
    let sum: f64 = structure.mesh[2..].iter().map(|w| w * w).sum();
    let wanted: f64 = masses.iter().map(|mass| 1.0 / mass).sum();
    assert!((sum / wanted - 1.0).abs() < 1e-12);
    assert!(structure.mesh_tilt.iter().all(|&w| w == 0.0));
    let names: Vec<&str> = structure.bearings.iter().map(|b| b.name.as_str()).collect();
    assert_eq!(names.len(), 8);
    assert!(names.iter().all(|name| !name.ends_with("axial")));
}

/// Faces off the middle of the bodies: at rest a rigid shaft carries the mesh force and friction where they act,
/// independent of the position of its gear's mass.
#[test]
fn a_mesh_off_the_middle_of_the_bodies_acts_where_the_faces_are() {
    let offset = 7e-3;
    let mut off_middle = drive(Tier::Tilting, shafts());
    off_middle.gears.form.face_middle = offset;
    let moved = shafts().map(|shaft| Shaft {
        gear_position: shaft.gear_position + offset / shaft.span,
        ..shaft
    });
    let flexibility = |structure: &ModalStructure| -> Vec<f64> {
        let coast = structure.coast.as_ref().unwrap();
        let loads = [
            &structure.mesh,
            &structure.mesh_tilt,
            &structure.friction,
            &coast.mesh,
            &coast.friction,
        ];
        let bearings = structure.bearings.iter().map(|bearing| &bearing.gain);
        let seen: Vec<&Vec<f64>> = bearings.chain(loads).collect();
        (loads.iter().flat_map(|load| {
            seen.iter().map(move |row| {
                (2..structure.modes())
                    .map(|mode| row[mode] * load[mode] / structure.frequency[mode].powi(2))
                    .sum()
            })
        }))
        .collect()
    };
    let found = flexibility(&all_modes(&off_middle));
    let expected = flexibility(&rigid(Tier::Tilting, moved));
    let middle = flexibility(&rigid(Tier::Tilting, shafts()));
    // Forces on bearings have a common scale, because axial forces are zero. Every deflection has a separate scale.
    let (rows, forces) = (expected.len() / 5, expected.len() / 5 - 5);
    let largest = |i: usize| {
        let own = i % rows;
        let alike = if own < forces { 0..forces } else { own..own + 1 };
        (0..5)
            .flat_map(|load| alike.clone().map(move |row| load * rows + row))
            .map(|at| expected[at].abs())
            .fold(0.0, f64::max)
    };
    for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
        assert!(
            (found - expected).abs() < 1e-11 * largest(i),
            "{i}: {found} {expected}"
        );
    }
    let apart = middle.iter().zip(&expected).enumerate();
    let apart = apart.map(|(i, (middle, expected))| (middle - expected).abs() / largest(i));
    assert!(apart.fold(0.0, f64::max) > 0.05);
}

/// A rigid rotor on two springs at unequal distances from its centre of mass: 2 × 2 in each plane, with unequal springs
/// and tilt springs, and an axial mode.
#[test]
fn tilting_rotor_on_two_springs_at_unequal_distances() {
    let mut shafts = shafts();
    shafts[1].bearings[1].y = 0.4e8;
    shafts[1].bearings[1].tilt = 0.0;
    shafts[0].gear_position = 0.7;
    let mut expected = Vec::new();
    for (index, shaft) in shafts.iter().enumerate() {
        let body = body(index, shaft);
        let centre = shaft.gear_position * shaft.span + body.centre;
        let arms = [-centre, shaft.span - centre];
        for pick in [|b: &Bearing| b.x, |b: &Bearing| b.y] {
            let [mut direct, mut coupled, mut tilting] = [0.0; 3];
            for (bearing, arm) in shaft.bearings.iter().zip(arms) {
                direct += pick(bearing);
                coupled += pick(bearing) * arm;
                tilting += pick(bearing) * arm * arm + bearing.tilt;
            }
            let stiffness = [[direct, coupled], [coupled, tilting]];
            expected.extend(pair_frequencies([body.mass, body.transverse], stiffness));
        }
        expected.push((1e8 / body.mass).sqrt());
    }
    assert_frequencies(&rigid(Tier::Tilting, shafts), &expected, 1e-12);
}

/// In the middle of symmetric spans each body bounces on both bearings and pedestals as one chain of two masses, and
/// tilts on them as another: `m u'' = −k (u − v)`, `M v'' = k (u − v) − K v`.
#[test]
fn pedestals_make_chains_of_two_masses() {
    let mut shafts = shafts();
    for shaft in &mut shafts {
        shaft.overhang = 0.0;
        shaft.gear_position = 0.5;
    }
    let structure = rigid(Tier::Pedestal, shafts.clone());
    let chain = |inertia, seat, bearing: f64, ground: f64, tilt: f64| {
        let stiffness = [[bearing + tilt, -bearing], [-bearing, bearing + ground]];
        pair_frequencies([inertia, seat], stiffness)
    };
    let mut expected = Vec::new();
    for (index, shaft) in shafts.iter().enumerate() {
        let body = body(index, shaft);
        assert!(body.centre.abs() < 1e-15);
        let arm = (0.5 * shaft.span).powi(2);
        for (bearing, ground) in [
            (shaft.bearings[0].x, PEDESTAL.x),
            (shaft.bearings[0].y, PEDESTAL.y),
        ] {
            let seats = 2.0 * PEDESTAL.mass;
            expected.extend(chain(body.mass, seats, 2.0 * bearing, 2.0 * ground, 0.0));
            // Seats on opposite sides move in opposite directions, by θ a each.
            expected.extend(chain(
                body.transverse,
                seats * arm,
                2.0 * bearing * arm,
                2.0 * ground * arm,
                2.0 * shaft.bearings[0].tilt,
            ));
        }
        expected.push((1e8 / body.mass).sqrt());
    }
    assert_frequencies(&structure, &expected, 1e-12);
}

/// Pedestals of decreasing mass become springs in series with the bearings; the difference decreases with their mass.
#[test]
fn light_pedestals_are_springs_in_series() {
    let mut softer = shafts();
    for bearing in softer.iter_mut().flat_map(|shaft| &mut shaft.bearings) {
        bearing.x = 1.0 / (1.0 / bearing.x + 1.0 / 4e8);
        bearing.y = 1.0 / (1.0 / bearing.y + 1.0 / 3e8);
    }
    let series = rigid(Tier::Tilting, softer);
    let [coarse, fine] = [1e-2, 1e-4].map(|mass| {
        let sprung = on_pedestals(Pedestal { mass, ..PEDESTAL });
        deviation(&sprung.modes(12, 12, false).unwrap(), &series)
    });
    println!("light pedestals: {coarse:.1e} at 10 g, {fine:.1e} at 0.1 g");
    assert!(fine < 1e-4, "{fine:e}");
    assert!(
        (50.0..200.0).contains(&(coarse / fine)),
        "{coarse:e} {fine:e}"
    );
}

/// Largest relative difference of the elastic frequencies of `lower`, and of the mesh participations relative to the
/// largest of them.
fn deviation(upper: &ModalStructure, lower: &ModalStructure) -> f64 {
    let largest = lower.mesh.iter().fold(0.0_f64, |m, w| m.max(w.abs()));
    (0..lower.modes())
        .map(|mode| {
            let frequency = match lower.frequency[mode] {
                0.0 => upper.frequency[mode],
                wanted => (upper.frequency[mode] / wanted - 1.0).abs(),
            };
            frequency.max((upper.mesh[mode] - lower.mesh[mode]).abs() / largest)
        })
        .fold(0.0, f64::max)
}

/// Asserts that `upper` tends to `lower` when the springs of its additional motions stiffen, with the inverse of the
/// stiffness.
#[allow(clippy::print_stdout)]
fn assert_limit(name: &str, upper: impl Fn(f64) -> ModalStructure, lower: &ModalStructure) {
    let [coarse, fine] = [1e4, 1e6].map(|stiffening| deviation(&upper(stiffening), lower));
    println!("{name}: {coarse:.1e} at 1e4, {fine:.1e} at 1e6");
    assert!(coarse < 1e-2, "{name}: {coarse:e}");
    let gain = coarse / fine;
    assert!((50.0..200.0).contains(&gain), "{name}: {gain}");
}

#[test]
fn a_pedestal_drive_on_stiff_pedestals_tilts_only() {
    let lower = rigid(Tier::Tilting, shafts());
    let upper = |stiffening: f64| {
        all_modes(&on_pedestals(Pedestal {
            x: 4e8 * stiffening,
            y: 3e8 * stiffening,
            mass: 3.0,
        }))
    };
    assert_limit("pedestal to tilting", upper, &lower);
}

#[test]
fn a_tilting_drive_held_against_tilt_translates_only() {
    let lower = rigid(Tier::Translational, shafts());
    let upper = |stiffening: f64| {
        let mut shafts = shafts();
        for bearing in shafts.iter_mut().flat_map(|shaft| &mut shaft.bearings) {
            bearing.tilt *= stiffening;
            bearing.axial *= stiffening;
        }
        rigid(Tier::Tilting, shafts)
    };
    assert_limit("tilting to translational", upper, &lower);
}

/// On stiff bearings only rotations have a mesh deflection. The mode of the closed mesh is that of the torsional drive,
/// and the bearings contribute their static flexibility.
#[test]
fn a_translational_drive_on_stiff_bearings_rotates_only() {
    let lower = rigid(Tier::Torsional, shafts());
    let soft = |stiffening: f64| {
        let mut shafts = shafts();
        for bearing in shafts.iter_mut().flat_map(|shaft| &mut shaft.bearings) {
            bearing.x *= stiffening;
            bearing.y *= stiffening;
        }
        drive(Tier::Translational, shafts)
            .modes(6, 2, true)
            .unwrap()
    };
    let (sin, cos) = gears().pressure_angle.sin_cos();
    for stiffening in [1.0, 1e4] {
        let upper = soft(stiffening);
        assert!(deviation(&upper, &lower) < 1e-12);
        let exact = 2.0 * (sin * sin / 2.5e8 + cos * cos / 2e8) / stiffening;
        assert!((upper.residual_flexibility / exact - 1.0).abs() < 1e-12);
    }
}

/// Lowest modes of the flexible drive with stiff shafts; the upper ones stay far above.
#[test]
fn a_flexible_drive_with_stiff_shafts_is_the_tilting_drive() {
    let lower = rigid(Tier::Tilting, shafts());
    let upper = |stiffening: f64| flexible(stiffening).modes(12, 12, false).unwrap();
    assert_limit("flexible to tilting", upper, &lower);
}

#[test]
fn more_modes_than_freedoms_are_refused() {
    for (tier, freedoms) in Tier::ALL.into_iter().zip([2, 6, 12, 20]) {
        assert_eq!(tier.freedoms(), freedoms);
        let drive = drive(tier, shafts());
        assert_eq!(
            drive.modes(freedoms, freedoms, false).unwrap().modes(),
            freedoms
        );
        assert_eq!(
            drive.modes(freedoms + 1, 2, false),
            Err(ShaftError::ModeCount(ModeCount {
                requested: freedoms + 1,
                least: 1,
                available: freedoms
            }))
        );
    }
}

/// A tier needs only stiffnesses for the motions that it releases.
#[test]
fn what_a_tier_releases_must_be_held() {
    let without = |change: fn(&mut Bearing)| {
        let mut shafts = shafts();
        shafts[1].bearings.iter_mut().for_each(change);
        shafts
    };
    let modes = |tier: Tier, shafts| drive(tier, shafts).modes(2, 2, false);
    let free = |direction| {
        Err(ShaftError::NotHeld {
            shaft: 2,
            direction,
        })
    };
    let axial = || without(|bearing| bearing.axial = 0.0);
    assert!(modes(Tier::Translational, axial()).is_ok());
    assert_eq!(modes(Tier::Tilting, axial()), free("axially"));
    let y = || without(|bearing| bearing.y = 0.0);
    assert!(modes(Tier::Torsional, y()).is_ok());
    let direction = "across the line of centres";
    assert_eq!(modes(Tier::Translational, y()), free(direction));
    let floating = on_pedestals(Pedestal {
        mass: 0.0,
        ..PEDESTAL
    });
    assert!(matches!(
        floating.modes(2, 2, false),
        Err(ShaftError::Gear(GearError::NotPositive { .. }))
    ));
    let mut bare = drive(Tier::Pedestal, shafts());
    bare.pedestals = None;
    assert_eq!(bare.modes(2, 2, false), Err(ShaftError::NoPedestals));
}

/// In every tier, the bearings pass on the whole mesh force: `−F n` on the pinion and `+F n` on the wheel, under static
/// load.
#[test]
fn bearing_forces_balance_the_mesh_force() {
    let (sin, cos) = gears().pressure_angle.sin_cos();
    for tier in [Tier::Translational, Tier::Tilting, Tier::Pedestal] {
        let structure = rigid(tier, shafts());
        // Static equilibrium under a unit load: ω² q = torque − mesh.
        let force = |gain: &[f64]| -> f64 {
            (2..tier.freedoms())
                .map(|i| {
                    let square = structure.frequency[i].powi(2);
                    gain[i] * (structure.torque[i] - structure.mesh[i]) / square
                })
                .sum()
        };
        for (shaft, sign) in [("pinion", -1.0), ("wheel", 1.0)] {
            for (direction, exact) in [("x", sin), ("y", cos)] {
                let felt = structure.bearings.iter().filter(|bearing| {
                    bearing.name.starts_with(shaft) && bearing.name.ends_with(direction)
                });
                let sum: f64 = felt.map(|bearing| force(&bearing.gain)).sum();
                assert!(
                    (sum - sign * exact).abs() < 1e-10,
                    "{shaft} {direction}: {sum}"
                );
            }
        }
    }
}

/// Any shaft on any bearings.
fn any_shaft() -> impl Strategy<Value = Shaft> {
    let stiffness = || 1e7..1e9f64;
    let bearing = move || {
        (stiffness(), stiffness(), 0.0..1e5f64).prop_map(|(x, y, tilt)| Bearing {
            x,
            y,
            axial: 1e8,
            tilt,
            ..Bearing::default()
        })
    };
    let lengths = (15e-3..35e-3f64, 0.06..0.3f64, 0.0..0.1f64, 0.1..0.9f64);
    (lengths, 0.0..1e-2f64, [bearing(), bearing()]).prop_map(
        |((diameter, span, overhang, gear_position), end_inertia, bearings)| Shaft {
            diameter,
            inner_diameter: 0.6 * diameter,
            span,
            overhang,
            gear_position,
            end_inertia,
            bearings,
            drag: Drag::default(),
        },
    )
}

fn any_pedestal() -> impl Strategy<Value = Pedestal> {
    let stiffness = || 1e7..1e9f64;
    (stiffness(), stiffness(), 0.1..10.0f64).prop_map(|(x, y, mass)| Pedestal { x, y, mass })
}

/// Displacement of a gear by a unit force on it: a rigid bar on two springs and tilt springs.
fn gear_flexibility(shaft: &Shaft, springs: [f64; 2]) -> f64 {
    let gear = shaft.gear_position * shaft.span;
    let [mut direct, mut coupled, mut tilting] = [0.0; 3];
    for ((bearing, spring), arm) in shaft
        .bearings
        .iter()
        .zip(springs)
        .zip([-gear, shaft.span - gear])
    {
        direct += spring;
        coupled += spring * arm;
        tilting += spring * arm * arm + bearing.tilt;
    }
    tilting / (direct * tilting - coupled * coupled)
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 64,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// Properties of the modes of any structure: its mobility at the mesh, `Σ w² = w M⁻¹ w`, and its flexibility there,
    /// `Σ w²/ω² = w K⁻¹ w`.
    #[test]
    fn sums_over_all_modes_are_mobility_and_flexibility(
        shafts in [any_shaft(), any_shaft()],
        seats in [[any_pedestal(), any_pedestal()], [any_pedestal(), any_pedestal()]],
    ) {
        let base = gears().base_radii();
        let (sin, cos) = gears().pressure_angle.sin_cos();
        for tier in [Tier::Tilting, Tier::Pedestal] {
            let mut machine = drive(tier, shafts.clone());
            machine.pedestals = Some(seats);
            let structure = all_modes(&machine);
            let flexibility = machine.modes(tier.freedoms(), 2, true).unwrap().residual_flexibility;
            let (mut mobility, mut exact) = (0.0, 0.0);
            for (index, shaft) in shafts.iter().enumerate() {
                let body = body(index, shaft);
                mobility += base[index].powi(2) / body.polar
                    + 1.0 / body.mass
                    + body.centre.powi(2) / body.transverse;
                let springs = |bearing: fn(&Bearing) -> f64, seat: fn(&Pedestal) -> f64| {
                    [0, 1].map(|number| {
                        let yields = match tier {
                            Tier::Pedestal => 1.0 / seat(&seats[index][number]),
                            _ => 0.0,
                        };
                        1.0 / (1.0 / bearing(&shaft.bearings[number]) + yields)
                    })
                };
                let along = springs(|b| b.x, |p| p.x);
                let y = springs(|b| b.y, |p| p.y);
                exact += sin * sin * gear_flexibility(shaft, along)
                    + cos * cos * gear_flexibility(shaft, y);
            }
            let sum: f64 = structure.mesh.iter().map(|w| w * w).sum();
            prop_assert!((sum / mobility - 1.0).abs() < 1e-10, "{sum} {mobility}");
            prop_assert!((flexibility / exact - 1.0).abs() < 1e-9, "{flexibility} {exact}");
        }
    }
}
