//! Reads the text of a manifest or of a file that it names: a regular file of limited size, in UTF-8.

use super::diagnostic::{Diagnostic, DiagnosticKind, Issues, Span};
use crate::input;
use std::io;
use std::path::Path;

/// Largest file that is read \[bytes\]: hundreds of times the longest list typed by hand, and checked in seconds.
const MOST_BYTES: u64 = 16 << 20;

/// Why could a text not be read?
pub(super) enum TextError {
    /// The file cannot be read.
    Unreadable(io::Error),
    /// The text is not UTF-8; reported at the place of the fault.
    Reported,
}

/// Reads a text and adds it to the sources. Messages call it `what`, such as `the manifest`.
pub(super) fn read(issues: &Issues, path: &Path, what: &str) -> Result<usize, TextError> {
    let bytes = input::read(path, MOST_BYTES).map_err(TextError::Unreadable)?;
    add(issues, path.display().to_string(), bytes, what)
}

/// The index of a text among the sources. Reports a file that cannot be read: `key` names it, and messages
/// call it `what` and `name`.
pub(super) fn or_report(
    issues: &Issues,
    source: Result<usize, TextError>,
    (key, what, name): (&str, &str, &str),
    remedy: &str,
) -> Option<usize> {
    source_or_report(source, issues, |error| {
        let message = format!("{what} `{name}` cannot be read: {error}");
        let span = Span::start_of(issues.add_source(name.to_owned(), String::new()));
        Diagnostic::new(DiagnosticKind::Unreadable, span, key, message).remedy(remedy)
    })
}

/// Reads the file that a key names, and adds it to the sources. Returns its index there, or reports why it has none.
pub(super) fn read_named(
    issues: &Issues,
    path: &Path,
    what: &str,
    (key, span): (&str, Span),
) -> Option<usize> {
    source_or_report(read(issues, path, what), issues, |error| {
        let message = format!("{what} `{}` cannot be read: {error}", path.display());
        Diagnostic::new(DiagnosticKind::Unreadable, span, key, message)
            .label("named here")
            .remedy("check the path; a relative path starts at the folder of the manifest")
    })
}

/// The index of a text, or `None` after the report of a fault. `fault` describes a file that cannot be read.
fn source_or_report(
    source: Result<usize, TextError>,
    issues: &Issues,
    fault: impl FnOnce(io::Error) -> Diagnostic,
) -> Option<usize> {
    match source {
        Ok(source) => Some(source),
        Err(TextError::Reported) => None,
        Err(TextError::Unreadable(error)) => fault(error).fail(issues),
    }
}

/// Reads a text from a stream to its end and adds it to the sources under a name.
pub(super) fn read_stream(
    issues: &Issues,
    stream: &mut dyn io::Read,
    name: &str,
    what: &str,
) -> Result<usize, TextError> {
    let bytes = input::read_stream(stream, MOST_BYTES).map_err(TextError::Unreadable)?;
    add(issues, name.to_owned(), bytes, what)
}

/// Adds bytes to the sources if they are a text.
fn add(issues: &Issues, name: String, bytes: Vec<u8>, what: &str) -> Result<usize, TextError> {
    match String::from_utf8(bytes) {
        Ok(text) => Ok(issues.add_source(name, text)),
        Err(error) => {
            let start = error.utf8_error().valid_up_to();
            let byte = error.as_bytes()[start];
            // The text is correct up to the fault, which the replacement character marks.
            let text = String::from_utf8_lossy(error.as_bytes()).into_owned();
            let end = start + char::REPLACEMENT_CHARACTER.len_utf8();
            let source = issues.add_source(name, text);
            let span = Span { source, start, end };
            let message =
                format!("{what} is not UTF-8: the byte 0x{byte:02x} does not begin a character");
            let remedy = match byte {
                0xb5 => {
                    "save the file as UTF-8; in Latin-1 `µ` is this byte: write \"um\" for \"µm\""
                }
                _ => "save the file as UTF-8",
            };
            Diagnostic::new(DiagnosticKind::Unreadable, span, "", message)
                .label("here")
                .remedy(remedy)
                .report(issues);
            Err(TextError::Reported)
        }
    }
}
