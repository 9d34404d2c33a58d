//! What can go wrong with the cache of tables, said with what to do about it.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::CacheFault;
use crate::store::io_fault::{IoFault, Purpose};

/// A table could not be kept, found or removed.
#[derive(Debug, Error)]
pub enum CacheError {
    /// The operating system refused.
    #[error(transparent)]
    Io(#[from] IoFault),
    /// A table that was just written does not come back as it was.
    #[error("`{}` was written, but {fault}", path.display())]
    NotReadBack {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        fault: CacheFault,
    },
    /// A shape without a place for each value.
    #[error("array `{name}` of shape {shape:?} has {values} values")]
    Shape {
        /// The array.
        name: String,
        /// Extent of each axis.
        shape: Vec<usize>,
        /// Number of values.
        values: usize,
    },
    /// Two arrays of one name.
    #[error("there are two arrays `{name}`")]
    NameTaken {
        /// The name.
        name: String,
    },
    /// The table has no such array.
    #[error("the table has no array `{name}`; it has: {known}")]
    NoArray {
        /// The name asked for.
        name: String,
        /// Arrays that are there.
        known: String,
    },
    /// No table has a key that begins like this.
    #[error(
        "no table `{wanted}` in `{}`: give a file, or the first digits of a key that \
         `atlas table list` shows", folder.display()
    )]
    Unknown {
        /// What was asked for.
        wanted: String,
        /// The folder searched.
        folder: PathBuf,
    },
    /// Several tables have.
    #[error("`{wanted}` fits several tables: {}", found.join(", "))]
    Ambiguous {
        /// What was asked for.
        wanted: String,
        /// Names of the files.
        found: Vec<String>,
    },
}

impl CacheError {
    /// A failure of the operating system with the folder of tables.
    pub(super) fn io(path: &Path, action: &'static str, source: io::Error) -> Self {
        IoFault::new(path, action, Purpose::Tables, source).into()
    }
}
