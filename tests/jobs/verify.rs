//! `atlas verify` as a process: every quick check passes on this machine, the exit status agrees, the JSON can be read,
//! and the command needs no file.

#![allow(clippy::unwrap_used)]

use serde_json::Value;
use std::process::{Command, Output};

fn verify(arguments: &[&str]) -> Output {
    // The folder is empty: there is nothing to read.
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_atlas"))
        .current_dir(folder.path())
        .arg("verify")
        .args(arguments)
        .output()
        .unwrap();
    let left = std::fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(left, 0, "something was written");
    output
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

#[test]
fn the_whole_ladder_passes() {
    let output = verify(&["--json"]);
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let checks = report["checks"].as_array().unwrap();
    let (mut lines, mut skips) = (0, 0);
    for check in checks {
        for line in check["lines"].as_array().unwrap() {
            if line["passed"].is_null() {
                let what = line["what"].as_str().unwrap();
                assert!(what.contains("computed mesh"), "skipped: {line:#}");
                skips += 1;
                continue;
            }
            assert_eq!(line["passed"], true, "{}: {line:#}", check["check"]);
            assert!(line["value"].is_f64(), "{line:#}");
            lines += 1;
        }
    }
    assert!(checks.len() >= 20 && lines >= 50, "{lines} lines");
    assert_eq!(report["passed"], true);
    assert_eq!(report["failures"], 0);
    // The only skip is `closed_modes` on the only drive that it does not support.
    assert_eq!((skips, &report["skips"]), (1, &Value::from(1)));
    assert_eq!(report["extent"], "quick");
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(text(&output.stderr), "");
}

#[test]
fn one_check_alone() {
    let output = verify(&["--only", "shafts", "--only", "wedge"]);
    let shown = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{shown}");
    let passed: Vec<&str> = (shown.lines().filter(|l| l.starts_with("  pass  ")))
        .map(|line| line.split_whitespace().nth(1).unwrap())
        .collect();
    assert_eq!(passed, ["shafts", "shafts", "shafts", "wedge", "wedge"]);
    assert!(shown.contains("5 of 5 lines pass, 0 fail"), "{shown}");
    assert!(!shown.contains('\u{1b}'), "no colour but on a terminal");
}

#[test]
fn an_unknown_check_is_refused_with_the_names_there_are() {
    let output = verify(&["--only", "cycles"]);
    assert_eq!(output.status.code(), Some(2));
    let told = text(&output.stderr);
    assert!(
        told.contains("cycle") && told.contains("multipliers"),
        "{told}"
    );
}
