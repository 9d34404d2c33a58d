//! The text of a job: parsed, validated (all errors at once) and resolved into a specification.
//!
//! ```text
//! text → tree (values with their places) → unknown keys → axes of the grid
//!      → every combination of axis values put into the tree and resolved → Job
//! ```
//!
//! Nothing is computed or written here. A fault never stops the search for others; a
//! syntax error does, for the text behind it.

mod advice;
mod axis;
mod axis_units;
mod diagnostic;
mod errors;
mod excerpt;
mod expand;
mod grid;
mod hash;
mod job;
pub mod manual;
mod modal_file;
mod parameter;
mod points;
mod reader;
mod schema;
mod sections;
mod spec;
mod syntax;
mod text;
mod tree;
mod unknown;

pub use advice::{Advice, AdviceKind, advice};
pub use axis::{AxisKey, AxisValues};
pub use axis_units::axis_units;
pub use diagnostic::{Diagnostic, DiagnosticKind, Source, Span};
pub use errors::ManifestErrors;
pub use expand::Between;
pub use job::Job;
pub use parameter::{Parameter, ParameterError};
pub use points::Points;
pub use spec::*;

use diagnostic::Issues;
use expand::Expansion;
use reader::Section;
use sections::Context;
use std::path::Path;
use text::NoText;

/// Reads a manifest file.
///
/// # Errors
///
/// Every fault of the manifest and of the modal file it names; an unreadable manifest is
/// one fault of its own.
pub fn load(path: &Path) -> Result<Job, ManifestErrors> {
    let mut issues = Issues::default();
    match text::read(&mut issues, path, "the manifest") {
        Ok(source) => judge(issues, source, path.parent().unwrap_or(Path::new(""))),
        Err(NoText::Reported) => Err(ManifestErrors::new(issues)),
        Err(NoText::Unreadable(error)) => {
            let name = path.display().to_string();
            let message = format!("the manifest `{name}` cannot be read: {error}");
            let source = issues.add_source(name, String::new());
            let span = Span {
                source,
                start: 0,
                end: 0,
            };
            issues.push(
                Diagnostic::new(DiagnosticKind::Unreadable, span, "", message)
                    .remedy("check the path; a manifest is a text file (UTF-8) in TOML"),
            );
            Err(ManifestErrors::new(issues))
        }
    }
}

/// Reads the text of a manifest. `name` stands for it in messages; relative paths in it
/// start at `base_dir`.
///
/// # Errors
///
/// Every fault of the text and of the modal file it names.
pub fn parse(text: &str, name: &str, base_dir: &Path) -> Result<Job, ManifestErrors> {
    let mut issues = Issues::default();
    let source = issues.add_source(name.to_owned(), text.to_owned());
    judge(issues, source, base_dir)
}

/// Judges a manifest that was read and resolves it.
fn judge(mut issues: Issues, source: usize, base_dir: &Path) -> Result<Job, ManifestErrors> {
    let mut tree = tree::parse(source, &mut issues);
    let syntax_faults = issues.more;
    let syntax_error = issues
        .found
        .iter()
        .filter(|d| d.kind == DiagnosticKind::Syntax)
        .map(|d| d.span.start)
        .chain(issues.unread)
        .min();

    unknown::check(&mut issues, &tree, schema::MANIFEST);
    let root = Section::root(&tree, schema::MANIFEST);
    let head = sections::read_job(&root, &mut issues);
    let axes = grid::read(&root, &mut issues);

    // The values of a grid that is too large are not looked at.
    let counted = axes.valid.iter().filter(|_| !axes.too_large);
    let plain: Vec<&Axis> = counted.map(|axis| &axis.axis).collect();
    let seed = head.as_ref().map_or(0, |head| head.seed);
    let mut hash = hash::JobHash::new(seed, &plain, axes.carried.as_ref());
    if let Some(refine) = &axes.refine {
        hash.refined(refine);
    }
    let mut context = Context::new(base_dir);
    let judged = expand::expand(
        &mut tree,
        &axes.valid,
        !axes.too_large,
        &mut issues,
        &mut context,
        &mut hash,
    );

    let varied: Vec<&Axis> = axes.valid.iter().map(|axis| &axis.axis).collect();
    let retained = judged.first().map(|variant| variant.model.retained);
    let continuation = sections::read_continuation(
        &Section::root(&tree, schema::MANIFEST),
        &mut issues,
        &varied,
        &axes.faulty,
        retained,
    );

    if let Some(start) = syntax_error {
        keep_certain(&mut issues, source, start);
        issues.more = syntax_faults;
    }
    // A key that only a faulty axis gives is not missing.
    issues
        .found
        .retain(|d| d.kind != DiagnosticKind::MissingKey || !axes.faulty.contains(&d.key));
    drop_echoes(&mut issues);
    match head {
        Some(head) if issues.count() == 0 => {
            let plain: Vec<Axis> = axes.valid.iter().map(|axis| axis.axis.clone()).collect();
            let between = Between::new(tree, axes.valid, context);
            let variants = Expansion::new(judged, between.clone());
            let nested = axes.refine.as_ref().map(|refine| refine.nested);
            let points = Points::new(variants, &plain, axes.carried.as_ref(), nested);
            Ok(Job {
                name: head.name,
                seed: head.seed,
                text: issues.sources.swap_remove(source).text,
                hash: hash.finish(),
                axes: plain,
                carried: axes.carried,
                refine: axes.refine,
                between,
                points,
                continuation: continuation.flatten(),
            })
        }
        _ => Err(ManifestErrors::new(issues)),
    }
}

/// A misspelt key is one fault, not an unknown and a missing one.
fn drop_echoes(issues: &mut Issues) {
    let meant: Vec<String> = issues
        .found
        .iter()
        .filter(|d| d.kind == DiagnosticKind::UnknownKey)
        .filter_map(|d| {
            let near = d
                .suggestion
                .as_ref()?
                .strip_prefix('`')?
                .strip_suffix('`')?;
            Some(match d.key.rsplit_once('.') {
                Some((parent, _)) => format!("{parent}.{near}"),
                None => near.to_owned(),
            })
        })
        .collect();
    issues
        .found
        .retain(|d| d.kind != DiagnosticKind::MissingKey || !meant.contains(&d.key));
}

/// After a syntax error the tree is a guess. Syntax errors stay, and so do faults of
/// values and names on the lines before the first of them; what seems to be missing may
/// only not have been understood.
fn keep_certain(issues: &mut Issues, source: usize, first: usize) {
    let text = &issues.sources[source].text;
    let line_start = text[..first.min(text.len())]
        .rfind('\n')
        .map_or(0, |newline| newline + 1);
    issues.found.retain(|d| match d.kind {
        DiagnosticKind::Syntax | DiagnosticKind::DuplicateKey => true,
        DiagnosticKind::UnknownKey
        | DiagnosticKind::WrongType
        | DiagnosticKind::WrongUnit
        | DiagnosticKind::OutOfRange
        | DiagnosticKind::Unavailable => d.span.source == 0 && d.span.end <= line_start,
        DiagnosticKind::Unreadable
        | DiagnosticKind::MissingKey
        | DiagnosticKind::Empty
        | DiagnosticKind::GridTooLarge
        | DiagnosticKind::UnknownAxis
        | DiagnosticKind::Inconsistent
        | DiagnosticKind::NoEffect => false,
    });
}
