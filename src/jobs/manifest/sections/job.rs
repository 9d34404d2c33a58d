//! `[job]`: name and seed.

use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::reader::Section;

/// The contents of `[job]`.
#[derive(Debug)]
pub(in crate::manifest) struct JobHead {
    pub name: String,
    pub seed: u64,
}

/// Longest name; every file system must accept it, with suffixes, as a results folder.
const MAX_NAME: usize = 100;

pub(in crate::manifest) fn read(root: &Section, issues: &mut Issues) -> Option<JobHead> {
    let section = root.required_child(issues, "job")?;
    let name = section.text(issues, "name").filter(|name| {
        let fits = !name.is_empty()
            && name.len() <= MAX_NAME
            && !name.starts_with(['.', '-'])
            && name
                .chars()
                .all(|c| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.'));
        if !fits {
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::OutOfRange,
                    section.span_of("name"),
                    "job.name",
                    format!("`job.name` = \"{name}\" cannot name a results folder"),
                )
                .label("not a folder name")
                .accepted(format!(
                    "give 1 to {MAX_NAME} letters, digits, `-`, `_` or `.`; begin with a letter, a digit or `_`"
                )),
            );
        }
        fits
    });
    let seed = section.integer_or_default(issues, "seed");
    Some(JobHead {
        name: name?.to_owned(),
        seed: seed?,
    })
}
