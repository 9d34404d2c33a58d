//! The periodic orbits, as text.

use crate::report::numbers::number;
use crate::report::orbits::Orbit;
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
        1..=MOST_LISTED => push_each(text, &found.orbits),
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

/// A line an orbit.
fn push_each(text: &mut String, orbits: &[Orbit]) {
    _ = writeln!(
        text,
        "\n  {:>6}  {:>6}  {:<8}  {:<19}  {:<7}  {:<23}  {:<14}  {:<10}  linear",
        "point",
        "period",
        "",
        "leading multiplier",
        "modulus",
        "crosses as",
        "grazing margin",
        "kick grows"
    );
    for orbit in orbits {
        let line = format!(
            "  {:>6}  {:>6}  {:<8}  {:<19}  {:<7}  {:<23}  {:<14}  {:<10}  {}",
            orbit.point_id,
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
