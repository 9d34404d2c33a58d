//! How long does a run take, and how much memory and disk space? The answer comes from a few points that are
//! tried out beforehand.
//!
//! Points are drawn over the grid until the time is known accurately enough, or the calibration has taken the
//! share [`CALIBRATION_SHARE`] of it. For a point inside a chain, the point before it is computed first, as
//! if it started the chain. The timed point thus starts from a settled motion, as in a sweep. Refinement adds
//! time for every change of motion between neighbours of the sample. Trials do not include it: most points
//! have no change, so a few points would be a poor estimate of the number.

use super::chain::halvings;
use super::chain_tasks::ChainSelection;
use super::estimate::{Interval, PointTime, Workload, drawn};
use super::layout::layout;
use super::parts::{Prepared, needed_tables};
use super::point::Worker;
use super::queue::work;
use super::run::{Sweep, SweepError, Workers, pieces, start_workers};
use super::shared::lock;
use super::trial::{TriedPoint, try_out};
use crate::manifest::Job;
use crate::numerics::statistics::mean;
use crate::store::{GROUP_BYTES, PointRow, ResultWriter, StoreError, journal_bytes};
use crate::topology::{ProcessorClock, Topology, peak_memory};
use serde::Serialize;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Relative half width of the interval of the computing time at which the calibration stops.
const ACCURATE_ENOUGH: f64 = 0.15;

/// Upper limit, per worker, of the smallest number of points to be tried out.
const POINTS_A_WORKER: usize = 8;

/// Memory that a measured cycle occupies until its point is finished, estimated \[bytes\]. Runs of the
/// supplied manifests with up to 160 000 cycles take 18 to 44 MB more than their calibration.
const CYCLE_BYTES: u64 = 300;

/// Largest number of cycles whose memory is counted. Records of one trajectory do not grow from 10⁵ to 10⁷ cycles
/// (docs/robustness.md); the limit for eight trajectories was not measured.
const MOST_CYCLES: u64 = 160_000;

/// Largest number of points per worker that are tried out.
const MOST_A_WORKER: usize = 64;

/// Smallest sample of a larger job: fewer points may all have motion that settles quickly.
const SMALLEST_SAMPLE: usize = 8;

/// Largest processor time of the calibration, divided by the smallest expected time of the run. One point is
/// tried out in any case.
const CALIBRATION_SHARE: f64 = 0.03;

/// Processor time that the calibration may take in any case \[s\].
const FLOOR: f64 = 0.15;

/// Time between two checks of the clock.
const CHECK_INTERVAL: Duration = Duration::from_millis(20);

/// The cost of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Forecast {
    /// Points of the grid (of the shard).
    pub points: u64,
    /// Points of a chain; 1 if points are independent.
    pub chain_length: u64,
    /// Pieces of work that can run at the same time; more threads would idle. Unlimited for a refined grid.
    #[serde(skip)]
    pub pieces: u64,
    /// Mesh tables that are needed, including those already computed.
    pub tables: u64,
    /// Worker threads.
    pub threads: u64,
    /// Intended placement of the threads, in words.
    pub placement: String,
    /// Number of points that were tried out.
    pub calibrated: u64,
    /// Number of these that were abandoned because they took too long; the times are then lower bounds.
    pub cut_short: u64,
    /// Wall time of the calibration, tables included \[s\].
    pub calibration_time: f64,
    /// Wall time of the run if no other program uses its cores \[s\].
    pub time: Interval,
    /// Largest memory of the run \[bytes\]; absent if the memory of the calibration is unknown.
    pub memory: Option<u64>,
    /// Result files \[bytes\].
    pub disk: u64,
    /// The journal, which exists during the run \[bytes\].
    pub journal: u64,
}

