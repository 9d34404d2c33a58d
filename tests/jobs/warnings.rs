//! Warnings of a job that runs nevertheless: keys without effect and unusual drives, reported once, with file, line,
//! key and remedy. Two keys that define one quantity are an error.

#![allow(clippy::unwrap_used)]

use crate::place;
use gearatlas::manifest::{self, Diagnostic, DiagnosticKind, Job};
use place::{OSCILLATOR, Place, status, stderr, stdout};
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn toml_files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => found.extend(toml_files(&path)),
            false if path.extension().is_some_and(|end| end == "toml") => found.push(path),
            false => {}
        }
    }
    found.sort();
    found
}

fn load(path: &Path, changes: &[String]) -> Job {
    let job = manifest::load_changed(path, changes);
    job.unwrap_or_else(|errors| panic!("{}: {errors}", path.display()))
}

/// Every manifest in `tests/manifests/warned` is valid, and the job without the keys that have no effect is the same.
#[test]
fn a_key_without_effect_changes_nothing() {
    let all = toml_files(&root().join("tests/manifests/warned"));
    assert!(all.len() >= 9, "{}", all.len());
    for path in all {
        let job = load(&path, &[]);
        assert!(!job.warnings.is_empty(), "{}", path.display());
        let in_manifest = |warning: &&Diagnostic| {
            assert_eq!(warning.kind, DiagnosticKind::NoEffect);
            assert!(warning.line > 0 && warning.remedy.is_some(), "{warning:?}");
            // Removing an axis changes the points, and a modal file is not part of the manifest.
            warning.span.source == 0 && !warning.key.contains('"')
        };
        let keys = job.warnings.diagnostics.iter().filter(in_manifest);
        let out: Vec<String> = keys.map(|warning| format!("{}=", warning.key)).collect();
        let without = load(&path, &out);
        assert_eq!(without.hash, job.hash, "{}", path.display());
        let left = job.warnings.diagnostics.len() - out.len();
        assert_eq!(
            without.warnings.diagnostics.len(),
            left,
            "{}",
            path.display()
        );
    }
}

/// One stiffness for the whole cycle is a choice that every shipped manifest accepts, with any other keys in [mesh].
#[test]
fn every_shipped_manifest_takes_a_constant_stiffness() {
    let changes = ["mesh.stiffness=constant", "mesh.mean_stiffness=4e8"].map(str::to_owned);
    let mut warned = 0;
    for path in toml_files(&root().join("manifests")) {
        let text = fs::read_to_string(&path).unwrap();
        if !text.contains("\n[mesh]") {
            continue;
        }
        let job = load(&path, &changes);
        let keys = job.warnings.diagnostics.iter().map(|warning| &*warning.key);
        let own = keys.filter(|key| *key != "excitation.table_harmonics");
        assert!(
            own.clone().all(|key| key.starts_with("mesh.")),
            "{}",
            path.display()
        );
        warned += usize::from(own.count() > 0);
        // Without the change every key has an effect.
        assert!(load(&path, &[]).warnings.is_empty(), "{}", path.display());
    }
    assert!(warned >= 26, "{warned}");
}

/// Two numbers for one quantity are an error, because it is unknown which of them is meant.
#[test]
fn one_quantity_given_twice_is_an_error() {
    let quickstart = root().join("manifests/quickstart.toml");
    for (changes, key, other) in [
        (
            &["mesh.values=[4e8, 3e8]"][..],
            "mesh.mean_stiffness",
            "mesh.values",
        ),
        (
            &[
                "mesh.friction=0.05",
                "mesh.friction_law=schlenk",
                "mesh.roughness=0.5 um",
                "mesh.oil_viscosity=20 mPa*s",
            ],
            "mesh.friction",
            "mesh.friction_law",
        ),
        (
            &["mesh.half_gap=10 um", "mesh.normal_backlash=20 um"],
            "mesh.normal_backlash",
            "mesh.half_gap",
        ),
        (
            &[
                "analyses.multistability={ slice = { mode = 3, modes = [3, 4], extent = \"30 um\" } }",
            ],
            "analyses.multistability.slice.modes",
            "analyses.multistability.slice.mode",
        ),
    ] {
        let changes: Vec<String> = changes.iter().map(|change| (*change).to_owned()).collect();
        let errors = manifest::load_changed(&quickstart, &changes).unwrap_err();
        let fault = errors.errors().find(|fault| fault.key == key).unwrap();
        assert_eq!(fault.kind, DiagnosticKind::Inconsistent, "{errors}");
        assert!(fault.message.contains(&format!("`{other}`")), "{errors}");
        assert!(fault.remedy.is_some(), "{errors}");
    }
}

/// A key with an effect at some points of the grid is not reported.
#[test]
fn what_some_points_feel_is_not_warned_of() {
    let path = root().join("manifests/flex80-table.toml");
    let warned = |helix: &str| {
        let changes = [
            format!("grid.\"gear.helix_angle\"={helix}"),
            "mesh.face=independent".to_owned(),
        ];
        load(&path, &changes).warnings.diagnostics
    };
    assert!(warned("{ values = [0, \"10 deg\"] }").is_empty());
    let always = warned("{ values = [\"10 deg\", \"15 deg\"] }");
    assert_eq!(always.len(), 1, "{always:?}");
    assert_eq!((&*always[0].key, &always[0].at_point), ("mesh.face", &None));
}

fn oscillator_with_idle_keys() -> Place {
    Place::new(&OSCILLATOR.replace("stiffness = \"piecewise\"", "stiffness = \"constant\""))
}

