//! `atlas check m.toml`: lists all errors of a manifest, or its points and settings. Writes no file.

use super::analyses::analyses;
use super::excitation::{self, Cause};
use super::gear_mesh::GearMesh;
use super::kernel::{self, FirstKernel};
use super::loaded_bearings::LoadedBearings;
use super::manifest_args::{ManifestArgs, report, warn};
use super::structure::{self, Structure};
use super::{BAD_INPUT, Status, answer, grid, pretty, start_threads_for_tables, words};
use crate::gear::{CycleDivision, MeshTableSpec};
use crate::input::{clipped, printable};
use crate::manifest::{
    CoastSpec, DampingSpec, Diagnostic, Job, ManifestErrors, PointSpec, Source, StiffnessSpec,
    StructureSource, Variant, advice,
};
use crate::report::{Unit, to_digits};
use crate::store::TableStore;
use crate::sweep::Prepared;
use clap::Args;
use serde_json::{Value, json};
use std::process::ExitCode;

/// Arguments of `atlas check`.
#[derive(Debug, Args)]
pub struct CheckArgs {
    #[command(flatten)]
    pub(super) manifest: ManifestArgs,
    /// Print JSON instead of text.
    #[arg(long)]
    pub json: bool,
}

/// Largest number of characters in a line of the summary.
const MOST_CHARACTERS: usize = 2000;

/// Largest number of values of an axis in the output for programs.
const MOST_VALUES: usize = 10_000;

/// Checks a manifest: status 0 if it is valid, 2 if it is not, 1 if threads cannot start.
pub fn run(args: &CheckArgs) -> Status {
    Ok(match args.manifest.load() {
        Ok(job) => {
            start_threads_for_tables(&job)?;
            let name = args.manifest.name();
            let text = if args.json {
                pretty(&job_json(&name, &job))
            } else {
                warn(&job.warnings);
                summary(&name, &job)
            };
            answer(&text, ExitCode::SUCCESS)
        }
        Err(errors) if args.json => {
            answer(&pretty(&errors_json(&errors)), ExitCode::from(BAD_INPUT))
        }
        Err(errors) => {
            report(&errors);
            ExitCode::from(BAD_INPUT)
        }
    })
}

fn summary(name: &str, job: &Job) -> String {
    let parts = Prepared::new(TableStore::in_memory());
    let first = job.points.first();
    let lines = (first.as_ref()).map_or(Vec::new(), |first| describe(job, first, &parts));
    let verdict = match first.and_then(|first| fault(&first, &parts)) {
        Some(error) => {
            format!("no error in the keys, but the first point cannot be computed: {error}")
        }
        None => "valid".to_owned(),
    };
    let mut text = format!("{}: {verdict}\n\n", printable(name));
    for (head, line) in lines {
        text += format!("{head:<11} {}", clipped(&line, MOST_CHARACTERS)).trim_end();
        text.push('\n');
    }
    text
}

/// The reason why a point cannot be computed. `None` if there is none, or if the structure is too large to
/// check.
fn fault(point: &PointSpec, parts: &Prepared) -> Option<String> {
    structure::check_size(point).ok()?;
    parts.model(point).err().map(|error| error.to_string())
}

