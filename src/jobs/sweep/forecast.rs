//! What a run will take: its time with an interval, its memory and its disk space, from a few
//! points that are tried out beforehand.
//!
//! Points are drawn over the grid until the time is known well enough, or [`SHARE`] of it is spent. Of a
//! chain, the point before is tried out too, as if it were the first, so that
//! the one that is timed starts from a settled motion as it does in a sweep. What the
//! refinement of changes takes is added for every change between neighbours of the sample: most
//! points meet none, and a few would say little of how many do.

use super::estimate::{Interval, Load, Sampled, drawn};
use super::layout::layout;
use super::parts::{Prepared, tables_wanted};
use super::point::Worker;
use super::queue::work;
use super::run::{Sweep, SweepError, Workers, pieces, start_workers};
use super::trial::{Tried, try_out};
use super::turns::Share;
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

/// Half width of the interval of the computing time, over the time, at which it is known well
/// enough.
const CLOSE: f64 = 0.15;

/// Most points of a first sample, per worker.
const POINTS_A_WORKER: usize = 8;

/// What is kept of a measured cycle until its point is finished, an estimate \[bytes\]: runs of
/// shipped manifests with a budget of 160 000 cycles hold 18 to 44 MB more than a plan that tries their
/// points out.
const CYCLE_BYTES: u64 = 300;

/// Cycles beyond which no growth is counted. Records of one trajectory do not grow from 10⁵ to 10⁷ cycles
/// (docs/robustness.md); where those of eight stop was not measured.
const MOST_CYCLES: u64 = 160_000;

/// Most points that are tried out, a worker.
const MOST_A_WORKER: usize = 64;

/// Fewest points that the time is known from, where there are so many: fewer may all be of the motion
/// that is quick to settle.
const FEWEST: usize = 8;

/// Processor time that trying out may take, over that of the run at least; one point is tried out in any case.
const SHARE: f64 = 0.03;

/// Processor time that trying out may take in any case \[s\].
const FLOOR: f64 = 0.15;

/// Time between two looks at the clock.
const LOOK_UP: Duration = Duration::from_millis(20);

/// What a run will take.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Forecast {
    /// Points of the grid (of the shard).
    pub points: u64,
    /// Points of a chain; 1 where points are independent.
    pub chain_length: u64,
    /// Pieces of work that may be done at the same time: more threads have nothing to do. A refined grid has any
    /// number.
    #[serde(skip)]
    pub pieces: u64,
    /// Mesh tables needed, computed already or not.
    pub tables: u64,
    /// Worker threads.
    pub threads: u64,
    /// Where they are to run, in words.
    pub placement: String,
    /// Points tried out to know.
    pub calibrated: u64,
    /// Of these, given up because they took too long: the times are then at least what is
    /// said.
    pub cut_short: u64,
    /// Wall time of the calibration, tables included \[s\].
    pub calibration_time: f64,
    /// Wall time of the run, where nothing else works on its cores \[s\].
    pub time: Interval,
    /// Most memory that it takes \[bytes\]; absent where the system does not tell what the
    /// calibration took.
    pub memory: Option<u64>,
    /// Result files \[bytes\].
    pub disk: u64,
    /// The journal, which is there while the run lasts \[bytes\].
    pub journal: u64,
}

