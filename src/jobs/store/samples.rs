//! What tells the points of drawn values apart: their row of the design, and how the design was made, which stands in
//! the metadata of `points.parquet` as `samples`.

use super::point_row::PointRow;
use super::table::{Column, columns};
use serde::{Deserialize, Serialize};

/// How the values of axes were drawn, as far as the files tell.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SampleColumns {
    /// Names of the axes that are distributions.
    pub axes: Vec<String>,
    /// `sobol` or `saltelli`.
    pub design: String,
    /// Samples of the sequence.
    pub samples: usize,
    /// Rows of the design.
    pub rows: usize,
    /// Points with numbers one after the other that share a row.
    pub stride: usize,
}

impl SampleColumns {
    /// The row of a point.
    pub fn row(&self, point_id: u64) -> u64 {
        point_id / self.stride as u64 % self.rows as u64
    }
}

/// The column of the rows.
pub(super) fn sample_columns(samples: &SampleColumns) -> Vec<Column<PointRow>> {
    let samples = samples.clone();
    columns![row: PointRow;
        u64 "sample", "1", samples.row(row.point_id),
            "Row of the design of the axes that are distributions, from 0";
    ]
}
