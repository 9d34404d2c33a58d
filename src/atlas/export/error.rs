//! Why can a table not be written for another program?

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
        "no result tables in `{}`; give a folder that `atlas run`, `atlas follow` or `atlas trace` wrote",
        folder.display()
    )]
    NoTables {
        /// The folder.
        folder: PathBuf,
    },
    /// The folder does not have a table that was asked for.
    #[error("`{}` has no table `{name}`; it has {present}", folder.display())]
    NoTable {
        /// The folder.
        folder: PathBuf,
        /// What was asked for.
        name: String,
        /// Those that are there.
        present: String,
    },
    /// None of the tables has a column that was asked for.
    #[error("no column `{name}` in {tables}{}", nearest.as_ref().map_or(
        String::from("; `atlas export FOLDER --list` lists them"), |known| format!("; did you mean `{known}`?")
    ))]
    NoColumn {
        /// What was asked for.
        name: String,
        /// The tables looked in.
        tables: String,
        /// A column with a name like it.
        nearest: Option<String>,
    },
    /// A file would be replaced.
    #[error("`{}` already exists: choose another folder with --out, or replace it with --overwrite", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// A format that has no place for lists in a table of their own.
    #[error("{format} files keep lists as lists; remove --lists long, or choose csv")]
    ListsAreKept {
        /// The format.
        format: &'static str,
    },
    /// The library of Arrow files refused, or the system did.
    #[error("cannot write the Arrow file `{}`", path.display())]
    Arrow {
        /// The file.
        path: PathBuf,
        /// Why.
        source: arrow_schema::ArrowError,
    },
}
