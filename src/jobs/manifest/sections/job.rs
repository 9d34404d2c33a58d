//! `[job]`: name and seed.

use crate::manifest::diagnostic::DiagnosticKind;
use crate::manifest::reader::Section;

/// The contents of `[job]`.
#[derive(Debug)]
pub(in crate::manifest) struct JobHead {
    pub name: String,
    pub seed: u64,
}

/// Largest length of a name. Every file system must accept it, with suffixes, as a results folder.
const MAX_NAME: usize = 100;

pub(in crate::manifest) fn read(root: &Section) -> Option<JobHead> {
    let section = root.required_child("job")?;
    let name = (section.text("name")).and_then(|name| folder_name(&section, name));
    let seed = section.integer("seed");
    Some(JobHead {
        name: name?.to_owned(),
        seed: seed?,
    })
}

/// The name if a results folder can have it.
fn folder_name<'n>(section: &Section, name: &'n str) -> Option<&'n str> {
    let usual = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    let length = 1..=MAX_NAME;
    if length.contains(&name.len()) && !name.starts_with(['.', '-']) && name.chars().all(usual) {
        return Some(name);
    }
    let message = format!("`job.name` = \"{name}\" cannot name a results folder");
    let accepted = format!(
        "give 1 to {MAX_NAME} letters, digits, `-`, `_` or `.`; begin with a letter, a digit or `_`"
    );
    section
        .fault(DiagnosticKind::OutOfRange, "name", message)
        .label("not a folder name")
        .accepted(accepted)
        .fail(section.issues)
}
