//! What a results folder says, as numbers: counts, classes, the chaotic points, the worst
//! residual. [`super::render`] turns it into text.
//!
//! The points are passed over once, and once more for the map; what is kept of them does not grow
//! with their number. Pictures need every point, and ask for them.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Serialize;
use thiserror::Error;

use super::branches::{self, Attractor};
use super::coexistence::{self, Coexistence};
use super::heat::Map;
use super::transitions::{self, TransitionSummary};
use crate::input::printable;
use crate::store::{ResultTable, RunRecord, RunState, StoreError, TableKind, read_runs};

/// A results folder cannot be summarised.
#[derive(Debug, Error)]
pub enum ReportError {
    /// Its files cannot be read.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A file lacks a value that every row has.
    #[error("`{}` has a row without `{column}`; write the results anew with `atlas run`", folder.display())]
    Incomplete {
        /// The results folder.
        folder: PathBuf,
        /// The column.
        column: String,
    },
}

/// A results folder in numbers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// The folder.
    pub folder: PathBuf,
    /// Name of the job; absent without a run record.
    pub job: Option<String>,
    /// How the run ended (`interrupted` if any shard was); absent without a run record.
    pub state: Option<RunState>,
    /// Shards found and expected, of a split job.
    pub shards: Option<[usize; 2]>,
    /// Rows of `points.parquet`.
    pub points: usize,
    /// Points of the grid, as far as the run records tell.
    pub expected: u64,
    /// Points by status.
    pub statuses: BTreeMap<String, usize>,
    /// Points by kind of motion, the calmest first.
    pub classes: Vec<ClassCount>,
    /// Mesh cycles marched.
    pub cycles: u64,
    /// Wall time of the runs, added over shards \[s\]; absent without a run record.
    pub wall_time: Option<f64>,
    /// The same per marched cycle \[s\].
    pub wall_time_per_cycle: Option<f64>,
    /// Time one worker spent on a marched cycle \[s\].
    pub worker_time_per_cycle: Option<f64>,
    /// The grid's axes, slowest first.
    pub axes: Vec<Axis>,
    /// The axis along which the state is carried; absent where points are independent.
    pub carried_along: Option<String>,
    /// Refined changes of motion along it, in `point_id` order.
    pub transitions: Vec<TransitionSummary>,
    /// Points with a largest exponent.
    pub with_exponent: usize,
    /// Chaotic points.
    pub chaotic_points: usize,
    /// The first of them, largest exponent first.
    pub chaotic: Vec<PointSummary>,
    /// Points with a twin trajectory.
    pub with_twin: usize,
    /// Points where twin and tangent disagree.
    pub twin_disagrees_points: usize,
    /// The first of them.
    pub twin_disagrees: Vec<PointSummary>,
    /// Points where probes found more than one attractor.
    pub coexisting: Vec<Coexistence>,
    /// The same as points.
    #[serde(skip)]
    pub coexisting_points: Vec<PointSummary>,
    /// Every attractor that probes found, by point and number.
    pub attractors: Vec<Attractor>,
    /// The branch of each of `attractors` along the last axis with more than one value.
    pub branches: Vec<usize>,
    /// Points with any status but ok.
    pub troubled_points: usize,
    /// The first of them.
    pub troubled: Vec<PointSummary>,
    /// The point with the largest energy residual, and the residual.
    pub worst_energy: Option<(u64, f64)>,
    /// Warnings of the runs.
    pub warnings: Vec<String>,
    /// The map of the largest exponent.
    #[serde(skip)]
    pub map: Option<Map>,
    /// Every point, in `point_id` order, where they were asked for or attractors follow them.
    #[serde(skip)]
    pub all: Vec<PointSummary>,
}

/// Points listed of each kind; the others are counted.
const MOST_LISTED: usize = 1000;

/// A grid axis with the values met in the file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Axis {
    /// Column name.
    pub name: String,
    /// SI unit, `1` when dimensionless.
    pub unit: String,
    /// Values met, ascending.
    pub values: Vec<f64>,
}

/// How many points move in one way.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ClassCount {
    /// `locked`, `periodic`, …; `none` for points without a class.
    pub class: String,
    /// Period of periodic motion.
    pub period: Option<u64>,
    /// Points.
    pub points: usize,
}

