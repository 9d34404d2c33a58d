//! The layout of maps: each point of the grid is a cell.

use std::collections::BTreeMap;

use super::axis::Axis;
use super::canvas::{Anchor, Canvas, Colour, FAINT, INK, Place, SOFT, WIDTH};
use super::hatch::hatch;
use super::lettering::{fitted, text_width, wrapped};
use super::panel::{BOTTOM, LABEL_SIZE, LEFT, TICK_SIZE, TOP, label_place};
use super::point_style::PointStyle;
use super::ramp::ink_on;
use super::results::{Results, Slice};
use crate::report::numbers::plural;
use crate::report::refined::Plane;
use crate::report::{Axis as GridAxis, PointSummary};
use crate::store::RefinedColumns;

const RIGHT: f64 = 735.0;
/// Left edge of keys and colour bars.
pub(super) const MARGIN: f64 = RIGHT + 24.0;
/// Largest number of cells in a map.
const MOST_CELLS: usize = 1 << 20;
pub(super) const HEIGHT: [f64; 2] = [TOP, BOTTOM];

/// Largest number of values of an axis for which each value has a tick.
const MOST_TICKS: usize = 12;
/// Smallest em size \[px\] of a single letter in a cell, and of a longer text, which needs more room around
/// it.
const SMALLEST: [f64; 2] = [6.5, 8.0];
/// Largest share of a cell's width that a single letter, and a longer text, may take.
const FILLED: [f64; 2] = [0.86, 0.75];

/// Radius of a dot in the corner of a cell \[px\].
const DOT: f64 = 1.7;
/// Distance of the dot's centre from the sides of its cell \[px\].
const DOT_INSET: f64 = 4.0;
/// Smallest side of a cell with a dot \[px\].
const DOTTED: f64 = 14.0;

/// Counts of special cells in a drawn map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Drawn {
    /// Cells without a point.
    pub missing: usize,
    /// Cells with a point but without room for its text.
    pub unlettered: usize,
    /// Cells with a dot.
    pub dotted: usize,
}

