//! A bifurcation followed in two parameters.
//!
//! At one parameter held, the other is sought where the test of the bifurcation vanishes, each value
//! being that of a corrected orbit: of a fold, which has no orbits on one side, on a plane across its
//! null vector. Which parameter is held follows the direction of the curve.

use super::bifurcation::{Bifurcation, Kind, Test, critical, pairs_outside};
use super::map::{At, CycleMap};
use super::orbit::{Border, NoOrbit, Orbit, correct, distance};
use crate::numerics::linalg::eigenpair;
use num_complex::Complex64;
use std::f64::consts::{PI, TAU};

/// How a curve is followed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Smallest values of both parameters.
    pub from: At,
    /// Largest values.
    pub to: At,
    /// Longest step, as a part of the intervals.
    pub longest: f64,
    /// Most points one way.
    pub most: usize,
}

impl Plane {
    fn scale(&self, axis: usize) -> f64 {
        self.to[axis] - self.from[axis]
    }

    fn holds(&self, at: At) -> bool {
        (0..2).all(|axis| (self.from[axis]..=self.to[axis]).contains(&at[axis]))
    }

    /// Distance of two places, as a part of the intervals.
    pub fn apart(&self, a: At, b: At) -> f64 {
        ((a[0] - b[0]) / self.scale(0)).hypot((a[1] - b[1]) / self.scale(1))
    }
}

/// A point of a curve, with what happens there besides.
#[derive(Debug, Clone)]
pub struct CurvePoint {
    /// The orbit.
    pub orbit: Orbit,
    /// Codimension two between the point before and this one, in words.
    pub note: Option<&'static str>,
}

