//! The files of followed orbits: `branches.parquet` has one row per orbit, `bifurcations.parquet` one row per
//! bifurcation, and `curves.parquet` one row per point of a curve in two parameters.

use super::StoreError;
use super::checksum::TableRecord;
use super::command_record::CommandTables;
use super::point_row::AxisColumn;
use super::table::{Column, Table, columns};
use super::table_kind::{FOLLOW_RECORD, TableKind};
use crate::analysis::continuation::bifurcation::Bifurcation;
use crate::analysis::continuation::branch::Branch;
use crate::analysis::continuation::curve::Curve;
use crate::analysis::continuation::kind::Kind;
use crate::analysis::continuation::orbit::Orbit;
use std::path::Path;

/// An orbit on a branch.
#[derive(Debug, Clone, PartialEq)]
pub struct BranchRow {
    /// Value of every axis.
    pub axis_values: Vec<f64>,
    /// Number of the branch, from 0 over the whole job.
    pub branch: u32,
    /// Number of the orbit on its branch, from 0.
    pub index: u32,
    /// Length of the branch up to the orbit \[1\]: the interval of the axis counts 1, and a change of the orbit by ten
    /// times its size counts 1.
    pub length: f64,
    /// Columns of the orbit.
    pub orbit: OrbitColumns,
}

/// The columns of an orbit.
#[derive(Debug, Clone, PartialEq)]
pub struct OrbitColumns {
    period: u32,
    unstable: u32,
    leading: [f64; 2],
    lambda: f64,
    events: u32,
    sequence: String,
    margin: Option<f64>,
    rms: f64,
    smallest: f64,
    largest: f64,
    force_peak: f64,
    residual: f64,
    steps: u32,
    start: [Vec<f64>; 2],
}

impl OrbitColumns {
    /// The columns of `orbit`.
    pub fn of(orbit: &Orbit) -> Self {
        let leading = orbit.multipliers.first().copied().unwrap_or_default();
        let (touches, motion) = (&orbit.details.touches, &orbit.details.motion);
        Self {
            period: orbit.period,
            unstable: orbit.unstable() as u32,
            leading: [leading.re, leading.im],
            lambda: leading.norm().ln() / f64::from(orbit.period),
            events: touches.sequence.len() as u32,
            sequence: touches.text(),
            margin: touches.margin(),
            rms: motion.rms,
            smallest: motion.smallest,
            largest: motion.largest,
            force_peak: motion.force_peak,
            residual: orbit.residual,
            steps: orbit.steps,
            start: orbit.details.start.clone(),
        }
    }
}

/// A bifurcation of a branch, or one of its ends.
#[derive(Debug, Clone, PartialEq)]
pub struct BifurcationRow {
    /// Value of every axis.
    pub axis_values: Vec<f64>,
    /// Number of the branch.
    pub branch: u32,
    /// Number of the last orbit of the branch before it.
    pub after: u32,
    /// Name of the bifurcation; `end` for an end of the branch.
    pub kind: String,
    /// Interval of the followed axis that contains it, in SI.
    pub bracket: [f64; 2],
    /// Real and imaginary part of the multiplier on the unit circle; `None` if there is none, as at an end.
    pub critical: Option<[f64; 2]>,
    /// Further details, in words.
    pub detail: String,
    /// Columns of the orbit.
    pub orbit: OrbitColumns,
}

/// A point of a curve.
#[derive(Debug, Clone, PartialEq)]
pub struct CurveRow {
    /// Value of every axis.
    pub axis_values: Vec<f64>,
    /// Number of the curve, from 0 over the whole job.
    pub curve: u32,
    /// Number of the point on its curve, from 0.
    pub index: u32,
    /// Kind of bifurcation.
    pub kind: String,
    /// The codimension-two point before it, or the reason for the curve's end.
    pub note: Option<String>,
    /// Columns of the orbit; `None` for an onset in closed form.
    pub orbit: Option<OrbitColumns>,
}

