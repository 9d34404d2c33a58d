//! The columns of `basins.parquet`.

use super::table::{Column, Table, Value};
use crate::analysis::{CellOutcome, Class};

/// A row of `basins.parquet`.
#[derive(Debug, Clone, PartialEq)]
pub struct CellRow {
    /// The point.
    pub point_id: u64,
    /// A cell of its slice.
    pub cell: CellOutcome,
}

/// Columns of `basins.parquet`.
pub fn basins_table() -> Table<CellRow> {
    let mut columns = place_columns();
    columns.extend(ending_columns());
    Table::new(columns)
}

fn place_columns() -> Vec<Column<CellRow>> {
    vec![
        Column::new(
            "point_id",
            "1",
            "Row-major index into the grid",
            Value::U64(Box::new(|row: &CellRow| Some(row.point_id))),
        ),
        Column::new(
            "i",
            "1",
            "Column of the cell in the slice, from 0 at the smallest x",
            Value::U32(Box::new(|row: &CellRow| Some(row.cell.column))),
        ),
        Column::new(
            "j",
            "1",
            "Row of the cell in the slice, from 0 at the smallest y",
            Value::U32(Box::new(|row: &CellRow| Some(row.cell.row))),
        ),
        Column::new(
            "x",
            "m",
            "Mesh deflection by the first mode at the cell's centre, from run.initial; for velocities, the one of equal energy",
            Value::F64(Box::new(|row: &CellRow| Some(row.cell.place[0]))),
        ),
        Column::new(
            "y",
            "m",
            "The same by the second mode",
            Value::F64(Box::new(|row: &CellRow| Some(row.cell.place[1]))),
        ),
    ]
}

fn ending_columns() -> Vec<Column<CellRow>> {
    vec![
        Column::new(
            "attractor_id",
            "1",
            "Attractor of the point, as in attractors.parquet; null where the motion settled on none",
            Value::U32(Box::new(|row: &CellRow| row.cell.attractor)),
        ),
        Column::new(
            "status",
            "",
            "How the motion ended: ok, not_converged, diverged, event_storm",
            Value::Text(Box::new(|row: &CellRow| Some(row.cell.status.name()))),
        ),
        Column::new(
            "class",
            "",
            "Kind of motion: locked, periodic, quasi_periodic, chaotic, not_converged",
            Value::Text(Box::new(|row: &CellRow| {
                row.cell.class.as_ref().map(Class::name)
            })),
        ),
        Column::new(
            "period",
            "mesh cycles",
            "Period of locked and periodic motion",
            Value::U32(Box::new(|row: &CellRow| row.cell.class.as_ref()?.period())),
        ),
        Column::new(
            "in_full",
            "",
            "Whether the motion was investigated like a probe; false where it was seen to approach a known orbit, or ended early",
            Value::Bool(Box::new(|row: &CellRow| Some(row.cell.in_full))),
        ),
        Column::new(
            "cycles",
            "mesh cycles",
            "Mesh cycles marched",
            Value::U64(Box::new(|row: &CellRow| Some(row.cell.cycles))),
        ),
    ]
}