/// A bifurcation curve.
#[derive(Debug, Clone)]
pub struct Curve {
    /// What happens on it.
    pub kind: Kind,
    /// Its points, in order.
    pub points: Vec<CurvePoint>,
    /// Why it ends at the first and the last.
    pub ends: [&'static str; 2],
}

/// Why most curves end that do not leave the plane.
const NO_ORBIT: &str = "no orbit is found beyond";

/// First step and shortest step, as parts of the intervals.
const FIRST: f64 = 2e-3;
const SHORTEST: f64 = 1e-6;

/// Largest turn of a curve from step to step \[rad\].
const LARGEST_TURN: f64 = 0.5;

/// Part of an interval to which a point is located, and most orbits that it takes.
const LOCATED: f64 = 1e-10;
const MOST_TRIALS: usize = 60;

/// Logarithm of a test that is none: of a depth in half gaps.
const NEARLY_ZERO: f64 = -23.0;

/// Places tried first, as parts of the interval: on one side of a graze there may be no orbit.
const FIRST_PLACES: [f64; 7] = [0.0, 1e-4, -1e-4, 1e-3, -1e-3, 5e-3, -5e-3];

/// How often a place without an orbit is brought nearer.
const MOST_REFUSALS: usize = 12;

/// First change of the sought parameter, as a part of its interval, or of ξ \[half gaps\].
const FIRST_TRIAL: f64 = 1e-5;

/// Follows a bifurcation in the plane of both parameters, both ways.
pub fn follow(map: &mut impl CycleMap, plane: &Plane, start: &Bifurcation) -> Option<Curve> {
    let test = match start.kind {
        Kind::Fold => Test::PlusOne,
        Kind::PeriodDoubling => Test::MinusOne,
        Kind::Torus => Test::Pair,
        Kind::Graze { extreme } => Test::Depth(extreme),
        Kind::BranchPoint | Kind::Jump | Kind::Sequence | Kind::Merging { .. } => return None,
    };
    let own = CurvePoint {
        orbit: start.orbit.clone(),
        note: None,
    };
    // Along the second parameter at first; along the first where the curve turns in the second.
    let mut both = None;
    for axis in [1, 0] {
        let towards = |sense: f64| std::array::from_fn(|i| if i == axis { sense } else { 0.0 });
        let (back, first) = one_way(map, plane, &start.kind, &test, &own, towards(-1.0));
        let (ahead, last) = match first {
            "closed" => (Vec::new(), first),
            _ => one_way(map, plane, &start.kind, &test, &own, towards(1.0)),
        };
        let found = back.len() + ahead.len();
        both = Some((back, ahead, [first, last]));
        if found > 0 {
            break;
        }
    }
    let (mut back, ahead, [first, last]) = both?;
    back.reverse();
    back.push(own);
    back.extend(ahead);
    Some(Curve {
        kind: start.kind,
        points: back,
        ends: [first, last],
    })
}

fn one_way(
    map: &mut impl CycleMap,
    plane: &Plane,
    kind: &Kind,
    test: &Test,
    start: &CurvePoint,
    mut direction: [f64; 2],
) -> (Vec<CurvePoint>, &'static str) {
    let mut points = vec![start.clone()];
    let mut test = test.clone();
    let mut step = FIRST;
    let end = loop {
        if points.len() > plane.most {
            break "as many points as asked for";
        }
        let last = &points[points.len() - 1].orbit;
        let target: At = std::array::from_fn(|i| last.at[i] + step * direction[i] * plane.scale(i));
        let held = if direction[1].abs() >= direction[0].abs() {
            1
        } else {
            0
        };
        let known: Vec<&Orbit> = points.iter().rev().take(3).map(|p| &p.orbit).collect();
        let found = point(map, plane, kind, &test, &known, target, held)
            .and_then(|orbit| orbit.with_details(map).map_err(|_| NO_ORBIT));
        match found {
            Ok(orbit) => {
                let turn = turned(plane, direction, last.at, orbit.at);
                let far = plane.apart(last.at, orbit.at) > 3.0 * step;
                let cusp = *kind == Kind::Fold && turn > 0.7 * PI && points.len() > 2;
                if (turn > LARGEST_TURN && points.len() > 1 && !cusp) || far {
                    step *= 0.4;
                    if step < SHORTEST {
                        break "the curve turns sharply";
                    }
                    continue;
                }
                if !plane.holds(orbit.at) {
                    points.push(CurvePoint { orbit, note: None });
                    break "the interval ends";
                }
                let note = match cusp {
                    true => Some("cusp"),
                    false => codimension_two(kind, last, &orbit),
                };
                let apart = plane.apart(last.at, orbit.at);
                if apart > 0.0 {
                    direction = std::array::from_fn(|i| {
                        (orbit.at[i] - last.at[i]) / plane.scale(i) / apart
                    });
                }
                if let (Test::Depth(extreme), true) = (&mut test, true)
                    && let Some(now) = orbit
                        .details
                        .touches
                        .nearest(extreme, f64::from(orbit.period))
                {
                    *extreme = *now;
                }
                let closed = points.len() > 10
                    && plane.apart(orbit.at, start.orbit.at) < apart
                    && distance(&orbit.u, &start.orbit.u) < 0.2;
                points.push(CurvePoint { orbit, note });
                if closed {
                    break "closed";
                }
                if turn < 0.5 * LARGEST_TURN {
                    step = (1.5 * step).min(plane.longest);
                }
            }
            Err(reason) => {
                step *= 0.4;
                if step < SHORTEST {
                    break reason;
                }
            }
        }
    };
    points.remove(0);
    (points, end)
}

/// The angle by which a curve turns.
fn turned(plane: &Plane, direction: [f64; 2], from: At, to: At) -> f64 {
    let next: [f64; 2] = std::array::from_fn(|i| (to[i] - from[i]) / plane.scale(i));
    let size = next[0].hypot(next[1]);
    match size > 0.0 {
        true => ((next[0] * direction[0] + next[1] * direction[1]) / size)
            .clamp(-1.0, 1.0)
            .acos(),
        false => 0.0,
    }
}

/// The point of the curve at a value of the parameter that is held, near a target.
fn point(
    map: &mut impl CycleMap,
    plane: &Plane,
    kind: &Kind,
    test: &Test,
    known: &[&Orbit],
    target: At,
    held: usize,
) -> Result<Orbit, &'static str> {
    const NO_TEST: &str = "the extreme that grazes is gone";
    let free = 1 - held;
    let last = known[0];
    // Linear through the last two, by the parameter that is held.
    let mut guess = last.u.clone();
    let mut place = target;
    if let [_, before, ..] = known {
        let run = last.at[held] - before.at[held];
        if run != 0.0 {
            let part = (target[held] - last.at[held]) / run;
            for (u, (a, b)) in guess.iter_mut().zip(last.u.iter().zip(&before.u)) {
                *u = a + part * (a - b);
            }
            place[free] = last.at[free] + part * (last.at[free] - before.at[free]);
        }
    }
    let null = match kind {
        Kind::Fold => Some(
            eigenpair(last.monodromy.as_ref(), Complex64::ONE)
                .ok_or(NO_ORBIT)?
                .vector[0]
                .clone(),
        ),
        _ => None,
    };
    let column = match &null {
        Some(_) => Some(
            map.by_parameter(&guess, place, last.period, free)
                .map_err(|_| NO_ORBIT)?,
        ),
        None => None,
    };
    // Only the depth of an extreme takes details.
    let watched = matches!(test, Test::Depth(_));
    let mut at_trial = |x: f64, near: &[f64]| -> Result<Orbit, NoOrbit> {
        let found = match (&null, &column) {
            (Some(null), Some(column)) => {
                let there: Vec<f64> = guess.iter().zip(null).map(|(u, v)| u + x * v).collect();
                let border = Border::Plane {
                    axis: free,
                    scale: plane.scale(free),
                    normal: null.clone(),
                    along: 0.0,
                    column: column.iter().map(|c| c * plane.scale(free)).collect(),
                };
                correct(map, &there, place, last.period, &border)?
            }
            _ => {
                let mut at = place;
                at[free] += x * plane.scale(free);
                correct(map, near, at, last.period, &Border::Parameters)?
            }
        };
        let found = found.with_multipliers(last.period)?;
        match watched {
            true => found.with_details(map),
            false => Ok(found),
        }
    };
    let (mut x, first) = FIRST_PLACES
        .into_iter()
        .find_map(|x| Some((x, at_trial(x, &guess).ok()?)))
        .ok_or(NO_ORBIT)?;
    let reference = test.at(&first).ok_or(NO_TEST)?.0;
    let value = |orbit: &Orbit| {
        test.at(orbit)
            .map(|(size, sign)| sign * (size - reference).exp())
            .ok_or(NO_TEST)
    };
    let mut older = (x, value(&first)?, first);
    if older.1 == 0.0 || !reference.is_finite() {
        return Ok(older.2);
    }
    let mut change = FIRST_TRIAL;
    // Where the test was last seen negative and positive.
    let mut bracket: [Option<f64>; 2] = [None; 2];
    for trial in 0..MOST_TRIALS {
        // Beyond a graze there may be no orbit: less of the way then, and the other way at first.
        let mut shorter = change;
        let mut found = None;
        for refusal in 0..MOST_REFUSALS {
            if let Ok(orbit) = at_trial(x + shorter, &older.2.u) {
                found = Some((x + shorter, value(&orbit)?, orbit));
                break;
            }
            shorter *= if trial == 0 && refusal == 0 {
                -1.0
            } else {
                0.5
            };
        }
        let newer = found.ok_or(NO_ORBIT)?;
        for end in [&older, &newer] {
            bracket[usize::from(end.1 > 0.0)] = Some(end.0);
        }
        let slope = (newer.1 - older.1) / (newer.0 - older.0);
        change = (-newer.1 / slope).clamp(-0.02, 0.02);
        x = newer.0;
        older = newer;
        let nothing = test
            .at(&older.2)
            .is_some_and(|(size, _)| size < NEARLY_ZERO);
        if older.1 == 0.0 || nothing || !watched && change.abs() <= LOCATED {
            return Ok(older.2);
        }
        if let [Some(low), Some(high)] = bracket {
            // Where the slope steps the secant alone may miss.
            let outside = (x + change - low) * (x + change - high) >= 0.0;
            if outside || trial % 3 == 2 {
                change = 0.5 * (low + high) - x;
            }
        }
        if !change.is_finite() {
            break;
        }
    }
    Err("the test of the bifurcation does not vanish near by")
}

