//! Tables as rows of single values: what CSV files and worksheets hold.

use super::cells::Cell;
use super::error::ExportError;
use super::format::Lists;
use super::survey::Surveyed;
use std::path::Path;

/// Takes the rows of a table.
pub trait Sheet {
    /// Takes a row.
    ///
    /// # Errors
    /// It cannot be written.
    fn row(&mut self, cells: &[Cell<'_>]) -> Result<(), ExportError>;
}

/// Head and rows of a table, its lists widened or left out.
pub fn write_table<S: Sheet>(
    folder: &Path,
    table: &Surveyed,
    lists: Lists,
    sheet: &mut S,
) -> Result<(), ExportError> {
    let flat = table.flat(lists);
    let head: Vec<Cell<'_>> = flat.iter().map(|flat| Cell::Text(&flat.title)).collect();
    sheet.row(&head)?;
    table.scan(folder, |columns| {
        for row in 0..columns.first().map_or(0, |cells| cells.rows()) {
            let cells = flat
                .iter()
                .map(|flat| columns[flat.column].at(row, flat.place));
            sheet.row(&cells.collect::<Vec<_>>())?;
        }
        Ok(())
    })
}

/// The lists of a table with a row an element: row of the table and place in the list, counted from 1.
pub fn write_lists<S: Sheet>(
    folder: &Path,
    table: &Surveyed,
    sheet: &mut S,
) -> Result<(), ExportError> {
    let point = table
        .columns
        .iter()
        .position(|column| column.head.name == "point_id");
    let head = [
        "row", "point_id", "column", "unit", "element", "name", "value",
    ]
    .map(Cell::Text);
    // Without `point_id` where the table has none.
    let shown = move |place: usize| point.is_some() || place != 1;
    sheet.row(&kept(&head, shown))?;
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
                    sheet.row(&kept(&cells, shown))?;
                }
            }
        }
        before += rows as u64;
        Ok(())
    })
}

fn kept<'a>(cells: &[Cell<'a>], shown: impl Fn(usize) -> bool) -> Vec<Cell<'a>> {
    let each = cells.iter().enumerate();
    each.filter(|(place, _)| shown(*place))
        .map(|(_, cell)| *cell)
        .collect()
}
