//! Changes of motion along a sweep, each between two values of the swept axis.

use std::path::Path;

use serde::Serialize;

use crate::store::{ResultTable, StoreError, TableKind};

/// A change of class or period, or a jump of the deflection, between two points of a chain.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TransitionSummary {
    /// The first point after the change, in sweep order.
    pub point_id: u64,
    /// The swept axis.
    pub axis: String,
    /// `up` or `down`.
    pub direction: String,
    /// Kind of motion before and after the change.
    pub classes: [String; 2],
    /// Period of the motion before and after the change, if it has one.
    pub periods: [Option<u64>; 2],
    /// The quantity that changes: `class`, `period` or `deflection`.
    pub what: String,
    /// RMS of the deflection before and after a jump \[m\].
    pub deflection_rms: [Option<f64>; 2],
    /// Mean deflection before and after a jump \[m\].
    pub deflection_mean: [Option<f64>; 2],
    /// Values of the swept axis that bracket the change, ascending.
    pub bracket: [f64; 2],
}

/// The transitions of a results folder; empty if the job did not search for them.
pub(super) fn read(folder: &Path) -> Result<Vec<TransitionSummary>, StoreError> {
    let Some(table) = ResultTable::read_if_there(folder, TableKind::Transitions)? else {
        return Ok(Vec::new());
    };
    let (ids, directions) = (table.u64("point_id")?, table.text("direction")?);
    let (from, to) = (table.text("from_class")?, table.text("to_class")?);
    let (before, behind) = (table.u64("from_period")?, table.u64("to_period")?);
    let (axes, what) = (table.text("axis")?, table.text("what")?);
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
            axis: axes[row].clone()?,
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
