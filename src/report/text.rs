//! A [`Summary`] as text for a terminal.

use std::fmt::Write;

use super::coexistence;
use super::heat::heat_map;
use super::summary::{Axis, PointSummary, Summary};
use super::transitions;
use crate::input::printable;
use crate::store::RunState;

/// Rows of a table before it is cut short.
const MOST_ROWS: usize = 20;

/// How the text may look.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Style {
    /// Characters only.
    Plain,
    /// With ANSI escapes of the 256-colour palette.
    Colour,
}

/// The summary as text.
pub fn render(summary: &Summary, style: Style) -> String {
    let mut text = String::new();
    push_header(&mut text, summary);
    push_classes(&mut text, summary);
    let map = heat_map(summary, style);
    if !map.is_empty() {
        _ = write!(text, "\n{map}");
    }
    push_chaotic(&mut text, summary);
    push_twins(&mut text, summary);
    transitions::push(&mut text, summary);
    coexistence::push(&mut text, summary);
    push_energy(&mut text, summary);
    push_troubled(&mut text, summary);
    if !summary.warnings.is_empty() {
        text.push_str("\nwarnings\n");
        for warning in &summary.warnings {
            _ = writeln!(text, "  {warning}");
        }
    }
    text
}

fn push_header(text: &mut String, summary: &Summary) {
    let job = summary.job.as_deref().unwrap_or("job unknown");
    _ = writeln!(
        text,
        "{job}  ({})",
        printable(&summary.folder.display().to_string())
    );
    let statuses: Vec<String> = summary
        .statuses
        .iter()
        .map(|(status, count)| format!("{count} {status}"))
        .collect();
    _ = write!(text, "  {} points", summary.points);
    if !statuses.is_empty() {
        _ = write!(text, ": {}", statuses.join(", "));
    }
    text.push('\n');
    if let Some([found, expected]) = summary.shards {
        _ = writeln!(text, "  {found} of {expected} shards");
    }
    match summary.state {
        Some(RunState::Complete) => {}
        Some(RunState::Interrupted) => {
            let missing = summary.expected - summary.points as u64;
            let missing = if missing > 0 {
                format!("{missing} points are missing")
            } else {
                String::new()
            };
            let joint = if missing.is_empty() { "" } else { ": " };
            _ = writeln!(
                text,
                "  interrupted{joint}{missing}; the same `atlas run` goes on"
            );
        }
        None => {
            _ = writeln!(
                text,
                "  no run.json: the run has not ended, or the file was removed"
            )
        }
    }
    let mut parts = Vec::new();
    if let Some(wall_time) = summary.wall_time {
        parts.push(format!("{} s wall time", number(wall_time)));
    }
    parts.push(format!("{} mesh cycles integrated", summary.cycles));
    if let Some(time) = summary.wall_time_per_cycle {
        parts.push(format!("{} µs a cycle", number(1e6 * time)));
    }
    if let Some(time) = summary.worker_time_per_cycle {
        parts.push(format!("{} µs a cycle on one worker", number(1e6 * time)));
    }
    _ = writeln!(text, "  {}", parts.join(", "));
}

fn push_classes(text: &mut String, summary: &Summary) {
    if summary.classes.is_empty() {
        text.push_str("\nno point was computed\n");
        return;
    }
    text.push_str("\nkind of motion\n");
    for count in &summary.classes {
        let class = match (count.class.as_str(), count.period) {
            ("none", _) => "not classified".into(),
            (_, Some(period)) => format!("period {period}"),
            (class, None) => class.replace('_', " "),
        };
        _ = writeln!(text, "  {class:<24}{:>6}", count.points);
    }
}

fn push_chaotic(text: &mut String, summary: &Summary) {
    if summary.with_exponent == 0 {
        text.push_str("\nno Lyapunov exponents in these results\n");
        return;
    }
    if summary.chaotic.is_empty() {
        text.push_str("\nno chaotic point\n");
        return;
    }
    text.push_str("\nchaotic points, λ in 1/cycle\n");
    push_table(
        text,
        summary,
        &summary.chaotic,
        summary.chaotic_points,
        |point| {
            let mut cell = exponent(point);
            if point.twin_agrees == Some(false) {
                cell.push_str("  twin disagrees");
            }
            cell
        },
    );
}

fn push_twins(text: &mut String, summary: &Summary) {
    let (disagree, compared) = (summary.twin_disagrees_points, summary.with_twin);
    if compared == 0 {
        return;
    }
    _ = writeln!(
        text,
        "\ntwin trajectories: {disagree} of {compared} disagree with the tangents"
    );
    if disagree > 0 {
        push_table(text, summary, &summary.twin_disagrees, disagree, |point| {
            let twin = point.twin.map_or_else(|| "none".into(), number);
            format!("{}, twin {twin}", exponent(point))
        });
    }
}

fn push_energy(text: &mut String, summary: &Summary) {
    if let Some((point_id, residual)) = summary.worst_energy {
        _ = writeln!(
            text,
            "\nworst energy residual {residual:.1e} (point {point_id})"
        );
    }
}

fn push_troubled(text: &mut String, summary: &Summary) {
    if summary.troubled.is_empty() {
        return;
    }
    text.push_str("\npoints that are not ok\n");
    push_table(
        text,
        summary,
        &summary.troubled,
        summary.troubled_points,
        |point| format!("{}: {}", point.status, point.reason),
    );
}

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

/// λ with its standard error, to the digits that the error supports.
fn exponent(point: &PointSummary) -> String {
    match (point.lambda, point.stderr) {
        (Some(lambda), Some(stderr)) if stderr > 0.0 => {
            // Two digits of the error.
            let digits = (1.0 - stderr.log10().floor()).clamp(0.0, 12.0) as usize;
            format!("λ = {lambda:.digits$} ± {stderr:.digits$}")
        }
        (Some(lambda), _) => format!("λ = {}", number(lambda)),
        (None, _) => "λ unknown".into(),
    }
}

/// `speed [rad/s]`; no unit when dimensionless.
pub(super) fn label(axis: &Axis) -> String {
    match axis.unit.as_str() {
        "" | "1" => axis.name.clone(),
        unit => format!("{} [{unit}]", axis.name),
    }
}

/// Four significant digits, and all of those before the point, without needless zeros.
pub(super) fn number(value: f64) -> String {
    let before_point = value.abs().log10().floor() + 1.0;
    match (4.0..=6.0).contains(&before_point) {
        true => to_digits(value, before_point as usize),
        false => to_digits(value, 4),
    }
}

/// So many significant digits, without needless zeros: `0.05`, `4.4e8`.
pub fn to_digits(value: f64, digits: usize) -> String {
    let rounded = format!("{value:.*e}", digits.saturating_sub(1)).parse();
    let rounded: f64 = rounded.unwrap_or(value);
    match rounded == 0.0 || (1e-3..1e6).contains(&rounded.abs()) {
        true => format!("{}", rounded + 0.0),
        false => format!("{rounded:e}"),
    }
}

#[cfg(test)]
mod tests;
