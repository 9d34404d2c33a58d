//! Where exactly between two neighbouring orbits of a branch does a bifurcation lie?
//!
//! The two orbits bracket the zero of a test function. Secants and bisections narrow the bracket, with values at
//! corrected orbits. If the parameter reverses between the two orbits, further orbits are sought on planes across the
//! chord of the bracket. The branch crosses each of these planes, but has no orbit at parameters beyond the fold.

use super::kind::{Kind, ON_CIRCLE, Test, critical, is_branch_point, off_circle};
use super::map::CycleMap;
use super::orbit::{Orbit, OrbitCondition, distance, find};
use super::path::{LARGEST_DISTANCE, PathCondition, Span, Vector, guess, place_bare, tangent};
use num_complex::Complex64;

/// Accuracy to which a bifurcation is located, relative to the parameter's interval.
const LOCATED: f64 = 1e-12;

/// Arclength of a bracket below which a zero counts as located if the parameters of both ends are equal.
const NARROW: f64 = 1e-7;

/// Largest number of orbits computed to locate one zero.
const MOST_TRIALS: usize = 80;

/// Factor by which a step grows after a step that left more than half of the bracket.
const BEYOND: f64 = 4.0;

/// Shortest step inside a bracket, in arclength.
const SHORTEST: f64 = 0.25 * LOCATED;

/// A located zero of a test.
pub(super) struct Located {
    pub orbit: Orbit,
    pub length: f64,
    pub bracket: [f64; 2],
    /// The nearest orbits on both sides.
    sides: [Orbit; 2],
    /// Whether the zero is exact, or the bracket at most [`NARROW`] long.
    pub narrow: bool,
}

impl Located {
    /// The kind of bifurcation at the zero, from the kind that the test suggests. `None` if no multiplier
    /// crosses the unit circle, for example if two real multipliers have the product 1.
    pub fn kind(
        &self,
        map: &mut impl CycleMap,
        span: &Span,
        knots: &[(f64, &Orbit)],
        kind: Kind,
    ) -> Option<Kind> {
        let touches = &self.orbit.details.touches;
        let there = critical(&kind, &self.orbit);
        Some(match kind {
            Kind::Graze { extreme } => Kind::Graze {
                extreme: *touches
                    .nearest(&extreme, f64::from(self.orbit.period))
                    .unwrap_or(&extreme),
            },
            Kind::Fold if there.is_some_and(|m| off_circle(&kind, m) <= ON_CIRCLE) => {
                if is_branch_point(map, span, &self.orbit) {
                    Kind::BranchPoint
                } else {
                    Kind::Fold
                }
            }
            // If M jumps, the determinant changes its sign without a zero. If dp/ds also changes its sign,
            // the bifurcation is a fold.
            Kind::Fold if self.turns(map, span, knots) => Kind::Fold,
            Kind::PeriodDoubling | Kind::Torus
                if there.is_some_and(|m| off_circle(&kind, m) <= ON_CIRCLE) =>
            {
                kind
            }
            Kind::Merging { .. } => kind,
            _ if self.sides[0].unstable() == self.sides[1].unstable() => return None,
            _ => Kind::Jump,
        })
    }

    /// Whether the parameter reverses at the bifurcation, by the tangents on both sides.
    fn turns(&self, map: &mut impl CycleMap, span: &Span, knots: &[(f64, &Orbit)]) -> bool {
        let [.., (_, a), (_, b)] = knots else {
            return false;
        };
        let chords = [(*a, &self.sides[0]), (&self.sides[1], *b)].map(|(from, to)| {
            if distance(&from.u, &to.u) > 0.0 {
                Vector::between(span, from, to)
            } else {
                Vector::between(span, a, b)
            }
        });
        let mut runs = (self.sides.iter().zip(&chords)).map(|(orbit, chord)| {
            tangent(map, span, orbit).is_ok_and(|direction| direction.cosine(chord) > 0.0)
        });
        runs.next() != runs.next()
    }
}

/// Largest distance of a merging from the last orbit, relative to the parameter's interval, or the length of
/// the step if that is larger. The step is a chord across the merging and may be shorter than this distance.
const FARTHEST: f64 = 0.02;

