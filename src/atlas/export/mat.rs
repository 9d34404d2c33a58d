//! A MATLAB file of level 5 (`load`, `scipy.io.loadmat`): a struct a table with a field a column, and `units`,
//! `descriptions` and `elements`, structs of the same names; the last has cells with the names of the elements of lists, empty
//! where they have none.
//!
//! Numbers, whole ones too, are columns of doubles, `NaN` where there is none; truth values are logical where
//! every row has one. Texts are cells, empty where there is none. Lists are rows of a matrix, `NaN` behind
//! their end. Format: MathWorks, MAT-File Format, R2023b. Nothing is compressed, so that every column has its
//! place before its values are known.

use super::cells::{Cell, Cells};
use super::error::ExportError;
use super::region::{Places, Region};
use super::survey::{Surveyed, SurveyedColumn};
use crate::store::{ColumnKind, StoreError, WholeFile};
use std::path::Path;

/// Bytes a variable may take.
const MOST_BYTES: u64 = (1 << 31) - 1;

/// Bytes of a field's name with its end; names may be as long as MATLAB's.
const NAME: usize = 64;

/// Types of data in the file.
const INT8: u32 = 1;
const UINT8: u32 = 2;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const DOUBLE: u32 = 9;
const MATRIX: u32 = 14;
const UTF8: u32 = 16;

/// Classes of arrays.
const CELL_CLASS: u32 = 1;
const STRUCT_CLASS: u32 = 2;
const CHAR_CLASS: u32 = 4;
const DOUBLE_CLASS: u32 = 6;
const UINT8_CLASS: u32 = 9;
const LOGICAL: u32 = 0x200;

/// Bytes of an array without a name before its data or cells.
const HEAD: u64 = 48;

/// Bytes before a run of data.
const TAG: u64 = 8;

/// Writes tables into one file.
pub fn write(folder: &Path, tables: &[Surveyed], path: &Path) -> Result<(), ExportError> {
    let whole = WholeFile::create(path)?;
    let places = Places {
        file: whole.file(),
        path,
    };
    let mut head = format!("{:<116}", "MATLAB 5.0 MAT-file, result tables of atlas").into_bytes();
    head.extend([0; 8]);
    head.extend(0x0100_u16.to_le_bytes());
    head.extend(b"IM");
    places.write(0, &head)?;
    let mut at = head.len() as u64;
    for table in tables {
        at = write_table(folder, table, &places, at)?;
    }
    let told = |pick: fn(&SurveyedColumn) -> Vec<u8>| {
        let tables = tables.iter().map(|table| {
            let texts = table.columns.iter().map(pick);
            (
                table.name().to_owned(),
                structure("", &names(table), &texts.collect::<Vec<_>>()),
            )
        });
        let (names, values): (Vec<String>, Vec<Vec<u8>>) = tables.unzip();
        (names, values)
    };
    let told = [
        ("units", told(|column| text(&column.head.unit))),
        (
            "descriptions",
            told(|column| text(&column.head.description)),
        ),
        ("elements", told(|column| cells(column.elements()))),
    ];
    for (name, (names, values)) in told {
        let variable = structure(name, &names, &values);
        places.write(at, &variable)?;
        at += variable.len() as u64;
    }
    Ok(whole.publish()?)
}

/// Refuses a table that a variable does not hold.
pub fn admit(table: &Surveyed) -> Result<(), ExportError> {
    table.exact("MATLAB", |column| column.head.kind == ColumnKind::Whole)?;
    let bytes = struct_head(table.name(), &names(table)).len() as u64
        + table
            .columns
            .iter()
            .map(|column| bytes(column, table.rows))
            .sum::<u64>();
    match bytes <= MOST_BYTES {
        true => Ok(()),
        false => Err(ExportError::MatlabVariable {
            table: table.name(),
            bytes,
            most: MOST_BYTES,
        }),
    }
}

/// Bytes of a column with its head.
fn bytes(column: &SurveyedColumn, rows: u64) -> u64 {
    match column.head.kind {
        ColumnKind::Text => HEAD + rows * (HEAD + TAG) + column.padded_bytes,
        _ if is_logical(column) => HEAD + TAG + rows.next_multiple_of(8),
        _ => HEAD + TAG + 8 * rows * column.places() as u64,
    }
}

fn is_logical(column: &SurveyedColumn) -> bool {
    column.head.kind == ColumnKind::Truth && column.absent == 0
}