/// The rows of the branch with this number, which is followed over the axis `over`.
pub fn branch_rows<'a>(
    number: u32,
    branch: &'a Branch,
    axis_values: &'a [f64],
    over: usize,
) -> impl Iterator<Item = BranchRow> + 'a {
    (branch.orbits.iter().zip(&branch.lengths).enumerate()).map(move |(index, (orbit, &length))| {
        BranchRow {
            axis_values: with_values_replaced(axis_values, &[(over, orbit.at[0])]),
            branch: number,
            index: index as u32,
            length,
            orbit: OrbitColumns::of(orbit),
        }
    })
}

/// The rows of the bifurcations and of the two ends of the branch with this number. `origin` says in words where the
/// branch starts.
pub fn bifurcation_rows(
    number: u32,
    branch: &Branch,
    origin: &str,
    axis_values: &[f64],
    over: usize,
) -> Vec<BifurcationRow> {
    let end = |which: usize, orbit: &Orbit, after: usize, detail: String| BifurcationRow {
        axis_values: with_values_replaced(axis_values, &[(over, orbit.at[0])]),
        branch: number,
        after: after as u32,
        kind: "end".to_owned(),
        bracket: [orbit.at[0]; 2],
        critical: None,
        detail: format!("{}{detail}", branch.ends[which]),
        orbit: OrbitColumns::of(orbit),
    };
    let last = branch.orbits.len() - 1;
    let mut rows = vec![end(0, &branch.orbits[0], 0, format!("; from {origin}"))];
    rows.extend(
        branch
            .bifurcations
            .iter()
            .map(|bifurcation| BifurcationRow {
                axis_values: with_values_replaced(axis_values, &[(over, bifurcation.orbit.at[0])]),
                branch: number,
                after: bifurcation.after as u32,
                kind: bifurcation.kind.name().to_owned(),
                bracket: bifurcation.bracket,
                critical: bifurcation.critical().map(|m| [m.re, m.im]),
                detail: detail(bifurcation),
                orbit: OrbitColumns::of(&bifurcation.orbit),
            }),
    );
    rows.push(end(1, &branch.orbits[last], last, String::new()));
    rows
}

fn detail(bifurcation: &Bifurcation) -> String {
    let what = match bifurcation.kind {
        Kind::Graze { extreme } => Some(format!(
            "contact {} from {} at {:.6} cycles",
            extreme.contact + 1,
            if extreme.is_minimum { "inside" } else { "outside" },
            extreme.time
        )),
        Kind::Merging { period } => Some(format!("the orbits of period {period}")),
        Kind::Torus => bifurcation.resonance().map(|q| format!("resonance 1:{q}")),
        _ => None,
    };
    let unfollowed_branch = bifurcation
        .unfollowed_branch
        .as_ref()
        .map(ToString::to_string);
    let notes: Vec<String> = what.into_iter().chain(unfollowed_branch).collect();
    notes.join("; ")
}

/// The rows of the curve with this number in the plane of two axes.
pub fn curve_rows(
    number: u32,
    curve: &Curve,
    axis_values: &[f64],
    axes: [usize; 2],
) -> Vec<CurveRow> {
    let last = curve.points.len().saturating_sub(1);
    (curve.points.iter().enumerate())
        .map(|(index, point)| {
            let end = match index {
                0 => Some(curve.ends[0]),
                _ if index == last => Some(curve.ends[1]),
                _ => None,
            };
            CurveRow {
                axis_values: with_values_replaced(
                    axis_values,
                    &[(axes[0], point.orbit.at[0]), (axes[1], point.orbit.at[1])],
                ),
                curve: number,
                index: index as u32,
                kind: curve.kind.name().to_owned(),
                note: point.note.or(end).map(str::to_owned),
                orbit: Some(OrbitColumns::of(&point.orbit)),
            }
        })
        .collect()
}

