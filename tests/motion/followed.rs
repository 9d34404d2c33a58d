//! Followed orbits through the real program: their pictures, their summary, and the changes of a sweep that they
//! explain. Stores `target/tmp/followed/` for `tests/python/test_readers.py`.

#![allow(clippy::unwrap_used)]

use crate::program;
use program::{atlas, said};
use std::fs;
use std::path::Path;

use gearatlas::store::{ResultTable, TableKind};
use serde_json::Value;

/// A one-degree oscillator in a gap: orbits are followed in less than a second.
const STRUCTURE: &str = include_str!("../manifests/oscillator.modal.toml");

const HEAD: &str = concat!(
    include_str!("../manifests/oscillator.head.toml"),
    r#"
transient = 300
[analyses]
lyapunov = { exponents = 1, effort = "survey" }
nvh = { harmonics = 3 }
poincare = { samples = 20 }
[grid]
speed = { from = 600, to = 1500, count = 10 }
"#
);

const TWO_LOADS: &str = "load = { values = [0.05, 0.1] }";

const PLANE: &str = r#"
[continuation]
over = "speed"
second = "load"
starts = 3
longest_period = 2
"#;

const LINE: &str = r#"
[continuation]
over = "speed"
starts = 5
longest_period = 4
"#;

fn write(folder: &Path, name: &str, parts: &[&str]) {
    fs::write(folder.join(name), [&[HEAD], parts].concat().join("\n")).unwrap();
    fs::write(folder.join("oscillator.modal.toml"), STRUCTURE).unwrap();
}

/// Names of the pictures drawn into `out`.
fn pictures(folder: &Path, arguments: &[&str]) -> Vec<String> {
    let fixed = ["plot", "r", "--json", "--format", "svg", "--out", "out"];
    let json: Value = serde_json::from_str(&said(folder, &[&fixed, arguments].concat())).unwrap();
    let files = json["files"].as_array().unwrap().iter();
    let names = files.map(|path| path.as_str().unwrap().strip_prefix("out/").unwrap());
    names.map(str::to_owned).collect()
}

/// Texts of a picture, which must be well-formed.
fn labels(folder: &Path, name: &str) -> Vec<String> {
    let source = fs::read_to_string(folder.join("out").join(name)).unwrap();
    let document = roxmltree::Document::parse(&source).unwrap();
    let texts = document.descendants().filter(|n| n.has_tag_name("text"));
    texts
        .map(|node| node.text().unwrap().trim().to_owned())
        .collect()
}

#[track_caller]
fn holds(labels: &[String], wanted: &[&str]) {
    for wanted in wanted {
        let found = labels.iter().any(|label| label.contains(wanted));
        assert!(found, "`{wanted}` is not among {labels:?}");
    }
}

fn summary(folder: &Path) -> Value {
    serde_json::from_str(&said(folder, &["show", "r", "--json"])).unwrap()
}

/// Compares counts from every table with `show`.
fn assert_counts(folder: &Path, followed: &Value) {
    let table = |kind| ResultTable::read(&folder.join("r"), kind).unwrap();
    let branches = table(TableKind::Branches);
    assert_eq!(followed["orbits"], branches.rows());
    let stable = branches.bool("stable").unwrap();
    let stable = stable.iter().filter(|own| **own == Some(true)).count();
    assert_eq!(followed["stable_orbits"], stable);
    let kinds = table(TableKind::Bifurcations).text("kind").unwrap();
    let sum = |key: &str| -> u64 {
        let counts = followed[key].as_object().unwrap().values();
        counts.map(|count| count.as_u64().unwrap()).sum()
    };
    let ends = kinds.iter().filter(|own| own.as_deref() == Some("end"));
    assert_eq!(sum("bifurcations"), (kinds.len() - ends.count()) as u64);
    let numbers = branches.u64("branch").unwrap();
    let last = numbers.iter().flatten().max().unwrap();
    assert_eq!(followed["branches"], last + 1);
}

