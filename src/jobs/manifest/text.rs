//! The text of a manifest or of a file that it names: of a regular file, in UTF-8, and not endless.

use super::diagnostic::{Diagnostic, DiagnosticKind, Issues, Span};
use crate::input;
use std::io;
use std::path::Path;

/// Largest file read \[bytes\]: hundreds of times the longest list that anybody has typed, and
/// judged in seconds.
const MOST_BYTES: u64 = 16 << 20;

/// Why a text cannot be had.
pub(super) enum NoText {
    /// Its file cannot be read.
    Unreadable(io::Error),
    /// It is not UTF-8; reported at the spot.
    Reported,
}

/// Reads a text and adds it to the sources. `what` names it in a sentence, `the manifest`.
pub(super) fn read(issues: &mut Issues, path: &Path, what: &str) -> Result<usize, NoText> {
    let bytes = input::read(path, MOST_BYTES).map_err(NoText::Unreadable)?;
    add(issues, path.display().to_string(), bytes, what)
}

/// Reads the file that a key names, and adds it to the sources; reported where it cannot be read.
pub(super) fn read_named(
    issues: &mut Issues,
    path: &Path,
    what: &str,
    (key, span): (&str, Span),
) -> Option<usize> {
    let error = match read(issues, path, what) {
        Ok(source) => return Some(source),
        Err(NoText::Reported) => return None,
        Err(NoText::Unreadable(error)) => error,
    };
    issues.push(
        Diagnostic::new(
            DiagnosticKind::Unreadable,
            span,
            key,
            format!("{what} `{}` cannot be read: {error}", path.display()),
        )
        .label("named here")
        .remedy("check the path; a relative path starts at the folder of the manifest"),
    );
    None
}

/// Reads a text from a stream to its end and adds it to the sources under a name.
pub(super) fn read_stream(
    issues: &mut Issues,
    stream: &mut dyn io::Read,
    name: &str,
    what: &str,
) -> Result<usize, NoText> {
    let bytes = input::read_stream(stream, MOST_BYTES).map_err(NoText::Unreadable)?;
    add(issues, name.to_owned(), bytes, what)
}

/// Adds a text to the sources where it is one.
fn add(issues: &mut Issues, name: String, bytes: Vec<u8>, what: &str) -> Result<usize, NoText> {
    match String::from_utf8(bytes) {
        Ok(text) => Ok(issues.add_source(name, text)),
        Err(error) => {
            let start = error.utf8_error().valid_up_to();
            let byte = error.as_bytes()[start];
            // Up to the spot it is the text of the file; the spot is where the mark stands.
            let text = String::from_utf8_lossy(error.as_bytes()).into_owned();
            let end = start + char::REPLACEMENT_CHARACTER.len_utf8();
            let source = issues.add_source(name, text);
            let span = Span { source, start, end };
            let message =
                format!("{what} is not UTF-8: the byte 0x{byte:02x} does not begin a character");
            issues.push(
                Diagnostic::new(DiagnosticKind::Unreadable, span, "", message)
                    .label("here")
                    .remedy("save the file as UTF-8; in Latin-1 `µ` is this byte: write \"um\" for \"µm\""),
            );
            Err(NoText::Reported)
        }
    }
}