/// The values of the axes after some are replaced; `replaced` has the index and the value of each.
pub fn with_values_replaced(axis_values: &[f64], replaced: &[(usize, f64)]) -> Vec<f64> {
    let mut out = axis_values.to_vec();
    for &(axis, value) in replaced {
        out[axis] = value;
    }
    out
}

fn axis_columns<R: 'static>(
    axes: &[AxisColumn],
    value: fn(&R, usize) -> Option<f64>,
) -> Vec<Column<R>> {
    let axis_column = |(index, axis): (usize, &AxisColumn)| {
        columns![row: R;
            f64 &axis.name, &axis.unit, value(row, index), &format!("Axis {}", axis.name);
        ]
    };
    axes.iter().enumerate().flat_map(axis_column).collect()
}

fn orbit_columns<R: 'static>(orbit: fn(&R) -> Option<&OrbitColumns>) -> Vec<Column<R>> {
    columns![row: R;
        u32 "period", "mesh cycles", orbit(row)?.period, "Period of the orbit";
        bool "stable", "", orbit(row)?.unstable == 0, "Whether all multipliers lie inside the unit circle";
        u32 "unstable", "1", orbit(row)?.unstable, "Multipliers outside the unit circle";
        f64 "multiplier_re", "1", orbit(row)?.leading[0], "Real part of the multiplier of largest modulus";
        f64 "multiplier_im", "1", orbit(row)?.leading[1], "Imaginary part of the multiplier of largest modulus";
        f64 "lambda", "1/cycle", orbit(row)?.lambda, "Largest exponent: logarithm of that modulus, divided by the period";
        u32 "events", "1", orbit(row)?.events, "Contact-state changes in one period";
        text "sequence", "", Some(&*orbit(row)?.sequence), "Contact changes in order: the number of the \
                                                           contact, then + if it closes or - if it opens";
        f64 "grazing_margin", "half gaps", orbit(row)?.margin,
            "Smallest distance between an extreme of a contact's depth and its surface";
        f64 "deflection_rms", "m", orbit(row)?.rms, "Root mean square of the mesh deflection about its mean";
        f64 "deflection_min", "m", orbit(row)?.smallest, "Smallest mesh deflection";
        f64 "deflection_max", "m", orbit(row)?.largest, "Largest mesh deflection";
        f64 "force_peak", "N", orbit(row)?.force_peak, "Largest |mesh force|";
        f64 "residual", "half gaps", orbit(row)?.residual, "Distance between the start and the end of a period";
        u32 "newton_steps", "1", orbit(row)?.steps, "Newton steps from the guess to the orbit";
        list "displacement", "m sqrt(kg)", &*orbit(row)?.start[0],
            "Modal displacements on the orbit at mesh phase 0, one per mode, as used by run.initial and continuation.states";
        list "modal_velocity", "m sqrt(kg)/s", &*orbit(row)?.start[1],
            "Modal velocities on the orbit at mesh phase 0, one per mode";
    ]
}

/// Columns of `branches.parquet`.
pub fn branches_table(axes: &[AxisColumn]) -> Table<BranchRow> {
    let mut all = columns![row: BranchRow;
        u32 "branch", "1", row.branch, "Number of the branch, from 0 over the whole job";
        u32 "index", "1", row.index, "Number of the orbit on its branch, from 0";
    ];
    all.extend(axis_columns(axes, |row: &BranchRow, index| {
        row.axis_values.get(index).copied()
    }));
    all.extend(columns![row: BranchRow;
        f64 "length", "1", row.length, "Length of the branch up to this orbit, where the interval of the \
                                        axis counts 1 and a change by ten times the orbit's size counts 1";
    ]);
    all.extend(orbit_columns(|row: &BranchRow| Some(&row.orbit)));
    Table::new(all)
}

