//! `atlas table clean`: removes tables that are not wanted any more.

use std::process::ExitCode;
use std::time::{Duration, SystemTime};

use clap::Args;

use super::{TablesFolder, refuse, tables};
use crate::cli::answer;
use crate::report::size_text;
use crate::store::Unwanted;

/// Arguments of `atlas table clean`.
///
/// Without --older-than and --all, tables that this program cannot read are removed, and what
/// killed runs left unfinished.
#[derive(Debug, Args)]
pub struct CleanArgs {
    /// Also remove tables not used for this long, such as 30d, 12h, 2w.
    #[arg(long, value_name = "AGE", value_parser = parse_age)]
    older_than: Option<Duration>,
    /// Remove every table.
    #[arg(long, conflicts_with = "older_than")]
    all: bool,
    #[command(flatten)]
    folder: TablesFolder,
}

/// Units of an age \[s\].
const UNITS: [(&str, f64); 5] = [
    ("s", 1.0),
    ("min", 60.0),
    ("h", 3600.0),
    ("d", 86_400.0),
    ("w", 604_800.0),
];

fn parse_age(text: &str) -> Result<Duration, String> {
    let start = text.find(|c: char| c.is_ascii_alphabetic());
    let (number, unit) = text.split_at(start.unwrap_or(text.len()));
    let seconds = UNITS.iter().find(|(name, _)| *name == unit);
    let age = number
        .trim()
        .parse::<f64>()
        .ok()
        .zip(seconds)
        .and_then(|(number, (_, seconds))| Duration::try_from_secs_f64(number * seconds).ok());
    age.ok_or_else(|| "an age is a number and s, min, h, d or w, such as 30d".into())
}

/// Removes tables and prints their files.
pub fn run(args: &CleanArgs) -> ExitCode {
    let unwanted = match (args.all, args.older_than) {
        (true, _) => Unwanted::All,
        (false, None) => Unwanted::Unusable,
        (false, Some(age)) => {
            let since = SystemTime::now().checked_sub(age);
            Unwanted::UnusedSince(since.unwrap_or(SystemTime::UNIX_EPOCH))
        }
    };
    let store = args.folder.store();
    let cleaned = match store.clean(unwanted) {
        Ok(cleaned) => cleaned,
        Err(error) => return refuse(&error),
    };
    let files = cleaned.files.iter();
    let mut text: String = files
        .map(|file| format!("removed {}\n", file.display()))
        .collect();
    let (count, size) = (tables(cleaned.files.len()), size_text(cleaned.bytes));
    text.push_str(&format!("{count} removed, {size} freed\n"));
    answer(&text, ExitCode::SUCCESS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ages_have_a_unit() {
        let seconds = |text: &str| parse_age(text).map(|age| age.as_secs());
        assert_eq!(seconds("30d"), Ok(2_592_000));
        assert_eq!(seconds("1.5 h"), Ok(5400));
        assert_eq!(seconds("0min"), Ok(0));
        for bad in ["", "30", "d", "-1d", "3 months", "1e400d", "nand", "1e300w"] {
            assert!(seconds(bad).is_err(), "{bad}");
        }
    }
}
