//! The summary of a results folder in numbers: counts, classes, the chaotic points, the worst residual, and
//! more. [`super::render`] turns it into text.
//!
//! The code makes one pass over the points, and a second one for the map. Memory does not grow with the
//! number of points, unless all points are kept. They are kept for pictures, attractors, orbits and refined
//! grids.

mod census;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::branches::{self, Attractor};
use super::coexistence::{self, Coexistence};
use super::error::ReportError;
use super::followed::{Followed, FollowedSummary};
use super::heat::Map;
use super::lifetimes::Lifetimes;
use super::orbits::{self, Orbits};
use super::point::{Axis, ClassCount, PointSummary};
use super::rattle::{self, Rattle};
use super::refined::{Plane, complete};
use super::tied::Tied;
use super::transitions::{self, TransitionSummary};
use crate::input::printable;
use crate::manifest::ManifestText;
use crate::store::{
    RefinedColumns, ResultTable, RunRecord, RunState, StoreError, TableKind, read_runs,
};
pub(super) use census::LARGEST_RESIDUAL;
use census::{Census, by_id, in_order, livelier, scan, shorter_lived};

/// Warning for tables without a record.
const UNRECORDED: &str =
    "there is no run.json, so the completeness of the tables cannot be checked";

/// A results folder in numbers.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Summary {
    /// The folder.
    pub folder: PathBuf,
    /// Name of the job; absent without a run record.
    pub job: Option<String>,
    /// Final state of the run (`interrupted` if any shard was); absent without a run record.
    pub state: Option<RunState>,
    /// Numbers of shards found and expected; absent if the job is not split.
    pub shards: Option<[usize; 2]>,
    /// Number of points in `points.parquet`.
    pub points: usize,
    /// Number of points of the complete run, from the run records; at least `points`.
    pub expected: u64,
    /// Points by status.
    pub statuses: BTreeMap<String, usize>,
    /// Points by kind of motion, the calmest first.
    pub classes: Vec<ClassCount>,
    /// Number of mesh cycles integrated, over all points.
    pub cycles: u64,
    /// Wall time of the runs, summed over shards \[s\]; absent without a run record.
    pub wall_time: Option<f64>,
    /// Wall time per integrated cycle \[s\].
    pub wall_time_per_cycle: Option<f64>,
    /// Time of one worker per integrated cycle \[s\].
    pub worker_time_per_cycle: Option<f64>,
    /// The grid's axes, slowest first.
    pub axes: Vec<Axis>,
    /// Units of axes in the manifest, by name; empty without a run record.
    #[serde(skip)]
    pub units: BTreeMap<String, String>,
    /// Tied axes: axes that advance in step.
    #[serde(skip)]
    pub tied: Tied,
    /// Whether some axes are distributions. Their values form no grid, so that maps over them are meaningless.
    #[serde(skip)]
    pub sampled: bool,
    /// The axis along which the state is carried; absent if points are independent.
    pub carried_along: Option<String>,
    /// How the grid is refined; absent if all its points are computed.
    pub refined: Option<RefinedColumns>,
    /// Changes of motion along the carried axis, in `point_id` order.
    pub transitions: Vec<TransitionSummary>,
    /// Numbers of changes of `class`, of `period`, and of jumps of the `deflection`.
    pub transition_counts: BTreeMap<String, usize>,
    /// Followed orbits; absent if there are none.
    pub followed: Option<FollowedSummary>,
    /// Number of points with a Lyapunov exponent.
    pub with_exponent: usize,
    /// Number of chaotic points, including transient chaos.
    pub chaotic_points: usize,
    /// The first of them, largest exponent first.
    pub chaotic: Vec<PointSummary>,
    /// Lifetimes of chaos.
    pub lifetimes: Lifetimes,
    /// Meshes, stages and stops of a train, the one that rattles most first; empty if there is only one.
    pub rattle: Vec<Rattle>,
    /// Number of points whose motion does not settle, so that their averages have standard errors.
    pub with_evidence: usize,
    /// Number of these points whose standard errors are not verified.
    pub unverified_points: usize,
    /// Number of points with a twin trajectory.
    pub with_twin: usize,
    /// Number of points at which the exponents of the twin and of the tangent vectors disagree.
    pub twin_disagrees_points: usize,
    /// The first of them.
    pub twin_disagrees: Vec<PointSummary>,
    /// Points where probes found more than one attractor.
    pub coexisting: Vec<Coexistence>,
    /// Summaries of the points in `coexisting`.
    #[serde(skip)]
    pub coexisting_points: Vec<PointSummary>,
    /// Every attractor that probes found, by point and number.
    pub attractors: Vec<Attractor>,
    /// The branch of each of `attractors` along the last axis with more than one value.
    pub branches: Vec<usize>,
    /// Periodic orbits; absent if the job did not search for them.
    pub orbits: Option<Orbits>,
    /// Number of points with any status except `ok`.
    pub troubled_points: usize,
    /// The first of them.
    pub troubled: Vec<PointSummary>,
    /// The point with the largest energy residual, and the residual.
    pub worst_energy: Option<(u64, f64)>,
    /// Number of points with an energy residual above `LARGEST_RESIDUAL`.
    pub open_balances: usize,
    /// Warnings of the runs.
    pub warnings: Vec<String>,
    /// The map of kinds of motion and exponents; absent without points or varying axes, or if axes are distributions.
    #[serde(skip)]
    pub map: Option<Map>,
    /// Every point, in `point_id` order, if requested, if there are attractors or orbits, or if the grid is refined.
    /// Without reasons and lives of chaos.
    #[serde(skip)]
    pub all: Vec<PointSummary>,
}