/// Tries out a few points for at most about `budget` and predicts the cost of the run. Tables that they need take
/// additional time, and are kept for the run. `None` if the sweep was interrupted. Result files are tried out in the
/// sweep's folder, which must be empty.
///
/// # Errors
/// Threads cannot be started, or the folder cannot be written.
pub fn forecast(sweep: &Sweep<'_>, budget: Duration) -> Result<Option<Forecast>, SweepError> {
    let Sweep {
        job,
        folder: scratch,
        options,
        parts,
        topology,
        interrupt,
    } = *sweep;
    let length = job.chain_length();
    let selection = ChainSelection::of_shard(job, options.shard);
    let crew = start_workers(job, &selection, options, topology)?;
    let threads = crew.threads;
    let all = selection.points();
    let ids = || selection.clone().ids().map(|id| id as usize);
    let workload = Workload {
        points: all,
        chains: selection.chains(),
        length,
        work: ids().map(|id| work(job.points.variant_near(id))).sum(),
        threads,
        shared: shared(job),
    };
    let tables = needed_tables(job, ids());
    let least = sample(all, threads).max(SMALLEST_SAMPLE).min(all);
    let places = drawn(all, least.max(all.min(MOST_A_WORKER * threads)));

    let clock = Instant::now();
    let calibration = Calibration {
        job,
        parts,
        workload,
        least,
        begun: ProcessorClock::Process.now(),
        clock: if workload.shared { ProcessorClock::Process } else { ProcessorClock::Thread },
        over: AtomicBool::new(false),
        tried: Mutex::default(),
    };
    let points = places.iter().map(|&n| selection.id(n)).collect::<Vec<_>>();
    calibration.try_all(&points, &crew, topology, (budget, interrupt))?;
    if interrupt.load(Ordering::Relaxed) {
        return Ok(None);
    }
    let calibration_time = clock.elapsed().as_secs_f64();
    let refining = calibration.refining();
    let prepared = calibration.preparing(tables);
    let most = calibration.most();
    let (sampled, cut_short, rows) = calibration.found();
    let calibrated = rows.len() as u64 + cut_short;

    let mut time = workload.wall_time(&sampled);
    time.expected += refining / threads as f64;
    // The motion may change and change back between two neighbours of the sample.
    time.high += 2.0 * refining / threads as f64;
    // A small sample may have only points whose motion settles, while the others do not.
    if sampled.len() < least && most.is_finite() {
        time.high = time.high.max(2.0 * most / threads as f64);
    }
    let row_bytes = mean_or_zero(&rows, |row| journal_bytes(row) as f64);
    let journal = (row_bytes * all as f64) as u64;
    let most_cycles = (job.points.variants().iter()).map(|variant| variant.run.cycles);
    let records = threads as u64 * CYCLE_BYTES * most_cycles.max().unwrap_or(0).min(MOST_CYCLES);
    // Predict the disk space before the memory is measured, because encoding also takes memory.
    let disk = disk(job, all, rows, scratch)?;
    let memory = peak_memory().map(|peak| memory(peak + records, journal));
    Ok(Some(Forecast {
        points: all as u64,
        chain_length: length as u64,
        pieces: pieces(job, &selection, usize::MAX) as u64,
        tables: tables as u64,
        threads: threads as u64,
        placement: crew.places.to_string(),
        calibrated,
        cut_short,
        calibration_time,
        time: time.after(prepared / threads as f64),
        memory,
        disk,
        journal,
    }))
}

/// The calibration: points that are tried out.
struct Calibration<'a> {
    job: &'a Job,
    parts: &'a Prepared,
    workload: Workload,
    /// Number of points that must be tried out before the time counts as known.
    least: usize,
    /// Processor time of the process at the start of the calibration \[s\].
    begun: f64,
    /// The clock that times points.
    clock: ProcessorClock,
    /// Raised when the time is over.
    over: AtomicBool,
    tried: Mutex<Vec<TriedPoint>>,
}

