//! `atlas plot`: SVG and PNG pictures of a results or trace folder, or of a mesh table.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use serde_json::json;

use super::{BAD_INPUT, answer, fail, with_causes};
use crate::report::{Drawn, PlotRequest, What, plot};
use crate::store::write_whole;

/// Arguments of `atlas plot`.
#[derive(Debug, Args)]
pub struct PlotArgs {
    /// Folder that `atlas run` or `atlas trace` wrote, such as results/flex80, or the file of a
    /// mesh table.
    pub source: PathBuf,
    /// Folder for the pictures [default: `pictures` in the folder, or beside the file].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// File formats.
    #[arg(long, value_enum, default_value_t = Format::Both)]
    pub format: Format,
    /// Kinds of pictures, separated by commas [default: all that the data allow].
    #[arg(long, value_enum, value_delimiter = ',', value_name = "KIND,...")]
    pub what: Vec<What>,
    /// Axis of pictures over one axis [default: the one with most values]; with `lambda` and
    /// `classes`, curves over it instead of maps.
    #[arg(long, value_name = "AXIS")]
    pub over: Option<String>,
    /// point_id for spectrum and phase [default: the loudest, or the most chaotic point] and
    /// for basins, multipliers and kicks [default: all].
    #[arg(long, value_name = "ID")]
    pub point: Option<u64>,
    /// Print nothing but errors.
    #[arg(long, short)]
    pub quiet: bool,
    /// Print the list of files as JSON.
    #[arg(long)]
    pub json: bool,
}

/// File formats of pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Scalable, for documents.
    Svg,
    /// 1920 pixels wide.
    Png,
    /// Both.
    Both,
}

/// Writes the pictures: status 0 when done, 2 for bad input, 1 where a file cannot be
/// written.
pub fn run(args: &PlotArgs) -> ExitCode {
    let request = PlotRequest {
        what: args.what.clone(),
        over: args.over.clone(),
        point: args.point,
    };
    let drawn = match plot(&args.source, &request) {
        Ok(drawn) => drawn,
        Err(error) => return fail(BAD_INPUT, &with_causes(&error)),
    };
    if drawn.pictures.is_empty() {
        let message = format!(
            "nothing to draw in `{}`: {}",
            args.source.display(),
            drawn.notes.join("; ")
        );
        return fail(BAD_INPUT, &message);
    }
    let default = || match args.source.parent() {
        Some(parent) if args.source.is_file() => parent.join("pictures"),
        _ => args.source.join("pictures"),
    };
    let folder = args.out.clone().unwrap_or_else(default);
    let files = match write(&drawn, &folder, args.format) {
        Ok(files) => files,
        Err(message) => return fail(1, &message),
    };
    let mut text = String::new();
    if args.json {
        text = format!("{:#}\n", json!({ "files": files, "notes": drawn.notes }));
    } else if !args.quiet {
        for file in &files {
            text.push_str(&format!("{}\n", file.display()));
        }
        for note in &drawn.notes {
            text.push_str(&format!("left out  {note}\n"));
        }
    }
    answer(&text, ExitCode::SUCCESS)
}

/// Writes every picture in every format; gives the files.
fn write(drawn: &Drawn, folder: &Path, format: Format) -> Result<Vec<PathBuf>, String> {
    let refused = |path: &Path, error: &dyn std::error::Error| {
        format!(
            "cannot write `{}`: {error}; choose another folder with --out",
            path.display()
        )
    };
    fs::create_dir_all(folder).map_err(|error| refused(folder, &error))?;
    let mut files = Vec::new();
    for picture in &drawn.pictures {
        let mut contents = Vec::new();
        if format != Format::Png {
            let text = picture.svg().map_err(|error| error.to_string())?;
            contents.push(("svg", text.into_bytes()));
        }
        if format != Format::Svg {
            contents.push(("png", picture.png().map_err(|error| error.to_string())?));
        }
        for (extension, bytes) in contents {
            let path = folder.join(format!("{}.{extension}", picture.name));
            write_whole(&path, &bytes).map_err(|error| with_causes(&error))?;
            files.push(path);
        }
    }
    Ok(files)
}
