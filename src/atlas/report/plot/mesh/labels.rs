//! Lines in a panel, with their names to the right of it. A name is at the height of the end of its line if
//! other names leave room.

use crate::report::plot::canvas::{Canvas, Colour, INK, Place};
use crate::report::plot::lettering::spread_out;
use crate::report::plot::panel::{Panel, TICK_SIZE};

/// Smallest distance of two names \[px\].
const LEAST_DISTANCE: f64 = 16.0;
/// Distance from the panel to the names \[px\].
const LABEL_GAP: f64 = 26.0;

/// Two lines that are nowhere farther apart than this look like one \[px\].
const SAME_LINE: f64 = 0.8;

/// A line with its distinguishing value and its colour.
pub(super) struct Named {
    pub curve: Vec<Place>,
    pub name: String,
    pub colour: Colour,
}

/// Draws lines into a panel, and their names beside it, each followed by `unit`. Successive lines that
/// coincide get one label, from the name of the first to the name of the last.
pub(super) fn draw(canvas: &mut Canvas, panel: &Panel, lines: &[Named], unit: &str) {
    let paths: Vec<Vec<Place>> = lines.iter().map(|line| path(panel, line)).collect();
    for (line, path) in lines.iter().zip(&paths) {
        canvas.line(path, line.colour, 1.8);
    }
    let groups = groups(&paths);
    let end = |first: usize| paths[first].last().map_or(panel.bottom, |end| end[1]);
    let ends: Vec<f64> = groups.iter().map(|&[_, last]| end(last)).collect();
    let places = spread_out(&ends, LEAST_DISTANCE, [panel.top, panel.bottom]);
    for ((&[first, last], end), place) in groups.iter().zip(&ends).zip(places) {
        let x = panel.right;
        let leader = [[x + 2.0, *end], [x + 14.0, place], [x + 22.0, place]];
        canvas.line(&leader, lines[last].colour, 1.8);
        let name = if first == last {
            format!("{} {unit}", lines[first].name)
        } else {
            format!("{} … {} {unit}", lines[first].name, lines[last].name)
        };
        canvas.label(
            [x + LABEL_GAP, place + 0.35 * TICK_SIZE],
            name.trim_end(),
            INK,
        );
    }
}

fn path(panel: &Panel, line: &Named) -> Vec<Place> {
    let finite = line.curve.iter().filter(|[_, value]| value.is_finite());
    finite
        .map(|[phase, value]| panel.at(*phase, *value))
        .collect()
}

/// Indices of the first and the last line of each group of successive lines that coincide.
fn groups(paths: &[Vec<Place>]) -> Vec<[usize; 2]> {
    let same = |a: &[Place], b: &[Place]| {
        a.len() == b.len()
            && a.iter()
                .zip(b)
                .all(|(a, b)| (a[1] - b[1]).abs() < SAME_LINE)
    };
    let mut groups: Vec<[usize; 2]> = Vec::new();
    for (line, path) in paths.iter().enumerate() {
        match groups.last_mut() {
            Some([first, last]) if same(&paths[*first], path) => *last = line,
            _ => groups.push([line, line]),
        }
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_on_each_other_are_one_group() {
        let line = |y: f64| vec![[0.0, y], [1.0, 2.0 * y]];
        let paths = [line(1.0), line(1.1), line(1.2), line(9.0), line(1.0)];
        assert_eq!(groups(&paths), [[0, 2], [3, 3], [4, 4]]);
        assert!(groups(&[]).is_empty());
    }
}
