//! Which bifurcations lie between two neighbouring orbits of a branch, and exactly where?
//!
//! | bifurcation | function whose zero it is |
//! |---|---|
//! | fold, pitchfork, transcritical | `det(M − I)`: a multiplier +1; a fold where P_p is not in the range of M − I |
//! | period doubling | `det(M + I)` |
//! | torus (Neimark–Sacker) | `Π (μ_i μ_j − 1)` over i < j: a pair on the unit circle |
//! | graze | the depth of a contact at its extreme |
//! | merging | the displacement after half a period, projected on its value at the first orbit |
//!
//! M is the monodromy matrix of an orbit with the multipliers μ, and P_p the derivative of its end with respect to
//! the parameter. The functions of all multipliers keep their sign where real multipliers become a complex pair. Near a
//! zero, their smallest factor represents their size ([`Test::at`]).

use super::kind::{Kind, ON_CIRCLE, Test, critical, off_circle, pairs_outside};
use super::locate::{locate, merging};
use super::map::CycleMap;
use super::orbit::{Orbit, SAME_ORBIT, distance};
use super::path::Span;
use super::touches::Extreme;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Largest difference between two locations of the same bifurcation, relative to the interval.
const SAME_PLACE: f64 = 1e-9;
/// Largest difference between two times of the same graze \[mesh cycles\].
const SAME_TIME: f64 = 1e-3;

/// Arclength of a step below which a bifurcation other than a fold need not be located.
const FINE: f64 = 1e-5;

/// Angle \[rad\] from a strong resonance within which a pair of multipliers counts as resonant.
const RESONANT: f64 = 0.02;

/// A branch that begins at a bifurcation and is not followed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Unfollowed {
    /// The period of the branch is above the limit.
    #[error("period {period} is above longest_period")]
    PeriodTooLong {
        /// Period of the branch.
        period: u32,
    },
    /// The branch cannot be followed for another reason.
    #[error("a branch of period {period} is not followed: {reason}")]
    Lost {
        /// Period of the branch.
        period: u32,
        /// Why, in words.
        reason: String,
    },
}

/// A bifurcation.
#[derive(Debug, Clone)]
pub struct Bifurcation {
    /// The kind.
    pub kind: Kind,
    /// The orbit at the bifurcation.
    pub orbit: Orbit,
    /// Index of the last orbit of the branch before the bifurcation.
    pub after: usize,
    /// Arclength from the first orbit to the bifurcation.
    pub length: f64,
    /// Interval of the parameter that contains the bifurcation.
    pub bracket: [f64; 2],
    /// A branch that begins here and is not followed.
    pub unfollowed_branch: Option<Unfollowed>,
}

impl Bifurcation {
    fn new(kind: Kind, orbit: Orbit, length: f64, bracket: [f64; 2]) -> Self {
        Self {
            kind,
            orbit,
            after: 0,
            length,
            bracket,
            unfollowed_branch: None,
        }
    }

    /// Whether two records describe the same bifurcation, found twice.
    pub(super) fn is(&self, other: &Self, span: &Span) -> bool {
        let touches = match (self.kind, other.kind) {
            (Kind::Graze { extreme: a }, Kind::Graze { extreme: b }) => {
                a.contact == b.contact && (a.time - b.time).abs() < SAME_TIME
            }
            (a, b) => a == b,
        };
        let difference = (self.orbit.at[span.axis] - other.orbit.at[span.axis]).abs();
        touches
            && self.orbit.period == other.orbit.period
            && difference <= SAME_PLACE * span.scale()
            && distance(&self.orbit.u, &other.orbit.u) <= SAME_ORBIT * other.orbit.size()
    }

    /// The period of the orbits into which the branch merges here, if this is a merging.
    pub fn merges(&self) -> Option<u32> {
        match self.kind {
            Kind::Merging { period } => Some(period),
            _ => None,
        }
    }

    /// The multiplier on the unit circle, if there is one.
    pub fn critical(&self) -> Option<Complex64> {
        critical(&self.kind, &self.orbit).filter(|m| off_circle(&self.kind, *m) <= ON_CIRCLE)
    }