/// `check`, `run` and `plan` print each warning once, on standard error; programs get it from `check --json`.
#[test]
fn warnings_are_told_once() {
    let place = oscillator_with_idle_keys();
    let once = |text: &str| {
        for key in ["contact_ratio", "single_pair_drop"] {
            let head = format!(
                "warning[no-effect]: `mesh.{key}` has no effect with stiffness = \"constant\""
            );
            assert_eq!(text.matches(&head).count(), 1, "{text}");
        }
        assert_eq!(text.matches("m.toml:1").count(), 2, "{text}");
        assert!(
            text.contains("remedy: remove it, or set stiffness = \"piecewise\""),
            "{text}"
        );
        assert_eq!(text.matches("m.toml: 2 warnings").count(), 1, "{text}");
    };
    let check = place.atlas(&["check", "m.toml"]);
    assert_eq!(status(&check), 0, "{}", stderr(&check));
    once(&stderr(&check));
    assert!(stdout(&check).contains("m.toml: valid"));
    assert!(
        !stdout(&check).contains("contact_ratio (line"),
        "{}",
        stdout(&check)
    );
    let run = place.run(
        "out",
        &["--set", "run.cycles=100", "--set", "run.audit_cycles=5"],
    );
    assert!([0, 3].contains(&status(&run)), "{}", stderr(&run));
    once(&stderr(&run));
    let plan = place.atlas(&["plan", "m.toml", "-j", "1"]);
    once(&stderr(&plan));
    let json = place.atlas(&["check", "m.toml", "--json"]);
    assert_eq!((status(&json), &*stderr(&json)), (0, ""));
    let told: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    let warnings = told["warnings"].as_array().unwrap();
    assert_eq!(warnings.len(), 2);
    assert_eq!(warnings[0]["key"], "mesh.contact_ratio");
    assert_eq!(
        (&warnings[0]["file"], &warnings[0]["kind"]),
        (&"m.toml".into(), &"no-effect".into())
    );
}

/// Warnings come after errors and are not counted with them.
#[test]
fn errors_come_before_warnings() {
    let place = oscillator_with_idle_keys();
    let check = place.atlas(&["check", "m.toml", "--set", "mesh.half_gap=-1"]);
    assert_eq!(status(&check), 2);
    let text = stderr(&check);
    let [error, warning] =
        ["error[out-of-range]", "warning[no-effect]"].map(|head| text.find(head));
    assert!(error.unwrap() < warning.unwrap(), "{text}");
    assert!(text.contains("1 error; nothing was computed"), "{text}");
}

/// Equal rows of a list are separate points, with separate results, also in shards, in `retry` and by name.
#[test]
fn equal_rows_are_points_of_their_own() {
    let (head, _) = OSCILLATOR.split_once("[grid]").unwrap();
    let grid = "[grid]\npoints = \"p.csv\"\n[run]\ntransient = 50\ncycles = 100\naudit_cycles = 5\n\
        [analyses]\nnvh = {}\nmultistability = { initial_conditions = 3, transient = 50, cycles = 320 }\n";
    let place = Place::new(&format!("{head}{grid}"));
    fs::write(
        place.path("p.csv"),
        "load,speed\n0.3,1050\n0.1,600\n0.3,1050\n",
    )
    .unwrap();
    let whole = place.whole("whole", &["-j", "2"]);
    for index in 1..=3 {
        place.whole("parts", &["--shard", &format!("{index}/3")]);
    }
    let merged = place.atlas(&["merge", "parts", "--out", "joined"]);
    assert_eq!(status(&merged), 0, "{}", stderr(&merged));
    let column = |folder: &Path, name: &str| {
        let points =
            gearatlas::store::ResultTable::read(folder, gearatlas::store::TableKind::Points)
                .unwrap();
        points.f64(name).unwrap()
    };
    for folder in [&whole, &place.path("parts"), &place.path("joined")] {
        let points =
            gearatlas::store::ResultTable::read(folder, gearatlas::store::TableKind::Points)
                .unwrap();
        assert_eq!(points.u64("point_id").unwrap(), [Some(0), Some(1), Some(2)]);
        assert_eq!(
            column(folder, "speed"),
            [Some(1050.0), Some(600.0), Some(1050.0)]
        );
        let rms = column(folder, "deflection_rms");
        // The motion starts from one state, so that it is equal bit for bit.
        assert_eq!(rms[0].unwrap().to_bits(), rms[2].unwrap().to_bits());
        assert_ne!(rms[0], rms[1]);
    }
    assert_eq!(
        column(&whole, "deflection_rms"),
        column(&place.path("parts"), "deflection_rms")
    );
    // Probes are random per point, so that each row has different ones.
    let probes =
        gearatlas::store::ResultTable::read(&whole, gearatlas::store::TableKind::Probes).unwrap();
    let ids = probes.u64("point_id").unwrap();
    assert_eq!(ids.iter().filter(|id| **id == Some(2)).count(), 3);
    for command in [
        &["plot", "whole"][..],
        &["report", "whole"],
        &["show", "whole"],
    ] {
        let output = place.atlas(command);
        assert_eq!(status(&output), 0, "{command:?}: {}", stderr(&output));
    }
    let trace = place.atlas(&[
        "trace", "m.toml", "--point", "load=0.3", "--cycles", "2", "--out", "t",
    ]);
    assert_eq!(status(&trace), 0, "{}", stderr(&trace));
    // Tied lists of values are also rows.
    let tied = format!(
        "{head}[grid]\ntied = [[\"load\", \"speed\"]]\nload = {{ values = [0.3, 0.1, 0.3] }}\nspeed = {{ values = [1050, 600, 1050] }}\n"
    );
    assert_eq!(
        Place::new(&tied).atlas(&["check", "m.toml"]).status.code(),
        Some(0)
    );
}
