//! `atlas show`: a summary of a results folder in the terminal.

use std::io::{self, ErrorKind, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, ValueEnum};

use crate::report::{Style, Summary, render};

/// Arguments of `atlas show`.
#[derive(Debug, Args)]
pub struct ShowArgs {
    /// Folder that `atlas run` wrote, such as results/flex80.
    pub results: PathBuf,
    /// Print JSON for programs instead of text.
    #[arg(long)]
    pub json: bool,
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
    let text = match text(&args.results, args.json, args.color) {
        Ok(text) => text,
        Err(message) => {
            // Nothing can be done when standard error is closed as well.
            _ = writeln!(io::stderr(), "error: {message}");
            return ExitCode::from(2);
        }
    };
    match io::stdout().write_all(text.as_bytes()) {
        Ok(()) => ExitCode::SUCCESS,
        // `atlas show … | head` has read what it wanted.
        Err(error) if error.kind() == ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(error) => {
            _ = writeln!(
                io::stderr(),
                "error: cannot write to standard output: {error}"
            );
            ExitCode::FAILURE
        }
    }
}

fn text(folder: &Path, json: bool, colour: Colour) -> Result<String, String> {
    let summary = Summary::read(folder).map_err(|error| with_causes(&error))?;
    if json {
        let text = serde_json::to_string_pretty(&summary).map_err(|error| with_causes(&error))?;
        return Ok(text + "\n");
    }
    Ok(render(&summary, colour.style()))
}

/// An error with its causes, on one line.
pub(super) fn with_causes(error: &dyn std::error::Error) -> String {
    let mut message = error.to_string();
    let mut source = error.source();
    while let Some(cause) = source {
        message.push_str(": ");
        message.push_str(&cause.to_string());
        source = cause.source();
    }
    message
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
        let json = text(folder.path(), true, Colour::Never).unwrap();
        let value: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert_eq!(value["points"], 0);
        assert_eq!(value["state"], serde_json::Value::Null);
        let plain = text(folder.path(), false, Colour::Never).unwrap();
        assert!(plain.contains("no point was computed"), "{plain}");
    }

    #[test]
    fn a_folder_without_results_is_bad_input() {
        let folder = tempfile::tempdir().unwrap();
        let message = text(folder.path(), false, Colour::Never).unwrap_err();
        assert!(message.starts_with("no results in"), "{message}");
        assert_eq!(message.lines().count(), 1);
    }

    #[test]
    fn colours_are_never_forced_on_a_pipe() {
        assert_eq!(Colour::Always.style(), Style::Colour);
        assert_eq!(Colour::Never.style(), Style::Plain);
    }
}
