//! `atlas table build m.toml`: the mesh table of a manifest's gears, computed and kept.

use std::io::{IsTerminal, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use clap::Args;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::{Value, json};
use signal_hook::consts::SIGXFSZ;
use signal_hook::flag;

use super::{Folder, NO_ACCESS};
use crate::cli::{BAD_INPUT, answer, check, fail, with_causes};
use crate::gear::{GearPair, MeshTableInputs};
use crate::manifest::{self, Job, StructureSource};
use crate::store::{FetchedMesh, Origin};
use crate::units::{self, Dimension};

/// Arguments of `atlas table build`.
#[derive(Debug, Args)]
pub struct BuildArgs {
    /// The manifest, with a drawing of its gears.
    manifest: PathBuf,
    /// Angles between the flanks, separated by commas, increasing.
    #[arg(long, value_name = "ANGLE,...", value_delimiter = ',', default_value = "0 mrad",
        value_parser = |text: &str| quantity(text, Dimension::Angle))]
    misalignment: Vec<f64>,
    /// Torques on the pinion, separated by commas, increasing [default: the rated torque].
    #[arg(long, value_name = "TORQUE,...", value_delimiter = ',',
        value_parser = |text: &str| quantity(text, Dimension::Torque))]
    torque: Vec<f64>,
    /// Keep the contact pattern, too.
    #[arg(long)]
    pattern: bool,
    #[command(flatten)]
    folder: Folder,
    /// Print nothing but errors.
    #[arg(long, short)]
    quiet: bool,
    /// Print JSON for programs.
    #[arg(long)]
    json: bool,
}

fn quantity(text: &str, dimension: Dimension) -> Result<f64, String> {
    units::parse(text.trim(), dimension).map_err(|error| error.to_string())
}

/// Builds the tables: status 0 when all are kept, 1 where one cannot be, 2 for bad input.
pub fn run(args: &BuildArgs) -> ExitCode {
    let job = match manifest::load(&args.manifest) {
        Ok(job) => job,
        Err(errors) => {
            check::report(&errors);
            return ExitCode::from(BAD_INPUT);
        }
    };
    let drawings = drawings(&job);
    if drawings.is_empty() {
        let message =
            "has no drawing of its gears; a manifest of model.kind = \"flexible\" has one";
        return fail(
            BAD_INPUT,
            &format!("`{}` {message}", args.manifest.display()),
        );
    }
    // Unwatched, this one would end the process without a word when a file outgrows
    // `ulimit -f`; watched, the write fails and the error is said.
    if let Err(error) = flag::register(SIGXFSZ, Arc::default()) {
        return fail(NO_ACCESS, &with_causes(&error));
    }
    let mut tables = Vec::new();
    for gears in &drawings {
        let fetched = match fetch(args, gears) {
            Ok(fetched) => fetched,
            Err(message) => return fail(BAD_INPUT, &message),
        };
        for warning in &fetched.warnings {
            // Nothing can be done when standard error is closed.
            _ = writeln!(std::io::stderr().lock(), "warning: {warning}");
        }
        if fetched.origin == Origin::BuiltInMemory {
            return ExitCode::from(NO_ACCESS);
        }
        tables.push(fetched);
    }
    let text = match (args.json, args.quiet) {
        (true, _) => format!("{:#}\n", Value::from_iter(tables.iter().map(record))),
        (false, true) => String::new(),
        (false, false) => tables.iter().map(line).collect(),
    };
    answer(&text, ExitCode::SUCCESS)
}

/// The different pairs of gears of a job, their bores those of the shafts.
fn drawings(job: &Job) -> Vec<GearPair> {
    let mut last = None;
    let mut drawings = Vec::new();
    for point in &job.points {
        let StructureSource::Flexible(drive) = &point.model.source else {
            continue;
        };
        // Points of one structure share it: most are done with here.
        if last.replace(Arc::as_ptr(drive)) == Some(Arc::as_ptr(drive)) {
            continue;
        }
        let diameters = [0, 1].map(|shaft| drive.shafts[shaft].diameter);
        let gears = drive.gears.on_shafts(diameters);
        if !drawings.contains(&gears) {
            drawings.push(gears);
        }
    }
    drawings
}

fn fetch(args: &BuildArgs, gears: &GearPair) -> Result<FetchedMesh, String> {
    let mut inputs = MeshTableInputs {
        misalignment: args.misalignment.clone(),
        pattern: args.pattern,
        ..MeshTableInputs::of_gears(gears)
    };
    if !args.torque.is_empty() {
        inputs.torque.clone_from(&args.torque);
    }
    let target = match args.quiet || !std::io::stderr().is_terminal() {
        true => ProgressDrawTarget::hidden(),
        false => ProgressDrawTarget::stderr(),
    };
    let bar = ProgressBar::with_draw_target(None, target);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} mesh phases  ETA {eta}") {
        bar.set_style(style);
    }
    let progress = |_, all: usize| {
        bar.set_length(all as u64);
        bar.inc(1);
    };
    let store = args.folder.store();
    let fetched = store.mesh_table(gears, &inputs, &progress);
    bar.finish_and_clear();
    fetched.map_err(|error| with_causes(&error))
}

/// `computed`, or `found`.
fn word(table: &FetchedMesh) -> &'static str {
    match table.origin {
        Origin::Found => "found",
        Origin::Built | Origin::BuiltInMemory => "computed",
    }
}

fn line(table: &FetchedMesh) -> String {
    let file = table.file.display();
    format!("{:<9} {file}\n", word(table))
}

fn record(table: &FetchedMesh) -> Value {
    json!({ "file": table.file, "origin": word(table) })
}
