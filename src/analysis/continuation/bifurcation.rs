//! What happens between two neighbouring orbits of a branch, and exactly where.
//!
//! | what | function whose zero it is |
//! |---|---|
//! | fold, pitchfork, transcritical | `det(M − I)`: a multiplier +1; a fold where P_p is not in the range of M − I |
//! | period doubling | `det(M + I)` |
//! | torus (Neimark–Sacker) | `Π (μ_i μ_j − 1)` over i < j: a pair on the unit circle |
//! | graze | the extreme of a contact's depth |
//! | merging | the offset of a part of the period, along itself |
//!
//! Functions of all multipliers are smooth where single ones meet and part.

use super::locate::{locate, merging};
use super::map::CycleMap;
use super::orbit::{Orbit, SAME_ORBIT, distance, length};
use super::path::Span;
use super::touches::Extreme;
use crate::numerics::linalg::eigenpair;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Part of the interval by which a bifurcation found twice may differ, and time in cycles by which its graze may.
const SAME_PLACE: f64 = 1e-9;
const SAME_TIME: f64 = 1e-3;

/// Step below which what is not a turn of the branch need not be located.
const FINE: f64 = 1e-5;

/// Part of P_p outside the range of M − I from which a multiplier +1 is a fold.
const OUT_OF_RANGE: f64 = 1e-6;

/// Distance from the unit circle, or from ±1, at which a multiplier counts as on it.
pub(super) const ON_CIRCLE: f64 = 1e-4;

/// Angle \[rad\] from a strong resonance at which a pair counts as resonant.
const RESONANT: f64 = 0.02;

/// What happens on a branch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// The branch turns: two orbits meet.
    Fold,
    /// A multiplier +1 without a turn: another branch crosses.
    BranchPoint,
    /// A multiplier −1: an orbit of twice the period begins.
    PeriodDoubling,
    /// A pair on the unit circle: a torus begins.
    Torus,
    /// An extreme touches a contact's surface.
    Graze {
        /// The extreme.
        extreme: Extreme,
    },
    /// Multipliers jump across the unit circle where the map has a corner, and the branch goes on the same way.
    Jump,
    /// The sequence of contact changes becomes another, and no extreme on a surface says how.
    Sequence,
    /// The orbit becomes one of a part of its period, where that doubles.
    Merging {
        /// That part, in cycles.
        period: u32,
    },
}

impl Kind {
    /// The word stored in result files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Fold => "fold",
            Self::BranchPoint => "branch_point",
            Self::PeriodDoubling => "period_doubling",
            Self::Torus => "torus",
            Self::Graze { .. } => "graze",
            Self::Jump => "jump",
            Self::Sequence => "sequence",
            Self::Merging { .. } => "merging",
        }
    }
}

/// A branch that begins at a bifurcation and is not followed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Unfollowed {
    /// Its period is longer than asked for.
    #[error("period {period} is above longest_period")]
    Long {
        /// Its period.
        period: u32,
    },
    /// Something else.
    #[error("a branch of period {period} is not followed: {reason}")]
    Lost {
        /// Its period.
        period: u32,
        /// Why, in words.
        reason: String,
    },
}

/// A bifurcation.
#[derive(Debug, Clone)]
pub struct Bifurcation {
    /// What happens.
    pub kind: Kind,
    /// The orbit there.
    pub orbit: Orbit,
    /// The orbit of the branch that comes before it.
    pub after: usize,
    /// Length of branch from its first orbit.
    pub length: f64,
    /// Interval of the parameter in which it lies.
    pub bracket: [f64; 2],
    /// A branch that begins here and is not followed.
    pub lost: Option<Unfollowed>,
}

impl Bifurcation {
    fn new(kind: Kind, orbit: Orbit, length: f64, bracket: [f64; 2]) -> Self {
        Self {
            kind,
            orbit,
            after: 0,
            length,
            bracket,
            lost: None,
        }
    }

    /// Whether it is another one found anew.
    pub(super) fn is(&self, other: &Self, span: &Span) -> bool {
        let touches = match (self.kind, other.kind) {
            (Kind::Graze { extreme: a }, Kind::Graze { extreme: b }) => {
                a.contact == b.contact && (a.time - b.time).abs() < SAME_TIME
            }
            (a, b) => a == b,
        };
        let apart = (self.orbit.at[span.axis] - other.orbit.at[span.axis]).abs();
        touches
            && self.orbit.period == other.orbit.period
            && apart <= SAME_PLACE * span.scale()
            && distance(&self.orbit.u, &other.orbit.u) <= SAME_ORBIT * other.orbit.size()
    }