impl Summary {
    /// Reads a results folder without keeping all points.
    ///
    /// # Errors
    /// The folder has no results, or they cannot be read.
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

    /// Whether the folder contains only followed orbits.
    pub fn is_of_orbits_alone(&self) -> bool {
        self.followed.is_some() && self.points == 0 && self.state.is_none()
    }

    fn build(folder: &Path, keep: bool) -> Result<Self, ReportError> {
        let head = match ResultTable::head(folder, TableKind::Points) {
            Err(missing @ StoreError::Missing { .. }) => {
                let followed = Followed::read(folder)?.ok_or(missing)?;
                return Ok(Self::of_orbits(folder, &followed));
            }
            head => head?,
        };
        let followed = Followed::read(folder)?;
        let runs = read_runs(folder)?;
        let attractors = branches::read_attractors(folder)?;
        let orbits = orbits::read(folder)?;
        // Attractors are matched between points, and orbits are listed by point.
        let keep = keep || !attractors.is_empty() || orbits.is_some();
        let mut census = Census::new(head.axes()?.len(), keep);
        let refined: Option<RefinedColumns> =
            (head.metadata("refined")).and_then(|text| serde_json::from_str(text).ok());
        if refined.is_some() {
            census.all.get_or_insert_default();
        }
        scan(folder, &head, |points, extra| {
            census.take(points, extra);
        })?;
        let mut axes = census.axes(&head)?;
        let mut all = census.all.take().unwrap_or_default();
        all.sort_unstable_by_key(|point| point.point_id);
        if let Some(refined) = &refined {
            complete(&mut axes, refined, &all);
        }
        let tied = Tied::of(&head, &axes, census.points);
        let sampled = head.metadata("samples").is_some();
        let mut map =
            (Map::new(&axes, &tied, refined.as_ref())).filter(|_| census.points > 0 && !sampled);
        match (&mut map, &refined) {
            (Some(map), Some(refined)) => map.fill(&Plane::new(refined, &all), &all),
            (Some(map), None) => scan(folder, &head, |points, _| {
                points.iter().for_each(|point| map.add(&axes, point));
            })?,
            (None, _) => {}
        }
        let along = axes.iter().rposition(|axis| axis.values.len() > 1);
        let branches = along.map_or_else(
            || (0..attractors.len()).collect(),
            |along| {
                let fixed_axes = tied.fixed_axes(axes.len(), &[along]);
                branches::branches(&attractors, &all, &axes, along, &fixed_axes)
            },
        );
        let transitions = transitions::read(folder)?;
        let mut transition_counts = BTreeMap::new();
        for transition in &transitions {
            *transition_counts
                .entry(transition.what.clone())
                .or_insert(0) += 1;
        }
        let mut summary = Self {
            folder: folder.to_path_buf(),
            carried_along: head.metadata("carried_along").map(shown),
            transitions,
            transition_counts,
            refined,
            followed: followed.map(|followed| FollowedSummary::of(&followed)),
            axes,
            tied,
            sampled,
            rattle: rattle::ranked(folder, &head)?,
            attractors,
            branches,
            orbits,
            map,
            all,
            ..Self::default()
        };
        summary.take_census(census);
        summary.take_runs(&runs);
        summary.coexisting = coexistence::read(folder, &summary.coexisting_points)?;
        Ok(summary)
    }