/// Label and text of every line of the summary.
fn describe(job: &Job, first: &PointSpec, parts: &Prepared) -> Vec<(String, String)> {
    let mut lines = vec![
        ("job".to_owned(), format!("{}, seed {}", job.name, job.seed)),
        ("hash".to_owned(), job.hash.clone()),
        ("points".to_owned(), grid::points(job)),
    ];
    if let Some(carried) = &job.carried {
        lines.push(("order".to_owned(), grid::order(job, carried)));
    }
    lines.extend(grid::samples(job).map(|line| ("samples".to_owned(), line)));
    let units = job.written().axis_units();
    for (place, axis) in job.axes.iter().enumerate() {
        let unit = Unit::of_axis(&units, axis.name(), &axis.unit);
        let (low, high) = axis.values.ends();
        let mut text = unit.after(&span(low * unit.factor, high * unit.factor));
        if let Some(law) = grid::distribution(job, place, &unit) {
            text += &format!(", {law}");
        }
        lines.push((format!("  {}", axis.name()), text));
    }
    lines.push((
        "model".to_owned(),
        format!(
            "{}, {} of {} modes kept{}",
            first.model.source.kind(),
            spread(over(job, |v| v.model.retained as f64)),
            spread(over(job, |v| v.model.modes as f64)),
            if first.model.mta { ", the others as residual flexibility" } else { "" }
        ),
    ));
    lines.extend(speeds(first));
    let gear_mesh = GearMesh::of(first, parts);
    if let Some(length) = first.mesh.length {
        let scale = format!("none; lengths are measured by {} m", to_digits(length, 4));
        lines.push(("mesh".to_owned(), scale));
    } else {
        lines.push(("mesh".to_owned(), mesh(job)));
        lines.push(("coast flank".to_owned(), coast(job)));
        lines.extend(gear_mesh.lines());
    }
    let structure = parts.structure(&first.model).ok();
    let causes = excitation::causes(first, &gear_mesh, structure.as_deref());
    let causes: Vec<String> = (causes.into_iter()).map(|cause| cause.text).collect();
    let causes = if causes.is_empty() { "nothing".to_owned() } else { causes.join(", ") };
    lines.push(("excited by".to_owned(), causes));
    lines.push((
        "run".to_owned(),
        format!(
            "{} transient cycles, at most {} measured; {}",
            first.run.transient,
            first.run.cycles,
            kernel::setting(&first.run.kernel)
        ),
    ));
    let kernel = FirstKernel::of(job, first, parts).line();
    lines.extend(kernel.map(|line| ("kernel".to_owned(), line)));
    lines.push(("analyses".to_owned(), analyses(first)));
    lines.extend(LoadedBearings::of(first).map_or(Vec::new(), |bearings| bearings.lines()));
    match Structure::of(job, first, parts) {
        Ok(structure) => lines.extend(structure.lines()),
        Err(reason) => lines.push(("modes".to_owned(), reason)),
    }
    lines.extend(words::lines(&advice(job)));
    lines
}

/// Speeds of the bodies of a train, relative to the speed of the driver; `None` for other structures.
fn speeds(first: &PointSpec) -> Option<(String, String)> {
    let StructureSource::Train(train) = &first.model.source else {
        return None;
    };
    let bodies = train.body_speeds().ok()?;
    let bodies: Vec<String> = (bodies.iter())
        .map(|(name, speed)| format!("{name} {}", to_digits(*speed, 4)))
        .collect();
    let text = format!("{} x the speed of the driver", bodies.join(", "));
    Some(("speeds".to_owned(), text))
}

fn mesh(job: &Job) -> String {
    let mut known = over(job, |v| v.mesh.friction.constant())
        .flatten()
        .peekable();
    let friction = match known.peek() {
        None => "from load, speed, oil and roughness".to_owned(),
        Some(_) => spread(known),
    };
    let damping = |pick: fn(&DampingSpec) -> Option<f64>, unit: &str| {
        let mut values = over(job, |v| pick(&v.mesh.damping)).flatten().peekable();
        values.peek()?;
        Some(spread(values) + unit)
    };
    let ratio = damping(
        |d| match d {
            DampingSpec::Ratio(value) => Some(*value),
            DampingSpec::Coefficient(_) => None,
        },
        " (ratio)",
    );
    let coefficient = damping(
        |d| match d {
            DampingSpec::Coefficient(value) => Some(*value),
            DampingSpec::Ratio(_) => None,
        },
        " N*s/m",
    );
    let dampings: Vec<String> = [ratio, coefficient].into_iter().flatten().collect();
    format!(
        "half gap {} µm; {}; contact damping {}; friction {}",
        spread(over(job, |v| 1e6 * v.mesh.half_gap)),
        stiffness(job),
        dampings.join(", "),
        friction
    )
}

