//! The periodic orbits, as text.

use crate::report::numbers::number;
use crate::report::orbits::Orbit;
use crate::report::point::PointSummary;
use crate::report::summary::Summary;
use std::fmt::Write;

/// Orbits that are listed one by one; of more only the counts are shown.
const MOST_LISTED: usize = 40;

/// Given states without an orbit that are listed.
const MOST_MISSED: usize = 20;

/// Counts by period, the orbits where they are few, and given states that led to none.
pub(super) fn push(text: &mut String, summary: &Summary) {
    let Some(found) = &summary.orbits else {
        return;
    };
    if found.orbits.is_empty() {
        text.push_str("\nno periodic orbit was found\n");
    } else {
        _ = writeln!(text, "\nperiodic orbits, at {} points", found.points);
        _ = writeln!(
            text,
            "  {:>6}  {:>6}  {:>6}  {:>6}  {:<18}  {:<14}  kick over linear",
            "period", "orbits", "points", "stable", "leading modulus", "grazing margin"
        );
    }
    for count in &found.periods {
        let [least, greatest] = count.modulus.map(number);
        let modulus = match least == greatest {
            true => least,
            false => format!("{least} … {greatest}"),
        };
        let line = format!(
            "  {:>6}  {:>6}  {:>6}  {:>6}  {modulus:<18}  {:<14}  {}",
            count.period,
            count.orbits,
            count.points,
            count.stable,
            cell(count.grazing_margin),
            cell(count.kick_over_linear)
        );
        _ = writeln!(text, "{}", line.trim_end());
    }
    match found.orbits.len() {
        0 => {}
        1..=MOST_LISTED => push_each(text, summary, &found.orbits),
        _ => text.push_str("  orbits.parquet and `atlas show --json` list them one by one\n"),
    }
    if found.missed.is_empty() {
        return;
    }
    text.push_str("\nsearches from given states that led to no orbit\n");
    _ = writeln!(text, "  {:>6}  {:>6}  {:>6}", "point", "state", "period");
    for missed in found.missed.iter().take(MOST_MISSED) {
        _ = writeln!(
            text,
            "  {:>6}  {:>6}  {:>6}  {}",
            missed.point_id, missed.state, missed.period, missed.reason
        );
    }
    if found.missed.len() > MOST_MISSED {
        _ = writeln!(text, "  … and {} more", found.missed.len() - MOST_MISSED);
    }
}

fn cell(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), number)
}

/// The points with their orbits, a line each.
fn push_each(text: &mut String, summary: &Summary, orbits: &[Orbit]) {
    _ = writeln!(
        text,
        "\n  {:>6}  {:<8}  {:<19}  {:<7}  {:<23}  {:<14}  {:<10}  linear",
        "period", "", "leading multiplier", "modulus", "crosses as", "grazing margin", "kick grows"
    );
    for of_point in orbits.chunk_by(|a, b| a.point_id == b.point_id) {
        let known = |point: &&PointSummary| point.point_id == of_point[0].point_id;
        if let Some(point) = summary.all.iter().find(known) {
            _ = writeln!(text, "  point {}", words(summary, point));
        }
        for orbit in of_point {
            let line = format!(
                "  {:>6}  {:<8}  {:<19}  {:<7}  {:<23}  {:<14}  {:<10}  {}",
                orbit.period,
                if orbit.stable { "stable" } else { "unstable" },
                orbit.leading_words(),
                number(orbit.modulus),
                orbit.crossing_words(),
                cell(orbit.grazing_margin),
                cell(orbit.kick_growth),
                cell(orbit.kick_growth_linear)
            );
            _ = writeln!(text, "{}", line.trim_end());
        }
    }
}

/// `3: load 0.05, speed 1200 rad/s, sweep up`.
fn words(summary: &Summary, point: &PointSummary) -> String {
    let values = summary.axes.iter().zip(&point.axis_values);
    let values = values.map(|(axis, value)| match axis.unit.as_str() {
        "" | "1" => format!("{} {}", axis.name, number(*value)),
        unit => format!("{} {} {unit}", axis.name, number(*value)),
    });
    let sweep = point.direction.iter().map(|way| format!("sweep {way}"));
    let parts: Vec<String> = values.chain(sweep).collect();
    format!("{}: {}", point.point_id, parts.join(", "))
}
