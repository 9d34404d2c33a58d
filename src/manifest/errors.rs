//! All faults of a manifest together: in the order of the text, and shown to people.

use super::diagnostic::{Diagnostic, DiagnosticKind, Issues, Source};
use super::excerpt::Excerpt;
use crate::input::printable;
use codespan_reporting::diagnostic as codespan;
use codespan_reporting::term;
use std::fmt::{self, Write};

/// Faults shown to people; programs get all that are kept.
const MOST_SHOWN: usize = 20;

/// All faults of a job, in the order of the text; at least one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ManifestErrors {
    /// The files they stand in; the manifest first.
    pub sources: Vec<Source>,
    /// The faults, no more of them than anybody reads.
    pub diagnostics: Vec<Diagnostic>,
    /// How many there are beyond those.
    pub more: usize,
}

impl ManifestErrors {
    /// Sorts the faults by place, drops repetitions and fills in lines and columns.
    pub(super) fn new(issues: Issues) -> Self {
        let Issues {
            sources,
            mut found,
            more,
            unread: _,
        } = issues;
        found.sort_by_key(|d| (d.span.source, d.span.start, d.span.end));
        found.dedup_by(|a, b| (a.kind, a.span, &a.key) == (b.kind, b.span, &b.key));
        for diagnostic in &mut found {
            let source = &sources[diagnostic.span.source];
            if diagnostic.kind != DiagnosticKind::Unreadable || !source.text.is_empty() {
                (diagnostic.line, diagnostic.column) = place(&source.text, diagnostic.span.start);
            }
        }
        Self {
            sources,
            diagnostics: found,
            more,
        }
    }

    /// How many faults there are.
    pub fn count(&self) -> usize {
        self.diagnostics.len() + self.more
    }

    /// How many there are in which manifest, a line.
    pub fn summary(&self) -> String {
        let count = match self.count() {
            1 => "1 error".to_owned(),
            count => format!("{count} errors"),
        };
        let name = self.sources.first().map_or("", |source| &source.name);
        let name = printable(name);
        format!("{name}: {count}; nothing was computed or written")
    }

    /// The first faults as text for people, without colour, and how many there are beyond.
    pub fn render(&self) -> String {
        self.render_into(|excerpt, diagnostic, out| {
            term::emit_to_io_write(out, &term::Config::default(), excerpt, diagnostic)
        })
    }

    /// The same with ANSI colours for a terminal.
    pub fn render_coloured(&self) -> String {
        self.render_into(|excerpt, diagnostic, out| {
            let styles = term::Styles::default();
            let mut writer = term::StylesWriter::new(term::termcolor::Ansi::new(out), &styles);
            term::emit_to_write_style(&mut writer, &term::Config::default(), excerpt, diagnostic)
        })
    }

    fn render_into(
        &self,
        emit: impl Fn(
            &Excerpt,
            &codespan::Diagnostic<()>,
            &mut Vec<u8>,
        ) -> Result<(), codespan_reporting::files::Error>,
    ) -> String {
        let mut text = Vec::new();
        for diagnostic in self.diagnostics.iter().take(MOST_SHOWN) {
            let mut shown = codespan::Diagnostic::error()
                .with_code(diagnostic.kind.code())
                .with_message(printable(&diagnostic.message))
                .with_notes(diagnostic.notes());
            let excerpt = Excerpt::of(&self.sources[diagnostic.span.source], diagnostic);
            if diagnostic.line > 0 {
                shown = shown.with_labels(vec![
                    codespan::Label::primary((), excerpt.spot.clone())
                        .with_message(printable(&diagnostic.label)),
                ]);
            }
            if emit(&excerpt, &shown, &mut text).is_err() {
                // The snippet could not be drawn; the sentence still must be shown.
                text.extend_from_slice(printable(&diagnostic.message).as_bytes());
                text.push(b'\n');
            }
            if diagnostic.line == 0 {
                text.push(b'\n');
            }
        }
        let mut text = String::from_utf8_lossy(&text).into_owned();
        let hidden = self.count() - self.diagnostics.len().min(MOST_SHOWN);
        if hidden > 0 {
            _ = writeln!(text, "… and {hidden} more\n");
        }
        text
    }
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

impl fmt::Display for ManifestErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render())
    }
}

impl std::error::Error for ManifestErrors {}
