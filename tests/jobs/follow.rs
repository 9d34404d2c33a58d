//! `atlas follow` and `atlas sensitivity` as a user runs them.

#![allow(clippy::unwrap_used)]

use crate::program::said;
use std::path::Path;
use std::process::{Command, Output};

/// The rigid pair of the tiers, over an interval of speed and load.
fn manifest(grid: &str, continuation: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("manifests/tiers/torsional.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let (head, rest) = text.split_once("[grid]").unwrap();
    let (_, tail) = rest.split_once("[run]").unwrap();
    format!("{head}[grid]\n{grid}\n[run]{tail}\n{continuation}")
}

const GRID: &str =
    "load = { values = [0.2, 0.4] }\nspeed = { from = 1000, to = 2200, count = 2 }\n";

const FOLLOWED: &str = "[continuation]\nover = \"speed\"\nsecond = \"load\"\nstarts = 2\nlongest_period = 2\ntransient = 200\ncycles = 100\n";

fn atlas(folder: &Path, text: &str, arguments: &[&str]) -> Output {
    std::fs::write(folder.join("m.toml"), text).unwrap();
    Command::new(env!("CARGO_BIN_EXE_atlas"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap()
}

fn refused(text: &str, arguments: &[&str], parts: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let output = atlas(folder.path(), text, arguments);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{said}");
    for part in parts {
        assert!(said.contains(part), "{part}: {said}");
    }
}

#[test]
fn tables_are_the_same_for_any_number_of_threads() {
    let text = manifest(GRID, FOLLOWED);
    let folder = tempfile::tempdir().unwrap();
    let mut written = Vec::new();
    for threads in ["1", "2"] {
        let out = format!("out-{threads}");
        let output = atlas(
            folder.path(),
            &text,
            &[
                "follow",
                "m.toml",
                "--threads",
                threads,
                "--out",
                &out,
                "--json",
            ],
        );
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{said}");
        let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert!(summary["branches"].as_u64().unwrap() >= 2, "{summary}");
        assert!(summary["orbits"].as_u64().unwrap() > 100, "{summary}");
        assert!(summary["curves"]["onset"].as_u64() == Some(1), "{summary}");
        let tables = ["branches", "bifurcations", "curves"];
        written.push(tables.map(|name| {
            std::fs::read(folder.path().join(&out).join(format!("{name}.parquet"))).unwrap()
        }));
    }
    assert!(written[0] == written[1], "other bytes with two threads");
}

/// A point of a manifest whose orbits can be followed is computed by `--set` of its axis.
#[test]
fn one_point_of_an_interval_is_a_valid_job() {
    let folder = tempfile::tempdir().unwrap();
    let text = manifest(GRID, "[continuation]\nover = \"speed\"\n");
    std::fs::write(folder.path().join("m.toml"), text).unwrap();
    let checked = said(
        folder.path(),
        &["check", "m.toml", "--set", "grid.speed=1500"],
    );
    assert!(checked.contains("valid"), "{checked}");
}

#[test]
fn what_cannot_be_followed_is_said_with_its_remedy() {
    let follow = ["follow", "m.toml"];
    refused(&manifest(GRID, ""), &follow, &["[continuation]", "over ="]);
    refused(
        &manifest(
            "load = 0.2\nspeed = 1500\n",
            "[continuation]\nover = \"speed\"\n",
        ),
        &follow,
        &[
            "its axis `speed` has one value",
            "or its axis has one value",
        ],
    );
    refused(
        &manifest(
            &format!("{GRID}\"gear.teeth.0\" = {{ values = [20, 21] }}\n"),
            "[continuation]\nover = \"gear.teeth.0\"\n",
        ),
        &follow,
        &["is not continuous", "gear.teeth.0"],
    );
    refused(
        &manifest(GRID, "[continuation]\nover = \"sped\"\n"),
        &follow,
        &["no axis `sped`", "\"speed\""],
    );
    refused(
        &manifest(
            GRID,
            "[continuation]\nover = \"speed\"\nsecond = \"speed\"\n",
        ),
        &follow,
        &[
            "second = \"speed\"",
            "already the axis along which orbits are followed",
        ],
    );
    refused(
        &manifest(
            GRID,
            "[continuation]\nover = \"speed\"\nstates = [{ at = 1500, displacement = [0.0], velocity = [0.0] }]\n",
        ),
        &follow,
        &["continuation.states.0", "retained modes"],
    );
}

#[test]
fn a_given_state_next_to_no_orbit_is_reported() {
    let far = "[continuation]\nover = \"speed\"\nstarts = 1\nlongest_period = 1\ntransient = 10\ncycles = 10\n\
               states = [{ at = 1500, period = 1, displacement = [0.0, 1.0], velocity = [0.0, 900.0] }]\n";
    let folder = tempfile::tempdir().unwrap();
    let text = manifest(
        "load = 0.2\nspeed = { from = 1400, to = 1600, count = 2 }\n",
        far,
    );
    let output = atlas(folder.path(), &text, &["follow", "m.toml"]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(
        said.contains("no orbit of period 1 is near given state 0"),
        "{said}"
    );
}

#[test]
fn sensitivities_of_an_orbit_agree_with_differences() {
    let folder = tempfile::tempdir().unwrap();
    let text = manifest("load = 0.4\nspeed = 2200\n", "");
    let output = atlas(
        folder.path(),
        &text,
        &[
            "sensitivity",
            "m.toml",
            "--json",
            "--by",
            "load,speed,mesh.half_gap,mesh.mean_stiffness",
        ],
    );
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{said}");
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let rows = found["sensitivities"].as_array().unwrap();
    assert_eq!(rows.len(), 4 * 8, "{found}");
    for row in rows.iter().filter(|row| row["method"] == "orbit") {
        let (by, check) = (
            row["derivative"].as_f64().unwrap(),
            row["check"].as_f64().unwrap(),
        );
        let scale = row["value"].as_f64().unwrap().abs() / row["at"].as_f64().unwrap();
        assert!(
            (by - check).abs() <= 1e-4 * by.abs().max(1e-2 * scale),
            "{row}"
        );
    }
    refused(
        &text,
        &["sensitivity", "m.toml", "--by", "mesh.half_gp"],
        &["mesh.half_gp", "did you mean `mesh.half_gap`"],
    );
    refused(
        &text,
        &["sensitivity", "m.toml", "--by", "mesh.segments"],
        &["not continuous"],
    );
}

/// The largest force is at the end of the two-pair contact, which moves with the contact ratio. A quantity at round-off
/// has no derivative.
#[test]
fn a_peak_moves_with_the_breakpoint_that_ends_it() {
    let folder = tempfile::tempdir().unwrap();
    let text = manifest("load = 6\nspeed = 700\n", "");
    let rows = |settings: &[&str]| {
        let mut arguments = vec![
            "sensitivity",
            "m.toml",
            "--json",
            "--by",
            "mesh.contact_ratio,load",
        ];
        let set = ["mesh.segments=", "mesh.friction=0"];
        for setting in set.iter().chain(settings) {
            arguments.extend(["--set", setting]);
        }
        let output = atlas(folder.path(), &text, &arguments);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{said}");
        let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        found["sensitivities"].as_array().unwrap().clone()
    };
    let moving = rows(&[
        "mesh.stiffness=continuous",
        "mesh.contact_ratio=1.62",
        "excitation.transmission_error=[{harmonic=1,amplitude='2 um',phase=3.5}]",
    ]);
    let peaks: Vec<_> = (moving.iter())
        .filter(|row| row["quantity"] == "force_peak")
        .collect();
    assert_eq!(peaks.len(), 2);
    for row in peaks {
        let [by, check] = ["derivative", "check"].map(|name| row[name].as_f64().unwrap());
        assert!((by / check - 1.0).abs() < 1e-6, "{row}");
        assert_eq!(row["note"], "", "{row}");
    }
}

/// Without mesh motion the RMS and harmonics of the deflection are round-off, and round-off has no derivative.
#[test]
fn what_is_zero_has_no_derivative() {
    let folder = tempfile::tempdir().unwrap();
    let text = manifest("load = 1\nspeed = 2000\n", "");
    let mut arguments = vec!["sensitivity", "m.toml", "--json", "--by", "load"];
    for setting in [
        "mesh.stiffness=constant",
        "mesh.segments=",
        "mesh.contact_ratio=",
        "mesh.single_pair_drop=",
        "mesh.friction=0",
        "excitation.transmission_error=[]",
    ] {
        arguments.extend(["--set", setting]);
    }
    let output = atlas(folder.path(), &text, &arguments);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{said}");
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    for row in found["sensitivities"].as_array().unwrap() {
        let is_size = ["deflection_rms", "deflection_harmonic_1"]
            .iter()
            .any(|name| row["quantity"] == *name);
        assert_eq!(
            row["derivative"].is_null(),
            is_size || row["quantity"].as_str().unwrap().contains("harmonic"),
            "{row}"
        );
        assert_eq!(
            row["note"].as_str().unwrap().contains("kink"),
            row["derivative"].is_null(),
            "{row}"
        );
    }
}

/// Set keys and a manifest from a pipe are followed as if written in a manifest; pictures have the axis in its unit.
#[test]
fn changed_manifests_are_followed_and_shown_in_their_units() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let text = manifest(
        GRID,
        "[continuation]\nover = \"speed\"\nstarts = 2\nlongest_period = 2\ntransient = 200\ncycles = 100\n",
    );
    let grid =
        r#"grid={ load = 0.4, speed = { from = "10000 rpm", to = "21000 rpm", count = 2 } }"#;
    let follow = ["follow", "m.toml", "--set", grid, "--quiet", "--out"];
    let set = atlas(path, &text, &[&follow[..], &["set"]].concat());
    assert_eq!(set.status.code(), Some(0), "{set:?}");
    let own = "load = 0.4\nspeed = { from = \"10000 rpm\", to = \"21000 rpm\", count = 2 }\n";
    std::fs::write(path.join("own.toml"), text.replace(GRID, own)).unwrap();
    let piped = Command::new(env!("CARGO_BIN_EXE_atlas"))
        .current_dir(path)
        .args(["follow", "-", "--quiet", "--out", "piped"])
        .stdin(std::fs::File::open(path.join("own.toml")).unwrap())
        .output()
        .unwrap();
    assert_eq!(piped.status.code(), Some(0), "{piped:?}");
    let [one, two] =
        ["set", "piped"].map(|out| std::fs::read(path.join(out).join("branches.parquet")).unwrap());
    assert!(one == two, "what is set is not what is written");
    let plain = atlas(
        path,
        &text,
        &["follow", "m.toml", "--quiet", "--out", "plain"],
    );
    assert_eq!(plain.status.code(), Some(0), "{plain:?}");
    for (out, unit, label) in [
        ("set", None, "speed [rpm]"),
        ("plain", None, "speed [rad/s]"),
        ("plain", Some("rpm"), "speed [rpm]"),
    ] {
        let unit = unit.iter().flat_map(|unit| ["--unit", *unit]);
        let plot = [
            "plot", out, "--what", "branches", "--quiet", "--format", "svg",
        ];
        let plot: Vec<&str> = plot.into_iter().chain(unit).collect();
        let drawn = atlas(path, &text, &plot);
        assert_eq!(drawn.status.code(), Some(0), "{drawn:?}");
        let pictures = std::fs::read_dir(path.join(out).join("pictures")).unwrap();
        for picture in pictures {
            let picture = std::fs::read_to_string(picture.unwrap().path()).unwrap();
            assert!(picture.contains(label), "{out}: {label}");
        }
    }
}
