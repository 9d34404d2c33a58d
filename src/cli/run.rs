//! `atlas run m.toml`: computes every point of a job and writes its result files.

use super::progress::Display;
use super::{BAD_INPUT, FAILED_POINTS, INTERRUPTED, check, fail, print};
use crate::manifest::{self, Job};
use crate::store::{
    MachineRecord, PlacementRecord, ProgramRecord, RunRecord, RunState, Shard, Totals, read_runs,
    timestamp, write_run,
};
use crate::sweep::{self, Finished, Options};
use crate::topology::Topology;
use clap::Args;
use signal_hook::consts::{SIGINT, SIGTERM};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Instant, SystemTime};

/// Arguments of `atlas run`.
#[derive(Debug, Args)]
pub struct RunArgs {
    /// The manifest.
    pub manifest: PathBuf,
    /// Folder for the results [default: results/<job name>].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Worker threads [default: one a core this process may use].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub threads: Option<u32>,
    /// Compute only part i of n, every n-th point: 1/4, 2/4, …
    #[arg(long, value_name = "i/n", value_parser = parse_shard)]
    pub shard: Option<Shard>,
    /// Compute again although the folder holds results, and replace them.
    #[arg(long)]
    pub fresh: bool,
    /// Print nothing but errors.
    #[arg(long, short)]
    pub quiet: bool,
    /// Print the record of the run (run.json) to standard output.
    #[arg(long)]
    pub json: bool,
}

/// Most shards a job may be split into.
const MOST_SHARDS: u32 = 100_000;

fn parse_shard(text: &str) -> Result<Shard, String> {
    let shard = text.split_once('/').and_then(|(index, count)| {
        Some(Shard {
            index: index.parse().ok()?,
            count: count.parse().ok()?,
        })
    });
    shard
        .filter(|s| (1..=s.count).contains(&s.index) && s.count <= MOST_SHARDS)
        .ok_or_else(|| format!("a shard is i/n with 1 ≤ i ≤ n ≤ {MOST_SHARDS}, such as 2/8"))
}

/// Runs a job: status 0 when done, 2 for bad input, 3 when points failed, 130 when
/// interrupted.
pub fn run(args: &RunArgs) -> ExitCode {
    let job = match manifest::load(&args.manifest) {
        Ok(job) => job,
        Err(errors) => {
            check::report(&errors);
            return ExitCode::from(BAD_INPUT);
        }
    };
    let folder = args
        .out
        .clone()
        .unwrap_or_else(|| Path::new("results").join(&job.name));
    match earlier_run(&folder, &job, args) {
        Ok(Earlier::Nothing) => {}
        Ok(Earlier::Complete(record)) => {
            if args.json {
                print_record(&record);
            } else if !args.quiet {
                print(&format!(
                    "{} already holds the results of this manifest ({} points); --fresh computes them again\n",
                    folder.display(),
                    record.totals.points
                ));
            }
            return status(&record);
        }
        Err(message) => return fail(BAD_INPUT, &message),
    }
    execute(args, &job, &folder)
}

/// What a folder holds of a job already.
enum Earlier {
    /// Nothing that counts.
    Nothing,
    /// All of it.
    Complete(Box<RunRecord>),
}

/// Looks at what is in the folder; an error where it must not be touched.
fn earlier_run(folder: &Path, job: &Job, args: &RunArgs) -> Result<Earlier, String> {
    if args.fresh || !folder.exists() {
        return Ok(Earlier::Nothing);
    }
    let runs = read_runs(folder).map_err(|e| format!("{e}; --fresh starts over"))?;
    for record in runs {
        if record.manifest_hash != job.hash {
            return Err(format!(
                "{} holds results of another manifest (job {}, hash {}…; this one is {}…); choose a folder with --out, or replace them with --fresh",
                folder.display(),
                record.job,
                prefix(&record.manifest_hash),
                prefix(&job.hash),
            ));
        }
        if record.shard == args.shard && record.state == RunState::Complete {
            return Ok(Earlier::Complete(Box::new(record)));
        }
    }
    Ok(Earlier::Nothing)
}

/// Enough of a hash to tell two apart.
fn prefix(hash: &str) -> &str {
    hash.get(..8).unwrap_or(hash)
}

