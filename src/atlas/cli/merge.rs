//! `atlas merge DIR… --out DIR`: joins the shards of a job into one set of results.

use super::{BAD_INPUT, Status, answer, fail, reply, warn, with_causes};
use crate::store::{MergeError, merge, mixed_instructions_warning};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `atlas merge`.
#[derive(Debug, Args)]
pub struct MergeArgs {
    /// Folders with the shards of one job, or a folder of such folders. They are not changed.
    #[arg(required = true, value_name = "DIR")]
    pub folders: Vec<PathBuf>,
    /// Write the joined results to this folder, which must be new or empty.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Print nothing but errors.
    #[arg(long, short)]
    pub quiet: bool,
    /// Print JSON instead of text: the record of the joined run (run.json).
    #[arg(long)]
    pub json: bool,
}

/// Joins shards: status 0 if done, 2 if they do not form one complete job, 1 if a file cannot be read or
/// written.
pub fn run(args: &MergeArgs) -> Status {
    let record = match merge(&args.folders, &args.out) {
        Ok(record) => record,
        Err(error) => {
            let status = match &error {
                MergeError::Store(error) if !error.is_refusal() => 1,
                _ => BAD_INPUT,
            };
            return Err(fail(status, &with_causes(&error)));
        }
    };
    if let Some(warning) = mixed_instructions_warning(&record.machine.instructions) {
        warn(&warning);
    }
    let (shards, points) = (record.shards.len(), record.totals.points);
    let out = args.out.display();
    let text = || {
        format!(
            "{points} points of {shards} shards joined\nresults in {out}; `atlas show {out}` summarises them\n"
        )
    };
    let text = reply(args.json, args.quiet, || &record, text);
    Ok(answer(&text, ExitCode::SUCCESS))
}
