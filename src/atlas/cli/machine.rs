//! `atlas machine`: measures the performance of this machine for computations. `compare` and `show` read its results.

use super::process::{NOTHING_WRITTEN, Process, begin_writing};
use super::size::size;
use super::{
    BAD_INPUT, INTERRUPTED, OrFail, Status, answer, either, fail, line, plot, pretty, reply,
};
use crate::characterize::compare::{Comparison, Pair, compare};
use crate::characterize::{self, Extent, Part, Progress, Settings};
use crate::report::{machine_page, machine_pictures, size_text};
use crate::store::Characteristics;
use clap::{Args, Subcommand};
use indicatif::ProgressBar;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

/// Arguments of `atlas machine`.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub struct MachineArgs {
    #[command(subcommand)]
    command: Option<MachineCommand>,
    #[command(flatten)]
    measure: MeasureArgs,
}

#[derive(Debug, Subcommand)]
enum MachineCommand {
    /// Compare two results figure by figure, within their spreads.
    Compare(CompareArgs),
    /// Print the page of a result and draw its pictures again.
    Show(ShowArgs),
}

/// What is measured and where it goes.
#[derive(Debug, Args)]
struct MeasureArgs {
    /// Measure less, in about a minute.
    #[arg(long, conflicts_with = "full")]
    quick: bool,
    /// Measure larger working sets and more modes, with more repetitions, in up to an hour.
    #[arg(long)]
    full: bool,
    /// Begin no measurement after this many seconds [default: 240; 55 with --quick; 2400 with --full].
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    budget: Option<f64>,
    /// Measure only these parts, separated by commas [default: all].
    #[arg(long, value_enum, value_delimiter = ',', value_name = "PART,...")]
    only: Vec<Part>,
    /// Measure at most this many rounds; with one round, results have no spread [default: 5; 3 with --quick; 9 with --full].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=9))]
    rounds: Option<u32>,
    /// Use at most this much memory, such as 512MiB or 8GiB [default: a quarter of the free memory].
    #[arg(long, value_name = "SIZE", value_parser = memory)]
    memory: Option<u64>,
    /// Write the results to this folder [default: results/machine-HOST].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print nothing but errors.
    #[arg(long, short)]
    quiet: bool,
    /// Print JSON instead of text: the whole record.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Args)]
struct CompareArgs {
    /// Folder of the first result.
    a: PathBuf,
    /// Folder of the second result.
    b: PathBuf,
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Args)]
struct ShowArgs {
    /// Folder that `atlas machine` wrote [default: the folder of this machine].
    folder: Option<PathBuf>,
    /// Print JSON instead of text: the whole record.
    #[arg(long)]
    json: bool,
}

/// Default folder for the results of this machine.
pub fn default_folder() -> PathBuf {
    PathBuf::from("results").join(format!("machine-{}", characterize::host()))
}

/// Measures, compares or shows: status 0, 1 if a measurement fails or a file cannot be written, 2 for bad input, 130
/// after Ctrl-C.
pub fn run(args: &MachineArgs) -> Status {
    match &args.command {
        None => measure(&args.measure),
        Some(MachineCommand::Compare(args)) => compared(args),
        Some(MachineCommand::Show(args)) => show(args),
    }
}

fn measure(args: &MeasureArgs) -> Status {
    let extent = match (args.quick, args.full) {
        (true, _) => Extent::Quick,
        (_, true) => Extent::Full,
        _ => Extent::Default,
    };
    let settings = Settings {
        extent,
        budget: args.budget.map_or(extent.budget(), Duration::from_secs_f64),
        only: args.only.clone(),
        rounds: args.rounds.map(|n| n as usize),
        memory: args.memory,
    };
    let process = Process::prepare(NOTHING_WRITTEN)?;
    let Some(topology) = process.topology else {
        return Err(fail(1, &process.warnings.join("; ")));
    };
    let folder = args.out.clone().unwrap_or_else(default_folder);
    // If the folder cannot be created, report this before the measurement, which takes minutes.
    if let Err(error) = fs::create_dir_all(&folder) {
        let shown = folder.display();
        return Err(fail(
            1,
            &format!("cannot create `{shown}`: {error}; choose another folder with --out"),
        ));
    }
    let bar = bar(args.quiet, settings.budget);
    let characteristics = characterize::characterize(
        &topology,
        &settings,
        &mut |progress| advance(&bar, progress),
        &process.interrupt,
    );
    bar.finish_and_clear();
    let Some(characteristics) = characteristics.or_explain(1)? else {
        return Ok(ExitCode::from(INTERRUPTED));
    };
    begin_writing();
    characteristics.write(&folder).or_explain(1)?;
    let pictures = draw(&characteristics, &folder).or_fail(1)?;
    let text = || page(&characteristics, &folder, pictures);
    let text = reply(args.json, args.quiet, || &characteristics, text);
    Ok(answer(&text, ExitCode::SUCCESS))
}

