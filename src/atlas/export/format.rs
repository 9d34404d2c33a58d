//! Which formats are there, and where do lists go in them?

use clap::ValueEnum;

/// A format of other programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Text separated by commas: a file a table.
    Csv,
    /// NumPy: a file a table, an array a column.
    Npz,
    /// MATLAB, level 5: one file, a struct a table.
    Mat,
    /// Excel: one workbook, a worksheet a table.
    Xlsx,
    /// Arrow IPC (Feather, version 2): a file a table, for Julia, R and others.
    Arrow,
}

impl Format {
    /// How names of its files end.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Npz => "npz",
            Self::Mat => "mat",
            Self::Xlsx => "xlsx",
            Self::Arrow => "arrow",
        }
    }

    /// Whether one file holds all tables.
    pub(super) fn holds_all(self) -> bool {
        matches!(self, Self::Mat | Self::Xlsx)
    }
}

/// Where lists go in formats of rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Lists {
    /// Into numbered columns, one an element.
    Wide,
    /// Into a table of their own, a row an element.
    Long,
}
