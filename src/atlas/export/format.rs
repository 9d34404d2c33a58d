//! The formats of exported files, and the place of lists in them.

use clap::ValueEnum;

/// A format of other programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Text separated by commas, one file per table.
    Csv,
    /// Arrow IPC (Feather, version 2), one file per table, for Julia, R and others.
    Arrow,
}

impl Format {
    /// Extension of its files.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Arrow => "arrow",
        }
    }
}

/// Where lists go in formats of rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Lists {
    /// Into numbered columns, one per element.
    Wide,
    /// Into a separate table with one row per element.
    Long,
}
