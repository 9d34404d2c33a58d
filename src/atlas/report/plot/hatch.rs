//! Hatching: diagonal lines over cells of a map, which mark transient chaos.

use super::canvas::{Canvas, Colour, Place};

/// Distance between lines, horizontally or vertically \[px\].
const PITCH: f64 = 7.0;
/// Width of a line \[px\].
const WIDTH: f64 = 0.9;

/// Hatches a rectangle. All rectangles share one family of lines, so that these continue across neighbouring cells of
/// any size.
pub(super) fn hatch(
    canvas: &mut Canvas,
    [left, top]: Place,
    [right, bottom]: Place,
    colour: Colour,
) {
    // x + y is the same along a line.
    let first = ((left + top) / PITCH).ceil() as i64;
    let last = ((right + bottom) / PITCH).floor() as i64;
    for sum in (first..=last).map(|line| line as f64 * PITCH) {
        let low = [(sum - bottom).max(left), (sum - left).min(bottom)];
        let high = [(sum - top).min(right), (sum - right).max(top)];
        // Skip a line that only touches a corner.
        if high[0] - low[0] > 0.1 {
            canvas.line(&[low, high], colour, WIDTH);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::plot::canvas::{INK, Shape};

    fn lines(from: Place, to: Place) -> Vec<[Place; 2]> {
        let mut canvas = Canvas::titled("", "");
        hatch(&mut canvas, from, to, INK);
        let lines = canvas.shapes.iter().filter_map(|shape| match shape {
            Shape::Line { points, .. } => Some([points[0], points[1]]),
            _ => None,
        });
        lines.collect()
    }

    #[test]
    fn lines_end_at_the_edges_and_go_on_in_the_next_cell() {
        let [first, second] = [100.0, 130.0].map(|left| lines([left, 50.0], [left + 30.0, 90.0]));
        for (left, found) in [(100.0, &first), (130.0, &second)] {
            assert!(found.len() > 6, "{found:?}");
            for [low, high] in found {
                for [x, y] in [low, high] {
                    assert!((left..=left + 30.0).contains(x) && (50.0..=90.0).contains(y));
                    let at_edge = [x - left, x - left - 30.0, y - 50.0, y - 90.0];
                    assert!(at_edge.iter().any(|distance| distance.abs() < 1e-9));
                }
                assert!((low[0] + low[1] - high[0] - high[1]).abs() < 1e-9);
            }
        }
        let leaves = |[_, high]: &&[Place; 2]| (high[0] - 130.0).abs() < 1e-9;
        for [_, end] in first.iter().filter(leaves) {
            let goes_on = |[low, _]: &[Place; 2]| (low[1] - end[1]).abs() < 1e-9;
            assert!(end[1] < 50.1 || second.iter().any(goes_on), "{end:?}");
        }
    }
}
