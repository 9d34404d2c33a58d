//! The colour ramp for magnitudes: viridis (van der Walt and Smith, 2015; CC0). It goes from dark to bright,
//! so that the order is visible to colour-blind readers and in grey prints.

use super::axis::Axis;
use super::canvas::{Anchor, Canvas, Colour, INK, WHITE};
use super::panel::{LABEL_SIZE, TICK_SIZE};

/// Viridis at nine evenly spaced fractions, dark to bright.
pub(in crate::report) const VIRIDIS: [Colour; 9] = [
    Colour(0x44, 0x01, 0x54),
    Colour(0x47, 0x2d, 0x7b),
    Colour(0x3b, 0x52, 0x8b),
    Colour(0x2c, 0x72, 0x8e),
    Colour(0x21, 0x91, 0x8c),
    Colour(0x28, 0xae, 0x80),
    Colour(0x5e, 0xc9, 0x62),
    Colour(0xad, 0xdc, 0x30),
    Colour(0xfd, 0xe7, 0x25),
];

/// The colour of the ramp at a fraction, which is clamped to 0 to 1.
pub(super) fn viridis(fraction: f64) -> Colour {
    let position = fraction.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let step = (position as usize).min(VIRIDIS.len() - 2);
    let (a, b) = (VIRIDIS[step], VIRIDIS[step + 1]);
    let mix = |a: u8, b: u8| {
        let part = position - step as f64;
        (f64::from(a) + part * (f64::from(b) - f64::from(a))).round() as u8
    };
    Colour(mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2))
}

/// Text colour that is legible on a background colour.
pub(super) fn ink_on(colour: Colour) -> Colour {
    let Colour(r, g, b) = colour;
    // Luma of ITU-R BT.601.
    let luma = 0.299 * f64::from(r) + 0.587 * f64::from(g) + 0.114 * f64::from(b);
    if luma > 140.0 { INK } else { WHITE }
}

/// Draws a colour bar from `top` to `bottom`, with ticks and the label of the axis on its right.
pub(super) fn bar(canvas: &mut Canvas, x: f64, [top, bottom]: [f64; 2], axis: &Axis) {
    const WIDTH: f64 = 18.0;
    const STEPS: usize = 64;
    for step in 0..STEPS {
        // Each step overlaps the one below it, because abutting edges show as seams in some viewers.
        let y = |i: usize| bottom - (bottom - top) * i as f64 / STEPS as f64;
        let colour = viridis((step as f64 + 0.5) / STEPS as f64);
        let low = (y(step) + 1.0).min(bottom);
        canvas.rectangle([x, y(step + 1)], [x + WIDTH, low], colour);
    }
    canvas.outline([x, top], [x + WIDTH, bottom], INK, 1.0);
    for (value, text) in axis.ticks(((bottom - top) / 45.0) as usize) {
        let y = bottom - axis.fraction(value) * (bottom - top);
        canvas.line(&[[x + WIDTH, y], [x + WIDTH + 4.0, y]], INK, 1.0);
        canvas.label([x + WIDTH + 8.0, y + 0.35 * TICK_SIZE], &text, INK);
    }
    let at = [x + WIDTH + 62.0, 0.5 * (top + bottom)];
    canvas.text_upwards(at, &axis.label, LABEL_SIZE, INK, Anchor::Middle);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ramp_grows_brighter_from_end_to_end() {
        let luma = |f: f64| {
            let Colour(r, g, b) = viridis(f);
            0.299 * f64::from(r) + 0.587 * f64::from(g) + 0.114 * f64::from(b)
        };
        let steps: Vec<f64> = (0..=100).map(|i| luma(f64::from(i) / 100.0)).collect();
        assert!(steps.windows(2).all(|pair| pair[0] <= pair[1] + 1.0));
        assert_eq!(viridis(-1.0), VIRIDIS[0]);
        assert_eq!(viridis(2.0), VIRIDIS[8]);
    }
}
