//! What is wrong with a manifest, where, and what is the remedy? There is one [`Diagnostic`] per fault;
//! [`ManifestErrors`](super::ManifestErrors) has all faults of a job. Some faults are warnings: the job runs, and
//! [`Warnings`](super::Warnings) has them.
//!
//! The size of the diagnostics is limited for any text: the first faults are kept. Further errors are counted, and
//! further warnings are dropped. Sentences are clipped.

use crate::input::{clipped, printable};
use std::cell::{Cell, Ref, RefCell};
use strum::IntoStaticStr;

/// Largest number of faults that are kept. Further errors are counted, and further warnings are dropped.
const MOST_KEPT: usize = 100;

/// Largest number of warnings that are kept, so that there is always room for errors.
const MOST_WARNED: usize = MOST_KEPT / 2;

/// Largest number of characters of a sentence; longer ones quote too much of the file.
const MOST_CHARACTERS: usize = 1000;

/// Clips a sentence to [`MOST_CHARACTERS`].
fn fit(text: impl Into<String>) -> String {
    let text = text.into();
    match clipped(&text, MOST_CHARACTERS) {
        std::borrow::Cow::Borrowed(_) => text,
        std::borrow::Cow::Owned(cut) => cut,
    }
}

/// A range of bytes in one of the files of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Span {
    /// The file: index into [`ManifestErrors::sources`](super::ManifestErrors::sources).
    pub source: usize,
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

impl Span {
    /// The start of a file.
    pub(super) fn start_of(source: usize) -> Self {
        let (start, end) = (0, 0);
        Self { source, start, end }
    }
}

/// A text that was read: the manifest (first), another file, or a key that a command changes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// Path or name for messages.
    pub name: String,
    /// Text.
    pub text: String,
}

/// The kinds of fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, IntoStaticStr)]
#[strum(serialize_all = "kebab-case")]
pub enum DiagnosticKind {
    /// A file cannot be read.
    Unreadable,
    /// The text is not TOML.
    Syntax,
    /// A key or table occurs twice.
    DuplicateKey,
    /// A key or table that does not exist.
    UnknownKey,
    /// A key or table that must be given.
    MissingKey,
    /// A value of the wrong type.
    WrongType,
    /// Text that is not a quantity of the expected dimension.
    WrongUnit,
    /// A value outside its range, or not one of the choices.
    OutOfRange,
    /// A list without entries.
    Empty,
    /// A grid with more points than the program accepts.
    GridTooLarge,
    /// A name that is not an axis of the grid, or not a key that an axis may vary.
    UnknownAxis,
    /// Inconsistent values.
    Inconsistent,
    /// A key without effect because of another choice; a warning.
    NoEffect,
    /// A drive that runs but is unusual; a warning.
    Unusual,
    /// A feature that this version does not have.
    Unavailable,
}

impl DiagnosticKind {
    /// A short name for programs, `wrong-unit`.
    pub fn code(self) -> &'static str {
        self.into()
    }

    /// Whether the job runs in spite of such a fault.
    pub fn is_warning(self) -> bool {
        matches!(self, Self::NoEffect | Self::Unusual)
    }
}

/// One fault.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// Kind of fault.
    pub kind: DiagnosticKind,
    /// Place.
    pub span: Span,
    /// Line of its first byte, from 1; 0 if the file of its place could not be read.
    pub line: usize,
    /// Column of its first byte in characters, from 1; 0 if the file of its place could not be read.
    pub column: usize,
    /// The dotted key, `mesh.half_gap`; empty if the fault concerns no key.
    pub key: String,
    /// Message, one sentence.
    pub message: String,
    /// A few words that messages show below the place.
    pub label: String,
    /// Accepted values.
    pub accepted: Option<String>,
    /// The nearest known key, or the right table for the key.
    pub suggestion: Option<String>,
    /// Remedy.
    pub remedy: Option<String>,
    /// The values of the model keys in the first combination that has the fault. `None` if all checked combinations
    /// have it, or if it cannot depend on these values.
    pub at_point: Option<String>,
}

