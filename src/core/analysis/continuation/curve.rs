//! A bifurcation curve over two parameters.
//!
//! At each point, one parameter is fixed; the direction of the curve decides which. The secant method varies
//! the other parameter until a multiplier is on the unit circle, or until an extreme of a contact's depth is
//! zero. Every trial is an orbit corrected by Newton's method. A fold has no orbits on one side, so its trial
//! orbits lie on a plane across its null vector. Only the critical multiplier is computed, by inverse
//! iteration from its last value.

use super::bifurcation::Bifurcation;
use super::kind::{Kind, critical};
use super::map::{CycleMap, MapParameters};
use super::orbit::{Orbit, OrbitCondition, OrbitSolution, correct, distance};
use super::touches::Extreme;
use crate::numerics::linalg::{eigenpair, eigenvalues};
use num_complex::Complex64;
use std::f64::consts::PI;

/// Settings for a bifurcation curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurveSettings {
    /// Smallest values of both parameters.
    pub from: MapParameters,
    /// Largest values.
    pub to: MapParameters,
    /// Longest step, relative to the intervals of both parameters.
    pub longest: f64,
    /// Largest number of points in one direction.
    pub most: usize,
}

impl CurveSettings {
    fn scale(&self, axis: usize) -> f64 {
        self.to[axis] - self.from[axis]
    }

    fn contains(&self, at: MapParameters) -> bool {
        (0..2).all(|axis| (self.from[axis]..=self.to[axis]).contains(&at[axis]))
    }

    /// Distance of two points, relative to the intervals.
    pub fn distance_between(&self, a: MapParameters, b: MapParameters) -> f64 {
        ((a[0] - b[0]) / self.scale(0)).hypot((a[1] - b[1]) / self.scale(1))
    }
}

/// A point of a curve, with the bifurcation of codimension two just before it, if any.
#[derive(Debug, Clone)]
pub struct CurvePoint {
    /// The orbit.
    pub orbit: Orbit,
    /// Bifurcation of codimension two between the previous point and this one, in words.
    pub note: Option<&'static str>,
}

