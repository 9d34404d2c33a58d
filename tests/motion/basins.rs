//! Slices through the program: the same bytes for any number of threads, the same branches
//! for any split, and pictures of both.

#![allow(clippy::unwrap_used)]

use crate::program;
use gearatlas::report::{Summary, render_branches};
use gearatlas::store::{ResultTable, TableKind};
use program::{atlas, said};
use std::path::Path;

const STRUCTURE: &str = include_str!("../../manifests/basins.modal.toml");
const MANIFEST: &str = include_str!("../../manifests/basins.toml");

/// The manifest of the documentation with fewer points and cells.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let small = MANIFEST
        .replace("count = 96", "count = 10")
        .replace("count = 7", "count = 4")
        .replace("initial_conditions = 32", "initial_conditions = 8");
    assert_eq!(small.matches("count = ").count(), 2);
    std::fs::write(folder.path().join("basins.modal.toml"), STRUCTURE).unwrap();
    std::fs::write(folder.path().join("m.toml"), small).unwrap();
    folder
}

fn run(folder: &Path, out: &str, more: &[&str]) {
    let mut arguments = vec!["run", "m.toml", "--out", out, "--quiet"];
    arguments.extend(more);
    said(folder, &arguments);
}

#[test]
fn slices_do_not_depend_on_threads_or_shards() {
    let folder = folder();
    let path = folder.path();
    let checked = said(path, &["check", "m.toml"]);
    assert!(
        checked.contains("a slice of 10 x 10 along modes 1 and 2"),
        "{checked}"
    );
    run(path, "1", &["--threads", "1"]);
    run(path, "3", &["--threads", "3"]);
    for table in ["probes.parquet", "attractors.parquet", "basins.parquet"] {
        let bytes = |out: &str| std::fs::read(path.join(out).join(table)).unwrap();
        assert!(bytes("1") == bytes("3"), "{table} depends on the threads");
    }
    for shard in ["1/3", "2/3", "3/3"] {
        run(path, "split", &["--shard", shard, "--threads", "2"]);
    }
    let summary = |out: &str| Summary::read(&path.join(out)).unwrap();
    let [whole, split] = [summary("1"), summary("split")];
    assert_eq!(render_branches(&whole), render_branches(&split));
    assert!(
        whole.attractors.len() > whole.points,
        "{}",
        whole.attractors.len()
    );
    // There are fewer branches than attractors, because attractors are matched between points.
    let branches = whole.branches.iter().max().unwrap() + 1;
    assert!(
        branches < whole.attractors.len() / 2,
        "{:?}",
        whole.branches
    );
    assert_eq!(
        said(path, &["show", "1", "--branches"]),
        render_branches(&whole)
    );

    // Every cell occurs once, and the counts of attractors.parquet are those of its cells.
    let table = ResultTable::read(&path.join("1"), TableKind::Basins).unwrap();
    assert_eq!(table.rows(), 4 * 100);
    let (ids, on) = (
        table.u64("point_id").unwrap(),
        table.u64("attractor_id").unwrap(),
    );
    for attractor in &whole.attractors {
        let own = (Some(attractor.point_id), Some(attractor.attractor_id));
        let cells = ids.iter().zip(&on).filter(|(id, on)| (**id, **on) == own);
        assert_eq!(attractor.cells, Some(cells.count() as u64));
    }
}

#[test]
fn slices_and_shares_are_drawn() {
    let folder = folder();
    let path = folder.path();
    run(path, "r", &[]);
    let files = said(
        path,
        &["plot", "r", "--what", "shares,basins", "--format", "svg"],
    );
    let names: Vec<&str> = files
        .lines()
        .filter_map(|line| line.rsplit('/').next())
        .collect();
    assert_eq!(names.len(), 5, "{files}");
    assert!(names.contains(&"shares.svg") && names.contains(&"basins-point=2.svg"));
    let read = |name: &str| std::fs::read_to_string(path.join("r/pictures").join(name)).unwrap();
    let slice = read("basins-point=2.svg");
    for label in [
        "mesh deflection by mode 1 [µm]",
        "attractor 0: period 1",
        "% of cells",
    ] {
        assert!(slice.contains(label), "{label}");
    }
    let shares = read("shares.svg");
    for label in ["share of probes", "speed [rad/s]", "95 % interval", "RMS"] {
        assert!(shares.contains(label), "{label}");
    }
    // Draw one point alone.
    let one = said(
        path,
        &[
            "plot", "r", "--what", "basins", "--point", "1", "--format", "svg",
        ],
    );
    assert_eq!(one.lines().count(), 1, "{one}");
}

