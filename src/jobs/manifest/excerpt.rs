//! The place of a fault for display: one line of the file, cut to a window around the place, with terminal control
//! characters escaped.

use super::diagnostic::{Diagnostic, Source};
use crate::input::printable;
use codespan_reporting::files::{Error, Files};
use std::ops::Range;

/// Largest length of a line that is shown completely \[characters\].
const MOST_COLUMNS: usize = 160;

/// Characters before the place in a longer line.
const BEFORE: usize = 40;

/// A line of a file.
#[derive(Debug)]
pub(super) struct Excerpt {
    name: String,
    text: String,
    line: usize,
    column: usize,
    /// Range of the place in `text` \[bytes\]. It ends with the shown part of the line if the place extends further.
    pub spot: Range<usize>,
}

impl Excerpt {
    /// The first line of a fault's span; a long line is cut to a window.
    pub fn of(source: &Source, diagnostic: &Diagnostic) -> Self {
        let (text, span) = (&source.text, diagnostic.span);
        let start = text.floor_char_boundary(span.start);
        let first = text[..start].rfind('\n').map_or(0, |newline| newline + 1);
        let last = text[start..].find('\n').map_or(text.len(), |n| start + n);
        let end = text.floor_char_boundary(span.end.clamp(start, last));
        let mut excerpt = Self {
            name: printable(&source.name).into_owned(),
            text: String::new(),
            line: diagnostic.line,
            column: diagnostic.column,
            spot: 0..0,
        };
        let long = text[first..last].chars().nth(MOST_COLUMNS).is_some();
        let (from, to) = if long {
            let before = text[first..start].char_indices().rev().take(BEFORE);
            let from = first + before.last().map_or(start - first, |(at, _)| at);
            let mut after = text[from..last].char_indices().skip(MOST_COLUMNS);
            (from, after.next().map_or(last, |(at, _)| from + at))
        } else {
            (first, last)
        };
        if from > first {
            excerpt.text.push('…');
        }
        excerpt.text += &printable(&text[from..start]);
        excerpt.spot.start = excerpt.text.len();
        excerpt.text += &printable(&text[start..end.min(to)]);
        excerpt.spot.end = excerpt.text.len();
        excerpt.text += &printable(&text[end.min(to)..to]);
        if to < last {
            excerpt.text.push('…');
        }
        excerpt
    }
}

impl<'a> Files<'a> for Excerpt {
    type FileId = ();
    type Name = &'a str;
    type Source = &'a str;

    fn name(&'a self, (): ()) -> Result<&'a str, Error> {
        Ok(&self.name)
    }

    fn source(&'a self, (): ()) -> Result<&'a str, Error> {
        Ok(&self.text)
    }

    fn line_index(&'a self, (): (), _byte: usize) -> Result<usize, Error> {
        Ok(0)
    }

    fn line_number(&'a self, (): (), _index: usize) -> Result<usize, Error> {
        Ok(self.line)
    }

    fn column_number(&'a self, (): (), _index: usize, _byte: usize) -> Result<usize, Error> {
        Ok(self.column)
    }

    fn line_range(&'a self, (): (), _index: usize) -> Result<Range<usize>, Error> {
        Ok(0..self.text.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::manifest::diagnostic::{DiagnosticKind, Span};

    fn of(text: &str, start: usize, end: usize) -> (String, String) {
        let source = Source {
            name: "m.toml".to_owned(),
            text: text.to_owned(),
        };
        let span = Span {
            source: 0,
            start,
            end,
        };
        let fault = Diagnostic::new(DiagnosticKind::Syntax, span, "", String::new());
        let excerpt = Excerpt::of(&source, &fault);
        let spot = excerpt.text[excerpt.spot.clone()].to_owned();
        (excerpt.text, spot)
    }

    #[test]
    fn a_short_line_is_shown_whole() {
        let wanted = |text: &str, spot: &str| (text.to_owned(), spot.to_owned());
        assert_eq!(of("a\nbcd\ne", 3, 4), wanted("bcd", "c"));
        // A place over several lines ends with the first line.
        assert_eq!(of("a\nbcd\ne", 3, 7), wanted("bcd", "cd"));
        assert_eq!(of("a\n", 2, 2), wanted("", ""));
        assert_eq!(
            of("x \u{1b}[2J y", 2, 3),
            wanted("x \\u001b[2J y", "\\u001b")
        );
    }

    #[test]
    fn of_a_long_line_a_window_about_the_spot_is_shown() {
        let text = format!("{}!{}", "µ".repeat(5000), "ß".repeat(5000));
        let (shown, spot) = of(&text, 10_000, 10_001);
        assert_eq!(spot, "!");
        assert_eq!(shown.chars().count(), MOST_COLUMNS + 2);
        assert_eq!(shown.chars().position(|c| c == '!'), Some(BEFORE + 1));
        let (shown, spot) = of(&text, 0, text.len());
        assert_eq!((shown.chars().count(), spot.chars().count()), (161, 160));
    }
}
