//! A progress bar with text in one line of a terminal.

use std::io::IsTerminal;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use terminal_size::{Width, terminal_size_of};

/// Width of a terminal whose width is unknown \[columns\].
const USUAL_WIDTH: usize = 80;

/// Longest and shortest bar \[columns\].
const BAR: [usize; 2] = [30, 8];

/// A part of a line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// Text of the part.
    pub words: String,
    /// Priority: if there is no room for all parts, those with the largest rank are left out.
    pub rank: u8,
}

/// A line that `indicatif` draws and redraws in place on standard error, never wider than the terminal. It
/// draws nothing if standard error is no terminal, or if `quiet`. `template` ends in `{wide_msg}`:
/// `indicatif` cuts this message to the remaining width.
pub fn bar(length: Option<u64>, quiet: bool, template: &str) -> ProgressBar {
    let target = if quiet || !std::io::stderr().is_terminal() {
        ProgressDrawTarget::hidden()
    } else {
        ProgressDrawTarget::stderr()
    };
    let bar = ProgressBar::with_draw_target(length, target);
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar
}

/// Width of the terminal on standard error \[columns\].
pub fn width() -> usize {
    let size = terminal_size_of(std::io::stderr());
    size.map_or(USUAL_WIDTH, |(Width(columns), _)| usize::from(columns))
}

/// A bar that is filled to `share` (0 to 1), then as many of the parts as fit into `width` columns, separated
/// by commas. The bar takes the remaining columns, at most thirty; it is omitted if fewer than eight remain.
pub fn fitted(share: f64, parts: &[Part], width: usize) -> String {
    // The last column stays empty, because some terminals begin a new line after a character there.
    let room = width.saturating_sub(1);
    let mut ranks: Vec<u8> = parts.iter().map(|part| part.rank).collect();
    ranks.sort_unstable();
    let text = |most: u8| -> String {
        let words = parts.iter().filter(|part| part.rank <= most);
        words
            .map(|part| part.words.as_str())
            .collect::<Vec<_>>()
            .join(", ")
    };
    let length = |text: &str| text.chars().count();
    let fits = |most: &&u8| length(&text(**most)) <= room;
    let words = text(ranks.iter().rev().find(fits).copied().unwrap_or(0));
    let left = room.saturating_sub(length(&words) + 2).min(BAR[0]);
    if left < BAR[1] {
        return words;
    }
    let filled = (share.clamp(0.0, 1.0) * left as f64).round() as usize;
    format!(
        "{}{}  {words}",
        "█".repeat(filled),
        "░".repeat(left - filled)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parts() -> Vec<Part> {
        let parts = [
            ("123/1000 points", 0),
            ("5.00 points/s", 3),
            ("about 10 seconds left", 1),
            ("1 failed", 2),
            ("node 0: 3.9 of 4 workers busy", 4),
        ];
        let part = |(words, rank): (&str, u8)| Part {
            words: words.to_owned(),
            rank,
        };
        parts.into_iter().map(part).collect()
    }

    #[test]
    fn a_line_is_never_as_wide_as_the_terminal_and_keeps_what_tells_most() {
        for width in 16..=200 {
            let line = fitted(0.5, &parts(), width);
            assert!(line.chars().count() < width, "{width}: {line}");
            assert!(line.contains("123/1000 points"), "{width}: {line}");
        }
        assert_eq!(
            fitted(0.5, &parts(), 40),
            "123/1000 points, about 10 seconds left"
        );
        let wide = fitted(0.5, &parts(), 200);
        assert!(
            parts().iter().all(|part| wide.contains(&part.words)),
            "{wide}"
        );
        assert!(
            wide.starts_with(&format!("{}{}  1", "█".repeat(15), "░".repeat(15))),
            "{wide}"
        );
        // A NaN share fills nothing.
        assert!(fitted(f64::NAN, &parts(), 200).starts_with('░'));
    }
}
