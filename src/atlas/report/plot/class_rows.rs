//! The kind of motion over one axis: one row per kind that occurs.

use std::collections::BTreeSet;

use super::axis::Axis;
use super::canvas::{Anchor, FAINT, INK, SOFT};
use super::hatch::hatch;
use super::motion::{Motion, counts};
use super::over_axis::across;
use super::panel::{LABEL_SIZE, Panel, TICK_SIZE};
use super::picture::Drawn;
use super::picture_kind::PictureKind;
use super::ramp::ink_on;
use super::results::Results;
use crate::report::PointSummary;
use crate::report::numbers::plural;

/// Smallest and largest height of a row \[px\], for many and for few rows.
const ROW: [f64; 2] = [18.0, 40.0];
/// Height of the panel \[px\], if the rows then have an allowed height.
const USUAL_HEIGHT: f64 = 454.0;
/// Smallest height of the panel \[px\], for its label.
const LEAST_HEIGHT: f64 = 116.0;

/// Largest half height of the mark of a point \[px\].
const TALLEST: f64 = 9.0;
/// Half width of the mark of a point without near neighbours, and smallest width of any mark \[px\].
const WIDEST: f64 = 6.0;
const LEAST_WIDTH: f64 = 1.0;

pub(super) fn draw(results: &Results, along: usize) -> Drawn {
    let name = &results.summary.axes[along].name;
    results.by_slice(PictureKind::Classes, results.slices(&[along]), |slice| {
        let title = format!("class of motion over {name}");
        let mut canvas = results.canvas(&title, &[&slice.words]);
        let class_counts = counts(slice.points.iter().copied());
        let rows: BTreeSet<Motion> = class_counts.keys().copied().collect();
        let count = rows.len() as f64;
        let height = (count * (USUAL_HEIGHT / count).clamp(ROW[0], ROW[1])).max(LEAST_HEIGHT);
        let panel = Panel::new(
            [148.0, 850.0],
            [72.0, 72.0 + height],
            across(results, along),
            Axis::linear("", "", [0.0, rows.len() as f64]),
        );
        panel.ticks_across(&mut canvas, true);
        let half = 0.5 * height / rows.len() as f64;
        for (row, motion) in rows.iter().enumerate() {
            let y = panel.y(row as f64 + 0.5);
            canvas.line(&[[panel.left, y], [panel.right, y]], FAINT, 1.0);
            let baseline = y + 0.35 * TICK_SIZE;
            let at = [panel.left - 9.0, baseline];
            canvas.text(at, &motion.name(), TICK_SIZE, INK, Anchor::End);
            let count = plural(class_counts[motion], "point");
            canvas.label([panel.right + 9.0, baseline], &count, SOFT);
        }
        let tall = (0.6 * half).min(TALLEST);
        for (motion, [left, right]) in class_intervals(&panel, along, &slice.points) {
            let row = rows.iter().position(|row| *row == motion).unwrap_or(0);
            let y = panel.y(row as f64 + 0.5);
            let [left, right] = widened_to_visible([left, right]);
            canvas.rectangle([left, y - tall], [right, y + tall], SOFT);
            let edge = (0.2 * (right - left)).min(0.8);
            let [from, to] = [
                [left + edge, y - tall + 0.8],
                [right - edge, y + tall - 0.8],
            ];
            canvas.rectangle(from, to, motion.colour());
            if motion.is_hatched() {
                hatch(&mut canvas, from, to, ink_on(motion.colour()));
            }
        }
        let at = [24.0, 0.5 * (panel.top + panel.bottom)];
        canvas.text_upwards(at, "class of motion", LABEL_SIZE, INK, Anchor::Middle);
        canvas.height = panel.bottom + 74.0;
        panel.outline(&mut canvas);
        canvas
    })
}

/// The intervals of the axis \[px\] with one kind of motion. The interval of a point reaches halfway to its
/// neighbours, but at most [`WIDEST`] pixels to each side. Touching intervals with the same kind of motion
/// are merged.
fn class_intervals(
    panel: &Panel,
    along: usize,
    points: &[&PointSummary],
) -> Vec<(Motion, [f64; 2])> {
    let mut places: Vec<(f64, Motion)> = (points.iter())
        .map(|point| (panel.x(point.axis_values[along]), Motion::of(point)))
        .collect();
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut intervals: Vec<(Motion, [f64; 2])> = Vec::new();
    for (index, &(x, motion)) in places.iter().enumerate() {
        let reach = |other: Option<&(f64, Motion)>| {
            other.map_or(WIDEST, |(other, _)| (0.5 * (other - x).abs()).min(WIDEST))
        };
        let before = index.checked_sub(1).and_then(|before| places.get(before));
        let [from, to] = [x - reach(before), x + reach(places.get(index + 1))];
        match intervals.last_mut() {
            Some((last, [_, end])) if *last == motion && from - *end < 0.01 => *end = to,
            _ => intervals.push((motion, [from, to])),
        }
    }
    intervals
}

/// An interval, widened to the smallest visible width.
fn widened_to_visible([left, right]: [f64; 2]) -> [f64; 2] {
    let widening = (0.5 * (LEAST_WIDTH - (right - left))).max(0.0);
    [left - widening, right + widening]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::point::Verdict;
    use std::sync::Arc;

    fn point(at: f64, class: &str) -> PointSummary {
        PointSummary {
            axis_values: vec![at],
            verdict: Arc::new(Verdict {
                class: Some(class.into()),
                ..Verdict::default()
            }),
            ..PointSummary::default()
        }
    }

    #[test]
    fn points_are_apart_where_they_are_few_and_touch_where_they_are_many() {
        let panel = Panel::new(
            [0.0, 100.0],
            [0.0, 100.0],
            Axis::linear("", "1", [0.0, 100.0]),
            Axis::linear("", "1", [0.0, 1.0]),
        );
        let few = [
            point(10.0, "chaotic"),
            point(50.0, "chaotic"),
            point(54.0, "steady_contact"),
        ];
        let found = class_intervals(&panel, 0, &few.each_ref());
        let wanted = [
            (Motion::Chaotic, [4.0, 16.0]),
            (Motion::Chaotic, [44.0, 52.0]),
            (Motion::SteadyContact, [52.0, 60.0]),
        ];
        assert_eq!(found, wanted);
        let class = |i: usize| {
            if i == 500 { "chaotic" } else { "quasi_periodic" }
        };
        let many: Vec<PointSummary> = (0..=1000)
            .map(|i| point(0.1 * i as f64, class(i)))
            .collect();
        let found = class_intervals(&panel, 0, &many.iter().collect::<Vec<_>>());
        assert_eq!(found.len(), 3, "{found:?}");
        let [left, right] = widened_to_visible(found[1].1);
        assert!((right - left - LEAST_WIDTH).abs() < 1e-9 && (left + right - 100.0).abs() < 1e-9);
    }
}
