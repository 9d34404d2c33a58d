//! `--set KEY=VALUE`, a manifest from standard input, and `-j`, with the real program.

#![allow(clippy::unwrap_used)]

use crate::{place, results, skipped};
use place::{OSCILLATOR, Place, status, stderr, stdout};
use results::assert_same;
use serde_json::{Value, json};
use std::collections::BTreeSet;

const TABLES: [&str; 2] = ["points.parquet", "poincare.parquet"];

fn hash(place: &Place, arguments: &[&str]) -> Value {
    let output = place.atlas(&[&["check", "--json"], arguments].concat());
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    serde_json::from_slice::<Value>(&output.stdout).unwrap()["hash"].clone()
}

/// Setting a key equals writing it.
#[test]
fn a_set_key_is_as_if_written() {
    let place = Place::new(OSCILLATOR);
    let text = OSCILLATOR.replace("\"15 um\"", "\"12 um\"");
    let text = text.replace("load = { from = 0.05, to = 0.3, count = 2 }", "load = 0.2");
    let text = text.replace("amplitude = \"5 um\"", "amplitude = \"4 um\"");
    std::fs::write(place.path("written.toml"), text).unwrap();
    let set = [
        "--set",
        "mesh.half_gap=12 um",
        "--set",
        "grid.load = 0.2",
        "--set",
        "excitation.transmission_error.0.amplitude=\"4 um\"",
    ];
    let changed = hash(&place, &[&["m.toml"], &set[..]].concat());
    assert_eq!(changed, hash(&place, &["written.toml"]));
    assert_ne!(changed, hash(&place, &["m.toml"]));

    let ours = place.whole("ours", &[&set[..], &["-j", "2"]].concat());
    let output = place.atlas(&["run", "written.toml", "--out", "theirs", "--threads", "1"]);
    assert!([0, 3].contains(&status(&output)), "{}", stderr(&output));
    assert_same(&TABLES, &ours, &place.path("theirs"));
    let record = place.record("ours");
    assert_eq!(record["placement"]["threads"], 2);
    assert_eq!(record["manifest"], OSCILLATOR);
    assert_eq!(
        record["set"],
        json!([
            "mesh.half_gap=12 um",
            "grid.load = 0.2",
            "excitation.transmission_error.0.amplitude=\"4 um\""
        ])
    );
    assert_eq!(record["manifest_hash"], changed);
    assert!(place.record("theirs").get("set").is_none());

    // The same command finds its results; another one reports the difference.
    let again = place.run("ours", &set);
    assert!(
        stdout(&again).contains("already holds"),
        "{}",
        stdout(&again)
    );
    let without = place.run("ours", &set[..4]);
    assert_eq!(status(&without), 2);
    let told = stderr(&without);
    assert!(
        told.contains("- --set excitation.transmission_error.0.amplitude"),
        "{told}"
    );
}

/// Every command with a manifest accepts changes of it, and a manifest from a pipe.
#[test]
fn every_command_takes_changes_and_pipes() {
    let place = Place::new(OSCILLATOR);
    let commands = [
        "check -",
        "plan - -j 1",
        "run - --out piped -j 1 --quiet",
        "trace - --point load=0.1,speed=700 --cycles 3 --out traced",
        "sensitivity - --point load=0.1,speed=700 --by load -j 1",
    ];
    for command in commands {
        let script =
            format!("$ATLAS {command} --set run.cycles=320 --set run.transient=30 < m.toml");
        let output = place.shell(&script);
        assert!(
            [0, 3].contains(&status(&output)),
            "{command}: {}",
            stderr(&output)
        );
        let bad = place.shell(&format!("$ATLAS {command} --set run.cycles=few < m.toml"));
        assert_eq!(status(&bad), 2, "{command}");
        let told = stderr(&bad);
        assert!(told.contains("┌─ --set:1:12"), "{command}: {told}");
        assert!(
            told.contains("standard input: 1 error"),
            "{command}: {told}"
        );
    }
    let record = place.record("piped");
    assert_eq!(record["manifest"], OSCILLATOR);
    assert_eq!(record["set"], json!(["run.cycles=320", "run.transient=30"]));
}

/// Portable instructions need a variable at the start of the process; the error contains the command to type, quoted
/// for the shell.
#[test]
#[cfg(all(target_env = "gnu", target_arch = "x86_64"))]
fn a_portable_job_started_without_its_variable_says_what_to_type() {
    let place = Place::new(OSCILLATOR);
    let tail = "--set run.instructions=portable --set run.cycles=320 --set 'grid.speed=\"1000 rad/s\"' -j 1 --quiet";
    let refused = place.shell(&format!(
        "unset GLIBC_TUNABLES; $ATLAS check m.toml; $ATLAS run m.toml --out out {tail}"
    ));
    if [0, 3].contains(&status(&refused)) {
        skipped::skipped("no instructions here but those that every processor has");
        return;
    }
    assert_eq!(status(&refused), 2, "{}", stderr(&refused));
    assert!(!place.path("out").exists());
    let told = stderr(&refused);
    let typed = told.lines().last().unwrap().trim();
    assert!(
        typed.starts_with("GLIBC_TUNABLES=glibc.cpu.hwcaps=-FMA"),
        "{told}"
    );
    let output = place.shell(typed);
    assert!([0, 3].contains(&status(&output)), "{}", stderr(&output));
    assert_eq!(
        place.record("out")["machine"]["instructions"],
        json!(["portable"])
    );
}

