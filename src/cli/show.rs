//! `atlas show`: a summary of a results folder in the terminal.

use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, ValueEnum};

use super::{BAD_INPUT, answer, fail, with_causes};
use crate::report::{ReportError, Style, Summary, render, render_branches};
use crate::store::{StoreError, journal_path};

/// Arguments of `atlas show`.
#[derive(Debug, Args)]
pub struct ShowArgs {
    /// Folder that `atlas run` wrote, such as results/flex80.
    pub results: PathBuf,
    /// Print JSON for programs instead of text.
    #[arg(long)]
    pub json: bool,
    /// Print the attractors that probes found, branch by branch along the last axis.
    #[arg(long, conflicts_with = "json")]
    pub branches: bool,
    /// When to use colours; `auto` asks the terminal and honours NO_COLOR.
    #[arg(long, value_enum, default_value_t = Colour::Auto, value_name = "WHEN")]
    pub color: Colour,
}

/// When to use colours.
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
            Self::Auto => {
                let refused = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
                !refused && io::stdout().is_terminal()
            }
        };
        if wanted { Style::Colour } else { Style::Plain }
    }
}

/// Prints the summary; exit status 2 when there are no results to summarise.
pub fn run(args: &ShowArgs) -> ExitCode {
    match text(&args.results, args.json, args.branches, args.color) {
        Ok(text) => answer(&text, ExitCode::SUCCESS),
        Err(message) => fail(BAD_INPUT, &message),
    }
}

fn text(folder: &Path, json: bool, branches: bool, colour: Colour) -> Result<String, String> {
    let summary = Summary::read(folder).map_err(|error| match &error {
        ReportError::Store(StoreError::Missing { .. }) if journal_path(folder, None).exists() => format!(
            "no results in `{}` yet: a run is at work there, or was killed; repeating its command goes on from there",
            folder.display()
        ),
        error => with_causes(error),
    })?;
    if json {
        let text = serde_json::to_string_pretty(&summary).map_err(|error| with_causes(&error))?;
        return Ok(text + "\n");
    }
    if branches {
        return match summary.attractors.is_empty() {
            true => Err(format!(
                "no attractors in `{}`; ask for `multistability` in the manifest's [analyses]",
                folder.display()
            )),
            false => Ok(render_branches(&summary)),
        };
    }
    Ok(render(&summary, colour.style()))
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
        assert_eq!(message.lines().count(), 1);
    }

    #[test]
    fn colours_are_never_forced_on_a_pipe() {
        assert_eq!(Colour::Always.style(), Style::Colour);
        assert_eq!(Colour::Never.style(), Style::Plain);
    }
}
