//! `atlas help`: lists the subcommands, or explains one of them, the keys of a manifest, one key, or the schema with
//! which editors check a manifest.

use super::{BAD_INPUT, Cli, answer, fail};
use crate::manifest::manual;
use clap::builder::{PossibleValue, StringValueParser, TypedValueParser};
use clap::error::ErrorKind;
use clap::{Arg, Args, Command, CommandFactory, Parser};
use std::ffi::OsStr;
use std::process::ExitCode;

/// Arguments of `atlas help`.
#[derive(Debug, Args)]
pub struct HelpArgs {
    /// A subcommand; `manifest` for all keys of a manifest; `schema` for its JSON Schema; a table
    /// such as `mesh` (write `[run]` if a subcommand has the same name); or a key such as `mesh.half_gap`
    #[arg(value_name = "TOPIC", value_parser = Topic, hide_possible_values = true)]
    pub topic: Vec<String>,
}

/// Parser that accepts any text. Its possible values serve only the completion in shells.
#[derive(Debug, Clone)]
struct Topic;

impl TypedValueParser for Topic {
    type Value = String;

    fn parse_ref(
        &self,
        command: &Command,
        argument: Option<&Arg>,
        value: &OsStr,
    ) -> Result<String, clap::Error> {
        StringValueParser::new().parse_ref(command, argument, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let topics = ["manifest", "schema"].into_iter().chain(manual::topics());
        Some(Box::new(topics.map(PossibleValue::new)))
    }
}

/// Explains a topic: status 0, or 2 if it does not exist.
pub fn run(args: &HelpArgs) -> ExitCode {
    let topic: Vec<&str> = args.topic.iter().map(String::as_str).collect();
    match topic.as_slice() {
        ["manifest"] => answer(&manual::overview(), ExitCode::SUCCESS),
        ["schema"] => answer(&manual::json_schema(), ExitCode::SUCCESS),
        [] => of_subcommand(&[]),
        [first, ..] if is_subcommand(first) => of_subcommand(&topic),
        [topic] => match manual::explain(topic) {
            Ok(text) => answer(&text, ExitCode::SUCCESS),
            Err(error) => fail(BAD_INPUT, &error.to_string()),
        },
        _ => fail(
            BAD_INPUT,
            "help takes one table or key of a manifest, or a subcommand",
        ),
    }
}

fn is_subcommand(name: &str) -> bool {
    Cli::command().find_subcommand(name).is_some()
}

/// Prints the `--help` text of a subcommand.
fn of_subcommand(names: &[&str]) -> ExitCode {
    let line = ["atlas"].iter().chain(names).chain(&["--help"]);
    let Err(text) = Cli::try_parse_from(line) else {
        return ExitCode::SUCCESS;
    };
    let status = match text.kind() {
        ErrorKind::DisplayHelp => ExitCode::SUCCESS,
        _ => ExitCode::from(BAD_INPUT),
    };
    // Ignore a closed output.
    _ = text.print();
    status
}
