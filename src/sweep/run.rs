//! The pool, the channel and the writer.

use super::build::Parts;
use super::chain::{Link, compute};
use super::point::Worker;
use crate::analysis::Status;
use crate::manifest::{Axis, Job};
use crate::store::{
    AxisColumn, ChainColumns, Journal, PointRow, ResultLayout, ResultWriter, SYNC_INTERVAL, Shard,
    StoreError,
};
use crate::topology::Topology;
use crossbeam_channel::{Receiver, RecvTimeoutError, bounded};
use std::collections::HashMap;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::time::Duration;

/// Rows on their way from workers to the writer.
const CHANNEL: usize = 256;

/// Points handed out beyond the oldest unfinished one; a chain a worker where that is more.
/// Bounds what the writer has to keep in memory when one point takes much longer than its
/// neighbours. It is looked at between chains only, so that the oldest always goes on.
const AHEAD: usize = 4096;

/// How a sweep is to be run.
#[derive(Debug, Clone, Copy, Default)]
pub struct Options {
    /// Worker threads; one a core where absent.
    pub threads: Option<usize>,
    /// Part of a split job.
    pub shard: Option<Shard>,
}

/// Where a sweep stands, after every finished point.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Progress {
    /// Points finished.
    pub done: u64,
    /// Of these, with a status other than ok.
    pub not_ok: u64,
    /// Of these, with status failed, diverged or event_storm.
    pub failed: u64,
    /// Of `done`, taken over from an earlier, interrupted run.
    pub resumed: u64,
    /// Mesh cycles marched by this run.
    pub cycles: u64,
}

impl Progress {
    fn count(&mut self, row: &PointRow) {
        let status = &row.outcome.status;
        self.done += 1;
        self.not_ok += u64::from(*status != Status::Ok);
        self.failed += u64::from(!matches!(status, Status::Ok | Status::NotConverged));
    }
}

/// Told about every finished point, from the writer's thread.
pub trait Watcher: Send {
    /// Points of an earlier run were taken over; nothing has been computed yet.
    fn resumed(&mut self, progress: &Progress);

    /// A point was finished and handed to the writer.
    fn point(&mut self, row: &PointRow, progress: &Progress);
}

/// How a sweep ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Finished {
    /// Points of this run.
    pub points: u64,
    /// What was done of them.
    pub progress: Progress,
    /// Points not computed, because the sweep was called off.
    pub missing: u64,
    /// Worker threads used.
    pub threads: usize,
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

/// Indices into a job's points that belong to a shard: every n-th chain, so that neighbours,
/// which cost alike, are dealt out evenly. `chain` is the length of a chain, 1 where points
/// are independent.
pub fn shard_points(points: usize, chain: usize, shard: Option<Shard>) -> Vec<usize> {
    let (first, step) = shard.map_or((0, 1), |s| (s.index as usize - 1, s.count as usize));
    (0..points)
        .step_by(chain)
        .skip(first)
        .step_by(step)
        .flat_map(|begin| begin..begin + chain)
        .collect()
}

/// A chain that is not finished.
struct Turn {
    /// Where it stands among all points of this run.
    place: usize,
    /// Its first point.
    first: usize,
    /// What is known of it from an earlier run.
    link: Link,
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
    options: Options,
    parts: &Parts,
    journal: &mut Journal,
    topology: Option<&Topology>,
    called_off: &AtomicBool,
    watcher: &mut dyn Watcher,
) -> Result<Finished, SweepError> {
    let length = job.chain_length();
    let all = shard_points(job.points.len(), length, options.shard);
    let ids: Vec<u64> = all.iter().map(|&i| job.points[i].point_id).collect();
    let mut writer = ResultWriter::create(folder, &layout(job, options.shard), ids)?;
    let mut progress = Progress::default();
    let mut done = vec![false; job.points.len() / length];
    let mut links: HashMap<usize, Link> = HashMap::new();
    journal.replay(|row| {
        let point_id = row.point_id;
        let (chain, place) = (point_id as usize / length, point_id as usize % length);
        let done = done
            .get_mut(chain)
            .ok_or(StoreError::UnexpectedPoint { point_id })?;
        if *done {
            // Twice the same point, twice the same numbers.
            return Ok(());
        }
        let link = links.entry(chain).or_default();
        if place < link.passed() {
            return Ok(());
        }
        if place > link.passed() {
            return Err(StoreError::UnexpectedPoint { point_id });
        }
        link.pass(job, &row);
        if link.passed() == length {
            *done = true;
            links.remove(&chain);
        }
        progress.count(&row);
        writer.push(row)
    })?;
    progress.resumed = progress.done;
    watcher.resumed(&progress);
    let queue: Vec<Turn> = (0..all.len())
        .step_by(length)
        .filter(|&place| !done[all[place] / length])
        .map(|place| Turn {
            place,
            first: all[place],
            link: links.remove(&(all[place] / length)).unwrap_or_default(),
        })
        .collect();
    let threads = options
        .threads
        .or(topology.map(|t| t.cores.len()))
        .or(std::thread::available_parallelism().ok().map(usize::from))
        .unwrap_or(1)
        .clamp(1, work(job, &queue).max(1));
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(|i| format!("atlas-{i}"))
        .build()
        .map_err(|error| SweepError::Threads {
            threads,
            reason: error.to_string(),
        })?;

    pool.install(|| parts.prepare(queue.iter().map(|turn| &job.points[turn.first]), &mut || ()));

    let ahead = AHEAD.max(threads * length) as u64;
    let next = AtomicUsize::new(0);
    let written = AtomicU64::new(progress.done - writer.waiting() as u64);
    let (sender, receiver) = bounded(CHANNEL);
    let ended = std::thread::scope(|scope| {
        let mut recorder = Recorder {
            writer,
            journal,
            progress,
            watcher,
            written: &written,
        };
        let writing = scope.spawn(move || {
            let recorded = recorder.record_all(&receiver);
            if recorded.is_err() {
                // Nothing more can be kept: no use in computing on.
                called_off.store(true, Ordering::Relaxed);
            }
            recorded?;
            recorder.finish()
        });
        pool.broadcast(|context| {
            let worker = Worker {
                index: context.index() as u32,
                topology,
            };
            let sender = sender.clone();
            while let Some(turn) = queue.get(next.fetch_add(1, Ordering::Relaxed)) {
                while turn.place as u64 >= written.load(Ordering::Relaxed) + ahead
                    && !called_off.load(Ordering::Relaxed)
                {
                    std::thread::sleep(Duration::from_millis(1));
                }
                let mut link = turn.link.clone();
                while link.passed() < length {
                    if called_off.load(Ordering::Relaxed) {
                        return;
                    }
                    let point = &job.points[turn.first + link.passed()];
                    let Ok(row) = compute(job, point, &link, parts, worker, called_off) else {
                        return;
                    };
                    link.pass(job, &row);
                    if sender.send(row).is_err() {
                        // The writer has given up.
                        return;
                    }
                }
            }
        });
        drop(sender);
        writing
            .join()
            .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    });
    let (progress, missing) = ended?;
    Ok(Finished {
        points: all.len() as u64,
        progress,
        missing,
        threads,
    })
}

