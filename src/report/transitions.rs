//! Where the motion changes along a sweep, and between which values.

use std::fmt::Write;
use std::path::Path;

use serde::Serialize;

use super::summary::Summary;
use super::text::{number, to_digits};
use crate::store::{ResultTable, StoreError, TableKind};

/// Rows shown before the list is cut short.
const MOST_ROWS: usize = 40;

/// A change of class or period, or a jump of the deflection, between two points of a chain.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TransitionSummary {
    /// The first point behind it, in sweep order.
    pub point_id: u64,
    /// `up` or `down`.
    pub direction: String,
    /// Kind of motion before and behind it.
    pub classes: [String; 2],
    /// Their periods, where they have one.
    pub periods: [Option<u64>; 2],
    /// What changes: `class`, `period` or `deflection`.
    pub what: String,
    /// RMS of the deflection before and behind a jump \[m\].
    pub deflection_rms: [Option<f64>; 2],
    /// Mean deflection before and behind it \[m\].
    pub deflection_mean: [Option<f64>; 2],
    /// Values of the swept axis that bracket it, ascending.
    pub bracket: [f64; 2],
}

/// The transitions of a results folder; empty where none were sought.
pub(super) fn read(folder: &Path) -> Result<Vec<TransitionSummary>, StoreError> {
    let table = match ResultTable::read(folder, TableKind::Transitions) {
        Err(StoreError::Missing { .. }) => return Ok(Vec::new()),
        table => table?,
    };
    let (ids, directions) = (table.u64("point_id")?, table.text("direction")?);
    let (from, to) = (table.text("from_class")?, table.text("to_class")?);
    let (before, behind) = (table.u64("from_period")?, table.u64("to_period")?);
    let what = table.text("what")?;
    let pair = |name: &str| -> Result<_, StoreError> {
        Ok([
            table.f64(&format!("from_{name}"))?,
            table.f64(&format!("to_{name}"))?,
        ])
    };
    let (rms, mean) = (pair("deflection_rms")?, pair("deflection_mean")?);
    let (lower, upper) = (table.f64("lower")?, table.f64("upper")?);
    let found = (0..table.rows()).filter_map(|row| {
        Some(TransitionSummary {
            point_id: ids[row]?,
            direction: directions[row].clone()?,
            classes: [from[row].clone()?, to[row].clone()?],
            periods: [before[row], behind[row]],
            what: what[row].clone()?,
            deflection_rms: rms.each_ref().map(|side| side[row]),
            deflection_mean: mean.each_ref().map(|side| side[row]),
            bracket: [lower[row]?, upper[row]?],
        })
    });
    Ok(found.collect())
}

/// A list of them.
pub(super) fn push(text: &mut String, summary: &Summary) {
    let Some(axis) = summary.carried_along.as_ref() else {
        return;
    };
    if summary.transitions.is_empty() {
        return;
    }
    let unit = summary.axes.iter().find(|known| known.name == *axis);
    let unit = match unit.map_or("", |known| known.unit.as_str()) {
        "1" => "",
        unit => unit,
    };
    _ = writeln!(text, "\nchanges of motion along {axis}");
    for found in summary.transitions.iter().take(MOST_ROWS) {
        let [from, to] = [0, 1].map(|side| match found.periods[side] {
            Some(period) if found.classes[side] == "periodic" => format!("period {period}"),
            _ => found.classes[side].replace('_', " "),
        });
        // As many digits as tell the two ends apart.
        let [lower, upper] = found.bracket;
        let digits = (2.0 + (upper.abs() / (upper - lower)).log10().ceil()).clamp(4.0, 15.0);
        let [lower, upper] = [lower, upper].map(|end| to_digits(end, digits as usize));
        let line = format!(
            "  {:>6}  {:<5} {from:<16} → {to:<16} {lower} … {upper} {unit}{}",
            found.point_id,
            found.direction,
            jump(found)
        );
        _ = writeln!(text, "{}", line.trim_end());
    }
    if summary.transitions.len() > MOST_ROWS {
        let more = summary.transitions.len() - MOST_ROWS;
        _ = writeln!(text, "  … and {more} more");
    }
}

/// What jumps, of a jump: the RMS, or the mean where that changes more.
fn jump(found: &TransitionSummary) -> String {
    let by = |[before, behind]: [Option<f64>; 2]| Some([before?, behind?]);
    let (Some(rms), Some(mean)) = (by(found.deflection_rms), by(found.deflection_mean)) else {
        return String::new();
    };
    let change = |[before, behind]: [f64; 2]| (behind - before).abs();
    let (name, [before, behind]) = match change(rms) >= change(mean) {
        true => ("RMS", rms),
        false => ("mean", mean),
    };
    format!(
        "  {name} of the deflection jumps, {} → {} m",
        number(before),
        number(behind)
    )
}
