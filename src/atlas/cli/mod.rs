//! The command line: arguments, and one file per subcommand, which calls the other modules. Only this code
//! prints and sets exit statuses.

mod activity;
mod analyses;
mod campbell;
pub mod check;
mod console;
mod events;
mod excitation;
pub mod export;
mod fmu;
pub mod follow;
mod gear_mesh;
mod grid;
pub mod help;
mod kernel;
mod line;
mod loaded_bearings;
pub mod machine;
pub mod man;
mod manifest_args;
pub mod merge;
mod new;
pub mod plan;
pub mod plot;
mod point;
mod portable;
mod process;
mod progress;
mod recording;
pub mod report;
mod resonances;
mod retry;
pub mod run;
mod run_args;
pub mod runup;
pub mod sensitivity;
pub mod show;
mod size;
pub mod sound;
mod status;
mod structure;
pub mod table;
mod threads;
pub mod trace;
pub mod verify;
mod words;

use crate::input::{printable, printable_but_colours, with_causes};
use crate::manifest::{Job, StiffnessSpec, StructureSource, Variant};
use crate::shaft::MeshLaw;
use crate::sweep::silence_reported_panics;
use clap::{CommandFactory, Parser, Subcommand};
use serde::Serialize;
use std::borrow::Cow;
use std::error::Error;
use std::ffi::OsString;
use std::fmt::Display;
use std::io::{ErrorKind, Write};
use std::path::Path;
use std::process::ExitCode;

/// Exit status for bad input.
const BAD_INPUT: u8 = 2;

/// Exit status of a job with failed points.
const FAILED_POINTS: u8 = 3;

/// Exit status if another process works on the same results: try again later.
const BUSY: u8 = 4;

/// Exit status after Ctrl-C or SIGTERM.
const INTERRUPTED: u8 = 130;

/// Compute gear rattle over grids of operating points: exact propagation, Lyapunov exponents with
/// error bars, Poincaré samples and NVH statistics, in Parquet files.
#[derive(Debug, Parser)]
#[command(
    name = "atlas",
    version,
    arg_required_else_help = true,
    disable_help_subcommand = true
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Write a commented manifest to start from
    New(new::NewArgs),
    /// Compute the points of a manifest, or continue an interrupted run, and write the result files
    Run(run_args::RunArgs),
    /// Show all errors of a manifest, or a summary of the job
    Check(check::CheckArgs),
    /// Follow periodic orbits along an axis of the grid, through their bifurcations
    Follow(follow::FollowArgs),
    /// Join the shards of a job into one set of results
    Merge(merge::MergeArgs),
    /// Estimate time, memory and disk of a run from a few of its points
    Plan(plan::PlanArgs),
    /// Summarise a results folder, or a file of computed tables
    Show(show::ShowArgs),
    /// Draw SVG and PNG pictures of a results or trace folder, or of a mesh table
    Plot(plot::PlotArgs),
    /// Write one HTML file to explore a results or trace folder in a browser, offline
    Report(report::ReportArgs),
    /// Write the tables of a results or trace folder as CSV or Arrow files for other programs
    Export(export::ExportArgs),
    /// Compute derivatives of the results of a point with respect to keys of the manifest
    Sensitivity(sensitivity::SensitivityArgs),
    /// Record the trajectory of one point with its events
    Trace(trace::TraceArgs),
    /// Run one drive up or down in speed, and write order tracks, levels and spectra
    Runup(runup::RunupArgs),
    /// Write a signal of a run-up as a WAV file
    Sound(sound::SoundArgs),
    /// Write a drive as a functional mock-up unit (FMU) that other simulators step
    Fmu(fmu::FmuArgs),
    /// Measure memory, arithmetic and kernels of this machine
    Machine(machine::MachineArgs),
    /// Compute and keep the mesh table of a manifest's gears; `atlas plot` draws it
    Table(table::TableArgs),
    /// Compare this build on this machine with closed forms, published values and independent
    /// integrators
    Verify(verify::VerifyArgs),
    /// Explain a subcommand, or a table or key of a manifest
    Help(help::HelpArgs),
    /// Print a completion script for a shell
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Write manual pages: atlas.1 and one for every subcommand
    Man(man::ManArgs),
}