impl Calibration<'_> {
    /// Tries out points in turn until their time is known accurately enough, for about `budget` at most.
    ///
    /// # Errors
    /// A thread cannot be started.
    fn try_all(
        &self,
        points: &[usize],
        crew: &Workers,
        topology: Option<&Topology>,
        (budget, interrupt): (Duration, &AtomicBool),
    ) -> Result<(), SweepError> {
        let next = AtomicUsize::new(0);
        let (done, waiting) = channel::<()>();
        std::thread::scope(|scope| {
            let over = &self.over;
            let watch = move || {
                let started = Instant::now();
                while waiting.recv_timeout(CHECK_INTERVAL) == Err(RecvTimeoutError::Timeout) {
                    if started.elapsed() >= budget || interrupt.load(Ordering::Relaxed) {
                        over.store(true, Ordering::Relaxed);
                    }
                }
            };
            std::thread::Builder::new()
                .spawn_scoped(scope, watch)
                .map_err(|error| SweepError::threads(crew.threads + 1, &error))?;
            crew.pool.broadcast(|context| {
                let worker = Worker {
                    index: context.index() as u32,
                    topology,
                    seat: None,
                };
                if self.workload.shared && worker.index > 0 {
                    // The other workers help the first one with its point.
                    return;
                }
                while let Some(&id) = points.get(next.fetch_add(1, Ordering::Relaxed)) {
                    if over.load(Ordering::Relaxed) || self.is_enough() {
                        return;
                    }
                    self.try_out(id, worker);
                }
            });
            drop(done);
            Ok(())
        })
    }

    fn tried(&self) -> MutexGuard<'_, Vec<TriedPoint>> {
        lock(&self.tried)
    }

    /// Whether the time is known accurately enough, or the calibration has taken its share.
    fn is_enough(&self) -> bool {
        let sampled: Vec<PointTime> = self.tried().iter().map(|tried| tried.sampled).collect();
        let Interval {
            low,
            expected,
            high,
        } = self.workload.computing(&sampled);
        let many = sampled.len() >= self.least;
        let spent = ProcessorClock::Process.now() - self.begun;
        let next = spent / sampled.len().max(1) as f64;
        // The points of a small sample may all have motion that settles.
        let run = if many { low } else { self.most() };
        many && high - expected <= ACCURATE_ENOUGH * expected
            || !sampled.is_empty() && spent + next >= FLOOR.max(CALIBRATION_SHARE * run)
    }

    /// Computing time of all points if none settled \[s\].
    fn most(&self) -> f64 {
        let tried = self.tried();
        let work: f64 = tried.iter().map(|tried| tried.sampled.work).sum();
        self.workload.work * tried.iter().map(|tried| tried.most).sum::<f64>() / work
    }

    /// Processor time of all mesh tables and structures \[s\], estimated from the points that were tried out.
    fn preparing(&self, tables: usize) -> f64 {
        let tried = self.tried();
        let known = needed_tables(self.job, tried.iter().map(|tried| tried.id));
        let all = match (tables, self.job.points.variants().len()) {
            // One structure serves all points.
            (0, 1) => 1.0,
            (0, _) => self.workload.points as f64 / tried.len().max(1) as f64,
            _ => tables as f64 / known.max(1) as f64,
        };
        all * tried.iter().map(|tried| tried.prepared).sum::<f64>()
    }

    /// Tries out a point and records the result.
    fn try_out(&self, id: usize, worker: Worker<'_>) {
        let (job, parts, over) = (self.job, self.parts, &self.over);
        if let Ok(tried) = try_out(job, id, parts, worker, self.clock, over) {
            self.tried().push(tried);
        }
    }

    /// Computing time for narrowing down changes of motion \[s\], from changes between neighbours of the sample.
    fn refining(&self) -> f64 {
        let (job, length) = (self.job, self.job.chain_length());
        let mut tried = self.tried();
        tried.sort_by_key(|tried| tried.id);
        let between = |pair: &[TriedPoint]| {
            let [a, b] = [&pair[0], &pair[1]];
            let variant = job.points.variant_near(b.id);
            let halvings = halvings(&variant.analyses);
            let (Some(from), Some(to)) = (a.motion, b.motion) else {
                return 0.0;
            };
            if a.id / length == b.id / length && from != to {
                f64::from(halvings) * 0.5 * (a.sampled.ratio() + b.sampled.ratio()) * b.sampled.work
            } else {
                0.0
            }
        };
        tried.windows(2).map(between).sum()
    }

    /// The times of the points in order, the number of abandoned ones, and rows of the others. Omits abandoned points
    /// that took less time per work than the average of the others: they have no information.
    fn found(self) -> (Vec<PointTime>, u64, Vec<PointRow>) {
        let mut tried = self
            .tried
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner);
        tried.sort_by_key(|tried| tried.id);
        let ratio = |tried: &TriedPoint| tried.sampled.ratio();
        let whole: Vec<f64> = (tried.iter().filter(|tried| tried.row.is_some()))
            .map(ratio)
            .collect();
        let middle = if whole.is_empty() { 0.0 } else { mean(&whole) };
        let telling = |tried: &TriedPoint| tried.row.is_some() || ratio(tried) > middle;
        let tried: Vec<_> = tried.into_iter().filter(telling).collect();
        let cut_short = tried.iter().filter(|tried| tried.row.is_none()).count() as u64;
        let sampled = tried.iter().map(|tried| tried.sampled).collect();
        let rows = tried.into_iter().filter_map(|tried| tried.row).collect();
        (sampled, cut_short, rows)
    }
}

