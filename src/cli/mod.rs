//! Arguments, and one thin file per subcommand: the only code that prints or sets an
//! exit status.

pub mod check;
pub mod show;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Gear rattle over grids of operating points.
#[derive(Debug, Parser)]
#[command(name = "atlas", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Show all errors of a manifest, or what it expands to
    Check(check::CheckArgs),
    /// Summarise a results folder
    Show(show::ShowArgs),
}

/// Runs the program with the process's own arguments.
pub fn main() -> ExitCode {
    match Cli::parse().command {
        Command::Check(args) => check::run(&args),
        Command::Show(args) => show::run(&args),
    }
}
