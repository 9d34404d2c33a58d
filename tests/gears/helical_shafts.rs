//! Loads of helical gears on their bearings: axial forces, and moments proportional to the pitch radii.

#![allow(clippy::unwrap_used)]

use crate::default_drive;
use gearatlas::shaft::{Bearing, RigidDrive, Tier};
use gearatlas::structure::ModalStructure;

const RIGID_MODES: usize = 2;

fn drive(degrees: f64, tier: Tier) -> RigidDrive {
    let mut gears = default_drive::gears();
    gears.helix_angle = degrees.to_radians();
    let mut shafts = default_drive::shafts();
    for bearing in shafts.iter_mut().flat_map(|shaft| &mut shaft.bearings) {
        // All moments act as forces on the bearings.
        *bearing = Bearing {
            tilt: 0.0,
            ..*bearing
        };
    }
    RigidDrive {
        tier,
        gears,
        shafts,
        pedestals: None,
        density: default_drive::DENSITY,
        damping: 0.01,
        damping_overrides: Vec::new(),
        gyroscopic: false,
    }
}

/// Force on a bearing under a mesh force of 1 N on the drive flanks (side 1) or −1 N on the coast flanks (side −1),
/// with the torques in balance.
fn force(structure: &ModalStructure, side: f64, name: &str) -> f64 {
    let coast = structure.coast.as_ref().unwrap();
    let mesh = if side > 0.0 { &structure.mesh } else { &coast.mesh };
    let bearing = structure.bearings.iter().find(|own| own.name == name);
    let Some(bearing) = bearing else { return 0.0 };
    (RIGID_MODES..mesh.len())
        .map(|i| {
            let omega = structure.frequency[i];
            bearing.gain[i] * side * (structure.torque[i] - mesh[i]) / (omega * omega)
        })
        .sum()
}

/// Each rigid shaft is in force and moment equilibrium with F tan β_b along the axis, at the pitch point.
#[test]
fn bearings_bear_the_axial_force_and_its_moment() {
    for degrees in [-15.0, 0.0, 20.0, 30.0] {
        let drive = drive(degrees, Tier::Tilting);
        let all = Tier::Tilting.freedoms();
        let structure = drive.modes(all, all, false).unwrap();
        let axial = drive.gears.base_helix_angle().tan();
        let (sin, cos) = drive.gears.operating_pressure_angle().unwrap().sin_cos();
        let radii = drive.gears.operating_pitch_radii().unwrap();
        for side in [1.0, -1.0] {
            for (index, name) in ["pinion", "wheel"].into_iter().enumerate() {
                let sign = [-1.0, 1.0][index];
                let of = |direction: &str| {
                    [1, 2].map(|number| {
                        force(&structure, side, &format!("{name} {number} {direction}"))
                    })
                };
                let close = |found: f64, exact: f64, what: &str| {
                    let off = (found - exact).abs();
                    assert!(
                        off < 1e-9,
                        "{degrees} {side} {name} {what}: {found} {exact}"
                    );
                };
                close(of("x").iter().sum(), sign * sin, "x");
                close(of("y").iter().sum(), sign * side * cos, "y");
                close(of("axial").iter().sum(), -sign * side * axial, "axial");
                let shaft = &drive.shafts[index];
                let gear = shaft.gear_position * shaft.span;
                let [first, second] = of("x");
                let moment = -gear * first + (shaft.span - gear) * second;
                close(moment, -side * axial * radii[index], "moment");
            }
        }
    }
}

/// Shafts without axial freedom have no axial force.
#[test]
fn tiers_without_axial_freedom_keep_their_modes() {
    for tier in [Tier::Torsional, Tier::Translational] {
        let of = |degrees: f64| {
            let drive = drive(degrees, tier);
            drive.modes(tier.freedoms(), tier.freedoms(), false)
        };
        let (left, right) = (of(20.0).unwrap(), of(-20.0).unwrap());
        assert_eq!(left.mesh, right.mesh);
        assert!(left.bearings.iter().all(|own| !own.name.ends_with("axial")));
    }
}