#[test]
fn orbits_alone_are_shown_and_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "m.toml", &[TWO_LOADS, PLANE]);
    said(folder, &["follow", "m.toml", "--out", "r", "--quiet"]);
    let names = pictures(folder, &[]);
    let wanted = [
        "branches-load=0.05.svg",
        "branches-load=0.1.svg",
        "curves.svg",
    ];
    assert_eq!(names, wanted);
    let branches = labels(folder, "branches-load=0.1.svg");
    holds(
        &branches,
        &[
            "case: periodic orbits over speed",
            "load 0.1",
            "speed [rad/s]",
        ],
    );
    holds(
        &branches,
        &[
            "RMS of the deflection [µm]",
            "stable",
            "unstable",
            "period 2",
        ],
    );
    holds(&branches, &["period doubling (", "fold ("]);
    let grey = branches.iter().any(|label| label == "points of the grid");
    assert!(!grey, "no points here: {branches:?}");
    let curves = labels(folder, "curves.svg");
    holds(
        &curves,
        &["case: bifurcations over speed and load", "load [–]"],
    );
    holds(&curves, &["onset of rattle", "fold (", "period doubling ("]);

    let json = summary(folder);
    assert_eq!((&json["job"], &json["points"]), (&"case".into(), &0.into()));
    let followed = &json["followed"];
    assert_eq!(followed["over"], "speed");
    assert_eq!(followed["second"], "load");
    assert_eq!(followed["lines"], 2);
    assert_eq!(followed["range"], serde_json::json!([600.0, 1500.0]));
    assert_eq!(followed["curves"]["onset"], 1);
    assert_counts(folder, followed);
    let text = said(folder, &["show", "r"]);
    assert!(
        text.starts_with("case  (r)\n\norbits followed over speed, 600 … 1500 rad/s, 2 lines\n")
    );
    assert!(
        text.contains("onset") && !text.contains("point was computed"),
        "{text}"
    );

    // Store the results for the tests of the Python readers.
    let sample = Path::new(env!("CARGO_TARGET_TMPDIR")).join("followed");
    fs::create_dir_all(&sample).unwrap();
    for entry in fs::read_dir(folder.join("r")).unwrap().map(Result::unwrap) {
        if entry.path().is_file() {
            fs::copy(entry.path(), sample.join(entry.file_name())).unwrap();
        }
    }

    // Curves of a plane that is no longer requested are removed.
    write(
        folder,
        "m.toml",
        &[TWO_LOADS, &PLANE.replace("second = \"load\"", "")],
    );
    said(folder, &["follow", "m.toml", "--out", "r", "--quiet"]);
    assert!(!folder.join("r/curves.parquet").exists());
    assert_eq!(pictures(folder, &[]), &wanted[..2]);
    let refused = atlas(folder, &["plot", "r", "--what", "curves"]);
    assert_eq!(refused.status.code(), Some(2));
    let errors = String::from_utf8(refused.stderr).unwrap();
    assert!(
        errors.contains("`second` axis in [continuation] of the manifest"),
        "{errors}"
    );
    assert!(errors.contains("available here: branches\n"), "{errors}");
}

#[test]
fn points_of_a_sweep_lie_behind_the_branches() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let sweep = "order = \"both\"\nalong = \"speed\"";
    write(folder, "sweep.toml", &["load = 0.1", sweep]);
    let text = fs::read_to_string(folder.join("sweep.toml")).unwrap();
    let text = text.replace("samples = 20", "samples = 20, refine = 6");
    fs::write(folder.join("sweep.toml"), text).unwrap();
    said(folder, &["run", "sweep.toml", "--out", "r", "--quiet"]);
    write(folder, "m.toml", &["load = 0.1", LINE]);
    said(folder, &["follow", "m.toml", "--out", "r", "--quiet"]);

    let json = summary(folder);
    assert_eq!(json["state"], "complete");
    assert!(!json["transitions"].as_array().unwrap().is_empty());
    assert!(json["followed"]["bifurcations"].is_object());
    let names = pictures(folder, &["--what", "branches"]);
    assert_eq!(names, ["branches.svg"]);
    holds(
        &labels(folder, "branches.svg"),
        &["points of the grid", "load 0.1"],
    );
}

#[test]
fn curves_lie_over_the_map_of_points_with_both_axes() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "m.toml", &[TWO_LOADS, PLANE]);
    said(folder, &["run", "m.toml", "--out", "r", "--quiet"]);
    said(folder, &["follow", "m.toml", "--out", "r", "--quiet"]);
    assert_eq!(pictures(folder, &["--what", "curves"]), ["curves.svg"]);
    let labels = labels(folder, "curves.svg");
    holds(
        &labels,
        &[
            "behind: 20 points",
            "λ of chaotic points",
            "onset of rattle",
        ],
    );
    let source = fs::read_to_string(folder.join("out/curves.svg")).unwrap();
    let rectangles = source.matches("<rect").count();
    assert!(rectangles > 20, "{rectangles}");
}

#[test]
fn an_empty_folder_is_told_what_can_be_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let message = atlas(folder.path(), &["plot", "."]);
    assert_eq!(message.status.code(), Some(2));
    let errors = String::from_utf8(message.stderr).unwrap();
    assert!(
        errors.contains("branches.parquet (from `atlas follow`)"),
        "{errors}"
    );
}
