//! Errors of an export.

use crate::store::StoreError;
use std::path::PathBuf;
use thiserror::Error;

/// A table cannot be exported.
#[derive(Debug, Error)]
pub enum ExportError {
    /// A file cannot be read or written.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The folder has no result table.
    #[error(
        "no result tables in `{}`; give a folder that `atlas run`, `runup`, `follow` or `trace` wrote",
        folder.display()
    )]
    NoTables {
        /// The folder.
        folder: PathBuf,
    },
    /// The folder does not have a requested table.
    #[error("`{}` has no table `{name}`; it has {present}", folder.display())]
    NoTable {
        /// The folder.
        folder: PathBuf,
        /// The requested name.
        name: String,
        /// Existing tables.
        present: String,
    },
    /// None of the tables has a requested column.
    #[error("no column `{name}` in {tables}{}", nearest.as_ref().map_or(
        String::from("; `atlas export FOLDER --list` lists them"), |known| format!("; did you mean `{known}`?")
    ))]
    NoColumn {
        /// The requested name.
        name: String,
        /// The searched tables.
        tables: String,
        /// A column with a similar name.
        nearest: Option<String>,
    },
    /// A file would be replaced.
    #[error("`{}` already exists: choose another folder with --out, or replace it with --overwrite", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// A format without separate tables for lists.
    #[error("{format} files keep lists as lists; remove --lists long, or choose csv")]
    ListsAreKept {
        /// The format.
        format: &'static str,
    },
    /// The library of Arrow files or the system failed.
    #[error("cannot write the Arrow file `{}`", path.display())]
    Arrow {
        /// The file.
        path: PathBuf,
        /// Why.
        source: arrow_schema::ArrowError,
    },
}
