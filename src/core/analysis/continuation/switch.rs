//! Which other branches begin at a bifurcation?

use super::bifurcation::Bifurcation;
use super::kind::Kind;
use super::map::CycleMap;
use super::orbit::{NoOrbit, Orbit, OrbitCondition, distance, find, length};
use super::path::Span;
use crate::numerics::linalg::eigenpair;
use num_complex::Complex64;

/// Distances from the bifurcation, in sizes of the motion, at which the first orbit of a branch is sought.
const START_DISTANCES: [f64; 9] = [1e-3, 5e-3, 2e-4, 2e-2, 5e-5, 1e-5, 2e-6, 0.1, 0.3];

/// Reasons why a branch that begins at a bifurcation is not found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoBranch {
    /// The multiplier on the unit circle has no unique eigenvector.
    #[error("the orbit has several multipliers at {wanted:+}")]
    NoDirection {
        /// The multiplier.
        wanted: f64,
    },
    /// Newton's method finds no orbit near the bifurcation.
    #[error(transparent)]
    Orbit(#[from] NoOrbit),
    /// Newton's method finds only orbits on the branch of the bifurcation.
    #[error("every nearby orbit lies on the branch of the bifurcation")]
    OnlyKnown,
}

/// The first two orbits of every branch that begins at a bifurcation. The first one is the orbit at the
/// bifurcation, with the period of the branch. The second one lies away from it.
pub fn branches(
    map: &mut impl CycleMap,
    span: &Span,
    at: &Bifurcation,
) -> Vec<Result<[Orbit; 2], NoBranch>> {
    let (wanted, sides) = match at.kind {
        Kind::PeriodDoubling => (-1.0, &[1.0][..]),
        Kind::BranchPoint => (1.0, &[1.0, -1.0][..]),
        _ => return Vec::new(),
    };
    let orbit = &at.orbit;
    let Some(critical) = eigenpair(orbit.monodromy.as_ref(), Complex64::new(wanted, 0.0)) else {
        return vec![Err(NoBranch::NoDirection { wanted })];
    };
    let here = match at.kind {
        Kind::PeriodDoubling => orbit.doubled(map),
        _ => Ok(orbit.clone()),
    };
    let here = match here {
        Ok(here) => here,
        Err(reason) => return vec![Err(reason.into())],
    };
    let displaced = |side: &f64| {
        Ok([
            here.clone(),
            first(map, span, &here, &critical.vector[0], *side)?,
        ])
    };
    sides.iter().map(displaced).collect()
}

/// The first orbit of the branch that leaves the bifurcation in the direction `side` times `direction`.
fn first(
    map: &mut impl CycleMap,
    span: &Span,
    here: &Orbit,
    direction: &[f64],
    side: f64,
) -> Result<Orbit, NoBranch> {
    let mut fault = None;
    for away in START_DISTANCES.map(|away| away * here.size()) {
        let guess: Vec<f64> = (here.u.iter().zip(direction))
            .map(|(u, v)| u + side * away * v)
            .collect();
        // The derivative is taken at the guess, because at the bifurcation it lies in the range of M − I. The
        // linear system would then be singular.
        let column = map
            .by_parameter(&guess, here.at, here.period, span.axis)
            .map_err(NoOrbit::from)?;
        let condition = OrbitCondition::Plane {
            axis: span.axis,
            scale: span.scale(),
            normal: direction.to_vec(),
            along: 0.0,
            column: column.iter().map(|c| c * span.scale()).collect(),
        };
        let found = match find(map, &guess, here.at, here.period, &condition) {
            Ok(found) => found,
            Err(reason) => {
                fault.get_or_insert(reason);
                continue;
            }
        };
        let off = distance(&found.u, &here.u);
        let half = found.period / 2;
        let repeats = |orbit: &Orbit| length(&orbit.offset(half)) <= 0.1 * away;
        let another = here.period == 1 || !repeats(here) || !repeats(&found);
        if off > 0.3 * away && off < 10.0 * away && another {
            return Ok(found);
        }
    }
    Err(fault.map_or(NoBranch::OnlyKnown, NoBranch::from))
}