/// Columns of `bifurcations.parquet`.
pub fn bifurcations_table(axes: &[AxisColumn]) -> Table<BifurcationRow> {
    let mut all = columns![row: BifurcationRow;
        u32 "branch", "1", row.branch, "Number of the branch";
        u32 "after", "1", row.after, "Number of the previous orbit on the branch";
        text "kind", "", Some(&*row.kind),
            "fold, branch_point, period_doubling, torus, graze, jump (of multipliers across the unit \
             circle, at a graze), sequence (the contact sequence changes without a graze), merging (with \
             orbits of half the period), or end of the branch";
    ];
    all.extend(axis_columns(axes, |row: &BifurcationRow, index| {
        row.axis_values.get(index).copied()
    }));
    all.extend(columns![row: BifurcationRow;
        f64 "low", "1", row.bracket[0], "Lower end of the interval of the followed axis that contains it, in the unit of the axis";
        f64 "high", "1", row.bracket[1], "Upper end of that interval";
        f64 "critical_re", "1", row.critical.map(|m| m[0]), "Real part of the multiplier on the unit circle";
        f64 "critical_im", "1", row.critical.map(|m| m[1]), "Imaginary part of the multiplier on the unit circle";
        text "detail", "", Some(&*row.detail), "Further details; for an end, its reason";
    ]);
    all.extend(orbit_columns(|row: &BifurcationRow| Some(&row.orbit)));
    Table::new(all)
}

/// Columns of `curves.parquet`.
pub fn curves_table(axes: &[AxisColumn]) -> Table<CurveRow> {
    let mut all = columns![row: CurveRow;
        u32 "curve", "1", row.curve, "Number of the curve, from 0 over the whole job";
        u32 "index", "1", row.index, "Number of the point on its curve, from 0";
        text "kind", "", Some(&*row.kind), "fold, period_doubling, torus, graze, or onset (of rattle, in closed form)";
    ];
    all.extend(axis_columns(axes, |row: &CurveRow, index| {
        row.axis_values.get(index).copied()
    }));
    all.extend(columns![row: CurveRow;
        text "note", "", row.note.as_deref(), "Bifurcation of codimension two just before this point; at the ends, \
                                               the reason why the curve ends";
    ]);
    all.extend(orbit_columns(|row: &CurveRow| row.orbit.as_ref()));
    Table::new(all)
}

/// All rows of a job's orbits.
#[derive(Debug, Default)]
pub struct FollowedRows {
    /// Rows of `branches.parquet`.
    pub branches: Vec<BranchRow>,
    /// Rows of `bifurcations.parquet`.
    pub bifurcations: Vec<BifurcationRow>,
    /// Rows of `curves.parquet`; `None` without a second axis.
    pub curves: Option<Vec<CurveRow>>,
}

