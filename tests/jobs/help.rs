//! `atlas help`: subcommands, keys of a manifest, the schema for editors.

#![allow(clippy::unwrap_used)]

use crate::{program, skipped};
use program::atlas;
use std::process::Command;

/// Standard output of a call that succeeds.
fn text(arguments: &[&str]) -> String {
    program::printed(".", arguments)
}

#[test]
fn subcommands_are_explained_as_before() {
    assert_eq!(text(&["help"]), text(&["--help"]));
    assert_eq!(text(&["help", "run"]), text(&["run", "--help"]));
    assert_eq!(
        text(&["help", "machine", "show"]),
        text(&["machine", "show", "--help"])
    );
    assert_eq!(text(&["help", "help"]), text(&["help", "--help"]));
    let output = atlas(".", &["help", "machine", "sho"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(output.stdout.is_empty());
}

#[test]
fn keys_are_explained() {
    insta::assert_snapshot!("mesh_half_gap", text(&["help", "mesh.half_gap"]));
    insta::assert_snapshot!("overview", text(&["help", "manifest"]));
    insta::assert_snapshot!("shafts", text(&["help", "shafts"]));
    // `run` is a subcommand; brackets select the table.
    assert!(text(&["help", "[run]"]).contains("audit_cycles"));
    assert!(text(&["help", "run.steps"]).contains("60 bytes"));
}

#[test]
fn an_unknown_key_is_an_error_with_the_nearest() {
    let output = atlas(".", &["help", "mesh.half_gpa"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(output.stdout.is_empty());
    assert_eq!(
        String::from_utf8(output.stderr).unwrap(),
        "error: there is no table or key `mesh.half_gpa` in a manifest or in a file that it names; did you mean `mesh.half_gap`?\n"
    );
    assert_eq!(atlas(".", &["help", "mesh", "gear"]).status.code(), Some(2));
}

#[test]
fn the_schema_is_printed_for_editors() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/manifest.schema.json");
    let written = std::fs::read_to_string(path).unwrap();
    assert!(text(&["help", "schema"]) == written);
}

/// Shell completion after `atlas help` offers the keys, which help need not list.
#[test]
fn keys_are_completed() {
    for shell in ["bash", "zsh"] {
        let script = text(&["completions", shell]);
        for topic in ["manifest", "mesh.half_gap", "mesh_coast"] {
            assert!(script.contains(&format!("{topic} ")), "{shell}: {topic}");
        }
    }
    assert!(!text(&["help", "help"]).contains("possible values"));
}

/// A page for the program and one per subcommand, which groff accepts without a warning.
#[test]
fn every_subcommand_has_a_manual_page() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let told = text(&["man", folder.to_str().unwrap()]);
    let pages: Vec<&str> = told
        .lines()
        .map(|line| line.rsplit('/').next().unwrap())
        .collect();
    let listed = text(&["help"]);
    let commands = listed.split("Commands:").nth(1).unwrap();
    let commands = commands.split("Options:").next().unwrap().lines();
    let names: Vec<&str> = commands
        .filter(|line| line.starts_with("  ") && !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    assert!(names.len() > 12, "{names:?}");
    for name in &names {
        assert!(
            pages.contains(&&*format!("atlas-{name}.1")),
            "{name} in {pages:?}"
        );
    }
    assert!(
        pages.contains(&"atlas.1") && pages.contains(&"atlas-machine-show.1"),
        "{pages:?}"
    );
    let plot = std::fs::read_to_string(folder.join("atlas-plot.1")).unwrap();
    assert!(plot.contains(".TH atlas-plot 1"), "{plot}");
    assert!(plot.contains("bearing_rms[pinion 1 x]"), "{plot}");
    for page in &pages {
        let lint = Command::new("groff")
            .args(["-man", "-ww", "-z", "-Tutf8", "-k"])
            .arg(folder.join(page))
            .output();
        let Ok(lint) = lint else {
            skipped::skipped("no groff here to read manual pages");
            return;
        };
        let said = String::from_utf8_lossy(&lint.stderr);
        assert!(lint.status.success() && said.is_empty(), "{page}: {said}");
    }
}
