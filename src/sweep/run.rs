//! The pool and the channel between workers and writer.

use super::build::Parts;
use super::chain::compute;
use super::layout::layout;
use super::point::Worker;
use super::queue::{Next, Queue};
use super::recorder::{Begun, Progress, Recorder, Watcher};
use super::turns::{TakenOver, shard_points};
use crate::manifest::Job;
use crate::store::{Journal, ResultWriter, Shard, StoreError};
use crate::topology::{Pinning, Plan, Topology, default_workers, plan};
use crossbeam_channel::bounded;
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Rows on their way from workers to the writer.
const CHANNEL: usize = 256;

/// How a sweep is to be run.
#[derive(Debug, Clone, Copy, Default)]
pub struct Options<'a> {
    /// Worker threads; one a core where absent.
    pub threads: Option<usize>,
    /// Whether workers are bound to their cores.
    pub pinning: Pinning,
    /// Part of a split job.
    pub shard: Option<Shard>,
    /// Only these points, whole chains of them; the files are those of an undivided run.
    pub only: Option<&'a BTreeSet<u64>>,
    /// Failed points, those taken over not counted, after which the sweep is called off.
    pub most_failures: Option<u64>,
}

/// How a sweep ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finished {
    /// Points of this run.
    pub points: u64,
    /// What was done of them.
    pub progress: Progress,
    /// Points not computed, because the sweep was called off.
    pub missing: u64,
    /// Worker threads used.
    pub threads: usize,
    /// Where they were to run, in words.
    pub asked: String,
    /// Where they ran.
    pub obtained: String,
    /// Whether it was called off for its failed points.
    pub gave_up: bool,
}

/// Why a sweep could not run.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// Results cannot be written.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// Threads cannot be started.
    #[error("cannot start {threads} worker threads: {reason}; ask for fewer with --threads")]
    Threads {
        /// How many were asked for.
        threads: usize,
        /// What the system says.
        reason: String,
    },
}

/// Runs a job and writes its tables to `folder`. Points in the journal are taken over, the
/// others are computed and appended to it; it is the caller's to remove once everything
/// else is written. Raising `called_off` drops the points in flight; what is finished is
/// written.
///
/// # Errors
/// Threads cannot be started, or results cannot be written; the sweep then stops.
pub fn run(
    job: &Job,
    folder: &Path,
    options: Options<'_>,
    parts: &Parts,
    journal: &mut Journal,
    topology: Option<&Topology>,
    called_off: &AtomicBool,
    watcher: &mut dyn Watcher,
) -> Result<Finished, SweepError> {
    let length = job.chain_length();
    let mut all = shard_points(job.points.len(), length, options.shard);
    if let Some(only) = options.only {
        all.retain(|&i| only.contains(&job.points[i].point_id));
    }
    let shard = options.shard.filter(|_| options.only.is_none());
    let ids: Vec<u64> = all.iter().map(|&i| job.points[i].point_id).collect();
    let mut writer = ResultWriter::create(folder, &layout(job, shard), ids)?;
    let mut progress = Progress::default();
    let taken_over = TakenOver::replay(job, journal, |row| {
        progress.count(&row);
        writer.push(row)
    })?;
    progress.resumed = progress.done;
    let turns = taken_over.rest(&all);
    let firsts = turns.iter().map(|turn| turn.first);
    let Crew {
        pool,
        threads,
        seats,
        obtained,
    } = start_workers(job, firsts, options, topology)?;
    let asked = seats.to_string();
    watcher.begun(&Begun {
        points: all.len() as u64,
        progress,
        threads,
        asked: &asked,
        obtained: &obtained,
    });

    let shards = shard.map_or(1, |shard| shard.count as usize);
    let queue = Queue::new(job, all.len(), turns, shards, threads);
    let firsts = queue.turns().iter().map(|turn| &job.points[turn.first]);
    pool.install(|| parts.prepare(firsts, &mut || ()));
    for warning in parts.meshes().warnings() {
        watcher.warning(&warning);
    }

    let written = AtomicU64::new(progress.done - writer.waiting() as u64);
    let (sender, receiver) = bounded(CHANNEL);
    let ended = std::thread::scope(|scope| {
        let recorder = Recorder {
            writer,
            journal,
            progress,
            watcher,
            begun: Instant::now(),
            written: &written,
            most_failures: options.most_failures,
            called_off,
        };
        let writing = scope.spawn(move || {
            let recorded = recorder.record_all(&receiver);
            if recorded.is_err() {
                // Nothing more can be kept: no use in computing on.
                called_off.store(true, Ordering::Relaxed);
            }
            recorded
        });
        pool.broadcast(|context| {
            let worker = Worker {
                index: context.index() as u32,
                topology,
            };
            let sender = sender.clone();
            while !called_off.load(Ordering::Relaxed) {
                let index = match queue.next(written.load(Ordering::Relaxed)) {
                    Next::Chain(index) => index,
                    Next::Wait => {
                        std::thread::sleep(Duration::from_millis(1));
                        continue;
                    }
                    Next::End => return,
                };
                let turn = &queue.turns()[index];
                let (mut link, clock) = (turn.link.clone(), Instant::now());
                while link.passed() < length {
                    let point = &job.points[turn.first + link.passed()];
                    let Ok(row) = compute(job, point, &link, parts, worker, called_off) else {
                        return;
                    };
                    link.pass(job, &row);
                    if sender.send(row).is_err() {
                        // The writer has given up.
                        return;
                    }
                    if called_off.load(Ordering::Relaxed) {
                        return;
                    }
                }
                queue.finished(index, clock.elapsed());
            }
        });
        drop(sender);
        writing
            .join()
            .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    });
    let recorded = ended?;
    Ok(Finished {
        points: all.len() as u64,
        progress: recorded.progress,
        missing: recorded.missing,
        threads,
        asked,
        obtained,
        gave_up: recorded.gave_up,
    })
}

