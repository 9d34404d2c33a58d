//! A table of points.

use crate::report::numbers::number;
use crate::report::point::{Axis, PointSummary};
use crate::report::summary::Summary;
use std::fmt::Write;

/// Rows of a table before it is cut short.
const MOST_ROWS: usize = 20;

/// A table of the first of `count` points: id, axis values and one more cell.
pub(super) fn push_table(
    text: &mut String,
    summary: &Summary,
    points: &[PointSummary],
    count: usize,
    cell: impl Fn(&PointSummary) -> String,
) {
    let headings: Vec<String> = summary.axes.iter().map(label).collect();
    _ = write!(text, "  {:>6}", "point");
    for heading in &headings {
        _ = write!(text, "  {heading:>10}");
    }
    if summary.carried_along.is_some() {
        text.push_str("  sweep");
    }
    text.push('\n');
    for point in points.iter().take(MOST_ROWS) {
        _ = write!(text, "  {:>6}", point.point_id);
        for (value, heading) in point.axis_values.iter().zip(&headings) {
            let width = heading.chars().count().max(10);
            _ = write!(text, "  {:>width$}", number(*value));
        }
        if let Some(direction) = &point.direction {
            _ = write!(text, "  {direction:<5}");
        }
        _ = writeln!(text, "  {}", cell(point));
    }
    if count > MOST_ROWS {
        _ = writeln!(text, "  … and {} more", count - MOST_ROWS);
    }
}

/// `speed [rad/s]`; no unit when dimensionless.
pub(super) fn label(axis: &Axis) -> String {
    match axis.unit.as_str() {
        "" | "1" => axis.name.clone(),
        unit => format!("{} [{unit}]", axis.name),
    }
}
