//! The writer's side of a sweep: passes every finished point to the journal, the watcher and the result files.

use super::point_kernel::KernelTally;
use super::refine::Refinement;
use super::shared::lock;
use crate::analysis::Status;
use crate::store::{Journal, PointRow, ResultWriter, SYNC_INTERVAL, StoreError, Written};
use crossbeam_channel::{Receiver, RecvTimeoutError};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Capacity of the channel from workers to the writer, in rows.
pub(super) const CHANNEL: usize = 256;

/// The plan of a sweep.
#[derive(Debug, Clone, Copy)]
pub struct SweepPlan<'a> {
    /// Points known so far, including those taken from an earlier, interrupted run.
    pub progress: Progress,
    /// Worker threads.
    pub threads: usize,
    /// Intended placement of the threads, in words.
    pub asked: &'a str,
    /// Actual placement of the threads, in words.
    pub obtained: &'a str,
}

/// Progress of a sweep after a finished point.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Progress {
    /// Points finished.
    pub done: u64,
    /// Number of these with a status other than ok.
    pub not_ok: u64,
    /// Number of these with status failed, diverged, event_storm or inaccurate.
    pub failed: u64,
    /// Number of `done` that come from an earlier, interrupted run.
    pub resumed: u64,
    /// Points of this run that are known so far.
    pub points: u64,
    /// Whether more points may follow from results, as on a refined grid.
    pub open: bool,
    /// Mesh cycles integrated by this run.
    pub cycles: u64,
    /// Time since the first point was started.
    pub elapsed: Duration,
}

impl Progress {
    /// Counts a finished point, without its cycles.
    pub(super) fn count(&mut self, row: &PointRow) {
        let status = &row.outcome.status;
        self.done += 1;
        self.not_ok += u64::from(*status != Status::Ok);
        self.failed += u64::from(status.is_failure());
    }

    /// Points computed by this run \[1/s\]; 0 before the first.
    pub fn rate(&self) -> f64 {
        let seconds = self.elapsed.as_secs_f64();
        if seconds > 0.0 { (self.done - self.resumed) as f64 / seconds } else { 0.0 }
    }

    /// Time of the remaining points at that rate \[s\]; `None` before the first point, and if their number is unknown.
    pub fn left(&self) -> Option<f64> {
        let rate = self.rate();
        let known = rate > 0.0 && !self.open;
        known.then(|| self.points.saturating_sub(self.done) as f64 / rate)
    }
}

/// Receives the progress of a sweep. Finished points arrive on the writer's thread.
pub trait ProgressObserver: Send {
    /// Workers are ready and points of an earlier run were read; nothing has been computed yet.
    fn begun(&mut self, begun: &SweepPlan<'_>);

    /// A warning for the user, one sentence.
    fn warning(&mut self, sentence: &str);

    /// One more mesh table was read or computed; the number of these so far. The first point has not started.
    fn prepared(&mut self, _tables: u64) {}

    /// No more points are computed; the finished ones are being written.
    fn writing(&mut self) {}

    /// A point was finished and is in the journal.
    fn point(&mut self, row: &PointRow, progress: &Progress);

    /// Some time has passed without a point; called about once per second then.
    fn tick(&mut self, progress: &Progress);
}

/// State of the writer's thread.
pub(super) struct Recorder<'a> {
    pub writer: ResultWriter,
    pub journal: &'a mut Journal,
    pub progress: Progress,
    pub kernels: KernelTally,
    pub watcher: &'a mut dyn ProgressObserver,
    /// Start of the first point.
    pub begun: Instant,
    /// Number of points that have left the writer's memory; workers read it.
    pub written: &'a AtomicU64,
    /// Points of this run that are known so far.
    pub points: &'a AtomicU64,
    /// The refined grid; its tables are written when all its points are known.
    pub refinement: Option<&'a Mutex<Refinement>>,
    /// Number of failed points, without those of earlier runs, that interrupts the sweep.
    pub most_failures: Option<u64>,
    pub interrupt: &'a AtomicBool,
}

/// Summary after everything is written.
#[derive(Debug, Clone, PartialEq)]
pub struct Recorded {
    /// Counts of finished points.
    pub progress: Progress,
    /// The kernels that computed its points.
    pub kernels: KernelTally,
    /// The tables, and the number of points that are missing because the sweep was interrupted.
    pub written: Written,
    /// Whether too many failed points interrupted the sweep.
    pub gave_up: bool,
}

impl Recorder<'_> {
    /// Takes rows until the channel closes, then completes the result files.
    pub(super) fn record_all(mut self, rows: &Receiver<PointRow>) -> Result<Recorded, StoreError> {
        let failed_before = self.progress.failed;
        let mut gave_up = false;
        loop {
            match rows.recv_timeout(SYNC_INTERVAL) {
                Ok(row) => self.record(row)?,
                Err(RecvTimeoutError::Timeout) => {
                    self.journal.sync_if_due()?;
                    self.progress.elapsed = self.begun.elapsed();
                    self.progress.points = self.points.load(Ordering::Relaxed);
                    self.watcher.tick(&self.progress);
                }
                Err(RecvTimeoutError::Disconnected) => break,
            }
            let failed = self.progress.failed - failed_before;
            if !gave_up && self.most_failures.is_some_and(|most| failed >= most) {
                gave_up = true;
                self.interrupt.store(true, Ordering::Relaxed);
            }
        }
        self.watcher.writing();
        self.journal.sync()?;
        if let Some(refinement) = self.refinement {
            self.writer.expect(lock(refinement).take_requested());
            let writer = &mut self.writer;
            self.journal.in_order(|row| writer.push(row))?;
        }
        let written = self.writer.finish()?;
        Ok(Recorded {
            progress: self.progress,
            kernels: self.kernels,
            gave_up: gave_up && written.missing > 0,
            written,
        })
    }

    fn record(&mut self, row: PointRow) -> Result<(), StoreError> {
        self.journal.append(&row)?;
        self.progress.count(&row);
        self.kernels.count(&row);
        self.progress.cycles += row.outcome.cycles;
        self.progress.elapsed = self.begun.elapsed();
        self.progress.points = self.points.load(Ordering::Relaxed);
        self.watcher.point(&row, &self.progress);
        if self.refinement.is_some() {
            return Ok(());
        }
        self.writer.push(row)?;
        let waiting = self.writer.waiting() as u64;
        self.written
            .store(self.progress.done - waiting, Ordering::Relaxed);
        Ok(())
    }
}
