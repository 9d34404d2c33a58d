//! Is the book of `docs/` complete, and do its tutorials work? The test runs their commands in order, as a reader
//! would.

#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;
use std::env;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The blocks of a page with fence ```` ```sh ````, joined.
fn commands(page: &str) -> String {
    let mut script = String::new();
    let mut within = false;
    for line in page.lines() {
        match (within, line) {
            (false, "```sh") => within = true,
            (true, "```") => within = false,
            (true, line) => {
                script.push_str(line);
                script.push('\n');
            }
            _ => {}
        }
    }
    assert!(!within, "a block of commands does not end");
    script
}

/// Runs the commands of a page in a separate folder with the shipped manifests; returns the folder.
fn follow(name: &str) -> tempfile::TempDir {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = fs::read_to_string(root.join("docs/tutorials").join(name)).unwrap();
    let script = commands(&page);
    assert!(script.matches("\natlas ").count() >= 10, "{script}");
    let place = tempfile::tempdir().unwrap();
    symlink(root.join("manifests"), place.path().join("manifests")).unwrap();
    let program = Path::new(env!("CARGO_BIN_EXE_atlas")).parent().unwrap();
    let path: Vec<PathBuf> = [program.to_path_buf()]
        .into_iter()
        .chain(env::split_paths(&env::var_os("PATH").unwrap_or_default()))
        .collect();
    let output = Command::new("bash")
        .args(["-euo", "pipefail", "-c", &script])
        .current_dir(place.path())
        .env("PATH", env::join_paths(path).unwrap())
        .stdin(Stdio::null())
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{name}: {}\n{}\n{}",
        output.status,
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    place
}

/// Asserts that every file that a page names as its result exists and is not empty.
fn left(place: &tempfile::TempDir, files: &[&str]) {
    for file in files {
        let size = fs::metadata(place.path().join(file)).map(|file| file.len());
        assert!(matches!(size, Ok(1..)), "{file}: {size:?}");
    }
}

#[test]
fn the_tutorial_for_engineers() {
    let place = follow("engineer.md");
    left(&place, &["results/pair/points.parquet"]);
}

#[test]
fn the_tutorial_for_researchers() {
    let place = follow("researcher.md");
    left(&place, &["results/oscillator/points.parquet"]);
}

/// Every page of `docs/` is in the book's contents, and every page of the contents exists.
#[test]
fn contents_name_every_page() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let contents = fs::read_to_string(docs.join("SUMMARY.md")).unwrap();
    let mut named: Vec<String> = (contents.split("](").skip(1))
        .map(|rest| rest.split(')').next().unwrap().to_owned())
        .collect();
    let pages = |folder: &str| -> Vec<String> {
        let entries = fs::read_dir(docs.join(folder)).unwrap();
        let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        names
            .filter(|name| name.ends_with(".md") && name != "SUMMARY.md")
            .map(|name| format!("{folder}{name}"))
            .collect()
    };
    let mut there = [pages(""), pages("tutorials/"), pages("theory/")].concat();
    named.sort();
    there.sort();
    assert_eq!(named, there);
}

/// The names in a table of dependencies of a manifest of Cargo, without those of this workspace.
fn dependencies(cargo: &toml::Table, path: &[&str]) -> BTreeSet<String> {
    let table = path
        .iter()
        .fold(cargo, |table, key| table[*key].as_table().unwrap());
    let names = table.keys().filter(|name| !name.contains("atlas"));
    names.cloned().collect()
}

#[test]
fn every_direct_dependency_has_a_reason_and_no_reason_outlives_it() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let cargo = |file| -> toml::Table {
        fs::read_to_string(root.join(file))
            .unwrap()
            .parse()
            .unwrap()
    };
    let mut used = dependencies(&cargo("Cargo.toml"), &["workspace", "dependencies"]);
    used.extend(dependencies(&cargo("python/Cargo.toml"), &["dependencies"]));
    let page = fs::read_to_string(root.join("docs/dependencies.md")).unwrap();
    let rows = page.lines().filter_map(|line| line.strip_prefix("| `"));
    let told: BTreeSet<String> = rows
        .map(|row| row.split('`').next().unwrap().to_owned())
        .collect();
    assert_eq!(
        told, used,
        "docs/dependencies.md (left) and Cargo.toml (right)"
    );
    assert!(used.contains("raw-cpuid") && used.contains("insta") && used.contains("pyo3"));
}
