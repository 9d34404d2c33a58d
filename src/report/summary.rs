//! What a results folder says, as numbers: counts, classes, the chaotic points, the worst
//! residual. [`super::render`] turns it into text.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Serialize;
use thiserror::Error;

use super::branches::{self, Attractor};
use super::coexistence::{self, Coexistence};
use super::transitions::{self, TransitionSummary};
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

/// Said of tables that nothing vouches for.
const UNRECORDED: &str = "there is no run.json: whether the tables are whole, and what was \
                          written, cannot be checked";

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
    /// Chaotic points, largest exponent first.
    pub chaotic: Vec<PointSummary>,
    /// Points where twin and tangent disagree.
    pub twin_disagrees: Vec<PointSummary>,
    /// Points where probes found more than one attractor.
    pub coexisting: Vec<Coexistence>,
    /// Every attractor that probes found, by point and number.
    pub attractors: Vec<Attractor>,
    /// The branch of each of `attractors` along the last axis with more than one value.
    pub branches: Vec<usize>,
    /// Points with any status but ok.
    pub troubled: Vec<PointSummary>,
    /// The point with the largest energy residual, and the residual.
    pub worst_energy: Option<(u64, f64)>,
    /// Warnings of the runs.
    pub warnings: Vec<String>,
    /// Every point, in `point_id` order.
    #[serde(skip)]
    pub all: Vec<PointSummary>,
}

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
    /// Reads a results folder.
    ///
    /// # Errors
    /// There are no results in the folder, or they cannot be read.
    pub fn read(folder: &Path) -> Result<Self, ReportError> {
        let table = ResultTable::read(folder, TableKind::Points)?;
        let runs = read_runs(folder)?;
        let all = read_points(folder, &table)?;
        let total = |column: Vec<Option<f64>>| column.into_iter().flatten().sum::<f64>();
        let cycles: u64 = table.u64("cycles")?.into_iter().flatten().sum();
        let per_cycle = |time: f64| (cycles > 0).then(|| time / cycles as f64);
        let wall_time =
            (!runs.is_empty()).then(|| runs.iter().map(|run| run.totals.wall_time).sum());
        let worst_energy = table
            .f64("energy_residual")?
            .into_iter()
            .zip(&all)
            .filter_map(|(residual, point)| Some((point.point_id, residual?.abs())))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let mut chaotic = chosen(&all, |point| point.class.as_deref() == Some("chaotic"));
        chaotic.sort_by(|a, b| b.lambda.unwrap_or(0.0).total_cmp(&a.lambda.unwrap_or(0.0)));
        let mut statuses = BTreeMap::new();
        for point in &all {
            *statuses.entry(point.status.clone()).or_insert(0) += 1;
        }
        let axes = read_axes(&table, &all)?;
        let attractors = branches::read_attractors(folder)?;
        let along = axes.iter().rposition(|axis| axis.values.len() > 1);
        let followed = along.map_or_else(
            || (0..attractors.len()).collect(),
            |along| branches::branches(&attractors, &all, &axes, along),
        );
        let recorded: u64 = runs.iter().map(|run| run.totals.points).sum();
        Ok(Self {
            folder: folder.to_path_buf(),
            job: runs.first().map(|run| run.job.clone()),
            state: state(&runs),
            shards: runs
                .first()
                .and_then(|run| Some([runs.len(), run.shard?.count as usize])),
            points: all.len(),
            expected: recorded.max(all.len() as u64),
            statuses,
            classes: count_classes(&all),
            cycles,
            wall_time,
            wall_time_per_cycle: wall_time.and_then(per_cycle),
            worker_time_per_cycle: per_cycle(total(table.f64("wall_time")?)),
            carried_along: table.metadata("carried_along").map(str::to_owned),
            transitions: transitions::read(folder)?,
            axes,
            chaotic,
            twin_disagrees: chosen(&all, |point| point.twin_agrees == Some(false)),
            coexisting: coexistence::read(folder, &table)?,
            attractors,
            branches: followed,
            troubled: chosen(&all, |point| point.status != "ok"),
            worst_energy,
            warnings: match runs.is_empty() {
                true => vec![UNRECORDED.to_owned()],
                false => runs.into_iter().flat_map(|run| run.warnings).collect(),
            },
            all,
        })
    }
}

fn chosen(all: &[PointSummary], wanted: impl Fn(&PointSummary) -> bool) -> Vec<PointSummary> {
    all.iter().filter(|point| wanted(point)).cloned().collect()
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
                .map(|(name, values)| values[row].ok_or_else(|| incomplete(name)))
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

fn read_axes(table: &ResultTable, all: &[PointSummary]) -> Result<Vec<Axis>, ReportError> {
    let units = table.units()?;
    let axes = table.axes()?.into_iter().enumerate().map(|(index, name)| {
        let mut values: Vec<f64> = all.iter().map(|point| point.axis_values[index]).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        let unit = units.get(&name).cloned().unwrap_or_default();
        Axis { name, unit, values }
    });
    Ok(axes.collect())
}

/// Counts by class and period, the calmest first.
fn count_classes(all: &[PointSummary]) -> Vec<ClassCount> {
    let order = [
        "locked",
        "periodic",
        "quasi_periodic",
        "chaotic",
        "not_converged",
        "none",
    ];
    let mut counts: BTreeMap<(usize, Option<u64>), (String, usize)> = BTreeMap::new();
    for point in all {
        let class = point.class.clone().unwrap_or_else(|| "none".into());
        let rank = order
            .iter()
            .position(|known| *known == class)
            .unwrap_or(order.len());
        let period = point.period.filter(|_| class == "periodic");
        counts.entry((rank, period)).or_insert((class, 0)).1 += 1;
    }
    counts
        .into_iter()
        .map(|((_, period), (class, points))| ClassCount {
            class,
            period,
            points,
        })
        .collect()
}
