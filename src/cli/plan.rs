//! `atlas plan m.toml`: what a run will take. Computes a few points, keeps none of them.

use super::process::Process;
use super::table::TablesFolder;
use super::{BAD_INPUT, answer, check, fail, with_causes};
use crate::manifest;
use crate::report::size_text;
use crate::store::Shard;
use crate::sweep::build::Parts;
use crate::sweep::{self, Forecast, Options};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// Most time spent on points beforehand.
const BUDGET: Duration = Duration::from_secs(10);

/// Arguments of `atlas plan`.
#[derive(Debug, Args)]
pub struct PlanArgs {
    /// The manifest.
    pub manifest: PathBuf,
    /// Worker threads [default: one a core this process may use].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub threads: Option<u32>,
    /// Only part i of n, as `atlas run --shard i/n` would compute.
    #[arg(long, value_name = "i/n", value_parser = super::run::parse_shard)]
    pub shard: Option<Shard>,
    #[command(flatten)]
    tables: TablesFolder,
    /// Print JSON for programs.
    #[arg(long)]
    pub json: bool,
}

/// Says what a run will take: status 0, or 2 for bad input.
pub fn run(args: &PlanArgs) -> ExitCode {
    let job = match manifest::load(&args.manifest) {
        Ok(job) => job,
        Err(errors) => {
            check::report(&errors);
            return ExitCode::from(BAD_INPUT);
        }
    };
    let process = match Process::prepare() {
        Ok(process) => process,
        Err(error) => return fail(1, &format!("cannot watch for signals: {error}")),
    };
    let scratch = match tempfile::tempdir() {
        Ok(scratch) => scratch,
        Err(error) => return fail(1, &format!("cannot make a temporary folder: {error}")),
    };
    let options = Options {
        threads: args.threads.map(|n| n as usize),
        shard: args.shard,
        ..Options::default()
    };
    let parts = Parts::new(args.tables.store());
    let found = sweep::forecast(
        &job,
        options,
        &parts,
        process.topology.as_ref(),
        BUDGET,
        &process.called_off,
        scratch.path(),
    );
    match found {
        Err(error) => fail(1, &with_causes(&error)),
        Ok(None) => ExitCode::from(super::INTERRUPTED),
        Ok(Some(found)) if args.json => {
            // Plain data; it always has a JSON form.
            let json = serde_json::to_string_pretty(&found).unwrap_or_default();
            answer(&format!("{json}\n"), ExitCode::SUCCESS)
        }
        Ok(Some(found)) => answer(&text(&found), ExitCode::SUCCESS),
    }
}

fn text(found: &Forecast) -> String {
    let mut lines = vec![("points", found.points.to_string())];
    if found.chain_length > 1 {
        let chains = found.points / found.chain_length;
        lines.push((
            "chains",
            format!("{chains} of {} points", found.chain_length),
        ));
    }
    lines.push(("tables", format!("{} of the mesh", found.tables)));
    lines.push(("placement", found.placement.clone()));
    let time = &found.time;
    let at_least = if found.cut_short > 0 { "at least " } else { "" };
    lines.push((
        "time",
        format!(
            "{at_least}{} ({} to {}), from {} points in {}",
            duration(time.expected),
            duration(time.low),
            duration(time.high),
            found.calibrated,
            duration(found.calibration_time),
        ),
    ));
    if found.cut_short > 0 {
        let cut = format!(
            "{} of these points took too long and were given up",
            found.cut_short
        );
        lines.push(("", cut));
    }
    if let Some(memory) = found.memory {
        lines.push(("memory", format!("about {}", size_text(memory))));
    }
    lines.push((
        "disk",
        format!(
            "about {}, and {} of journal until the run ends",
            size_text(found.disk),
            size_text(found.journal)
        ),
    ));
    lines
        .iter()
        .map(|(head, line)| format!("{head:<11} {line}\n"))
        .collect()
}

/// A time for people: `0.42 s`, `3 min 20 s`, `5 h 12 min`.
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
