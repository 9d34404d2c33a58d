//! The styles that distinguish the curves of a picture: colour with marker, and dashes.

use crate::report::plot::canvas::{Canvas, Colour, INK, Place};
use crate::report::plot::categories::colour;
use crate::report::plot::marker::{Marker, OTHERS};
use crate::report::plot::ramp::viridis;

/// Largest number of curves that each have a separate colour.
const MOST_COLOURS: usize = 7;

/// How a curve is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Style {
    pub colour: Colour,
    pub marker: Marker,
    /// 0 for a full line, then 1, 2 and 3 for medium, short and long dashes, repeated.
    pub dashes: usize,
}

impl Style {
    /// Style of measured points.
    pub const MEASURED: Self = Self {
        colour: INK,
        marker: Marker::Disc,
        dashes: 0,
    };

    /// The style with the `place`-th of `count` colours and the `dashes`-th kind of line. If curves are
    /// `ordered` and too many for distinct colours, their colours go from dark to bright.
    pub fn new([place, count]: [usize; 2], ordered: bool, dashes: usize) -> Self {
        let ramp = ordered && count > MOST_COLOURS;
        Self {
            colour: if ramp {
                viridis(0.92 * place as f64 / (count - 1) as f64)
            } else {
                colour(place)
            },
            marker: OTHERS[place % OTHERS.len()],
            dashes,
        }
    }

    /// Draws the line through some places.
    pub fn line(&self, canvas: &mut Canvas, places: &[Place], width: f64) {
        const PATTERNS: [[f64; 2]; 3] = [[8.0, 4.0], [2.0, 3.0], [14.0, 3.0]];
        match self.dashes.checked_sub(1) {
            None => canvas.line(places, self.colour, width),
            Some(kind) => {
                // `Canvas::patterned` does not interrupt a line at places with NaN.
                let nowhere = |place: &Place| place.iter().any(|c| c.is_nan());
                for part in places.split(nowhere).filter(|part| part.len() > 1) {
                    canvas.patterned(part, PATTERNS[kind % PATTERNS.len()], self.colour, width);
                }
            }
        }
    }

    /// A tint of the colour, for error bars.
    pub fn tint(&self) -> Colour {
        let Colour(r, g, b) = self.colour;
        let half = |part: u8| 255 - (255 - part) / 2;
        Colour(half(r), half(g), half(b))
    }

    /// Draws the sample of the style in a legend, 26 pixels wide.
    pub fn sample(&self, canvas: &mut Canvas, [x, y]: Place, lined: bool) {
        if lined {
            self.line(canvas, &[[x, y], [x + 26.0, y]], 1.8);
        }
        self.mark(canvas, [x + 13.0, y], false);
    }

    /// Draws a marker, or a dot if `small`.
    pub fn mark(&self, canvas: &mut Canvas, at: Place, small: bool) {
        if small {
            canvas.disc(at, 1.3, self.colour)
        } else {
            self.marker.filled(canvas, at, self.colour)
        }
    }
}
