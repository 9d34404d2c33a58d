//! Arguments, and one thin file per subcommand: the only code that prints or sets an
//! exit status.

pub mod check;

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
}

/// Runs the program with the process's own arguments.
pub fn main() -> ExitCode {
    match Cli::parse().command {
        Command::Check(args) => check::run(&args),
    }
}
