//! The errors and warnings of a manifest, and their form as readable text.

use super::diagnostic::{Diagnostic, DiagnosticKind, Issues, Source};
use super::excerpt::Excerpt;
use crate::input::printable;
use crate::units::plural;
use codespan_reporting::diagnostic as codespan;
use codespan_reporting::term;
use std::borrow::Cow;
use std::collections::HashSet;
use std::fmt::Write;

/// Largest number of faults in the readable text; programs get all faults that were kept.
const MOST_SHOWN: usize = 20;

/// All faults of a job, with at least one error.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}", self.render(false))]
pub struct ManifestErrors {
    /// The files that were read, the manifest first.
    pub sources: Vec<Source>,
    /// The errors in the order of the text, then the warnings. Their number is limited.
    pub diagnostics: Vec<Diagnostic>,
    /// Number of further errors.
    pub more: usize,
}

impl ManifestErrors {
    pub(super) fn new(issues: Issues) -> Self {
        Self {
            diagnostics: take_sorted(&issues),
            sources: issues.sources.into_inner(),
            more: issues.more.get(),
        }
    }

    /// The errors that were kept.
    pub fn errors(&self) -> impl Iterator<Item = &Diagnostic> {
        self.diagnostics.iter().filter(|d| !d.kind.is_warning())
    }

    /// Number of errors, kept or not.
    pub fn count(&self) -> usize {
        self.errors().count() + self.more
    }

    /// One line with the manifest's name and the number of errors.
    pub fn summary(&self) -> String {
        let count = plural(self.count(), "error");
        let name = name(&self.sources);
        format!("{name}: {count}; nothing was computed or written")
    }

    /// The first faults as readable text, with ANSI colours if `coloured`, and the number of further ones.
    pub fn render(&self, coloured: bool) -> String {
        render(&self.sources, &self.diagnostics, self.more, coloured)
    }
}

/// The warnings of a valid manifest; usually empty.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Warnings {
    /// The files that were read, the manifest first; empty without warnings.
    pub sources: Vec<Source>,
    /// The warnings in the order of the text.
    pub diagnostics: Vec<Diagnostic>,
}

impl Warnings {
    /// The warnings among the faults of a job without errors.
    pub(super) fn of(issues: &Issues) -> Self {
        let diagnostics = take_sorted(issues);
        if diagnostics.is_empty() {
            Self::default()
        } else {
            Self {
                sources: issues.sources.borrow().clone(),
                diagnostics,
            }
        }
    }

    /// Whether there are no warnings.
    pub fn is_empty(&self) -> bool {
        self.diagnostics.is_empty()
    }

    /// One line with the manifest's name and the number of warnings.
    pub fn summary(&self) -> String {
        let count = plural(self.diagnostics.len(), "warning");
        format!("{}: {count}", name(&self.sources))
    }

    /// The first warnings as readable text, with ANSI colours if `coloured`, and the number of further ones.
    pub fn render(&self, coloured: bool) -> String {
        render(&self.sources, &self.diagnostics, 0, coloured)
    }
}

/// Name of the manifest.
fn name(sources: &[Source]) -> Cow<'_, str> {
    printable(sources.first().map_or("", |source| &source.name))
}

/// Takes the faults: errors before warnings, each sorted by place, without repetitions, with lines and columns.
fn take_sorted(issues: &Issues) -> Vec<Diagnostic> {
    let mut diagnostics = issues.found.take();
    let sources = issues.sources.borrow();
    diagnostics.sort_by_key(|d| (d.kind.is_warning(), d.span.source, d.span.start, d.span.end));
    let mut seen = HashSet::new();
    diagnostics.retain(|d| seen.insert((d.kind, d.span, d.key.clone())));
    for diagnostic in &mut diagnostics {
        let source = &sources[diagnostic.span.source];
        if diagnostic.kind != DiagnosticKind::Unreadable || !source.text.is_empty() {
            (diagnostic.line, diagnostic.column) = place(&source.text, diagnostic.span.start);
        }
    }
    diagnostics
}

/// The first faults as text, and the number of further ones, `more` of which were not kept.
fn render(sources: &[Source], diagnostics: &[Diagnostic], more: usize, coloured: bool) -> String {
    let (config, styles) = (term::Config::default(), term::Styles::default());
    let mut text = Vec::new();
    for diagnostic in diagnostics.iter().take(MOST_SHOWN) {
        let severity = if diagnostic.kind.is_warning() {
            codespan::Severity::Warning
        } else {
            codespan::Severity::Error
        };
        let mut shown = codespan::Diagnostic::new(severity)
            .with_code(diagnostic.kind.code())
            .with_message(printable(&diagnostic.message))
            .with_notes(diagnostic.notes());
        let excerpt = Excerpt::of(&sources[diagnostic.span.source], diagnostic);
        if diagnostic.line > 0 {
            shown = shown.with_labels(vec![
                codespan::Label::primary((), excerpt.spot.clone())
                    .with_message(printable(&diagnostic.label)),
            ]);
        }
        let emitted = if coloured {
            let mut writer =
                term::StylesWriter::new(term::termcolor::Ansi::new(&mut text), &styles);
            term::emit_to_write_style(&mut writer, &config, &excerpt, &shown)
        } else {
            term::emit_to_io_write(&mut text, &config, &excerpt, &shown)
        };
        if emitted.is_err() {
            // The excerpt could not be drawn; show the message anyway.
            text.extend_from_slice(printable(&diagnostic.message).as_bytes());
            text.push(b'\n');
        }
        if diagnostic.line == 0 {
            text.push(b'\n');
        }
    }
    let mut text = String::from_utf8_lossy(&text).into_owned();
    let hidden = diagnostics.len().saturating_sub(MOST_SHOWN) + more;
    if hidden > 0 {
        _ = writeln!(text, "… and {hidden} more\n");
    }
    text
}

/// Line and column, from 1, of a byte; the column counts characters.
fn place(text: &str, byte: usize) -> (usize, usize) {
    let before = &text.as_bytes()[..byte.min(text.len())];
    let line_start = before
        .iter()
        .rposition(|&b| b == b'\n')
        .map_or(0, |newline| newline + 1);
    let line = before.iter().filter(|&&b| b == b'\n').count() + 1;
    let column = String::from_utf8_lossy(&before[line_start..])
        .chars()
        .count()
        + 1;
    (line, column)
}
