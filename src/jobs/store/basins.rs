//! The columns of `basins.parquet`.

use super::point_row::{PointRow, ResultOfPoint};
use super::table::{Table, columns};
use crate::analysis::{CellOutcome, Class};

/// Takes the rows of a point.
pub(super) fn cell_rows(point: &mut PointRow) -> Vec<ResultOfPoint<CellOutcome>> {
    let outcomes = point.multistability.iter_mut();
    let cells = outcomes.flat_map(|outcome| std::mem::take(&mut outcome.cells));
    ResultOfPoint::all(point.point_id, cells)
}

/// Columns of `basins.parquet`.
pub fn basins_table() -> Table<ResultOfPoint<CellOutcome>> {
    Table::new(columns![row: ResultOfPoint<CellOutcome>;
        u64 "point_id", "1", row.point_id, "Row-major index into the grid";
        u32 "i", "1", row.result.column, "Column of the cell in the slice, from 0 at the smallest x";
        u32 "j", "1", row.result.row, "Row of the cell in the slice, from 0 at the smallest y";
        f64 "x", "m", row.result.place[0],
            "Mesh deflection by the first mode at the centre of the cell, relative to run.initial; for \
             velocities, the deflection of equal energy";
        f64 "y", "m (m/s in a phase plane)", row.result.place[1],
            "Mesh deflection by the second mode, measured like x; in a phase plane, the rate of mesh deflection by the same mode";
        u32 "attractor_id", "1", row.result.attractor,
            "Attractor of the point, as in attractors.parquet; null if the motion settled on none";
        text "status", "", row.result.status.name(),
            "Status of the cell: ok, not_converged, diverged, event_storm";
        text "class", "", row.result.class.as_ref().map(Class::name),
            "Class of motion: steady_contact, periodic, quasi_periodic, chaotic, not_converged";
        u32 "period", "mesh cycles", row.result.class.as_ref()?.period(),
            "Period of steady_contact and periodic motion";
        bool "in_full", "", row.result.in_full,
            "Whether the motion was measured like a probe; false if it approached a known orbit or ended early";
        u64 "cycles", "mesh cycles", row.result.cycles, "Mesh cycles integrated";
    ])
}