/// One point, as far as a summary needs it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PointSummary {
    /// Row-major index into the grid.
    pub point_id: u64,
    /// Value of each axis.
    pub axis_values: Vec<f64>,
    /// Direction of its sweep, `up` or `down`; absent where points are independent.
    pub direction: Option<String>,
    /// How the work ended.
    pub status: String,
    /// Why.
    pub reason: String,
    /// Kind of motion.
    pub class: Option<String>,
    /// Its period, where it has one.
    pub period: Option<u64>,
    /// Largest exponent \[1/cycle\].
    pub lambda: Option<f64>,
    /// Its standard error.
    pub stderr: Option<f64>,
    /// The twin's exponent.
    pub twin: Option<f64>,
    /// Whether the two agree.
    pub twin_agrees: Option<bool>,
}

impl Summary {
    /// Reads a results folder; its points are not kept.
    ///
    /// # Errors
    /// There are no results in the folder, or they cannot be read.
    pub fn read(folder: &Path) -> Result<Self, ReportError> {
        Self::build(folder, false)
    }

    /// Reads a results folder with all its points.
    ///
    /// # Errors
    /// As [`Summary::read`].
    pub fn with_points(folder: &Path) -> Result<Self, ReportError> {
        Self::build(folder, true)
    }

    fn build(folder: &Path, keep: bool) -> Result<Self, ReportError> {
        let head = ResultTable::head(folder, TableKind::Points)?;
        let runs = read_runs(folder)?;
        let attractors = branches::read_attractors(folder)?;
        // Attractors are followed from point to point.
        let mut census = Census::new(head.axes()?.len(), keep || !attractors.is_empty());
        scan(folder, &head, |points, extra| {
            census.take(points, extra);
        })?;
        let axes = census.axes(&head)?;
        let Census {
            points,
            statuses,
            classes,
            cycles,
            worker_time,
            worst_energy,
            with_exponent,
            chaotic,
            with_twin,
            twin_disagrees,
            troubled,
            coexisting,
            all,
            ..
        } = census;
        let mut map = Map::new(&axes).filter(|_| points > 0);
        if let Some(map) = &mut map {
            scan(folder, &head, |points, _| {
                points.iter().for_each(|point| map.add(&axes, point));
            })?;
        }
        let mut all = all.unwrap_or_default();
        all.sort_by_key(|point| point.point_id);
        let along = axes.iter().rposition(|axis| axis.values.len() > 1);
        let followed = along.map_or_else(
            || (0..attractors.len()).collect(),
            |along| branches::branches(&attractors, &all, &axes, along),
        );
        let per_cycle = |time: f64| (cycles > 0).then(|| time / cycles as f64);
        let wall_time =
            (!runs.is_empty()).then(|| runs.iter().map(|run| run.totals.wall_time).sum());
        let recorded: u64 = runs.iter().map(|run| run.totals.points).sum();
        let shown = |text: &str| printable(text).into_owned();
        let by_id = |a: &PointSummary, b: &PointSummary| a.point_id.cmp(&b.point_id);
        let (chaotic_points, chaotic) = chaotic.finish(|a, b| {
            let lambda = |point: &PointSummary| point.lambda.unwrap_or(0.0);
            lambda(b).total_cmp(&lambda(a)).then(by_id(a, b))
        });
        let (twin_disagrees_points, twin_disagrees) = twin_disagrees.finish(by_id);
        let (troubled_points, troubled) = troubled.finish(by_id);
        let mut coexisting_points = coexisting;
        coexisting_points.sort_by_key(|point| point.point_id);
        Ok(Self {
            folder: folder.to_path_buf(),
            job: runs.first().map(|run| shown(&run.job)),
            state: state(&runs),
            shards: runs
                .first()
                .and_then(|run| Some([runs.len(), run.shard?.count as usize])),
            points,
            expected: recorded.max(points as u64),
            statuses,
            classes: in_order(classes),
            cycles,
            wall_time,
            wall_time_per_cycle: wall_time.and_then(per_cycle),
            worker_time_per_cycle: per_cycle(worker_time),
            carried_along: head.metadata("carried_along").map(shown),
            transitions: transitions::read(folder)?,
            axes,
            with_exponent,
            chaotic_points,
            chaotic,
            with_twin,
            twin_disagrees_points,
            twin_disagrees,
            coexisting: coexistence::read(folder, &coexisting_points)?,
            coexisting_points,
            attractors,
            branches: followed,
            troubled_points,
            troubled,
            worst_energy,
            warnings: runs
                .iter()
                .flat_map(|run| run.warnings.iter().map(|warning| shown(warning)))
                .collect(),
            map,
            all,
        })
    }
}

/// What a census takes of a point beside its summary.
struct Extra {
    cycles: u64,
    wall_time: f64,
    energy_residual: Option<f64>,
    attractors: u64,
}

