//! `atlas show`: a summary of a results folder, or of a file of computed tables, in the terminal.

use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, ValueEnum};

use super::{BAD_INPUT, answer, either, fail, pretty, refuses_colours, with_causes};
use crate::input::printable;
use crate::report::{ReportError, Style, Summary, TableSummary, render, render_branches};
use crate::store::{Contents, StoreError, TableKind, journal_path, table_path};

/// Arguments of `atlas show`.
#[derive(Debug, Args)]
pub struct ShowArgs {
    /// Folder that `atlas run` or `atlas follow` wrote, such as results/flex80, or a file of the folder `tables`.
    pub results: PathBuf,
    /// Print JSON instead of text.
    #[arg(long)]
    pub json: bool,
    /// Print the attractors that probes found, branch by branch along the last axis with several values.
    #[arg(long, conflicts_with = "json")]
    pub branches: bool,
    /// Choose when to use colours.
    #[arg(long, value_enum, default_value_t = Colour::Auto, value_name = "WHEN")]
    pub color: Colour,
}

/// Choose when to use colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Colour {
    /// On a terminal, unless NO_COLOR is set.
    Auto,
    /// Always.
    Always,
    /// Never.
    Never,
}

impl Colour {
    fn style(self) -> Style {
        let wanted = match self {
            Self::Always => true,
            Self::Never => false,
            Self::Auto => !refuses_colours() && io::stdout().is_terminal(),
        };
        if wanted { Style::Colour } else { Style::Plain }
    }
}

/// Prints the summary; exit status 2 if there are no results to summarise.
pub fn run(args: &ShowArgs) -> ExitCode {
    match text(&args.results, args.json, args.branches, args.color) {
        Ok(text) => answer(&text, ExitCode::SUCCESS),
        Err(message) => fail(BAD_INPUT, &message),
    }
}

fn text(folder: &Path, json: bool, branches: bool, colour: Colour) -> Result<String, String> {
    if folder.is_file() && !branches {
        return table(folder, json);
    }
    let points = table_path(folder, TableKind::Points, None);
    let summary = Summary::read(folder).map_err(|error| match &error {
        ReportError::Store(StoreError::Missing { .. }) if !points.exists() => instead(folder),
        error => with_causes(error),
    })?;
    if json {
        return Ok(pretty(&summary));
    }
    if branches {
        return if summary.attractors.is_empty() {
            Err(format!(
                "no attractors in `{}`; add `multistability = {{}}` to [analyses] of the manifest",
                folder.display()
            ))
        } else {
            Ok(render_branches(&summary))
        };
    }
    Ok(render(&summary, colour.style()))
}

/// The contents of a file of computed tables.
fn table(file: &Path, json: bool) -> Result<String, String> {
    let summary = TableSummary::read(file).map_err(|fault| {
        format!(
            "`{}` {fault}; give a folder that `atlas run` wrote, or a whole file of the folder `tables`",
            file.display()
        )
    })?;
    Ok(either(json, || &summary, || summary.render()))
}

/// The message for a folder without results: what it contains, and the command for such contents.
pub(super) fn instead(folder: &Path) -> String {
    let here = folder.display();
    if journal_path(folder, None).exists() {
        return format!(
            "no results in `{here}` yet: a run is in progress there, or was killed; repeat its command to continue"
        );
    }
    match Contents::of(folder) {
        Contents::NotThere => {
            format!("no results in `{here}`: the folder does not exist; `atlas run` writes one")
        }
        Contents::File => {
            format!("no results in `{here}`: it is a file; give a folder that `atlas run` wrote")
        }
        Contents::Trace => {
            format!("no results in `{here}`: it holds a trace; `atlas plot {here}` draws it")
        }
        Contents::RunUp => {
            format!("no results in `{here}`: it holds a run-up; `atlas plot {here}` draws it")
        }
        Contents::Machine => format!(
            "no results in `{here}`: it holds measurements of `atlas machine`; `atlas machine show {here}` prints them"
        ),
        Contents::Tables => format!(
            "no results in `{here}`: it holds computed tables; `atlas show {here}/FILE` shows the content of a file"
        ),
        Contents::Folders(names) => {
            const MOST_FOLDERS: usize = 12;
            let more = match names.len().saturating_sub(MOST_FOLDERS) {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            let named = names
                .iter()
                .take(MOST_FOLDERS)
                .map(|name| printable(name).into_owned());
            format!(
                "no results in `{here}` itself; these folders in it have some: {}{more}",
                named.collect::<Vec<_>>().join(", ")
            )
        }
        Contents::Nothing => format!(
            "no results in `{here}`: atlas wrote nothing in it; give a folder that `atlas run` wrote"
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::{ResultLayout, ResultWriter};

    #[test]
    fn json_is_json_and_text_is_text() {
        let folder = tempfile::tempdir().unwrap();
        let writer = ResultWriter::create(folder.path(), &ResultLayout::default(), []).unwrap();
        writer.finish().unwrap();
        let json = text(folder.path(), true, false, Colour::Never).unwrap();
        let value: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert_eq!(value["points"], 0);
        assert_eq!(value["state"], serde_json::Value::Null);
        let plain = text(folder.path(), false, false, Colour::Never).unwrap();
        assert!(plain.contains("no point was computed"), "{plain}");
    }

    #[test]
    fn a_folder_without_results_is_bad_input() {
        let folder = tempfile::tempdir().unwrap();
        let message = text(folder.path(), false, false, Colour::Never).unwrap_err();
        assert!(message.starts_with("no results in"), "{message}");
        assert!(message.contains("atlas wrote nothing in it"), "{message}");
        assert_eq!(message.lines().count(), 1);
    }

    #[test]
    fn folders_of_other_kinds_are_named_with_their_command() {
        for (file, command) in [
            ("trace.parquet", "atlas plot"),
            ("signals.parquet", "atlas plot"),
            ("machine.json", "atlas machine show"),
            ("mesh-0123456789abcdef0123456789abcdef.table", "atlas show"),
        ] {
            let folder = tempfile::tempdir().unwrap();
            std::fs::write(folder.path().join(file), "").unwrap();
            let message = text(folder.path(), false, false, Colour::Never).unwrap_err();
            let wanted = format!("`{command} {}", folder.path().display());
            assert!(message.contains(&wanted), "{message}");
            assert_eq!(message.lines().count(), 1);
        }
        let root = tempfile::tempdir().unwrap();
        let inner = root.path().join("first");
        ResultWriter::create(&inner, &ResultLayout::default(), [])
            .unwrap()
            .finish()
            .unwrap();
        let message = text(root.path(), false, false, Colour::Never).unwrap_err();
        assert!(
            message.ends_with("folders in it have some: first"),
            "{message}"
        );
    }

    #[test]
    fn always_and_never_ignore_the_terminal() {
        assert_eq!(Colour::Always.style(), Style::Colour);
        assert_eq!(Colour::Never.style(), Style::Plain);
    }
}
