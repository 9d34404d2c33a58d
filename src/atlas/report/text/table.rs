//! A table of points.

use crate::report::numbers::number;
use crate::report::point::{Axis, PointSummary, varied};
use crate::report::summary::Summary;
use std::fmt::Write;

/// Largest number of rows in a table.
const MOST_ROWS: usize = 20;

/// Appends a table of the first of `count` points: number, values of the axes with several values, direction
/// of the sweep, and the text of `cell`.
pub(super) fn push_table(
    text: &mut String,
    summary: &Summary,
    points: &[PointSummary],
    count: usize,
    cell: impl Fn(&PointSummary) -> String,
) {
    let varied: Vec<usize> = varied(&summary.axes).collect();
    let headings = varied.iter().map(|axis| label(&summary.axes[*axis]));
    let headings: Vec<String> = headings.collect();
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
        for (axis, heading) in varied.iter().zip(&headings) {
            let width = heading.chars().count().max(10);
            _ = write!(text, "  {:>width$}", number(point.axis_values[*axis]));
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

/// Values of some axes as text: `load 0.1, speed 1200 rad/s`. `values` has one value per axis of the summary.
pub(super) fn place_words(
    summary: &Summary,
    axes: impl Iterator<Item = usize>,
    values: &[f64],
) -> String {
    let words = axes.filter_map(|index| {
        let (axis, value) = (&summary.axes[index], number(*values.get(index)?));
        Some(with_unit(&format!("{} {value}", axis.name), &axis.unit))
    });
    words.collect::<Vec<_>>().join(", ")
}

/// A text followed by its unit; without a unit if dimensionless.
pub(super) fn with_unit(words: &str, unit: &str) -> String {
    match unit {
        "" | "1" => words.to_owned(),
        unit => format!("{words} {unit}"),
    }
}

/// `speed [rad/s]`; without a unit if dimensionless.
pub(super) fn label(axis: &Axis) -> String {
    match axis.unit.as_str() {
        "" | "1" => axis.name.clone(),
        unit => format!("{} [{unit}]", axis.name),
    }
}
