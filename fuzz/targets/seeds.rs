//! Seeds for fuzzers: the manifests of the repository, good and bad, files of the program, and inputs in `fuzz/seeds`.

use super::{drive, journal, results, table};
use gearatlas::manifest::manual::json_schema;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Longest seed \[bytes\].
const LONGEST: u64 = 64 << 10;

/// The seeds of a target, for a repository in a folder.
///
/// # Panics
/// The folder is not this repository.
pub fn of(target: &str, repository: &Path) -> Vec<Vec<u8>> {
    let mut found = match target {
        "manifest" => texts(
            repository,
            &["manifests", "tests/manifests", "tests/data"],
            "toml",
        ),
        "modal" => {
            let mut modal = texts(
                repository,
                &["manifests", "tests/manifests", "tests/data"],
                ".modal.toml",
            );
            modal.extend(texts(repository, &["tests/manifests/bad"], "modal"));
            modal
        }
        "points" => texts(repository, &["manifests", "tests/manifests"], "csv"),
        "drive" => (0..drive::BASES.len() as u8)
            .map(|base| vec![base])
            .collect(),
        "breakpoints" => vec![vec![0, 0, 15, 4, 40, 0]],
        "table" | "table-sealed" => table::seeds(),
        "journal" => journal::seeds(),
        "journal-sealed" => journal::sealed_seeds(),
        "results" => results::seeds(),
        _ => Vec::new(),
    };
    found.extend(files(&repository.join("fuzz/seeds").join(target), ""));
    assert!(!found.is_empty(), "no seeds of {target}");
    found
}

/// Inputs that once broke a target.
pub fn regressions(target: &str, repository: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = repository.join("fuzz/regressions").join(target);
    let read = |path: PathBuf| {
        let bytes = fs::read(&path).expect("a file that can be read");
        (path, bytes)
    };
    paths(&folder, "").into_iter().map(read).collect()
}

fn texts(repository: &Path, folders: &[&str], ending: &str) -> Vec<Vec<u8>> {
    let all = folders.iter();
    all.flat_map(|folder| files(&repository.join(folder), ending))
        .collect()
}

/// The files of a folder and its subfolders with an ending, without long ones.
fn files(folder: &Path, ending: &str) -> Vec<Vec<u8>> {
    let short = |path: &PathBuf| fs::metadata(path).is_ok_and(|file| file.len() <= LONGEST);
    let all = paths(folder, ending).into_iter().filter(short);
    all.map(|path| fs::read(path).expect("a file that can be read"))
        .collect()
}

fn paths(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else {
        return Vec::new();
    };
    let mut all: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    all.sort();
    let below = |path: PathBuf| match path.is_dir() {
        true => paths(&path, ending),
        false if path.to_string_lossy().ends_with(ending) => vec![path],
        false => Vec::new(),
    };
    all.into_iter().flat_map(below).collect()
}

/// Words of manifests: keys, choices and examples of the schema, and extreme numbers of doubles and integers.
pub fn dictionary() -> Vec<String> {
    let schema: Value = serde_json::from_str(&json_schema()).expect("a schema is JSON");
    let mut words = BTreeSet::new();
    gather(&schema, &mut words);
    const NUMBERS: [&str; 14] = [
        "0",
        "-1",
        "1e308",
        "-1e308",
        "1e-308",
        "5e-324",
        "nan",
        "inf",
        "-inf",
        "9223372036854775807",
        "-9223372036854775808",
        "18446744073709551615",
        "0.1",
        "1e-12",
    ];
    const SIGNS: [&str; 12] = [
        "\"\"\"", "[[", "]]", "{}", "[]", "\"", "'''", "= [", "\\u0000", "\u{202e}", "\r\n", "#",
    ];
    words.extend(NUMBERS.iter().chain(&SIGNS).map(|word| (*word).to_owned()));
    words.into_iter().collect()
}

fn gather(schema: &Value, words: &mut BTreeSet<String>) {
    match schema {
        Value::Object(map) => {
            if let Some(Value::Object(properties)) = map.get("properties") {
                words.extend(properties.keys().cloned());
            }
            for list in ["enum", "examples"] {
                let values = map.get(list).and_then(Value::as_array);
                words.extend(values.into_iter().flatten().map(Value::to_string));
            }
            map.values().for_each(|value| gather(value, words));
        }
        Value::Array(values) => values.iter().for_each(|value| gather(value, words)),
        _ => {}
    }
}
