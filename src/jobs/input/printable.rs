//! Makes texts and names of files safe to show: a terminal obeys control characters, and some characters reverse the
//! order of others.
//!
//! Escapes are those of JSON and TOML, so that a document stays valid.

use std::borrow::Cow;
use std::fmt::Write;

/// Whether [`printable`] keeps the character: a terminal shows it, or it is a line feed or a tab.
fn shows(c: char) -> bool {
    let turns =
        matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    matches!(c, '\n' | '\t') || !(c.is_control() || turns)
}

/// Writes control characters, and characters that reverse the order of others, as `\u001b`. Keeps line feeds and tabs.
pub fn printable(text: &str) -> Cow<'_, str> {
    if text.chars().all(shows) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if shows(c) {
            out.push(c)
        } else {
            // All escaped characters have at most four hexadecimal digits.
            _ = write!(out, "\\u{:04x}", u32::from(c))
        }
    }
    Cow::Owned(out)
}

/// As [`printable`], but keeps the colour codes `ESC [ ... m` that the program writes.
pub fn printable_but_colours(text: &str) -> Cow<'_, str> {
    if !text.contains('\u{1b}') {
        return printable(text);
    }
    let mut out = String::with_capacity(text.len());
    for (i, part) in text.split('\u{1b}').enumerate() {
        let inside = |c: char| c.is_ascii_digit() || c == ';';
        let colour = part.strip_prefix('[').and_then(|rest| {
            let end = rest.find(|c| !inside(c))?;
            rest[end..].starts_with('m').then_some(())
        });
        if i > 0 {
            out.push_str(if colour.is_some() { "\u{1b}" } else { "\\u001b" });
        }
        out += &printable(part);
    }
    Cow::Owned(out)
}

/// The text if it has at most `most` characters, otherwise its first `most` characters and `…`.
pub fn clipped(text: &str, most: usize) -> Cow<'_, str> {
    match text.char_indices().nth(most) {
        None => Cow::Borrowed(text),
        Some((end, _)) => Cow::Owned(format!("{}…", &text[..end])),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_terminal_obeys_is_written_out() {
        assert_eq!(printable("δ = 1 µm\n\tb"), "δ = 1 µm\n\tb");
        assert_eq!(
            printable("\u{1b}]0;pwn\u{7}\r\u{9b}31m\u{202e}x"),
            r"\u001b]0;pwn\u0007\u000d\u009b31m\u202ex"
        );
    }

    #[test]
    fn a_document_stays_one() {
        let name = "a\u{9b}b\u{202e}c\u{7f}";
        let document = serde_json::json!({ "name": name }).to_string();
        assert!(
            document.chars().any(|c| !shows(c)),
            "JSON leaves some as they are"
        );
        let shown = printable_but_colours(&document);
        assert!(shown.chars().all(shows), "{shown}");
        let read: serde_json::Value = serde_json::from_str(&shown).unwrap();
        assert_eq!(read["name"], name);
    }

    #[test]
    fn colours_of_our_own_stay() {
        let coloured = "\u{1b}[48;5;54m@\u{1b}[0m";
        assert_eq!(printable_but_colours(coloured), coloured);
        assert_eq!(
            printable_but_colours("\u{1b}[2J\u{1b}]0;x\u{7}"),
            r"\u001b[2J\u001b]0;x\u0007"
        );
    }

    #[test]
    fn long_text_is_cut_between_characters() {
        assert_eq!(clipped("µµµ", 3), "µµµ");
        assert_eq!(clipped("µµµµ", 3), "µµµ…");
    }
}
