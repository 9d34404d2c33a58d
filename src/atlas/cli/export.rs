//! `atlas export`: tables of a results or trace folder for other programs.

use super::{BAD_INPUT, Status, answer, fail, reply, start_threads, with_causes};
use crate::export::{ExportError, ExportRequest, Format, Lists, Surveyed, export, survey_folder};
use crate::store::StoreError;
use clap::Args;
use serde_json::{Value, json};
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `atlas export`.
#[derive(Debug, Args)]
pub struct ExportArgs {
    /// Folder that `atlas run`, `runup`, `follow` or `trace` wrote, such as results/flex80.
    pub folder: PathBuf,
    /// Write files of this format. `python -m gearatlas.export` writes NumPy, MATLAB and Excel files.
    #[arg(long, value_enum, default_value_t = Format::Csv)]
    pub format: Format,
    /// Write only these tables, separated by commas: points, spectra, trace, ... [default: all].
    #[arg(long, value_delimiter = ',', value_name = "TABLE,...")]
    pub tables: Vec<String>,
    /// Write only these columns, separated by commas, of all tables that have them [default: all].
    #[arg(long, value_delimiter = ',', value_name = "COLUMN,...")]
    pub columns: Vec<String>,
    /// Write lists in this form in csv files; arrow files always contain lists.
    #[arg(long, value_enum, default_value_t = Lists::Wide)]
    pub lists: Lists,
    /// Write the files to this folder [default: `export` in the folder].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace files that already exist.
    #[arg(long)]
    pub overwrite: bool,
    /// List tables and columns, and write nothing.
    #[arg(long)]
    pub list: bool,
    /// Print nothing but errors.
    #[arg(long, short)]
    pub quiet: bool,
    /// Print JSON instead of text.
    #[arg(long, conflicts_with = "quiet")]
    pub json: bool,
}

/// Writes the files: status 0 if done, 2 for bad input, 1 if a file cannot be written.
pub fn run(args: &ExportArgs) -> Status {
    let request = ExportRequest {
        tables: args.tables.clone(),
        columns: args.columns.clone(),
        format: args.format,
        lists: args.lists,
        overwrite: args.overwrite,
    };
    let out = args
        .out
        .clone()
        .unwrap_or_else(|| args.folder.join("export"));
    if args.format == Format::Csv && !args.list {
        start_threads(None)?;
    }
    let found = if args.list {
        survey_folder(&args.folder, &request).map(|tables| (Vec::new(), tables))
    } else {
        export(&args.folder, &request, &out).map(|done| (done.files, done.tables))
    };
    let (files, tables) = match found {
        Ok(found) => found,
        Err(error) => return Err(fail(status(&error), &with_causes(&error))),
    };
    let json = || {
        let tables: Vec<_> = tables.iter().map(table_json).collect();
        json!({ "files": files, "tables": tables })
    };
    let listed = || tables.iter().map(table_text).collect::<Vec<_>>().join("\n");
    let written = || (files.iter().map(|file| format!("{}\n", file.display()))).collect();
    let text = || if args.list { listed() } else { written() };
    let text = reply(args.json, args.quiet, json, text);
    Ok(answer(&text, ExitCode::SUCCESS))
}

/// Exit status: 1 if the operating system reports an error, 2 if the user has to change the request.
fn status(error: &ExportError) -> u8 {
    match error {
        ExportError::Store(StoreError::Io(_)) | ExportError::Arrow { .. } => 1,
        _ => BAD_INPUT,
    }
}

fn table_text(table: &Surveyed) -> String {
    let mut text = format!("{}: {} rows\n", table.name(), table.rows);
    for column in &table.columns {
        let title = column.titled(column.head.name.clone());
        let list = if column.is_list() {
            format!(", {} elements", column.width)
        } else {
            String::new()
        };
        text += &format!("  {title}{list}: {}\n", column.head.description);
    }
    text
}

fn table_json(table: &Surveyed) -> Value {
    let columns = table.columns.iter().map(|column| {
        json!({
            "name": column.head.name,
            "unit": column.head.unit,
            "description": column.head.description,
            "elements": column.is_list().then_some(column.width),
            "absent": column.absent,
        })
    });
    json!({ "name": table.name(), "rows": table.rows, "columns": columns.collect::<Vec<_>>() })
}
