//! `atlas run m.toml`: computes every point of a job and writes its result files.

use super::console::Console;
use super::earlier::{self, Earlier};
use super::process::Process;
use super::retry;
use super::run_args::RunArgs;
use super::status::{failure, status};
use super::{BAD_INPUT, FAILED_POINTS, fail, grid, with_causes};
use crate::manifest::Job;
use crate::store::{
    ForecastRecord, Journal, MachineRecord, PlacementRecord, ProgramRecord, RunRecord, RunState,
    Totals, mixed, timestamp, write_run,
};
use crate::sweep::Parts;
use crate::sweep::{self, Finished, Options, SweepError, Watcher};
use std::path::Path;
use std::process::ExitCode;
use std::time::{Instant, SystemTime};

/// Runs a job: status 0 when done, 2 for bad input, 3 when points failed, 4 where another
/// process computes the same, 130 when interrupted.
pub fn run(args: &RunArgs) -> ExitCode {
    let job = match args.manifest.admit() {
        Ok(job) => job,
        Err(status) => return status,
    };
    let options = [
        ("--shard", args.shard.is_some()),
        ("--retry", args.retry.is_some()),
    ];
    let asked = options.iter().find(|(_, asked)| *asked);
    if let Some(refusal) = asked.and_then(|(option, _)| grid::refuses(&job, option)) {
        return fail(BAD_INPUT, &refusal);
    }
    let folder = args
        .out
        .clone()
        .unwrap_or_else(|| Path::new("results").join(&job.name));
    match earlier::look(&folder, &job, args.shard, args.fresh) {
        Ok(Earlier::Nothing) if args.retry.is_some() => fail(
            BAD_INPUT,
            &format!(
                "{} holds no finished results of this manifest: run it without --retry first",
                folder.display()
            ),
        ),
        Ok(Earlier::Nothing) => execute(args, &job, &folder),
        Ok(Earlier::Complete(record)) if args.retry.is_some() => {
            retry::run(args, &job, &folder, *record)
        }
        Ok(Earlier::Complete(record)) => {
            let text = format!(
                "{} already holds the results of this manifest ({} points); --fresh computes them again\n",
                folder.display(),
                record.totals.points
            );
            Console::new(args, &job, &folder).close(&record, status(&record), &text)
        }
        Err(message) => fail(BAD_INPUT, &message),
    }
}

fn execute(args: &RunArgs, job: &Job, folder: &Path) -> ExitCode {
    let Process {
        called_off,
        topology,
        mut warnings,
    } = match Process::prepare() {
        Ok(process) => process,
        Err(error) => return fail(1, &format!("cannot watch for signals: {error}")),
    };
    let options = Options {
        threads: args.threads.count(),
        pinning: args.pinning(),
        shard: args.shard,
        only: None,
        most_failures: args.max_failures,
    };
    let mut journal = match Journal::open(folder, &job.hash, args.shard, args.fresh) {
        Ok(journal) => journal,
        Err(error) => return fail(failure(&error), &with_causes(&error)),
    };
    let instructions = journal.instructions();
    warnings.extend(mixed(&instructions));
    let parts = Parts::new(args.tables.store());
    let mut voice = Console::new(args, job, folder);
    for warning in &warnings {
        voice.warning(warning);
    }
    let (started, clock) = (SystemTime::now(), Instant::now());
    let swept = sweep::run(
        job,
        folder,
        options,
        &parts,
        &mut journal,
        topology.as_ref(),
        &called_off,
        &mut voice,
    );
    let finished = match swept {
        Ok(finished) => finished,
        Err(error) => {
            drop(voice);
            journal.abandon();
            let status = match &error {
                SweepError::Store(error) => failure(error),
                SweepError::Threads { .. } => 1,
            };
            return fail(status, &with_causes(&error));
        }
    };
    warnings.extend(parts.warnings());
    let mut totals = Totals::new(
        finished.points,
        finished.progress.done - finished.progress.not_ok,
        finished.progress.failed,
        finished.progress.cycles,
        clock.elapsed().as_secs_f64(),
    );
    totals.not_converged = finished.progress.not_ok - finished.progress.failed;
    totals.missing = finished.written.missing;
    totals.resumed = finished.progress.resumed;
    let record = RunRecord {
        job: job.name.clone(),
        state: match finished.written.missing {
            0 => RunState::Complete,
            _ => RunState::Interrupted,
        },
        shard: args.shard,
        started: timestamp(started),
        finished: timestamp(SystemTime::now()),
        program: ProgramRecord::current(),
        machine: MachineRecord {
            instructions,
            ..MachineRecord::current(topology.as_ref())
        },
        placement: PlacementRecord {
            threads_asked: args.threads.asked,
            threads: finished.threads as u32,
            asked: finished.asked.clone(),
            obtained: finished.obtained.clone(),
            copies_asked: finished.copies_asked.clone(),
            copies_obtained: finished.copies_obtained.clone(),
        },
        forecast: finished.forecast.map(|forecast| ForecastRecord {
            points: forecast.points,
            after: forecast.after,
            wall_time: forecast.wall_time.expected,
            wall_time_low: forecast.wall_time.low,
            wall_time_high: forecast.wall_time.high,
        }),
        totals,
        shards: Vec::new(),
        tables: finished.written.tables.clone(),
        retries: Vec::new(),
        warnings,
        manifest_hash: job.hash.clone(),
        manifest: job.text.clone(),
        set: job.changes.clone(),
    };
    if let Err(error) = write_run(folder, &record) {
        return fail(1, &with_causes(&error));
    }
    // Last: until the record is written, the journal is what a next run goes on from.
    if record.state == RunState::Complete
        && let Err(error) = journal.remove()
    {
        return fail(1, &with_causes(&error));
    }
    let text = closing_line(&finished, &record, folder);
    let status = match finished.gave_up {
        true => FAILED_POINTS,
        false => status(&record),
    };
    voice.close(&record, status, &text)
}

fn closing_line(finished: &Finished, record: &RunRecord, folder: &Path) -> String {
    let (totals, threads) = (&record.totals, finished.threads);
    // More may follow from the results of these.
    let missing = match finished.progress.open {
        true => format!("at least {}", totals.missing),
        false => totals.missing.to_string(),
    };
    let folder = folder.display();
    let mut text = format!(
        "{} of {} points in {:.1} s on {threads} {}",
        finished.progress.done,
        finished.points,
        totals.wall_time,
        if threads == 1 { "thread" } else { "threads" },
    );
    if totals.resumed > 0 {
        text += &format!(
            ", {} of them taken over from an interrupted run",
            totals.resumed
        );
    }
    text += &format!(
        ": {} ok, {} not converged, {} failed",
        totals.ok, totals.not_converged, totals.failed
    );
    if totals.cycles > 0 {
        text += &format!(
            "; {} cycles, {:.2} µs a cycle and thread",
            totals.cycles,
            1e6 * totals.wall_time_per_cycle * threads as f64,
        );
    }
    text += &match record.state {
        RunState::Complete => {
            format!("\nresults in {folder}; atlas show {folder} summarises them\n")
        }
        RunState::Interrupted if finished.gave_up => format!(
            "\ncalled off, because so many points failed (--max-failures): {missing} points are missing, the others are in {folder}; the same command goes on from here\n"
        ),
        RunState::Interrupted => format!(
            "\ninterrupted: {missing} points are missing, the others are in {folder}; the same command goes on from here\n"
        ),
    };
    text
}
