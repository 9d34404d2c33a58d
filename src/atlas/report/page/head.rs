//! The head of a page: what it needs to know of a results folder besides the tables, such as axes, kinds of
//! motion and records of runs.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::{Value, json};

use super::block::{self, Blocks};
use crate::report::Summary;
use crate::report::followed::Followed;
use crate::report::plot::{Motion, PREFIXABLE, VIRIDIS, category_colour, kind_colour, kind_name};
use crate::report::refined::Plane;
use crate::report::text::{Style, render};
use crate::store::{ProgramRecord, ResultTable, RunRecord, RunState, StoreError, TableKind};
use crate::units::conversion;

/// Kinds of bifurcations and of their curves, as the tables of followed orbits name them.
const KINDS: [&str; 10] = [
    "fold",
    "branch_point",
    "period_doubling",
    "torus",
    "merging",
    "graze",
    "jump",
    "sequence",
    "onset",
    "end",
];

/// The description of a folder with points or followed orbits.
///
/// # Errors
/// Followed orbits cannot be read.
pub(super) fn of_results(
    summary: &Summary,
    runs: &[RunRecord],
    folder: &Path,
    blocks: &mut Blocks,
) -> Result<Value, crate::report::ReportError> {
    let followed = Followed::read(folder)?;
    let units = match &followed {
        Some(followed) if runs.is_empty() => &followed.units,
        _ => &summary.units,
    };
    let motions: Vec<Motion> = summary.all.iter().map(Motion::of).collect();
    let mut counts: BTreeMap<Motion, usize> = BTreeMap::new();
    for motion in &motions {
        *counts.entry(*motion).or_insert(0) += 1;
    }
    let place = |motion: &Motion| counts.keys().take_while(|other| *other < motion).count() as u32;
    let codes: Vec<u32> = motions.iter().map(place).collect();
    let axes: Vec<Value> = (summary.axes.iter())
        .map(|axis| {
            let shown = units.get(&axis.name);
            let factor = shown.and_then(|shown| conversion(&axis.unit, shown));
            json!({
                "name": axis.name,
                "unit": axis.unit,
                "shown": factor.and(shown),
                "factor": factor,
                "values": blocks.push(block::numbers(&axis.values)),
            })
        })
        .collect();
    let all = 0..axes.len();
    // The fixed axes for every pair of axes that a picture varies; equal indices are a picture over one axis.
    let held: Vec<Vec<Vec<usize>>> = (all.clone())
        .map(|first| {
            (all.clone())
                .map(|second| summary.tied.fixed_axes(axes.len(), &[first, second]))
                .collect()
        })
        .collect();
    let spanning = (summary.tied.free(axes.len()).into_iter())
        .filter(|&axis| summary.axes[axis].values.len() > 1);
    Ok(json!({
        "job": summary.job,
        "state": summary.state.map(|state| match state {
            RunState::Complete => "complete",
            RunState::Interrupted => "interrupted",
        }),
        "points": summary.points,
        "expected": summary.expected,
        "axes": axes,
        "held": held,
        "spanning": spanning.collect::<Vec<_>>(),
        "along": summary.carried_along,
        "over": followed.as_ref().map(|followed| followed.over),
        "second": followed.as_ref().and_then(|followed| followed.second),
        "motions": counts.iter().map(|(motion, count)| json!({
            "name": motion.name(),
            "mark": motion.mark(),
            "colour": motion.colour().to_string(),
            "hatched": motion.is_hatched(),
            "points": count,
        })).collect::<Vec<_>>(),
        "motion": blocks.push(block::codes(&codes)),
        "plane": summary.refined.as_ref().map(|refined| {
            let plane = Plane::new(refined, &summary.all);
            let [rows, columns] = plane.sides;
            let places = (0..rows).flat_map(|row| (0..columns).map(move |column| [row, column]));
            let stands: Vec<u32> = places
                .map(|[row, column]| plane.at(row, column).map_or(0, |point| point as u32 + 1))
                .collect();
            json!({
                "axes": refined.axes,
                "sides": plane.sides,
                "stands": blocks.push(block::codes(&stands)),
            })
        }),
        "summary": render(summary, Style::Plain),
        "warnings": summary.warnings,
    }))
}

/// The description of a folder with only a traced trajectory.
///
/// # Errors
/// The table of the trace cannot be read.
pub(super) fn of_trace(folder: &Path) -> Result<Value, StoreError> {
    let head = ResultTable::head(folder, TableKind::Trace)?;
    Ok(json!({ "job": head.metadata("job") }))
}

/// Adds to the head: this program, colours, kinds of bifurcations, records of runs and, if `has_trace`, metadata of
/// the trace.
///
/// # Errors
/// A table cannot be read.
pub(super) fn complete(
    header: &mut Value,
    runs: &[RunRecord],
    folder: &Path,
    has_trace: bool,
) -> Result<(), StoreError> {
    header["program"] = json!(ProgramRecord::current().to_string());
    header["ramp"] = json!(VIRIDIS.map(|colour| colour.to_string()));
    header["palette"] = (0..7)
        .map(|number| category_colour(number).to_string())
        .collect();
    header["prefixable"] = json!(PREFIXABLE);
    header["kinds"] = (KINDS.iter())
        .map(|kind| {
            let look = json!({ "name": kind_name(kind), "colour": kind_colour(kind).to_string() });
            ((*kind).to_owned(), look)
        })
        .collect();
    let files: usize = runs.iter().map(|run| run.tables.len()).sum();
    header["checked"] = json!(files);
    header["runs"] = json!(runs);
    if has_trace {
        let head = ResultTable::head(folder, TableKind::Trace)?;
        let own = [
            "job",
            "manifest_hash",
            "point",
            "point_units",
            "mesh_period",
            "half_gap",
        ];
        let words = own
            .iter()
            .filter_map(|key| Some(((*key).to_owned(), json!(head.metadata(key)?))));
        header["trace"] = words.collect();
    }
    Ok(())
}
