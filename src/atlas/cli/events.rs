//! `atlas run --json`: the progress of a run on standard output, for programs. Each line is one JSON object with its
//! kind in `event`; docs/events.md describes them.

use super::activity::{Activity, NodeActivity};
use super::fail;
use crate::analysis::Class;
use crate::manifest::Job;
use crate::store::{PointRow, RunRecord, Shard};
use crate::sweep::{Progress, ProgressObserver, SweepPlan};
use serde::Serialize;
use std::collections::BTreeSet;
use std::io::{self, ErrorKind, Write};
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

/// Time between two events of progress.
const INTERVAL: Duration = Duration::from_secs(1);

/// An event of a run.
#[derive(Debug, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
enum Event<'a> {
    Started {
        job: &'a str,
        folder: &'a Path,
        manifest_hash: &'a str,
        #[serde(skip_serializing_if = "Option::is_none")]
        shard: Option<Shard>,
        points: u64,
        resumed: u64,
        chain_length: usize,
        threads: usize,
        placement: WorkerPlacement<'a>,
    },
    Point {
        point_id: u64,
        axes: serde_json::Map<String, serde_json::Value>,
        status: &'static str,
        reason: &'a str,
        class: Option<&'static str>,
        period: Option<u32>,
        lambda_max: Option<f64>,
        lambda_stderr: Option<f64>,
        cycles: u64,
        wall_time: f64,
        worker: u32,
        numa_node: Option<u32>,
    },
    Progress {
        points: u64,
        #[serde(skip_serializing_if = "std::ops::Not::not")]
        open: bool,
        done: u64,
        resumed: u64,
        ok: u64,
        not_converged: u64,
        failed: u64,
        cycles: u64,
        elapsed: f64,
        rate: f64,
        eta: Option<f64>,
        nodes: Vec<NodeActivity>,
    },
    Warning {
        message: &'a str,
    },
    Finished {
        exit_status: u8,
        record: &'a RunRecord,
    },
}

#[derive(Debug, Serialize)]
struct WorkerPlacement<'a> {
    asked: &'a str,
    obtained: &'a str,
}

/// Writes events.
pub struct Events<'a> {
    job: &'a Job,
    folder: &'a Path,
    shard: Option<Shard>,
    activity: Activity,
    last_progress: Duration,
    warned: BTreeSet<String>,
    /// Why no more events can be written.
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

    fn emit(&mut self, event: &Event<'_>) {
        if self.fault.is_some() {
            return;
        }
        // Plain data always have a JSON form; numbers that are not finite become null.
        let mut line = serde_json::to_vec(event).unwrap_or_default();
        line.push(b'\n');
        let mut stdout = io::stdout().lock();
        self.fault = stdout.write_all(&line).and_then(|()| stdout.flush()).err();
    }

    fn progress(&mut self, progress: &Progress) {
        self.last_progress = progress.elapsed;
        let elapsed = progress.elapsed.as_secs_f64();
        self.emit(&Event::Progress {
            points: progress.points,
            open: progress.open,
            done: progress.done,
            resumed: progress.resumed,
            ok: progress.done - progress.not_ok,
            not_converged: progress.not_ok - progress.failed,
            failed: progress.failed,
            cycles: progress.cycles,
            elapsed,
            rate: progress.rate(),
            eta: progress.left(),
            nodes: self.activity.over(elapsed),
        });
    }

    /// Writes the last event. Returns the exit status, which differs if standard output could not be written. A closed
    /// pipe is no error, because its reader no longer needs events.
    pub fn finished(mut self, record: &RunRecord, exit_status: u8) -> ExitCode {
        for warning in &record.warnings {
            self.warning(warning);
        }
        self.emit(&Event::Finished {
            exit_status,
            record,
        });
        match self.fault {
            Some(error) if error.kind() != ErrorKind::BrokenPipe => {
                fail(1, &format!("cannot write to standard output: {error}"))
            }
            _ => ExitCode::from(exit_status),
        }
    }
}

impl ProgressObserver for Events<'_> {
    fn begun(&mut self, begun: &SweepPlan<'_>) {
        let job = self.job;
        self.emit(&Event::Started {
            job: &job.name,
            folder: self.folder,
            manifest_hash: &job.hash,
            shard: self.shard,
            points: begun.progress.points,
            resumed: begun.progress.resumed,
            chain_length: job.chain_length(),
            threads: begun.threads,
            placement: WorkerPlacement {
                asked: begun.asked,
                obtained: begun.obtained,
            },
        });
    }

    fn warning(&mut self, sentence: &str) {
        if self.warned.insert(sentence.to_owned()) {
            self.emit(&Event::Warning { message: sentence });
        }
    }

    fn point(&mut self, row: &PointRow, progress: &Progress) {
        self.activity.count(row);
        let names = self.job.axes.iter().map(|axis| axis.name().to_owned());
        let values = row.axis_values.iter().map(|&value| value.into());
        let (outcome, placement) = (&row.outcome, &row.placement);
        let lyapunov = outcome.lyapunov.as_ref();
        self.emit(&Event::Point {
            point_id: row.point_id,
            axes: names.zip(values).collect(),
            status: outcome.status.name(),
            reason: &outcome.reason,
            class: outcome.class.as_ref().map(Class::name),
            period: outcome.class.as_ref().and_then(Class::period),
            lambda_max: lyapunov.and_then(|found| found.exponents.first().copied()),
            lambda_stderr: lyapunov.map(|found| found.stderr()),
            cycles: outcome.cycles,
            wall_time: placement.wall_time,
            worker: placement.worker,
            numa_node: placement.numa_node,
        });
        if progress.done == progress.points || progress.elapsed >= self.last_progress + INTERVAL {
            self.progress(progress);
        }
    }

    fn tick(&mut self, progress: &Progress) {
        self.progress(progress);
    }
}
