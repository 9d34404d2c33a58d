//! `atlas verify`: the validation checks on this machine.

use super::threads::Threads;
use super::{OrFail, Status, answer, either, line, start_threads};
use crate::topology::Machine;
use crate::verify::{self, CHECKS, Check, Extent, Report, Subjects};
use clap::Args;
use clap::builder::PossibleValuesParser;
use indicatif::ProgressBar;
use serde_json::json;
use std::process::ExitCode;
use std::time::Duration;

/// Arguments of `atlas verify`.
#[derive(Debug, Args)]
pub struct VerifyArgs {
    /// Use longer horizons and more cycles per drive: many minutes instead of seconds.
    #[arg(long)]
    full: bool,
    /// Run only this check; repeat the option for several [default: all].
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(CHECKS.iter().map(|check| check.name)))]
    only: Vec<String>,
    #[command(flatten)]
    threads: Threads,
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
}

/// Runs the checks: status 0 if all pass, 1 if one fails.
pub fn run(args: &VerifyArgs) -> Status {
    start_threads(args.threads.count())?;
    let extent = if args.full { Extent::Full } else { Extent::Quick };
    let wanted = |check: &Check| args.only.is_empty() || args.only.iter().any(|n| n == check.name);
    let checks: Vec<Check> = CHECKS.iter().copied().filter(wanted).collect();
    let subjects = Subjects::all(extent).or_fail(1)?;
    let bar = bar(checks.len() as u64);
    let mut begun = 0;
    let report = verify::run(&subjects, &checks, &mut |check| {
        bar.set_position(begun);
        bar.set_message(check.name);
        begun += 1;
    });
    bar.finish_and_clear();
    let text = either(args.json, || document(&report), || report.to_string());
    Ok(answer(&text, ExitCode::from(report.status())))
}

/// A progress bar on a terminal; it draws nothing elsewhere.
fn bar(checks: u64) -> ProgressBar {
    let template = "{bar:10} {pos}/{len} checks  {elapsed}  {wide_msg}";
    let bar = line::bar(Some(checks), false, template);
    bar.enable_steady_tick(Duration::from_millis(250));
    bar
}

/// The report for programs, with a description of the machine.
fn document(report: &Report) -> serde_json::Value {
    let machine = Machine::current();
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "machine": { "cpu": machine.cpu, "isa": machine.isa, "system": machine.system },
        "extent": report.extent.name(),
        "passed": report.passed(),
        "failures": report.failures(),
        "skips": report.skips(),
        "seconds": report.seconds,
        "checks": report.findings,
    })
}