/// Writes the tables into a results folder, each completely or not at all, then `follow.json`. If no curves were
/// requested, removes old ones: they do not belong to these branches.
///
/// # Errors
/// The folder cannot be created, or a file cannot be written.
pub fn write_followed(
    folder: &Path,
    axes: &[AxisColumn],
    rows: FollowedRows,
    metadata: &[(&str, String)],
) -> Result<Vec<TableRecord>, StoreError> {
    let mut tables = CommandTables::start(folder, FOLLOW_RECORD, metadata)?;
    match rows.curves {
        Some(rows) => tables.write(TableKind::Curves, curves_table(axes), rows)?,
        None => tables.supersede(TableKind::Curves),
    }
    let bifurcations = bifurcations_table(axes);
    tables.write(TableKind::Bifurcations, bifurcations, rows.bifurcations)?;
    tables.write(TableKind::Branches, branches_table(axes), rows.branches)?;
    tables.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::ResultTable;
    use std::collections::BTreeMap;

    fn sample_orbit() -> OrbitColumns {
        OrbitColumns {
            period: 2,
            unstable: 1,
            leading: [-1.5, 0.25],
            lambda: 0.2,
            events: 4,
            sequence: "1+ 1-".into(),
            margin: Some(0.3),
            rms: 1e-6,
            smallest: -2e-6,
            largest: 3e-6,
            force_peak: 700.0,
            residual: 1e-13,
            steps: 3,
            start: [vec![0.1], vec![0.2]],
        }
    }

    /// Every column of a table with one row, as text.
    fn only_row<R>(folder: &Path, kind: TableKind, table: &Table<R>) -> BTreeMap<String, String> {
        let read = ResultTable::read(folder, kind).unwrap();
        assert_eq!(read.rows(), 1);
        (table.columns().iter())
            .map(|column| {
                let name = column.name.as_str();
                let number = || Some(read.f64(name).ok()?[0]?.to_string());
                let whole = || Some(read.u64(name).ok()?[0]?.to_string());
                let text = || read.text(name).ok()?[0].clone();
                let truth = || Some(read.bool(name).ok()?[0]?.to_string());
                let list = || Some(format!("{:?}", read.lists(name).ok()?[0].as_ref()?));
                let value = (number().or_else(whole).or_else(text))
                    .or_else(truth)
                    .or_else(list);
                (
                    name.to_owned(),
                    value.unwrap_or_else(|| panic!("{name} is null")),
                )
            })
            .collect()
    }

    #[test]
    fn every_column_of_followed_orbits_comes_back() {
        let axes = [("load", "1"), ("speed", "rad/s")].map(|(name, unit)| AxisColumn {
            name: name.into(),
            unit: unit.into(),
        });
        let axis_values = vec![0.1, 900.0];
        let rows = FollowedRows {
            branches: vec![BranchRow {
                axis_values: axis_values.clone(),
                branch: 5,
                index: 6,
                length: 0.75,
                orbit: sample_orbit(),
            }],
            bifurcations: vec![BifurcationRow {
                axis_values: axis_values.clone(),
                branch: 5,
                after: 7,
                kind: "fold".into(),
                bracket: [899.0, 901.0],
                critical: Some([1.0, 0.125]),
                detail: "x".into(),
                orbit: sample_orbit(),
            }],
            curves: Some(vec![CurveRow {
                axis_values,
                curve: 8,
                index: 9,
                kind: "torus".into(),
                note: Some("cusp".into()),
                orbit: Some(sample_orbit()),
            }]),
        };
        let folder = tempfile::tempdir().unwrap();
        write_followed(folder.path(), &axes, rows, &[]).unwrap();
        let branch = only_row(folder.path(), TableKind::Branches, &branches_table(&axes));
        let own = only_row(
            folder.path(),
            TableKind::Bifurcations,
            &bifurcations_table(&axes),
        );
        let curve = only_row(folder.path(), TableKind::Curves, &curves_table(&axes));
        for (table, name, value) in [
            (&branch, "branch", "5"),
            (&branch, "index", "6"),
            (&branch, "length", "0.75"),
            (&branch, "speed", "900"),
            (&branch, "stable", "false"),
            (&branch, "unstable", "1"),
            (&branch, "multiplier_re", "-1.5"),
            (&branch, "multiplier_im", "0.25"),
            (&branch, "sequence", "1+ 1-"),
            (&branch, "deflection_min", "-0.000002"),
            (&branch, "deflection_max", "0.000003"),
            (&branch, "deflection_rms", "0.000001"),
            (&branch, "force_peak", "700"),
            (&branch, "newton_steps", "3"),
            (&branch, "displacement", "[Some(0.1)]"),
            (&branch, "modal_velocity", "[Some(0.2)]"),
            (&own, "after", "7"),
            (&own, "kind", "fold"),
            (&own, "low", "899"),
            (&own, "high", "901"),
            (&own, "critical_re", "1"),
            (&own, "critical_im", "0.125"),
            (&own, "detail", "x"),
            (&curve, "curve", "8"),
            (&curve, "index", "9"),
            (&curve, "load", "0.1"),
            (&curve, "note", "cusp"),
            (&curve, "period", "2"),
        ] {
            assert_eq!(table[name], value, "{name}");
        }
    }
}
