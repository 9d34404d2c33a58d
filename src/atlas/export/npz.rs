//! NumPy arrays in an archive (`numpy.load`): one a column, `column_names`, `column_units` and
//! `column_descriptions`, and `NAME_elements` of a column of lists whose elements have names.
//!
//! Whole numbers and truth values stay what they are where every row has one; else, as in pandas, they
//! are floating-point numbers, `NaN` where there is none. Texts have the length of the longest, empty where
//! there is none. Lists are rows of a matrix, `NaN` behind their end.

use super::cells::{Cell, Cells};
use super::error::ExportError;
use super::region::Places;
use super::survey::{Surveyed, SurveyedColumn};
use super::zip::{self, Entry};
use crate::store::{ColumnKind, WholeFile};
use std::path::Path;

/// What the elements of an array are.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Element {
    Whole,
    Number,
    Truth,
    /// Texts of so many characters.
    Text(usize),
}

impl Element {
    fn of(column: &SurveyedColumn) -> Self {
        match column.head.kind {
            ColumnKind::Text => Self::Text(column.characters.max(1)),
            ColumnKind::Whole if column.absent == 0 => Self::Whole,
            ColumnKind::Truth if column.absent == 0 => Self::Truth,
            _ => Self::Number,
        }
    }

    fn bytes(self) -> u64 {
        match self {
            Self::Whole | Self::Number => 8,
            Self::Truth => 1,
            Self::Text(characters) => 4 * characters as u64,
        }
    }

    /// NumPy's own name.
    fn name(self) -> String {
        match self {
            Self::Whole => "<u8".to_owned(),
            Self::Number => "<f8".to_owned(),
            Self::Truth => "|b1".to_owned(),
            Self::Text(characters) => format!("<U{characters}"),
        }
    }

    fn push(self, cell: Cell<'_>, bytes: &mut Vec<u8>) {
        match (self, cell) {
            (Self::Whole, Cell::Whole(value)) => bytes.extend(value.to_le_bytes()),
            (Self::Truth, Cell::Truth(value)) => bytes.push(u8::from(value)),
            (Self::Text(characters), cell) => {
                let text = if let Cell::Text(text) = cell {
                    text
                } else {
                    ""
                };
                let end = bytes.len() + 4 * characters;
                text.chars()
                    .for_each(|c| bytes.extend(u32::from(c).to_le_bytes()));
                bytes.resize(end, 0);
            }
            (_, cell) => bytes.extend(cell.number().to_le_bytes()),
        }
    }
}

/// The head of an array in the format's version 1.
fn head(element: Element, shape: &str) -> Vec<u8> {
    let description = format!(
        "{{'descr': '{}', 'fortran_order': False, 'shape': ({shape}), }}",
        element.name()
    );
    let length = (10 + description.len() + 1).next_multiple_of(64) - 10;
    let mut head = b"\x93NUMPY\x01\x00".to_vec();
    head.extend((length as u16).to_le_bytes());
    head.extend(format!("{description:<0$}\n", length - 1).into_bytes());
    head
}

/// An array in the archive: its head, and the bytes behind it.
struct Array {
    name: String,
    element: Element,
    head: Vec<u8>,
    count: u64,
}

impl Array {
    fn new(name: &str, element: Element, rows: u64, width: Option<usize>) -> Self {
        let (shape, each) = match width {
            None => (format!("{rows},"), 1),
            Some(width) => (format!("{rows}, {width}"), width as u64),
        };
        // Whoever unpacks the archive gets files beside each other, whatever a table calls a column.
        let apart = |c: char| c.is_control() || matches!(c, '/' | '\\');
        let name = name.replace(apart, "_");
        let (name, head) = (format!("{name}.npy"), head(element, &shape));
        Self {
            name,
            element,
            head,
            count: rows * each,
        }
    }

    fn size(&self) -> u64 {
        self.head.len() as u64 + self.count * self.element.bytes()
    }
}

/// Writes a table.
pub fn write(folder: &Path, table: &Surveyed, path: &Path) -> Result<(), ExportError> {
    table.exact("NumPy", |column| Element::of(column) == Element::Number)?;
    let columns = &table.columns;
    let mut arrays: Vec<Array> = (columns.iter())
        .map(|column| {
            let width = column.is_list().then_some(column.width);
            Array::new(&column.head.name, Element::of(column), table.rows, width)
        })
        .collect();
    let mut told: Vec<(String, Vec<&str>)> = vec![
        (
            "column_names".to_owned(),
            columns.iter().map(|column| &*column.head.name).collect(),
        ),
        (
            "column_units".to_owned(),
            columns.iter().map(|column| &*column.head.unit).collect(),
        ),
        (
            "column_descriptions".to_owned(),
            columns
                .iter()
                .map(|column| &*column.head.description)
                .collect(),
        ),
    ];
    for column in columns {
        let names: Vec<&str> = column.elements().iter().map(String::as_str).collect();
        if !names.is_empty() {
            told.push((format!("{}_elements", column.head.name), names));
        }
    }
    for (name, texts) in &told {
        let longest = texts.iter().map(|text| text.chars().count()).max();
        let element = Element::Text(longest.unwrap_or(0).max(1));
        arrays.push(Array::new(name, element, texts.len() as u64, None));
    }
    let whole = WholeFile::create(path)?;
    let places = Places {
        file: whole.file(),
        path,
    };
    let mut entries: Vec<Entry> = zip::lay_out(
        arrays
            .iter()
            .map(|array| (array.name.clone(), array.size())),
    );
    for (entry, array) in entries.iter_mut().zip(&arrays) {
        entry.append(&places, &array.head)?;
    }
    table.scan(folder, |cells| {
        let found = cells.iter().zip(columns);
        for ((cells, column), (entry, array)) in found.zip(entries.iter_mut().zip(&arrays)) {
            entry.append(&places, &bytes(cells, column, array.element))?;
        }
        Ok(())
    })?;
    let behind = columns.len();
    for ((_, texts), (entry, array)) in told
        .iter()
        .zip(entries[behind..].iter_mut().zip(&arrays[behind..]))
    {
        let mut bytes = Vec::new();
        texts
            .iter()
            .for_each(|text| array.element.push(Cell::Text(text), &mut bytes));
        entry.append(&places, &bytes)?;
    }
    zip::finish(entries, &places)?;
    Ok(whole.publish()?)
}

fn bytes(cells: &Cells, column: &SurveyedColumn, element: Element) -> Vec<u8> {
    let mut bytes = Vec::new();
    for row in 0..cells.rows() {
        for place in 0..column.places() {
            element.push(cells.at(row, place), &mut bytes);
        }
    }
    bytes
}
