//! `atlas table`: the cache of computed tables, filled, looked at and looked after.

mod build;
mod clean;
mod list;
mod show;
mod verify;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Subcommand};

use super::fail;
use crate::store::{CacheError, TableStore};

/// Arguments of `atlas table`.
#[derive(Debug, Args)]
pub struct TableArgs {
    #[command(subcommand)]
    command: TableCommand,
}

#[derive(Debug, Subcommand)]
enum TableCommand {
    /// Compute and keep the mesh table of a manifest's gears
    Build(build::BuildArgs),
    /// List the tables by kind and key
    List(list::ListArgs),
    /// Show what a table was computed from and what it holds
    Show(show::ShowArgs),
    /// Check every byte of tables
    Verify(verify::VerifyArgs),
    /// Remove tables; they are computed again when they are needed
    Clean(clean::CleanArgs),
}

/// Where the tables are.
#[derive(Debug, Args)]
pub(super) struct TablesFolder {
    /// Folder of computed tables, a cache that may be deleted at any time.
    #[arg(long, value_name = "DIR", default_value = "tables")]
    tables: PathBuf,
}

impl TablesFolder {
    /// The store in the folder.
    pub(super) fn store(&self) -> TableStore {
        TableStore::open(&self.tables)
    }
}

/// Exit status where a folder or file cannot be read or written.
const NO_ACCESS: u8 = 1;

/// Carries out a subcommand: status 0 when done, 1 where a file cannot be read or written or a
/// verified table is damaged, 2 for bad input.
pub fn run(args: &TableArgs) -> ExitCode {
    match &args.command {
        TableCommand::Build(args) => build::run(args),
        TableCommand::List(args) => list::run(args),
        TableCommand::Show(args) => show::run(args),
        TableCommand::Verify(args) => verify::run(args),
        TableCommand::Clean(args) => clean::run(args),
    }
}

/// Prints an error of the store and gives the exit status.
fn refuse(error: &CacheError) -> ExitCode {
    let status = match error {
        CacheError::Unknown { .. } | CacheError::Ambiguous { .. } => super::BAD_INPUT,
        _ => NO_ACCESS,
    };
    fail(status, &error.to_string())
}

/// `1 table`, `3 tables`.
fn tables(count: usize) -> String {
    match count {
        1 => "1 table".into(),
        count => format!("{count} tables"),
    }
}
