//! The text of a job: parsed, validated (all errors at once) and resolved into a specification.
//!
//! ```text
//! text → tree (values with their places) → unknown keys → axes of the grid
//!      → every combination of axis values put into the tree and resolved → Job
//! ```
//!
//! Nothing is computed or written here. Warnings do not stop the job; the job contains them. The search for
//! faults continues after a fault. Only a syntax error ends it, for the text after the error.

mod advice;
mod axis;
mod columns;
mod combinations;
mod csv;
mod diagnostic;
mod distribution;
mod errors;
mod excerpt;
mod expand;
mod expression;
mod grid;
mod grid_dimension;
mod hash;
mod housing_file;
mod job;
mod manifest_text;
pub mod manual;
mod measured;
mod modal_file;
mod modal_keys;
mod modal_tree;
mod named_files;
mod operating_point;
mod parameter;
mod point_resolver;
mod points;
mod reader;
mod schema;
mod sections;
mod set;
mod slip;
mod spec;
mod syntax;
mod text;
mod tree;
mod unknown;

pub use advice::{Advice, AdviceKind, Place, advice};
pub use axis::{AxisKey, AxisValues};
pub use diagnostic::{Diagnostic, DiagnosticKind, Source, Span};
pub use distribution::{Distribution, Law};
pub use errors::{ManifestErrors, Warnings};
pub use grid_dimension::GridDimension;
pub use job::Job;
pub use manifest_text::ManifestText;
pub use measured::{Measured, MeasuredColumn};
pub use named_files::NamedFile;
pub use parameter::{Parameter, ParameterError};
pub use point_resolver::PointResolver;
pub use points::Points;
pub use spec::*;

use diagnostic::Issues;
use expand::Expansion;
use grid::GridAxis;
use reader::Section;
use sections::Context;
use std::io::Read;
use std::path::Path;
use text::TextError;
use tree::Node;

/// Reads a manifest file.
///
/// # Errors
///
/// Every fault of the manifest and of the files it names; an unreadable manifest is one fault.
pub fn load(path: &Path) -> Result<Job, ManifestErrors> {
    load_changed(path, &[])
}

/// Reads a manifest file and changes some keys, each given as `KEY=VALUE`: the value is TOML, or a text without quotes.
/// `KEY=` removes the key. The job's hash is that of the changed manifest.
///
/// # Errors
///
/// As [`load`], and every fault of the changes.
pub fn load_changed(path: &Path, changes: &[String]) -> Result<Job, ManifestErrors> {
    let issues = Issues::default();
    let source = text::read(&issues, path, "the manifest");
    let base_dir = path.parent().unwrap_or(Path::new(""));
    resolve_read_manifest(
        issues,
        source,
        &path.display().to_string(),
        base_dir,
        changes,
    )
}

/// Reads a manifest from a stream. Messages call it `name`, and relative paths in it start at the current folder. Keys
/// are changed as by [`load_changed`].
///
/// # Errors
///
/// As [`load_changed`].
pub fn read_changed(
    stream: &mut dyn Read,
    name: &str,
    changes: &[String],
) -> Result<Job, ManifestErrors> {
    let issues = Issues::default();
    let source = text::read_stream(&issues, stream, name, "the manifest");
    resolve_read_manifest(issues, source, name, Path::new(""), changes)
}

fn resolve_read_manifest(
    issues: Issues,
    source: Result<usize, TextError>,
    name: &str,
    base_dir: &Path,
    changes: &[String],
) -> Result<Job, ManifestErrors> {
    let remedy = "check the path; a manifest is a TOML file in UTF-8";
    match text::or_report(&issues, source, ("", "the manifest", name), remedy) {
        Some(source) => resolve_manifest(issues, source, base_dir, changes),
        None => Err(ManifestErrors::new(issues)),
    }
}

/// Reads the text of a manifest. Messages call it `name`; relative paths in it start at `base_dir`.
///
/// # Errors
///
/// Every fault of the text and of the files it names.
pub fn parse(text: &str, name: &str, base_dir: &Path) -> Result<Job, ManifestErrors> {
    let changes = &[];
    ManifestText { text, changes }.job(name, base_dir)
}

impl ManifestText<'_> {
    /// The job. Messages call the text `name`; relative paths in it start at `base_dir`.
    ///
    /// # Errors
    ///
    /// Every fault of the text, of the changes and of the files it names.
    pub fn job(self, name: &str, base_dir: &Path) -> Result<Job, ManifestErrors> {
        let issues = Issues::default();
        let source = issues.add_source(name.to_owned(), self.text.to_owned());
        resolve_manifest(issues, source, base_dir, self.changes)
    }
}

