//! Errors of pictures, with remedies for the user.

use std::fmt::Display;
use std::path::PathBuf;

use thiserror::Error;

use super::picture_kind::PictureKind;
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
    /// The folder contains neither results nor followed orbits, a trace or a run-up.
    #[error(
        "nothing to draw in `{}`: give a folder with points.parquet (from `atlas run`), \
         branches.parquet (from `atlas follow`), trace.parquet (from `atlas trace`) or signals.parquet (from `atlas runup`), or a mesh table (from `atlas table`)",
        folder.display()
    )]
    Nothing {
        /// The given folder.
        folder: PathBuf,
    },
    /// The table file cannot be used.
    #[error("`{}` {fault}", path.display())]
    Table {
        /// The file.
        path: PathBuf,
        /// The fault.
        fault: CacheFault,
    },
    /// The data do not fit this picture.
    #[error("no {} picture: {reason}", what.name())]
    Unfit {
        /// The picture.
        what: PictureKind,
        /// Why, and what would help.
        reason: String,
    },
    /// Requested pictures do not fit the data.
    #[error("no {} picture from `{}`: {reason}; available here: {available}", what.name(), path.display())]
    NotAvailable {
        /// The requested picture.
        what: PictureKind,
        /// The given folder or file.
        path: PathBuf,
        /// Why, and what would help.
        reason: String,
        /// Pictures that are possible.
        available: String,
    },
    /// No point with that number.
    #[error(
        "no point {point_id} in these results; the column point_id of points.parquet lists all"
    )]
    UnknownPoint {
        /// The requested number.
        point_id: u64,
    },
    /// No axis with that name.
    #[error("no grid axis `{name}` with more than one value; these have several: {known}")]
    UnknownAxis {
        /// The requested name.
        name: String,
        /// Axes that can be plotted over.
        known: String,
    },
    /// No axis with that name in one of the folders.
    #[error("no grid axis `{name}` in `{}`; its axes are: {known}", folder.display())]
    NoAxis {
        /// The requested name.
        name: String,
        /// The folder.
        folder: PathBuf,
        /// Axes of the folder.
        known: String,
    },
    /// No axis remains along which the curves could go.
    #[error(
        "`{}` has no grid axis for the curves{}",
        folder.display(),
        except.as_ref().map_or(String::new(), |name| format!(" besides `{name}`; remove --by {name}"))
    )]
    NoOtherAxis {
        /// The folder.
        folder: PathBuf,
        /// The axis that distinguishes the curves.
        except: Option<String>,
    },
    /// The same axis is requested along the curves and to distinguish them.
    #[error("--over and --by name the same axis `{name}`; name two different axes")]
    SameAxis {
        /// The axis.
        name: String,
    },
    /// The text is neither a kind of picture nor a column of numbers.
    #[error(
        "no kind of picture and no column of numbers has the name `{name}`{}{}; `atlas plot {} --list` lists all",
        if *is_text { " (this column contains text)" } else { "" },
        if nearest.is_empty() { String::new() } else { format!("; did you mean {}?", nearest.join(", ")) },
        folder.display()
    )]
    UnknownColumn {
        /// The requested name.
        name: String,
        /// Whether it is a column of texts.
        is_text: bool,
        /// Similar names.
        nearest: Vec<String>,
        /// The folder.
        folder: PathBuf,
    },
    /// A column of a missing table.
    #[error("no {column}: there is no {table} in `{}`; `atlas plot {} --list` lists what can be drawn", folder.display(), folder.display())]
    NoTable {
        /// The requested column.
        column: String,
        /// The folder.
        folder: PathBuf,
        /// File of the missing table.
        table: &'static str,
    },
    /// An element that a column does not have.
    #[error(
        "no {column}[{element}]: {}",
        match length {
            Some(length) if names.is_empty() => {
                format!("its lists have {length} elements, counted from 1")
            }
            Some(_) => format!("its elements are {}", names.join(", ")),
            None => "the column contains numbers, not lists".to_owned(),
        }
    )]
    NoElement {
        /// The column.
        column: String,
        /// The requested element.
        element: String,
        /// Number of elements; `None` if the column contains no lists.
        length: Option<usize>,
        /// Their names, if any.
        names: Vec<String>,
    },
    /// The unit in an option does not fit.
    #[error("`{option} {given}` does not fit {name}, whose unit is {}", if unit == "1" { "1 (a plain number)" } else { unit })]
    OtherUnit {
        /// The option.
        option: &'static str,
        /// Value of the option.
        given: String,
        /// The column or level.
        name: String,
        /// Unit of the column or level.
        unit: String,
    },
    /// A unit that fits no drawn quantity.
    #[error("`--unit {unit}` does not fit any drawn quantity; their units are {drawn}")]
    UnusedUnit {
        /// The unit.
        unit: String,
        /// SI units of the drawn quantities.
        drawn: String,
    },
    /// A picture of one folder, requested for several.
    #[error("{} pictures need a single folder; several folders are possible with columns (`--what deflection_rms`) and `--what orders`", what.name())]
    OneFolder {
        /// The picture.
        what: PictureKind,
    },
    /// Columns were requested, but the source has no results.
    #[error("`{}` has no columns to draw; give a folder that `atlas run` wrote", folder.display())]
    NoColumns {
        /// The folder or file.
        folder: PathBuf,
    },
    /// Measured points over another axis than that of the curves.
    #[error(
        "the first column of `{}` is `{column}`, but the curves are over `{over}`; give --over {column}, or rename the column",
        file.display()
    )]
    MeasuredAxis {
        /// The file of the measured points.
        file: PathBuf,
        /// First column of the file.
        column: String,
        /// The axis of the curves.
        over: String,
    },
    /// Measured points for a column that is not drawn.
    #[error(
        "the second column of `{}` is `{column}`, which --what does not name; give --what {column}, or rename the column",
        file.display()
    )]
    MeasuredValue {
        /// The file of the measured points.
        file: PathBuf,
        /// Second column of the file.
        column: String,
    },
    /// Measured points in a unit of another quantity.
    #[error(
        "`{column} [{unit}]` in `{}` does not fit {column}, whose unit is {}",
        file.display(),
        if si == "1" { "1 (a plain number)" } else { si }
    )]
    MeasuredUnit {
        /// The file of the measured points.
        file: PathBuf,
        /// The column.
        column: String,
        /// Unit of the column in the file.
        unit: String,
        /// SI unit of the column.
        si: String,
    },
    /// The drawing library fails.
    #[error("a picture could not be drawn: {detail}")]
    Drawing {
        /// Message of the library.
        detail: String,
    },
}

impl PictureKind {
    /// The error of data that do not fit this kind of picture.
    pub(super) fn unfit(self, reason: impl Into<String>) -> PlotError {
        PlotError::Unfit {
            what: self,
            reason: reason.into(),
        }
    }
}

impl PlotError {
    pub(super) fn drawing(error: impl Display) -> Self {
        Self::Drawing {
            detail: error.to_string(),
        }
    }
}