/// Passes over all points, some thousand at a time.
fn scan(
    folder: &Path,
    head: &ResultTable,
    mut each: impl FnMut(Vec<PointSummary>, Vec<Extra>),
) -> Result<(), ReportError> {
    let axes = head.axes()?;
    let columns = axes.iter().map(String::as_str).chain(COLUMNS);
    let columns: Vec<&str> = columns.collect();
    ResultTable::scan(folder, TableKind::Points, &columns, |part| {
        let points = read_points(folder, part)?;
        let (cycles, time) = (part.u64("cycles")?, part.f64("wall_time")?);
        let (residual, attractors) = (part.f64("energy_residual")?, part.u64("attractors")?);
        let extra = (0..points.len()).map(|row| Extra {
            cycles: cycles[row].unwrap_or_default(),
            wall_time: time[row].unwrap_or_default(),
            energy_residual: residual[row],
            attractors: attractors[row].unwrap_or_default(),
        });
        each(points, extra.collect());
        Ok(())
    })
}

/// Columns of points.parquet that a summary reads, the axes aside.
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

/// The first points in some order, and how many there are.
#[derive(Default)]
struct Leading {
    count: usize,
    kept: Vec<PointSummary>,
    /// None where all are kept.
    most: Option<usize>,
}

impl Leading {
    fn new(most: Option<usize>) -> Self {
        Self {
            most,
            ..Self::default()
        }
    }

    fn add(
        &mut self,
        point: &PointSummary,
        order: impl Fn(&PointSummary, &PointSummary) -> Ordering,
    ) {
        self.count += 1;
        self.kept.push(point.clone());
        if let Some(most) = self.most
            && self.kept.len() >= 2 * most
        {
            self.kept.sort_by(order);
            self.kept.truncate(most);
        }
    }

    fn finish(
        mut self,
        order: impl Fn(&PointSummary, &PointSummary) -> Ordering,
    ) -> (usize, Vec<PointSummary>) {
        self.kept.sort_by(order);
        self.kept.truncate(self.most.unwrap_or(usize::MAX));
        (self.count, self.kept)
    }
}

/// What is known of the points passed over so far.
struct Census {
    points: usize,
    statuses: BTreeMap<String, usize>,
    classes: Classes,
    cycles: u64,
    worker_time: f64,
    worst_energy: Option<(u64, f64)>,
    with_exponent: usize,
    chaotic: Leading,
    with_twin: usize,
    twin_disagrees: Leading,
    troubled: Leading,
    coexisting: Vec<PointSummary>,
    /// Values met on each axis.
    values: Vec<Values>,
    all: Option<Vec<PointSummary>>,
}

impl Census {
    fn new(axes: usize, keep: bool) -> Self {
        let most = (!keep).then_some(MOST_LISTED);
        Self {
            points: 0,
            statuses: BTreeMap::new(),
            classes: Classes::new(),
            cycles: 0,
            worker_time: 0.0,
            worst_energy: None,
            with_exponent: 0,
            chaotic: Leading::new(most),
            with_twin: 0,
            twin_disagrees: Leading::new(most),
            troubled: Leading::new(most),
            coexisting: Vec::new(),
            values: (0..axes).map(|_| Values::default()).collect(),
            all: keep.then(Vec::new),
        }
    }

    fn take(&mut self, points: Vec<PointSummary>, extra: Vec<Extra>) {
        let by_id = |a: &PointSummary, b: &PointSummary| a.point_id.cmp(&b.point_id);
        for (point, extra) in points.iter().zip(extra) {
            self.points += 1;
            self.cycles = self.cycles.saturating_add(extra.cycles);
            self.worker_time += extra.wall_time;
            if let Some(residual) = extra.energy_residual.map(f64::abs)
                && self.worst_energy.is_none_or(|(_, worst)| residual >= worst)
            {
                self.worst_energy = Some((point.point_id, residual));
            }
            *self.statuses.entry(point.status.clone()).or_insert(0) += 1;
            count_class(&mut self.classes, point);
            self.with_exponent += usize::from(point.lambda.is_some());
            self.with_twin += usize::from(point.twin_agrees.is_some());
            if point.class.as_deref() == Some("chaotic") {
                self.chaotic.add(point, |a, b| {
                    let lambda = |point: &PointSummary| point.lambda.unwrap_or(0.0);
                    lambda(b).total_cmp(&lambda(a)).then(by_id(a, b))
                });
            }
            if point.twin_agrees == Some(false) {
                self.twin_disagrees.add(point, by_id);
            }
            if point.status != "ok" {
                self.troubled.add(point, by_id);
            }
            if extra.attractors > 1 {
                self.coexisting.push(point.clone());
            }
            for (values, value) in self.values.iter_mut().zip(&point.axis_values) {
                values.add(*value);
            }
        }
        if let Some(all) = &mut self.all {
            all.extend(points);
        }
    }