fn execute(args: &RunArgs, job: &Job, folder: &Path) -> ExitCode {
    let called_off = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        // The second signal ends the process at once; the first only asks.
        let registered = signal_hook::flag::register_conditional_shutdown(
            signal,
            i32::from(INTERRUPTED),
            called_off.clone(),
        )
        .and_then(|_| signal_hook::flag::register(signal, called_off.clone()));
        if let Err(error) = registered {
            return fail(1, &format!("cannot watch for signals: {error}"));
        }
    }
    hush_workers();
    let topology = Topology::current();
    let mut warnings = Vec::new();
    if let Err(error) = &topology {
        warnings.push(format!("{error}; NUMA nodes are not recorded"));
    }
    let topology = topology.ok();
    let options = Options {
        threads: args.threads.map(|n| n as usize),
        shard: args.shard,
    };
    let points = sweep::shard_points(job.points.len(), args.shard).len() as u64;
    let mut display = Display::new(points, args.quiet);
    let (started, clock) = (SystemTime::now(), Instant::now());
    let swept = sweep::run(
        job,
        folder,
        options,
        topology.as_ref(),
        &called_off,
        &mut display,
    );
    display.finish();
    let finished = match swept {
        Ok(finished) => finished,
        Err(error) => return fail(1, &error.to_string()),
    };
    let mut totals = Totals::new(
        finished.points,
        finished.progress.done - finished.progress.not_ok,
        finished.progress.not_ok,
        finished.progress.cycles,
        clock.elapsed().as_secs_f64(),
    );
    totals.missing = finished.missing;
    let record = RunRecord {
        job: job.name.clone(),
        state: match finished.missing {
            0 => RunState::Complete,
            _ => RunState::Interrupted,
        },
        shard: args.shard,
        started: timestamp(started),
        finished: timestamp(SystemTime::now()),
        program: ProgramRecord::current(),
        machine: MachineRecord::current(topology.as_ref()),
        placement: PlacementRecord {
            threads_asked: args.threads,
            threads: finished.threads as u32,
            asked: "none: the system places threads".to_owned(),
            obtained: "not bound".to_owned(),
        },
        totals,
        warnings,
        manifest_hash: job.hash.clone(),
        manifest: job.text.clone(),
    };
    if let Err(error) = write_run(folder, &record) {
        return fail(1, &error.to_string());
    }
    if args.json {
        print_record(&record);
    } else if !args.quiet {
        print(&closing_line(&finished, &record, folder));
    }
    status(&record)
}

/// A panic in a worker becomes a row with its message; a backtrace amid the progress bar
/// would only be noise.
fn hush_workers() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        let worker = std::thread::current()
            .name()
            .is_some_and(|name| name.starts_with("atlas-"));
        if !worker {
            usual(panic);
        }
    }));
}

fn status(record: &RunRecord) -> ExitCode {
    match record.state {
        RunState::Interrupted => ExitCode::from(INTERRUPTED),
        RunState::Complete if record.totals.failed > 0 => ExitCode::from(FAILED_POINTS),
        RunState::Complete => ExitCode::SUCCESS,
    }
}

fn print_record(record: &RunRecord) {
    // A record is plain data; it always has a JSON form.
    if let Ok(text) = serde_json::to_string_pretty(record) {
        print(&format!("{text}\n"));
    }
}

fn closing_line(finished: &Finished, record: &RunRecord, folder: &Path) -> String {
    let totals = &record.totals;
    let folder = folder.display();
    let mut text = format!(
        "{} of {} points in {:.1} s on {} {}: {} ok, {} not ok; {} cycles, {:.2} µs a cycle and thread\n",
        finished.progress.done,
        finished.points,
        totals.wall_time,
        finished.threads,
        if finished.threads == 1 {
            "thread"
        } else {
            "threads"
        },
        totals.ok,
        totals.failed,
        totals.cycles,
        1e6 * totals.wall_time_per_cycle * finished.threads as f64,
    );
    text += &match record.state {
        RunState::Complete => format!("results in {folder}; atlas show {folder} summarises them\n"),
        RunState::Interrupted => format!(
            "interrupted: {} points are missing; what is finished is in {folder}; the same command computes the job again\n",
            finished.missing
        ),
    };
    text
}
