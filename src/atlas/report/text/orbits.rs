//! The periodic orbits, as text.

use super::table::{place_words, with_unit};
use crate::report::numbers::{number, plural};
use crate::report::orbits::{Orbit, OrbitCount};
use crate::report::point::{PointSummary, varied};
use crate::report::summary::Summary;
use std::collections::BTreeSet;
use std::fmt::Write;

/// Largest number of orbits that are listed one by one; if there are more, only the counts are shown.
const MOST_LISTED: usize = 40;

/// Largest number of listed states without an orbit.
const MOST_MISSED: usize = 20;

/// Appends counts by period, the orbits if they are few, and the given states that led to no orbit.
pub(super) fn push(text: &mut String, summary: &Summary) {
    let Some(found) = &summary.orbits else {
        return;
    };
    if found.orbits.is_empty() {
        text.push_str("\nno periodic orbit was found\n");
    } else {
        _ = writeln!(
            text,
            "\nperiodic orbits, at {}",
            plural(found.points, "point")
        );
        _ = writeln!(
            text,
            "  {:>6}  {:<8}  {:>6}  {:>6}  {:<18}  {:<14}  {:<16}  where",
            "period",
            "",
            "orbits",
            "points",
            "leading modulus",
            "grazing margin",
            "kick over linear"
        );
    }
    for count in &found.periods {
        let [least, greatest] = count.modulus.map(number);
        let modulus = if least == greatest { least } else { format!("{least} … {greatest}") };
        let line = format!(
            "  {:>6}  {:<8}  {:>6}  {:>6}  {modulus:<18}  {:<14}  {:<16}  {}",
            count.period,
            stability(count.stable),
            count.orbits,
            count.points,
            cell(count.grazing_margin),
            cell(count.kick_over_linear),
            place(summary, &found.orbits, count)
        );
        _ = writeln!(text, "{}", line.trim_end());
    }
    match found.orbits.len() {
        0 => {}
        1..=MOST_LISTED => push_each(text, summary, &found.orbits),
        _ => text.push_str("  orbits.parquet and `atlas show --json` list every orbit\n"),
    }
    if found.missed.is_empty() {
        return;
    }
    text.push_str("\nsearches from given states that found no orbit\n");
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

fn stability(stable: bool) -> &'static str {
    if stable { "stable" } else { "unstable" }
}

/// Axis values of the orbits of a period: `load 0.05, speed 900 … 1200 rad/s`, for the axes with several values.
fn place(summary: &Summary, orbits: &[Orbit], count: &OrbitCount) -> String {
    let same_kind = |orbit: &&Orbit| orbit.period == count.period && orbit.stable == count.stable;
    let ids: BTreeSet<u64> = orbits
        .iter()
        .filter(same_kind)
        .map(|orbit| orbit.point_id)
        .collect();
    let points = summary
        .all
        .iter()
        .filter(|point| ids.contains(&point.point_id));
    let points: Vec<&PointSummary> = points.collect();
    let words = varied(&summary.axes).filter_map(|index| {
        let axis = &summary.axes[index];
        let values = || points.iter().map(|point| point.axis_values[index]);
        let [low, high] = [values().reduce(f64::min)?, values().reduce(f64::max)?].map(number);
        let span = if low == high { low } else { format!("{low} … {high}") };
        Some(with_unit(&format!("{} {span}", axis.name), &axis.unit))
    });
    words.collect::<Vec<_>>().join(", ")
}

fn cell(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), number)
}

/// Appends the orbits of each point, one line per orbit.
fn push_each(text: &mut String, summary: &Summary, orbits: &[Orbit]) {
    _ = writeln!(
        text,
        "\n  {:>6}  {:<8}  {:<19}  {:<7}  {:<23}  {:<14}  {:<10}  linear",
        "period", "", "leading multiplier", "modulus", "crosses as", "grazing margin", "kick grows"
    );
    for of_point in orbits.chunk_by(|a, b| a.point_id == b.point_id) {
        let known = |point: &&PointSummary| point.point_id == of_point[0].point_id;
        if let Some(point) = summary.all.iter().find(known) {
            _ = writeln!(text, "  point {}", point_words(summary, point));
        }
        for orbit in of_point {
            let line = format!(
                "  {:>6}  {:<8}  {:<19}  {:<7}  {:<23}  {:<14}  {:<10}  {}",
                orbit.period,
                stability(orbit.stable),
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

/// A point in words: `3: load 0.05, speed 1200 rad/s, sweep up`.
fn point_words(summary: &Summary, point: &PointSummary) -> String {
    let place = place_words(summary, varied(&summary.axes), &point.axis_values);
    let sweep = point.direction.iter().map(|way| format!("sweep {way}"));
    let parts = Some(place)
        .into_iter()
        .filter(|place| !place.is_empty())
        .chain(sweep);
    let parts: Vec<String> = parts.collect();
    if parts.is_empty() {
        point.point_id.to_string()
    } else {
        format!("{}: {}", point.point_id, parts.join(", "))
    }
}
