//! `atlas plot`: SVG and PNG pictures of a results or trace folder, or of a mesh table.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::str::FromStr;
use std::sync::LazyLock;

use clap::builder::{PossibleValue, TypedValueParser};
use clap::{Arg, Args, ValueEnum};
use serde_json::json;

use super::{
    BAD_INPUT, OrFail, Status, answer, campbell, fail, manifest_args, point, reply,
    start_threads_for_tables, with_causes,
};
use crate::manifest::Measured;
use crate::report::{
    Amount, Display, Drawn, Log, NoAmount, Picture, PictureKind, PictureRequest, PlotRequest,
    Resonance, Unit, drawable, plot,
};
use crate::store::{ResultLayout, TableStore, points_table, write_atomically};
use crate::sweep::Prepared;
use crate::units::conversion;

/// Arguments of `atlas plot`.
#[derive(Debug, Args)]
#[command(after_help = KINDS)]
pub struct PlotArgs {
    /// Folder that `atlas run`, `atlas follow`, `atlas trace` or `atlas runup` wrote, or the file of a mesh table. Several
    /// folders draw the same columns into one picture.
    #[arg(required = true, value_name = "SOURCE")]
    pub sources: Vec<PathBuf>,
    /// Draw these kinds of pictures and columns of the results, separated by commas; see below
    /// [default: all kinds possible with the data].
    #[arg(long, value_parser = Names, value_name = "KIND|COLUMN,...", hide_possible_values = true)]
    pub what: Vec<Vec<PictureRequest>>,
    /// Draw curves over this axis instead of maps [default: the axis of a sweep,
    /// else the axis with most values].
    #[arg(long, value_name = "AXIS")]
    pub over: Option<String>,
    /// Draw one curve per value of this axis.
    #[arg(long, value_name = "AXIS")]
    pub by: Option<String>,
    /// Lay measured points over the curves: a file with the columns axis, value and, if known, standard error, such as
    /// `speed [rpm],deflection_rms [um],stderr [um]`. They choose the axis and the column if --over and --what do not.
    #[arg(long, value_name = "FILE")]
    pub measured: Option<PathBuf>,
    /// Draw this point: its point_id, or values of axes such as load=0.05,speed="9000 rpm" [default: the loudest or most
    /// chaotic point; all points for basins, multipliers and kicks].
    #[arg(long, value_name = "ID|AXIS=VALUE,...")]
    pub point: Option<String>,
    /// Draw these mesh orders in `orders` [default: 1,2,3].
    #[arg(long, value_parser = order, value_delimiter = ',', value_name = "ORDER,...")]
    pub orders: Vec<f64>,
    /// Draw this signal in `orders` and `waterfall`: deflection, force, "mesh force ...", "bearing ..." [default: deflection].
    #[arg(long, value_name = "NAME")]
    pub signal: Option<String>,
    /// Draw the waterfall over frequency instead of order.
    #[arg(long)]
    pub frequency: bool,
    /// Use these units in the pictures, such as rpm,um [default: the units of the manifest].
    #[arg(long, value_parser = unit, value_delimiter = ',', value_name = "UNIT,...")]
    pub unit: Vec<String>,
    /// Show decibels relative to this amplitude, in SI or with its unit: 1e-6, "1 N".
    #[arg(long, value_name = "REFERENCE")]
    pub db: Option<Amount>,
    /// Make axes logarithmic: x, y or xy.
    #[arg(long, value_enum, value_name = "AXES", hide_possible_values = true)]
    pub log: Option<Log>,
    /// Show only this range of values: 0:2e-5, "0:20 um"; in decibels with --db.
    #[arg(long, value_parser = range, value_name = "LOW:HIGH", allow_hyphen_values = true)]
    pub range: Option<[Amount; 2]>,
    /// Write the pictures to this folder [default: `pictures` in the first folder, or beside the file].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Write files of this format: svg, png or both.
    #[arg(long, value_enum, default_value_t = Format::Both, hide_possible_values = true)]
    pub format: Format,
    /// List the kinds and columns of the source, and draw nothing.
    #[arg(long)]
    pub list: bool,
    /// Print nothing but errors.
    #[arg(long, short)]
    pub quiet: bool,
    /// Print JSON instead of text.
    #[arg(long)]
    pub json: bool,
}

