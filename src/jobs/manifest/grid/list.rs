//! `grid.points`: a list of operating points, in the manifest or in a file. Its columns are tied axes.

use super::axis_key::path_of;
use super::grid_axis::GridAxis;
use super::values::{AxisReader, Spans};
use crate::manifest::axis::{AxisKey, AxisValues};
use crate::manifest::columns::{self, Column};
use crate::manifest::csv::ListOf;
use crate::manifest::diagnostic::Issues;
use crate::manifest::reader::{Section, all_or_none};
use crate::units::Dimension;
use std::path::Path;

const POINTS: ListOf = ListOf {
    path: "grid.points",
    row: "{ load = 0.1, speed = \"1000 rpm\" }",
    header: "speed [rpm],torque [N m]",
};

/// The axes from a list of points.
#[derive(Debug, Default)]
pub(super) struct List {
    /// The columns as axes; all are tied.
    pub axes: Vec<GridAxis>,
    /// Names of faulty columns.
    pub faulty: Vec<String>,
    /// Whether the list cannot be read, so that its columns are unknown.
    pub unknown: bool,
}

/// The list, if there is one.
pub(super) fn read(section: &Section, base_dir: &Path) -> Option<List> {
    let entry = section.entry("points")?;
    let columns = columns::read(section.issues, entry, &POINTS, base_dir);
    let Some(columns) = columns else {
        return Some(List {
            unknown: true,
            ..List::default()
        });
    };
    let mut list = List::default();
    for column in columns {
        match axis(section.issues, &column) {
            Some(axis) => list.axes.push(axis),
            None => list.faulty.push(column.name.key.clone()),
        }
    }
    Some(list)
}

fn axis(issues: &Issues, column: &Column) -> Option<GridAxis> {
    let name = column.name.key.as_str();
    let path = path_of(name);
    let mut reader = AxisReader::of(issues, &column.name, &path)?;
    column
        .unit_fits(issues, &path, reader.dimension)
        .then_some(())?;
    let values = all_or_none((column.values.iter()).map(|value| reader.value(value, &path)))?;
    let spans = Spans::Each(column.values.iter().map(|value| value.span).collect());
    let dimension = reader.dimension.unwrap_or(Dimension::Ratio);
    let values = (AxisValues::each(values), spans);
    let (key, key_span) = (AxisKey::of(name), column.name.key_span);
    Some(GridAxis::new(key, key_span, dimension, values))
}
