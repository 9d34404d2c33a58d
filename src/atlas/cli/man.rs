//! `atlas man`: manual pages, one for the program and one per subcommand.

use super::{Cli, answer, fail, with_causes};
use crate::store::write_atomically;
use clap::{Args, Command, CommandFactory};
use clap_mangen::Man;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `atlas man`.
#[derive(Debug, Args)]
pub struct ManArgs {
    /// Folder for the pages, created if needed; `man` looks for a user's pages in ~/.local/share/man/man1
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
}

/// Writes the pages: status 0, or 1 if one cannot be written.
pub fn run(args: &ManArgs) -> ExitCode {
    let mut command = Cli::command();
    // Sets the full name of every subcommand.
    command.build();
    match write(&command, &args.folder) {
        Ok(pages) => answer(&pages, ExitCode::SUCCESS),
        Err(message) => fail(1, &message),
    }
}

/// Writes the pages of a command and of all its subcommands; returns a message with their names.
fn write(command: &Command, folder: &Path) -> Result<String, String> {
    let refused = |error: &std::io::Error| format!("cannot write `{}`: {error}", folder.display());
    fs::create_dir_all(folder).map_err(|error| refused(&error))?;
    let page = Man::new(command.clone());
    let path = folder.join(page.get_filename());
    let mut text = Vec::new();
    page.render(&mut text).map_err(|error| refused(&error))?;
    write_atomically(&path, &text).map_err(|error| with_causes(&error))?;
    let mut pages = format!("{}\n", path.display());
    for below in command.get_subcommands() {
        pages += &write(below, folder)?;
    }
    Ok(pages)
}