/// Checks and resolves a manifest that was read, with some keys changed.
fn resolve_manifest(
    issues: Issues,
    source: usize,
    base_dir: &Path,
    changes: &[String],
) -> Result<Job, ManifestErrors> {
    let mut tree = tree::parse(source, &issues);
    let syntax_faults = issues.more.get();
    let syntax_error = (issues.found.borrow().iter())
        .filter(|d| d.kind == DiagnosticKind::Syntax)
        .map(|d| d.span.start)
        .chain(issues.unread.get())
        .min();

    let changed = set::apply(&mut tree, changes, &issues);
    unknown::check(&issues, &tree, schema::MANIFEST);
    let root = Section::root(&tree, &issues, schema::MANIFEST);
    let head = sections::read_job(&root);
    let seed = head.as_ref().map_or(0, |head| head.seed);
    let axes = grid::read(&root, base_dir, seed);
    set::check_axes(&tree, &changed, &axes, &issues);
    let mut context = Context::new(base_dir);
    change_modal_file(&mut tree, &axes.valid, &changed, &issues, &mut context);

    // The hash omits the values of a grid that is too large.
    let counted = axes.valid.iter().filter(|_| !axes.too_large);
    let plain: Vec<&Axis> = counted.map(|axis| &axis.axis).collect();
    let mut hash = hash::JobHash::new(seed, &plain, axes.carried.as_ref());
    if axes.dimensions.iter().any(GridDimension::is_tied) {
        // The dimensions show which axes advance in step.
        hash.add(&axes.dimensions);
    }
    if let Some(refine) = &axes.refine {
        hash.add(refine);
    }
    let judged = expand::expand(
        &mut tree,
        &axes.valid,
        &axes.dimensions,
        !axes.too_large,
        &issues,
        &mut context,
        &mut hash,
    );

    let varied: Vec<&Axis> = axes.valid.iter().map(|axis| &axis.axis).collect();
    let retained = judged
        .variants()
        .first()
        .map(|variant| variant.model.retained);
    let continuation = sections::read_continuation(
        &Section::root(&tree, &issues, schema::MANIFEST),
        &varied,
        &axes.dimensions,
        (&axes.faulty, &axes.expressions),
        retained,
    );

    let root = Section::root(&tree, &issues, schema::MANIFEST);
    let run_up = sections::read_run_up(&root, base_dir);
    operating_point::check(&axes.valid, judged.variants(), &issues);
    if let Some(start) = syntax_error {
        keep_certain(&issues, source, start);
        issues.more.set(syntax_faults);
    }
    // A key is not missing if a faulty axis gives it.
    issues.found.borrow_mut().retain(|d| {
        d.kind != DiagnosticKind::MissingKey || !(axes.unknown || axes.faulty.contains(&d.key))
    });
    drop_echoes(&issues);
    match head {
        Some(head) if issues.count() == 0 => {
            let warnings = Warnings::of(&issues);
            let plain: Vec<Axis> = axes.valid.iter().map(|axis| axis.axis.clone()).collect();
            let between = PointResolver::new(tree, axes.valid, &axes.dimensions, context)
                .deriving(axes.expressions);
            let variants = Expansion::new(judged, between.clone());
            let nested = axes.refine.as_ref().map(|refine| refine.nested);
            let points = Points::new(
                variants,
                head.seed,
                &plain,
                &axes.dimensions,
                axes.carried.as_ref(),
                nested,
            );
            Ok(Job {
                name: head.name,
                seed: head.seed,
                text: issues.sources.borrow_mut().swap_remove(source).text,
                changes: changes.to_vec(),
                folder: base_dir.to_owned(),
                warnings,
                hash: hash.finish(),
                axes: plain,
                dimensions: axes.dimensions,
                carried: axes.carried,
                refine: axes.refine,
                samples: axes.samples,
                between,
                points,
                continuation: continuation.flatten(),
                run_up: run_up.flatten(),
            })
        }
        _ => Err(ManifestErrors::new(issues)),
    }
}

/// Puts the tree of the modal file into that of the manifest if axes or commands change numbers of the file.
/// Applies the changes of commands.
fn change_modal_file(
    tree: &mut Node,
    axes: &[GridAxis],
    changed: &[set::Changed],
    issues: &Issues,
    context: &mut Context,
) {
    let of_file = |axis: &GridAxis| modal_keys::is_modal_number_name(axis.axis.name());
    if axes.iter().any(of_file) || changed.iter().any(set::Changed::is_of_modal_file) {
        modal_file::attach(tree, issues, context);
        set::apply_to_modal_file(tree, changed, issues);
    }
}

/// Drops the fault of a missing key if an unknown key seems to be its misspelt name.
fn drop_echoes(issues: &Issues) {
    let mut diagnostics = issues.found.borrow_mut();
    let meant: Vec<String> = (diagnostics.iter())
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
    diagnostics.retain(|d| d.kind != DiagnosticKind::MissingKey || !meant.contains(&d.key));
}

/// After a syntax error the tree is uncertain. Keeps syntax errors and duplicate keys, and faults of values and names
/// on the lines of the manifest before byte `first`. Keys that seem to be missing may only be unreadable.
fn keep_certain(issues: &Issues, source: usize, first: usize) {
    let text = issues.text(source);
    let line_start = text[..first.min(text.len())]
        .rfind('\n')
        .map_or(0, |newline| newline + 1);
    issues.found.borrow_mut().retain(|d| match d.kind {
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
        | DiagnosticKind::NoEffect
        | DiagnosticKind::Unusual => false,
    });
}
