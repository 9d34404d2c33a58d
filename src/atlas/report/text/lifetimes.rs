//! The lifetimes of chaos, as text.

use super::table::push_table;
use crate::report::numbers::{number, plural};
use crate::report::point::ChaosLife;
use crate::report::summary::Summary;
use std::fmt::Write;

/// Appends one sentence for the points at which no trajectory left chaos, one for those at which all did, and
/// one with a table for those at which some did.
pub(super) fn push(text: &mut String, summary: &Summary) {
    let lifetimes = &summary.lifetimes;
    if lifetimes.lasting.points + lifetimes.transient_points + lifetimes.left.points == 0 {
        return;
    }
    text.push_str("\nlife of chaos, in mesh cycles\n");
    if let Some(bounds) = lifetimes.lasting.range {
        _ = writeln!(
            text,
            "  {}: no trajectory left chaos; its mean life is at least {} (95 %)",
            plural(lifetimes.lasting.points, "point"),
            span(bounds)
        );
    }
    if let Some(lives) = lifetimes.left.range {
        _ = writeln!(
            text,
            "  {}: all trajectories left chaos; its mean life is {}; the class describes the following motion",
            plural(lifetimes.left.points, "point"),
            span(lives)
        );
    }
    if lifetimes.transient_points > 0 {
        _ = writeln!(
            text,
            "  {}: some trajectories left chaos, the shortest mean life first",
            plural(lifetimes.transient_points, "point")
        );
        let points = &lifetimes.transient;
        push_table(text, summary, points, lifetimes.transient_points, |point| {
            point.chaos.as_deref().map(described).unwrap_or_default()
        });
    }
}

/// `6700 … 13300`, or one number if both have the same text.
fn span(ends: [f64; 2]) -> String {
    let [least, most] = ends.map(|end| number(end.round()));
    if least == most { least } else { format!("{least} … {most}") }
}

/// `life 2300 (95 %: 1100 … 5400); 3 of 8 trajectories ended on period 3 (2), quasi-periodic (1)`.
fn described(chaos: &ChaosLife) -> String {
    let whole = |cycles: Option<f64>| match cycles {
        Some(cycles) => number(cycles.round()),
        None => "unknown".into(),
    };
    let mut text = format!(
        "life {} (95 %: {} … {})",
        whole(chaos.mean),
        whole(Some(chaos.low)),
        whole(chaos.high)
    );
    if let (Some(all), Some(ended_on)) = (chaos.trajectories, &chaos.ended_on) {
        let ended_on: Vec<String> = ended_on.split(", ").map(ending).collect();
        _ = write!(
            text,
            "; {} of {all} trajectories ended on {}",
            chaos.exits,
            ended_on.join(", ")
        );
    }
    text
}

/// `period 3 (2)` from `periodic 3 (2)`.
fn ending(stored: &str) -> String {
    match stored.strip_prefix("periodic ") {
        Some(period) => format!("period {period}"),
        None => stored.replace("quasi_", "quasi-").replace('_', " "),
    }
}
