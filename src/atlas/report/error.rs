//! Errors of a summary.

use crate::store::StoreError;
use std::path::PathBuf;
use thiserror::Error;

/// A results folder cannot be summarised.
#[derive(Debug, Error)]
pub enum ReportError {
    /// The files of the folder cannot be read.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A required value is missing.
    #[error("`{}` has a row without `{column}`; write the results again", folder.display())]
    Incomplete {
        /// The results folder.
        folder: PathBuf,
        /// The column.
        column: String,
    },
    /// A table of followed orbits does not name their axis.
    #[error("`{}` does not name the axis along which orbits were followed; write it again with `atlas follow`", path.display())]
    NoFollowedAxis {
        /// The table.
        path: PathBuf,
    },
}
