//! Readable syntax errors. The parser continues after an error and so reports consequences of it. Of a line, only the
//! first error and all duplicate keys are kept. Nothing is kept after an unclosed bracket.

use super::diagnostic::{Diagnostic, DiagnosticKind, Issues, Span};
use toml::de::Error;

/// Records the syntax errors of a file.
pub(super) fn report(source: usize, text: &str, errors: &[Error], issues: &Issues) {
    let mut last_line = None;
    let newlines: Vec<usize> = text.match_indices('\n').map(|(at, _)| at).collect();
    for error in errors {
        let range = error.span().unwrap_or(0..0);
        let span = Span {
            source,
            start: range.start,
            end: range.end,
        };
        let spot = text.get(range.clone()).unwrap_or_default();
        if error.message() == "duplicate key" {
            issues.push_with(|| duplicate(span, spot));
            continue;
        }
        let line = newlines.partition_point(|&newline| newline < range.start);
        if last_line.replace(line) == Some(line) {
            continue;
        }
        let line_start = line.checked_sub(1).map_or(0, |before| newlines[before] + 1);
        let before = text.get(line_start..range.start).unwrap_or_default();
        let begins_line = before.trim().is_empty();
        let unclosed = begins_line && error.message().starts_with("missing comma");
        issues.push_with(|| {
            let (message, remedy) = words(error.message(), spot, unclosed);
            let message = format!("not valid TOML: {message}");
            Diagnostic::new(DiagnosticKind::Syntax, span, "", message)
                .label("here")
                .remedy(remedy)
        });
        if unclosed {
            return;
        }
    }
}

fn duplicate(span: Span, key: &str) -> Diagnostic {
    Diagnostic::new(
        DiagnosticKind::DuplicateKey,
        span,
        key,
        format!("`{key}` is given twice"),
    )
    .label("second time")
    .remedy("keep one of the two")
}

/// The fault and the remedy, in the words of a user rather than of the grammar.
fn words(detail: &str, spot: &str, unclosed: bool) -> (String, String) {
    let (message, remedy) = if unclosed {
        (
            "a list or table that begins above this line is not closed",
            "close it with ] or } before this line, or add the missing comma",
        )
    } else if detail.starts_with("string values must be quoted") && spot.is_empty() {
        (
            "a value is missing after `=`",
            "give a value, or remove the line",
        )
    } else if detail.starts_with("string values must be quoted") {
        let quoted = spot.trim();
        return (
            "texts must be in quotes".to_owned(),
            format!("write \"{quoted}\""),
        );
    } else if detail.starts_with("invalid basic string, expected `\"`") {
        (
            "a quoted text is not closed",
            "end it with \" on the same line",
        )
    } else {
        return (
            detail.to_owned(),
            "a line is `key = value` or `[table]`; a value is a number, a \"text\", true, false, [a, list] or { a = \"table\" }"
                .to_owned(),
        );
    };
    (message.to_owned(), remedy.to_owned())
}
