//! Growth or decay of a small kick from each periodic orbit of a point, return by return.

use super::axis::{Axis, range};
use super::canvas::{Canvas, Place, SOFT};
use super::categories::colour;
use super::clip::crossing;
use super::error::PlotError;
use super::orbits::{key, numbers, pictures};
use super::panel::{BOTTOM, LEFT, Panel};
use super::picture::Drawn;
use super::picture_kind::PictureKind;
use super::request::PlotRequest;
use super::results::Results;
use crate::report::numbers::number;
use crate::report::orbits::Orbit;

const RIGHT: f64 = 660.0;
const TOP: f64 = 84.0;

/// Largest ratio by which the shown linear predictions may exceed the range of the integrated distances.
const LARGEST_RATIO: f64 = 30.0;

pub(super) fn draw(results: &Results, request: &PlotRequest) -> Result<Drawn, PlotError> {
    pictures(
        results,
        request,
        PictureKind::Kicks,
        "growth of kicks from periodic orbits, return by return",
        |orbit| orbit.kick[0].len() > 1,
        growth,
    )
}

fn growth(canvas: &mut Canvas, orbits: &[&Orbit]) {
    let [full, linear] = [0, 1].map(|which: usize| {
        let values = orbits.iter().flat_map(move |orbit| &orbit.kick[which]);
        range(values.copied().filter(|value| *value > 0.0))
    });
    let low = full[0].min(linear[0].max(full[0] / LARGEST_RATIO));
    let high = full[1].max(linear[1].min(full[1] * LARGEST_RATIO));
    let most = orbits.iter().map(|orbit| orbit.kick[0].len()).max();
    let returns = most.unwrap_or(2) as f64 - 1.0;
    let panel = Panel::new(
        [LEFT, RIGHT],
        [TOP, BOTTOM],
        Axis::linear("returns to the orbit", "1", [0.0, returns]),
        Axis::logarithmic(
            "distance from the orbit",
            "half gaps",
            [0.5 * low, 2.0 * high],
        ),
    );
    panel.frame(canvas, true);
    for (place, orbit) in orbits.iter().enumerate() {
        let colour = colour(place);
        let [full, linear] = orbit.kick.each_ref().map(|kick| path(&panel, kick));
        for [from, to] in parts(&panel, &linear) {
            canvas.dashes(from, to, colour, 1.3);
        }
        for part in parts(&panel, &full) {
            canvas.line(&part, colour, 2.0);
        }
        for at in full.iter().filter(|at| shown(&panel, at)) {
            canvas.disc(*at, 3.2, colour);
        }
    }
    let ends = (orbits.iter().enumerate()).filter_map(|(place, orbit)| {
        let mut path = path(&panel, &orbit.kick[0]).into_iter();
        Some((place, path.rfind(|at| shown(&panel, at))?))
    });
    numbers(canvas, &ends.collect::<Vec<_>>());
    let note = "lines: full integration; dashes: powers of the monodromy matrix where they differ";
    canvas.label([panel.left, TOP - 8.0], note, SOFT);
    key(canvas, [RIGHT + 28.0, TOP + 2.0], orbits, |orbit| {
        let first = orbit.kick[0][1] / orbit.kick[0][0];
        format!(
            "first return × {}, then × {}",
            number(first),
            number(orbit.modulus)
        )
    });
}

/// Distances after 0, 1, 2, … returns, as places in the panel.
fn path(panel: &Panel, distances: &[f64]) -> Vec<Place> {
    let at = |(count, distance): (usize, &f64)| panel.at(count as f64, *distance);
    distances.iter().enumerate().map(at).collect()
}

/// Whether a place lies between bottom and top of the panel. A distance of zero does not, because the axis is
/// logarithmic.
fn shown(panel: &Panel, at: &Place) -> bool {
    (panel.top..=panel.bottom).contains(&at[1])
}

/// The parts of a path between the upper and the lower edge of a panel.
fn parts(panel: &Panel, path: &[Place]) -> Vec<[Place; 2]> {
    let (across, down) = (
        [f64::NEG_INFINITY, f64::INFINITY],
        [panel.top, panel.bottom],
    );
    let pairs = path.windows(2);
    pairs
        .filter_map(|pair| crossing(pair[0], pair[1], across, down))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_ends_where_it_leaves_the_panel() {
        let panel = Panel::new(
            [0.0, 100.0],
            [0.0, 100.0],
            Axis::linear("", "1", [0.0, 1.0]),
            Axis::linear("", "1", [0.0, 1.0]),
        );
        let whole = [[10.0, 20.0], [30.0, 90.0]];
        assert_eq!(parts(&panel, &whole), [whole]);
        let leaving = parts(&panel, &[[0.0, 50.0], [40.0, -50.0]]);
        assert_eq!(leaving, [[[0.0, 50.0], [20.0, 0.0]]]);
        let entering = parts(&panel, &[[0.0, 150.0], [40.0, 50.0]]);
        assert_eq!(entering, [[[20.0, 100.0], [40.0, 50.0]]]);
        assert!(parts(&panel, &[[0.0, -1.0], [40.0, -50.0]]).is_empty());
        assert!(parts(&panel, &[[0.0, 101.0], [40.0, 150.0]]).is_empty());
    }
}
