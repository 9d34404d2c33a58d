//! `atlas help`: subcommands, keys of a manifest, the schema for editors.

#![allow(clippy::unwrap_used)]

use std::process::{Command, Output};

fn atlas(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_atlas"))
        .args(arguments)
        .output()
        .unwrap()
}

/// Standard output of a call that succeeds.
fn text(arguments: &[&str]) -> String {
    let output = atlas(arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}");
    assert!(output.stderr.is_empty(), "{arguments:?}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn subcommands_are_explained_as_before() {
    assert_eq!(text(&["help"]), text(&["--help"]));
    assert_eq!(text(&["help", "run"]), text(&["run", "--help"]));
    assert_eq!(
        text(&["help", "table", "build"]),
        text(&["table", "build", "--help"])
    );
    assert_eq!(text(&["help", "help"]), text(&["help", "--help"]));
    let output = atlas(&["help", "table", "bild"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(output.stdout.is_empty());
}

#[test]
fn keys_are_explained() {
    insta::assert_snapshot!("mesh_half_gap", text(&["help", "mesh.half_gap"]));
    insta::assert_snapshot!("overview", text(&["help", "manifest"]));
    insta::assert_snapshot!("shafts", text(&["help", "shafts"]));
    // `run` is a subcommand; brackets name the table.
    assert!(text(&["help", "[run]"]).contains("audit_cycles"));
    assert!(text(&["help", "run.steps"]).contains("60 bytes"));
}

#[test]
fn an_unknown_key_is_an_error_with_the_nearest() {
    let output = atlas(&["help", "mesh.half_gpa"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(output.stdout.is_empty());
    assert_eq!(
        String::from_utf8(output.stderr).unwrap(),
        "error: there is no table or key `mesh.half_gpa` in a manifest or a modal file; is `mesh.half_gap` meant?\n"
    );
    assert_eq!(atlas(&["help", "mesh", "gear"]).status.code(), Some(2));
}

#[test]
fn the_schema_is_printed_for_editors() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/manifest.schema.json");
    let written = std::fs::read_to_string(path).unwrap();
    assert!(text(&["help", "schema"]) == written);
}