/// A key that is incompatible with a set one is removed.
#[test]
fn keys_are_taken_out() {
    let place = Place::new(OSCILLATOR);
    let exact = ["check", "m.toml", "--set", "run.kernel=volterra"];
    let steps = "--set=run.steps=64";
    let told = stderr(&place.atlas(&[&exact[..], &[steps]].concat()));
    assert!(told.contains("no effect"), "{told}");
    let output = place.atlas(&[&exact[..], &[steps, "--set", "run.steps="]].concat());
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let output = place.atlas(&["check", "m.toml", "--set", "run.steps="]);
    assert_eq!(status(&output), 2);
    assert!(
        stderr(&output).contains("nothing to remove"),
        "{}",
        stderr(&output)
    );
}

/// The table of a mesh is built with the set keys, also from a pipe.
#[test]
fn tables_are_built_of_what_was_set() {
    let place = Place::new(include_str!("../../manifests/flex80-table.toml"));
    let files = |arguments: &str| -> Vec<String> {
        let script = format!("$ATLAS table {arguments} --tables kept --json");
        let output = place.shell(&script);
        assert_eq!(status(&output), 0, "{arguments}: {}", stderr(&output));
        let told: Value = serde_json::from_slice(&output.stdout).unwrap();
        let files = told.as_array().unwrap().iter();
        files
            .map(|own| own["file"].as_str().unwrap().to_owned())
            .collect()
    };
    let wide = "--set gear.face_width=\"21 mm\"";
    let set = files(&format!("m.toml {wide}"));
    assert!(!set.is_empty());
    assert_eq!(set, files(&format!("- {wide} < m.toml")));
    assert_ne!(set, files("- < m.toml"));
    // Tables for torques other than the points' have the laws of the manifest.
    let tables = ["coupled", "independent"].map(|face| {
        ["load_dependent", "linear"].map(|contact| {
            let laws = format!("--set mesh.face={face} --set mesh.contact={contact}");
            files(&format!("m.toml {laws} --torque \"40 N m\""))
        })
    });
    let different: BTreeSet<_> = tables.as_flattened().iter().collect();
    assert_eq!(different.len(), 4, "{tables:?}");
}

#[test]
fn faults_of_changes_point_to_them() {
    let place = Place::new(OSCILLATOR);
    for (change, spot, words) in [
        ("mesh.half_gap=15 N", "1:15", "a unit of force"),
        ("mesh.half_gpa=15 um", "1:15", "nearest: `half_gap`"),
        ("mesh.half_gap", "1:1", "not of the form KEY=VALUE"),
        ("grid.load={ values = [0.1", "1:26", "not valid TOML"),
        (
            "excitation.transmission_error.4.amplitude=1",
            "1:1",
            "`excitation.transmission_error` has 1 entry",
        ),
        ("run.kernel=magic", "1:12", "cannot be \"magic\""),
        ("mesh.half_gap=1e-5\nx=1", "1:1", "several keys"),
    ] {
        let output = place.atlas(&["check", "m.toml", "--set", change]);
        assert_eq!(status(&output), 2, "{change}");
        let told = stderr(&output);
        assert!(told.contains(&format!("--set:{spot}")), "{change}: {told}");
        assert!(told.contains(words), "{change}: {told}");
    }
    // An axis of the grid is set as an axis.
    let axis = "grid.\"mesh.half_gap\"={ values = [1e-5, 2e-5] }";
    let output = place.atlas(&["check", "m.toml", "--set", axis]);
    assert!(
        stdout(&output).contains("12 = 2 mesh.half_gap x 2 load x 3 speed"),
        "{}",
        stdout(&output)
    );
    let both = [
        "check",
        "m.toml",
        "--set",
        axis,
        "--set",
        "mesh.half_gap=1e-5",
    ];
    let output = place.atlas(&both);
    assert_eq!(status(&output), 2);
    assert!(
        stderr(&output).contains("the grid varies it"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn a_stream_that_is_no_manifest_is_refused() {
    let place = Place::new(OSCILLATOR);
    let output = place.shell("printf '\\377' | $ATLAS check -");
    assert_eq!(status(&output), 2);
    assert!(stderr(&output).contains("not UTF-8"), "{}", stderr(&output));
    let output = place.shell("head -c 20000000 /dev/zero | $ATLAS check -");
    assert_eq!(status(&output), 2);
    assert!(
        stderr(&output).contains("more than 16 MiB"),
        "{}",
        stderr(&output)
    );
}
