//! The values of one column over some rows.

use crate::store::{ColumnKind, ResultTable, StoreError};

/// Values of a column, one per row; `None` for absent values.
#[derive(Debug)]
pub enum Cells {
    /// Whole numbers.
    Whole(Vec<Option<u64>>),
    /// Numbers, all finite.
    Number(Vec<Option<f64>>),
    /// Booleans.
    Truth(Vec<Option<bool>>),
    /// Texts.
    Text(Vec<Option<String>>),
    /// Lists of numbers.
    List(Vec<Option<Vec<Option<f64>>>>),
}

/// A single value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cell<'a> {
    /// No value.
    Absent,
    /// A whole number.
    Whole(u64),
    /// A number.
    Number(f64),
    /// A boolean.
    Truth(bool),
    /// A text.
    Text(&'a str),
}

impl Cells {
    /// The values of a column for some rows.
    pub fn read(rows: &ResultTable, name: &str, kind: ColumnKind) -> Result<Self, StoreError> {
        Ok(match kind {
            ColumnKind::Whole => Self::Whole(rows.u64(name)?),
            ColumnKind::Number => Self::Number(rows.f64(name)?),
            ColumnKind::Truth => Self::Truth(rows.bool(name)?),
            ColumnKind::Text => Self::Text(rows.text(name)?),
            ColumnKind::List => Self::List(rows.lists(name)?),
        })
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        match self {
            Self::Whole(values) => values.len(),
            Self::Number(values) => values.len(),
            Self::Truth(values) => values.len(),
            Self::Text(values) => values.len(),
            Self::List(values) => values.len(),
        }
    }

    /// The value of a row; for a list its element at `place`, counted from 0.
    pub fn at(&self, row: usize, place: usize) -> Cell<'_> {
        match self {
            Self::Whole(values) => values[row].map_or(Cell::Absent, Cell::Whole),
            Self::Number(values) => values[row].map_or(Cell::Absent, Cell::Number),
            Self::Truth(values) => values[row].map_or(Cell::Absent, Cell::Truth),
            Self::Text(values) => values[row].as_deref().map_or(Cell::Absent, Cell::Text),
            Self::List(values) => {
                let element = values[row].as_ref().and_then(|list| *list.get(place)?);
                element.map_or(Cell::Absent, Cell::Number)
            }
        }
    }

    /// Length of the list of a row; 1 for other columns.
    pub fn length(&self, row: usize) -> usize {
        match self {
            Self::List(values) => values[row].as_ref().map_or(0, Vec::len),
            _ => 1,
        }
    }
}
