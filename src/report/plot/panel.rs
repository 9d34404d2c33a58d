//! A panel: two axes with ticks and labels, and the marks drawn between them.

use super::axis::Axis;
use super::canvas::{Anchor, Canvas, Colour, FAINT, INK, Place, SOFT};
use super::draw::text_width;

/// Em size of tick texts \[px\].
pub(super) const TICK_SIZE: f64 = 12.5;
/// Em size of axis labels \[px\].
pub(super) const LABEL_SIZE: f64 = 14.0;

/// Where the label of an axis up has its baseline: left of the ticks, and in one line with
/// those of panels above and below as long as ticks are short.
pub(super) fn label_place(left: f64, widest_tick: f64) -> f64 {
    (left - 58.0)
        .min(left - 22.0 - widest_tick)
        .max(LABEL_SIZE + 4.0)
}

/// A rectangle of the canvas with an axis across and one up.
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
    pub fn x(&self, value: f64) -> f64 {
        self.left + self.across.fraction(value) * (self.right - self.left)
    }

    pub fn y(&self, value: f64) -> f64 {
        self.bottom - self.up.fraction(value) * (self.bottom - self.top)
    }

    pub fn at(&self, x: f64, y: f64) -> Place {
        [self.x(x), self.y(y)]
    }

    /// Grid lines, frame, ticks and labels. `named` panels carry the texts of the axis
    /// across; of panels above each other the lowest does.
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
        let middle = 0.5 * (self.top + self.bottom);
        let x = label_place(self.left, widest);
        let label = &self.up.label;
        canvas.text_upwards([x, middle], label, LABEL_SIZE, INK, Anchor::Middle);
        canvas.outline([self.left, self.top], [self.right, self.bottom], INK, 1.0);
    }

    /// Grid lines, ticks and, where `named`, texts of the axis across.
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
            canvas.text(at, &self.across.label, LABEL_SIZE, INK, Anchor::Middle);
        }
    }

    /// A dashed line at a value, with its name right of the panel.
    pub fn level(&self, canvas: &mut Canvas, value: f64, name: &str, colour: Colour) {
        let y = self.y(value);
        canvas.dashes([self.left, y], [self.right, y], colour, 1.2);
        let at = [self.right + 8.0, y + 0.35 * TICK_SIZE];
        canvas.text(at, name, TICK_SIZE, colour, Anchor::Start);
    }

    /// A note in the middle of a panel without data.
    pub fn note(&self, canvas: &mut Canvas, text: &str) {
        let at = [
            0.5 * (self.left + self.right),
            0.5 * (self.top + self.bottom),
        ];
        canvas.text(at, text, LABEL_SIZE, SOFT, Anchor::Middle);
    }
}
