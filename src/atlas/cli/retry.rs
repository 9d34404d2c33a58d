//! `atlas run --retry failed`: recomputes the failed points of finished results and replaces the old ones.
//!
//! The new points are first written to a hidden folder beside the tables, with a separate journal. Thus the
//! old results stay complete until every point is computed, and the same command resumes an interrupted
//! retry.

use super::console::Console;
use super::process::{Process, left};
use super::run_args::RunArgs;
use super::status::{failure, status};
use super::{FAILED_POINTS, INTERRUPTED, fail, with_causes};
use crate::manifest::Job;
use crate::propagate::instructions;
use crate::store::{
    Exchange, IoFault, Journal, ProgramRecord, Purpose, Refusal, RetryRecord, RunRecord, Stopwatch,
    StoreError, TableRecord, Totals, mixed_instructions_warning, remove_stale, replace, statuses,
    write_run,
};
use crate::sweep::{ChainSelection, Options, Prepared, ProgressObserver, Sweep, SweepError};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Statuses that are recomputed.
const FAILURES: [&str; 4] = ["failed", "diverged", "event_storm", "inaccurate"];

/// Warning in the results while a retry replaces points.
const RETRY_WARNING: &str =
    "a retry of these points was interrupted; repeat it with --retry failed";

/// Recomputes the failed points of the results in `folder`, which `record` describes.
pub fn run(args: &RunArgs, job: &Job, folder: &Path, record: RunRecord) -> ExitCode {
    match retry(args, job, folder, record) {
        Ok(code) => code,
        Err(error) => {
            let status = match &error {
                SweepError::Store(error) => failure(error),
                SweepError::Threads { .. } => 1,
            };
            fail(status, &with_causes(&error))
        }
    }
}

fn retry(
    args: &RunArgs,
    job: &Job,
    folder: &Path,
    mut record: RunRecord,
) -> Result<ExitCode, SweepError> {
    // The lock of the journal keeps other processes from changing these results meanwhile.
    let lock = Journal::open(folder, &job.hash, args.shard, true)?;
    remove_stale(folder)?;
    let failed_points = failed(folder, args, &record.tables)?;
    let retry = Retry {
        args,
        job,
        folder,
        points: ChainSelection::of_shard(job, args.shard)
            .with(&failed_points)
            .ids()
            .collect(),
        new_folder: retry_folder(folder, args),
    };
    retry.refuse_link()?;
    let mut voice = Console::new(args, job, folder);
    let text = if retry.points.is_empty() {
        let folder = folder.display();
        format!("{folder} has no failed points, so there is nothing to compute\n")
    } else {
        let mut process = match Process::prepare(&left(folder)) {
            Ok(process) => process,
            Err(status) => return Ok(status),
        };
        match retry.compute(&mut process, &mut record, &mut voice) {
            Ok(RetryEnd::Exchanged(text)) => text,
            Ok(RetryEnd::Cut(status, text)) => {
                lock.abandon();
                return Ok(voice.close(&record, status, &text));
            }
            Err(error) => {
                drop(voice);
                lock.abandon();
                return Err(error);
            }
        }
    };
    // If an earlier retry was killed during its last steps, the record still has this warning.
    record.warnings.retain(|warning| warning != RETRY_WARNING);
    latest(&mut record.tables);
    recount(&mut record, folder, args)?;
    write_run(folder, &record)?;
    // This is the last step: until the record is written, a repeated command needs the folder.
    discard(&retry.new_folder)?;
    lock.abandon();
    Ok(voice.close(&record, status(&record), &text))
}

/// A retry: the points to be recomputed, and where the old and the new points are.
struct Retry<'a> {
    args: &'a RunArgs,
    job: &'a Job,
    folder: &'a Path,
    points: BTreeSet<u64>,
    /// Folder of the new points.
    new_folder: PathBuf,
}

/// How the computation ended, with the text to print.
enum RetryEnd {
    Exchanged(String),
    /// Interrupted: exit status and text.
    Cut(u8, String),
}