    /// Copies the counts of the census into the summary.
    fn take_census(&mut self, census: Census) {
        self.points = census.points;
        self.statuses = census.statuses;
        self.classes = in_order(census.classes);
        self.cycles = census.cycles;
        self.worker_time_per_cycle = over(census.worker_time, census.cycles);
        self.worst_energy = census.worst_energy;
        self.open_balances = census.open_balances;
        self.with_exponent = census.with_exponent;
        self.with_evidence = census.with_evidence;
        self.unverified_points = census.unverified;
        self.with_twin = census.with_twin;
        self.lifetimes = census.lifetimes;
        (self.chaotic_points, self.chaotic) = census.chaotic.finish(livelier);
        let transient = census.transient.finish(shorter_lived);
        (self.lifetimes.transient_points, self.lifetimes.transient) = transient;
        (self.twin_disagrees_points, self.twin_disagrees) = census.twin_disagrees.finish(by_id);
        (self.troubled_points, self.troubled) = census.points_not_ok.finish(by_id);
        self.coexisting_points = census.coexisting;
        (self.coexisting_points).sort_by_key(|point| point.point_id);
    }

    /// Copies the data of the run records into the summary.
    fn take_runs(&mut self, runs: &[RunRecord]) {
        let recorded: u64 = runs.iter().map(|run| run.totals.points).sum();
        self.expected = recorded.max(self.points as u64);
        self.state = state(runs);
        let Some(first) = runs.first() else {
            self.warnings = vec![UNRECORDED.to_owned()];
            return;
        };
        self.job = Some(shown(&first.job));
        self.shards = (first.shard).map(|shard| [runs.len(), shard.count as usize]);
        self.units = axis_units(first);
        // The wall time of a resumed run is that of its last part, so that only the cycles of this part
        // count.
        let integrated: u64 = runs.iter().map(|run| run.totals.cycles).sum();
        let wall_time = runs.iter().map(|run| run.totals.wall_time).sum();
        self.wall_time = Some(wall_time);
        self.wall_time_per_cycle = over(wall_time, integrated);
        // Points that a worker integrates side by side overlap in time, so that the sum of their times is too
        // large. It cannot exceed the wall time of all workers.
        let of_workers = |run: &RunRecord| run.totals.wall_time * f64::from(run.placement.threads);
        let most = over(runs.iter().map(of_workers).sum(), integrated);
        let known = self.worker_time_per_cycle.zip(most);
        self.worker_time_per_cycle = known.map(|(time, most)| time.min(most));
        let warnings = runs.iter().flat_map(|run| &run.warnings);
        self.warnings = warnings.map(|warning| shown(warning)).collect();
    }

    /// The summary of a folder without points.
    fn of_orbits(folder: &Path, followed: &Followed) -> Self {
        Self {
            folder: folder.to_path_buf(),
            job: followed.job.clone(),
            axes: followed.axes.clone(),
            followed: Some(FollowedSummary::of(followed)),
            units: followed.units.clone(),
            ..Self::default()
        }
    }
}

/// A time per cycle, if there are cycles.
fn over(time: f64, cycles: u64) -> Option<f64> {
    (cycles > 0).then(|| time / cycles as f64)
}

/// The text with its control characters made visible.
fn shown(text: &str) -> String {
    printable(text).into_owned()
}

/// Units of axes in the manifest of a run, by name.
fn axis_units(run: &RunRecord) -> BTreeMap<String, String> {
    let manifest = ManifestText {
        text: &run.manifest,
        changes: &run.set,
    };
    manifest.axis_units()
}

/// A split job is complete when every shard exists and is complete.
fn state(runs: &[RunRecord]) -> Option<RunState> {
    let first = runs.first()?;
    let all_here = first
        .shard
        .is_none_or(|shard| runs.len() >= shard.count as usize);
    let complete = all_here && runs.iter().all(|run| run.state == RunState::Complete);
    Some(if complete { RunState::Complete } else { RunState::Interrupted })
}
