//! Foreign names and texts, in every place where a command repeats them or makes a file of them. No control sequence
//! reaches a terminal, no path leaves the folder of results, and new files have the permissions of the user's umask.

#![allow(clippy::unwrap_used)]

use crate::{place, seal};
use place::{OSCILLATOR, Place, status, stderr, stdout};
use seal::reseal;
use serde_json::{Value, json};
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Output;

/// A title for the window, a cleared screen, a colour by one character, and reversed text.
const EVIL: &str = "\u{1b}]0;owned\u{7}\u{1b}[2J\u{9b}31m\u{202e}x\r";

/// Whether the text contains no control characters, so that a terminal only displays it.
fn is_harmless(text: &str) -> bool {
    text.chars().all(|c| {
        matches!(c, '\n' | '\t') || !(c.is_control() || ('\u{202a}'..='\u{202e}').contains(&c))
    })
}

fn said(output: &Output) -> String {
    let text = stdout(output) + &stderr(output);
    assert!(is_harmless(&text), "{text:?}");
    assert!(!text.contains("panicked"), "{text}");
    text
}

#[test]
fn arguments_that_are_names_of_files_are_only_shown() {
    let place = Place::new(OSCILLATOR);
    place.whole("r", &[]);
    fs::write(place.path(EVIL), OSCILLATOR).unwrap();
    for arguments in [
        &["show", EVIL][..],
        &["show", "r", EVIL],
        &["show", &format!("--{EVIL}")],
        &[EVIL],
        &["run", "m.toml", "--threads", EVIL],
        &["run", "m.toml", "--set", EVIL],
        &["run", "m.toml", "--shard", EVIL],
        &["run", "m.toml", "--out", EVIL],
        &["merge", EVIL, "--out", EVIL],
        &["plot", "r", "--what", EVIL],
        &["plot", EVIL],
        &["export", "r", "--format", EVIL],
        &["export", "r", "--format", "csv", "--columns", EVIL],
        &["trace", "m.toml", "--point", EVIL],
        &["table", EVIL],
        &["table", "m.toml", "--tables", EVIL],
        &["machine", "show", EVIL],
        &["verify", EVIL],
        &["help", EVIL],
        &["completions", EVIL],
    ] {
        let output = place.atlas(arguments);
        assert_ne!(status(&output), 0, "{arguments:?}");
        assert!(!said(&output).is_empty(), "{arguments:?}");
    }
    // The request is executed, and its name is printed.
    let output = place.run("out\u{1b}[2J", &[]);
    assert!(said(&output).contains(r"out\u001b[2J"));
    assert!(place.path("out\u{1b}[2J").join("run.json").exists());
}

#[test]
fn warnings_about_folders_are_only_shown() {
    let place = Place::new(&OSCILLATOR.replace("[run]", "[run]\nkernel = \"closed_modes\""));
    fs::write(place.path(EVIL), "a file in the place of the folder").unwrap();
    said(&place.run("r", &["--tables", EVIL]));
    // The record keeps the problems of the cache of tables, and its summary shows them.
    let text = said(&place.atlas(&["show", "r"]));
    assert!(
        text.contains("cannot be kept") && text.contains(r"\u001b]0;owned\u0007"),
        "{text}"
    );
}

