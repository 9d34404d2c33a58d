//! Pictures over one axis: the layout of its panels, and the sweeps along it.

use super::axis::Axis;
use super::canvas::{BLUE, Colour, RED};
use super::results::Results;
use crate::report::PointSummary;

pub(super) const RIGHT: f64 = 775.0;
pub(super) const MARGIN: f64 = RIGHT + 18.0;
pub(super) fn across(results: &Results, along: usize) -> Axis {
    let axis = &results.summary.axes[along];
    results.axis(axis, |name, unit| Axis::for_grid(name, unit, &axis.values))
}

/// Points of a slice that were computed in one direction.
pub(super) struct Sweep<'a> {
    /// `up` or `down`; empty if points are independent.
    pub direction: &'a str,
    pub colour: Colour,
    pub points: Vec<&'a PointSummary>,
}

/// The sweeps of a slice, up before down.
pub(super) fn sweeps<'a>(results: &'a Results, points: &[&'a PointSummary]) -> Vec<Sweep<'a>> {
    let of = |direction: Option<&'a str>| -> Vec<&'a PointSummary> {
        let in_direction = |point: &&&PointSummary| point.direction.as_deref() == direction;
        points.iter().filter(in_direction).copied().collect()
    };
    let directions = results.directions();
    if directions.is_empty() {
        return vec![Sweep {
            direction: "",
            colour: BLUE,
            points: of(None),
        }];
    }
    let sweep = |direction| Sweep {
        direction,
        colour: if direction == "down" { RED } else { BLUE },
        points: of(Some(direction)),
    };
    directions.into_iter().map(sweep).collect()
}