/// Tries out a few points for at most about `budget` (tables that they need come on top, and are kept
/// for the run), and says what the run will take; nothing where the sweep was called off meanwhile. Result files
/// are tried out in its folder, which is to be empty.
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
        called_off,
    } = *sweep;
    let length = job.chain_length();
    let share = Share::of_shard(job, options.shard);
    let crew = start_workers(job, &share, options, topology)?;
    let threads = crew.threads;
    let all = share.points();
    let ids = || share.clone().ids().map(|id| id as usize);
    let load = Load {
        points: all,
        chains: share.chains(),
        length,
        work: ids().map(|id| work(job.points.variant_near(id))).sum(),
        threads,
        shared: shared(job),
    };
    let tables = tables_wanted(job, ids());
    let least = sample(all, threads).max(FEWEST.min(all));
    let places = drawn(all, least.max(all.min(MOST_A_WORKER * threads)));

    let clock = Instant::now();
    let calibration = Calibration {
        job,
        parts,
        load,
        least,
        begun: ProcessorClock::Process.now(),
        clock: if load.shared { ProcessorClock::Process } else { ProcessorClock::Thread },
        over: AtomicBool::new(false),
        tried: Mutex::default(),
    };
    let points = places.iter().map(|&n| share.id(n)).collect::<Vec<_>>();
    calibration.try_all(&points, &crew, topology, (budget, called_off))?;
    if called_off.load(Ordering::Relaxed) {
        return Ok(None);
    }
    let calibration_time = clock.elapsed().as_secs_f64();
    let refining = calibration.refining();
    let prepared = calibration.preparing(tables);
    let most = calibration.most();
    let (sampled, cut_short, rows) = calibration.found();
    let calibrated = rows.len() as u64 + cut_short;

    let mut time = load.wall_time(&sampled);
    time.expected += refining / threads as f64;
    // A change may come and go between two neighbours.
    time.high += 2.0 * refining / threads as f64;
    // A few points may all be of the motion that settles, and the others of none.
    if sampled.len() < least && most.is_finite() {
        time.high = time.high.max(2.0 * most / threads as f64);
    }
    let row_bytes = mean_or_zero(&rows, |row| journal_bytes(row) as f64);
    let journal = (row_bytes * all as f64) as u64;
    let most_cycles = (job.points.variants().iter()).map(|variant| variant.run.cycles);
    let records = threads as u64 * CYCLE_BYTES * most_cycles.max().unwrap_or(0).min(MOST_CYCLES);
    // Before the memory is looked at, which encoding takes up too.
    let disk = disk(job, all, rows, scratch)?;
    let memory = peak_memory().map(|peak| memory(peak + records, journal));
    Ok(Some(Forecast {
        points: all as u64,
        chain_length: length as u64,
        pieces: pieces(job, &share, usize::MAX) as u64,
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

/// Points that are tried out.
struct Calibration<'a> {
    job: &'a Job,
    parts: &'a Prepared,
    load: Load,
    /// Fewest points that the time is known from.
    least: usize,
    /// Processor time of the process when trying out began \[s\].
    begun: f64,
    /// What points are timed with.
    clock: ProcessorClock,
    /// Raised when no more time is left.
    over: AtomicBool,
    tried: Mutex<Vec<Tried>>,
}

impl Calibration<'_> {
    /// Tries out points in turn until their time is known well enough, for about `budget` at most.
    ///
    /// # Errors
    /// A thread cannot be started.
    fn try_all(
        &self,
        points: &[usize],
        crew: &Workers,
        topology: Option<&Topology>,
        (budget, called_off): (Duration, &AtomicBool),
    ) -> Result<(), SweepError> {
        let next = AtomicUsize::new(0);
        let (done, waiting) = channel::<()>();
        std::thread::scope(|scope| {
            let over = &self.over;
            let watch = move || {
                let started = Instant::now();
                while waiting.recv_timeout(LOOK_UP) == Err(RecvTimeoutError::Timeout) {
                    if started.elapsed() >= budget || called_off.load(Ordering::Relaxed) {
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
                };
                if self.load.shared && worker.index > 0 {
                    // The others help with the point.
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

    fn tried(&self) -> MutexGuard<'_, Vec<Tried>> {
        self.tried.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether the time is known well enough, or trying out has taken its share.
    fn is_enough(&self) -> bool {
        let sampled: Vec<Sampled> = self.tried().iter().map(|tried| tried.sampled).collect();
        let Interval {
            low,
            expected,
            high,
        } = self.load.computing(&sampled);
        let many = sampled.len() >= self.least;
        let spent = ProcessorClock::Process.now() - self.begun;
        let next = spent / sampled.len().max(1) as f64;
        // A few points may all be of the motion that settles.
        let run = if many { low } else { self.most() };
        many && high - expected <= CLOSE * expected
            || !sampled.is_empty() && spent + next >= FLOOR.max(SHARE * run)
    }

    /// Computing time of all points if none settled \[s\].
    fn most(&self) -> f64 {
        let tried = self.tried();
        let work: f64 = tried.iter().map(|tried| tried.sampled.work).sum();
        self.load.work * tried.iter().map(|tried| tried.most).sum::<f64>() / work
    }

    /// Processor time of all mesh tables and structures \[s\], by those of the points that were tried out.
    fn preparing(&self, tables: usize) -> f64 {
        let tried = self.tried();
        let known = tables_wanted(self.job, tried.iter().map(|tried| tried.id));
        let all = match (tables, self.job.points.variants().len()) {
            // One structure serves all points.
            (0, 1) => 1.0,
            (0, _) => self.load.points as f64 / tried.len().max(1) as f64,
            _ => tables as f64 / known.max(1) as f64,
        };
        all * tried.iter().map(|tried| tried.prepared).sum::<f64>()
    }

    /// Tries out a point and keeps what was learnt.
    fn try_out(&self, id: usize, worker: Worker<'_>) {
        let (job, parts, over) = (self.job, self.parts, &self.over);
        if let Ok(tried) = try_out(job, id, parts, worker, self.clock, over) {
            self.tried().push(tried);
        }
    }

    /// Computing time that narrowing down changes of motion takes \[s\], by those between
    /// neighbours of the sample.
    fn refining(&self) -> f64 {
        let (job, length) = (self.job, self.job.chain_length());
        let mut tried = self.tried();
        tried.sort_by_key(|tried| tried.id);
        let between = |pair: &[Tried]| {
            let [a, b] = [&pair[0], &pair[1]];
            let variant = job.points.variant_near(b.id);
            let halvings = variant
                .analyses
                .poincare
                .as_ref()
                .map_or(0, |asked| asked.refine);
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

    /// What points took, in their order, how many were given up, rows of the others. One that was given
    /// up sooner than the others took on average does not count: it says nothing.
    fn found(self) -> (Vec<Sampled>, u64, Vec<PointRow>) {
        let mut tried = self
            .tried
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner);
        tried.sort_by_key(|tried| tried.id);
        let ratio = |tried: &Tried| tried.sampled.ratio();
        let whole: Vec<f64> = (tried.iter().filter(|tried| tried.row.is_some()))
            .map(ratio)
            .collect();
        let middle = if whole.is_empty() { 0.0 } else { mean(&whole) };
        let telling = |tried: &Tried| tried.row.is_some() || ratio(tried) > middle;
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

/// Most memory of a run, from what trying its points out took and the size of its journal \[bytes\].
/// Rows are in memory while they wait for older points and until their row group is written.
fn memory(peak: u64, journal: u64) -> u64 {
    /// A long run over a short one: memory that is free but in pieces.
    const IN_PIECES: f64 = 1.25;
    /// A row that waits and is being encoded over the same in the journal, where a small number takes a
    /// byte.
    const ENCODED: u64 = 6;
    /// Groups are written when they are as large.
    const MOST: u64 = 8 * GROUP_BYTES as u64;
    (IN_PIECES * peak as f64) as u64 + (ENCODED * journal).min(MOST)
}

/// Points of a sample of so many, on so many threads.
fn sample(points: usize, threads: usize) -> usize {
    (points / 4).clamp(2, POINTS_A_WORKER * threads.max(2))
}

/// Whether threads share points.
fn shared(job: &Job) -> bool {
    let mut variants = job.points.variants().iter();
    variants.any(|variant| variant.analyses.multistability.is_some())
}

/// Size of the result files of so many points like these \[bytes\].
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
