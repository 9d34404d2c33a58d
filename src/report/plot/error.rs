//! What can stand in the way of a picture, said with what to do about it.

use std::fmt::Display;
use std::path::PathBuf;

use thiserror::Error;

use super::what::What;
use crate::report::ReportError;
use crate::store::{CacheFault, StoreError};

/// Pictures cannot be drawn.
#[derive(Debug, Error)]
pub enum PlotError {
    /// The summary of the results cannot be read.
    #[error(transparent)]
    Report(#[from] ReportError),
    /// A table cannot be read.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The folder holds neither results nor followed orbits nor a trace.
    #[error(
        "nothing to plot in `{}`: give a folder with points.parquet (from `atlas run`), \
         branches.parquet (from `atlas follow`) or trace.parquet (from `atlas trace`), or a mesh table (see `atlas table list`)",
        folder.display()
    )]
    Nothing {
        /// The folder given.
        folder: PathBuf,
    },
    /// The table file cannot be used.
    #[error("`{}` {fault}", path.display())]
    Table {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        fault: CacheFault,
    },
    /// A mesh table lacks something that every picture needs.
    #[error("`{}` cannot be drawn: {detail}", path.display())]
    MeshTable {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        detail: String,
    },
    /// The data do not fit this picture.
    #[error("no {} picture: {reason}", what.name())]
    Unfit {
        /// The picture.
        what: What,
        /// Why, and what would help.
        reason: String,
    },
    /// Pictures asked for do not fit the data.
    #[error("no {} picture from `{}`: {reason}; available here: {available}", what.name(), path.display())]
    NotAvailable {
        /// The picture asked for.
        what: What,
        /// The folder or file given.
        path: PathBuf,
        /// Why, and what would help.
        reason: String,
        /// Pictures that it allows.
        available: String,
    },
    /// No point of that number.
    #[error(
        "no point {point_id} in these results; points.parquet lists them in its column point_id"
    )]
    UnknownPoint {
        /// The number asked for.
        point_id: u64,
    },
    /// No axis of that name.
    #[error("no grid axis `{name}` with more than one value; such axes are: {known}")]
    UnknownAxis {
        /// The name asked for.
        name: String,
        /// Axes that can be plotted over.
        known: String,
    },
    /// The drawing library refuses.
    #[error("a picture could not be drawn: {detail}")]
    Drawing {
        /// Its own words.
        detail: String,
    },
}

impl PlotError {
    pub(super) fn drawing(error: impl Display) -> Self {
        Self::Drawing {
            detail: error.to_string(),
        }
    }
}