    /// The period of the orbits that a branch ends in, where it does.
    pub fn merges(&self) -> Option<u32> {
        match self.kind {
            Kind::Merging { period } => Some(period),
            _ => None,
        }
    }

    /// The multiplier on the unit circle, where one is.
    pub fn critical(&self) -> Option<Complex64> {
        critical(&self.kind, &self.orbit).filter(|m| off_circle(&self.kind, *m) <= ON_CIRCLE)
    }

    /// The strong resonance that a torus begins in, if any: q of q turns.
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

/// The multiplier of an orbit that is next to where a bifurcation of some kind has one.
pub(super) fn critical(kind: &Kind, orbit: &Orbit) -> Option<Complex64> {
    let near = |wanted: f64| {
        let real = orbit.multipliers.iter().filter(|m| m.im == 0.0);
        real.min_by(|a, b| (a.re - wanted).abs().total_cmp(&(b.re - wanted).abs()))
            .copied()
    };
    match kind {
        Kind::Fold | Kind::BranchPoint => near(1.0),
        Kind::PeriodDoubling => near(-1.0),
        Kind::Torus => {
            let pairs = orbit.multipliers.iter().filter(|m| m.im > 0.0);
            pairs
                .min_by(|a, b| (a.norm() - 1.0).abs().total_cmp(&(b.norm() - 1.0).abs()))
                .copied()
        }
        Kind::Graze { .. } | Kind::Jump | Kind::Sequence | Kind::Merging { .. } => None,
    }
}

/// A function whose zero is a bifurcation.
#[derive(Debug, Clone)]
pub enum Test {
    /// `det(M − I)`.
    PlusOne,
    /// `det(M + I)`.
    MinusOne,
    /// `Π (μ_i μ_j − 1)`.
    Pair,
    /// The depth of the extreme nearest in time to one.
    Depth(Extreme),
    /// The offset after some cycles, along its value at the first orbit.
    Offset(u32, Vec<f64>),
}

/// The logarithm of a product's size and its sign.
fn product(factors: impl Iterator<Item = Complex64>) -> (f64, f64) {
    let (mut size, mut sign) = (0.0, 1.0);
    for factor in factors {
        size += factor.norm().ln();
        // Complex factors come in pairs, whose product is positive.
        if factor.im == 0.0 && factor.re < 0.0 {
            sign = -sign;
        }
    }
    (size, sign)
}

impl Test {
    /// Its value at an orbit: a logarithm of its size to be compared with others of the same test, and
    /// a sign. None where the orbit has no such extreme.
    pub fn at(&self, orbit: &Orbit) -> Option<(f64, f64)> {
        let all = &orbit.multipliers;
        Some(match self {
            Self::PlusOne => product(all.iter().map(|m| m - 1.0)),
            Self::MinusOne => product(all.iter().map(|m| m + 1.0)),
            Self::Pair => {
                let pairs = (0..all.len()).flat_map(|i| (0..i).map(move |j| all[i] * all[j] - 1.0));
                let real = |z: Complex64| {
                    if z.im.abs() <= 1e-14 * z.norm() {
                        Complex64::new(z.re, 0.0)
                    } else {
                        z
                    }
                };
                product(pairs.map(real))
            }
            Self::Depth(extreme) => signed(
                orbit
                    .details
                    .touches
                    .nearest(extreme, f64::from(orbit.period))?
                    .depth,
            ),
            Self::Offset(cycles, along) => {
                let offset = orbit.offset(*cycles);
                let dot: f64 = offset.iter().zip(along).map(|(a, b)| a * b).sum();
                // Orbits of the shorter period lie beyond the end of the branch.
                match dot / length(along) {
                    off if off.abs() < SAME_ORBIT * orbit.size() => signed(-SAME_ORBIT),
                    off => signed(off),
                }
            }
        })
    }

