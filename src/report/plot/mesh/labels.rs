//! Names of lines, right of their panel and level with their ends as far as others let them.

use crate::report::plot::canvas::{Anchor, Canvas, Colour, INK, Place};
use crate::report::plot::panel::{Panel, TICK_SIZE};

/// Least distance of two names \[px\].
const APART: f64 = 16.0;
/// Where names start, right of the panel \[px\].
const ASIDE: f64 = 26.0;

/// A line, its name and its colour.
pub(super) struct Named {
    pub curve: Vec<Place>,
    pub name: String,
    pub colour: Colour,
}

/// Draws lines into a panel and their names beside it.
pub(super) fn draw(canvas: &mut Canvas, panel: &Panel, lines: &[Named]) {
    let mut ends = Vec::new();
    for line in lines {
        let path: Vec<Place> = (line.curve.iter())
            .filter(|[_, value]| value.is_finite())
            .map(|[phase, value]| panel.at(*phase, *value))
            .collect();
        canvas.line(&path, line.colour, 1.8);
        ends.push(path.last().map_or(panel.bottom, |end| end[1]));
    }
    let places = apart(&ends, [panel.top, panel.bottom]);
    for ((line, end), place) in lines.iter().zip(&ends).zip(places) {
        let x = panel.right;
        let leader = [[x + 2.0, *end], [x + 14.0, place], [x + 22.0, place]];
        canvas.line(&leader, line.colour, 1.8);
        let at = [x + ASIDE, place + 0.35 * TICK_SIZE];
        canvas.text(at, &line.name, TICK_SIZE, INK, Anchor::Start);
    }
}

/// Heights near those wanted, in their order, [`APART`] and between two bounds where there is
/// room.
fn apart(wanted: &[f64], [top, bottom]: [f64; 2]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..wanted.len()).collect();
    order.sort_by(|&a, &b| wanted[a].total_cmp(&wanted[b]));
    let mut places = wanted.to_vec();
    let mut least = top;
    for &i in &order {
        places[i] = places[i].max(least);
        least = places[i] + APART;
    }
    let mut most = bottom;
    for &i in order.iter().rev() {
        places[i] = places[i].min(most);
        most = places[i] - APART;
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_do_not_overlap_and_stay_beside_their_panel() {
        assert_eq!(apart(&[10.0, 90.0], [0.0, 100.0]), [10.0, 90.0]);
        for wanted in [[50.0; 4], [99.0, 98.0, 97.0, 3.0], [0.0, 0.0, 100.0, 100.0]] {
            let places = apart(&wanted, [0.0, 100.0]);
            for i in 0..4 {
                assert!((0.0..=100.0).contains(&places[i]), "{places:?}");
                for j in 0..i {
                    assert!((places[i] - places[j]).abs() >= APART, "{places:?}");
                }
            }
        }
    }
}