impl Retry<'_> {
    /// Refuses to write if the folder for the new points is a symbolic link.
    fn refuse_link(&self) -> Result<(), StoreError> {
        if !self.new_folder.is_symlink() {
            return Ok(());
        }
        let fault = IoFault {
            path: self.new_folder.clone(),
            action: "create",
            purpose: Purpose::Results,
            refusal: Refusal::SymbolicLink,
        };
        Err(fault.into())
    }

    /// Computes the points and replaces the failed ones.
    fn compute(
        &self,
        process: &mut Process,
        record: &mut RunRecord,
        voice: &mut Console<'_>,
    ) -> Result<RetryEnd, SweepError> {
        let (args, folder) = (self.args, self.folder);
        let mut journal = journal(&self.new_folder, self.job, &self.points)?;
        let parts = Prepared::new(args.tables.store());
        for warning in &process.warnings {
            voice.warning(warning);
        }
        let watch = Stopwatch::start();
        let sweep = Sweep {
            job: self.job,
            folder: &self.new_folder,
            options: Options {
                threads: args.threads.count(),
                pinning: args.pinning(),
                shard: args.shard,
                only: Some(&self.points),
                most_failures: args.max_failures,
            },
            parts: &parts,
            topology: process.topology.as_ref(),
            interrupt: &process.interrupt,
        };
        let finished = sweep.run(&mut journal, voice)?;
        if finished.recorded.written.missing > 0 {
            let (status, why) = if finished.recorded.gave_up {
                (FAILED_POINTS, "stopped by --max-failures")
            } else {
                (INTERRUPTED, "interrupted")
            };
            let text = format!(
                "{why}: {} of {} points are missing, and {} is unchanged; the same command continues\n",
                finished.recorded.written.missing,
                finished.points,
                folder.display()
            );
            return Ok(RetryEnd::Cut(status, text));
        }
        self.exchange(record, &finished.recorded.written.tables)?;
        process.warnings.extend(parts.warnings());
        for warning in process.warnings.drain(..) {
            note(record, warning);
        }
        note_instructions(record);
        let retry = RetryRecord {
            started: watch.started(),
            finished: watch.now(),
            program: ProgramRecord::current(),
            points: self.points.len() as u64,
            failed: finished.recorded.progress.failed,
            cycles: finished.recorded.progress.cycles,
            wall_time: watch.elapsed().as_secs_f64(),
        };
        let text = format!(
            "{} points computed again in {:.1} s, {} failed\nresults in {}\n",
            retry.points,
            retry.wall_time,
            retry.failed,
            folder.display()
        );
        record.retries.push(retry);
        Ok(RetryEnd::Exchanged(text))
    }

    /// Replaces the old points by those of the new tables.
    fn exchange(&self, record: &mut RunRecord, added: &[TableRecord]) -> Result<(), StoreError> {
        let exchange = Exchange {
            folder: self.folder,
            shard: self.args.shard,
            tables: &record.tables,
            points: &self.points,
            new_folder: &self.new_folder,
            added,
        };
        record.tables = replace(exchange, |tables| {
            let mut either = record.clone();
            either.tables.extend(tables.iter().cloned());
            either.warnings.push(RETRY_WARNING.into());
            write_run(self.folder, &either)
        })?;
        Ok(())
    }
}

/// Adds the instruction set of this process to those listed in a record.
fn note_instructions(record: &mut RunRecord) {
    let (used, here) = (&mut record.machine.instructions, instructions());
    if used.iter().all(|name| name != here) {
        used.push(here.to_owned());
    }
    if let Some(warning) = mixed_instructions_warning(used) {
        note(record, warning);
    }
}

/// Adds a warning to a record, unless an earlier run or retry has added it.
fn note(record: &mut RunRecord, warning: String) {
    if !record.warnings.contains(&warning) {
        record.warnings.push(warning);
    }
}

/// Keeps only the last table of each name: a later table replaces the earlier ones.
fn latest(tables: &mut Vec<TableRecord>) {
    let mut names = BTreeSet::new();
    tables.reverse();
    tables.retain(|table| names.insert(table.name.clone()));
    tables.reverse();
}

/// Points with one of the statuses in [`FAILURES`].
fn failed(
    folder: &Path,
    args: &RunArgs,
    tables: &[TableRecord],
) -> Result<BTreeSet<u64>, StoreError> {
    let mut points_by_status = statuses(folder, args.shard, tables)?;
    let failed = FAILURES
        .into_iter()
        .filter_map(|name| points_by_status.remove(name));
    Ok(failed.flatten().collect())
}

/// Updates the counts of points in a record from its tables. Cycles and times remain those of the first run.
fn recount(record: &mut RunRecord, folder: &Path, args: &RunArgs) -> Result<(), StoreError> {
    let points_by_status = statuses(folder, args.shard, &record.tables)?;
    let count = |name: &str| {
        points_by_status
            .get(name)
            .map_or(0, |points| points.len() as u64)
    };
    record.totals = Totals {
        not_converged: count("not_converged"),
        missing: 0,
        resumed: record.totals.resumed,
        ..Totals::new(
            points_by_status
                .values()
                .map(|points| points.len() as u64)
                .sum(),
            count("ok"),
            FAILURES.into_iter().map(count).sum(),
            record.totals.cycles,
            record.totals.wall_time,
        )
    };
    Ok(())
}

/// The folder for recomputed points.
fn retry_folder(folder: &Path, args: &RunArgs) -> PathBuf {
    folder.join(match args.shard {
        None => ".retry".to_owned(),
        Some(shard) => format!(".retry.{}", shard.stem()),
    })
}

/// The journal of this retry. A journal with other points or of another program is replaced.
fn journal(new_folder: &Path, job: &Job, points: &BTreeSet<u64>) -> Result<Journal, StoreError> {
    let ids: Vec<String> = points.iter().map(u64::to_string).collect();
    let hash = blake3::hash(format!("{} {}", job.hash, ids.join(",")).as_bytes()).to_hex();
    match Journal::open(new_folder, &hash, None, false) {
        Err(
            StoreError::OtherJob { .. }
            | StoreError::OtherProgram { .. }
            | StoreError::ForeignJournal { .. },
        ) => Journal::open(new_folder, &hash, None, true),
        opened => opened,
    }
}

/// Removes the folder of the retry, if it exists.
fn discard(new_folder: &Path) -> Result<(), StoreError> {
    match std::fs::remove_dir_all(new_folder) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(StoreError::io(new_folder, "remove", error))
        }
        _ => Ok(()),
    }
}