/// The period doubling of the orbits of period `period`, at which the branch merges into them: the orbit, the arclength
/// at the end of the step, and the bracket of the parameter. `None` if it is not found. The search follows these
/// orbits, because the equations of the branch itself are singular there.
pub(super) fn merging(
    map: &mut impl CycleMap,
    span: &Span,
    knots: &[(f64, &Orbit)],
    period: u32,
) -> Option<(Orbit, f64, [f64; 2])> {
    let [.., (s_a, a), (s_b, _)] = knots else {
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
        let orbit = find(map, guess, at, period, &OrbitCondition::Parameters).ok()?;
        // det(M + I), which stays smooth where two real multipliers become a pair.
        let determinant: Complex64 = orbit.multipliers.iter().map(|m| m + 1.0).product();
        Some((value, determinant.re, orbit))
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
    // A period doubling far beyond the step belongs to another branch.
    if (newer.0 - start).abs() > (s_b - s_a).max(FARTHEST) * span.scale() {
        return None;
    }
    // If a multiplier jumps past −1, the determinant has no zero.
    let there = critical(&Kind::PeriodDoubling, &newer.2)?;
    if (there + 1.0).norm() > ON_CIRCLE {
        return None;
    }
    let mut bracket = [older.0, newer.0];
    bracket.sort_by(f64::total_cmp);
    Some((newer.2, *s_b, bracket))
}

/// Fractions of a bracket at which an orbit is sought, in this order, if no orbit is found at the first
/// choice.
const PARTS: [f64; 4] = [0.5, 0.3, 0.7, 0.1];

/// The zero of a test between the last two of `knots`; `None` if the test has no value at one of them.
pub(super) fn locate(
    map: &mut impl CycleMap,
    span: &Span,
    knots: &[(f64, &Orbit)],
    test: &Test,
) -> Option<Located> {
    let [.., (s_a, a), (s_b, b)] = knots else {
        return None;
    };
    let reference = test.at(a)?.0.max(test.at(b)?.0);
    let value = |orbit: &Orbit| {
        test.at(orbit)
            .map(|(size, sign)| sign * (size - reference).exp())
    };
    let mut low = (*s_a, value(a)?, (*a).clone());
    let mut high = (*s_b, value(b)?, (*b).clone());
    // If the parameter reverses in the bracket, Newton's method at a given parameter cannot reach the fold.
    let turns = Test::PlusOne.changes(a, b);
    let mut exact = None;
    let (mut before, mut misses) = (f64::INFINITY, 0);
    for _ in 0..MOST_TRIALS {
        let width = high.0 - low.0;
        let p = [&low, &high].map(|end| end.2.at[span.axis]);
        let approached = !is_fold_inexact(test, &nearer(&low, &high).2);
        let together = (p[0] - p[1]).abs() <= LOCATED * span.scale();
        if width <= LOCATED || together && width <= NARROW && approached {
            break;
        }
        misses = if width > 0.5 * before { misses + 1 } else { (misses - 1).max(0) };
        before = width;
        let part = match test {
            // Beyond a merging, the offset has only a sign and no useful value.
            Test::Offset(..) => 0.5,
            _ => beyond_secant(low.1 / (low.1 - high.1), width, misses),
        };
        let needs_details = matches!(test, Test::Depth(_) | Test::Offset(..));
        let ends = [&low, &high].map(|end| (end.0, &end.2));
        let mut parts = std::iter::once(part).chain(PARTS);
        let middle = parts.find_map(|part| {
            let (s, orbit) = inside(map, span, knots, ends, part, turns)?;
            let orbit = if needs_details { orbit.with_details(map).ok()? } else { orbit };
            Some((s, value(&orbit)?, orbit))
        });
        let Some(middle) = middle else { break };
        if middle.1 == 0.0 {
            exact = Some(middle);
            break;
        }
        if (middle.1 > 0.0) == (low.1 > 0.0) {
            low = middle;
        } else {
            high = middle;
        }
    }
    let narrow = exact.is_some() || high.0 - low.0 <= NARROW;
    let (length, _, orbit) = exact.unwrap_or_else(|| nearer(&low, &high).clone());
    let mut bracket = [low.2.at[span.axis], high.2.at[span.axis]];
    bracket.sort_by(f64::total_cmp);
    Some(Located {
        orbit: orbit.with_details(map).ok()?,
        length,
        bracket,
        sides: [low.2, high.2],
        narrow,
    })
}

/// The end of a bracket whose value is closer to zero. Each end has its arclength, value and orbit.
fn nearer<'a>(low: &'a (f64, f64, Orbit), high: &'a (f64, f64, Orbit)) -> &'a (f64, f64, Orbit) {
    if low.1.abs() < high.1.abs() { low } else { high }
}

/// The fraction of a bracket at which to evaluate the function next. Its secant is zero at the fraction
/// `secant`. If the secants always stop on the same side of the zero, the bracket hardly shrinks. Therefore,
/// after each of `misses` steps that left more than half of the bracket, the next step is longer, up to the
/// middle.
fn beyond_secant(secant: f64, width: f64, misses: i32) -> f64 {
    let nearer = secant.min(1.0 - secant).max(SHORTEST / width);
    let reach = (nearer * BEYOND.powi(misses)).min(0.5);
    if secant < 0.5 { reach } else { 1.0 - reach }
}

/// Whether a fold is sought and the orbit's multiplier is not yet close enough to +1.
fn is_fold_inexact(test: &Test, orbit: &Orbit) -> bool {
    matches!(test, Test::PlusOne)
        && critical(&Kind::Fold, orbit)
            .is_none_or(|m| off_circle(&Kind::Fold, m) > 0.01 * ON_CIRCLE)
}

/// An orbit between two neighbours at a fraction of their chord, with its arclength.
fn inside(
    map: &mut impl CycleMap,
    span: &Span,
    knots: &[(f64, &Orbit)],
    ends: [(f64, &Orbit); 2],
    part: f64,
    turns: bool,
) -> Option<(f64, Orbit)> {
    let [(s_low, low), (s_high, high)] = ends;
    let width = s_high - s_low;
    let s = s_low + part * width;
    let far = |k: &&(f64, &Orbit)| ends.iter().all(|o| (o.0 - k.0).abs() > 0.1 * width);
    let chosen: Vec<(f64, &Orbit)> = ends
        .iter()
        .chain(knots.iter().filter(far))
        .copied()
        .collect();
    let chord = Vector::between(span, low, high);
    let across = if turns { PathCondition::Always(&chord) } else { PathCondition::Steep(&chord) };
    // At a corner of the branch, a polynomial is a bad guess, but a chord is not.
    [guess(span, &chosen, s), guess(span, &ends, s)]
        .into_iter()
        .find_map(|guess| {
            let orbit = place_bare(map, span, low, &guess, across).ok()?;
            let along = Vector::between(span, low, &orbit);
            let cosine = along.cosine(&chord);
            let place = cosine * along.length() / chord.length();
            let off = (1.0 - cosine * cosine).max(0.0).sqrt() * along.length();
            (place > 0.0 && place < 1.0 && off <= LARGEST_DISTANCE * chord.length())
                .then_some((s, orbit))
        })
}
