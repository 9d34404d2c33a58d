//! The pool, the channel and the writer.

use super::build::StructureCache;
use super::point::{Worker, compute};
use crate::analysis::Status;
use crate::manifest::Job;
use crate::store::{
    AxisColumn, Journal, PointRow, ResultLayout, ResultWriter, SYNC_INTERVAL, Shard, StoreError,
};
use crate::topology::Topology;
use crossbeam_channel::{Receiver, RecvTimeoutError, bounded};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::time::Duration;

/// Rows on their way from workers to the writer.
const CHANNEL: usize = 256;

/// Points handed out beyond the oldest unfinished one. Bounds what the writer has to keep
/// in memory when one point takes much longer than its neighbours.
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

/// Indices into a job's points that belong to a shard: every n-th, so that neighbours, which
/// cost alike, are dealt out evenly.
pub fn shard_points(points: usize, shard: Option<Shard>) -> Vec<usize> {
    match shard {
        None => (0..points).collect(),
        Some(s) => (s.index as usize - 1..points)
            .step_by(s.count as usize)
            .collect(),
    }
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
    journal: &mut Journal,
    topology: Option<&Topology>,
    called_off: &AtomicBool,
    watcher: &mut dyn Watcher,
) -> Result<Finished, SweepError> {
    let all = shard_points(job.points.len(), options.shard);
    let ids: Vec<u64> = all.iter().map(|&i| job.points[i].point_id).collect();
    let mut writer = ResultWriter::create(folder, &layout(job, options.shard), ids)?;
    let mut progress = Progress::default();
    let mut known = vec![false; job.points.len()];
    journal.replay(|row| {
        match known.get_mut(row.point_id as usize) {
            // Twice the same point, twice the same numbers.
            Some(true) => return Ok(()),
            Some(known) => *known = true,
            None => {
                return Err(StoreError::UnexpectedPoint {
                    point_id: row.point_id,
                });
            }
        }
        progress.count(&row);
        writer.push(row)
    })?;
    progress.resumed = progress.done;
    watcher.resumed(&progress);
    // Every point that is left, with its place among all points of this run.
    let queue: Vec<(usize, usize)> = (0..)
        .zip(all.iter().copied())
        .filter(|&(_, index)| !known[index])
        .collect();
    let threads = options
        .threads
        .or(topology.map(|t| t.cores.len()))
        .or(std::thread::available_parallelism().ok().map(usize::from))
        .unwrap_or(1)
        .clamp(1, queue.len().max(1));
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(|i| format!("atlas-{i}"))
        .build()
        .map_err(|error| SweepError::Threads {
            threads,
            reason: error.to_string(),
        })?;

    let structures = StructureCache::default();
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
            while !called_off.load(Ordering::Relaxed) {
                let turn = next.fetch_add(1, Ordering::Relaxed);
                let Some(&(place, index)) = queue.get(turn) else {
                    break;
                };
                while place as u64 >= written.load(Ordering::Relaxed) + AHEAD as u64
                    && !called_off.load(Ordering::Relaxed)
                {
                    std::thread::sleep(Duration::from_millis(1));
                }
                let point = &job.points[index];
                let Ok(row) = compute(point, job.seed, &structures, worker, called_off) else {
                    break;
                };
                if sender.send(row).is_err() {
                    // The writer has given up.
                    break;
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

fn layout(job: &Job, shard: Option<Shard>) -> ResultLayout {
    let any = |pick: fn(&crate::manifest::AnalysesSpec) -> bool| {
        job.points.iter().any(|p| pick(&p.analyses))
    };
    ResultLayout {
        axes: job
            .axes
            .iter()
            .map(|axis| AxisColumn {
                name: axis.name.clone(),
                unit: axis.unit.clone(),
            })
            .collect(),
        poincare: any(|a| a.poincare.is_some()),
        spectra: any(|a| a.nvh.is_some_and(|n| n.spectrum)),
        probes: any(|a| a.multistability.is_some()),
        horizon: any(|a| a.horizon.is_some()),
        shard,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_cover_every_point_once() {
        for (points, count) in [(0, 1), (1, 3), (80, 7), (81, 80)] {
            let mut seen = vec![0; points];
            for index in 1..=count {
                for i in shard_points(points, Some(Shard { index, count })) {
                    seen[i] += 1;
                }
            }
            assert!(seen.iter().all(|n| *n == 1));
            assert_eq!(shard_points(points, None).len(), points);
        }
    }
}
