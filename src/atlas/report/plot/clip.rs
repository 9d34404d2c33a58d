//! Clipping of curves at the edges of their panel.

use super::canvas::Place;
use super::panel::Panel;

/// Clips a polyline at a panel. A line that leaves or enters the panel ends at its edge. Lines outside the
/// panel become gaps, that is, places with NaN.
pub(super) fn clipped(places: &[Place], panel: &Panel) -> Vec<Place> {
    let [top, bottom] = [panel.top, panel.bottom];
    let [left, right] = [panel.left, panel.right];
    let nowhere = [f64::NAN, f64::NAN];
    let mut out = Vec::with_capacity(places.len());
    for (i, &place) in places.iter().enumerate() {
        if i > 0 {
            match crossing(places[i - 1], place, [left, right], [top, bottom]) {
                Some([from, to]) => {
                    if out.last() != Some(&from) {
                        out.extend([nowhere, from]);
                    }
                    out.push(to);
                }
                None => out.push(nowhere),
            }
        }
    }
    out
}

/// The part of a straight line within a rectangle (Liang and Barsky 1984); `None` if it is empty.
pub(super) fn crossing(
    from: Place,
    to: Place,
    across: [f64; 2],
    down: [f64; 2],
) -> Option<[Place; 2]> {
    let (mut start, mut end) = (0.0_f64, 1.0_f64);
    for (axis, [low, high]) in [across, down].into_iter().enumerate() {
        let length = to[axis] - from[axis];
        if length.is_nan() {
            return None;
        }
        if length == 0.0 {
            if from[axis] < low || from[axis] > high {
                return None;
            }
            continue;
        }
        let [a, b] = [(low - from[axis]) / length, (high - from[axis]) / length];
        start = start.max(a.min(b));
        end = end.min(a.max(b));
    }
    let at = |t: f64| [0, 1].map(|axis| from[axis] + t * (to[axis] - from[axis]));
    let ends = [
        if start <= 0.0 { from } else { at(start) },
        if end >= 1.0 { to } else { at(end) },
    ];
    (start <= end).then_some(ends)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_at_the_edge() {
        let within = |from: Place, to: Place| crossing(from, to, [0.0, 10.0], [0.0, 10.0]);
        assert_eq!(
            within([1.0, 1.0], [5.0, 5.0]),
            Some([[1.0, 1.0], [5.0, 5.0]])
        );
        assert_eq!(
            within([5.0, 5.0], [5.0, 25.0]),
            Some([[5.0, 5.0], [5.0, 10.0]])
        );
        assert_eq!(
            within([-5.0, 5.0], [15.0, 5.0]),
            Some([[0.0, 5.0], [10.0, 5.0]])
        );
        assert_eq!(within([-5.0, 12.0], [15.0, 12.0]), None);
        assert_eq!(within([-5.0, 0.0], [0.0, 15.0]), None);
        assert_eq!(within([1.0, f64::NAN], [2.0, 2.0]), None);
    }
}
