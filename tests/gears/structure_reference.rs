//! The default drive compared with an independent finite-element assembly of the same drive
//! (`tests/data/default-drive.modal.toml`).
// Helpers outside the test functions may also unwrap.
#![allow(clippy::unwrap_used)]

use crate::default_drive;
use gearatlas::structure::ModalStructure;
use std::f64::consts::PI;

const MODES: usize = 40;
const MEAN_STIFFNESS: f64 = 4e8;

/// Columns of the independent assembly.
struct Reference(toml::Table);

impl Reference {
    fn read() -> Self {
        Self(
            include_str!("../data/default-drive.modal.toml")
                .parse()
                .unwrap(),
        )
    }

    fn column(&self, key: &str) -> Vec<f64> {
        let values = self.0[key].as_array().unwrap();
        assert_eq!(values.len(), MODES, "{key}");
        values.iter().map(|v| v.as_float().unwrap()).collect()
    }
}

fn structure() -> ModalStructure {
    default_drive::flexible()
        .modes(MODES, MODES, false)
        .unwrap()
}

fn largest(column: &[f64]) -> f64 {
    column.iter().fold(0.0, |m, v| m.max(v.abs()))
}

#[test]
fn frequencies_agree() {
    let ours = structure();
    let theirs = Reference::read().column("frequency");
    assert_eq!(ours.frequency[..2], [0.0, 0.0]);
    let worst = (ours.frequency.iter().zip(&theirs).skip(2))
        .map(|(a, b)| (a / b - 1.0).abs())
        .fold(0.0, f64::max);
    println!("largest relative difference of a frequency: {worst:.1e}");
    assert!(worst < 1e-6, "{worst:e}");
}

/// Modes whose frequencies differ by less than 0.1 % may mix under a small difference of
/// the assemblies: only the sum of squares over such a group is comparable.
fn groups(frequency: &[f64]) -> Vec<std::ops::Range<usize>> {
    let mut groups: Vec<std::ops::Range<usize>> = Vec::new();
    for mode in 0..frequency.len() {
        match groups.last_mut() {
            Some(group) if frequency[mode] <= frequency[group.start] * 1.001 => {
                group.end = mode + 1;
            }
            _ => groups.push(mode..mode + 1),
        }
    }
    groups
}

/// Largest difference of the participations of each group, relative to the column's largest.
fn column_difference(frequency: &[f64], ours: &[f64], theirs: &[f64]) -> f64 {
    let norm = |column: &[f64]| column.iter().map(|v| v * v).sum::<f64>().sqrt();
    (groups(frequency).into_iter())
        .map(|group| (norm(&ours[group.clone()]) - norm(&theirs[group])).abs())
        .fold(0.0, f64::max)
        / largest(theirs)
}

#[test]
fn participations_agree() {
    let ours = structure();
    let reference = Reference::read();
    let half_base_pitch = 0.5 * PI * 4e-3 * 20f64.to_radians().cos();
    for (key, column, scale) in [
        ("mesh", &ours.mesh, 1.0),
        ("mesh_tilt", &ours.mesh_tilt, 1.0),
        ("torque", &ours.torque, 1.0),
        ("friction", &ours.friction, 1.0),
        ("friction_lever", &ours.friction_lever, half_base_pitch),
    ] {
        let column: Vec<f64> = column.iter().map(|v| v * scale).collect();
        let difference = column_difference(&ours.frequency, &column, &reference.column(key));
        println!("{key}: {difference:.1e} of the column's largest");
        assert!(difference < 1e-4, "{key}: {difference:e}");
    }
}

/// Participations agree mode by mode, without grouping, for quantities that do not depend on the basis of the rigid
/// pair, or for which the two assemblies have the same basis.
#[test]
fn participations_agree_mode_by_mode() {
    let ours = structure();
    let reference = Reference::read();
    for (key, column, from) in [
        ("mesh", &ours.mesh, 0),
        ("mesh_tilt", &ours.mesh_tilt, 0),
        ("torque", &ours.torque, 0),
        ("friction", &ours.friction, 2),
    ] {
        let theirs = reference.column(key);
        let difference = (from..MODES)
            .map(|mode| (column[mode].abs() - theirs[mode].abs()).abs())
            .fold(0.0, f64::max)
            / largest(&theirs);
        println!("{key}: {difference:.1e} of the column's largest, mode by mode");
        assert!(difference < 1e-4, "{key}: {difference:e}");
    }
}

/// Relative signs of mesh, tilt and torque within a mode are physical; the sign of a mode is not.
#[test]
fn signs_within_a_mode_agree() {
    let ours = structure();
    let reference = Reference::read();
    let mesh = reference.column("mesh");
    for (key, column) in [("mesh_tilt", &ours.mesh_tilt), ("torque", &ours.torque)] {
        let theirs = reference.column(key);
        let scale = largest(&theirs) * largest(&mesh);
        for mode in 0..MODES {
            let (a, b) = (ours.mesh[mode] * column[mode], mesh[mode] * theirs[mode]);
            assert!(
                (a - b).abs() < 1e-4 * scale,
                "{key}, mode {}: {a} {b}",
                mode + 1
            );
        }
    }
}

/// In the two rigid rotations the friction columns of the independent assembly are those of a reversed arm on the
/// pinion, `tan α (r_b1 θ1 + r_b2 θ2)` and `θ1 − θ2`. Thus friction at the pitch point would drive the neutral
/// rotation, although the flanks roll there. The friction of this program vanishes there. The sums of squares over the
/// pair are equal, so that `participations_agree` cannot detect the difference.
#[test]
fn rigid_friction_differs_by_the_arm_of_the_pinion() {
    let ours = structure();
    let reference = Reference::read();
    let (friction, lever) = (
        reference.column("friction"),
        reference.column("friction_lever"),
    );
    let angle = 20f64.to_radians();
    let [base_1, base_2] = default_drive::flexible().gears.base_radii();
    let half_base_pitch = 0.5 * PI * 4e-3 * angle.cos();
    assert!(ours.friction[0].abs() < 1e-9 * largest(&ours.friction));
    for mode in 0..2 {
        let pinion = ours.pinion_torque.as_ref().unwrap()[mode];
        let wheel = ours.wheel_torque.as_ref().unwrap()[mode];
        let tangential = angle.tan() * (base_1 * pinion + base_2 * wheel);
        let moment = half_base_pitch * (pinion - wheel);
        assert!(
            (tangential.abs() - friction[mode].abs()).abs() < 1e-9,
            "mode {}",
            mode + 1
        );
        assert!(
            (moment.abs() - lever[mode].abs()).abs() < 1e-9,
            "mode {}",
            mode + 1
        );
    }
}

#[test]
fn participation_sums_and_residual_flexibility() {
    let sum = |retained| -> f64 {
        let structure = default_drive::flexible()
            .modes(MODES, retained, false)
            .unwrap();
        assert_eq!(structure.residual_flexibility, 0.0);
        structure.mesh.iter().map(|w| w * w).sum()
    };
    for (retained, expected) in [(15, 1.77), (20, 1.78), (40, 1.81)] {
        let found = sum(retained);
        println!("sum of squares at {retained} modes: {found:.4}");
        assert!((found - expected).abs() <= 0.005, "{retained}: {found}");
    }
    let augmented = default_drive::flexible().modes(MODES, 20, true).unwrap();
    let product = augmented.residual_flexibility * MEAN_STIFFNESS;
    println!("residual flexibility times mean stiffness, 40 to 20: {product:.4e}");
    assert!((product - 1.94e-3).abs() <= 0.005e-3, "{product}");
}
