//! The pool, the channel and the writer.

use super::build::StructureCache;
use super::point::{Worker, compute};
use crate::analysis::Status;
use crate::manifest::Job;
use crate::store::{AxisColumn, PointRow, ResultLayout, ResultWriter, Shard, StoreError};
use crate::topology::Topology;
use crossbeam_channel::{Receiver, bounded};
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
    /// Mesh cycles marched.
    pub cycles: u64,
}

/// Told about every finished point, from the writer's thread.
pub trait Watcher: Send {
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

/// Runs a job and writes its tables to `folder`. Raising `called_off` drops the points in
/// flight; what is finished is written.
///
/// # Errors
/// Threads cannot be started, or results cannot be written; the sweep then stops.
pub fn run(
    job: &Job,
    folder: &Path,
    options: Options,
    topology: Option<&Topology>,
    called_off: &AtomicBool,
    watcher: &mut dyn Watcher,
) -> Result<Finished, SweepError> {
    let queue = shard_points(job.points.len(), options.shard);
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
    let ids: Vec<u64> = queue.iter().map(|&i| job.points[i].point_id).collect();
    let writer = ResultWriter::create(folder, &layout(job, options.shard), ids)?;

    let structures = StructureCache::default();
    let next = AtomicUsize::new(0);
    let finished = AtomicU64::new(0);
    let (sender, receiver) = bounded(CHANNEL);
    let written = std::thread::scope(|scope| {
        let finished = &finished;
        let writing = scope.spawn(move || write(writer, &receiver, finished, called_off, watcher));
        pool.broadcast(|context| {
            let worker = Worker {
                index: context.index() as u32,
                topology,
            };
            let sender = sender.clone();
            while !called_off.load(Ordering::Relaxed) {
                let turn = next.fetch_add(1, Ordering::Relaxed);
                let Some(&index) = queue.get(turn) else { break };
                while turn as u64 >= finished.load(Ordering::Relaxed) + AHEAD as u64
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
    let (progress, missing) = written?;
    Ok(Finished {
        points: queue.len() as u64,
        progress,
        missing,
        threads,
    })
}

/// The writer's thread: rows into files until the channel closes.
fn write(
    mut writer: ResultWriter,
    receiver: &Receiver<PointRow>,
    oldest: &AtomicU64,
    called_off: &AtomicBool,
    watcher: &mut dyn Watcher,
) -> Result<(Progress, u64), StoreError> {
    let mut progress = Progress::default();
    for row in receiver {
        progress.done += 1;
        progress.cycles += row.outcome.cycles;
        progress.not_ok += u64::from(row.outcome.status != Status::Ok);
        progress.failed += u64::from(!matches!(
            row.outcome.status,
            Status::Ok | Status::NotConverged
        ));
        watcher.point(&row, &progress);
        if let Err(error) = writer.push(row) {
            // Nothing more can be kept: no use in computing on.
            called_off.store(true, Ordering::Relaxed);
            return Err(error);
        }
        oldest.store(progress.done - writer.waiting() as u64, Ordering::Relaxed);
    }
    let written = writer.finish()?;
    Ok((progress, written.missing))
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