    /// The order q of the strong resonance (1:q) at which a torus begins, if any.
    pub fn resonance(&self) -> Option<u32> {
        let angle = self
            .critical()
            .filter(|_| self.kind == Kind::Torus)?
            .arg()
            .abs();
        (1..=4u32)
            .find(|&q| (angle - TAU / f64::from(q)).abs() < RESONANT || q == 1 && angle < RESONANT)
    }
}

/// The bifurcations between the last two of `knots`, in order. Each knot is an orbit of the branch with its
/// arclength. The result is `None` if a bifurcation cannot be located. The two orbits may then not be
/// neighbours on the branch, and the caller should retry with a shorter step. If no shorter step is possible
/// (`last_resort`), or for all kinds but folds if the step is short, the result has a wide bracket or is omitted.
pub fn between(
    map: &mut impl CycleMap,
    span: &Span,
    knots: &[(f64, &Orbit)],
    last_resort: bool,
) -> Option<Vec<Bifurcation>> {
    let [.., (s_a, a), (s_b, b)] = knots else {
        return Some(Vec::new());
    };
    let grazes = grazes(a, b);
    let explained = !grazes.is_empty();
    let mut bifurcations = Vec::new();
    let fine = last_resort || s_b - s_a < FINE;
    for (kind, test) in changed(a, b, grazes, map.unit()) {
        if let Kind::Merging { period } = kind
            && let Some((orbit, length, bracket)) = merging(map, span, knots, period)
        {
            bifurcations.push(Bifurcation::new(kind, orbit, length, bracket));
            continue;
        }
        let there = match locate(map, span, knots, &test) {
            Some(there) if there.narrow => there,
            // A fold that is not located requires a retry, because the orbits beyond it would be lost.
            _ if !last_resort && (kind == Kind::Fold || !fine) => return None,
            Some(there) => there,
            None => continue,
        };
        let Some(kind) = there.kind(map, span, knots, kind) else {
            continue;
        };
        bifurcations.push(Bifurcation::new(
            kind,
            there.orbit,
            there.length,
            there.bracket,
        ));
    }
    if !explained && !a.details.touches.is_cyclic_shift_of(&b.details.touches) {
        let mut bracket = [a.at[span.axis], b.at[span.axis]];
        bracket.sort_by(f64::total_cmp);
        bifurcations.push(Bifurcation::new(
            Kind::Sequence,
            (*b).clone(),
            *s_b,
            bracket,
        ));
    }
    bifurcations.sort_by(|a, b| a.length.total_cmp(&b.length));
    Some(bifurcations)
}

/// The test functions whose signs at two orbits differ, each with the kind of bifurcation that it suggests.
/// The excitation repeats after `unit` cycles.
fn changed(a: &Orbit, b: &Orbit, grazes: Vec<Extreme>, unit: u32) -> Vec<(Kind, Test)> {
    let mut tests = Vec::new();
    if Test::PlusOne.changes(a, b) {
        tests.push((Kind::Fold, Test::PlusOne));
    }
    if Test::MinusOne.changes(a, b) {
        tests.push((Kind::PeriodDoubling, Test::MinusOne));
    }
    if pairs_outside(a, 1.0) != pairs_outside(b, 1.0) && Test::Pair.changes(a, b) {
        tests.push((Kind::Torus, Test::Pair));
    }
    // A branch of doubled period merges into orbits of half its period.
    if b.period.is_multiple_of(2 * unit) {
        let period = b.period / 2;
        let test = Test::Offset(period, a.offset(period));
        if !a.repeats_sooner(unit) && test.changes(a, b) {
            tests.push((Kind::Merging { period }, test));
        }
    }
    let of_graze = |extreme| (Kind::Graze { extreme }, Test::Depth(extreme));
    tests.extend(grazes.into_iter().map(of_graze));
    tests
}

/// Extremes whose depths on the two orbits have different signs.
fn grazes(a: &Orbit, b: &Orbit) -> Vec<Extreme> {
    let period = f64::from(b.period);
    (a.details.touches.extremes.iter())
        .filter(|extreme| {
            let other = b.details.touches.nearest(extreme, period);
            let back = other.and_then(|other| a.details.touches.nearest(other, period));
            other.is_some_and(|other| other.depth * extreme.depth < 0.0) && back == Some(extreme)
        })
        .copied()
        .collect()
}

#[cfg(test)]
mod tests;
