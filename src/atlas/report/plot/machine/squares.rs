//! A coloured square with its value for every pair of two numbered kinds of things.

use super::super::axis::range;
use super::super::canvas::{Anchor, Canvas, INK};
use super::super::panel::{LABEL_SIZE, TICK_SIZE};
use super::super::ramp::{ink_on, viridis};

/// What the squares are of.
pub struct Squares<'a> {
    /// Numbers of the rows, and what they number.
    pub rows: (&'a [u32], &'a str),
    /// Numbers of the columns, and what they number.
    pub columns: (&'a [u32], &'a str),
    /// Factor from values to what is written, and its name with its unit.
    pub unit: (f64, &'a str),
}

impl Squares<'_> {
    /// Draws row, column and value of each.
    pub fn draw(&self, canvas: &mut Canvas, squares: Vec<(u32, u32, f64)>) {
        let (rows, columns) = (self.rows.0, self.columns.0);
        let (left, top) = (150.0, 110.0);
        let cell = (700.0 / columns.len() as f64).min(400.0 / rows.len() as f64);
        let [low, high] = range(squares.iter().map(|square| square.2));
        for (row, column, value) in squares {
            let (Some(i), Some(j)) = (
                rows.iter().position(|number| *number == row),
                columns.iter().position(|number| *number == column),
            ) else {
                continue;
            };
            let from = [left + cell * j as f64, top + cell * i as f64];
            let shade = viridis((value - low) / (high - low).max(f64::MIN_POSITIVE));
            canvas.rectangle(from, [from[0] + cell - 2.0, from[1] + cell - 2.0], shade);
            let written = self.unit.0 * value;
            let text = match written {
                written if written >= 100.0 && cell <= 40.0 => format!("{written:.0}"),
                written => format!("{written:.1}"),
            };
            if cell > 6.5 * text.len() as f64 {
                let at = [
                    from[0] + 0.5 * cell,
                    from[1] + 0.5 * cell + 0.35 * TICK_SIZE,
                ];
                canvas.text(at, &text, TICK_SIZE, ink_on(shade), Anchor::Middle);
            }
        }
        for (i, row) in rows.iter().enumerate() {
            let at = [
                left - 10.0,
                top + cell * (i as f64 + 0.5) + 0.35 * TICK_SIZE,
            ];
            let text = format!("{} {row}", self.rows.1);
            canvas.text(at, &text, TICK_SIZE, INK, Anchor::End);
        }
        for (j, column) in columns.iter().enumerate() {
            let at = [left + cell * (j as f64 + 0.5), top - 10.0];
            // Where squares are narrow, the numbers alone.
            let text = match cell > 90.0 {
                true => format!("{} {column}", self.columns.1),
                false => column.to_string(),
            };
            canvas.text(at, &text, TICK_SIZE, INK, Anchor::Middle);
        }
        let at = [left, top + cell * rows.len() as f64 + 30.0];
        canvas.text(at, self.unit.1, LABEL_SIZE, INK, Anchor::Start);
    }
}
