//! `atlas table m.toml`: computes and stores the mesh table of a manifest's gears.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use clap::Args;
use serde_json::{Value, json};
use signal_hook::consts::SIGXFSZ;
use signal_hook::flag;

use super::manifest_args::ManifestArgs;
use super::threads::Threads;
use super::{
    BAD_INPUT, OrFail, Status, answer, fail, line, reply, start_threads, warn, with_causes,
};
use crate::gear::{Contact, FaceLaw, GearPair, MeshTable, MeshTableInputs};
use crate::manifest::{Job, StiffnessSpec};
use crate::store::{Fetched, Origin, TableStore};
use crate::units::{self, Dimension};

/// Arguments of `atlas table`.
#[derive(Debug, Args)]
pub struct TableArgs {
    #[command(flatten)]
    manifest: ManifestArgs,
    /// Compute these angles between the flanks, separated by commas, increasing [default: 0].
    #[arg(long, value_name = "ANGLE,...", value_delimiter = ',', allow_hyphen_values = true,
        value_parser = |text: &str| quantity(text, Dimension::Angle))]
    misalignment: Vec<f64>,
    /// Compute these torques on the pinion, separated by commas, increasing [default: the rated torque].
    #[arg(long, value_name = "TORQUE,...", value_delimiter = ',',
        value_parser = |text: &str| quantity(text, Dimension::Torque))]
    torque: Vec<f64>,
    /// Also keep the contact pattern.
    #[arg(long)]
    pattern: bool,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    folder: TablesFolder,
    /// Print nothing but errors.
    #[arg(long, short)]
    quiet: bool,
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
}

/// Where the tables are.
#[derive(Debug, Args)]
pub(super) struct TablesFolder {
    /// Keep computed tables in this folder. It is a cache that may be deleted at any time.
    #[arg(long, value_name = "DIR", default_value = "tables")]
    tables: PathBuf,
}

impl TablesFolder {
    /// The store in the folder.
    pub(super) fn store(&self) -> TableStore {
        TableStore::open(&self.tables)
    }
}

/// Exit status if a table cannot be stored.
const NO_ACCESS: u8 = 1;

fn quantity(text: &str, dimension: Dimension) -> Result<f64, String> {
    units::parse(text.trim(), dimension).map_err(|error| error.to_string())
}

/// Computes the tables: status 0 if all are stored, 1 if one cannot be stored, 2 for bad input.
pub fn run(args: &TableArgs) -> Status {
    let job = args.manifest.read_job()?;
    start_threads(args.threads.count())?;
    let drawings = drawings(&job);
    if drawings.is_empty() {
        let message =
            "has no drawing of its gears; a manifest of model.kind = \"flexible\" has one";
        return Err(fail(
            BAD_INPUT,
            &format!("`{}` {message}", args.manifest.name()),
        ));
    }
    // Without a handler, this signal ends the process silently when a file exceeds `ulimit -f`. With a handler, the
    // write fails and the error is printed.
    flag::register(SIGXFSZ, Arc::default()).or_explain(NO_ACCESS)?;
    let mut tables = Vec::new();
    for drawing in &drawings {
        let fetched = load_or_compute(args, drawing).or_fail(BAD_INPUT)?;
        for warning in &fetched.warnings {
            warn(&warning.to_string());
        }
        if fetched.origin == Origin::BuiltInMemory {
            return Ok(ExitCode::from(NO_ACCESS));
        }
        tables.push((fetched.file, fetched.origin));
    }
    let json = || {
        let records =
            (tables.iter()).map(|(file, origin)| json!({ "file": file, "origin": word(*origin) }));
        Value::from_iter(records)
    };
    let text = || {
        (tables.iter())
            .map(|(file, origin)| format!("{:<9} {}\n", word(*origin), file.display()))
            .collect()
    };
    let text = reply(args.json, args.quiet, json, text);
    Ok(answer(&text, ExitCode::SUCCESS))
}

/// A pair of gears, the contact law of its flanks (`mesh.contact`) and the law of its face (`mesh.face`).
#[derive(Debug, PartialEq)]
struct Drawing {
    gears: GearPair,
    contact: Contact,
    face: FaceLaw,
}

impl Drawing {
    /// A drawing with the laws that a manifest has by default.
    fn by_default(gears: GearPair) -> Self {
        let face = if gears.helix_angle == 0.0 { FaceLaw::Coupled } else { FaceLaw::Independent };
        Self {
            gears,
            contact: Contact::Secant,
            face,
        }
    }
}

/// The different drawings in a job; the gears have the bores of their shafts.
fn drawings(job: &Job) -> Vec<Drawing> {
    let mut drawings = Vec::new();
    for variant in job.points.variants() {
        let drawing = match &variant.mesh.stiffness {
            StiffnessSpec::Table(table) => Some(Drawing {
                gears: table.gears.clone(),
                contact: table.contact,
                face: table.face,
            }),
            _ => variant.model.source.gears().map(Drawing::by_default),
        };
        if let Some(drawing) = drawing
            && !drawings.contains(&drawing)
        {
            drawings.push(drawing);
        }
    }
    drawings
}

/// The mesh table of a drawing for these arguments, from the store or computed, with its file.
fn load_or_compute(args: &TableArgs, drawing: &Drawing) -> Result<Fetched<MeshTable>, String> {
    let gears = &drawing.gears;
    let mut inputs = MeshTableInputs {
        contact: drawing.contact,
        face: drawing.face,
        pattern: args.pattern,
        ..MeshTableInputs::of_gears(gears)
    };
    if !args.misalignment.is_empty() {
        inputs.misalignment.clone_from(&args.misalignment);
    }
    if !args.torque.is_empty() {
        inputs.torque.clone_from(&args.torque);
    }
    let template = "{bar:10} {pos}/{len}  ETA {eta}  {wide_msg}";
    let bar = line::bar(None, args.quiet, template);
    bar.set_message("stretches of the mesh cycle");
    let progress = |_, all: usize| {
        bar.set_length(all as u64);
        bar.inc(1);
    };
    let store = args.folder.store();
    let fetched = store.mesh_table(gears, &inputs, &progress);
    bar.finish_and_clear();
    fetched.map_err(|error| with_causes(&error))
}

/// The origin of a table, as text: `computed`, or `found` in the store.
fn word(origin: Origin) -> &'static str {
    match origin {
        Origin::Found => "found",
        Origin::Built | Origin::BuiltInMemory => "computed",
    }
}
