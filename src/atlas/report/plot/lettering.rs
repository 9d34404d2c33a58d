//! Widths of texts, and the fitting of texts into a limited width.

use std::sync::OnceLock;

use plotters::style::{FontDesc, FontFamily, FontStyle, register_font};

/// DejaVu Sans 2.37, reduced to Latin, Greek and symbols; its licence is in the same folder.
static FONT: &[u8] = include_bytes!("fonts/DejaVuSans-subset.ttf");
/// Font families for SVG viewers. Verdana has the widths of DejaVu Sans.
pub(super) const FAMILY: &str = "DejaVu Sans, Verdana, sans-serif";
/// Ascent plus descent of DejaVu Sans, divided by its em (1901 + 483 of 2048 units). The bitmap backend takes
/// this height as the size of a font.
pub(super) const LINE_PER_EM: f64 = 2384.0 / 2048.0;

/// Registers the font once; returns whether this worked.
pub(super) fn font_is_ready() -> bool {
    static FONT_REGISTERED: OnceLock<bool> = OnceLock::new();
    *FONT_REGISTERED.get_or_init(|| register_font(FAMILY, FontStyle::Normal, FONT).is_ok())
}

/// Width of a text \[px\].
pub(super) fn text_width(text: &str, size: f64) -> f64 {
    // The text is measured at a large size, because the backend returns whole pixels.
    const LARGE: f64 = 100.0;
    let font = FontDesc::new(
        FontFamily::Name(FAMILY),
        LARGE * LINE_PER_EM,
        FontStyle::Normal,
    );
    let measured = if font_is_ready() { font.box_size(text).ok() } else { None };
    // If the font cannot be read: letters are 0.6 em wide on average.
    let width = measured.map_or_else(
        || 0.6 * LARGE * text.chars().count() as f64,
        |(width, _)| f64::from(width),
    );
    width * size / LARGE
}

/// A text in one line no wider than `width` \[px\], and its em size. The size is reduced, but not below `least`; if
/// this is not enough, the text is cut.
pub(super) fn fitted(text: &str, size: f64, least: f64, width: f64) -> (String, f64) {
    let wide = text_width(text, size);
    if wide <= width {
        return (text.to_owned(), size);
    }
    let fitting = size * width / wide;
    if fitting >= least {
        return (text.to_owned(), fitting);
    }
    (cut(text, least, width), least)
}

/// A text in lines no wider than `width` \[px\], broken between words; a wider word is cut.
pub(super) fn wrapped(text: &str, size: f64, width: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ').filter(|word| !word.is_empty()) {
        match lines.last_mut() {
            Some(line) if text_width(&format!("{line} {word}"), size) <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(cut(word, size, width)),
        }
    }
    lines
}

/// As many characters as fit, with an ellipsis if some do not.
fn cut(text: &str, size: f64, width: f64) -> String {
    if text_width(text, size) <= width {
        return text.to_owned();
    }
    // Begin with the first 300 characters, because each step of the loop measures the text.
    let mut kept: String = text.chars().take(300).collect();
    while kept.pop().is_some() {
        let shown = format!("{}…", kept.trim_end());
        if text_width(&shown, size) <= width {
            return shown;
        }
    }
    "…".to_owned()
}

/// Heights near the `wanted` ones, in the same order. They are at least `distance` apart, and between `top` and
/// `bottom` if there is room.
pub(super) fn spread_out(wanted: &[f64], distance: f64, [top, bottom]: [f64; 2]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..wanted.len()).collect();
    order.sort_by(|&a, &b| wanted[a].total_cmp(&wanted[b]));
    let mut places = wanted.to_vec();
    let mut least = top;
    for &i in &order {
        places[i] = places[i].max(least);
        least = places[i] + distance;
    }
    let mut most = bottom;
    for &i in order.iter().rev() {
        places[i] = places[i].min(most);
        most = places[i] - distance;
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_measured_with_the_built_in_font() {
        // Advance widths of DejaVu Sans: 1303 of 2048 units for a digit, 569 for an i.
        let width = text_width("0000000000", 20.0);
        assert!((width - 200.0 * 1303.0 / 2048.0).abs() < 0.5, "{width}");
        let narrow = text_width("iiiiiiiiii", 20.0);
        assert!((narrow - 200.0 * 569.0 / 2048.0).abs() < 0.5, "{narrow}");
    }

    #[test]
    fn a_line_is_made_smaller_before_it_is_cut() {
        let text = "rate of the deflection";
        let wide = text_width(text, 14.0);
        assert_eq!(fitted(text, 14.0, 9.0, wide + 1.0), (text.into(), 14.0));
        let (shown, size) = fitted(text, 14.0, 9.0, 0.8 * wide);
        assert_eq!(shown, text);
        assert!((size - 0.8 * 14.0).abs() < 1e-9, "{size}");
        let (shown, size) = fitted(text, 14.0, 9.0, 0.4 * wide);
        assert_eq!(size, 9.0);
        assert!(shown.ends_with('…') && text_width(&shown, size) <= 0.4 * wide);
    }

    #[test]
    fn lines_break_between_words_and_lose_none() {
        let text = "steady contact → period 2 → quasi-periodic";
        let lines = wrapped(text, 12.0, 120.0);
        assert!(lines.len() > 1, "{lines:?}");
        assert!(lines.iter().all(|line| text_width(line, 12.0) <= 120.0));
        assert_eq!(lines.join(" "), text);
        let long = wrapped("mesh.mean_stiffness_of_something", 12.0, 60.0);
        assert!(matches!(&long[..], [one] if one.ends_with('…')), "{long:?}");
    }

    #[test]
    fn heights_are_apart_and_within_their_bounds() {
        assert_eq!(spread_out(&[10.0, 90.0], 16.0, [0.0, 100.0]), [10.0, 90.0]);
        for wanted in [[50.0; 4], [99.0, 98.0, 97.0, 3.0], [0.0, 0.0, 100.0, 100.0]] {
            let places = spread_out(&wanted, 16.0, [0.0, 100.0]);
            for i in 0..4 {
                assert!((0.0..=100.0).contains(&places[i]), "{places:?}");
                for j in 0..i {
                    assert!((places[i] - places[j]).abs() >= 16.0, "{places:?}");
                }
            }
        }
    }
}