/// Foreign records and tables, with valid checksums.
#[test]
fn records_of_others_are_only_shown() {
    let place = Place::new(OSCILLATOR);
    for shard in ["1/2", "2/2"] {
        place.whole("parts", &["--shard", shard]);
    }
    place.whole("r", &[]);
    let spoil = |record: &mut Value| {
        record["job"] = json!(EVIL);
        record["warnings"] = json!([EVIL]);
        record["machine"]["cpu"] = json!(EVIL);
        record["machine"]["instructions"] = json!([EVIL, "baseline"]);
        record["program"]["version"] = json!(EVIL);
    };
    reseal(&place.path("r/run.json"), spoil);
    for record in ["run.shard-1-of-2.json", "run.shard-2-of-2.json"] {
        reseal(&place.path("parts").join(record), spoil);
    }
    for arguments in [
        &["show", "r"][..],
        &["show", "r", "--json"],
        &["show", "parts"],
        &["plot", "r", "--format", "svg", "--out", "pictures"],
        &["export", "r", "--format", "csv", "--out", "sheets"],
        &["run", "m.toml", "--out", "r"],
        &["run", "m.toml", "--out", "r", "--retry", "failed"],
        &["merge", "parts", "--out", "joined"],
        &["merge", "parts", "--out", "joined-json", "--json"],
    ] {
        let output = place.atlas(arguments);
        said(&output);
        if arguments.contains(&"--json") && status(&output) == 0 {
            let document: Value = serde_json::from_str(&stdout(&output)).unwrap();
            assert!(document.is_object(), "{arguments:?}");
        }
    }
    // Nothing was written outside the named folders.
    let mut left: Vec<String> = fs::read_dir(place.0.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    left.retain(|name| !["pictures", "sheets", "joined", "joined-json"].contains(&&**name));
    left.sort();
    assert_eq!(
        left,
        ["m.toml", "oscillator.modal.toml", "parts", "r", "tables"]
    );
}

#[test]
fn a_document_with_strange_characters_stays_one() {
    let key = "\"a\u{9b}\u{202e}\"";
    let place = Place::new(&OSCILLATOR.replace("[mesh]", &format!("[mesh]\n{key} = 1")));
    let output = place.atlas(&["check", "m.toml", "--json"]);
    assert_eq!(status(&output), 2);
    said(&output);
    let document: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert!(
        document.to_string().contains("a\u{9b}\u{202e}"),
        "{document}"
    );
}

#[test]
fn no_name_leads_out_of_the_folder() {
    let place = Place::new(OSCILLATOR);
    let inner = place.path("inner");
    fs::create_dir(&inner).unwrap();
    fs::copy(
        place.path("oscillator.modal.toml"),
        inner.join("oscillator.modal.toml"),
    )
    .unwrap();
    let long = "x".repeat(101);
    let given = OSCILLATOR
        .lines()
        .find(|line| line.starts_with("name ="))
        .unwrap();
    for name in [
        "..",
        ".",
        "../up",
        "/tmp/atlas-absolute",
        "a/b",
        "a\\\\b",
        "a\\u0000b",
        "",
        "-x",
        ".hidden",
        "a b",
        "a\\nb",
        "é",
        "C:",
        &long,
    ] {
        let text = OSCILLATOR.replace(given, &format!("name = \"{name}\""));
        fs::write(inner.join("m.toml"), text).unwrap();
        for command in ["run", "follow", "trace"] {
            let output = std::process::Command::new(env!("CARGO_BIN_EXE_atlas"))
                .args([command, "m.toml"])
                .current_dir(&inner)
                .output()
                .unwrap();
            assert_eq!(status(&output), 2, "{command} {name}: {}", stderr(&output));
            assert!(said(&output).contains("job.name"), "{command} {name}");
        }
    }
    let names = |folder: &Path| fs::read_dir(folder).unwrap().count();
    assert_eq!(
        (names(&inner), names(place.0.path())),
        (2, 3),
        "nothing is written"
    );
    // The longest possible name gives a folder.
    let text = OSCILLATOR.replace(given, &format!("name = \"{}\"", "x".repeat(100)));
    fs::write(place.path("m.toml"), text).unwrap();
    let output = place.atlas(&["run", "m.toml"]);
    assert!([0, 3].contains(&status(&output)), "{}", stderr(&output));
    assert!(
        place
            .path("results")
            .join("x".repeat(100))
            .join("run.json")
            .exists()
    );
    // A results folder with a name too long for the file system gives a one-line error.
    let output = place.run(&"y".repeat(300), &[]);
    assert_eq!(status(&output), 1);
    assert_eq!(stderr(&output).lines().count(), 1);
}

/// Every file and folder below one, with its permissions.
fn modes(folder: &Path, found: &mut Vec<(String, u32)>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let mode = fs::metadata(&path).unwrap().permissions().mode() & 0o7777;
        found.push((path.to_string_lossy().into_owned(), mode));
        if path.is_dir() {
            modes(&path, found);
        }
    }
}

#[test]
fn files_have_the_permissions_that_the_user_lets_through() {
    let place = Place::new(&OSCILLATOR.replace("[run]", "[run]\nkernel = \"closed_modes\""));
    let script = |umask: &str| {
        format!(
            "umask {umask}; $ATLAS run m.toml --out o{umask}/r --tables o{umask}/tables && \
             $ATLAS plot o{umask}/r --out o{umask}/pictures && \
             $ATLAS export o{umask}/r --format csv --out o{umask}/sheets && \
             $ATLAS trace m.toml --point load=0.1,speed=600 --out o{umask}/trace && \
             $ATLAS man o{umask}/man; echo $?"
        )
    };
    for (umask, bits) in [("022", 0o022), ("077", 0o077), ("002", 0o002)] {
        let output = place.shell(&script(umask));
        let mut found = Vec::new();
        modes(&place.path(&format!("o{umask}")), &mut found);
        assert!(found.len() > 12, "{} {found:?}", stderr(&output));
        for (path, mode) in found {
            let full = match Path::new(&path) {
                path if path.is_dir() => 0o777,
                // Kept tables are read-only.
                path if path.extension().is_some_and(|e| e == "table") => 0o444,
                _ => 0o666,
            };
            assert_eq!(mode, full & !bits, "{path}: {mode:o} with umask {umask}");
        }
    }
}
