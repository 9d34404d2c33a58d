//! What `atlas check` tells of the structure: the whole text is a snapshot.

#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::process::Command;

/// A shaft between a mesh and a stop, with drag, a heavily damped mode, and a second mesh with three
/// cycles in five; a load turns twice in three cycles.
const MODAL_FILE: &str = r#"
teeth = 20
rated_force = 1330.0
frequency = [0.0, 0.0, 4200.0, 6000.0]
damping = [0.0, 0.0, 0.01, 0.0]
mesh = [0.0, 0.6, 0.3, 0.1]
torque = [0.0, 0.6, 0.3, 0.0]
damping_matrix = [[0.0, 0.0, 0.0, 0.0], [0.0, 12.0, 1.0, 0.0], [0.0, 1.0, 4.0, 0.0], [0.0, 0.0, 0.0, 15000.0]]

[[contact]]
name = "second mesh"
participation = [0.0, -0.4, 0.2, 0.0]
gap = "10 um"
levels = ["3e8 N/m", "2.2e8 N/m"]
cycles = [3, 5]

[[harmonic_load]]
name = "pump"
force = [0.0, 0.0, 2.0, 1.0]
amplitude = 20
cycles = [2, 3]
"#;

const MANIFEST: &str = r#"
[job]
name = "case"

[model]
kind = "modal"
file = "case.modal.toml"

[mesh]
half_gap = "15 um"
stiffness = "constant"
mean_stiffness = "4e8 N/m"
contact_damping = 0.05

[grid]
"model.retained" = { values = [4, 3] }
load = 0.1
speed = { from = 200, to = 700, count = 10 }
"#;

fn check(folder: &Path, arguments: &[&str]) -> String {
    std::fs::write(folder.join("case.modal.toml"), MODAL_FILE).unwrap();
    std::fs::write(folder.join("case.toml"), MANIFEST).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_atlas"))
        .args(["check", "case.toml"])
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap();
    let [said, failed] =
        [output.stdout, output.stderr].map(|said| String::from_utf8(said).unwrap());
    assert!(output.status.success(), "{failed}");
    said
}

#[test]
fn the_structure_is_told() {
    let folder = tempfile::tempdir().unwrap();
    insta::assert_snapshot!("structure", check(folder.path(), &[]));
}

/// The speeds are those at which the harmonics of the mesh have the closed modes' frequencies.
#[test]
fn programs_are_told_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let told: serde_json::Value = serde_json::from_str(&check(folder.path(), &["--json"])).unwrap();
    let structure = &told["structure"];
    assert_eq!(structure["count"], 2);
    assert_eq!(structure["base_period"], 15);
    assert_eq!(structure["open"].as_array().unwrap().len(), 4);
    let closed = structure["closed"].as_array().unwrap();
    let share: f64 = (closed.iter())
        .map(|mode| mode["mesh_share"].as_f64().unwrap())
        .sum();
    // Their sum is k w'(K + k w w')^-1 w, which is 1 where nothing but the mesh holds a rotation.
    assert!((share - 1.0).abs() < 1e-9, "{share}");
    for mode in &closed[1..] {
        let frequency = mode["frequency_hz"].as_f64().unwrap();
        for (harmonic, speed) in (1..).zip(mode["resonant_speeds"].as_array().unwrap()) {
            let mesh = 20.0 * speed.as_f64().unwrap() / std::f64::consts::TAU;
            assert!((f64::from(harmonic) * mesh / frequency - 1.0).abs() < 1e-12);
        }
    }
}
