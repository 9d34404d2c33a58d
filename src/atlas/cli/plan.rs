//! `atlas plan m.toml`: forecasts the cost of a run. Computes a few points without keeping them. With results of
//! `atlas machine`, also gives the gain from threads on this machine, and the cost of the run on another measured
//! machine.

use super::manifest_args::ManifestArgs;
use super::process::{NOTHING_WRITTEN, Process};
use super::table::TablesFolder;
use super::threads::Threads;
use super::{
    BAD_INPUT, OrFail, Status, answer, fail, grid, labelled, machine, scratch_folder, with_causes,
};
use crate::characterize::compare::{MachineRate, machine_rate};
use crate::manifest::Job;
use crate::report::size_text;
use crate::store::{Characteristics, Shard, StoreError};
use crate::sweep::Prepared;
use crate::sweep::{self, Forecast, Interval, Options, Sweep};
use crate::topology::Source;
use crate::units::plural;
use clap::Args;
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// Time limit for the sample points.
const BUDGET: Duration = Duration::from_secs(10);

/// Arguments of `atlas plan`.
#[derive(Debug, Args)]
pub struct PlanArgs {
    #[command(flatten)]
    manifest: ManifestArgs,
    #[command(flatten)]
    threads: Threads,
    /// Estimate only part i of n, as `atlas run --shard i/n` computes it [default: all points].
    #[arg(long, value_name = "i/n", value_parser = super::run_args::parse_shard)]
    pub shard: Option<Shard>,
    /// Read the results of `atlas machine` for this machine from this folder [default: results/machine-HOST if present].
    #[arg(long, value_name = "DIR")]
    pub machine: Option<PathBuf>,
    /// Also estimate the run on another machine, from the folder with its results of `atlas machine`.
    #[arg(long, value_name = "DIR")]
    pub on: Option<PathBuf>,
    #[command(flatten)]
    tables: TablesFolder,
    /// Print JSON instead of text.
    #[arg(long)]
    pub json: bool,
}

/// Forecasts a run: status 0, 1 if the sample points cannot be computed, 2 for bad input, 130 if interrupted.
pub fn run(args: &PlanArgs) -> Status {
    let job = args.manifest.read_job()?;
    let refused = args.shard.and_then(|_| grid::refuses(&job, "--shard"));
    if let Some(refusal) = refused {
        return Err(fail(BAD_INPUT, &refusal));
    }
    let machines = Machines::read(args).or_fail(BAD_INPUT)?;
    let process = Process::prepare(NOTHING_WRITTEN)?;
    let scratch = scratch_folder()?;
    let parts = Prepared::new(args.tables.store());
    let sweep = Sweep {
        job: &job,
        folder: scratch.path(),
        options: Options {
            threads: args.threads.count(),
            shard: args.shard,
            ..Options::default()
        },
        parts: &parts,
        topology: process.topology.as_ref(),
        interrupt: &process.interrupt,
    };
    let Some(found) = sweep::forecast(&sweep, BUDGET).or_explain(1)? else {
        return Err(ExitCode::from(super::INTERRUPTED));
    };
    let measured = machines.measured(&job, &found, args.threads.asked);
    let source = process.topology.map(|topology| topology.source);
    let text = if args.json {
        document(&job, &found, &measured, source)
    } else {
        text(&job, &found, source) + &measured.text()
    };
    Ok(answer(&text, ExitCode::SUCCESS))
}

/// The forecast and the measured rates of the machines, as JSON.
fn document(
    job: &Job,
    forecast: &Forecast,
    measured: &Measured,
    topology: Option<Source>,
) -> String {
    let mut document = json!(forecast);
    let parts = [
        ("topology", json!(topology.map(|source| source.to_string()))),
        ("refine", grid::refine_json(job)),
        ("machine", json!(measured.here)),
        ("elsewhere", json!(measured.there)),
    ];
    for (key, part) in parts.into_iter().filter(|(_, part)| !part.is_null()) {
        document[key] = part;
    }
    format!("{document:#}\n")
}

/// Results of `atlas machine` for this machine and for the machine of `--on`.
struct Machines {
    here: Option<Characteristics>,
    there: Option<Characteristics>,
}

/// The measured rates of both machines for the modes of a job.
struct Measured {
    here: Option<MachineRate>,
    /// The rate of the machine of `--on`, and the estimated time of the job on it \[s\].
    there: Option<(MachineRate, Interval)>,
}

impl Machines {
    /// Reads the requested results. Without --machine, reads those of this machine from the default folder, if present.
    fn read(args: &PlanArgs) -> Result<Self, String> {
        let read =
            |folder: &PathBuf| Characteristics::read(folder).map_err(|error| with_causes(&error));
        let usual = || {
            let read = Characteristics::read(&machine::default_folder());
            StoreError::if_there(read).map_err(|error| with_causes(&error))
        };
        let here = args
            .machine
            .as_ref()
            .map_or_else(usual, |f| read(f).map(Some))?;
        let there = args.on.as_ref().map(read).transpose()?;
        if there.is_some() && here.is_none() {
            return Err(
                "--on needs measurements of this machine, and there are none; run `atlas machine --quick` here, or \
                 give their folder with --machine"
                    .to_owned(),
            );
        }
        Ok(Self { here, there })
    }

