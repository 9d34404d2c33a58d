//! Markers, and the symbol, colour and name of each kind of bifurcation, the same in all pictures.

use super::canvas::{Canvas, Colour, INK, Place, WHITE, WIDTH};
use super::lettering::wrapped;
use super::panel::TICK_SIZE;

/// The shape of a marker.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Marker {
    Disc,
    Square,
    Diamond,
    Triangle,
    Inverted,
    Plus,
    Cross,
    Dot,
    Bar,
}

/// Filled markers that readers can distinguish, for curves and symbols that have no fixed marker.
pub(super) const OTHERS: [Marker; 5] = [
    Marker::Disc,
    Marker::Square,
    Marker::Diamond,
    Marker::Triangle,
    Marker::Inverted,
];

impl Marker {
    /// The marker of a kind of bifurcation.
    pub fn of(kind: &str) -> Self {
        match kind {
            "fold" => Self::Disc,
            "period_doubling" => Self::Square,
            "torus" => Self::Triangle,
            "merging" => Self::Diamond,
            "branch_point" => Self::Plus,
            "graze" => Self::Cross,
            "sequence" | "jump" => Self::Dot,
            _ => Self::Bar,
        }
    }

    /// Draws the marker at its usual size; closed shapes are filled with white.
    pub fn draw(self, canvas: &mut Canvas, at: Place) {
        self.filled(canvas, at, WHITE);
    }

    /// Draws the marker at its usual size; closed shapes have the colour `fill` and a dark edge.
    pub fn filled(self, canvas: &mut Canvas, at: Place, fill: Colour) {
        self.sized(canvas, at, fill, 1.0);
    }

    /// Draws the marker with a fill, scaled by a factor.
    pub fn sized(self, canvas: &mut Canvas, [x, y]: Place, fill: Colour, factor: f64) {
        let corners: &[Place] = match self {
            Self::Square => &[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]],
            Self::Diamond => &[[0.0, -1.3], [1.3, 0.0], [0.0, 1.3], [-1.3, 0.0]],
            Self::Triangle => &[[0.0, -1.2], [1.15, 0.8], [-1.15, 0.8]],
            Self::Inverted => &[[0.0, 1.2], [1.15, -0.8], [-1.15, -0.8]],
            _ => &[],
        };
        let shape = |size: f64| -> Vec<Place> {
            let corners = corners.iter();
            corners.map(|[a, b]| [x + size * a, y + size * b]).collect()
        };
        let mut strokes = |ends: &[[Place; 2]], width: f64| {
            for [from, to] in ends {
                let [from, to] = [from, to].map(|[a, b]| [x + factor * a, y + factor * b]);
                canvas.line(&[from, to], INK, width);
            }
        };
        // The edge must not cover the whole colour of a small symbol.
        let edge = 1.3 * factor.min(1.0);
        match self {
            Self::Disc => {
                canvas.disc([x, y], 4.6 * factor, INK);
                canvas.disc([x, y], 4.6 * factor - edge, fill);
            }
            Self::Dot => canvas.disc([x, y], 2.2 * factor, INK),
            Self::Cross => strokes(
                &[[[-3.0, -3.0], [3.0, 3.0]], [[-3.0, 3.0], [3.0, -3.0]]],
                1.2,
            ),
            Self::Plus => strokes(&[[[-4.5, 0.0], [4.5, 0.0]], [[0.0, -4.5], [0.0, 4.5]]], 1.8),
            Self::Bar => strokes(&[[[0.0, -6.0], [0.0, 6.0]]], 1.8),
            _ => {
                canvas.polygon(&shape(4.8 * factor), INK);
                canvas.polygon(&shape(4.8 * factor - 1.3 * edge), fill);
            }
        }
    }
}

/// The colour of the curve of a kind of bifurcation, from Okabe and Ito's palette, which colour-blind readers
/// can distinguish.
pub(in crate::report) fn colour(kind: &str) -> Colour {
    match kind {
        "fold" => Colour(0xd5, 0x5e, 0x00),
        "period_doubling" => Colour(0x00, 0x72, 0xb2),
        "torus" => Colour(0x00, 0x9e, 0x73),
        "graze" => Colour(0xcc, 0x79, 0xa7),
        _ => INK,
    }
}

/// The name of a kind of bifurcation, for example `period doubling` or `onset of rattle`.
pub(in crate::report) fn name(kind: &str) -> String {
    match kind {
        "onset" => "onset of rattle".to_owned(),
        kind => kind.replace('_', " "),
    }
}

/// Width of the sample of an entry of a key \[px\].
pub(super) const SAMPLE: f64 = 22.0;

/// Writes the text of an entry of a key to the right of its sample, in as many lines as necessary. Returns
/// the height of the entry \[px\].
pub(super) fn entry(canvas: &mut Canvas, [x, y]: Place, text: &str) -> f64 {
    const PITCH: f64 = 22.0;
    const LINE: f64 = 15.0;
    let left = x + SAMPLE + 8.0;
    let lines = wrapped(text, TICK_SIZE, WIDTH - 6.0 - left);
    for (line, words) in lines.iter().enumerate() {
        canvas.label([left, y + 4.5 + LINE * line as f64], words, INK);
    }
    PITCH + LINE * lines.len().saturating_sub(1) as f64
}
