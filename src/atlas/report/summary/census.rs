//! Counts over the points of a results folder, in one pass. Memory does not grow with the number of points,
//! unless all points are kept.

use std::cmp::Ordering;
use std::collections::{BTreeMap, HashSet};
use std::path::Path;
use std::sync::Arc;

use crate::input::printable;
use crate::report::error::ReportError;
use crate::report::lifetimes::Lifetimes;
use crate::report::point::{
    Axis, CHAOTIC, ChaosLife, ClassCount, PointSummary, TRANSIENT_CHAOS, Verdict,
};
use crate::store::{ResultTable, TableKind};

/// Largest number of points listed per kind; further ones are only counted.
const MOST_LISTED: usize = 1000;

/// Energy residual above which the summary warns, relative to the exchanged energy. An amplitude is
/// proportional to the square root of an energy. Thus this residual corresponds to a relative error of 5e-7
/// of an amplitude, of which four digits are shown. Kernels without discretisation errors stay below 1e-11,
/// and their points are not `ok` above 1e-9. Kernels that step through time exceed the limit if their steps
/// are too long.
pub(in crate::report) const LARGEST_RESIDUAL: f64 = 1e-6;

/// Order of points by ascending number.
pub(super) fn by_id(a: &PointSummary, b: &PointSummary) -> Ordering {
    a.point_id.cmp(&b.point_id)
}

/// Order of points with the larger exponent first.
pub(super) fn livelier(a: &PointSummary, b: &PointSummary) -> Ordering {
    let lambda = |point: &PointSummary| point.lambda.unwrap_or(0.0);
    lambda(b).total_cmp(&lambda(a)).then(by_id(a, b))
}

/// Order of points with the shorter mean life of chaos first.
pub(super) fn shorter_lived(a: &PointSummary, b: &PointSummary) -> Ordering {
    let life = |point: &PointSummary| point.chaos.as_ref()?.mean;
    let life = |point: &PointSummary| life(point).unwrap_or(f64::INFINITY);
    life(a).total_cmp(&life(b)).then(by_id(a, b))
}

/// Data of a point for the census in addition to its summary.
pub(super) struct CensusData {
    cycles: u64,
    wall_time: f64,
    energy_residual: Option<f64>,
    attractors: u64,
}

/// Calls `each` with all points of a table, some thousand at a time.
pub(super) fn scan(
    folder: &Path,
    table: &ResultTable,
    mut each: impl FnMut(Vec<PointSummary>, Vec<CensusData>),
) -> Result<(), ReportError> {
    let axes = table.axes()?;
    let columns = axes.iter().map(String::as_str).chain(COLUMNS);
    let columns: Vec<&str> = columns.chain(EVIDENCE).collect();
    // Results of older programs have no columns of evidence.
    let heads = table.columns()?;
    let has_column = |name: &&str| heads.iter().any(|column| column.name == **name);
    let with_evidence = EVIDENCE.iter().all(has_column);
    ResultTable::scan(folder, TableKind::Points, &columns, |part| {
        let points = read_points(folder, part, with_evidence)?;
        let (cycles, time) = (part.u64("cycles")?, part.f64("wall_time")?);
        let (residual, attractors) = (part.f64("energy_residual")?, part.u64("attractors")?);
        let extra = (0..points.len()).map(|row| CensusData {
            cycles: cycles[row].unwrap_or_default(),
            wall_time: time[row].unwrap_or_default(),
            energy_residual: residual[row],
            attractors: attractors[row].unwrap_or_default(),
        });
        each(points, extra.collect());
        Ok(())
    })
}

/// Columns of points.parquet that a summary reads, in addition to the axes.
const COLUMNS: [&str; 14] = [
    "point_id",
    "direction",
    "status",
    "reason",
    "class",
    "period",
    "lambda_max",
    "lambda_stderr",
    "lambda_twin",
    "twin_agrees",
    "cycles",
    "wall_time",
    "energy_residual",
    "attractors",
];

/// Columns about the evidence for averages, for motion that does not settle.
const EVIDENCE: [&str; 7] = [
    "trajectories",
    "errors_verified",
    "chaos_lifetime",
    "chaos_lifetime_low",
    "chaos_lifetime_high",
    "chaos_exits",
    "ended_on",
];

/// The first points in some order, at most [`MOST_LISTED`], and the number of all points.
#[derive(Default)]
pub(super) struct FirstPoints {
    count: usize,
    points: Vec<PointSummary>,
}

impl FirstPoints {
    fn add(
        &mut self,
        point: &PointSummary,
        order: impl Fn(&PointSummary, &PointSummary) -> Ordering,
    ) {
        self.count += 1;
        self.points.push(point.clone());
        if self.points.len() >= 2 * MOST_LISTED {
            self.points.sort_by(order);
            self.points.truncate(MOST_LISTED);
        }
    }

