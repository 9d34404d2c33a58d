//! Data of a refined grid: the level of each point, and the method of refinement, which is the metadata `refined` of
//! `points.parquet`.

use super::point_row::PointRow;
use super::table::{Column, columns};
use crate::numerics::nested_grid::NestedGrid;
use serde::{Deserialize, Serialize};

/// How the grid of a job is refined, as written to its files.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct RefinedColumns {
    /// Numbering of the points.
    pub nested: NestedGrid,
    /// Names of the axes of rows and columns.
    pub axes: [String; 2],
    /// Criteria by which points are compared: `class, period`.
    pub by: String,
    /// Start of every point: `static`, `rest` or `modal`.
    pub start: String,
}

/// The level of a point.
pub(super) fn level_columns(nested: NestedGrid) -> Vec<Column<PointRow>> {
    columns![row: PointRow;
        u32 "level", "1", nested.level(row.point_id as usize),
            "Number of halvings of the grid's intervals that lead to this point; 0 for points of the undivided grid";
    ]
}
