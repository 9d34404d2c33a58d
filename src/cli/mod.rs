//! Arguments, and one thin file per subcommand: the only code that prints or sets an
//! exit status.

pub mod show;

use std::process::ExitCode;

/// Runs the program with the process's own arguments.
pub fn main() -> ExitCode {
    ExitCode::SUCCESS
}
