//! A grid of points as a grid of cells: the layout that the maps share.

use std::collections::BTreeMap;

use super::axis::{Axis, range};
use super::canvas::{Anchor, Canvas, Colour, FAINT, INK, SOFT};
use super::draw::text_width;
use super::panel::{LABEL_SIZE, TICK_SIZE, label_place};
use super::ramp::ink_on;
use super::results::{Results, Slice};
use crate::report::refined::Plane;
use crate::report::{Axis as GridAxis, PointSummary};
use crate::store::RefinedColumns;

const LEFT: f64 = 92.0;
const RIGHT: f64 = 735.0;
const TOP: f64 = 72.0;
const BOTTOM: f64 = 526.0;
/// Where keys and colour bars start.
pub(super) const MARGIN: f64 = RIGHT + 24.0;
/// Most cells of a map.
const MOST_CELLS: usize = 1 << 20;
pub(super) const HEIGHT: [f64; 2] = [TOP, BOTTOM];

/// The axes of a map: the first two that vary.
pub(super) struct Cells<'a> {
    across: (usize, &'a GridAxis),
    up: (usize, &'a GridAxis),
    /// Of a refined grid: its places are the cells.
    refined: Option<&'a RefinedColumns>,
}

impl<'a> Cells<'a> {
    /// None where fewer vary, or a map would have more cells than pixels.
    pub fn new(results: &'a Results) -> Option<Self> {
        let axis = |index: usize| (index, &results.summary.axes[index]);
        let cells = |slow: usize, fast: usize| {
            let [slow, fast] = [slow, fast].map(|index| axis(index).1.values.len());
            slow.saturating_mul(fast)
        };
        let refined = results.summary.refined.as_ref();
        match results.varied()[..] {
            [slow, fast, ..] if refined.is_some() || cells(slow, fast) <= MOST_CELLS => {
                Some(Self {
                    across: axis(fast),
                    up: axis(slow),
                    refined,
                })
            }
            _ => None,
        }
    }

    pub fn free(&self) -> Vec<usize> {
        vec![self.across.0, self.up.0]
    }

    /// `load and speed`.
    pub fn words(&self) -> String {
        format!("{} and {}", self.up.1.name, self.across.1.name)
    }

    /// Draws every point of a slice in the colour and with the text that `show` gives it (a
    /// list of texts, the first that fits is taken), and the axes. Gives how many cells are
    /// without a point.
    pub fn draw(
        &self,
        canvas: &mut Canvas,
        slice: &Slice<'_>,
        show: impl Fn(&PointSummary) -> (Colour, Vec<String>),
    ) -> usize {
        match self.refined {
            Some(refined) => {
                let plane = Plane::new(refined, slice.points.iter().copied());
                self.draw_plane(canvas, &plane, |index| show(slice.points[index]).0);
                0
            }
            None => self.draw_points(canvas, slice, show),
        }
    }

    /// Draws the places of a refined plane, runs of one colour as one rectangle, and the axes with
    /// the values of the undivided grid.
    fn draw_plane(&self, canvas: &mut Canvas, plane: &Plane, show: impl Fn(usize) -> Colour) {
        let [rows, columns] = plane.sides;
        let [wide, high] = [
            (RIGHT - LEFT) / columns as f64,
            (BOTTOM - TOP) / rows as f64,
        ];
        let mut block = |rows: [usize; 2], columns: [usize; 2], colour: Colour| {
            // A little too large, because abutting edges show as seams in some viewers.
            let left = LEFT + wide * columns[0] as f64;
            let right = (LEFT + wide * columns[1] as f64 + 0.2).min(RIGHT);
            let top = (BOTTOM - high * rows[1] as f64 - 0.2).max(TOP);
            let bottom = BOTTOM - high * rows[0] as f64;
            canvas.rectangle([left, top], [right, bottom], colour);
        };
        // Runs of the row before that may go on, by their first column: end, first row, colour.
        let mut open: BTreeMap<usize, (usize, usize, Colour)> = BTreeMap::new();
        for row in 0..rows {
            let colours: Vec<Option<Colour>> = (0..columns)
                .map(|column| plane.at(row, column).map(&show))
                .collect();
            let (mut start, mut now) = (0, BTreeMap::new());
            for run in colours.chunk_by(|a, b| a == b) {
                let end = start + run.len();
                if let Some(colour) = run[0] {
                    let from = match open.get(&start) {
                        Some(&(to, from, shade)) if to == end && shade == colour => {
                            open.remove(&start);
                            from
                        }
                        _ => row,
                    };
                    now.insert(start, (end, from, colour));
                }
                start = end;
            }
            for (start, (end, from, colour)) in open {
                block([from, row], [start, end], colour);
            }
            open = now;
        }
        for (start, (end, from, colour)) in open {
            block([from, rows], [start, end], colour);
        }
        canvas.outline([LEFT, TOP], [RIGHT, BOTTOM], INK, 1.0);
        self.ticks_across(canvas, wide, plane.step);
        self.ticks_up(canvas, high, plane.step);
    }

    fn draw_points(
        &self,
        canvas: &mut Canvas,
        slice: &Slice<'_>,
        show: impl Fn(&PointSummary) -> (Colour, Vec<String>),
    ) -> usize {
        let columns = self.across.1.values.len();
        let rows = self.up.1.values.len();
        let [wide, high] = [
            (RIGHT - LEFT) / columns as f64,
            (BOTTOM - TOP) / rows as f64,
        ];
        // Larger cells are told apart by a white line; thin ones overlap a little, because
        // abutting edges show as seams in some viewers.
        let gap = if wide.min(high) > 8.0 { 0.75 } else { -0.2 };
        let mut filled = vec![false; columns * rows];
        for point in &slice.points {
            let column = position(self.across.1, point.axis_values[self.across.0]);
            let row = position(self.up.1, point.axis_values[self.up.0]);
            filled[row * columns + column] = true;
            let [x, y] = [
                LEFT + wide * column as f64,
                BOTTOM - high * (row + 1) as f64,
            ];
            let (colour, texts) = show(point);
            canvas.rectangle([x + gap, y + gap], [x + wide - gap, y + high - gap], colour);
            let size = (0.55 * high).min(14.0);
            let fitting = texts
                .iter()
                .find(|text| size >= 6.5 && text_width(text, size) < 0.86 * wide);
            if let Some(text) = fitting {
                let at = [x + 0.5 * wide, y + 0.5 * high + 0.36 * size];
                canvas.text(at, text, size, ink_on(colour), Anchor::Middle);
            }
        }
        for (index, _) in filled.iter().enumerate().filter(|(_, filled)| !**filled) {
            let (row, column) = (index / columns, index % columns);
            let [x, y] = [
                LEFT + wide * column as f64,
                BOTTOM - high * (row + 1) as f64,
            ];
            canvas.line(&[[x, y + high], [x + wide, y]], FAINT, 1.0);
            canvas.line(&[[x, y], [x + wide, y + high]], FAINT, 1.0);
        }
        canvas.outline([LEFT, TOP], [RIGHT, BOTTOM], INK, 1.0);
        self.ticks_across(canvas, wide, 1);
        self.ticks_up(canvas, high, 1);
        filled.iter().filter(|filled| !**filled).count()
    }

    fn ticks_across(&self, canvas: &mut Canvas, wide: f64, step: usize) {
        let (_, axis) = self.across;
        let scale = scale(axis);
        let texts: Vec<String> = axis.values.iter().map(|v| scale.shown(*v)).collect();
        let widest = texts.iter().map(|text| text_width(text, TICK_SIZE));
        let stride = ((widest.fold(0.0, f64::max) + 12.0) / wide).ceil().max(1.0) as usize;
        let stride = stride.next_multiple_of(step);
        for (column, text) in texts.iter().enumerate().step_by(stride) {
            let x = LEFT + wide * (column as f64 + 0.5);
            canvas.line(&[[x, BOTTOM], [x, BOTTOM + 5.0]], INK, 1.0);
            let at = [x, BOTTOM + 9.0 + TICK_SIZE];
            canvas.text(at, text, TICK_SIZE, INK, Anchor::Middle);
        }
        let at = [0.5 * (LEFT + RIGHT), BOTTOM + 46.0];
        canvas.text(at, &scale.label, LABEL_SIZE, INK, Anchor::Middle);
    }

    fn ticks_up(&self, canvas: &mut Canvas, high: f64, step: usize) {
        let (_, axis) = self.up;
        let scale = scale(axis);
        let stride = (1.7 * TICK_SIZE / high).ceil().max(1.0) as usize;
        let stride = stride.next_multiple_of(step);
        let mut widest = 0.0_f64;
        for (row, value) in axis.values.iter().enumerate().step_by(stride) {
            let y = BOTTOM - high * (row as f64 + 0.5);
            canvas.line(&[[LEFT - 5.0, y], [LEFT, y]], INK, 1.0);
            let text = scale.shown(*value);
            let at = [LEFT - 9.0, y + 0.35 * TICK_SIZE];
            canvas.text(at, &text, TICK_SIZE, INK, Anchor::End);
            widest = widest.max(text_width(&text, TICK_SIZE));
        }
        let at = [label_place(LEFT, widest), 0.5 * (TOP + BOTTOM)];
        canvas.text_upwards(at, &scale.label, LABEL_SIZE, INK, Anchor::Middle);
    }
}

/// Only for its unit and number format: cells are evenly spaced whatever their values.
fn scale(axis: &GridAxis) -> Axis {
    Axis::linear(&axis.name, &axis.unit, range(axis.values.iter().copied()))
}

fn position(axis: &GridAxis, value: f64) -> usize {
    axis.values.partition_point(|&known| known < value)
}

/// Says below a key what crossed-out cells are.
pub(super) fn missing_key(canvas: &mut Canvas, y: f64, missing: usize) {
    if missing > 0 {
        let [x, y] = [MARGIN, y];
        canvas.line(&[[x, y], [x + 14.0, y + 14.0]], SOFT, 1.0);
        canvas.line(&[[x, y + 14.0], [x + 14.0, y]], SOFT, 1.0);
        let text = format!("not computed ({missing})");
        canvas.text([x + 21.0, y + 12.0], &text, TICK_SIZE, INK, Anchor::Start);
    }
}