    /// Whether it has another sign at one orbit than at the other.
    pub fn changes(&self, a: &Orbit, b: &Orbit) -> bool {
        matches!((self.at(a), self.at(b)), (Some(a), Some(b)) if a.1 != b.1)
    }
}

/// Complex multipliers outside a circle of some radius.
pub(super) fn pairs_outside(orbit: &Orbit, radius: f64) -> usize {
    let outside = |m: &&Complex64| m.im != 0.0 && m.norm() > radius;
    orbit.multipliers.iter().filter(outside).count()
}

fn signed(value: f64) -> (f64, f64) {
    (value.abs().ln(), if value < 0.0 { -1.0 } else { 1.0 })
}

/// What happens between the last two of some orbits of a branch, in order; knots are lengths of branch
/// and orbits. None where it is not found, so that the two may not be neighbours at all: a shorter step tells,
/// unless there is none (`last_resort`).
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
    let mut found = Vec::new();
    let fine = last_resort || s_b - s_a < FINE;
    for (kind, test) in changed(a, b, grazes) {
        if let Kind::Merging { period } = kind
            && let Some((orbit, length, bracket)) = merging(map, span, knots, period)
        {
            found.push(Bifurcation::new(kind, orbit, length, bracket));
            continue;
        }
        let there = match locate(map, span, knots, &test) {
            Some(there) if there.narrow => there,
            // Whether the branch turns must be known: its other orbits would be lost.
            _ if !last_resort && (kind == Kind::Fold || !fine) => return None,
            Some(there) => there,
            None => continue,
        };
        let Some(kind) = there.kind(map, span, knots, kind) else {
            continue;
        };
        found.push(Bifurcation::new(
            kind,
            there.orbit,
            there.length,
            there.bracket,
        ));
    }
    if !explained && !a.details.touches.alike(&b.details.touches) {
        let mut bracket = [a.at[span.axis], b.at[span.axis]];
        bracket.sort_by(f64::total_cmp);
        found.push(Bifurcation::new(
            Kind::Sequence,
            (*b).clone(),
            *s_b,
            bracket,
        ));
    }
    found.sort_by(|a, b| a.length.total_cmp(&b.length));
    Some(found)
}

/// The functions that change their sign from one orbit to the next, with what that is at first sight.
fn changed(a: &Orbit, b: &Orbit, grazes: Vec<Extreme>) -> Vec<(Kind, Test)> {
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
    // A branch of doubled period comes home at half of it.
    if b.period.is_multiple_of(2) {
        let period = b.period / 2;
        let test = Test::Offset(period, a.offset(period));
        if !a.repeats_sooner() && test.changes(a, b) {
            tests.push((Kind::Merging { period }, test));
        }
    }
    let of_graze = |extreme| (Kind::Graze { extreme }, Test::Depth(extreme));
    tests.extend(grazes.into_iter().map(of_graze));
    tests
}

/// Extremes whose depth changes its sign from one orbit to the other.
fn grazes(a: &Orbit, b: &Orbit) -> Vec<Extreme> {
    let period = f64::from(b.period);
    (a.details.touches.extremes.iter())
        .filter(|own| {
            let other = b.details.touches.nearest(own, period);
            let back = other.and_then(|other| a.details.touches.nearest(other, period));
            other.is_some_and(|other| other.depth * own.depth < 0.0) && back == Some(own)
        })
        .copied()
        .collect()
}

/// Whether P_p lies in the range of M − I: with ψ the left null vector of M − I, a fold has `ψ·P_p ≠ 0`.
pub(super) fn crosses(map: &mut impl CycleMap, span: &Span, orbit: &Orbit) -> bool {
    let column = map.by_parameter(&orbit.u, orbit.at, orbit.period, span.axis);
    let transposed = orbit.monodromy.transpose().to_owned();
    let null = eigenpair(transposed.as_ref(), Complex64::ONE);
    let (Ok(column), Some(null)) = (column, null) else {
        return false;
    };
    let along: f64 = null.vector[0].iter().zip(&column).map(|(a, b)| a * b).sum();
    along.abs() <= OUT_OF_RANGE * length(&column)
}

/// Distance of a multiplier from where a bifurcation has it.
pub(super) fn off_circle(kind: &Kind, multiplier: Complex64) -> f64 {
    match kind {
        Kind::PeriodDoubling => (multiplier + 1.0).norm(),
        Kind::Torus => (multiplier.norm() - 1.0).abs(),
        _ => (multiplier - 1.0).norm(),
    }
}

#[cfg(test)]
mod tests;
