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
//! Functions of all multipliers are smooth where single ones meet and part. A zero is bracketed by
//! the two orbits and found by secants, every fourth step a halving, every value being that of a
//! corrected orbit.

use super::map::CycleMap;
use super::orbit::{Border, NoOrbit, Orbit, SAME_ORBIT, find, length};
use super::path::{Span, Vector, guess, place_bare};
use super::touches::Extreme;
use crate::numerics::linalg::eigenpair;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Part of the parameter's interval to which a bifurcation is located.
const LOCATED: f64 = 1e-12;

/// Most orbits that a location takes.
const MOST_TRIALS: usize = 60;

/// Part of P_p outside the range of M − I from which a multiplier +1 is a fold.
const OUT_OF_RANGE: f64 = 1e-6;

/// Distance from the unit circle, or from ±1, at which a multiplier counts as on it.
const ON_CIRCLE: f64 = 1e-4;

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
    /// Multipliers jump across the unit circle, at a graze or another corner of the map.
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
}

impl Bifurcation {
    /// The period of the orbits that a branch ends in, where it does.
    pub fn merges(&self) -> Option<u32> {
        match self.kind {
            Kind::Merging { period } => Some(period),
            _ => None,
        }
    }

    /// The multiplier on the unit circle, where one is.
    pub fn critical(&self) -> Option<Complex64> {
        critical(&self.kind, &self.orbit)
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
                    off if off.abs() < SAME_ORBIT => signed(-SAME_ORBIT),
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
/// and orbits.
pub fn between(map: &mut impl CycleMap, span: &Span, knots: &[(f64, &Orbit)]) -> Vec<Bifurcation> {
    let [.., (_, a), (_, b)] = knots else {
        return Vec::new();
    };
    let mut tests: Vec<(Option<Kind>, Test)> = Vec::new();
    if Test::PlusOne.changes(a, b) {
        tests.push((None, Test::PlusOne));
    }
    if Test::MinusOne.changes(a, b) {
        tests.push((Some(Kind::PeriodDoubling), Test::MinusOne));
    }
    if pairs_outside(a, 1.0) != pairs_outside(b, 1.0) && Test::Pair.changes(a, b) {
        tests.push((Some(Kind::Torus), Test::Pair));
    }
    // A branch of doubled period comes home at half of it.
    if b.period.is_multiple_of(2) {
        let period = b.period / 2;
        let test = Test::Offset(period, a.offset(period));
        if !a.repeats_sooner() && test.changes(a, b) {
            tests.push((Some(Kind::Merging { period }), test));
        }
    }
    let grazes = grazes(a, b);
    let explained = !grazes.is_empty();
    tests.extend(
        grazes
            .into_iter()
            .map(|extreme| (Some(Kind::Graze { extreme }), Test::Depth(extreme))),
    );
    let mut found: Vec<Bifurcation> = (tests.into_iter())
        .filter_map(|(kind, test)| {
            let (orbit, length, bracket) = match kind {
                Some(Kind::Merging { period }) => {
                    merging(map, span, knots, period).or_else(|| locate(map, span, knots, &test))?
                }
                _ => locate(map, span, knots, &test)?,
            };
            let kind = match kind {
                Some(Kind::Graze { extreme }) => Kind::Graze {
                    extreme: *orbit
                        .details
                        .touches
                        .nearest(&extreme, f64::from(orbit.period))
                        .unwrap_or(&extreme),
                },
                Some(kind) => kind,
                None => turns(map, span, &orbit),
            };
            // Where a graze lets a multiplier jump, the determinant changes its sign without a zero.
            let wanted = |m: Complex64| match kind {
                Kind::PeriodDoubling => (m + 1.0).norm(),
                Kind::Torus => (m.norm() - 1.0).abs(),
                _ => (m - 1.0).norm(),
            };
            let jumps = match critical(&kind, &orbit) {
                Some(multiplier) => wanted(multiplier) > ON_CIRCLE,
                None => !matches!(kind, Kind::Graze { .. } | Kind::Merging { .. }),
            };
            let kind = if jumps { Kind::Jump } else { kind };
            Some(Bifurcation {
                kind,
                orbit,
                after: 0,
                length,
                bracket,
            })
        })
        .collect();
    if !explained && !a.details.touches.alike(&b.details.touches) {
        let bracket = [a.at[span.axis], b.at[span.axis]];
        let length = knots[knots.len() - 1].0;
        found.push(Bifurcation {
            kind: Kind::Sequence,
            orbit: (*b).clone(),
            after: 0,
            length,
            bracket,
        });
    }
    found.sort_by(|a, b| a.length.total_cmp(&b.length));
    found
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

/// A fold, or a crossing of branches: with ψ the left null vector of M − I, a fold has `ψ·P_p ≠ 0`.
fn turns(map: &mut impl CycleMap, span: &Span, orbit: &Orbit) -> Kind {
    let column = map.by_parameter(&orbit.u, orbit.at, orbit.period, span.axis);
    let transposed = orbit.monodromy.transpose().to_owned();
    let null = eigenpair(transposed.as_ref(), Complex64::ONE);
    let (Ok(column), Some(null)) = (column, null) else {
        return Kind::Fold;
    };
    let along: f64 = null.vector[0].iter().zip(&column).map(|(a, b)| a * b).sum();
    let size = column.iter().map(|c| c * c).sum::<f64>().sqrt();
    match along.abs() > OUT_OF_RANGE * size {
        true => Kind::Fold,
        false => Kind::BranchPoint,
    }
}

/// Where the orbits of a part of the period double: the place where a branch merges into them. On that
/// branch itself the equations are singular there.
fn merging(
    map: &mut impl CycleMap,
    span: &Span,
    knots: &[(f64, &Orbit)],
    period: u32,
) -> Option<(Orbit, f64, [f64; 2])> {
    let [.., (_, a), (s_b, _)] = knots else {
        return None;
    };
    let halfway = |orbit: &Orbit| -> Vec<f64> {
        let later = &orbit.details.strobes[period as usize];
        orbit
            .u
            .iter()
            .zip(later)
            .map(|(a, b)| 0.5 * (a + b))
            .collect()
    };
    let mut parent = |guess: &[f64], value: f64| -> Option<(f64, f64, Orbit)> {
        let mut at = a.at;
        at[span.axis] = value;
        let orbit = find(map, guess, at, period, &Border::Parameters).ok()?;
        let (size, sign) = Test::MinusOne.at(&orbit)?;
        Some((value, sign * size.exp(), orbit))
    };
    let start = a.at[span.axis];
    let mut older = parent(&halfway(a), start)?;
    let mut newer = parent(&older.2.u, start + 1e-6 * span.scale())?;
    for _ in 0..MOST_TRIALS {
        let change = -newer.1 * (newer.0 - older.0) / (newer.1 - older.1);
        if !change.is_finite() || change.abs() > 0.1 * span.scale() {
            return None;
        }
        let next = parent(&newer.2.u, newer.0 + change)?;
        older = std::mem::replace(&mut newer, next);
        if change.abs() <= LOCATED * span.scale() || newer.1 == 0.0 {
            break;
        }
    }
    // Where multipliers jump the determinant has no zero.
    let there = critical(&Kind::PeriodDoubling, &newer.2)?;
    if (there + 1.0).norm() > ON_CIRCLE {
        return None;
    }
    let mut bracket = [older.0, newer.0];
    bracket.sort_by(f64::total_cmp);
    Some((newer.2, *s_b, bracket))
}

/// The zero of a test between the last two orbits: the orbit there, its length, its bracket.
fn locate(
    map: &mut impl CycleMap,
    span: &Span,
    knots: &[(f64, &Orbit)],
    test: &Test,
) -> Option<(Orbit, f64, [f64; 2])> {
    let [.., (s_a, a), (s_b, b)] = knots else {
        return None;
    };
    let chord = Vector::between(span, a, b);
    let reference = test.at(a)?.0.max(test.at(b)?.0);
    let value = |orbit: &Orbit| {
        test.at(orbit)
            .map(|(size, sign)| sign * (size - reference).exp())
    };
    let mut low = (*s_a, value(a)?, (*a).clone());
    let mut high = (*s_b, value(b)?, (*b).clone());
    let watched = matches!(test, Test::Depth(_) | Test::Offset(..));
    let mut best: Option<(f64, f64, Orbit)> = None;
    for trial in 0..MOST_TRIALS {
        let width = high.0 - low.0;
        let p = [&low, &high].map(|end| end.2.at[span.axis]);
        if width.abs() <= LOCATED
            || (p[0] - p[1]).abs() <= LOCATED * span.scale() && width.abs() <= 1e-7
        {
            break;
        }
        // Every fourth step halves, so that the bracket shrinks in any case; of orbits that have come home
        // nothing but that is known.
        let part = match (trial % 4, test) {
            (3, _) | (_, Test::Offset(..)) => 0.5,
            _ => (low.1 / (low.1 - high.1)).clamp(1e-3, 1.0 - 1e-3),
        };
        let s = low.0 + part * width;
        let mut near = knots.to_vec();
        near.push((low.0, &low.2));
        near.push((high.0, &high.2));
        near.dedup_by(|a, b| a.0 == b.0);
        let own = [(low.0, &low.2), (high.0, &high.2)];
        let others = near
            .iter()
            .filter(|k| own.iter().all(|o| (o.0 - k.0).abs() > 0.1 * width));
        let chosen: Vec<(f64, &Orbit)> = own.iter().chain(others).copied().collect();
        let there: Result<Orbit, NoOrbit> =
            place_bare(map, span, a, &guess(span, &chosen, s), &chord).and_then(|found| {
                match watched {
                    true => found.with_details(map),
                    false => Ok(found),
                }
            });
        let Ok(orbit) = there else { break };
        let Some(own) = value(&orbit) else { break };
        let middle = (s, own, orbit);
        let better = best
            .as_ref()
            .is_none_or(|(_, known, _)| middle.1.abs() < known.abs());
        if better {
            best = Some(middle.clone());
        }
        if middle.1 == 0.0 {
            break;
        }
        if (middle.1 > 0.0) == (low.1 > 0.0) {
            low = middle;
        } else {
            high = middle;
        }
    }
    let (s, _, orbit) = best.unwrap_or(if low.1.abs() < high.1.abs() {
        low.clone()
    } else {
        high.clone()
    });
    let mut bracket = [low.2.at[span.axis], high.2.at[span.axis]];
    bracket.sort_by(f64::total_cmp);
    Some((orbit.with_details(map).ok()?, s, bracket))
}

#[cfg(test)]
mod tests;
