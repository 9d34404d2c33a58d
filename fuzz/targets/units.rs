//! Quantities: numbers with units, and units alone.

use super::right;
use gearatlas::units::{Dimension, conversion, parse, parse_any, split};

/// One quantity per line; the lines are units as well.
pub fn units(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    let lines: Vec<&str> = text.lines().take(20).collect();
    for line in &lines {
        quantity(line);
    }
    for pair in lines.windows(2) {
        let ratio = conversion(pair[0], pair[1]);
        right(ratio.is_none_or(|r| r.is_finite() && r > 0.0), || {
            format!("{pair:?}: {ratio:?}")
        });
        let back = conversion(pair[1], pair[0]);
        // The inverse of a ratio near the end of the range of doubles may exceed it.
        if let [Some(there), Some(back)] = [ratio, back] {
            right((there * back - 1.0).abs() < 1e-14, || {
                format!("{pair:?}: {there} {back}")
            });
        }
    }
}

/// Both parsers agree on a text, and a quantity can be written and read again.
fn quantity(text: &str) {
    let any = parse_any(text);
    let mut accepted = 0;
    for dimension in Dimension::with_text_form() {
        let Ok(value) = parse(text, dimension) else {
            continue;
        };
        accepted += 1;
        right(value.is_finite(), || format!("{text:?} is {value}"));
        right(any == Ok((value, dimension)), || {
            format!("{text:?}: {any:?}")
        });
        if dimension != Dimension::Ratio {
            let written = format!("{value:e} {}", dimension.unit());
            let again = parse(&written, dimension);
            right(again == Ok(value), || {
                format!("{text:?}, {written:?}: {again:?}")
            });
        }
    }
    right(accepted == usize::from(any.is_ok()), || {
        format!("{text:?} is of {accepted} dimensions")
    });
    if let Some((number, _)) = split(text) {
        right(number.is_finite(), || {
            format!("{text:?} begins with {number}")
        });
    }
}