/// Runs the program with the arguments of the process.
pub fn main() -> ExitCode {
    silence_reported_panics();
    match process::end_when_interrupted() {
        Ok(()) => process::run_interruptibly(carry_out),
        Err(error) => fail(1, &format!("cannot watch for signals: {error}")),
    }
}

/// Executes the command from the arguments of the process.
fn carry_out() -> ExitCode {
    let arguments = match Cli::try_parse() {
        Ok(arguments) => arguments,
        Err(refusal) => return refused(&refusal),
    };
    execute(arguments.command).unwrap_or_else(|status| status)
}

/// Executes a command.
fn execute(command: Command) -> Status {
    Ok(match command {
        Command::New(args) => new::run(&args)?,
        Command::Run(args) => run::run(&args)?,
        Command::Check(args) => check::run(&args)?,
        Command::Follow(args) => follow::run(&args)?,
        Command::Merge(args) => merge::run(&args)?,
        Command::Plan(args) => plan::run(&args)?,
        Command::Show(args) => show::run(&args),
        Command::Plot(args) => plot::run(&args)?,
        Command::Report(args) => report::run(&args)?,
        Command::Export(args) => export::run(&args)?,
        Command::Sensitivity(args) => sensitivity::run(&args)?,
        Command::Trace(args) => trace::run(&args)?,
        Command::Runup(args) => runup::run(&args)?,
        Command::Sound(args) => sound::run(&args),
        Command::Fmu(args) => fmu::run(&args)?,
        Command::Machine(args) => machine::run(&args)?,
        Command::Table(args) => table::run(&args)?,
        Command::Verify(args) => verify::run(&args)?,
        Command::Help(args) => help::run(&args),
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Cli::command(), "atlas", &mut script);
            answer(&String::from_utf8_lossy(&script), ExitCode::SUCCESS)
        }
        Command::Man(args) => man::run(&args),
    })
}

/// Parses arguments, with the program's name first, without executing them.
///
/// # Errors
/// The error in them, or a requested text such as the help.
pub fn understood(arguments: impl IntoIterator<Item = OsString>) -> Result<(), clap::Error> {
    Cli::try_parse_from(arguments).map(drop)
}

/// Prints errors in the arguments, or the requested help. Arguments may be names of foreign files (`atlas show *`),
/// whose control characters must not reach a terminal.
fn refused(refusal: &clap::Error) -> ExitCode {
    let text = refusal.render().to_string();
    match (printable(&text), refusal.exit_code()) {
        (Cow::Owned(shown), _) => {
            _ = std::io::stderr().lock().write_all(shown.as_bytes());
            ExitCode::from(BAD_INPUT)
        }
        (Cow::Borrowed(_), status) => {
            // Prints in colour if the terminal supports it.
            _ = refusal.print();
            ExitCode::from(u8::try_from(status).unwrap_or(BAD_INPUT))
        }
    }
}

/// Starts the threads that computations outside a sweep share. Otherwise rayon starts them on first use, and panics if
/// the system refuses. `count` is `None` for one thread per core.
fn start_threads(count: Option<usize>) -> Result<(), ExitCode> {
    let pool = (rayon::ThreadPoolBuilder::new()).num_threads(count.unwrap_or(0));
    pool.build_global().map_err(|error| {
        let message = format!(
            "cannot start worker threads: {error}; raise the limit on threads (`ulimit -u`, or \
             pids.max of the control group)"
        );
        fail(1, &message)
    })
}

/// Calls [`start_threads`] if points of a job have mesh tables, because their computation uses these threads.
fn start_threads_for_tables(job: &Job) -> Result<(), ExitCode> {
    let tabled = |variant: &Variant| {
        let further = match &variant.model.source {
            StructureSource::Train(train) => &train.meshes[..],
            _ => &[],
        };
        matches!(variant.mesh.stiffness, StiffnessSpec::Table(_))
            || further
                .iter()
                .any(|mesh| matches!(mesh.law, MeshLaw::Drawn(_)))
    };
    if job.points.variants().iter().any(tabled) {
        start_threads(None)
    } else {
        Ok(())
    }
}

