//! Result tables for other programs: CSV and Arrow. The Python package writes NumPy, MATLAB and Excel files.
//!
//! A table is read twice, some thousand rows at a time: once to learn how many rows, how long lists
//! it has (`survey`), then to be written. Memory holds a row group of the table and
//! 8192 rows, whatever its length; every format takes rows as they come. A file has its name when it is whole.

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