fn mean_or_zero(rows: &[PointRow], value: impl Fn(&PointRow) -> f64) -> f64 {
    if rows.is_empty() {
        0.0
    } else {
        mean(&rows.iter().map(value).collect::<Vec<f64>>())
    }
}

/// Memory of a run \[bytes\], from the memory of the calibration and the size of the journal. Rows are in memory while
/// they wait for older points and until their row group is written.
fn memory(peak: u64, journal: u64) -> u64 {
    /// Growth of memory in a long run, by fragmentation.
    const IN_PIECES: f64 = 1.25;
    /// Memory of a row that waits and is encoded, divided by its size in the journal, where a small number takes one
    /// byte.
    const ENCODED: u64 = 6;
    /// Upper limit of the memory of rows \[bytes\]: a row group is written once it has [`GROUP_BYTES`].
    const MOST_ROW_BYTES: u64 = 8 * GROUP_BYTES as u64;
    (IN_PIECES * peak as f64) as u64 + (ENCODED * journal).min(MOST_ROW_BYTES)
}

/// Smallest number of points to be tried out, before [`SMALLEST_SAMPLE`] applies.
fn sample(points: usize, threads: usize) -> usize {
    (points / 4).clamp(2, POINTS_A_WORKER * threads.max(2))
}

/// Whether several threads compute one point.
fn shared(job: &Job) -> bool {
    let mut variants = job.points.variants().iter();
    variants.any(|variant| variant.analyses.multistability.is_some())
}

/// Predicted size of the result files \[bytes\] of `points` points that resemble `rows`.
fn disk(job: &Job, points: usize, rows: Vec<PointRow>, scratch: &Path) -> Result<u64, StoreError> {
    let count = rows.len().max(1) as u64;
    let mut sizes = [0, 0];
    for (size, rows) in sizes.iter_mut().zip([Vec::new(), rows]) {
        let ids: Vec<u64> = rows.iter().map(|row| row.point_id).collect();
        let mut writer = ResultWriter::create(scratch, &layout(job, None), ids)?;
        for row in rows {
            writer.push(row)?;
        }
        writer.finish()?;
        let refused = |error| StoreError::io(scratch, "read", error);
        for entry in std::fs::read_dir(scratch).map_err(refused)? {
            *size += entry
                .and_then(|entry| entry.metadata())
                .map_err(refused)?
                .len();
        }
    }
    let [empty, some] = sizes;
    Ok(empty + some.saturating_sub(empty) * points as u64 / count)
}
