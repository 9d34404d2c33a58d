//! `atlas table show`: what a table was computed from and what it holds.

use std::process::ExitCode;

use clap::Args;

use super::{TablesFolder, refuse};
use crate::cli::{BAD_INPUT, answer, fail, with_causes};
use crate::report::TableSummary;

/// Arguments of `atlas table show`.
#[derive(Debug, Args)]
pub struct ShowArgs {
    /// First digits of its key, or its file.
    #[arg(value_name = "KEY|FILE")]
    table: String,
    #[command(flatten)]
    folder: TablesFolder,
    /// Print JSON for programs.
    #[arg(long)]
    json: bool,
}

/// Prints the summary; exit status 2 where there is no such table or it is damaged.
pub fn run(args: &ShowArgs) -> ExitCode {
    let file = match args.folder.store().find(&args.table) {
        Ok(file) => file,
        Err(error) => return refuse(&error),
    };
    let summary = match TableSummary::read(&file) {
        Ok(summary) => summary,
        Err(fault) => return fail(BAD_INPUT, &format!("`{}` {fault}", file.display())),
    };
    if !args.json {
        return answer(&summary.render(), ExitCode::SUCCESS);
    }
    match serde_json::to_string_pretty(&summary) {
        Ok(text) => answer(&(text + "\n"), ExitCode::SUCCESS),
        Err(error) => fail(1, &with_causes(&error)),
    }
}