    /// The measured rates for a job, and its time on the machine of `--on`. `forecast` is for this machine.
    /// `threads` is the requested number of threads.
    fn measured(&self, job: &Job, forecast: &Forecast, threads: Option<u32>) -> Measured {
        let variants = job.points.variants().iter();
        let modes = variants.map(|variant| variant.model.retained).max();
        let modes = modes.unwrap_or(1);
        let own = |modes| machine_rate(self.here.as_ref()?, modes, forecast.threads);
        let here = own(modes);
        let there = self.there.as_ref().and_then(|machine| {
            let cores = machine.description.cores as u64;
            let threads = threads.map_or(cores, u64::from).min(forecast.pieces);
            // Compare the machines at a number of modes that both have measured.
            let there = machine_rate(machine, here.as_ref()?.modes as usize, threads)?;
            let own = own(there.modes as usize).filter(|own| own.modes == there.modes)?;
            let slower = own.rate / there.rate;
            let time = Interval {
                low: slower * forecast.time.low,
                expected: slower * forecast.time.expected,
                high: slower * forecast.time.high,
            };
            Some((there, time))
        });
        Measured { here, there }
    }
}

impl Measured {
    fn text(&self) -> String {
        let threads = |count: u64| plural(count as usize, "thread");
        let noise = |rate: &MachineRate| {
            if rate.quiet { "" } else { ", while the machine was busy" }
        };
        let mut text = String::new();
        if let Some(here) = &self.here {
            let date = here.measured.get(..10).unwrap_or_default();
            text.push_str(&format!(
                "machine     {} at {:.0} % of ideal, no gain beyond {}; measured {date}{}\n",
                threads(here.threads),
                100.0 * here.efficiency,
                threads(here.worthwhile),
                noise(here),
            ));
        }
        if let Some((there, time)) = &self.there {
            text.push_str(&format!(
                "on {:<8} {} ({} to {}) with {}{}\n",
                there.host,
                duration(time.expected),
                duration(time.low),
                duration(time.high),
                threads(there.threads),
                noise(there),
            ));
        }
        text
    }
}

fn text(job: &Job, forecast: &Forecast, topology: Option<Source>) -> String {
    let points = match job.refine {
        Some(_) => grid::points(job),
        None => forecast.points.to_string(),
    };
    let mut lines = vec![("points", points)];
    if job.refine.is_some() {
        let known = format!("the estimate covers only the first {}", forecast.points);
        lines.push(("", known));
    }
    if forecast.chain_length > 1 {
        let chains = forecast.points / forecast.chain_length;
        lines.push((
            "chains",
            format!("{chains} of {} points", forecast.chain_length),
        ));
    }
    lines.push(("tables", format!("{} of the mesh", forecast.tables)));
    lines.push((
        "placement",
        match topology {
            Some(source) => format!("{}; topology from {source}", forecast.placement),
            None => forecast.placement.clone(),
        },
    ));
    let time = &forecast.time;
    let at_least = if forecast.cut_short > 0 { "at least " } else { "" };
    lines.push((
        "time",
        format!(
            "{at_least}{} ({} to {}), from {} points in {}",
            duration(time.expected),
            duration(time.low),
            duration(time.high),
            forecast.calibrated,
            duration(forecast.calibration_time),
        ),
    ));
    if forecast.cut_short > 0 {
        let cut = format!(
            "{} of these points were stopped because they took too long",
            forecast.cut_short
        );
        lines.push(("", cut));
    }
    if let Some(memory) = forecast.memory {
        lines.push(("memory", format!("at most about {}", size_text(memory))));
    }
    lines.push((
        "disk",
        format!(
            "about {}, plus {} of journal until the run ends",
            size_text(forecast.disk),
            size_text(forecast.journal)
        ),
    ));
    labelled(12, &lines)
}

/// A duration for users: `0.42 s`, `3 min 20 s`, `5 h 12 min`.
fn duration(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match whole {
        0..10 => format!("{seconds:.2} s"),
        10..100 => format!("{seconds:.0} s"),
        100..7200 => format!("{} min {} s", whole / 60, whole % 60),
        _ => format!("{} h {} min", whole / 3600, whole / 60 % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_for_people() {
        let wanted = ["0.42 s", "9.42 s", "42 s", "3 min 20 s", "5 h 12 min"];
        for (seconds, wanted) in [0.42, 9.42, 42.4, 200.0, 18_720.0].into_iter().zip(wanted) {
            assert_eq!(duration(seconds), wanted);
        }
    }
}