/// Lines of a summary: each label, padded to a width, and its text.
fn labelled(width: usize, lines: &[(&str, String)]) -> String {
    lines
        .iter()
        .map(|(label, text)| format!("{label:<width$}{text}\n"))
        .collect()
}

/// Prints to standard output and returns the exit status. A closed pipe (`atlas … | head`) is no error, because its
/// reader no longer needs output.
fn answer(text: &str, status: ExitCode) -> ExitCode {
    let mut stdout = std::io::stdout().lock();
    match stdout
        .write_all(printable_but_colours(text).as_bytes())
        .and_then(|()| stdout.flush())
    {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            fail(1, &format!("cannot write to standard output: {error}"))
        }
        _ => status,
    }
}

/// A JSON document if it is requested, otherwise the text.
fn either<D: Serialize>(
    json: bool,
    document: impl FnOnce() -> D,
    text: impl FnOnce() -> String,
) -> String {
    if json { pretty(&document()) } else { text() }
}

/// As [`either`], but if `quiet`, an empty string replaces the text (not the JSON document).
fn reply<D: Serialize>(
    json: bool,
    quiet: bool,
    document: impl FnOnce() -> D,
    text: impl FnOnce() -> String,
) -> String {
    either(
        json,
        document,
        || if quiet { String::new() } else { text() },
    )
}

/// A value as indented JSON. The values of this program can always be serialized.
fn pretty(document: &impl Serialize) -> String {
    serde_json::to_string_pretty(document).unwrap_or_default() + "\n"
}

/// Refuses to replace an existing file unless `overwrite`. The message proposes `remedy` or --overwrite.
fn refuse_existing(path: &Path, overwrite: bool, remedy: &str) -> Result<(), ExitCode> {
    if overwrite || path.symlink_metadata().is_err() {
        return Ok(());
    }
    let path = path.display();
    let message = format!("`{path}` already exists: {remedy}, or replace it with --overwrite");
    Err(fail(BAD_INPUT, &message))
}

/// A temporary folder, which is removed when the value is dropped.
fn scratch_folder() -> Result<tempfile::TempDir, ExitCode> {
    let created = tempfile::tempdir();
    created.map_err(|error| fail(1, &format!("cannot create a temporary folder: {error}")))
}

/// Whether the user refuses colours: NO_COLOR has a value (no-color.org).
fn refuses_colours() -> bool {
    std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty())
}

/// Prints one error line and returns the exit status.
fn fail(status: u8, message: &str) -> ExitCode {
    // Ignore a closed standard error.
    _ = writeln!(std::io::stderr().lock(), "error: {}", printable(message));
    ExitCode::from(status)
}

/// Exit status of a command. If the command ended early, its error has been printed.
type Status = Result<ExitCode, ExitCode>;

/// Converts an error to an exit status and prints it as one error line.
trait OrFail<T, E> {
    /// The value; on an error, prints its message and returns `status`.
    fn or_fail(self, status: u8) -> Result<T, ExitCode>
    where
        E: Display;

    /// The value; on an error, prints its message with all causes and returns `status`.
    fn or_explain(self, status: u8) -> Result<T, ExitCode>
    where
        E: Error;
}

impl<T, E> OrFail<T, E> for Result<T, E> {
    fn or_fail(self, status: u8) -> Result<T, ExitCode>
    where
        E: Display,
    {
        self.map_err(|error| fail(status, &error.to_string()))
    }

    fn or_explain(self, status: u8) -> Result<T, ExitCode>
    where
        E: Error,
    {
        self.map_err(|error| fail(status, &with_causes(&error)))
    }
}

/// Prints one warning line.
fn warn(sentence: &str) {
    _ = writeln!(std::io::stderr().lock(), "warning: {}", printable(sentence));
}
