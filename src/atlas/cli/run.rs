//! `atlas run m.toml`: computes every point of a job and writes its result files.

use super::console::Console;
use super::process::{Process, left};
use super::retry;
use super::run_args::RunArgs;
use super::status::{failure, status};
use super::{BAD_INPUT, FAILED_POINTS, OrFail, Status, fail, grid, with_causes};
use crate::manifest::Job;
use crate::store::{RunRecord, RunState};
use crate::sweep::{
    ExistingResults, Finished, JobRun, JobRunEnd, JobRunError, Options, SweepError,
    inspect_existing_results,
};
use crate::units::plural;
use std::path::Path;

/// Runs a job: status 0 if done, 1 if threads cannot start or files cannot be written, 2 for bad input, 3 if points
/// failed, 4 if another process computes the same, 130 if interrupted.
pub fn run(args: &RunArgs) -> Status {
    let job = args.manifest.read_job()?;
    let options = [
        ("--shard", args.shard.is_some()),
        ("--retry", args.retry.is_some()),
    ];
    let given = options.iter().find(|(_, given)| *given);
    if let Some(refusal) = given.and_then(|(option, _)| grid::refuses(&job, option)) {
        return Err(fail(BAD_INPUT, &refusal));
    }
    let folder = args
        .out
        .clone()
        .unwrap_or_else(|| Path::new("results").join(&job.name));
    match inspect_existing_results(&folder, &job, args.shard, args.overwrite)
        .or_explain(BAD_INPUT)?
    {
        ExistingResults::Nothing if args.retry.is_some() => {
            let folder = folder.display();
            let message =
                "holds no finished results of this manifest; run it without --retry first";
            Err(fail(BAD_INPUT, &format!("{folder} {message}")))
        }
        ExistingResults::Nothing => execute(args, &job, &folder),
        ExistingResults::Complete(record) if args.retry.is_some() => {
            Ok(retry::run(args, &job, &folder, *record))
        }
        ExistingResults::Complete(record) => {
            let text = format!(
                "{} already holds the results of this manifest ({} points); --overwrite computes them again\n",
                folder.display(),
                record.totals.points
            );
            Ok(Console::new(args, &job, &folder).close(&record, status(&record), &text))
        }
    }
}

fn execute(args: &RunArgs, job: &Job, folder: &Path) -> Status {
    let Process {
        interrupt,
        topology,
        warnings,
    } = Process::prepare(&left(folder))?;
    let run = JobRun {
        job,
        folder,
        options: Options {
            threads: args.threads.count(),
            pinning: args.pinning(),
            shard: args.shard,
            only: None,
            most_failures: args.max_failures,
        },
        fresh: args.overwrite,
        tables: args.tables.store(),
        topology: topology.as_ref(),
        warnings,
    };
    let mut voice = Console::new(args, job, folder);
    let JobRunEnd { finished, record } = match run.run(&interrupt, &mut voice) {
        Ok(ran) => ran,
        Err(error) => {
            drop(voice);
            let status = match &error {
                JobRunError::Sweep(SweepError::Store(error)) => failure(error),
                JobRunError::Sweep(SweepError::Threads { .. }) | JobRunError::Record(_) => 1,
            };
            return Err(fail(status, &with_causes(&error)));
        }
    };
    let text = closing_line(&finished, &record, folder);
    let status = if finished.recorded.gave_up { FAILED_POINTS } else { status(&record) };
    Ok(voice.close(&record, status, &text))
}

fn closing_line(finished: &Finished, record: &RunRecord, folder: &Path) -> String {
    let (totals, threads) = (&record.totals, finished.placement.threads);
    // While the refinement is open, the results of missing points may require even more points.
    let missing = if finished.recorded.progress.open {
        format!("at least {}", totals.missing)
    } else {
        totals.missing.to_string()
    };
    let folder = folder.display();
    let mut text = format!(
        "{} of {} points in {:.1} s on {}",
        finished.recorded.progress.done,
        finished.points,
        totals.wall_time,
        plural(threads as usize, "thread"),
    );
    if totals.resumed > 0 {
        text += &format!(", {} of them kept from an interrupted run", totals.resumed);
    }
    text += &format!(
        ": {} ok, {} not converged, {} failed",
        totals.ok, totals.not_converged, totals.failed
    );
    if totals.cycles > 0 {
        text += &format!(
            "; {} cycles, {:.2} µs per cycle and thread",
            totals.cycles,
            1e6 * totals.wall_time_per_cycle * f64::from(threads),
        );
    }
    text += &match record.state {
        RunState::Complete => {
            format!("\nresults in {folder}; `atlas show {folder}` summarises them\n")
        }
        RunState::Interrupted if finished.recorded.gave_up => format!(
            "\nstopped after too many failed points (--max-failures): {missing} points are missing, the \
             others are in {folder}; the same command continues\n"
        ),
        RunState::Interrupted => format!(
            "\ninterrupted: {missing} points are missing, the others are in {folder}; the same command continues\n"
        ),
    };
    text
}