/// Modes without mesh participation are known only with the structure, so every point reports the error in its results.
#[test]
fn a_slice_along_a_mode_that_is_not_felt_is_explained() {
    let folder = folder();
    let path = folder.path();
    let unfelt = STRUCTURE.replace("[1.0, 0.5]          # 1/sqrt(kg)", "[1.0, 0.0]");
    assert_ne!(unfelt, STRUCTURE);
    std::fs::write(path.join("basins.modal.toml"), unfelt).unwrap();
    let output = atlas(path, &["run", "m.toml", "--out", "r", "--quiet"]);
    assert_eq!(output.status.code(), Some(3));
    let points = ResultTable::read(&path.join("r"), TableKind::Points).unwrap();
    for reason in points.text("reason").unwrap() {
        let reason = reason.unwrap();
        assert!(
            reason.contains("mode 2 is not possible, because this mode does not deflect the mesh"),
            "{reason}"
        );
    }
}

/// The phase plane of an oscillator of one degree: x on the horizontal axis in metres, v on the vertical one in metres
/// per second, and the same bytes for any number of threads.
#[test]
fn the_phase_plane_of_one_mode_has_its_own_units() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let structure = "teeth = 20\nrated_force = 1330.0\nfrequency = [0.0]\ndamping = [0.0]\n\
                     mesh = [1.0]\ntorque = [1.0]\n";
    std::fs::write(path.join("one.modal.toml"), structure).unwrap();
    let manifest = r#"
        [job]
        name = "one"
        [model]
        kind = "modal"
        file = "one.modal.toml"
        [mesh]
        half_gap = "10 um"
        stiffness = "constant"
        mean_stiffness = "4e8 N/m"
        contact_damping = "1483 N*s/m"
        [excitation]
        transmission_error = [{ harmonic = 1, amplitude = "2 um" }]
        [grid]
        load = 0.5
        speed = 880
        [run]
        transient = 300
        cycles = 800
        [analyses]
        lyapunov = {}
        multistability = { initial_conditions = 4, slice = { mode = 1, extent = "30 um", speed = "0.4 m/s", count = 12 } }
    "#;
    std::fs::write(path.join("m.toml"), manifest).unwrap();
    let checked = said(path, &["check", "m.toml"]);
    let told = "a slice of 12 x 12 in the phase plane of mode 1";
    assert!(checked.contains(told), "{checked}");
    run(path, "1", &["--threads", "1"]);
    run(path, "2", &["--threads", "2"]);
    let bytes = |out: &str| std::fs::read(path.join(out).join("basins.parquet")).unwrap();
    assert!(bytes("1") == bytes("2"));
    let cells = ResultTable::read(&path.join("1"), TableKind::Basins).unwrap();
    let [x, y] = ["x", "y"].map(|name| cells.f64(name).unwrap());
    let largest = |values: &[Option<f64>]| values.iter().flatten().fold(0.0, |a: f64, b| a.max(*b));
    assert!((largest(&x) / (30e-6 * 11.0 / 12.0) - 1.0).abs() < 1e-12);
    assert!((largest(&y) / (0.4 * 11.0 / 12.0) - 1.0).abs() < 1e-12);
    let mut ends = cells.u64("attractor_id").unwrap();
    ends.sort();
    ends.dedup();
    assert_eq!(ends, [Some(0), Some(1)]);
    said(path, &["plot", "1", "--what", "basins", "--format", "svg"]);
    let picture = std::fs::read_to_string(path.join("1/pictures/basins.svg")).unwrap();
    for label in [
        "mesh deflection by mode 1 [",
        "rate of mesh deflection by mode 1 [",
    ] {
        assert!(picture.contains(label), "{label}");
    }
}
