//! `atlas trace m.toml --point …`: one trajectory in detail, with its events.

use super::manifest_args::ManifestArgs;
use super::point::{self, ChosenPoint, PointArg, number};
use super::process::{NOTHING_WRITTEN, Process, begin_writing};
use super::recording;
use super::table::TablesFolder;
use super::threads::Threads;
use super::{BAD_INPUT, INTERRUPTED, OrFail, Status, either, fail, labelled, start_threads};
use crate::analysis::{Signals, TraceConfig, TraceOutcome, named_outputs};
use crate::manifest::Job;
use crate::model::Model;
use crate::propagate::Stop;
use crate::report::Unit;
use crate::store::{TableKind, TraceLabel, TraceWriter, table_path};
use crate::sweep::{PointTrace, PointTraceError, Prepared};
use clap::Args;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Arguments of `atlas trace`.
#[derive(Debug, Args)]
pub struct TraceArgs {
    #[command(flatten)]
    manifest: ManifestArgs,
    #[command(flatten)]
    point: PointArg,
    /// Record this many mesh cycles.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    pub cycles: u64,
    /// Discard this many mesh cycles before recording [default: run.transient of the manifest].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(0..=1_000_000_000))]
    pub skip: Option<u64>,
    /// Record this many samples per mesh cycle, evenly spaced from mesh phase 0.
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub samples_per_cycle: u32,
    /// Also record modal displacements and velocities.
    #[arg(long)]
    pub modal: bool,
    /// Also record deflections and forces of all meshes, torques, accelerations, and rotations of gears relative to the
    /// mean rotation, one column each.
    #[arg(long)]
    pub outputs: bool,
    /// Write the files to this folder [default: results/JOB/trace-POINT].
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

/// Traces one operating point: status 0 if done, 1 if threads cannot start or files cannot be written, 2 for bad input,
/// 3 if the trajectory could not be integrated to the end, 130 if interrupted.
pub fn run(args: &TraceArgs) -> Status {
    let job = args.manifest.read_job()?;
    let point = point::read_point(&job, &args.point.text)?;
    let folder =
        (args.out.clone()).unwrap_or_else(|| recording::folder(&job, "trace", &point.label));
    if let Some(message) =
        recording::existing_message(&folder, TableKind::Trace, "trace").filter(|_| !args.overwrite)
    {
        return Err(fail(BAD_INPUT, &message));
    }
    let process = Process::prepare(NOTHING_WRITTEN)?;
    start_threads(args.threads.count())?;
    let parts = Prepared::new(args.tables.store());
    let trace = PointTrace {
        job: &job,
        point: &point.spec,
        swept: point.direction.is_some(),
        config: TraceConfig {
            skip: args.skip.unwrap_or(point.spec.run.transient),
            cycles: args.cycles,
            samples_per_cycle: args.samples_per_cycle,
            modal: args.modal,
            outputs: Signals {
                bearings: true,
                torques: args.outputs,
                accelerations: args.outputs,
                meshes: args.outputs,
                rotations: args.outputs,
                ..Signals::NONE
            },
        },
        parts: &parts,
    };
    let model = trace.model().or_fail(BAD_INPUT)?;
    let config = &trace.config;
    let label = label(&job, &point, &model, config);
    let open = || TraceWriter::create(&folder, &label, config.modal);
    let (outcome, writer) = match trace.record(&model, &process.interrupt, open) {
        Ok((outcome, _)) if matches!(outcome.stop, Some(Stop::Interrupted { .. })) => {
            return Err(fail(INTERRUPTED, NOTHING_WRITTEN));
        }
        Err(PointTraceError::Interrupted(_)) => {
            return Err(fail(INTERRUPTED, NOTHING_WRITTEN));
        }
        recorded => recorded.or_fail(1)?,
    };
    begin_writing();
    writer.finish().or_fail(1)?;
    let json = || summary_json(&job, &point, &outcome, &folder);
    let text = || summary(&job, &point, &model, config, &outcome, &folder);
    let text = either(args.json, json, text);
    Ok(recording::ended(&text, "trace", outcome.stop))
}

/// The metadata of the trace: its job, its point, and data of its model.
fn label(job: &Job, point: &ChosenPoint, model: &Model, config: &TraceConfig) -> TraceLabel {
    TraceLabel {
        job: job.name.clone(),
        manifest_hash: job.hash.clone(),
        point: (job.axes.iter().zip(&point.values))
            .map(|(axis, (name, value))| (name.clone(), *value, axis.unit.clone()))
            .collect(),
        period: model.period(),
        half_gap: point.spec.mesh.length.is_none().then_some(model.half_gap),
        outputs: named_outputs(model, config.outputs)
            .map(|(name, quantity)| [name, quantity.unit().to_owned()])
            .collect(),
    }
}

fn summary(
    job: &Job,
    point: &ChosenPoint,
    model: &Model,
    config: &TraceConfig,
    outcome: &TraceOutcome,
    folder: &Path,
) -> String {
    let units = job.written().axis_units();
    let values: Vec<String> = (job.axes.iter().zip(&point.values))
        .map(|(axis, (name, value))| {
            let unit = Unit::of_axis(&units, name, &axis.unit);
            format!("{name} {}", unit.amount(number, *value))
        })
        .chain(point.direction.map(|way| format!("sweep {}", way.name())))
        .collect();
    let mut lines = vec![
        ("point", format!("{}: {}", job.name, values.join(", "))),
        (
            "recorded",
            format!(
                "{} mesh cycles of {:.4} ms, from cycle {} on; {} samples",
                outcome.cycles,
                1e3 * model.period(),
                config.skip,
                outcome.samples
            ),
        ),
        (
            "events",
            match events_per_cycle(outcome) {
                Some(rate) => format!("{}, {rate:.2} per cycle", outcome.events),
                None => outcome.events.to_string(),
            },
        ),
    ];
    if outcome.jumped > 0 {
        lines.insert(
            1,
            (
                "skipped",
                format!(
                    "{} mesh cycles, {} of them in one step because contact was certain to last",
                    config.skip, outcome.jumped
                ),
            ),
        );
    }
    if let Some(nvh) = &outcome.nvh {
        let [drive, free, coast, both] = nvh.values.fractions.map(|f| 100.0 * f);
        lines.push((
            "contact",
            format!(
                "drive {drive:.1} %, free {free:.1} %, coast {coast:.1} %, both {both:.1} % of the time"
            ),
        ));
        lines.push((
            "force",
            format!(
                "largest {:.4} N, mean {:.4} N",
                nvh.force_peak, nvh.values.force_mean
            ),
        ));
    }
    for (head, kind) in [("files", TableKind::Trace), ("", TableKind::Events)] {
        lines.push((head, table_path(folder, kind, None).display().to_string()));
    }
    labelled(10, &lines)
}

fn summary_json(
    job: &Job,
    point: &ChosenPoint,
    outcome: &TraceOutcome,
    folder: &Path,
) -> serde_json::Value {
    let nvh = outcome.nvh.as_ref();
    json!({
        "job": job.name,
        "point": recording::values_json(&point.values),
        "direction": point.direction.map(|direction| direction.name()),
        "cycles": outcome.cycles,
        "jumped": outcome.jumped,
        "samples": outcome.samples,
        "events": outcome.events,
        "events_per_cycle": events_per_cycle(outcome),
        "fraction_drive": nvh.map(|n| n.values.fractions[0]),
        "fraction_free": nvh.map(|n| n.values.fractions[1]),
        "fraction_coast": nvh.map(|n| n.values.fractions[2]),
        "fraction_both": nvh.map(|n| n.values.fractions[3]),
        "force_peak": nvh.map(|n| n.force_peak),
        "force_mean": nvh.map(|n| n.values.force_mean),
        "stop": outcome.stop.map(|stop| stop.to_string()),
        "trace": table_path(folder, TableKind::Trace, None),
        "events_file": table_path(folder, TableKind::Events, None),
    })
}

/// Events per mesh cycle; `None` if not even the first cycle was finished.
fn events_per_cycle(outcome: &TraceOutcome) -> Option<f64> {
    (outcome.cycles > 0).then(|| outcome.events as f64 / outcome.cycles as f64)
}
