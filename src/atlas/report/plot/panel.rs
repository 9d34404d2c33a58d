//! A panel: a rectangle of a picture with two axes, their ticks and their labels.

use super::axis::Axis;
use super::canvas::{Anchor, Canvas, Colour, FAINT, INK, Place, SOFT};
use super::lettering::{fitted, spread_out, text_width, wrapped};

/// Left edge, top and bottom of the panel in most pictures \[px\].
pub(super) const LEFT: f64 = 92.0;
pub(super) const TOP: f64 = 72.0;
pub(super) const BOTTOM: f64 = 526.0;
/// Em size of tick texts \[px\].
pub(super) const TICK_SIZE: f64 = 12.5;
/// Em size of axis labels \[px\].
pub(super) const LABEL_SIZE: f64 = 14.0;

impl Canvas {
    /// Adds a text of the size of tick texts, starting at a place.
    pub fn label(&mut self, at: Place, text: &str, colour: Colour) {
        self.text(at, text, TICK_SIZE, colour, Anchor::Start);
    }
}

/// Horizontal position of the label of a vertical axis, left of the tick texts \[px\]. It is the same for
/// panels above each other if their tick texts are short.
pub(super) fn label_place(left: f64, widest_tick: f64) -> f64 {
    (left - 58.0)
        .min(left - 22.0 - widest_tick)
        .max(LABEL_SIZE + 4.0)
}

/// A rectangle of the canvas with a horizontal and a vertical axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Panel {
    pub left: f64,
    pub right: f64,
    pub top: f64,
    pub bottom: f64,
    pub across: Axis,
    pub up: Axis,
}

impl Panel {
    /// A panel between edges on the canvas \[px\]: `[left, right]` and `[top, bottom]`.
    pub fn new([left, right]: [f64; 2], [top, bottom]: [f64; 2], across: Axis, up: Axis) -> Self {
        Self {
            left,
            right,
            top,
            bottom,
            across,
            up,
        }
    }

    pub fn x(&self, value: f64) -> f64 {
        self.left + self.across.fraction(value) * (self.right - self.left)
    }

    pub fn y(&self, value: f64) -> f64 {
        self.bottom - self.up.fraction(value) * (self.bottom - self.top)
    }

    pub fn at(&self, x: f64, y: f64) -> Place {
        [self.x(x), self.y(y)]
    }

    /// Draws grid lines, frame, ticks and labels. The texts of the horizontal axis are drawn only if `named`.
    /// If panels are above each other, only the lowest is `named`.
    pub fn frame(&self, canvas: &mut Canvas, named: bool) {
        self.ticks_across(canvas, named);
        let ticks = self.up.ticks(((self.bottom - self.top) / 40.0) as usize);
        let mut widest = 0.0_f64;
        for (value, text) in &ticks {
            let y = self.y(*value);
            canvas.line(&[[self.left, y], [self.right, y]], FAINT, 1.0);
            canvas.line(&[[self.left - 5.0, y], [self.left, y]], INK, 1.0);
            let at = [self.left - 9.0, y + 0.35 * TICK_SIZE];
            canvas.text(at, text, TICK_SIZE, INK, Anchor::End);
            widest = widest.max(text_width(text, TICK_SIZE));
        }
        self.label_up(canvas, label_place(self.left, widest));
        self.outline(canvas);
    }

    /// Draws the edges of the panel.
    pub fn outline(&self, canvas: &mut Canvas) {
        canvas.outline([self.left, self.top], [self.right, self.bottom], INK, 1.0);
    }

    /// Draws the label of the vertical axis, with its baseline at `x`. A label that is longer than the panel is high
    /// has two lines if there is room, else smaller letters.
    fn label_up(&self, canvas: &mut Canvas, x: f64) {
        const LINE: f64 = 16.0;
        let (middle, length) = (
            0.5 * (self.top + self.bottom),
            self.bottom - self.top + 12.0,
        );
        let lines = wrapped(&self.up.label, LABEL_SIZE, length);
        let two = lines.len() == 2 && x - LINE > LABEL_SIZE;
        let lines: Vec<(String, f64)> = if two {
            lines.into_iter().map(|line| (line, LABEL_SIZE)).collect()
        } else {
            vec![fitted(&self.up.label, LABEL_SIZE, 8.0, length)]
        };
        for (above, (words, size)) in lines.iter().rev().enumerate() {
            let at = [x - LINE * above as f64, middle];
            canvas.text_upwards(at, words, *size, INK, Anchor::Middle);
        }
    }

    /// Draws grid lines and ticks of the horizontal axis and, if `named`, its texts.
    pub fn ticks_across(&self, canvas: &mut Canvas, named: bool) {
        for (value, text) in self
            .across
            .ticks(((self.right - self.left) / 60.0) as usize)
        {
            let x = self.x(value);
            canvas.line(&[[x, self.top], [x, self.bottom]], FAINT, 1.0);
            canvas.line(&[[x, self.bottom], [x, self.bottom + 5.0]], INK, 1.0);
            if named {
                let at = [x, self.bottom + 9.0 + TICK_SIZE];
                canvas.text(at, &text, TICK_SIZE, INK, Anchor::Middle);
            }
        }
        if named {
            let at = [0.5 * (self.left + self.right), self.bottom + 46.0];
            let (label, size) = fitted(&self.across.label, LABEL_SIZE, 8.0, self.right - self.left);
            canvas.text(at, &label, size, INK, Anchor::Middle);
        }
    }

    /// Draws dashed lines at values of the vertical axis, with their names to the right of the panel, without
    /// overlap.
    pub fn levels(&self, canvas: &mut Canvas, levels: &[(f64, &str)], colour: Colour) {
        let wanted: Vec<f64> = levels.iter().map(|(value, _)| self.y(*value)).collect();
        let places = spread_out(&wanted, 1.3 * TICK_SIZE, [self.top, self.bottom]);
        for ((y, place), (_, name)) in wanted.into_iter().zip(places).zip(levels) {
            canvas.dashes([self.left, y], [self.right, y], colour, 1.2);
            canvas.label([self.right + 8.0, place + 0.35 * TICK_SIZE], name, colour);
        }
    }

    /// Writes a note in the middle of a panel without data.
    pub fn note(&self, canvas: &mut Canvas, text: &str) {
        let at = [
            0.5 * (self.left + self.right),
            0.5 * (self.top + self.bottom),
        ];
        canvas.text(at, text, LABEL_SIZE, SOFT, Anchor::Middle);
    }
}