/// What of codimension two lies between two points of a curve.
fn codimension_two(kind: &Kind, a: &Orbit, b: &Orbit) -> Option<&'static str> {
    let pairs = |orbit: &Orbit| pairs_outside(orbit, 1.0 + 1e-6);
    match kind {
        Kind::Fold => {
            if Test::MinusOne.changes(a, b) {
                return Some("fold and period doubling");
            }
            (pairs(a) != pairs(b)).then_some("fold and torus")
        }
        Kind::PeriodDoubling => {
            if Test::PlusOne.changes(a, b) {
                return Some("fold and period doubling");
            }
            (pairs(a) != pairs(b)).then_some("period doubling and torus")
        }
        Kind::Torus => {
            let angle = |orbit: &Orbit| critical(kind, orbit).map(|m| m.arg());
            let (a, b) = (angle(a)?, angle(b)?);
            let passes = |turn: f64| (a - turn) * (b - turn) < 0.0;
            if passes(TAU / 3.0) {
                return Some("resonance 1:3");
            }
            passes(TAU / 4.0).then_some("resonance 1:4")
        }
        Kind::Graze { .. } => {
            if Test::PlusOne.changes(a, b) {
                return Some("graze and fold");
            }
            if Test::MinusOne.changes(a, b) {
                return Some("graze and period doubling");
            }
            (a.details.touches.sequence.len() != b.details.touches.sequence.len())
                .then_some("another graze")
        }
        Kind::BranchPoint | Kind::Jump | Kind::Sequence | Kind::Merging { .. } => None,
    }
}

/// Whether a bifurcation lies on a known curve: a segment passes it with like orbits.
pub fn is_known(plane: &Plane, curves: &[Curve], own: &Bifurcation) -> bool {
    curves
        .iter()
        .filter(|c| c.kind.name() == own.kind.name())
        .any(|curve| {
            curve.points.windows(2).any(|pair| {
                let [a, b] = [&pair[0].orbit, &pair[1].orbit];
                let (whole, first) = (plane.apart(a.at, b.at), plane.apart(a.at, own.orbit.at));
                let second = plane.apart(b.at, own.orbit.at);
                let part = first / (first + second).max(f64::MIN_POSITIVE);
                let like = || {
                    let u: Vec<f64> =
                        a.u.iter()
                            .zip(&b.u)
                            .map(|(a, b)| a + part * (b - a))
                            .collect();
                    let apart = distance(&a.u, &b.u);
                    own.orbit
                        .details
                        .strobes
                        .iter()
                        .any(|o| distance(o, &u) < 0.2 * apart + 0.02)
                };
                a.period == own.orbit.period && first + second < 1.02 * whole + 1e-7 && like()
            })
        })
}