/// What the writer's thread works on.
struct Recorder<'a> {
    writer: ResultWriter,
    journal: &'a mut Journal,
    progress: Progress,
    watcher: &'a mut dyn Watcher,
    /// Points that have left the writer's memory, for the workers to see.
    written: &'a AtomicU64,
}

impl Recorder<'_> {
    /// Takes rows until the channel closes.
    fn record_all(&mut self, receiver: &Receiver<PointRow>) -> Result<(), StoreError> {
        loop {
            match receiver.recv_timeout(SYNC_INTERVAL) {
                Ok(row) => self.record(row)?,
                Err(RecvTimeoutError::Timeout) => self.journal.sync_if_due()?,
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
        }
    }

    fn record(&mut self, row: PointRow) -> Result<(), StoreError> {
        self.journal.append(&row)?;
        self.progress.count(&row);
        self.progress.cycles += row.outcome.cycles;
        self.watcher.point(&row, &self.progress);
        self.writer.push(row)?;
        let waiting = self.writer.waiting() as u64;
        self.written
            .store(self.progress.done - waiting, Ordering::Relaxed);
        Ok(())
    }

    /// Where the run stands at its end, and the number of points that are missing.
    fn finish(self) -> Result<(Progress, u64), StoreError> {
        self.journal.sync()?;
        let written = self.writer.finish()?;
        Ok((self.progress, written.missing))
    }
}

/// Pieces of work that may be done at the same time: points, and probes where there are any.
fn work(job: &Job, queue: &[Turn]) -> usize {
    let pieces = queue.iter().map(|turn| {
        let probes = job.points[turn.first].analyses.multistability;
        probes.map_or(1, |asked| asked.initial_conditions as usize)
    });
    pieces.sum()
}

fn layout(job: &Job, shard: Option<Shard>) -> ResultLayout {
    let any = |pick: fn(&crate::manifest::AnalysesSpec) -> bool| {
        job.points.iter().any(|p| pick(&p.analyses))
    };
    let column = |axis: &Axis| AxisColumn {
        name: axis.name.clone(),
        unit: axis.unit.clone(),
    };
    ResultLayout {
        axes: job.axes.iter().map(column).collect(),
        poincare: any(|a| a.poincare.is_some()),
        spectra: any(|a| a.nvh.is_some_and(|n| n.spectrum)),
        probes: any(|a| a.multistability.is_some()),
        orbits: any(|a| a.orbits.is_some()),
        chains: job.carried.as_ref().map(|carried| ChainColumns {
            axis: column(&job.axes[carried.axis]),
            transitions: any(|a| a.poincare.is_some_and(|p| p.refine > 0)),
        }),
        basins: job
            .points
            .iter()
            .find_map(|p| p.analyses.multistability?.slice)
            .map(|slice| slice.modes.map(|mode| slice_axis(mode, slice.velocity))),
        horizon: any(|a| a.horizon.is_some()),
        shard,
    }
}

/// What a slice varies along a mode, counted from 0.
fn slice_axis(mode: usize, velocity: bool) -> String {
    let mode = mode + 1;
    if velocity {
        format!("velocity of mode {mode} as mesh deflection")
    } else {
        format!("mesh deflection by mode {mode}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_cover_every_point_once() {
        for (points, chain, count) in [(0, 1, 1), (1, 1, 3), (80, 1, 7), (81, 1, 80), (84, 12, 3)] {
            let mut seen = vec![0; points];
            for index in 1..=count {
                let own = shard_points(points, chain, Some(Shard { index, count }));
                for whole in own.chunks(chain) {
                    assert!(whole[0].is_multiple_of(chain), "chains stay whole");
                    assert!(whole.windows(2).all(|pair| pair[1] == pair[0] + 1));
                }
                for i in own {
                    seen[i] += 1;
                }
            }
            assert!(seen.iter().all(|n| *n == 1));
            assert_eq!(shard_points(points, chain, None).len(), points);
        }
    }
}
