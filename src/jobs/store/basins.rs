//! The columns of `basins.parquet`.

use super::file::Row;
use super::point_row::PointRow;
use super::table::{Table, columns};
use crate::analysis::{CellOutcome, Class};

/// A row of `basins.parquet`.
#[derive(Debug, Clone, PartialEq)]
pub struct CellRow {
    /// The point.
    pub point_id: u64,
    /// A cell of the point's slice.
    pub cell: CellOutcome,
}

impl Row for CellRow {}

/// Takes the rows of a point.
pub(super) fn cell_rows(point: &mut PointRow) -> Vec<CellRow> {
    let found = point.multistability.as_mut();
    let cells = found.map_or(Vec::new(), |found| std::mem::take(&mut found.cells));
    let point_id = point.point_id;
    (cells.into_iter())
        .map(|cell| CellRow { point_id, cell })
        .collect()
}

/// Columns of `basins.parquet`.
pub fn basins_table() -> Table<CellRow> {
    Table::new(columns![row: CellRow;
        u64 "point_id", "1", row.point_id, "Row-major index into the grid";
        u32 "i", "1", row.cell.column, "Column of the cell in the slice, from 0 at the smallest x";
        u32 "j", "1", row.cell.row, "Row of the cell in the slice, from 0 at the smallest y";
        f64 "x", "m", row.cell.place[0],
            "Mesh deflection by the first mode at the centre of the cell, relative to run.initial; for \
             velocities, the deflection of equal energy";
        f64 "y", "m (m/s in a phase plane)", row.cell.place[1],
            "Mesh deflection by the second mode, measured like x; in a phase plane, the rate of mesh deflection by the same mode";
        u32 "attractor_id", "1", row.cell.attractor,
            "Attractor of the point, as in attractors.parquet; null if the motion settled on none";
        text "status", "", row.cell.status.name(),
            "Status of the cell: ok, not_converged, diverged, event_storm";
        text "class", "", row.cell.class.as_ref().map(Class::name),
            "Class of motion: steady_contact, periodic, quasi_periodic, chaotic, not_converged";
        u32 "period", "mesh cycles", row.cell.class.as_ref()?.period(),
            "Period of steady_contact and periodic motion";
        bool "in_full", "", row.cell.in_full,
            "Whether the motion was measured like a probe; false if it approached a known orbit or ended early";
        u64 "cycles", "mesh cycles", row.cell.cycles, "Mesh cycles integrated";
    ])
}
