//! Writes the tables of the followed orbits of a job.

use super::continuation::Followed;
use crate::manifest::Job;
use crate::store::{
    AxisColumn, CurveRow, FollowedRows, StoreError, TableRecord, bifurcation_rows, branch_rows,
    curve_rows, with_values_replaced, write_followed,
};
use serde_json::json;
use std::path::Path;

/// Writes the branches, bifurcations and curves of a job to a folder of results; returns the records of the tables.
///
/// # Errors
/// A table cannot be written.
pub fn write_branches(
    job: &Job,
    folder: &Path,
    followed: &Followed,
) -> Result<Vec<TableRecord>, StoreError> {
    let axes: Vec<AxisColumn> = (job.axes.iter())
        .map(|axis| AxisColumn {
            name: axis.name().to_owned(),
            unit: axis.unit.clone(),
        })
        .collect();
    let name = |index: usize| axes.get(index).map(|axis| axis.name.clone());
    let spec = job.continuation.as_ref();
    let derived: Vec<&str> = (axes.iter().map(|axis| axis.name.as_str()))
        .filter(|name| job.between.is_derived(name))
        .collect();
    let metadata: Vec<(&str, String)> = [
        ("job", Some(job.name.clone())),
        ("manifest_hash", Some(job.hash.clone())),
        (
            "axes",
            Some(json!(axes.iter().map(|a| &a.name).collect::<Vec<_>>()).to_string()),
        ),
        (
            "axis_units",
            Some(json!(job.written().axis_units()).to_string()),
        ),
        ("over", spec.and_then(|spec| name(spec.over))),
        ("second", spec.and_then(|spec| name(spec.second?))),
        (
            "derived",
            (!derived.is_empty()).then(|| json!(derived).to_string()),
        ),
    ]
    .into_iter()
    .filter_map(|(key, value)| Some((key, value?)))
    .collect();
    write_followed(folder, &axes, rows(job, followed), &metadata)
}

/// The rows of all tables; branches and curves are numbered over the whole job.
fn rows(job: &Job, followed: &Followed) -> FollowedRows {
    let mut out = FollowedRows::default();
    let Some(spec) = &job.continuation else {
        return out;
    };
    let mut number = 0;
    for line in &followed.lines {
        let first = number;
        for (origin, branch) in &line.branches.all {
            out.branches
                .extend(branch_rows(number, branch, &line.axis_values, spec.over));
            let origin = origin.text(first as usize);
            out.bifurcations.extend(bifurcation_rows(
                number,
                branch,
                &origin,
                &line.axis_values,
                spec.over,
            ));
            number += 1;
        }
    }
    for row in &mut out.branches {
        job.derive(&mut row.axis_values);
    }
    for row in &mut out.bifurcations {
        job.derive(&mut row.axis_values);
    }
    let Some(second) = spec.second else {
        return out;
    };
    let mut curves = Vec::new();
    let mut number = 0;
    for plane in &followed.planes {
        for curve in &plane.all {
            curves.extend(curve_rows(
                number,
                curve,
                &plane.axis_values,
                [spec.over, second],
            ));
            number += 1;
        }
        for (index, onset) in plane.onset.iter().enumerate() {
            curves.push(CurveRow {
                axis_values: with_values_replaced(
                    &plane.axis_values,
                    &[(spec.over, onset.at[0]), (second, onset.at[1])],
                ),
                curve: number,
                index: index as u32,
                kind: "onset".to_owned(),
                note: (onset.radius >= 1.0).then(|| "unstable in contact".to_owned()),
                orbit: None,
            });
        }
        number += u32::from(!plane.onset.is_empty());
    }
    for row in &mut curves {
        job.derive(&mut row.axis_values);
    }
    out.curves = Some(curves);
    out
}