/// Threads that are ready to work.
pub(super) struct Crew {
    pub pool: rayon::ThreadPool,
    pub threads: usize,
    /// Where they were to sit.
    pub seats: Plan,
    /// Where they sit, in words.
    pub obtained: String,
}

/// Starts the workers for chains with these first points: as many as asked for, or one a
/// core, and no more than there are pieces of work.
pub(super) fn start_workers(
    job: &Job,
    firsts: impl Iterator<Item = usize>,
    options: Options<'_>,
    topology: Option<&Topology>,
) -> Result<Crew, SweepError> {
    let cores = topology.map_or(&[][..], |t| &t.cores);
    let parallelism = std::thread::available_parallelism().ok();
    let threads = options
        .threads
        .unwrap_or_else(|| default_workers(cores.len(), parallelism.map(usize::from)))
        .clamp(1, pieces(job, firsts).max(1));
    let seats = plan(cores, threads, options.pinning);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(|i| format!("atlas-{i}"))
        .build()
        .map_err(|error| SweepError::Threads {
            threads,
            reason: error.to_string(),
        })?;
    let obtained = take_seats(&pool, &seats, topology);
    Ok(Crew {
        pool,
        threads,
        seats,
        obtained,
    })
}

/// Binds every worker to its seat where that is planned; says what came of it. A worker that
/// cannot be bound works where the system puts it.
fn take_seats(pool: &rayon::ThreadPool, seats: &Plan, topology: Option<&Topology>) -> String {
    let Some(topology) = topology.filter(|_| seats.pinned) else {
        return "not pinned".into();
    };
    let taken = pool.broadcast(|context| {
        let seat = &seats.seats[context.index()];
        topology.bind_current_thread(&seat.threads)
    });
    let bound = taken.iter().filter(|taken| taken.is_ok()).count();
    match taken.iter().find_map(|taken| taken.as_ref().err()) {
        None => "pinned".into(),
        Some(error) => format!("{bound} of {} workers pinned: {error}", taken.len()),
    }
}

/// Pieces of work that may be done at the same time: points, and probes where there are any.
fn pieces(job: &Job, firsts: impl Iterator<Item = usize>) -> usize {
    let pieces = firsts.map(|first| {
        let probes = job.points[first].analyses.multistability;
        probes.map_or(1, |asked| asked.initial_conditions as usize)
    });
    pieces.sum()
}
