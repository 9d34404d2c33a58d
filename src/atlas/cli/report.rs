//! `atlas report`: one HTML file that explores a results or trace folder.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use serde_json::json;

use super::size::size;
use super::{BAD_INPUT, OrFail, Status, answer, fail, refuse_existing, reply, show, with_causes};
use crate::report::{PageRequest, ReportError, results_page, size_text};
use crate::store::{StoreError, TableKind, record_paths, table_path, write_atomically};

/// Arguments of `atlas report`.
#[derive(Debug, Args)]
pub struct ReportArgs {
    /// Folder that `atlas run`, `atlas follow` or `atlas trace` wrote, such as results/flex80.
    pub folder: PathBuf,
    /// Write this file [default: `report.html` in the folder].
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Limit the size of the tables in the file; the page lists the tables that it omits [default: 40MiB].
    #[arg(long, value_name = "SIZE", value_parser = size)]
    pub most_bytes: Option<u64>,
    /// Replace a file that already exists.
    #[arg(long)]
    pub overwrite: bool,
    /// Print nothing but errors.
    #[arg(long, short)]
    pub quiet: bool,
    /// Print JSON instead of text: the file, its size and the omitted tables.
    #[arg(long, conflicts_with = "quiet")]
    pub json: bool,
}

/// Writes the file: status 0 if done, 2 for bad input, 1 if it cannot be written.
pub fn run(args: &ReportArgs) -> Status {
    let path = (args.out.clone()).unwrap_or_else(|| args.folder.join("report.html"));
    let mut request = PageRequest::default();
    if let Some(most) = args.most_bytes {
        request.most_bytes = most;
    }
    let page = match results_page(&args.folder, request) {
        Ok(page) => page,
        Err(error) => return Err(fail(BAD_INPUT, &refusal(&args.folder, &error))),
    };
    refuse_existing(&path, args.overwrite, "choose another file with --out")?;
    write_atomically(&path, page.html.as_bytes()).or_explain(1)?;
    let bytes = page.html.len() as u64;
    let json = || json!({ "file": path, "bytes": bytes, "left_out": page.left_out });
    let text = || {
        let mut text = format!("{}  {}\n", path.display(), size_text(bytes));
        for line in &page.left_out {
            text += &format!("left out  {line}; raise --most-bytes to include it\n");
        }
        text
    };
    let text = reply(args.json, args.quiet, json, text);
    Ok(answer(&text, ExitCode::SUCCESS))
}

/// The error message for a folder. If the folder has no results, the message describes its contents.
fn refusal(folder: &Path, error: &ReportError) -> String {
    let points = table_path(folder, TableKind::Points, None);
    let recorded = record_paths(folder).is_ok_and(|records| !records.is_empty());
    match error {
        ReportError::Store(StoreError::Missing { .. }) if !points.exists() && !recorded => {
            show::instead(folder)
        }
        error => with_causes(error),
    }
}
