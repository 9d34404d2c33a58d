//! `atlas runup m.toml`: one run-up or run-down, as a test bench records it.

use super::manifest_args::ManifestArgs;
use super::point::{self, PointArg};
use super::process::{NOTHING_WRITTEN, Process, begin_writing};
use super::recording;
use super::table::TablesFolder;
use super::threads::Threads;
use super::{BAD_INPUT, INTERRUPTED, OrFail, Status, either, fail, labelled, start_threads};
use crate::analysis::run_up::{RunUp, RunUpConfig};
use crate::manifest::Job;
use crate::report::{Unit, to_digits};
use crate::store::{TableKind, table_path, write_run_up};
use crate::sweep::{PointRunUp, Prepared, RunUpError};
use clap::Args;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Arguments of `atlas runup`.
#[derive(Debug, Args)]
pub struct RunupArgs {
    #[command(flatten)]
    manifest: ManifestArgs,
    #[command(flatten)]
    point: PointArg,
    /// Write the files to this folder [default: results/JOB/runup-POINT].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace files that already exist.
    #[arg(long)]
    pub overwrite: bool,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    tables: TablesFolder,
    /// Print JSON instead of text.
    #[arg(long)]
    pub json: bool,
}

/// Runs one drive up: status 0 if done, 1 if files cannot be written, 2 for bad input, 3 if the motion could not be
/// integrated to the end, 130 if interrupted.
pub fn run(args: &RunupArgs) -> Status {
    let job = args.manifest.read_job()?;
    let Some(spec) = &job.run_up else {
        let message = "the manifest has no table [runup]; add `[runup]` with `speed = { from = \"600 rpm\", to = \"6000 rpm\", in = \"10 s\" }`";
        return Err(fail(BAD_INPUT, message));
    };
    // A run-up ignores the speed of its point, so the first point can be the default.
    let has_point = !args.point.text.is_empty();
    let point = point::read_point(&job, if has_point { &args.point.text } else { "0" })?;
    let label = if has_point { &point.label } else { "" };
    let folder = (args.out.clone()).unwrap_or_else(|| recording::folder(&job, "runup", label));
    let existing = recording::existing_message(&folder, TableKind::Signals, "run-up");
    if let Some(message) = existing.filter(|_| !args.overwrite) {
        return Err(fail(BAD_INPUT, &message));
    }
    let process = Process::prepare(NOTHING_WRITTEN)?;
    start_threads(args.threads.count())?;
    let parts = Prepared::new(args.tables.store());
    let run_up = PointRunUp {
        point: &point.spec,
        spec,
        parts: &parts,
    };
    let (config, run) = match run_up.record(&process.interrupt) {
        Err(RunUpError::Interrupted) => return Err(fail(INTERRUPTED, NOTHING_WRITTEN)),
        recorded => recorded.or_fail(BAD_INPUT)?,
    };
    begin_writing();
    let json = || summary_json(&job, &config, &run, &folder);
    let text = either(args.json, json, || summary(&job, &config, &run, &folder));
    let stop = run.stop;
    write_run_up(
        &folder,
        &metadata(&job, &point.values, &config),
        &config,
        run,
    )
    .or_fail(1)?;
    Ok(recording::ended(&text, "run-up", stop))
}

/// The origin of the tables, as metadata.
fn metadata(
    job: &Job,
    values: &[(String, f64)],
    config: &RunUpConfig,
) -> Vec<(&'static str, String)> {
    let point = serde_json::Value::Object(recording::values_json(values));
    vec![
        ("job", job.name.clone()),
        ("manifest_hash", job.hash.clone()),
        ("point", point.to_string()),
        (
            "sample_rate",
            json!({ "value": config.sample_rate, "unit": "Hz" }).to_string(),
        ),
    ]
}

/// Label and path of each file of a run-up; only the first label has text.
fn files(folder: &Path) -> [(&'static str, String); 5] {
    let path = |kind| table_path(folder, kind, None).display().to_string();
    [
        ("files", path(TableKind::Signals)),
        ("", path(TableKind::OrderTracks)),
        ("", path(TableKind::Levels)),
        ("", path(TableKind::Spectrogram)),
        ("", path(TableKind::ContactChanges)),
    ]
}

fn summary(job: &Job, config: &RunUpConfig, run: &RunUp, folder: &Path) -> String {
    let rpm = Unit::or_si(Some("rpm"), "rad/s").factor;
    let ends = [0.0, config.duration()];
    let [from, to] = ends.map(|time| to_digits(rpm * config.speed_at(time), 5));
    let [first, last] = ends.map(|time| to_digits(config.load_at(time), 4));
    let mut lines = vec![
        (
            "run-up",
            format!(
                "{}: {from} to {to} rpm in {} s, load {first} to {last}",
                job.name,
                config.duration()
            ),
        ),
        ("passed", format!("{:.0} mesh cycles", run.cycles)),
        (
            "events",
            format!(
                "{}, {:.2} per cycle",
                run.events.len(),
                run.events.len() as f64 / run.cycles
            ),
        ),
    ];
    if run.levels.is_empty() && !run.signals.is_empty() {
        let turns = config.revolutions;
        let why = format!(
            "none: the run-up is shorter than a stretch of {turns} revolutions; reduce runup.revolutions"
        );
        lines.push(("levels", why));
    }
    for (signal, [name, unit]) in run.signals.iter().enumerate() {
        let levels = || run.levels.iter().filter(|level| level.signal == signal);
        if let Some(loudest) = levels().max_by(|a, b| a.rms.total_cmp(&b.rms)) {
            lines.push((
                if signal == 0 { "loudest" } else { "" },
                format!(
                    "{name}: {} {unit} RMS at {} rpm",
                    to_digits(loudest.rms, 4),
                    to_digits(rpm * loudest.speed, 4)
                ),
            ));
        }
    }
    lines.extend(files(folder));
    labelled(10, &lines)
}

fn summary_json(job: &Job, config: &RunUpConfig, run: &RunUp, folder: &Path) -> serde_json::Value {
    let ends = [0.0, config.duration()];
    json!({
        "job": job.name,
        "speed": ends.map(|time| config.speed_at(time)),
        "load": ends.map(|time| config.load_at(time)),
        "duration": config.duration(),
        "cycles": run.cycles,
        "events": run.events.len(),
        "signals": run.signals.iter().map(|[name, unit]| json!({ "name": name, "unit": unit })).collect::<Vec<_>>(),
        "stop": run.stop.map(|stop| stop.to_string()),
        "files": files(folder).map(|(_, path)| path),
    })
}
