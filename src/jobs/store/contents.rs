//! What does a folder contain if it does not contain the results of a run?

use std::fs;
use std::path::{Path, PathBuf};

use super::characteristics::RECORD;
use super::file::table_path;
use super::table_cache::EXTENSION;
use super::table_kind::TableKind;

/// The contents of a path without `points.parquet`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Contents {
    /// The path does not exist.
    NotThere,
    /// A file.
    File,
    /// Results of `atlas trace`.
    Trace,
    /// Results of `atlas runup`.
    RunUp,
    /// Results of `atlas machine`.
    Machine,
    /// Cached tables.
    Tables,
    /// A folder of folders with results; their names.
    Folders(Vec<String>),
    /// None of these.
    Nothing,
}

impl Contents {
    /// Inspects names only, without reading files.
    pub fn of(path: &Path) -> Self {
        if !path.exists() {
            return Self::NotThere;
        }
        if !path.is_dir() {
            return Self::File;
        }
        let holds = |folder: &Path, kind| table_path(folder, kind, None).exists();
        if holds(path, TableKind::Trace) {
            return Self::Trace;
        }
        if holds(path, TableKind::Signals) {
            return Self::RunUp;
        }
        if path.join(RECORD).is_file() {
            return Self::Machine;
        }
        let entries = || fs::read_dir(path).into_iter().flatten().flatten();
        let is_table = |path: PathBuf| path.extension().is_some_and(|found| found == EXTENSION);
        if entries().any(|entry| is_table(entry.path())) {
            return Self::Tables;
        }
        let results = |folder: &PathBuf| {
            [TableKind::Points, TableKind::Branches]
                .iter()
                .any(|kind| holds(folder, *kind))
        };
        let mut names: Vec<String> = entries()
            .map(|entry| entry.path())
            .filter(results)
            .filter_map(|folder| Some(folder.file_name()?.to_string_lossy().into_owned()))
            .collect();
        names.sort();
        if names.is_empty() { Self::Nothing } else { Self::Folders(names) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_are_told_apart_by_what_is_in_them() {
        let root = tempfile::tempdir().unwrap();
        let within = |name: &str, file: &str| {
            let folder = root.path().join(name);
            fs::create_dir_all(&folder).unwrap();
            fs::write(folder.join(file), "").unwrap();
            Contents::of(&folder)
        };
        assert_eq!(within("a", "trace.parquet"), Contents::Trace);
        assert_eq!(within("f", "signals.parquet"), Contents::RunUp);
        assert_eq!(within("b", "machine.json"), Contents::Machine);
        let key = "0123456789abcdef0123456789abcdef";
        assert_eq!(within("c", &format!("mesh-{key}.table")), Contents::Tables);
        assert_eq!(within("d", "notes.txt"), Contents::Nothing);
        assert_eq!(
            Contents::of(&root.path().join("d/notes.txt")),
            Contents::File
        );
        assert_eq!(Contents::of(&root.path().join("e")), Contents::NotThere);
        for name in ["run2", "run1"] {
            let folder = root.path().join("d").join(name);
            fs::create_dir(&folder).unwrap();
            fs::write(folder.join("points.parquet"), "").unwrap();
        }
        let names = ["run1", "run2"].map(str::to_owned).to_vec();
        assert_eq!(
            Contents::of(&root.path().join("d")),
            Contents::Folders(names)
        );
    }
}