/// A bifurcation curve.
#[derive(Debug, Clone)]
pub struct Curve {
    /// The bifurcation.
    pub kind: Kind,
    /// Points of the curve, in order.
    pub points: Vec<CurvePoint>,
    /// Reasons why the curve ends at its first and at its last point.
    pub ends: [&'static str; 2],
}

/// The usual reason for the end of a curve inside the plane.
const NO_ORBIT: &str = "no orbit is found beyond";

/// First and shortest step, relative to the intervals.
const FIRST: f64 = 2e-3;
const SHORTEST: f64 = 1e-6;

/// Largest turn of a curve from step to step \[rad\].
const LARGEST_TURN: f64 = 0.5;

/// Accuracy of a located point, relative to the interval of the sought parameter. Along a fold's null vector,
/// it is relative to the motion's size.
const LOCATED: f64 = 1e-9;
/// Largest number of steps of the secant method for one point.
const MOST_TRIALS: usize = 60;

/// Largest distance of the critical multiplier of a located point from its value at the bifurcation. A
/// multiplier that jumps past this value stays farther away.
const LARGEST_MULTIPLIER_ERROR: f64 = 1e-4;

/// Depth of an extreme that counts as zero, in sizes of the motion.
const NO_DEPTH: f64 = 1e-12;

/// Offsets of the first trial from the guess, in the order tried. They are relative to the interval of the sought
/// parameter, or along a fold's null vector in sizes of the motion. There are several because on one side of a graze
/// there may be no orbit.
const FIRST_PLACES: [f64; 7] = [0.0, 1e-4, -1e-4, 1e-3, -1e-3, 5e-3, -5e-3];

/// Maximum number of halvings of a step if there is no orbit.
const MOST_REFUSALS: usize = 12;

/// First and largest change of the sought parameter between trials, relative to its interval. Along a fold's
/// null vector, the change is in sizes of the motion.
const FIRST_TRIAL: f64 = 1e-5;
const LONGEST_TRIAL: f64 = 0.02;

/// Follows a bifurcation in the plane of both parameters, in both directions. `None` if such a bifurcation
/// has no curve.
pub fn follow(
    map: &mut impl CycleMap,
    plane: &CurveSettings,
    start: &Bifurcation,
) -> Option<Curve> {
    CurveFunction::new(&start.kind, &start.orbit)?;
    let start_point = CurvePoint {
        orbit: start.orbit.clone(),
        note: None,
    };
    // The first step is along the second parameter. If the curve turns there and no point is found, it is
    // along the first parameter.
    let mut halves = None;
    for axis in [1, 0] {
        let towards = |sense: f64| std::array::from_fn(|i| if i == axis { sense } else { 0.0 });
        let (back, first) =
            follow_one_direction(map, plane, &start.kind, &start_point, towards(-1.0));
        let (ahead, last) = match first {
            "closed" => (Vec::new(), first),
            _ => follow_one_direction(map, plane, &start.kind, &start_point, towards(1.0)),
        };
        let point_count = back.len() + ahead.len();
        halves = Some((back, ahead, [first, last]));
        if point_count > 0 {
            break;
        }
    }
    let (mut back, ahead, [first, last]) = halves?;
    back.reverse();
    back.push(start_point);
    back.extend(ahead);
    Some(Curve {
        kind: start.kind,
        points: back,
        ends: [first, last],
    })
}

fn follow_one_direction(
    map: &mut impl CycleMap,
    plane: &CurveSettings,
    kind: &Kind,
    start: &CurvePoint,
    towards: [f64; 2],
) -> (Vec<CurvePoint>, &'static str) {
    let mut points = vec![start.clone()];
    let mut kind = *kind;
    let mut step = FIRST;
    let mut slopes: [Option<f64>; 2] = [None; 2];
    let end = loop {
        if points.len() > plane.most {
            break "the limit of continuation.orbits is reached";
        }
        let (length, direction) = chord(plane, &points).unwrap_or((0.0, towards));
        let last = &points[points.len() - 1].orbit;
        let target: MapParameters =
            std::array::from_fn(|i| last.at[i] + step * direction[i] * plane.scale(i));
        let fixed_axis = if direction[1].abs() >= direction[0].abs() { 1 } else { 0 };
        let last_orbits: Vec<&Orbit> = points.iter().rev().take(3).map(|p| &p.orbit).collect();
        slopes[1 - fixed_axis] = None;
        match point(
            map,
            plane,
            &kind,
            &last_orbits,
            target,
            fixed_axis,
            &mut slopes[fixed_axis],
        ) {
            Ok(orbit) => {
                let turn = angle_to_step(plane, direction, last.at, orbit.at);
                let far = plane.distance_between(last.at, orbit.at) > 3.0 * step;
                let cusp = kind == Kind::Fold && turn > 0.7 * PI && points.len() > 2;
                let sharp = turn > LARGEST_TURN && points.len() > 1 && !cusp;
                if sharp || far {
                    step *= 0.4;
                    // If the curve leaves the last chord at a sharp angle even for a short step, the last
                    // step has missed a bend. That last step is then repeated with a shorter length.
                    if sharp && step < 0.1 * length && 0.25 * length > SHORTEST {
                        points.pop();
                        step = 0.25 * length;
                        continue;
                    }
                    if step < SHORTEST {
                        break "the curve turns sharply";
                    }
                    continue;
                }
                if !plane.contains(orbit.at) {
                    points.push(CurvePoint { orbit, note: None });
                    break "the interval ends";
                }
                let note = if cusp { Some("cusp") } else { kind.codimension_two(last, &orbit) };
                if let Kind::Graze { extreme } = &mut kind
                    && let Some(now) = orbit
                        .details
                        .touches
                        .nearest(extreme, f64::from(orbit.period))
                {
                    *extreme = *now;
                }
                let distance_to_start = plane.distance_between(orbit.at, start.orbit.at);
                let closed = points.len() > 10
                    && distance_to_start < plane.distance_between(last.at, orbit.at)
                    && distance(&orbit.u, &start.orbit.u) < 0.2 * orbit.size();
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

/// Length and direction of the last step, relative to the intervals; `None` before the first step. The length
/// is not zero, because the fixed parameter has different values at both ends.
fn chord(plane: &CurveSettings, points: &[CurvePoint]) -> Option<(f64, [f64; 2])> {
    let [.., before, last] = points else {
        return None;
    };
    let (from, to) = (before.orbit.at, last.orbit.at);
    let length = plane.distance_between(from, to);
    let direction = std::array::from_fn(|i| (to[i] - from[i]) / plane.scale(i) / length);
    Some((length, direction))
}

/// The angle between a direction of the curve and the step from one point to the next \[rad\].
fn angle_to_step(
    plane: &CurveSettings,
    direction: [f64; 2],
    from: MapParameters,
    to: MapParameters,
) -> f64 {
    let next: [f64; 2] = std::array::from_fn(|i| (to[i] - from[i]) / plane.scale(i));
    let size = next[0].hypot(next[1]);
    if size > 0.0 {
        ((next[0] * direction[0] + next[1] * direction[1]) / size)
            .clamp(-1.0, 1.0)
            .acos()
    } else {
        0.0
    }
}

/// A function of an orbit that is zero on the curve.
enum CurveFunction {
    /// Signed distance of the multiplier nearest to the given one from the critical value of the bifurcation.
    Multiplier(Kind, Complex64),
    /// The depth of the extreme nearest in time to the given one \[half gaps\].
    Depth(Extreme),
}

const NO_TEST: &str = "the grazing extreme disappears";
const NO_MULTIPLIER: &str = "the multiplier changes its type";
const JUMPS: &str = "the multiplier jumps";

impl CurveFunction {
    fn new(kind: &Kind, last: &Orbit) -> Option<Self> {
        Some(match *kind {
            Kind::Fold => Self::Multiplier(*kind, Complex64::ONE),
            Kind::PeriodDoubling => Self::Multiplier(*kind, -Complex64::ONE),
            Kind::Torus => Self::Multiplier(*kind, critical(kind, last)?),
            Kind::Graze { extreme } => Self::Depth(extreme),
            Kind::BranchPoint | Kind::Jump | Kind::Sequence | Kind::Merging { .. } => return None,
        })
    }

    fn at(
        &mut self,
        map: &mut impl CycleMap,
        orbit: &OrbitSolution,
        period: u32,
    ) -> Result<f64, &'static str> {
        let (kind, near) = match self {
            Self::Depth(extreme) => {
                let details = (map.details(&orbit.u, orbit.at, period)).map_err(|_| NO_ORBIT)?;
                let nearest = details.touches.nearest(extreme, f64::from(period));
                return Ok(nearest.ok_or(NO_TEST)?.depth);
            }
            Self::Multiplier(kind, near) => (kind, near),
        };
        let matrix = orbit.monodromy.as_ref();
        let value = match eigenpair(matrix, *near) {
            Some(pair) => pair.value,
            // Inverse iteration fails if two multipliers are equally near.
            None => (eigenvalues(matrix).into_iter().flatten())
                .min_by(|a, b| (a - *near).norm().total_cmp(&(b - *near).norm()))
                .ok_or(NO_ORBIT)?,
        };
        match kind {
            Kind::Torus if value.im != 0.0 => {
                *near = value;
                Ok(value.norm() - 1.0)
            }
            Kind::Fold | Kind::PeriodDoubling if value.im == 0.0 => Ok(value.re - near.re),
            _ => Err(NO_MULTIPLIER),
        }
    }
}

/// Guess of the next point: its coordinates u and its parameters, from a polynomial in the fixed parameter through
/// the last orbits, latest first. The polynomial uses orbits back to the one where the fixed parameter reverses.
fn extrapolated(
    last_orbits: &[&Orbit],
    target: MapParameters,
    fixed_axis: usize,
) -> (Vec<f64>, MapParameters) {
    let run = |i: usize| last_orbits[i - 1].at[fixed_axis] - last_orbits[i].at[fixed_axis];
    let mut used = 1;
    while used < last_orbits.len() && run(used) != 0.0 && run(used) * run(1) > 0.0 {
        used += 1;
    }
    let free = 1 - fixed_axis;
    let mut u = vec![0.0; last_orbits[0].u.len()];
    let mut place = target;
    if used > 1 {
        place[free] = 0.0;
    }
    for (i, point) in last_orbits[..used].iter().enumerate() {
        let others = (0..used)
            .filter(|&j| j != i)
            .map(|j| last_orbits[j].at[fixed_axis]);
        let weight: f64 = others
            .map(|other| (target[fixed_axis] - other) / (point.at[fixed_axis] - other))
            .product();
        for (sum, value) in u.iter_mut().zip(&point.u) {
            *sum += weight * value;
        }
        if used > 1 {
            place[free] += weight * point.at[free];
        }
    }
    (u, place)
}

/// The point of the curve at the target's value of the fixed parameter. `slope` is the slope of the function
/// whose zero is sought. It is kept from one point to the next.
fn point(
    map: &mut impl CycleMap,
    plane: &CurveSettings,
    kind: &Kind,
    last_orbits: &[&Orbit],
    target: MapParameters,
    fixed_axis: usize,
    slope: &mut Option<f64>,
) -> Result<Orbit, &'static str> {
    let free = 1 - fixed_axis;
    let last = last_orbits[0];
    let (period, size) = (last.period, last.size());
    let mut function = CurveFunction::new(kind, last).ok_or(NO_MULTIPLIER)?;
    let (guess, place) = extrapolated(last_orbits, target, fixed_axis);
    // A fold has orbits on one side only, so the search moves along its null vector.
    let across = match kind {
        Kind::Fold => {
            let null = eigenpair(last.monodromy.as_ref(), Complex64::ONE).ok_or(NO_ORBIT)?;
            let column = map.by_parameter(&guess, place, period, free);
            let scale = plane.scale(free);
            let column: Vec<f64> = (column.map_err(|_| NO_ORBIT)?.iter())
                .map(|c| c * scale)
                .collect();
            Some((null.vector[0].clone(), column))
        }
        _ => None,
    };
    let at_trial = |map: &mut _, x: f64, near: &[f64]| match &across {
        Some((null, column)) => {
            let there: Vec<f64> = (guess.iter().zip(null))
                .map(|(u, v)| u + x * size * v)
                .collect();
            let condition = OrbitCondition::Plane {
                axis: free,
                scale: plane.scale(free),
                normal: null.clone(),
                along: 0.0,
                column: column.clone(),
            };
            correct(map, &there, place, period, &condition)
        }
        None => {
            let mut at = place;
            at[free] += x * plane.scale(free);
            correct(map, near, at, period, &OrbitCondition::Parameters)
        }
    };
    let (x, first) = FIRST_PLACES
        .into_iter()
        .find_map(|x| Some((x, at_trial(map, x, &guess).ok()?)))
        .ok_or(NO_ORBIT)?;
    let mut older = (x, function.at(map, &first, period)?, first);
    let mut change = slope.map_or(FIRST_TRIAL, |slope| -older.1 / slope);
    // A slope across a jump of the multiplier is useless at the next point.
    if change.abs() <= LOCATED && older.1.abs() > LARGEST_MULTIPLIER_ERROR {
        change = FIRST_TRIAL;
    }
    // Positions of the last trials with a negative and with a positive value.
    let mut bracket: [Option<f64>; 2] = [None; 2];
    let is_graze = matches!(function, CurveFunction::Depth(_));
    for trial in 0..MOST_TRIALS {
        let located = if is_graze {
            older.1.abs() < NO_DEPTH * size
        } else {
            older.1 == 0.0 || change.abs() <= LOCATED
        };
        if located && !is_graze && older.1.abs() > LARGEST_MULTIPLIER_ERROR {
            return Err(JUMPS);
        }
        if located {
            let orbit = older.2.with_multipliers(period).map_err(|_| NO_ORBIT)?;
            return orbit.with_details(map).map_err(|_| NO_ORBIT);
        }
        // There may be no orbit beyond a graze. Reverse the very first step once; otherwise halve the step.
        let mut shorter = change.clamp(-LONGEST_TRIAL, LONGEST_TRIAL);
        let mut found = None;
        for refusal in 0..MOST_REFUSALS {
            let x = older.0 + shorter;
            if let Ok(orbit) = at_trial(map, x, &older.2.u) {
                found = Some((x, function.at(map, &orbit, period)?, orbit));
                break;
            }
            shorter *= match (trial, refusal) {
                (0, 0) => -1.0,
                _ => 0.5,
            };
        }
        let newer = found.ok_or(NO_ORBIT)?;
        for end in [&older, &newer] {
            bracket[usize::from(end.1 > 0.0)] = Some(end.0);
        }
        let rate = (newer.1 - older.1) / (newer.0 - older.0);
        change = -newer.1 / rate;
        older = newer;
        if !change.is_finite() {
            break;
        }
        // The slope of the depth jumps at the graze, so it does not help at the next point.
        *slope = (!is_graze).then_some(rate);
        if let [Some(low), Some(high)] = bracket {
            // If the slope jumps, secants alone may not converge.
            let outside = (older.0 + change - low) * (older.0 + change - high) >= 0.0;
            if change.abs() > LOCATED && (outside || trial % 3 == 2) {
                change = 0.5 * (low + high) - older.0;
            }
        }
    }
    Err("the bifurcation is not found nearby")
}

/// Whether a bifurcation lies on a known curve of its kind: near the segment between two neighbouring points, with an
/// orbit near theirs.
pub fn is_known(plane: &CurveSettings, curves: &[Curve], bifurcation: &Bifurcation) -> bool {
    curves
        .iter()
        .filter(|c| c.kind.name() == bifurcation.kind.name())
        .any(|curve| {
            curve.points.windows(2).any(|pair| {
                let [a, b] = [&pair[0].orbit, &pair[1].orbit];
                let (whole, first) = (
                    plane.distance_between(a.at, b.at),
                    plane.distance_between(a.at, bifurcation.orbit.at),
                );
                let second = plane.distance_between(b.at, bifurcation.orbit.at);
                let part = first / (first + second).max(f64::MIN_POSITIVE);
                let like =
                    || {
                        let u: Vec<f64> =
                            a.u.iter()
                                .zip(&b.u)
                                .map(|(a, b)| a + part * (b - a))
                                .collect();
                        let apart = distance(&a.u, &b.u);
                        bifurcation.orbit.details.strobes.iter().any(|o| {
                            distance(o, &u) < 0.2 * apart + 0.02 * bifurcation.orbit.size()
                        })
                    };
                a.period == bifurcation.orbit.period
                    && first + second < 1.02 * whole + 1e-7
                    && like()
            })
        })
}

#[cfg(test)]
mod tests;