    /// The axes, with the values met.
    fn axes(&mut self, head: &ResultTable) -> Result<Vec<Axis>, ReportError> {
        let units = head.units()?;
        let values = self.values.drain(..);
        let axes = head
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

/// Different values, of many that are mostly alike.
#[derive(Default)]
struct Values {
    met: Vec<f64>,
    /// How many of them are known to differ.
    sorted: usize,
}

impl Values {
    fn add(&mut self, value: f64) {
        if self.met.last() == Some(&value) {
            return;
        }
        self.met.push(value);
        if self.met.len() > 2 * self.sorted + 65_536 {
            self.tidy();
        }
    }

    fn tidy(&mut self) {
        self.met.sort_by(f64::total_cmp);
        self.met.dedup();
        self.sorted = self.met.len();
    }

    fn finish(mut self) -> Vec<f64> {
        self.tidy();
        self.met
    }
}

/// A split job is complete once every shard is there and complete.
fn state(runs: &[RunRecord]) -> Option<RunState> {
    let first = runs.first()?;
    let all_here = first
        .shard
        .is_none_or(|shard| runs.len() >= shard.count as usize);
    let complete = all_here && runs.iter().all(|run| run.state == RunState::Complete);
    Some(if complete {
        RunState::Complete
    } else {
        RunState::Interrupted
    })
}

fn read_points(folder: &Path, table: &ResultTable) -> Result<Vec<PointSummary>, ReportError> {
    let axes: Vec<(String, Vec<Option<f64>>)> = table
        .axes()?
        .into_iter()
        .map(|name| table.f64(&name).map(|values| (name, values)))
        .collect::<Result<_, _>>()?;
    let (ids, statuses) = (table.u64("point_id")?, table.text("status")?);
    let (reasons, classes) = (table.text("reason")?, table.text("class")?);
    let (periods, agrees) = (table.u64("period")?, table.bool("twin_agrees")?);
    let (lambda, stderr) = (table.f64("lambda_max")?, table.f64("lambda_stderr")?);
    let twin = table.f64("lambda_twin")?;
    let directions = match table.metadata("carried_along") {
        Some(_) => table.text("direction")?,
        None => vec![None; table.rows()],
    };
    let incomplete = |column: &str| ReportError::Incomplete {
        folder: folder.to_path_buf(),
        column: column.to_owned(),
    };
    (0..table.rows())
        .map(|row| {
            let axis_values = axes
                .iter()
                .map(|(name, values)| {
                    let value = values[row].filter(|value| value.is_finite());
                    value.ok_or_else(|| incomplete(name))
                })
                .collect::<Result<_, _>>()?;
            Ok(PointSummary {
                point_id: ids[row].ok_or_else(|| incomplete("point_id"))?,
                axis_values,
                direction: directions[row].clone(),
                status: statuses[row].clone().ok_or_else(|| incomplete("status"))?,
                reason: reasons[row].clone().unwrap_or_default(),
                class: classes[row].clone(),
                period: periods[row],
                lambda: lambda[row],
                stderr: stderr[row],
                twin: twin[row],
                twin_agrees: agrees[row],
            })
        })
        .collect()
}

/// Points by rank of their class and by period, with the class's name.
type Classes = BTreeMap<(usize, Option<u64>), (String, usize)>;

/// Classes, the calmest first.
const CALMEST_FIRST: [&str; 6] = [
    "locked",
    "periodic",
    "quasi_periodic",
    "chaotic",
    "not_converged",
    "none",
];

fn count_class(counts: &mut Classes, point: &PointSummary) {
    let class = point.class.clone().unwrap_or_else(|| "none".into());
    let known = CALMEST_FIRST.iter().position(|known| *known == class);
    let period = point.period.filter(|_| class == "periodic");
    let rank = known.unwrap_or(CALMEST_FIRST.len());
    counts.entry((rank, period)).or_insert((class, 0)).1 += 1;
}

fn in_order(counts: Classes) -> Vec<ClassCount> {
    let counts = counts.into_iter();
    counts
        .map(|((_, period), (class, points))| ClassCount {
            class,
            period,
            points,
        })
        .collect()
}
