//! The changes of motion along a sweep, as text.

use crate::report::numbers::{number, to_digits};
use crate::report::summary::Summary;
use crate::report::transitions::TransitionSummary;
use std::fmt::Write;

/// Largest number of rows in the list.
const MOST_ROWS: usize = 40;

/// Appends a list of the changes of motion.
pub(super) fn push(text: &mut String, summary: &Summary) {
    let Some(axis) = summary.carried_along.as_ref() else {
        return;
    };
    if summary.transitions.is_empty() {
        return;
    }
    let unit = summary.axes.iter().find(|known| known.name == *axis);
    let unit = unit.map_or("", |known| known.unit.as_str());
    let counts = ["class", "period", "deflection"]
        .into_iter()
        .filter_map(|what| {
            let count = summary.transition_counts.get(what)?;
            Some(match what {
                "deflection" => format!("{count} by a jump of the deflection"),
                _ => format!("{count} of {what}"),
            })
        });
    let counts: Vec<String> = counts.collect();
    _ = writeln!(
        text,
        "\nchanges of motion along {axis}: {}",
        counts.join(", ")
    );
    for found in summary.transitions.iter().take(MOST_ROWS) {
        _ = writeln!(text, "{}", line(found, unit));
    }
    if summary.transitions.len() > MOST_ROWS {
        let more = summary.transitions.len() - MOST_ROWS;
        _ = writeln!(text, "  … and {more} more");
    }
}

/// A change of motion as a line: `     4  up    period 1         → chaotic          1040.5 … 1040.6 rad/s`.
pub(super) fn line(transition: &TransitionSummary, unit: &str) -> String {
    let unit = if unit == "1" { "" } else { unit };
    let [from, to] = [0, 1].map(|side| match transition.periods[side] {
        Some(period) if transition.classes[side] == "periodic" => format!("period {period}"),
        _ => transition.classes[side].replace('_', " "),
    });
    // Show as many digits as necessary to distinguish the two ends.
    let [lower, upper] = transition.bracket;
    let digits = (2.0 + (upper.abs() / (upper - lower)).log10().ceil()).clamp(4.0, 15.0);
    let [lower, upper] = [lower, upper].map(|end| to_digits(end, digits as usize));
    let line = format!(
        "  {:>6}  {:<5} {from:<16} → {to:<16} {lower} … {upper} {unit}{}",
        transition.point_id,
        transition.direction,
        jump(transition)
    );
    line.trim_end().to_owned()
}

/// The jump of the deflection as text: of its RMS, or of its mean if this changes more; empty if nothing
/// jumps.
fn jump(transition: &TransitionSummary) -> String {
    let by = |[before, behind]: [Option<f64>; 2]| Some([before?, behind?]);
    let (Some(rms), Some(mean)) = (
        by(transition.deflection_rms),
        by(transition.deflection_mean),
    ) else {
        return String::new();
    };
    let change = |[before, behind]: [f64; 2]| (behind - before).abs();
    let (name, [before, behind]) =
        if change(rms) >= change(mean) { ("RMS", rms) } else { ("mean", mean) };
    format!(
        "  {name} of the deflection jumps, {} → {} µm",
        number(1e6 * before),
        number(1e6 * behind)
    )
}