/// Additional `--help` text of `--what`.
const KINDS: &str = "\
Kinds:
  of a run       lambda, classes, bifurcation, spectrum, phase, waterfall, orders, horizon, convergence,
                 shares, basins
  of orbits      branches, curves, multipliers, kicks
  of a manifest  campbell, also from the record of a run
  of a trace     trace, phase
  of a run-up    spectrogram, tracks
  of a mesh      mesh, sharing, contact
Columns: any of points.parquet (deflection_rms), elements of lists (harmonics[3],
  bearing_rms[pinion 1 x], bearing_rms[axial]), columns of
  attractors and periodic orbits (attractors.force_peak, orbits.multipliers). Over two axes, a column is drawn as a map.
  `atlas plot SOURCE --list` shows them all, with units.
Examples:
  atlas plot results/job --what deflection_rms,deflection_pp --over speed --by load
  atlas plot results/job --measured points.csv --unit rpm
  atlas plot results/relief1 results/relief2 --what force_peak --db \"1 N\" --unit rpm";

/// Names of the number columns that every points.parquet has.
static COLUMNS: LazyLock<Vec<String>> = LazyLock::new(|| {
    let table = points_table(&ResultLayout::default());
    let columns = table.iter().flat_map(|table| table.columns());
    let numbers = columns.filter(|column| !column.unit.is_empty());
    numbers.map(|column| column.name.clone()).collect()
});

/// Parser of `--what`. Its possible values, kinds and common columns, serve only the completion in shells.
/// Names of columns are checked later, against the results.
#[derive(Debug, Clone)]
struct Names;

impl TypedValueParser for Names {
    type Value = Vec<PictureRequest>;

    fn parse_ref(
        &self,
        command: &clap::Command,
        argument: Option<&Arg>,
        value: &OsStr,
    ) -> Result<Vec<PictureRequest>, clap::Error> {
        let text = String::from_utf8_lossy(value.as_encoded_bytes());
        let names = separated(&text).into_iter().map(OsStr::new);
        names
            .map(|name| PictureRequest::from_str.parse_ref(command, argument, name))
            .collect()
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let kinds = PictureKind::value_variants()
            .iter()
            .filter_map(PictureKind::to_possible_value);
        let columns = COLUMNS.iter().map(|name| PossibleValue::new(&**name));
        Some(Box::new(kinds.chain(columns)))
    }
}

/// The names of a list, separated by commas. Commas in brackets belong to a name, such as
/// `contact_force[stage 1 of engine and input, forward]`.
fn separated(text: &str) -> Vec<&str> {
    let mut depth = 0_i32;
    text.split(|letter| {
        depth += i32::from(letter == '[') - i32::from(letter == ']');
        letter == ',' && depth <= 0
    })
    .collect()
}

/// Parses a unit; refuses unknown ones.
fn unit(text: &str) -> Result<String, String> {
    match conversion(text, text) {
        Some(_) => Ok(text.to_owned()),
        None => Err("not a known unit; give for example rpm, um, kN or deg".to_owned()),
    }
}

/// Parses a mesh order: a positive number, or a fraction such as 1/3.
fn order(text: &str) -> Result<f64, String> {
    let number = match text.split_once('/') {
        None => text.parse::<f64>().ok(),
        Some((part, whole)) => {
            let parts = part.parse::<f64>().ok().zip(whole.parse::<f64>().ok());
            parts.map(|(part, whole)| part / whole)
        }
    };
    (number.filter(|order| order.is_finite() && *order > 0.0))
        .ok_or_else(|| "give a positive number such as 2, 0.5 or 1/3".to_owned())
}

