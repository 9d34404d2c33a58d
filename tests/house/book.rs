//! Is the book of `docs/` complete? tests/python/test_pages.py runs the commands of its tutorials.

#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

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
