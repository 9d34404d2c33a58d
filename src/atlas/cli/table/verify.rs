//! `atlas table verify`: every byte of tables, checked.

use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

use super::{TablesFolder, refuse, tables};
use crate::cli::answer;
use crate::store::{CacheError, MappedTable};

/// Exit status where a table is damaged.
const DAMAGED: u8 = 1;

/// Arguments of `atlas table verify`.
#[derive(Debug, Args)]
pub struct VerifyArgs {
    /// First digits of keys, or files.
    #[arg(value_name = "KEY|FILE", required_unless_present = "all")]
    wanted: Vec<String>,
    /// Every table of the folder.
    #[arg(long, conflicts_with = "wanted")]
    all: bool,
    #[command(flatten)]
    folder: TablesFolder,
}

/// Prints a line a table; exit status 1 where one is damaged.
pub fn run(args: &VerifyArgs) -> ExitCode {
    let files = match files(args) {
        Ok(files) => files,
        Err(error) => return refuse(&error),
    };
    let mut text = String::new();
    let mut damaged = 0;
    for file in &files {
        _ = match MappedTable::open(file) {
            Ok(_) => writeln!(text, "`{}` is whole", file.display()),
            Err(fault) => {
                damaged += 1;
                writeln!(text, "`{}` {fault}", file.display())
            }
        };
    }
    let count = tables(files.len());
    let (verdict, status) = match damaged {
        0 => ("all whole".to_owned(), ExitCode::SUCCESS),
        n => (
            format!("{n} not usable; `atlas table clean` removes them"),
            DAMAGED.into(),
        ),
    };
    answer(&format!("{text}{count}, {verdict}\n"), status)
}

fn files(args: &VerifyArgs) -> Result<Vec<PathBuf>, CacheError> {
    let store = args.folder.store();
    match args.all {
        true => {
            let entries = store.entries()?.into_iter();
            Ok(entries.map(|entry| entry.path).collect())
        }
        false => args.wanted.iter().map(|name| store.find(name)).collect(),
    }
}
