//! Data of drawn points: the row of the design of each point, and the method of the design, which is the metadata
//! `samples` of `points.parquet`.

use super::point_row::PointRow;
use super::table::{Column, columns};
use serde::{Deserialize, Serialize};

/// How the values of axes were drawn, as written to the files.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SampleColumns {
    /// Names of the axes that are distributions.
    pub axes: Vec<String>,
    /// `sobol` or `saltelli`.
    pub design: String,
    /// Number of samples of the sequence.
    pub samples: usize,
    /// Number of rows of the design.
    pub rows: usize,
    /// Number of consecutive points that share a row.
    pub stride: usize,
}

impl SampleColumns {
    /// The row of the design that a point uses.
    pub fn row(&self, point_id: u64) -> u64 {
        point_id / self.stride as u64 % self.rows as u64
    }
}

/// The column that holds the row number in the design.
pub(super) fn sample_columns(samples: &SampleColumns) -> Vec<Column<PointRow>> {
    let samples = samples.clone();
    columns![row: PointRow;
        u64 "sample", "1", samples.row(row.point_id),
            "Row of the design of the axes that are distributions, from 0";
    ]
}