    pub(super) fn finish(
        mut self,
        order: impl Fn(&PointSummary, &PointSummary) -> Ordering,
    ) -> (usize, Vec<PointSummary>) {
        self.points.sort_by(order);
        self.points.truncate(MOST_LISTED);
        (self.count, self.points)
    }
}

/// Counts over the points read so far.
#[derive(Default)]
pub(super) struct Census {
    pub(super) points: usize,
    pub(super) statuses: BTreeMap<String, usize>,
    pub(super) classes: Classes,
    pub(super) cycles: u64,
    pub(super) worker_time: f64,
    pub(super) worst_energy: Option<(u64, f64)>,
    /// Number of points with a residual above [`LARGEST_RESIDUAL`].
    pub(super) open_balances: usize,
    pub(super) with_exponent: usize,
    pub(super) chaotic: FirstPoints,
    pub(super) lifetimes: Lifetimes,
    /// Points whose chaos some trajectories left.
    pub(super) transient: FirstPoints,
    pub(super) with_evidence: usize,
    pub(super) unverified: usize,
    pub(super) with_twin: usize,
    pub(super) twin_disagrees: FirstPoints,
    pub(super) points_not_ok: FirstPoints,
    pub(super) coexisting: Vec<PointSummary>,
    /// Values on each axis.
    values: Vec<Values>,
    verdicts: Verdicts,
    pub(super) all: Option<Vec<PointSummary>>,
}

impl Census {
    pub(super) fn new(axes: usize, keep: bool) -> Self {
        Self {
            values: (0..axes).map(|_| Values::default()).collect(),
            all: keep.then(Vec::new),
            ..Self::default()
        }
    }

    pub(super) fn take(&mut self, points: Vec<PointSummary>, extra: Vec<CensusData>) {
        for (point, extra) in points.iter().zip(extra) {
            self.points += 1;
            self.cycles = self.cycles.saturating_add(extra.cycles);
            self.worker_time += extra.wall_time;
            let residual = extra.energy_residual.map(f64::abs);
            self.open_balances += usize::from(residual.is_some_and(|r| r > LARGEST_RESIDUAL));
            if let Some(residual) = residual
                && self.worst_energy.is_none_or(|(_, worst)| residual >= worst)
            {
                self.worst_energy = Some((point.point_id, residual));
            }
            *self.statuses.entry(point.status.clone()).or_insert(0) += 1;
            count_class(&mut self.classes, point);
            self.with_exponent += usize::from(point.lambda.is_some());
            self.with_twin += usize::from(point.twin_agrees.is_some());
            if point.is_chaos() {
                self.chaotic.add(point, livelier);
            }
            if self.lifetimes.count(point) {
                self.transient.add(point, shorter_lived);
            }
            self.with_evidence += usize::from(point.errors_verified.is_some());
            self.unverified += usize::from(point.errors_verified == Some(false));
            if point.twin_agrees == Some(false) {
                self.twin_disagrees.add(point, by_id);
            }
            if point.status != "ok" {
                self.points_not_ok.add(point, by_id);
            }
            if extra.attractors > 1 {
                self.coexisting.push(point.clone());
            }
            for (values, value) in self.values.iter_mut().zip(&point.axis_values) {
                values.add(*value);
            }
        }
        if let Some(all) = &mut self.all {
            // Reasons and lifetimes of all points would take most of the memory. Only the points listed above
            // keep them.
            all.extend(points.into_iter().map(|mut point| {
                Arc::make_mut(&mut point.verdict).reason = String::new();
                point.verdict = self.verdicts.shared(point.verdict);
                point.chaos = None;
                point
            }));
        }
    }

    /// The axes, with their values.
    pub(super) fn axes(&mut self, table: &ResultTable) -> Result<Vec<Axis>, ReportError> {
        let units = table.units()?;
        let values = self.values.drain(..);
        let axes = table
            .axes()?
            .into_iter()
            .zip(values)
            .map(|(name, values)| Axis {
                unit: units
                    .get(&name)
                    .map_or("".into(), |unit| printable(unit))
                    .into_owned(),
                name: printable(&name).into_owned(),
                values: values.finish(),
            });
        Ok(axes.collect())
    }
}

/// Verdicts that points share.
#[derive(Default)]
struct Verdicts(HashSet<Arc<Verdict>>);

impl Verdicts {
    fn shared(&mut self, verdict: Arc<Verdict>) -> Arc<Verdict> {
        if let Some(known) = self.0.get(&verdict) {
            return known.clone();
        }
        self.0.insert(verdict.clone());
        verdict
    }
}

/// Collects the distinct values among many, of which most are equal.
#[derive(Default)]
struct Values {
    values: Vec<f64>,
    /// Number of values after the last removal of duplicates.
    sorted: usize,
}