/// Parses two amounts, separated by a colon. The unit of the second also applies to the first if that has
/// none.
fn range(text: &str) -> Result<[Amount; 2], String> {
    let refused =
        || "give two numbers separated by a colon, such as 0:2e-5 or \"0:20 um\"".to_owned();
    let (low, high) = text.split_once(':').ok_or_else(refused)?;
    let high: Amount = high.parse().map_err(|error: NoAmount| error.to_string())?;
    let low: Amount = low.parse().map_err(|error: NoAmount| error.to_string())?;
    low.up_to(high)
        .ok_or_else(|| "the lower end must be below the upper end".to_owned())
}

/// File formats of pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Scalable, for documents.
    Svg,
    /// 1920 pixels wide.
    Png,
    /// Both.
    Both,
}

/// Writes the pictures: status 0 if done, 2 for bad input, 1 if a file cannot be written.
pub fn run(args: &PlotArgs) -> Status {
    if args.list {
        return list(args);
    }
    let Some(source) = args.sources.first() else {
        return Err(fail(BAD_INPUT, "give a folder with results"));
    };
    let point = args.point.as_deref().map(|text| point_id(source, text));
    let point = match point.transpose() {
        Ok(point) => point,
        Err(Some(message)) => return Err(fail(BAD_INPUT, &message)),
        Err(None) => return Ok(ExitCode::from(BAD_INPUT)),
    };
    let measured = args.measured.as_deref().map(Measured::read).transpose();
    let measured = match measured {
        Ok(measured) => measured,
        Err(errors) => {
            manifest_args::report(&errors);
            return Ok(ExitCode::from(BAD_INPUT));
        }
    };
    let mut request = PlotRequest {
        what: args.what.concat(),
        over: args.over.clone(),
        by: args.by.clone(),
        point,
        orders: args.orders.clone(),
        signal: args.signal.clone(),
        frequency: args.frequency,
        measured,
        display: Display {
            units: args.unit.clone(),
            decibels: args.db.clone(),
            log: args.log,
            range: args.range.clone(),
        },
    };
    let (mut drawn, mut resonances) = (Drawn::default(), Vec::new());
    let mut speed = None;
    if request.what.contains(&CAMPBELL) {
        request.what.retain(|asked| *asked != CAMPBELL);
        let remedy = "give the manifest instead: atlas plot m.toml --what campbell";
        let job = campbell::job(source, remedy);
        job.as_ref().map_or(Ok(()), start_threads_for_tables)?;
        let parts = Prepared::new(TableStore::in_memory());
        let diagram = job.and_then(|job| campbell::of(&job, &args.orders, &parts).map_err(Some));
        let diagram = match diagram {
            Ok(diagram) => diagram,
            Err(Some(message)) => return Err(fail(BAD_INPUT, &message)),
            Err(None) => return Ok(ExitCode::from(BAD_INPUT)),
        };
        resonances = diagram.resonances();
        speed.clone_from(&diagram.unit);
        drawn = diagram.draw(&request.display);
    }
    let more = !request.what.is_empty() || request.measured.is_some();
    if drawn.pictures.is_empty() || more {
        drawn.append(plot(&args.sources, &request).or_explain(BAD_INPUT)?);
    }
    if drawn.pictures.is_empty() {
        let message = format!(
            "nothing to draw in `{}`: {}",
            source.display(),
            drawn.notes.join("; ")
        );
        return Err(fail(BAD_INPUT, &message));
    }
    let default = || match source.parent() {
        Some(parent) if source.is_file() => parent.join("pictures"),
        _ => source.join("pictures"),
    };
    let folder = args.out.clone().unwrap_or_else(default);
    let files = write(&drawn.pictures, &folder, args.format).or_fail(1)?;
    let json = || json!({ "files": files, "notes": drawn.notes, "resonances": resonances });
    let text = || {
        let files = files.iter().map(|file| format!("{}\n", file.display()));
        let notes = (drawn.notes.iter()).map(|note| format!("left out  {note}\n"));
        let table = table(&resonances, &Unit::or_si(speed.as_deref(), "rad/s"));
        files.chain(notes).chain([table]).collect()
    };
    let text = reply(args.json, args.quiet, json, text);
    Ok(answer(&text, ExitCode::SUCCESS))
}

