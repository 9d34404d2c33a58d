//! `atlas run --retry failed`: computes the failed points of finished results again and puts
//! them in the place of the old ones.
//!
//! They are computed into a hidden folder beside the tables, with a journal of its own, so
//! that the results stay whole until every point is there and an interrupted retry is taken
//! up by the same command.

use super::console::Console;
use super::process::{Process, left};
use super::run_args::RunArgs;
use super::status::{failure, status};
use super::{FAILED_POINTS, INTERRUPTED, fail, with_causes};
use crate::manifest::Job;
use crate::propagate::instructions;
use crate::store::{
    Exchange, IoFault, Journal, ProgramRecord, Purpose, Refusal, RetryRecord, RunRecord, Stopwatch,
    StoreError, TableRecord, Totals, mixed, remove_stale, replace, statuses, write_run,
};
use crate::sweep::Prepared;
use crate::sweep::{self, Options, Share, SweepError, Watcher};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Statuses that are computed again.
const FAILURES: [&str; 4] = ["failed", "diverged", "event_storm", "inaccurate"];

/// Said of results in which a retry exchanges points, until it has done so.
const AMID: &str = "a retry of these points was interrupted; repeat it with --retry failed";

/// Computes what failed of the results in `folder`, which `record` describes, again.
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
    // Nobody else may change these results meanwhile.
    let lock = Journal::open(folder, &job.hash, args.shard, true)?;
    remove_stale(folder)?;
    let found = failed(folder, args, &record.tables)?;
    let points: BTreeSet<u64> = Share::of_shard(job, args.shard)
        .with(&found)
        .ids()
        .collect();
    let anew = retry_folder(folder, args);
    if anew.is_symlink() {
        let fault = IoFault {
            path: anew,
            action: "create",
            purpose: Purpose::Results,
            refusal: Refusal::SymbolicLink,
        };
        return Err(StoreError::from(fault).into());
    }
    let mut voice = Console::new(args, job, folder);
    let mut text = format!(
        "{} has no failed points, so there is nothing to compute\n",
        folder.display()
    );
    if !points.is_empty() {
        let mut process = match Process::prepare(&left(folder)) {
            Ok(process) => process,
            Err(error) => return Ok(fail(1, &format!("cannot watch for signals: {error}"))),
        };
        let mut journal = journal(&anew, job, &points)?;
        let parts = Prepared::new(args.tables.store());
        let options = Options {
            threads: args.threads.count(),
            pinning: args.pinning(),
            shard: args.shard,
            only: Some(&points),
            most_failures: args.max_failures,
        };
        for warning in &process.warnings {
            voice.warning(warning);
        }
        let watch = Stopwatch::start();
        let swept = sweep::run(
            job,
            &anew,
            options,
            &parts,
            &mut journal,
            process.topology.as_ref(),
            &process.called_off,
            &mut voice,
        );
        let finished = match swept {
            Ok(finished) => finished,
            Err(error) => {
                drop(voice);
                lock.abandon();
                return Err(error);
            }
        };
        if finished.written.missing > 0 {
            lock.abandon();
            let status = if finished.gave_up { FAILED_POINTS } else { INTERRUPTED };
            let text = format!(
                "interrupted: {} of {} points are missing, and {} is unchanged; the same command continues\n",
                finished.written.missing,
                finished.points,
                folder.display()
            );
            return Ok(voice.close(&record, status, &text));
        }
        let exchange = Exchange {
            folder,
            shard: args.shard,
            tables: &record.tables,
            points: &points,
            anew: &anew,
            added: &finished.written.tables,
        };
        record.tables = replace(exchange, |tables| {
            let mut either = record.clone();
            either.tables.extend(tables.iter().cloned());
            either.warnings.push(AMID.into());
            write_run(folder, &either)
        })?;
        process.warnings.extend(parts.warnings());
        record.warnings.append(&mut process.warnings);
        let (used, here) = (&mut record.machine.instructions, instructions());
        if used.iter().all(|name| name != here) {
            used.push(here.to_owned());
        }
        let mixed = mixed(used).filter(|warning| !record.warnings.contains(warning));
        record.warnings.extend(mixed);
        let retry = RetryRecord {
            started: watch.started(),
            finished: watch.now(),
            program: ProgramRecord::current(),
            points: points.len() as u64,
            failed: finished.progress.failed,
            cycles: finished.progress.cycles,
            wall_time: watch.elapsed().as_secs_f64(),
        };
        text = format!(
            "{} points computed again in {:.1} s, {} failed\nresults in {}\n",
            retry.points,
            retry.wall_time,
            retry.failed,
            folder.display()
        );
        record.retries.push(retry);
    }
    // Of one that was killed with nothing left to do but to say so.
    record.warnings.retain(|warning| warning != AMID);
    latest(&mut record.tables);
    recount(&mut record, folder, args)?;
    write_run(folder, &record)?;
    // Last: until the record is written, the same command has to find it.
    discard(&anew)?;
    lock.abandon();
    Ok(voice.close(&record, status(&record), &text))
}

/// Leaves one table of each name, the one that was to take the place of the others.
fn latest(tables: &mut Vec<TableRecord>) {
    let mut names = BTreeSet::new();
    tables.reverse();
    tables.retain(|table| names.insert(table.name.clone()));
    tables.reverse();
}

/// Points with a status that says nothing of the motion.
fn failed(
    folder: &Path,
    args: &RunArgs,
    tables: &[TableRecord],
) -> Result<BTreeSet<u64>, StoreError> {
    let mut found = statuses(folder, args.shard, tables)?;
    let failed = FAILURES.into_iter().filter_map(|name| found.remove(name));
    Ok(failed.flatten().collect())
}

/// Brings the counts of a record in line with its table; its times stay those of the first
/// run.
fn recount(record: &mut RunRecord, folder: &Path, args: &RunArgs) -> Result<(), StoreError> {
    let found = statuses(folder, args.shard, &record.tables)?;
    let count = |name: &str| found.get(name).map_or(0, |points| points.len() as u64);
    record.totals = Totals {
        not_converged: count("not_converged"),
        missing: 0,
        resumed: record.totals.resumed,
        ..Totals::new(
            found.values().map(|points| points.len() as u64).sum(),
            count("ok"),
            FAILURES.into_iter().map(count).sum(),
            record.totals.cycles,
            record.totals.wall_time,
        )
    };
    Ok(())
}

/// Where points are computed again.
fn retry_folder(folder: &Path, args: &RunArgs) -> PathBuf {
    folder.join(match args.shard {
        None => ".retry".to_owned(),
        Some(shard) => format!(".retry.{}", shard.stem()),
    })
}

/// The journal of this very retry; one of other points or of another program is begun anew.
fn journal(anew: &Path, job: &Job, points: &BTreeSet<u64>) -> Result<Journal, StoreError> {
    let ids: Vec<String> = points.iter().map(u64::to_string).collect();
    let hash = blake3::hash(format!("{} {}", job.hash, ids.join(",")).as_bytes()).to_hex();
    match Journal::open(anew, &hash, None, false) {
        Err(
            StoreError::OtherJob { .. }
            | StoreError::OtherProgram { .. }
            | StoreError::ForeignJournal { .. },
        ) => Journal::open(anew, &hash, None, true),
        opened => opened,
    }
}

/// Removes the folder of the retry, where there is one.
fn discard(anew: &Path) -> Result<(), StoreError> {
    match std::fs::remove_dir_all(anew) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(StoreError::io(anew, "remove", error))
        }
        _ => Ok(()),
    }
}