/// Writes a table at a place of the file; where it ends.
fn write_table(
    folder: &Path,
    table: &Surveyed,
    places: &Places<'_>,
    start: u64,
) -> Result<u64, ExportError> {
    let mut head = struct_head(table.name(), &names(table));
    let mut at = start + head.len() as u64;
    // One of each element of lists: a matrix is kept column by column.
    let mut regions: Vec<Vec<Region>> = Vec::new();
    for column in &table.columns {
        let size = bytes(column, table.rows);
        let width = column.places() as u64;
        let mut own = tag(MATRIX, size - TAG).to_vec();
        let (class, data) = match column.head.kind {
            ColumnKind::Text => (CELL_CLASS, None),
            _ if is_logical(column) => (UINT8_CLASS | LOGICAL, Some((UINT8, table.rows))),
            _ => (DOUBLE_CLASS, Some((DOUBLE, 8 * table.rows * width))),
        };
        own.extend(array_head(class, [table.rows, width], ""));
        own.extend(
            data.into_iter()
                .flat_map(|(kind, length)| tag(kind, length)),
        );
        let first = at + own.len() as u64;
        regions.push(
            (0..width)
                .map(|place| Region::at(first + 8 * table.rows * place))
                .collect(),
        );
        places.write(at, &own)?;
        at += size;
    }
    let length = at - start - TAG;
    head[..8].copy_from_slice(&tag(MATRIX, length));
    places.write(start, &head)?;
    table.scan(folder, |columns| {
        for ((cells, column), regions) in columns.iter().zip(&table.columns).zip(&mut regions) {
            for (place, region) in regions.iter_mut().enumerate() {
                region.append(places, &encoded(cells, column, place))?;
            }
        }
        Ok(())
    })?;
    // What fills logical values up to a multiple of eight bytes was never written.
    let grown = places.file.set_len(at);
    grown.map_err(|source| StoreError::io(places.path, "write", source))?;
    Ok(at)
}

/// Some rows of a column, of lists those of one element.
fn encoded(cells: &Cells, column: &SurveyedColumn, place: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    for row in 0..cells.rows() {
        match cells.at(row, place) {
            Cell::Text(found) => bytes.extend(text(found)),
            Cell::Absent if column.head.kind == ColumnKind::Text => bytes.extend(text("")),
            Cell::Truth(value) if is_logical(column) => bytes.push(u8::from(value)),
            cell => bytes.extend(cell.number().to_le_bytes()),
        }
    }
    bytes
}

/// Names of fields as MATLAB takes them: letters, digits and `_`, a letter first, all different.
fn names(table: &Surveyed) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for column in &table.columns {
        let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
        let mut name: String = column.head.name.chars().map(plain).collect();
        if !name.starts_with(|c: char| c.is_ascii_alphabetic()) {
            name.insert_str(0, "x_");
        }
        name.truncate(NAME - 1);
        let mut count = 1;
        while names.contains(&name) {
            count += 1;
            let number = format!("_{count}");
            name.truncate(NAME - 1 - number.len());
            name += &number;
        }
        names.push(name);
    }
    names
}

/// What goes before some data.
fn tag(kind: u32, bytes: u64) -> [u8; 8] {
    let mut tag = [0; 8];
    tag[..4].copy_from_slice(&kind.to_le_bytes());
    tag[4..].copy_from_slice(&(bytes as u32).to_le_bytes());
    tag
}

/// Some data with its tag, filled up to a multiple of eight bytes.
fn data(kind: u32, bytes: &[u8]) -> Vec<u8> {
    let mut all = tag(kind, bytes.len() as u64).to_vec();
    all.extend_from_slice(bytes);
    all.resize(all.len().next_multiple_of(8), 0);
    all
}

/// Class, size and name of an array.
fn array_head(class: u32, size: [u64; 2], name: &str) -> Vec<u8> {
    let mut head = data(UINT32, &[class.to_le_bytes(), [0; 4]].concat());
    head.extend(data(
        INT32,
        &size.map(|count| (count as u32).to_le_bytes()).concat(),
    ));
    head.extend(data(INT8, name.as_bytes()));
    head
}

/// An array with its tag.
fn array(class: u32, size: [u64; 2], name: &str, behind: &[u8]) -> Vec<u8> {
    let head = array_head(class, size, name);
    let mut all = tag(MATRIX, (head.len() + behind.len()) as u64).to_vec();
    all.extend(head);
    all.extend_from_slice(behind);
    all
}

/// A text as a row of characters.
fn text(text: &str) -> Vec<u8> {
    // As many as MATLAB makes of it, which keeps characters in UTF-16.
    let length = text.encode_utf16().count() as u64;
    array(
        CHAR_CLASS,
        [length.min(1), length],
        "",
        &data(UTF8, text.as_bytes()),
    )
}

/// Texts in a row of cells.
fn cells(texts: &[String]) -> Vec<u8> {
    let each: Vec<u8> = texts.iter().flat_map(|own| text(own)).collect();
    array(CELL_CLASS, [1, texts.len() as u64], "", &each)
}

/// Everything of a struct before its values; its size is not known yet.
fn struct_head(name: &str, fields: &[String]) -> Vec<u8> {
    let mut head = tag(MATRIX, 0).to_vec();
    head.extend(array_head(STRUCT_CLASS, [1, 1], name));
    head.extend(
        [INT32 | 4 << 16, NAME as u32]
            .map(u32::to_le_bytes)
            .concat(),
    );
    let mut names = Vec::new();
    for field in fields {
        names.extend_from_slice(field.as_bytes());
        names.resize(names.len().next_multiple_of(NAME), 0);
    }
    head.extend(data(INT8, &names));
    head
}

/// A struct whose values are in memory.
fn structure(name: &str, fields: &[String], values: &[Vec<u8>]) -> Vec<u8> {
    let mut all = struct_head(name, fields);
    values.iter().for_each(|value| all.extend_from_slice(value));
    let length = all.len() as u64 - TAG;
    all[..8].copy_from_slice(&tag(MATRIX, length));
    all
}