impl Values {
    fn add(&mut self, value: f64) {
        if self.values.last() == Some(&value) {
            return;
        }
        self.values.push(value);
        if self.values.len() > 2 * self.sorted + 65_536 {
            self.tidy();
        }
    }

    fn tidy(&mut self) {
        self.values.sort_by(f64::total_cmp);
        self.values.dedup();
        self.sorted = self.values.len();
    }

    pub(super) fn finish(mut self) -> Vec<f64> {
        self.tidy();
        self.values
    }
}

fn read_points(
    folder: &Path,
    table: &ResultTable,
    with_evidence: bool,
) -> Result<Vec<PointSummary>, ReportError> {
    let axes: Vec<(String, Vec<Option<f64>>)> = table
        .axes()?
        .into_iter()
        .map(|name| table.f64(&name).map(|values| (name, values)))
        .collect::<Result<_, _>>()?;
    let (ids, mut statuses) = (table.u64("point_id")?, table.text("status")?);
    let (mut reasons, mut classes) = (table.text("reason")?, table.text("class")?);
    let (periods, agrees) = (table.u64("period")?, table.bool("twin_agrees")?);
    let (lambda, stderr) = (table.f64("lambda_max")?, table.f64("lambda_stderr")?);
    let twin = table.f64("lambda_twin")?;
    let mut directions = match table.metadata("carried_along") {
        Some(_) => table.text("direction")?,
        None => vec![None; table.rows()],
    };
    let evidence = if with_evidence {
        read_evidence(table)?
    } else {
        vec![(None, None); table.rows()]
    };
    let incomplete = |column: &str| ReportError::Incomplete {
        folder: folder.to_path_buf(),
        column: column.to_owned(),
    };
    (0..table.rows())
        .map(|row| {
            let mut axis_values = Vec::with_capacity(axes.len());
            for (name, values) in &axes {
                let value = values[row].filter(|value| value.is_finite());
                axis_values.push(value.ok_or_else(|| incomplete(name))?);
            }
            let (errors_verified, chaos) = evidence[row].clone();
            Ok(PointSummary {
                point_id: ids[row].ok_or_else(|| incomplete("point_id"))?,
                axis_values,
                verdict: Arc::new(Verdict {
                    direction: directions[row].take(),
                    status: statuses[row].take().ok_or_else(|| incomplete("status"))?,
                    reason: reasons[row].take().unwrap_or_default(),
                    class: classes[row].take(),
                    period: periods[row],
                    twin_agrees: agrees[row],
                    errors_verified,
                }),
                lambda: lambda[row],
                stderr: stderr[row],
                twin: twin[row],
                chaos,
            })
        })
        .collect()
}

/// Whether the standard errors of a point are verified, and the lifetime of its chaos.
type Evidence = (Option<bool>, Option<Box<ChaosLife>>);

fn read_evidence(table: &ResultTable) -> Result<Vec<Evidence>, ReportError> {
    let (trajectories, exits) = (table.u64("trajectories")?, table.u64("chaos_exits")?);
    let (verified, ended_on) = (table.bool("errors_verified")?, table.text("ended_on")?);
    let [mean, low, high] = [
        table.f64("chaos_lifetime")?,
        table.f64("chaos_lifetime_low")?,
        table.f64("chaos_lifetime_high")?,
    ];
    let life = |row: usize| {
        Some(Box::new(ChaosLife {
            mean: mean[row],
            low: low[row]?,
            high: high[row],
            exits: exits[row].unwrap_or_default(),
            trajectories: trajectories[row],
            ended_on: ended_on[row].clone(),
        }))
    };
    let rows = 0..table.rows();
    Ok(rows.map(|row| (verified[row], life(row))).collect())
}

/// Number of points by rank of their class and by period, with the name of the class.
pub(super) type Classes = BTreeMap<(usize, Option<u64>), (String, usize)>;

/// Classes, the calmest first.
const CALMEST_FIRST: [&str; 7] = [
    "steady_contact",
    "periodic",
    "quasi_periodic",
    TRANSIENT_CHAOS,
    CHAOTIC,
    "not_converged",
    "none",
];

fn count_class(counts: &mut Classes, point: &PointSummary) {
    let class = point.class.as_deref().unwrap_or("none").to_owned();
    let position = CALMEST_FIRST.iter().position(|name| *name == class);
    let period = point.period.filter(|_| class == "periodic");
    let rank = position.unwrap_or(CALMEST_FIRST.len());
    counts.entry((rank, period)).or_insert((class, 0)).1 += 1;
}

pub(super) fn in_order(counts: Classes) -> Vec<ClassCount> {
    let counts = counts.into_iter();
    counts
        .map(|((_, period), (class, points))| ClassCount {
            class,
            period,
            points,
        })
        .collect()
}
