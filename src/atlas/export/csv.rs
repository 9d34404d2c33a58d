//! CSV files (RFC 4180) in UTF-8, with line feeds.
//!
//! A number has the shortest text from which a program reads the same bits. An absent value is an empty
//! field, and an empty text is `""`.

use super::cells::Cell;
use super::error::ExportError;
use super::format::Lists;
use super::survey::Surveyed;
use crate::store::{AtomicFile, StoreError};
use rayon::prelude::*;
use std::fmt::Write as _;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Rows that one thread formats at a time.
const ROWS_TOGETHER: usize = 256;

/// Writes a table to `path`. Its lists become one column per element ([`Lists::Wide`]), or are left out
/// ([`Lists::Long`]).
pub fn table(
    folder: &Path,
    table: &Surveyed,
    lists: Lists,
    path: &Path,
) -> Result<(), ExportError> {
    written(path, |sheet| write_table(folder, table, lists, sheet))
}

/// Writes the lists of a table to `path`, one line per element.
pub fn lists(folder: &Path, table: &Surveyed, path: &Path) -> Result<(), ExportError> {
    written(path, |sheet| write_lists(folder, table, sheet))
}

fn written(
    path: &Path,
    rows: impl FnOnce(&mut Lines<'_, BufWriter<&std::fs::File>>) -> Result<(), ExportError>,
) -> Result<(), ExportError> {
    let file = AtomicFile::create(path)?;
    let sink = BufWriter::with_capacity(1 << 20, file.file());
    let mut lines = Lines { sink, path };
    rows(&mut lines)?;
    let flushed = lines.sink.flush();
    flushed.map_err(|source| StoreError::io(path, "write", source))?;
    drop(lines);
    Ok(file.publish()?)
}

struct Lines<'a, W> {
    sink: W,
    path: &'a Path,
}

impl<W: Write> Lines<'_, W> {
    fn row(&mut self, cells: &[Cell<'_>]) -> Result<(), ExportError> {
        let mut line = String::new();
        push_row(&mut line, cells.iter().copied());
        self.write(&line)
    }

    fn write(&mut self, lines: &str) -> Result<(), ExportError> {
        let written = self.sink.write_all(lines.as_bytes());
        Ok(written.map_err(|source| StoreError::io(self.path, "write", source))?)
    }
}

/// Writes the line of titles and the rows of a table.
fn write_table<W: Write>(
    folder: &Path,
    table: &Surveyed,
    lists: Lists,
    sheet: &mut Lines<'_, W>,
) -> Result<(), ExportError> {
    let flat = table.flat(lists);
    let head: Vec<Cell<'_>> = flat.iter().map(|flat| Cell::Text(&flat.title)).collect();
    sheet.row(&head)?;
    table.scan(folder, |columns| {
        let rows: Vec<usize> = (0..columns.first().map_or(0, |cells| cells.rows())).collect();
        let pieces: Vec<String> = (rows.par_chunks(ROWS_TOGETHER))
            .map(|rows| {
                let mut lines = String::new();
                for &row in rows {
                    let cells = (flat.iter()).map(|flat| columns[flat.column].at(row, flat.place));
                    push_row(&mut lines, cells);
                }
                lines
            })
            .collect();
        pieces.iter().try_for_each(|lines| sheet.write(lines))
    })
}

/// Writes the lists of a table, one line per element. The columns `row` and `element` are the row of the
/// table and the position in the list, both counted from 1.
fn write_lists<W: Write>(
    folder: &Path,
    table: &Surveyed,
    sheet: &mut Lines<'_, W>,
) -> Result<(), ExportError> {
    let point = table
        .columns
        .iter()
        .position(|column| column.head.name == "point_id");
    let head = [
        "row", "point_id", "column", "unit", "element", "name", "value",
    ]
    .map(Cell::Text);
    // The second column, `point_id`, is omitted if the table has none.
    let next = if point.is_some() { 1 } else { 2 };
    sheet.row(&[&head[..1], &head[next..]].concat())?;
    let mut before = 0;
    table.scan(folder, |columns| {
        let rows = columns.first().map_or(0, |cells| cells.rows());
        for row in 0..rows {
            for (column, cells) in table.columns.iter().zip(&columns) {
                if !column.is_list() {
                    continue;
                }
                for place in 0..cells.length(row) {
                    let name = column.elements().get(place);
                    let cells = [
                        Cell::Whole(before + row as u64 + 1),
                        point.map_or(Cell::Absent, |point| columns[point].at(row, 0)),
                        Cell::Text(&column.head.name),
                        Cell::Text(&column.head.unit),
                        Cell::Whole(place as u64 + 1),
                        name.map_or(Cell::Absent, |name| Cell::Text(name)),
                        cells.at(row, place),
                    ];
                    sheet.row(&[&cells[..1], &cells[next..]].concat())?;
                }
            }
        }
        before += rows as u64;
        Ok(())
    })
}

fn push_row<'a>(line: &mut String, cells: impl Iterator<Item = Cell<'a>>) {
    for (place, cell) in cells.enumerate() {
        if place > 0 {
            line.push(',');
        }
        push(line, cell);
    }
    line.push('\n');
}

fn push(line: &mut String, cell: Cell<'_>) {
    // Writing to a string cannot fail.
    _ = match cell {
        Cell::Absent => Ok(()),
        Cell::Whole(value) => write!(line, "{value}"),
        // The text has an exponent if the number is very large or very small.
        Cell::Number(value) => line.write_str(zmij::Buffer::new().format(value)),
        Cell::Truth(value) => write!(line, "{value}"),
        Cell::Text(text) if is_plain(text) => write!(line, "{text}"),
        Cell::Text(text) => write!(line, "\"{}\"", text.replace('"', "\"\"")),
    };
}

/// Whether a text needs no quotes.
fn is_plain(text: &str) -> bool {
    !text.is_empty() && text.trim() == text && !text.contains(['"', ',', '\n', '\r'])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(cells: &[Cell<'_>]) -> String {
        let mut lines = Lines {
            sink: Vec::new(),
            path: Path::new(""),
        };
        lines.row(cells).unwrap();
        String::from_utf8(lines.sink).unwrap()
    }

    #[test]
    fn fields_are_told_apart() {
        let cells = [
            Cell::Text("a, \"b\""),
            Cell::Absent,
            Cell::Text(""),
            Cell::Text("x y"),
            Cell::Truth(true),
        ];
        assert_eq!(line(&cells), "\"a, \"\"b\"\"\",,\"\",x y,true\n");
        assert_eq!(
            line(&[Cell::Text(" x"), Cell::Text("a\nb")]),
            "\" x\",\"a\nb\"\n"
        );
    }

    #[test]
    fn numbers_read_back_bit_for_bit() {
        for value in [
            0.1 + 0.2,
            -0.0,
            5e-324,
            f64::MAX,
            1e22,
            1.5e-5,
            123_456.0,
            f64::EPSILON,
        ] {
            let text = line(&[Cell::Number(value)]);
            let back: f64 = text.trim().parse().unwrap();
            assert_eq!(back.to_bits(), value.to_bits(), "{text}");
        }
        assert_eq!(
            line(&[Cell::Number(1.5e-15), Cell::Whole(u64::MAX)]),
            "1.5e-15,18446744073709551615\n"
        );
    }
}
