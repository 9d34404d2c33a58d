//! A workbook of Excel: a worksheet a table, and one that explains the columns.
//!
//! Rows go to temporary files as they come. Excel keeps numbers to 15 digits in what it shows, and to the bit in
//! the file. A worksheet has no more than 1 048 576 rows and 16 384 columns.

use super::cells::Cell;
use super::error::ExportError;
use super::format::Lists;
use super::sheet::{Sheet, write_lists, write_table};
use super::survey::Surveyed;
use crate::store::{ColumnKind, StoreError, WholeFile};
use rust_xlsxwriter::{Format, Workbook, Worksheet, XlsxError};
use std::io::{BufWriter, Write};
use std::path::Path;

/// Rows of a worksheet below its head.
const MOST_ROWS: u64 = 1_048_575;

/// Columns of a worksheet.
const MOST_COLUMNS: u64 = 16_384;

/// Characters of a text.
const MOST_CHARACTERS: u64 = 32_767;

/// Name of the worksheet that explains the columns.
const COLUMNS: &str = "columns";

/// Refuses tables that a worksheet does not hold.
pub fn admit(table: &Surveyed, lists: Lists) -> Result<(), ExportError> {
    table.exact("Excel", |column| column.head.kind == ColumnKind::Whole)?;
    let elements = match table.has_long_lists(lists) {
        true => table.elements,
        false => 0,
    };
    let characters = table.columns.iter().map(|column| column.characters).max();
    let columns = "choose columns with --columns, or --lists long, or --format csv, npz or mat";
    let rows = "choose --format csv, npz or mat";
    for (what, found, most, remedy) in [
        ("rows", table.rows.max(elements), MOST_ROWS, rows),
        (
            "columns",
            table.flat(lists).len() as u64,
            MOST_COLUMNS,
            columns,
        ),
        (
            "characters in a text",
            characters.unwrap_or(0) as u64,
            MOST_CHARACTERS,
            rows,
        ),
    ] {
        if found > most {
            return Err(ExportError::Worksheet {
                table: table.name(),
                what,
                found,
                most,
                remedy,
            });
        }
    }
    Ok(())
}

/// Writes tables, each admitted before.
pub fn write(
    folder: &Path,
    tables: &[Surveyed],
    lists: Lists,
    path: &Path,
) -> Result<(), ExportError> {
    let whole = WholeFile::create(path)?;
    let refused = |source| ExportError::Workbook {
        path: path.to_path_buf(),
        source,
    };
    let mut book = Workbook::new();
    let beside = path.parent().unwrap_or(Path::new("."));
    book.set_tempdir(beside).map_err(refused)?;
    for table in tables {
        let mut rows = Rows::new(&mut book, table.name(), path)?;
        write_table(folder, table, lists, &mut rows)?;
        if table.has_long_lists(lists) {
            let name = format!("{}_lists", table.name());
            write_lists(folder, table, &mut Rows::new(&mut book, &name, path)?)?;
        }
    }
    let mut rows = Rows::new(&mut book, COLUMNS, path)?;
    rows.row(&["table", "column", "unit", "description"].map(Cell::Text))?;
    for table in tables {
        for column in &table.columns {
            let head = &column.head;
            rows.row(&[table.name(), &head.name, &head.unit, &head.description].map(Cell::Text))?;
        }
    }
    let mut sink = BufWriter::new(whole.file());
    book.save_to_writer(&mut sink).map_err(refused)?;
    let flushed = sink.flush();
    flushed.map_err(|source| StoreError::io(path, "write", source))?;
    drop(sink);
    Ok(whole.publish()?)
}

/// The rows of a worksheet, from its head down.
struct Rows<'a> {
    sheet: &'a mut Worksheet,
    path: &'a Path,
    bold: Format,
    next: u32,
}

impl<'a> Rows<'a> {
    fn new(book: &'a mut Workbook, name: &str, path: &'a Path) -> Result<Self, ExportError> {
        let refused = |source| ExportError::Workbook {
            path: path.to_path_buf(),
            source,
        };
        let sheet = book.add_worksheet_with_constant_memory().map_err(refused)?;
        sheet
            .set_name(name)
            .and_then(|sheet| sheet.set_freeze_panes(1, 0))
            .map_err(refused)?;
        Ok(Self {
            sheet,
            path,
            bold: Format::new().set_bold(),
            next: 0,
        })
    }

    fn put(&mut self, row: u32, column: u16, cell: Cell<'_>) -> Result<(), XlsxError> {
        let head = row == 0;
        match cell {
            Cell::Absent => return Ok(()),
            Cell::Whole(value) => self.sheet.write_number(row, column, value as f64)?,
            Cell::Number(value) => self.sheet.write_number(row, column, value)?,
            Cell::Truth(value) => self.sheet.write_boolean(row, column, value)?,
            Cell::Text(text) if head => self
                .sheet
                .write_string_with_format(row, column, text, &self.bold)?,
            Cell::Text(text) => self.sheet.write_string(row, column, text)?,
        };
        Ok(())
    }
}

impl Sheet for Rows<'_> {
    fn row(&mut self, cells: &[Cell<'_>]) -> Result<(), ExportError> {
        let row = self.next;
        for (column, cell) in (0..).zip(cells) {
            self.put(row, column, *cell)
                .map_err(|source| ExportError::Workbook {
                    path: self.path.to_path_buf(),
                    source,
                })?;
        }
        self.next += 1;
        Ok(())
    }
}