/// The `point_id` from `--point`: the number itself, or that of the point with the given values. The error is a
/// message, or `None` if it was already shown.
fn point_id(source: &Path, text: &str) -> Result<u64, Option<String>> {
    match text.trim().parse() {
        Ok(id) => Ok(id),
        Err(_) => {
            let job = campbell::job(source, "give the point_id of the table points instead")?;
            point::id(&job, text).map_err(Some)
        }
    }
}

/// The request for a Campbell diagram, which this command computes from the manifest.
const CAMPBELL: PictureRequest = PictureRequest::Kind(PictureKind::Campbell);

/// Resonances, one per line; empty if there are none.
fn table(resonances: &[Resonance], unit: &Unit) -> String {
    let mut text = String::new();
    if !resonances.is_empty() {
        text += &format!(
            "{:>10} {:>10} {:<14} {:<8} {:>4} {:>10}\n",
            unit.text, "Hz", "excitation", "contacts", "mode", "in mesh"
        );
    }
    for resonance in resonances {
        text += &format!(
            "{:>10.1} {:>10.1} {:<14} {:<8} {:>4} {:>8.1} %\n",
            resonance.speed * unit.factor,
            resonance.frequency,
            resonance.excitation,
            resonance.contacts.name(),
            resonance.mode,
            100.0 * resonance.mesh_share
        );
    }
    text
}

/// Prints the possible pictures of the sources: status 0, or 2 if one cannot be read.
fn list(args: &PlotArgs) -> Status {
    let mut text = String::new();
    let mut all = Vec::new();
    for source in &args.sources {
        let choices = drawable(source).or_explain(BAD_INPUT)?;
        let kinds: Vec<&str> = choices.kinds.iter().map(|kind| kind.name()).collect();
        text += &format!("{}\n", source.display());
        text += &format!("kinds    {}\n", kinds.join(", "));
        for column in &choices.columns {
            text += &format!(
                "{:<28} {:<12} {}\n",
                column.name, column.unit, column.description
            );
            if !column.elements.is_empty() {
                text += &format!("{:<41} elements: {}\n", "", column.elements.join(", "));
            }
        }
        let columns: Vec<_> = (choices.columns.iter())
            .map(|column| {
                json!({
                    "name": column.name,
                    "unit": column.unit,
                    "description": column.description,
                    "elements": column.elements,
                })
            })
            .collect();
        all.push(json!({ "source": source, "kinds": kinds, "columns": columns }));
    }
    if args.json {
        text = format!("{:#}\n", json!(all));
    }
    Ok(answer(&text, ExitCode::SUCCESS))
}

/// Writes every picture in the formats of `format`; returns the files.
pub(super) fn write(
    pictures: &[Picture],
    folder: &Path,
    format: Format,
) -> Result<Vec<PathBuf>, String> {
    fs::create_dir_all(folder).map_err(|error| {
        let shown = folder.display();
        format!("cannot write `{shown}`: {error}; choose another folder with --out")
    })?;
    let mut files = Vec::new();
    for picture in pictures {
        let mut contents = Vec::new();
        if format != Format::Png {
            let text = picture.svg().map_err(|error| error.to_string())?;
            contents.push(("svg", text.into_bytes()));
        }
        if format != Format::Svg {
            contents.push(("png", picture.png().map_err(|error| error.to_string())?));
        }
        for (extension, bytes) in contents {
            let path = folder.join(format!("{}.{extension}", picture.name));
            write_atomically(&path, &bytes).map_err(|error| with_causes(&error))?;
            files.push(path);
        }
    }
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::separated;

    #[test]
    fn commas_in_brackets_separate_no_names() {
        for (text, names) in [
            ("lambda,force_peak", &["lambda", "force_peak"][..]),
            ("a[one, two],b[3]", &["a[one, two]", "b[3]"]),
            ("a[one, two", &["a[one, two"]),
            ("a],b", &["a]", "b"]),
        ] {
            assert_eq!(separated(text), names);
        }
    }
}
