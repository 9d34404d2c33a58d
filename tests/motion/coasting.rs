//! Coasting: a drive at −T is the mirror image of the drive with a mirrored drawing at +T. Only signs may differ, also
//! with misaligned flanks, shafts that tilt, friction that changes its direction, and no symmetry between the gears.

#![allow(clippy::unwrap_used)]

use crate::place;
use gearatlas::store::{ResultTable, TableKind};
use place::{Place, status, stderr};

const QUICKSTART: &str = include_str!("../../manifests/quickstart.toml");

/// The default drive with a gear off the middle of its bearings (`side` 0), or mirrored about the line between the axes
/// (`side` 1).
fn manifest(side: usize, mesh: &str, loads: [f64; 2]) -> String {
    let pick = |pair: [&str; 2]| pair[side].to_owned();
    let (first, second) = match side {
        0 => ("pinion", "wheel"),
        _ => ("wheel", "pinion"),
    };
    let head = QUICKSTART.split_once("[gear]").unwrap().0;
    let bearings = QUICKSTART.split_once("[shafts.bearings]").unwrap().1;
    let bearings = bearings.split_once("[mesh]").unwrap().0;
    format!(
        "{head}
[gear]
teeth = {teeth}
module = \"4 mm\"
pressure_angle = \"20 deg\"
face_width = \"20 mm\"
body_length = {bodies}
rated_torque = {rated}

[shafts]
young_modulus = \"206 GPa\"
shear_modulus = \"79 GPa\"
density = \"7850 kg/m^3\"
span = \"120 mm\"
overhang = \"40 mm\"
gear_position = 0.3
elements = [3, 5, 7]

[shafts.{first}]
diameter = \"22 mm\"
end_inertia = \"2e-3 kg*m^2\"

[shafts.{second}]
diameter = \"26 mm\"
end_inertia = \"5e-3 kg*m^2\"

[shafts.bearings]{bearings}
[mesh]
half_gap = \"10 um\"
contact_damping = 0.05
{mesh}

[grid]
load = {{ values = [{}, {}] }}
speed = {{ values = [{speed}] }}

[run]
transient = 4000
cycles = 600

[analyses]
nvh = {{ harmonics = 2 }}
",
        loads[0],
        loads[1],
        teeth = pick(["[20, 30]", "[30, 20]"]),
        bodies = pick(["[\"70 mm\", \"40 mm\"]", "[\"40 mm\", \"70 mm\"]"]),
        rated = pick(["50", "75"]),
        speed = pick(["900", "600"]),
    )
}

/// Results of a manifest, one row per load.
fn results(text: &str) -> (Place, ResultTable) {
    let place = Place::new(text);
    let output = place.run("out", &["-j", "1"]);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let table = ResultTable::read(&place.path("out"), TableKind::Points).unwrap();
    (place, table)
}

/// Results of the mesh under the mean load, with their signs in the mirror image. They agree within the error of a
/// table of an unevenly loaded face (at most 2e-7).
const MESH: [(&str, f64); 5] = [
    ("misalignment_loaded", -1.0),
    ("load_centre", 1.0),
    ("mesh_stiffness", 1.0),
    ("contact_ratio_loaded", 1.0),
    ("transmission_error_pp", 1.0),
];

/// Results of the motion, with their signs in the mirror image. Segments of the cycle have other positions on the
/// mirrored flank, so that results agree to the accuracy of segments. The deflection is along the drive flanks' line
/// of action, and has no image.
const MOTION: [(&str, f64); 8] = [
    ("force_mean", -1.0),
    ("power_transmitted", -1.0),
    ("force_std", 1.0),
    ("force_peak", 1.0),
    ("power_loss", 1.0),
    ("efficiency", 1.0),
    ("fraction_free", 1.0),
    ("fraction_both", 1.0),
];

/// Asserts that the results of one drive are those of its mirror image at the opposite load.
fn mirrored(one: &ResultTable, other: &ResultTable) {
    let mut seen = 0;
    let mut same = |names: [&str; 2], sign: f64, tolerance: f64| {
        let column = |table: &ResultTable, name| table.f64(name).unwrap();
        let rows = column(one, names[0])
            .into_iter()
            .zip(column(other, names[1]));
        for (row, pair) in rows.enumerate() {
            let (Some(a), Some(b)) = pair else {
                assert_eq!(pair, (None, None), "{names:?} of row {row}");
                continue;
            };
            let size = a.abs().max(b.abs()).max(1e-9);
            let apart = (a - sign * b).abs();
            assert!(apart <= tolerance * size, "{names:?} of row {row}: {a} {b}");
            seen += 1;
        }
    };
    // The pieces of the stiffness over a cycle are not images of each other, so the tolerance is larger.
    for (name, sign) in MESH {
        same([name; 2], sign, 1e-4);
    }
    let motion = 3e-3;
    for (name, sign) in MOTION {
        same([name; 2], sign, motion);
    }
    same(["fraction_drive", "fraction_coast"], 1.0, motion);
    same(["fraction_coast", "fraction_drive"], 1.0, motion);
    assert!(seen > 20, "{seen}");
}

#[test]
fn a_coasting_drive_is_the_image_of_its_mirrored_drawing() {
    let mesh = |misalignment: &str| {
        format!(
            "stiffness = \"table\"\nsegments = 48\nfriction = 0.06\nshaft_tilt = true\nmisalignment = \"{misalignment} mrad\""
        )
    };
    let (_here, one) = results(&manifest(0, &mesh("0.2"), [-0.6, 0.8]));
    let (_there, other) = results(&manifest(1, &mesh("-0.2"), [0.6, -0.8]));
    mirrored(&one, &other);
    // The coast flanks carry the mean load, and the shafts tilt them differently from the drive flanks.
    let coast = one.f64("fraction_coast").unwrap();
    assert!(coast[0].unwrap() > 0.5);
    assert!(coast[1].unwrap() < 0.5);
    let centre = one.f64("load_centre").unwrap();
    assert!(centre[0].unwrap().abs() > 1e-4, "{centre:?}");
}

#[test]
fn pairs_of_teeth_coast_as_they_drive() {
    let mesh = "stiffness = \"table\"\nresolution = \"pairs\"\nfriction = 0.06";
    let (_here, one) = results(&manifest(0, mesh, [-0.6, 0.0]));
    let (_there, other) = results(&manifest(1, mesh, [0.6, 0.0]));
    mirrored(&one, &other);
}
