//! Result tables for other programs (CSV and Arrow), and signals of run-ups as sound. The Python package writes NumPy,
//! MATLAB and Excel files.
//!
//! A table is read twice, some thousand rows at a time: first to count its rows and the lengths of its lists
//! (`survey`), then to write it. Memory holds one row group of the table and 8192 rows, for any length of the
//! table. Only sound reads a whole table. A file gets its name only when it is complete.

mod arrow;
mod cells;
mod csv;
mod error;
mod format;
mod request;
mod survey;
mod wav;

pub use error::ExportError;
pub use format::{Format, Lists};
pub use request::{ExportRequest, Exported, export, survey_folder};
pub use survey::{Surveyed, SurveyedColumn};
pub use wav::{SoundError, WavFile, WavRequest, write_wav};
