//! The columns of `point_levels.parquet`.

use super::PointRow;
use super::file::Row;
use super::table::{Table, columns};

/// A row of the table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointLevelRow {
    /// The point.
    pub point_id: u64,
    /// Standard deviation of the mesh force \[N\].
    pub force_std: f64,
}

impl Row for PointLevelRow {}

/// Takes the rows of a point.
pub(super) fn point_level_rows(point: &mut PointRow) -> Vec<PointLevelRow> {
    let point_id = point.point_id;
    let nvh = point.outcome.nvh.as_ref();
    let row = |force_std| PointLevelRow {
        point_id,
        force_std,
    };
    nvh.map(|nvh| row(nvh.force_std)).into_iter().collect()
}

/// Columns of the table.
pub fn point_levels_table() -> Table<PointLevelRow> {
    Table::new(columns![row: PointLevelRow;
        u64 "point_id", "1", row.point_id, "Row-major index into the grid";
        f64 "force_std", "N", row.force_std, "Standard deviation of the mesh force";
    ])
}