impl Diagnostic {
    /// A fault without the optional parts.
    pub(super) fn new(
        kind: DiagnosticKind,
        span: Span,
        key: &str,
        message: impl Into<String>,
    ) -> Self {
        Self {
            kind,
            span,
            line: 0,
            column: 0,
            key: fit(key),
            message: fit(message),
            label: String::new(),
            accepted: None,
            suggestion: None,
            remedy: None,
            at_point: None,
        }
    }

    pub(super) fn label(mut self, label: impl Into<String>) -> Self {
        self.label = fit(label);
        self
    }

    pub(super) fn accepted(mut self, accepted: impl Into<String>) -> Self {
        self.accepted = Some(fit(accepted));
        self
    }

    pub(super) fn suggestion(mut self, suggestion: Option<String>) -> Self {
        self.suggestion = suggestion.map(fit);
        self
    }

    pub(super) fn remedy(mut self, remedy: impl Into<String>) -> Self {
        self.remedy = Some(fit(remedy));
        self
    }

    pub(super) fn at_point(mut self, place: &str) -> Self {
        self.at_point = Some(fit(place));
        self
    }

    /// Records the fault.
    pub(super) fn report(self, issues: &Issues) {
        issues.push(self);
    }

    /// Records the fault and returns `None`.
    pub(super) fn fail<T>(self, issues: &Issues) -> Option<T> {
        issues.push(self);
        None
    }

    pub(super) fn notes(&self) -> Vec<String> {
        let note = |head: &str, text: &Option<String>| {
            let text = text.as_ref()?;
            Some(format!("{head}: {}", printable(text)))
        };
        [
            note("accepted", &self.accepted),
            note("nearest", &self.suggestion),
            note("remedy", &self.remedy),
            note("seen at", &self.at_point),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

/// The faults found so far, and the files that were read. All readers of a job share them.
#[derive(Debug, Default)]
pub(super) struct Issues {
    pub sources: RefCell<Vec<Source>>,
    /// The first faults.
    pub found: RefCell<Vec<Diagnostic>>,
    /// Number of further faults.
    pub more: Cell<usize>,
    /// First byte that was not read in the last file with a syntax error; `None` if all of it was read.
    pub unread: Cell<Option<usize>>,
}

impl Issues {
    /// Adds a file and returns its index.
    pub fn add_source(&self, name: String, text: String) -> usize {
        let mut sources = self.sources.borrow_mut();
        sources.push(Source { name, text });
        sources.len() - 1
    }

    /// The text of a file. No file may be added while the text is borrowed.
    pub fn text(&self, source: usize) -> Ref<'_, str> {
        Ref::map(self.sources.borrow(), |sources| {
            sources[source].text.as_str()
        })
    }

    pub fn push(&self, diagnostic: Diagnostic) {
        if !diagnostic.kind.is_warning() {
            return self.push_with(|| diagnostic);
        }
        let mut found = self.found.borrow_mut();
        let warnings = found.iter().filter(|known| known.kind.is_warning()).count();
        if found.len() < MOST_KEPT && warnings < MOST_WARNED {
            found.push(diagnostic);
        }
    }

    /// Records an error. Builds its sentences only if the error is kept.
    pub fn push_with(&self, diagnostic: impl FnOnce() -> Diagnostic) {
        if self.found.borrow().len() < MOST_KEPT {
            let diagnostic = diagnostic();
            self.found.borrow_mut().push(diagnostic);
        } else {
            self.more.set(self.more.get() + 1);
        }
    }

    /// Number of errors.
    pub fn count(&self) -> usize {
        let diagnostics = self.found.borrow();
        diagnostics.iter().filter(|d| !d.kind.is_warning()).count() + self.more.get()
    }
}
