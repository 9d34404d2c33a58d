//! The writer's side of a sweep: every finished point goes to the journal, to those who
//! watch, and to the result files.

use super::point_kernel::KernelTally;
use super::refine::{Refinement, lock};
use crate::analysis::Status;
use crate::store::{Journal, PointRow, ResultWriter, SYNC_INTERVAL, StoreError, Written};
use crossbeam_channel::{Receiver, RecvTimeoutError};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// What a sweep is about to do.
#[derive(Debug, Clone, Copy)]
pub struct Begun<'a> {
    /// Points known so far, of these those taken over from an earlier, interrupted run.
    pub progress: Progress,
    /// Worker threads.
    pub threads: usize,
    /// Where they are to run, in words.
    pub asked: &'a str,
    /// Where they run, in words.
    pub obtained: &'a str,
}

/// Where a sweep stands, after every finished point.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Progress {
    /// Points finished.
    pub done: u64,
    /// Of these, with a status other than ok.
    pub not_ok: u64,
    /// Of these, with status failed, diverged, event_storm or inaccurate.
    pub failed: u64,
    /// Of `done`, taken over from an earlier, interrupted run.
    pub resumed: u64,
    /// Points of this run, as far as they are known.
    pub points: u64,
    /// Whether more may follow from their results, as they do on a refined grid.
    pub open: bool,
    /// Mesh cycles integrated by this run.
    pub cycles: u64,
    /// Time since the first point was begun.
    pub elapsed: Duration,
}

impl Progress {
    /// Counts a finished point; its cycles only where this run integrated them.
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

    /// Time that the rest of the points takes at that rate \[s\]; none before the first, and where
    /// nobody knows how many there are.
    pub fn left(&self) -> Option<f64> {
        let rate = self.rate();
        let known = rate > 0.0 && !self.open;
        known.then(|| self.points.saturating_sub(self.done) as f64 / rate)
    }
}

/// Told how a sweep goes; of points, from the writer's thread.
pub trait Watcher: Send {
    /// Workers are ready and points of an earlier run were taken over; nothing has been computed
    /// yet.
    fn begun(&mut self, begun: &Begun<'_>);

    /// Something the user should know, a sentence.
    fn warning(&mut self, sentence: &str);

    /// So many mesh tables are at hand, and the first point is not begun.
    fn prepared(&mut self, _tables: u64) {}

    /// No point is computed any more: what is finished is being written.
    fn writing(&mut self) {}

    /// A point was finished and is in the journal.
    fn point(&mut self, row: &PointRow, progress: &Progress);

    /// Some time has passed without a point; called about once a second then.
    fn tick(&mut self, progress: &Progress);
}

/// What the writer's thread works on.
pub(super) struct Recorder<'a> {
    pub writer: ResultWriter,
    pub journal: &'a mut Journal,
    pub progress: Progress,
    pub kernels: KernelTally,
    pub watcher: &'a mut dyn Watcher,
    /// When the first point was begun.
    pub begun: Instant,
    /// Points that have left the writer's memory, for the workers to see.
    pub written: &'a AtomicU64,
    /// Points of this run, as far as they are known.
    pub points: &'a AtomicU64,
    /// The refined grid, whose tables are written when all its points are known.
    pub refinement: Option<&'a Mutex<Refinement>>,
    /// Failed points, taken-over ones not counted, after which the sweep is called off.
    pub most_failures: Option<u64>,
    pub called_off: &'a AtomicBool,
}

/// What was recorded when everything is written.
pub(super) struct Recorded {
    pub progress: Progress,
    pub kernels: KernelTally,
    pub written: Written,
    /// Whether the sweep was called off for its failed points.
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
                self.called_off.store(true, Ordering::Relaxed);
            }
        }
        self.watcher.writing();
        self.journal.sync()?;
        if let Some(refinement) = self.refinement {
            self.writer.expect(lock(refinement).take_asked());
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
