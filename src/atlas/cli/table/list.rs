//! `atlas table list`: every table of the folder, with its header but not its data checked.

use std::fmt::Write;
use std::process::ExitCode;

use clap::Args;
use serde_json::{Value, json};

use super::{TablesFolder, refuse, tables};
use crate::cli::answer;
use crate::report::size_text;
use crate::store::{CacheEntry, timestamp};

/// Digits of a key that are shown.
const DIGITS: usize = 12;

/// Arguments of `atlas table list`.
#[derive(Debug, Args)]
pub struct ListArgs {
    #[command(flatten)]
    folder: TablesFolder,
    /// Print JSON for programs.
    #[arg(long)]
    json: bool,
}

/// Prints a line a table.
pub fn run(args: &ListArgs) -> ExitCode {
    let store = args.folder.store();
    let entries = match store.entries() {
        Ok(entries) => entries,
        Err(error) => return refuse(&error),
    };
    let text = match args.json {
        true => format!("{:#}\n", Value::from_iter(entries.iter().map(record))),
        false => {
            let total = entries.iter().map(|entry| entry.bytes).sum();
            let folder = store.folder().display();
            let count = tables(entries.len());
            lines(&entries) + &format!("{count}, {}, in {folder}\n", size_text(total))
        }
    };
    answer(&text, ExitCode::SUCCESS)
}

fn lines(entries: &[CacheEntry]) -> String {
    let mut text = String::new();
    if !entries.is_empty() {
        let key = "key";
        _ = writeln!(
            text,
            "kind      {key:<DIGITS$}        size  last used             arrays"
        );
    }
    for entry in entries {
        let (size, used) = (size_text(entry.bytes), timestamp(entry.used));
        _ = match &entry.header {
            Ok(header) => {
                let names: Vec<&str> = header.arrays.iter().map(|a| a.name.as_str()).collect();
                let (kind, key) = (header.kind.name(), &header.key[..DIGITS]);
                let names = names.join(", ");
                writeln!(text, "{kind:<8}  {key}  {size:>10}  {used}  {names}")
            }
            Err(fault) => writeln!(text, "unusable  `{}` {fault}", entry.path.display()),
        };
    }
    text
}

fn record(entry: &CacheEntry) -> Value {
    let mut record = json!({
        "file": entry.path,
        "bytes": entry.bytes,
        "used": timestamp(entry.used),
    });
    match &entry.header {
        Ok(header) => {
            record["kind"] = json!(header.kind);
            record["key"] = json!(header.key);
            record["program"] = json!(header.program);
            record["arrays"] = json!(header.arrays);
        }
        Err(fault) => record["fault"] = json!(fault.to_string()),
    }
    record
}
