//! `atlas run --json`: the progress of a run on standard output, for programs. Each line is one JSON object with its
//! kind in `event`; docs/events.md describes them.

use super::activity::Activity;
use super::fail;
use crate::analysis::Class;
use crate::manifest::Job;
use crate::store::{PointRow, RunRecord, Shard};
use crate::sweep::{Progress, ProgressObserver, SweepPlan};
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;
use std::io::{self, ErrorKind, Write};
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

/// Smallest time between two `progress` events that follow a finished point, except after the last point.
const INTERVAL: Duration = Duration::from_secs(1);

/// Writes events.
pub struct Events<'a> {
    job: &'a Job,
    folder: &'a Path,
    shard: Option<Shard>,
    activity: Activity,
    last_progress: Duration,
    warned: BTreeSet<String>,
    /// The error after which no more events are written.
    fault: Option<io::Error>,
}

impl<'a> Events<'a> {
    /// Events of a run with results in `folder`.
    pub fn new(job: &'a Job, folder: &'a Path, shard: Option<Shard>) -> Self {
        Self {
            job,
            folder,
            shard,
            activity: Activity::default(),
            last_progress: Duration::ZERO,
            warned: BTreeSet::new(),
            fault: None,
        }
    }

    fn emit(&mut self, event: &Value) {
        if self.fault.is_some() {
            return;
        }
        // These data can always be serialized. Numbers that are not finite become null.
        let mut line = serde_json::to_vec(event).unwrap_or_default();
        line.push(b'\n');
        let mut stdout = io::stdout().lock();
        self.fault = stdout.write_all(&line).and_then(|()| stdout.flush()).err();
    }

    fn progress(&mut self, progress: &Progress) {
        self.last_progress = progress.elapsed;
        let elapsed = progress.elapsed.as_secs_f64();
        let mut event = json!({
            "event": "progress",
            "points": progress.points,
            "open": true,
            "done": progress.done,
            "resumed": progress.resumed,
            "ok": progress.done - progress.not_ok,
            "not_converged": progress.not_ok - progress.failed,
            "failed": progress.failed,
            "cycles": progress.cycles,
            "elapsed": elapsed,
            "rate": progress.rate(),
            "eta": progress.left(),
            "nodes": self.activity.over(elapsed),
        });
        leave_out(&mut event, "open", !progress.open);
        self.emit(&event);
    }

    /// Writes the last event. Returns `exit_status`, or 1 if an event could not be written to standard
    /// output. A closed pipe is no error, because its reader no longer needs events.
    pub fn finished(mut self, record: &RunRecord, exit_status: u8) -> ExitCode {
        for warning in &record.warnings {
            self.warning(warning);
        }
        self.emit(&json!({ "event": "finished", "exit_status": exit_status, "record": record }));
        match self.fault {
            Some(error) if error.kind() != ErrorKind::BrokenPipe => {
                fail(1, &format!("cannot write to standard output: {error}"))
            }
            _ => ExitCode::from(exit_status),
        }
    }
}

/// Removes a key from an event if `empty`: its value then has no information.
fn leave_out(event: &mut Value, key: &str, empty: bool) {
    if let Some(keys) = event.as_object_mut().filter(|_| empty) {
        keys.shift_remove(key);
    }
}

impl ProgressObserver for Events<'_> {
    fn begun(&mut self, begun: &SweepPlan<'_>) {
        let job = self.job;
        let mut event = json!({
            "event": "started",
            "job": job.name,
            "folder": self.folder.to_string_lossy(),
            "manifest_hash": job.hash,
            "shard": self.shard,
            "points": begun.progress.points,
            "resumed": begun.progress.resumed,
            "chain_length": job.chain_length(),
            "threads": begun.threads,
            "placement": { "asked": begun.asked, "obtained": begun.obtained },
        });
        leave_out(&mut event, "shard", self.shard.is_none());
        self.emit(&event);
    }

    fn warning(&mut self, sentence: &str) {
        if self.warned.insert(sentence.to_owned()) {
            self.emit(&json!({ "event": "warning", "message": sentence }));
        }
    }

    fn point(&mut self, row: &PointRow, progress: &Progress) {
        self.activity.count(row);
        let names = self.job.axes.iter().map(|axis| axis.name().to_owned());
        let values = row.axis_values.iter().map(|&value| value.into());
        let axes: Map<String, Value> = names.zip(values).collect();
        let (outcome, placement) = (&row.outcome, &row.placement);
        let lyapunov = outcome.lyapunov.as_ref();
        self.emit(&json!({
            "event": "point",
            "point_id": row.point_id,
            "axes": axes,
            "status": outcome.status.name(),
            "reason": outcome.reason,
            "class": outcome.class.as_ref().map(Class::name),
            "period": outcome.class.as_ref().and_then(Class::period),
            "lambda_max": lyapunov.and_then(|found| found.exponents.first().copied()),
            "lambda_stderr": lyapunov.map(|found| found.stderr()),
            "cycles": outcome.cycles,
            "wall_time": placement.wall_time,
            "worker": placement.worker,
            "numa_node": placement.numa_node,
        }));
        if progress.done == progress.points || progress.elapsed >= self.last_progress + INTERVAL {
            self.progress(progress);
        }
    }

    fn tick(&mut self, progress: &Progress) {
        self.progress(progress);
    }
}