/// The coast flank in words: `mirrored, on a separate line of action …`, or `on the line of action of the drive flank`.
fn coast(job: &Job) -> String {
    let symmetries = || {
        let mirrored = over(job, |variant| match variant.mesh.coast {
            CoastSpec::Mirrored { symmetry } => Some((symmetry, variant.mesh.stiffness.varies())),
            CoastSpec::SameLine => None,
        });
        mirrored.flatten()
    };
    if symmetries().next().is_none() {
        return "on the line of action of the drive flank".to_owned();
    }
    let line = "mirrored, on a separate line of action";
    if !symmetries().any(|(_, varies)| varies) {
        return line.to_owned();
    }
    let symmetry = spread(symmetries().map(|(symmetry, _)| symmetry));
    format!("{line}; a tooth is on the line of centres at mesh phase {symmetry}")
}

/// The mesh stiffness in words: `60 segments, 3.333e8 ... 4.444e8 N/m, mean 4e8`, or the source of a table.
fn stiffness(job: &Job) -> String {
    let mut levels = (f64::INFINITY, f64::NEG_INFINITY);
    let mut counts = (f64::INFINITY, f64::NEG_INFINITY);
    let mut series = false;
    let mut laws: Vec<&StiffnessSpec> = over(job, |v| &v.mesh.stiffness).collect();
    laws.dedup();
    let means = spread(laws.iter().filter_map(|law| law.mean()));
    for law in laws {
        let count = match law {
            StiffnessSpec::Constant(_) => 1,
            StiffnessSpec::Piecewise(values) => values.len(),
            StiffnessSpec::Continuous(levels) => levels.divisions().0.len(),
            StiffnessSpec::Fourier(_, harmonics) => {
                series = true;
                harmonics.len()
            }
            // The kind of the law cannot be an axis of a grid: if one variant has a table, all have one.
            StiffnessSpec::Table(table) => return tabled(job, table),
        };
        let (low, high) = range(law.extremes().into_iter().flatten());
        levels = (levels.0.min(low), levels.1.max(high));
        counts = (counts.0.min(count as f64), counts.1.max(count as f64));
    }
    let counts = span(counts.0, counts.1);
    let what = if series {
        format!("Fourier series of {counts} harmonics")
    } else {
        format!("{counts} segments")
    };
    let mean = if levels.0 == levels.1 { String::new() } else { format!(", mean {means}") };
    format!("{what}, {} N/m{mean}", span(levels.0, levels.1))
}

fn tabled(job: &Job, table: &MeshTableSpec) -> String {
    let division = match table.division {
        CycleDivision::Segments(count) => format!("{count} segments"),
        CycleDivision::Continuous => "continuous".to_owned(),
        CycleDivision::Pairs { slices: 1 } => "one spring per pair of teeth".to_owned(),
        CycleDivision::Pairs { slices } => {
            format!("one spring per pair of teeth and slice of the face, {slices} slices")
        }
    };
    format!(
        "stiffness from the drawing of the gears, {division}; misalignment {} mrad{}",
        spread(over(job, |v| 1e3 * v.mesh.misalignment)),
        if table.shaft_tilt { " plus the tilt of the shafts under load" } else { "" }
    )
}

/// A property of each resolved variant: everything about a point except its load and speed.
fn over<'j, T>(job: &'j Job, of: impl Fn(&'j Variant) -> T) -> impl Iterator<Item = T> {
    job.points.variants().iter().map(of)
}

/// The range of some values, as text.
fn spread(values: impl Iterator<Item = f64>) -> String {
    let (low, high) = range(values);
    span(low, high)
}

fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    })
}

/// `5e-6 … 5e-5`, or one number.
fn span(low: f64, high: f64) -> String {
    let number = |value: f64| {
        // Four digits are enough to recognise a value; the manifest has all digits.
        let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
        if rounded == 0.0 || (1e-3..1e6).contains(&rounded.abs()) {
            format!("{rounded}")
        } else {
            format!("{rounded:e}")
        }
    };
    if low == high {
        number(low)
    } else {
        format!("{} ... {}", number(low), number(high))
    }
}

