//! Every manifest in `tests/manifests/bad` through the real program: the whole message is
//! a snapshot, the exit status is 2, standard output is empty and nothing is written.

#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn manifests() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/manifests")
}

/// Files below a folder with their content, sorted.
fn tree(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut files = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let content = std::fs::read(&path).unwrap();
                files.push((path, content));
            }
        }
    }
    files.sort();
    files
}

fn copy(from: &Path, to: &Path) {
    for (file, content) in tree(from) {
        let target = to.join(file.strip_prefix(from).unwrap());
        std::fs::create_dir_all(target.parent().unwrap()).unwrap();
        std::fs::write(target, content).unwrap();
    }
}

fn check(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_atlas"))
        .arg("check")
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

#[test]
fn every_bad_manifest_is_explained() {
    let folder = tempfile::tempdir().unwrap();
    copy(&manifests(), folder.path());
    let before = tree(folder.path());
    let bad = folder.path().join("bad");
    let mut names: Vec<String> = std::fs::read_dir(&bad)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.ends_with(".toml"))
        .collect();
    names.sort();
    assert!(names.len() >= 30, "only {} bad manifests", names.len());
    for name in &names {
        let output = check(&bad, &[name]);
        assert_eq!(output.status.code(), Some(2), "{name}");
        assert_eq!(String::from_utf8(output.stdout).unwrap(), "", "{name}");
        let message = String::from_utf8(output.stderr).unwrap();
        insta::assert_snapshot!(name.trim_end_matches(".toml"), message);
    }
    assert_eq!(tree(folder.path()), before, "a check has written something");
}

#[test]
fn programs_get_every_place_as_json() {
    let output = check(&manifests().join("bad"), &["--json", "wrong_unit.toml"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(output.stderr.is_empty());
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["valid"], false);
    let errors = json["errors"].as_array().unwrap();
    assert_eq!(errors.len(), 2);
    let first = &errors[0];
    assert_eq!(first["kind"], "wrong-unit");
    assert_eq!(first["file"], "wrong_unit.toml");
    assert_eq!(first["key"], "mesh.half_gap");
    assert_eq!((&first["line"], &first["column"]), (&9.into(), &12.into()));
    let text = std::fs::read_to_string(manifests().join("bad/wrong_unit.toml")).unwrap();
    let place = |key: &str| usize::try_from(first[key].as_u64().unwrap()).unwrap();
    assert_eq!(&text[place("start")..place("end")], "\"15 N\"");
}

#[test]
fn a_file_that_cannot_be_read_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let absent = check(folder.path(), &["absent.toml"]);
    assert_eq!(absent.status.code(), Some(2));
    let message = String::from_utf8(absent.stderr).unwrap();
    assert!(
        message.contains("the manifest `absent.toml` cannot be read"),
        "{message}"
    );
    assert!(message.contains("remedy:"), "{message}");
    std::fs::write(folder.path().join("latin1.toml"), b"name = \"\xe9\"").unwrap();
    let latin1 = check(folder.path(), &["latin1.toml"]);
    assert_eq!(latin1.status.code(), Some(2));
    let message = String::from_utf8(latin1.stderr).unwrap();
    assert!(
        message.contains("UTF-8") && !message.contains('µ'),
        "{message}"
    );
}

#[test]
fn a_sound_manifest_is_summarised() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("manifests");
    let output = check(&folder, &["flex80.toml"]);
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stderr.is_empty());
    insta::assert_snapshot!("sound_flex80", String::from_utf8(output.stdout).unwrap());
    let output = check(&folder, &["--json", "quickstart.toml"]);
    assert_eq!(output.status.code(), Some(0));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["points"], 12);
    assert_eq!(
        json["axes"][0]["values"],
        serde_json::json!([0.1, 0.2, 0.3])
    );
    assert_eq!(json["axes"][1]["unit"], "rad/s");
}

/// Messages about keys from a command are true, and so is their advice.
#[test]
fn what_is_said_of_changes_is_true() {
    let manifests = Path::new(env!("CARGO_MANIFEST_DIR")).join("manifests");
    let checked = |name: &str, set: &[&str]| {
        let set = set.iter().flat_map(|change| ["--set", *change]);
        check(
            &manifests,
            &[name].into_iter().chain(set).collect::<Vec<_>>(),
        )
    };
    let tie = "grid.tied=[[\"load\",\"mesh.half_gap\"]]";
    let gaps = "grid.\"mesh.half_gap\"={values=[1e-5,2e-5,3e-5]}";
    for (name, set, said) in [
        (
            "points.toml",
            &["mesh.half_gap=20 um"][..],
            &["it is a column of grid.points: set grid.points"][..],
        ),
        (
            "quickstart.toml",
            &[tie, gaps, "mesh.half_gap=20 um"],
            &["give the axis as many values, 3, as load, which is tied to it"],
        ),
        (
            "quickstart.toml",
            &["grid.\"mesh.half_gap\"=1e-5", "mesh.half_gap=20 um"],
            &["set the axis: --set 'grid.\"mesh.half_gap\"=VALUE'"],
        ),
        (
            "quickstart.toml",
            &["run.initial=rest", "run.initial.velocity=[0,0]"],
            &[
                "does not exist: `run.initial` is a text",
                "set `run.initial` as a whole",
            ],
        ),
        (
            "quickstart.toml",
            &["grid.\"gear.bore.1\"=20 mm"],
            &[
                "the axis `gear.bore.1` names an element that does not exist: `gear.bore` is not given",
            ],
        ),
        (
            "quickstart.toml",
            &["run.0=3"],
            &["does not exist: `run` is a table"],
        ),
        (
            "quickstart.toml",
            &["excitation.transmission_error.1.amplitude=0"],
            &["does not exist: `excitation.transmission_error` has 1 entry"],
        ),
        (
            "quickstart.toml",
            &["run.transient=2000000000"],
            &["a whole number from 0 to 1e9"],
        ),
        (
            "quickstart.toml",
            &["job.seed=9223372036854775807"],
            &["a whole number from 0 to 9.2e18"],
        ),
        (
            "trains/two-stage.toml",
            &["train.mesh.0.levels=[]"],
            &["`train.mesh.0.levels` is empty, so the contact has no stiffness"],
        ),
        (
            "points.toml",
            &["grid.tied=[[\"torque\",\"speed\"]]"],
            &["`torque` is a column of `grid.points`, which cannot be tied"],
        ),
        (
            "quickstart.toml",
            &[
                "grid.load=0.0001 * speed",
                "grid.tied=[[\"load\",\"speed\"]]",
            ],
            &[
                "`load` is an expression",
                "remove `load` from tied",
                ": 1 error;",
            ],
        ),
        (
            "quickstart.toml",
            &[
                "grid.load={from=0.1,to=\"0.3 N\",count=3}",
                "grid.refine={levels=2}",
            ],
            &["[wrong-unit]", ": 1 error;"],
        ),
        (
            "basins.toml",
            &["contact.stop.gap="],
            &["`contact.stop.gap` is not in the modal file"],
        ),
    ] {
        let output = checked(name, set);
        assert_eq!(output.status.code(), Some(2), "{set:?}");
        let message = String::from_utf8(output.stderr).unwrap();
        for part in said {
            assert!(message.contains(part), "{part}: {message}");
        }
    }
    // The remedies work, and an element of a list can be removed.
    for (name, set) in [
        ("quickstart.toml", &["excitation.transmission_error.0="][..]),
        ("quickstart.toml", &[tie, gaps]),
    ] {
        let output = checked(name, set);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{set:?}: {message}");
    }
}
