//! What tells the points of a refined grid apart from those of a full one: their level, and how the
//! grid was refined, which stands in the metadata of `points.parquet` as `refined`.

use super::point_row::PointRow;
use super::table::{Column, columns};
use crate::numerics::nested_grid::NestedGrid;
use serde::{Deserialize, Serialize};

/// How the grid of a job is refined, as far as its files tell.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct RefinedColumns {
    /// Numbers the points.
    pub nested: NestedGrid,
    /// Names of the axes that rows and columns go along.
    pub axes: [String; 2],
    /// What corners of cells were compared by: `class, period`.
    pub by: String,
    /// Where every point starts: `static`, `rest` or `modal`.
    pub start: String,
}

/// The level of a point.
pub(super) fn level_columns(nested: NestedGrid) -> Vec<Column<PointRow>> {
    columns![row: PointRow;
        u32 "level", "1", nested.level(row.point_id as usize),
            "Number of halvings of the grid's intervals that lead to this point; 0 for points of the undivided grid";
    ]
}
