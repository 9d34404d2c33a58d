//! `atlas export` through the real program: files and refusals. tests/python/test_export.py tests how other programs
//! read its files; it exports the folder stored here.

#![allow(clippy::unwrap_used)]

use crate::program;
use program::{atlas, said};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::sync::LazyLock;

/// Folder of the stored results.
const WRITTEN: &str = concat!(env!("CARGO_TARGET_TMPDIR"), "/exported");

/// A trace of the quickstart drive with modal states, made once.
static TRACE: LazyLock<PathBuf> = LazyLock::new(|| {
    _ = fs::remove_dir_all(WRITTEN);
    fs::create_dir_all(WRITTEN).unwrap();
    fs::write(
        Path::new(WRITTEN).join("atlas"),
        env!("CARGO_BIN_EXE_atlas"),
    )
    .unwrap();
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/manifests/quickstart.toml");
    let point = [
        "--point",
        "load=0.05,speed=1200",
        "--cycles",
        "40",
        "--skip",
        "50",
    ];
    let trace = ["trace", manifest, "--modal", "--out", "trace"];
    said(WRITTEN, &[&trace, &point[..]].concat());
    Path::new(WRITTEN).join("trace")
});

fn export(arguments: &[&str]) -> Output {
    let folder = TRACE.to_str().unwrap();
    atlas(WRITTEN, &[&["export", folder], arguments].concat())
}

/// The one-line message of a call that fails with status 2.
fn refusal(arguments: &[&str]) -> String {
    let output = export(arguments);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(output.stdout.is_empty());
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(said.lines().count(), 1, "{said}");
    said
}

/// Written files, by name.
fn files(out: &Path) -> Vec<String> {
    let entries = fs::read_dir(out).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn every_format_has_its_files() {
    for (format, expected) in [
        ("csv", vec!["events.csv", "trace.csv"]),
        ("arrow", vec!["events.arrow", "trace.arrow"]),
    ] {
        let out = tempfile::tempdir().unwrap();
        let output = export(&["--format", format, "--out", out.path().to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        assert_eq!(files(out.path()), expected);
        let said = String::from_utf8(output.stdout).unwrap();
        assert_eq!(said.lines().count(), expected.len(), "{said}");
        // The same command writes the same bytes.
        let again = tempfile::tempdir().unwrap();
        export(&["--format", format, "--out", again.path().to_str().unwrap()]);
        for name in &expected {
            let [first, second] =
                [&out, &again].map(|dir| fs::read(dir.path().join(name)).unwrap());
            assert!(first == second, "{name}");
        }
    }
}

#[test]
fn columns_and_tables_are_chosen() {
    let out = tempfile::tempdir().unwrap();
    let to = ["--out", out.path().to_str().unwrap()];
    let output = export(&[&["--columns", "time,deflection,displacement"], &to[..]].concat());
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    // The table of events has only the column `time` of these.
    assert_eq!(files(out.path()), ["events.csv", "trace.csv"]);
    let text = fs::read_to_string(out.path().join("trace.csv")).unwrap();
    let head = text.lines().next().unwrap();
    assert!(
        head.starts_with("time [s],deflection [m],displacement_1 [m sqrt(kg)],displacement_2"),
        "{head}"
    );
    // 40 cycles of 64 samples.
    assert_eq!(text.lines().count(), 1 + 40 * 64);
    let events = fs::read_to_string(out.path().join("events.csv")).unwrap();
    assert_eq!(events.lines().next(), Some("time [s]"));

    let out = tempfile::tempdir().unwrap();
    let to = ["--out", out.path().to_str().unwrap()];
    export(&[&["--tables", "trace", "--lists", "long"], &to[..]].concat());
    assert_eq!(files(out.path()), ["trace.csv", "trace_lists.csv"]);
    let lists = fs::read_to_string(out.path().join("trace_lists.csv")).unwrap();
    assert!(
        lists.starts_with("row,column,unit,element,name,value\n1,"),
        "{}",
        &lists[..80]
    );
}

/// A selection of lists alone leaves nothing for the first file of the table.
#[test]
fn lists_alone_have_one_file() {
    let out = tempfile::tempdir().unwrap();
    let to = ["--out", out.path().to_str().unwrap()];
    let lists = [
        "--tables",
        "trace",
        "--columns",
        "displacement",
        "--lists",
        "long",
    ];
    let output = export(&[&lists, &to[..]].concat());
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    assert_eq!(files(out.path()), ["trace_lists.csv"]);
}

#[test]
fn files_are_not_replaced_unless_asked() {
    let out = tempfile::tempdir().unwrap();
    let to = ["--out", out.path().to_str().unwrap(), "--tables", "events"];
    assert_eq!(export(&to).status.code(), Some(0));
    let path = out.path().join("events.csv");
    fs::write(&path, "mine").unwrap();
    let said = refusal(&to);
    assert!(
        said.contains("events.csv` already exists") && said.contains("--overwrite"),
        "{said}"
    );
    assert_eq!(fs::read_to_string(&path).unwrap(), "mine");
    let output = export(&[&to[..], &["--overwrite"]].concat());
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    assert!(fs::read_to_string(&path).unwrap().starts_with("time [s]"));
}

#[test]
fn what_is_not_there_is_said() {
    let said = refusal(&["--tables", "points"]);
    assert!(
        said.contains("no table `points`; it has trace, events"),
        "{said}"
    );
    let said = refusal(&["--columns", "deflexion"]);
    assert!(
        said.contains("no column `deflexion` in trace, events; did you mean `deflection`?"),
        "{said}"
    );
    let said = refusal(&["--format", "arrow", "--lists", "long"]);
    assert!(said.contains("files keep lists as lists"), "{said}");
    let empty = tempfile::tempdir().unwrap();
    for folder in [empty.path(), Path::new("nowhere")] {
        let output = atlas(WRITTEN, &["export", folder.to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(2));
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains("no result tables in"), "{said}");
    }
    // A folder that cannot be created is not bad input.
    let output = export(&["--out", "/proc/none/here"]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
}

#[test]
fn tables_are_listed() {
    let output = export(&["--list"]);
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(
        said.starts_with("trace: 2560 rows\n  time [s]: Time since"),
        "{said}"
    );
    assert!(said.contains("\nevents: "), "{said}");
    assert!(!TRACE.join("export").exists());
    let output = export(&["--list", "--json", "--tables", "trace"]);
    let told: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(told["tables"][0]["columns"][3]["unit"], "m");
    assert_eq!(told["files"].as_array().unwrap().len(), 0);
}