fn job_json(name: &str, job: &Job) -> Value {
    let axes: Vec<Value> = job
        .axes
        .iter()
        .map(|axis| {
            let values = axis.values.iter().take(MOST_VALUES);
            json!({
                "name": axis.name(),
                "unit": axis.unit,
                "count": axis.values.len(),
                "values": values.collect::<Vec<_>>(),
            })
        })
        .collect();
    let retained = range(over(job, |v| v.model.retained as f64));
    let first = job.points.first();
    let parts = Prepared::new(TableStore::in_memory());
    let gear_mesh = first.as_ref().map(|p| GearMesh::of(p, &parts));
    let kernel = first.as_ref().map(|p| FirstKernel::of(job, p, &parts));
    let mut value = json!({
        "valid": true,
        "file": name,
        "job": job.name,
        "seed": job.seed,
        "hash": job.hash,
        "points": job.points.len(),
        "axes": axes,
        "tied": grid::tied_json(job),
        "carried": grid::carried_json(job),
        "refine": grid::refine_json(job),
        "samples": grid::samples_json(job),
        "model": first.as_ref().map(|p| p.model.source.kind()),
        "coast_flank": first.as_ref().map(|p| match p.mesh.coast {
            CoastSpec::SameLine => json!({ "line": "same_line" }),
            CoastSpec::Mirrored { symmetry } => json!({ "line": "mirrored", "symmetry": symmetry }),
        }),
        "gears": gear_mesh.as_ref().map(GearMesh::json),
        "excited_by": first.as_ref().zip(gear_mesh.as_ref()).map(|(p, mesh)| {
            let structure = parts.structure(&p.model).ok();
            let causes = excitation::causes(p, mesh, structure.as_deref()).into_iter();
            causes.map(|Cause { value, .. }| value).collect::<Vec<_>>()
        }),
        "retained_min": retained.0,
        "retained_max": retained.1,
        "structure": (first.as_ref())
            .and_then(|p| Structure::of(job, p, &parts).ok())
            .map(|structure| structure.json()),
        "first_point_error": first.as_ref().and_then(|p| fault(p, &parts)),
        "warnings": diagnostics_json(&job.warnings.sources, job.warnings.diagnostics.iter()),
        "advice": words::json(&advice(job)),
        "kernel": kernel.as_ref().and_then(|kernel| kernel.taken),
        "kernel_why": kernel.as_ref().and_then(|kernel| kernel.why.as_ref()),
        "analyses": first.as_ref().map(|p| {
            let names = [
                ("lyapunov", p.analyses.lyapunov.is_some()),
                ("poincare", p.analyses.poincare.is_some()),
                ("nvh", p.analyses.nvh.is_some()),
                ("multistability", p.analyses.multistability.is_some()),
                ("orbits", p.analyses.orbits.is_some()),
                ("horizon", p.analyses.horizon.is_some()),
                ("covariant", p.analyses.covariant.is_some()),
            ];
            names.iter().filter(|(_, on)| *on).map(|(name, _)| *name).collect::<Vec<_>>()
        }),
    });
    if let Some(bearings) = first.as_ref().and_then(LoadedBearings::of) {
        value["loaded_bearings"] = bearings.json();
    }
    value
}

fn errors_json(errors: &ManifestErrors) -> Value {
    let sources = &errors.sources;
    let warnings = errors.diagnostics.iter().filter(|d| d.kind.is_warning());
    json!({
        "valid": false,
        "errors_found": errors.count(),
        "errors": diagnostics_json(sources, errors.errors()),
        "warnings": diagnostics_json(sources, warnings),
    })
}

fn diagnostics_json<'d>(
    sources: &[Source],
    diagnostics: impl Iterator<Item = &'d Diagnostic>,
) -> Vec<Value> {
    let each = diagnostics.map(|d| {
        json!({
            "kind": d.kind.code(),
            "file": sources[d.span.source].name,
            "line": d.line,
            "column": d.column,
            "start": d.span.start,
            "end": d.span.end,
            "key": d.key,
            "message": d.message,
            "accepted": d.accepted,
            "nearest": d.suggestion,
            "remedy": d.remedy,
            "at_point": d.at_point,
        })
    });
    each.collect()
}