/// The layout of a map over the first two axes that maps use.
pub(super) struct Cells<'a> {
    across: (usize, &'a GridAxis),
    up: (usize, &'a GridAxis),
    /// Horizontal and vertical axis, for units and ticks only: cells have equal sizes for any values.
    scales: [Axis; 2],
    /// The refinement of the grid, if it is refined. Then the places of the finest grid are the cells.
    refined: Option<&'a RefinedColumns>,
}

impl<'a> Cells<'a> {
    /// The layout; `None` if fewer than two axes vary, if axes are distributions, or if an unrefined map would have
    /// more than [`MOST_CELLS`] cells.
    pub fn new(results: &'a Results) -> Option<Self> {
        let axis = |index: usize| (index, &results.summary.axes[index]);
        let cells = |slow: usize, fast: usize| {
            let [slow, fast] = [slow, fast].map(|index| axis(index).1.values.len());
            slow.saturating_mul(fast)
        };
        let refined = results.summary.refined.as_ref();
        match results.spanning()[..] {
            _ if results.summary.sampled => None,
            [slow, fast, ..] if refined.is_some() || cells(slow, fast) <= MOST_CELLS => {
                let scale = |(_, axis): (usize, &GridAxis)| {
                    results.axis(axis, |name, unit| Axis::for_grid(name, unit, &axis.values))
                };
                Some(Self {
                    scales: [axis(fast), axis(slow)].map(scale),
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

    /// Draws every point of a slice in the style that `show` gives, and the axes. Returns counts for the key.
    pub fn draw(
        &self,
        canvas: &mut Canvas,
        slice: &Slice<'_>,
        show: impl Fn(&PointSummary) -> PointStyle,
    ) -> Drawn {
        match self.refined {
            Some(refined) => {
                let plane = Plane::new(refined, slice.points.iter().copied());
                self.draw_plane(canvas, &plane, |index| {
                    let look = show(slice.points[index]);
                    (look.colour, look.hatched)
                });
                Drawn {
                    missing: 0,
                    unlettered: slice.points.len(),
                    dotted: 0,
                }
            }
            None => self.draw_points(canvas, slice, show),
        }
    }

    /// Draws the places of a refined plane, and the axes with the values of the undivided grid. `show` gives
    /// the colour of a point and whether it is hatched. Adjacent places that look the same become one
    /// rectangle.
    fn draw_plane(
        &self,
        canvas: &mut Canvas,
        plane: &Plane,
        show: impl Fn(usize) -> (Colour, bool),
    ) {
        let [rows, columns] = plane.sides;
        let [wide, high] = [
            (RIGHT - LEFT) / columns as f64,
            (BOTTOM - TOP) / rows as f64,
        ];
        let mut block =
            |rows: [usize; 2], columns: [usize; 2], (colour, hatched): (Colour, bool)| {
                // Slightly enlarged, because abutting edges show as seams in some viewers.
                let left = LEFT + wide * columns[0] as f64;
                let right = (LEFT + wide * columns[1] as f64 + 0.2).min(RIGHT);
                let top = (BOTTOM - high * rows[1] as f64 - 0.2).max(TOP);
                let bottom = BOTTOM - high * rows[0] as f64;
                canvas.rectangle([left, top], [right, bottom], colour);
                if hatched {
                    hatch(canvas, [left, top], [right, bottom], ink_on(colour));
                }
            };
        // Blocks that reach the previous row and may continue, by their first column: end column, first row,
        // look.
        let mut open: BTreeMap<usize, (usize, usize, (Colour, bool))> = BTreeMap::new();
        for row in 0..rows {
            let looks: Vec<Option<(Colour, bool)>> = (0..columns)
                .map(|column| plane.at(row, column).map(&show))
                .collect();
            let (mut start, mut now) = (0, BTreeMap::new());
            for run in looks.chunk_by(|a, b| a == b) {
                let end = start + run.len();
                if let Some(look) = run[0] {
                    let from = match open.get(&start) {
                        Some(&(to, from, other)) if to == end && other == look => {
                            open.remove(&start);
                            from
                        }
                        _ => row,
                    };
                    now.insert(start, (end, from, look));
                }
                start = end;
            }
            for (start, (end, from, look)) in open {
                block([from, row], [start, end], look);
            }
            open = now;
        }
        for (start, (end, from, look)) in open {
            block([from, rows], [start, end], look);
        }
        canvas.outline([LEFT, TOP], [RIGHT, BOTTOM], INK, 1.0);
        self.ticks_across(canvas, wide, plane.step);
        self.ticks_up(canvas, high, plane.step);
    }

    fn draw_points(
        &self,
        canvas: &mut Canvas,
        slice: &Slice<'_>,
        show: impl Fn(&PointSummary) -> PointStyle,
    ) -> Drawn {
        let columns = self.across.1.values.len();
        let rows = self.up.1.values.len();
        let [wide, high] = [
            (RIGHT - LEFT) / columns as f64,
            (BOTTOM - TOP) / rows as f64,
        ];
        // A white line separates larger cells. Thin cells overlap slightly, because abutting edges show as seams in
        // some viewers.
        let gap = if wide.min(high) > 8.0 { 0.75 } else { -0.2 };
        let mut filled = vec![false; columns * rows];
        let (mut unlettered, mut dotted) = (0, 0);
        for point in &slice.points {
            let [column, row] =
                [self.across, self.up].map(|(index, axis)| axis.place(point.axis_values[index]));
            filled[row * columns + column] = true;
            let [x, y] = [
                LEFT + wide * column as f64,
                BOTTOM - high * (row + 1) as f64,
            ];
            let look = show(point);
            let (colour, text) = (look.colour, &look.text);
            let corners: [Place; 2] = [[x + gap, y + gap], [x + wide - gap, y + high - gap]];
            canvas.rectangle(corners[0], corners[1], colour);
            if look.hatched {
                hatch(canvas, corners[0], corners[1], ink_on(colour));
            }
            if look.dotted && wide.min(high) >= DOTTED {
                let at = [x + wide - DOT_INSET, y + DOT_INSET];
                if look.hatched {
                    canvas.disc(at, 1.8 * DOT, colour);
                }
                canvas.disc(at, DOT, ink_on(colour));
                dotted += 1;
            }
            let size = (0.55 * high).min(14.0);
            let long = usize::from(text.chars().nth(1).is_some());
            let (smallest, filled) = (SMALLEST[long], FILLED[long]);
            // A letter is at least a quarter as wide as high. This cheap test comes before measuring the
            // text.
            let room = size >= smallest && wide >= 0.25 * smallest;
            let fitting = room.then(|| size.min(size * filled * wide / text_width(text, size)));
            let Some(size) = fitting.filter(|size| *size >= smallest) else {
                unlettered += 1;
                continue;
            };
            let at = [x + 0.5 * wide, y + 0.5 * high + 0.36 * size];
            if look.hatched {
                // Hatching behind a letter would make it hard to read: cover it.
                let half = [0.5 * text_width(text, size) + 1.5, 0.5 * size];
                let middle = [x + 0.5 * wide, y + 0.5 * high];
                let [from, to] = [-1.0, 1.0].map(|sign| [0, 1].map(|i| middle[i] + sign * half[i]));
                canvas.rectangle(from, to, colour);
            }
            canvas.text(at, text, size, ink_on(colour), Anchor::Middle);
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
        Drawn {
            missing: filled.iter().filter(|filled| !**filled).count(),
            unlettered,
            dotted,
        }
    }

    fn ticks_across(&self, canvas: &mut Canvas, wide: f64, step: usize) {
        let ((_, axis), scale) = (self.across, &self.scales[0]);
        let width = |text: &str| text_width(text, TICK_SIZE) + 12.0;
        for (column, text) in ticks(axis, scale, wide, step, width) {
            let x = LEFT + wide * (column + 0.5);
            canvas.line(&[[x, BOTTOM], [x, BOTTOM + 5.0]], INK, 1.0);
            let at = [x, BOTTOM + 9.0 + TICK_SIZE];
            canvas.text(at, &text, TICK_SIZE, INK, Anchor::Middle);
        }
        let at = [0.5 * (LEFT + RIGHT), BOTTOM + 46.0];
        let (label, size) = fitted(&scale.label, LABEL_SIZE, 8.0, RIGHT - LEFT);
        canvas.text(at, &label, size, INK, Anchor::Middle);
    }

    fn ticks_up(&self, canvas: &mut Canvas, high: f64, step: usize) {
        let ((_, axis), scale) = (self.up, &self.scales[1]);
        let mut widest = 0.0_f64;
        for (row, text) in ticks(axis, scale, high, step, |_| 1.7 * TICK_SIZE) {
            let y = BOTTOM - high * (row + 0.5);
            canvas.line(&[[LEFT - 5.0, y], [LEFT, y]], INK, 1.0);
            let at = [LEFT - 9.0, y + 0.35 * TICK_SIZE];
            canvas.text(at, &text, TICK_SIZE, INK, Anchor::End);
            widest = widest.max(text_width(&text, TICK_SIZE));
        }
        let at = [label_place(LEFT, widest), 0.5 * (TOP + BOTTOM)];
        let (label, size) = fitted(&scale.label, LABEL_SIZE, 8.0, BOTTOM - TOP);
        canvas.text_upwards(at, &label, size, INK, Anchor::Middle);
    }
}

/// Ticks of an axis of cells: the position in cells from the centre of the first cell, and the text. Ticks are at all
/// values of the grid if these are few and have room, else at round values. If fewer than two round values have room,
/// ticks are at some values of the grid. In a refined grid, `step` cells lie between values of the undivided grid.
/// `cell` is the width of a cell, and `room` that of a text \[px\].
fn ticks(
    axis: &GridAxis,
    scale: &Axis,
    cell: f64,
    step: usize,
    room: impl Fn(&str) -> f64,
) -> Vec<(f64, String)> {
    let labels = axis.values.iter().enumerate().step_by(step);
    let labels: Vec<(f64, String)> = labels
        .map(|(index, value)| (index as f64, scale.shown(*value)))
        .collect();
    let fit = |text: &str| room(text) <= cell * step as f64;
    if labels.len() <= MOST_TICKS && labels.iter().all(|(_, text)| fit(text)) {
        return labels;
    }
    let span = cell * axis.values.len() as f64;
    let wanted = ((span / 60.0) as usize).clamp(2, MOST_TICKS);
    let round = scale.ticks(wanted).into_iter();
    let round = round.filter_map(|(value, text)| Some((place(&axis.values, value)?, text)));
    let mut kept = thinned(round.collect(), cell, &room);
    if kept.len() < 2 {
        kept = thinned(labels, cell, &room);
    }
    kept
}

/// Removes each tick whose text has no room beside the text of the tick before it.
fn thinned(ticks: Vec<(f64, String)>, cell: f64, room: impl Fn(&str) -> f64) -> Vec<(f64, String)> {
    let mut kept: Vec<(f64, String)> = Vec::new();
    for (place, text) in ticks {
        let free = |(before, other): &(f64, String)| {
            (place - before) * cell >= 0.5 * (room(other) + room(&text))
        };
        if kept.last().is_none_or(free) {
            kept.push((place, text));
        }
    }
    kept
}

/// Position of a value among ascending values, as an interpolated index; `None` outside their range.
fn place(values: &[f64], value: f64) -> Option<f64> {
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * a.abs().max(b.abs());
    let upper = values.partition_point(|&known| known < value && !near(known, value));
    let above = *values.get(upper)?;
    if near(above, value) {
        return Some(upper as f64);
    }
    let below = values[upper.checked_sub(1)?];
    Some((upper - 1) as f64 + (value - below) / (above - below))
}

/// Draws explanations of crossed-out cells, dots and missing texts, from the height `y` down.
pub(super) fn notes(canvas: &mut Canvas, mut y: f64, drawn: Drawn) {
    let x = MARGIN;
    let say = |canvas: &mut Canvas, mut y: f64, words: &str| {
        for line in wrapped(words, TICK_SIZE, WIDTH - 6.0 - x - 28.0) {
            canvas.label([x + 28.0, y + 12.0], &line, INK);
            y += 16.0;
        }
        y + 6.0
    };
    if drawn.missing > 0 {
        let [left, top] = [x + 3.0, y];
        canvas.line(&[[left, top], [left + 14.0, top + 14.0]], SOFT, 1.0);
        canvas.line(&[[left, top + 14.0], [left + 14.0, top]], SOFT, 1.0);
        y = say(canvas, y, &format!("not computed ({})", drawn.missing));
    }
    if drawn.dotted > 0 {
        canvas.disc([x + 10.0, y + 7.5], 1.5 * DOT, INK);
        y = say(canvas, y, &format!("error not verified ({})", drawn.dotted));
    }
    if drawn.unlettered > 0 {
        let words = format!(
            "{} without room for a text",
            plural(drawn.unlettered, "cell")
        );
        say(canvas, y, &words);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(values: Vec<f64>) -> GridAxis {
        GridAxis {
            name: "speed".into(),
            unit: "rad/s".into(),
            values,
        }
    }

    fn ticks(
        axis: &GridAxis,
        cell: f64,
        step: usize,
        room: impl Fn(&str) -> f64,
    ) -> Vec<(f64, String)> {
        let scale = Axis::for_grid(&axis.name, &axis.unit, &axis.values);
        super::ticks(axis, &scale, cell, step, room)
    }

    fn even(from: f64, to: f64, count: usize) -> GridAxis {
        let step = (to - from) / (count - 1) as f64;
        axis((0..count).map(|i| from + step * i as f64).collect())
    }

    #[test]
    fn few_values_have_a_tick_each_and_many_have_round_ones() {
        let wide = |text: &str| 8.0 * text.len() as f64;
        let few = ticks(&axis(vec![172.9, 300.0, 411.5]), 200.0, 1, wide);
        let texts: Vec<&str> = few.iter().map(|(_, text)| text.as_str()).collect();
        assert_eq!(texts, ["172.9", "300", "411.5"]);
        let many = ticks(&even(172.9, 2000.0, 80), 8.0, 1, wide);
        let texts: Vec<&str> = many.iter().map(|(_, text)| text.as_str()).collect();
        assert_eq!(
            texts,
            [
                "200", "400", "600", "800", "1000", "1200", "1400", "1600", "1800", "2000"
            ]
        );
        // The value 200 is 27.1 above the first value, a cell is 23.13 wide, and 2000 is the last cell.
        assert!((many[0].0 - 27.1 / 23.127_848).abs() < 1e-3, "{many:?}");
        assert!((many[9].0 - 79.0).abs() < 1e-9, "{many:?}");
    }

    #[test]
    fn ticks_of_uneven_cells_do_not_touch() {
        let mut values: Vec<f64> = (0..40).map(f64::from).collect();
        values.extend((1..=40).map(|i| 40.0 + 1000.0 * f64::from(i)));
        let found = ticks(&axis(values), 8.0, 1, |_| 40.0);
        assert!(found.len() > 2, "{found:?}");
        assert!(
            found.windows(2).all(|pair| pair[1].0 - pair[0].0 >= 5.0),
            "{found:?}"
        );
        let decades = axis((0..60).map(|i| 10f64.powf(f64::from(i) / 20.0)).collect());
        let texts: Vec<String> = ticks(&decades, 10.0, 1, |_| 40.0)
            .into_iter()
            .map(|t| t.1)
            .collect();
        assert_eq!(texts, ["1", "10", "100"]);
    }
}
