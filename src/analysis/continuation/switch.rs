//! The other branches that begin at a bifurcation.

use super::bifurcation::{Bifurcation, Kind};
use super::map::CycleMap;
use super::orbit::{Border, Orbit, distance, find};
use super::path::Span;
use crate::numerics::linalg::eigenpair;
use num_complex::Complex64;

/// Distances \[half gaps\] from the bifurcation at which the first orbit of a branch is sought.
const AWAY: [f64; 5] = [0.005, 0.02, 0.001, 0.1, 0.3];

/// The first two orbits of every branch that begins at a bifurcation: the bifurcation's own as one of
/// theirs, and one away from it.
pub fn branches(map: &mut impl CycleMap, span: &Span, at: &Bifurcation) -> Vec<[Orbit; 2]> {
    let (wanted, times, sides) = match at.kind {
        Kind::PeriodDoubling => (-1.0, 2, &[1.0][..]),
        Kind::BranchPoint => (1.0, 1, &[1.0, -1.0][..]),
        _ => return Vec::new(),
    };
    let own = &at.orbit;
    let Some(critical) = eigenpair(own.monodromy.as_ref(), Complex64::new(wanted, 0.0)) else {
        return Vec::new();
    };
    let period = times * own.period;
    let direction = &critical.vector[0];
    // The bifurcation's orbit is one of a multiple of its period, too.
    let Ok(here) = find(map, &own.u, own.at, period, &Border::Parameters) else {
        return Vec::new();
    };
    (sides.iter())
        .filter_map(|side| {
            AWAY.iter().find_map(|away| {
                let guess: Vec<f64> = own
                    .u
                    .iter()
                    .zip(direction)
                    .map(|(u, v)| u + side * away * v)
                    .collect();
                // At the bifurcation itself the derivative by the parameter lies in the range of M − I.
                let column = map.by_parameter(&guess, own.at, period, span.axis).ok()?;
                let border = Border::Plane {
                    axis: span.axis,
                    scale: span.scale(),
                    normal: direction.clone(),
                    along: 0.0,
                    column: column.iter().map(|c| c * span.scale()).collect(),
                };
                let found = find(map, &guess, own.at, period, &border).ok()?;
                let off = distance(&found.u, &own.u);
                let near = off > 0.3 * away && off < 10.0 * away;
                let another = times == 1
                    || found
                        .offset(own.period)
                        .iter()
                        .map(|d| d * d)
                        .sum::<f64>()
                        .sqrt()
                        > 0.1 * away;
                (near && another).then_some([here.clone(), found])
            })
        })
        .collect()
}