fn page(characteristics: &Characteristics, folder: &Path, pictures: usize) -> String {
    let folder = folder.display();
    let page = machine_page(characteristics);
    format!(
        "{page}\n{folder}: machine.json, one Parquet file per measurement, {pictures} pictures\n"
    )
}

/// Draws every picture in SVG and PNG; returns their number.
fn draw(characteristics: &Characteristics, folder: &Path) -> Result<usize, String> {
    let pictures = machine_pictures(characteristics);
    plot::write(&pictures, &folder.join("pictures"), plot::Format::Both)?;
    Ok(pictures.len())
}

fn show(args: &ShowArgs) -> Status {
    let folder = args.folder.clone().unwrap_or_else(default_folder);
    let characteristics = Characteristics::read(&folder).or_explain(BAD_INPUT)?;
    if args.json {
        return Ok(answer(&pretty(&characteristics), ExitCode::SUCCESS));
    }
    let pictures = draw(&characteristics, &folder).or_fail(1)?;
    Ok(answer(
        &page(&characteristics, &folder, pictures),
        ExitCode::SUCCESS,
    ))
}

fn compared(args: &CompareArgs) -> Status {
    let a = Characteristics::read(&args.a).or_explain(BAD_INPUT)?;
    let b = Characteristics::read(&args.b).or_explain(BAD_INPUT)?;
    let comparison = compare(&a, &b);
    let text = || comparison_text(&a, &b, &comparison);
    let text = either(args.json, || &comparison, text);
    Ok(answer(&text, ExitCode::SUCCESS))
}

fn comparison_text(a: &Characteristics, b: &Characteristics, comparison: &Comparison) -> String {
    /// Largest number of disagreements shown.
    const MOST_DISAGREEMENTS: usize = 10;
    let run = |name: &str, run: &Characteristics| {
        let noise = if run.noise.quiet { "quiet" } else { "not quiet" };
        let cpu = &run.description.cpu;
        format!(
            "{name}  {}, {}, {} ({noise}), {cpu}\n",
            run.host, run.started, run.extent
        )
    };
    let mut text = run("a", a) + &run("b", b);
    text.push_str("\nmeasurement    figures   b / a   agree within their spread\n");
    for (kind, figures, ratio, agreeing, judged) in comparison.by_kind() {
        text.push_str(&format!(
            "  {kind:<13} {figures:>6}   {ratio:>5.2}   {agreeing} of {judged}\n"
        ));
    }
    let (agreeing, judged) = comparison.agreeing();
    text.push_str(&format!(
        "  {:<13} {:>6}           {agreeing} of {judged}\n",
        "all",
        comparison.pairs.len()
    ));
    let mut disagreeing: Vec<&Pair> = (comparison.pairs.iter())
        .filter(|pair| pair.agrees == Some(false))
        .collect();
    disagreeing.sort_by(|p, q| q.ratio.ln().abs().total_cmp(&p.ratio.ln().abs()));
    if !disagreeing.is_empty() {
        text.push_str("\nlargest differences, b / a (spread)\n");
    }
    for pair in disagreeing.iter().take(MOST_DISAGREEMENTS) {
        let spread = pair.spread.unwrap_or_default();
        text.push_str(&format!(
            "  {:.2} (± {spread:.2})  {}\n",
            pair.ratio, pair.what
        ));
    }
    let only = [("a", comparison.only_a), ("b", comparison.only_b)];
    for (name, count) in only.into_iter().filter(|(_, count)| *count > 0) {
        text.push_str(&format!("{count} figures only in {name}\n"));
    }
    text
}

/// A progress bar on a terminal; it draws nothing elsewhere, or if `quiet`.
fn bar(quiet: bool, budget: Duration) -> ProgressBar {
    let budget = budget.as_secs();
    let template = format!("{{bar:8}} {{elapsed}} of about {budget} s  {{wide_msg}}");
    let bar = line::bar(None, quiet, &template);
    bar.enable_steady_tick(Duration::from_millis(250));
    bar
}

fn advance(bar: &ProgressBar, progress: Progress) {
    bar.set_length(progress.of as u64);
    bar.set_position(progress.done as u64);
    bar.set_message(format!("round {}: {}", progress.round + 1, progress.what));
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 1e6 => Ok(value),
        _ => Err("give a number of seconds greater than 0, at most 1000000".to_owned()),
    }
}

/// Parses the memory for measurements \[bytes\]: at least one MiB.
fn memory(text: &str) -> Result<u64, String> {
    match size(text)? {
        bytes if bytes < 1 << 20 => Err(format!(
            "{} is too little; give at least 1MiB",
            size_text(bytes)
        )),
        bytes => Ok(bytes),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_and_time_have_a_least() {
        assert_eq!(memory("1048576"), Ok(1 << 20));
        assert!(memory("12").is_err() && memory("512KiB").is_err());
        assert!(positive("0").is_err() && positive("2.5") == Ok(2.5));
    }
}
