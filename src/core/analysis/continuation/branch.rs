//! A branch of periodic orbits over a parameter, followed step by step through folds.
//!
//! A step extrapolates the last orbits by a polynomial. Newton's method corrects this guess, at the guessed
//! parameter or, where the branch is steep, on a plane across it. The angle between successive chords and the
//! number of Newton steps control the length of the step. At a change of the contact sequence the map is once
//! differentiable, but its curvature may be large. Near such a change, only the observed angle shows how long
//! a step may be.

use super::bifurcation::{Bifurcation, between};
use super::end::End;
use super::kind::Kind;
use super::map::CycleMap;
use super::orbit::{NoOrbit, Orbit, distance, same};
use super::path::{
    LARGEST_DISTANCE, PathCondition, Span, Vector, WEIGHT, apart, guess, interpolated, place,
    solution, tangent,
};

/// Settings for the steps along a branch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepSettings {
    /// First step, relative to the parameter's interval.
    pub first: f64,
    /// Longest step, relative to the parameter's interval.
    pub longest: f64,
    /// Shortest step, relative to the parameter's interval. The branch ends if it would need a shorter one.
    pub shortest: f64,
    /// Largest number of orbits in one direction.
    pub most: usize,
}

impl Default for StepSettings {
    fn default() -> Self {
        Self {
            first: 2e-3,
            longest: 0.02,
            shortest: 1e-11,
            most: 4000,
        }
    }
}

/// Largest angle between successive chords \[rad\].
const LARGEST_ANGLE: f64 = 0.35;

/// Angle between successive chords \[rad\] below which the next step becomes longer.
const SMALL_ANGLE: f64 = 0.12;

/// Largest number of Newton steps after which the next step becomes longer.
const FEW_STEPS: u32 = 3;

/// Number of successive rejected steps after which the next guess uses the exact tangent instead of the last
/// orbits.
const FEW_REFUSALS: u32 = 2;

/// Longest step, relative to the parameter's interval, by which a branch of doubled period may reach the orbits of
/// half its period. A longer step shows that Newton's method has left the branch.
const LONGEST_STEP_TO_PARENT: f64 = 1e-4;

/// Distance of a merging from the first orbit, relative to the interval, below which the branch has only
/// turned back.
const AT_START: f64 = 1e-7;

/// Smallest share of the parameter in the length of a chord at which its sign is not round-off.
const LEAST_SLOPE: f64 = 1e-3;

/// Factor by which a rejected step is shortened.
const SHORTER: f64 = 0.4;

/// Lower bound of the size of an orbit, relative to the largest size on its branch. Distances stay finite
/// with it, so that a branch can be followed to an orbit of vanishing size.
const LEAST_SIZE: f64 = 0.02;

/// A branch of orbits.
#[derive(Debug, Clone)]
pub struct Branch {
    /// The orbits, in order.
    pub orbits: Vec<Orbit>,
    /// Arclength from the first orbit to each.
    pub lengths: Vec<f64>,
    /// Bifurcations on the branch, in order.
    pub bifurcations: Vec<Bifurcation>,
    /// Reasons why the branch ends at its first and at its last orbit.
    pub ends: [End; 2],
    /// Number of rejected steps.
    pub rejected: u64,
}

impl Branch {
    /// Whether the orbit before or after a bifurcation of this branch is stable.
    pub fn has_stable_neighbour(&self, bifurcation: &Bifurcation) -> bool {
        let neighbours = self.orbits.iter().skip(bifurcation.after).take(2);
        neighbours.into_iter().any(|orbit| orbit.unstable() == 0)
    }
}

/// Half of a branch: its orbits from the first one in one direction.
struct HalfBranch {
    orbits: Vec<Orbit>,
    lengths: Vec<f64>,
    bifurcations: Vec<Bifurcation>,
    end: End,
    rejected: u64,
}

/// Follows the branch of an orbit in both directions.
///
/// # Errors
/// [`NoOrbit`] if the map has no derivative at the first orbit.
pub fn follow(
    map: &mut impl CycleMap,
    span: &Span,
    start: Orbit,
    steps: &StepSettings,
) -> Result<Branch, NoOrbit> {
    let direction = tangent(map, span, &start)?;
    let up = half_branch(map, span, vec![start.clone()], direction.clone(), steps);
    if up.end == End::Closed {
        return Ok(up.into_branch(End::Closed));
    }
    let back = direction.reversed();
    let down = half_branch(map, span, vec![start], back, steps);
    Ok(down.joined(up))
}

/// Follows a branch in one direction, from the first of two orbits through the second.
pub fn follow_away(
    map: &mut impl CycleMap,
    span: &Span,
    first: Orbit,
    second: Orbit,
    steps: &StepSettings,
) -> Branch {
    let direction = Vector::between(span, &first, &second);
    half_branch(map, span, vec![first, second], direction, steps).into_branch(End::Start)
}

impl HalfBranch {
    fn into_branch(self, first: End) -> Branch {
        Branch {
            orbits: self.orbits,
            lengths: self.lengths,
            bifurcations: self.bifurcations,
            ends: [first, self.end],
            rejected: self.rejected,
        }
    }

    /// Joins this half, in reversed order, and the other half.
    fn joined(self, other: Self) -> Branch {
        let whole = self.lengths.last().copied().unwrap_or(0.0);
        let mut orbits: Vec<Orbit> = self.orbits.into_iter().rev().collect();
        let mut lengths: Vec<f64> = self.lengths.iter().rev().map(|s| whole - s).collect();
        let before = orbits.len();
        orbits.extend(other.orbits.into_iter().skip(1));
        lengths.extend(other.lengths.iter().skip(1).map(|s| whole + s));
        let mut bifurcations: Vec<Bifurcation> = self.bifurcations;
        for bifurcation in &mut bifurcations {
            bifurcation.length = whole - bifurcation.length;
            bifurcation.after = before - 2 - bifurcation.after;
        }
        bifurcations.reverse();
        bifurcations.extend(other.bifurcations.into_iter().map(|mut bifurcation| {
            bifurcation.length += whole;
            bifurcation.after += before - 1;
            bifurcation
        }));
        Branch {
            orbits,
            lengths,
            bifurcations,
            ends: [self.end, other.end],
            rejected: self.rejected + other.rejected,
        }
    }
}

/// Follows a branch in one direction from the last of its known `orbits`.
fn half_branch(
    map: &mut impl CycleMap,
    span: &Span,
    orbits: Vec<Orbit>,
    direction: Vector,
    steps: &StepSettings,
) -> HalfBranch {
    let mut lengths = vec![0.0];
    for pair in orbits.windows(2) {
        lengths.push(lengths[lengths.len() - 1] + apart(span, &pair[0], &pair[1]));
    }
    let mut half_branch = HalfBranch {
        orbits,
        lengths,
        bifurcations: Vec::new(),
        end: End::Full,
        rejected: 0,
    };
    let mut step = steps.first;
    // Along the exact tangent if it is known, otherwise along the last chord.
    let mut ahead = StepDirection {
        direction,
        exact: half_branch.orbits.len() == 1,
        refusals: 0,
        last_resort: false,
    };
    while half_branch.orbits.len() < steps.most {
        match advance(map, span, &half_branch, &ahead, step) {
            Ok(next) => {
                let few = next.orbit.steps <= FEW_STEPS;
                let last = &half_branch.orbits[half_branch.orbits.len() - 1];
                ahead = StepDirection {
                    direction: Vector::between(span, last, &next.orbit),
                    exact: false,
                    refusals: 0,
                    last_resort: false,
                };
                let leaves = next.leaves;
                if few && next.angle < SMALL_ANGLE {
                    step = (1.5 * step).min(steps.longest);
                }
                if let Some(end) = take(map, span, &mut half_branch, next) {
                    half_branch.end = end;
                    break;
                }
                if leaves {
                    half_branch.end = End::Interval;
                    break;
                }
            }
            Err(End::Interval) => {
                half_branch.end = End::Interval;
                break;
            }
            Err(refused) => {
                half_branch.rejected += 1;
                ahead.refusals += 1;
                step *= SHORTER;
                ahead.last_resort = step * SHORTER < steps.shortest;
                let last = &half_branch.orbits[half_branch.orbits.len() - 1];
                if ahead.refusals == FEW_REFUSALS
                    && let Ok(mut exact) = tangent(map, span, last)
                {
                    let sense = half_branch.orbits.iter().nth_back(1).and_then(Orbit::sense);
                    let chord = &ahead.direction;
                    let is_steep = chord.p.abs() < LEAST_SLOPE * chord.length();
                    // Without a fold between the last two orbits, the parameter keeps its direction, even at a corner.
                    let goes_on = sense.is_some() && sense == last.sense() && !is_steep;
                    let same_way = if goes_on { chord.p } else { exact.cosine(chord) };
                    if same_way < 0.0 {
                        exact = exact.reversed();
                    }
                    ahead.direction = exact;
                    ahead.exact = true;
                }
                if step < steps.shortest {
                    half_branch.end = refused;
                    break;
                }
            }
        }
    }
    half_branch
}

/// Direction and history of the next step.
struct StepDirection {
    direction: Vector,
    /// Whether `direction` is the exact tangent.
    exact: bool,
    /// Number of successive rejected steps from the last orbit.
    refusals: u32,
    /// Whether no shorter step will be tried.
    last_resort: bool,
}

/// An accepted step.
struct AcceptedStep {
    orbit: Orbit,
    /// Angle by which the branch turns \[rad\].
    angle: f64,
    /// Whether the orbit lies on the end of the interval.
    leaves: bool,
    /// Bifurcations on the step.
    found: Vec<Bifurcation>,
}

/// The next orbit, one step ahead. `Err` has the reason why the step is rejected.
fn advance(
    map: &mut impl CycleMap,
    span: &Span,
    half_branch: &HalfBranch,
    go: &StepDirection,
    step: f64,
) -> Result<AcceptedStep, End> {
    let lost = |reason| End::Lost { reason };
    let count = half_branch.orbits.len();
    let last = &half_branch.orbits[count - 1];
    let s = half_branch.lengths[count - 1] + step;
    let chord = &go.direction;
    let ahead = if go.exact {
        let factor = step / chord.length();
        Vector {
            u: (last.u.iter().zip(&chord.u))
                .map(|(u, t)| u + factor * t)
                .collect(),
            p: last.at[span.axis] + factor * chord.p * span.scale(),
            size: last.size(),
        }
    } else {
        let knots: Vec<(f64, &Orbit)> =
            (half_branch.lengths.iter().copied().zip(&half_branch.orbits))
                .skip(count.saturating_sub(4))
                .collect();
        guess(span, &knots, s)
    };
    let across = match go.refusals {
        0 => PathCondition::Steep(chord),
        _ => PathCondition::Always(chord),
    };
    let found = solution(map, span, last, &ahead, across).map_err(lost)?;
    let angle = angle(&Vector::to(span, last, &found.u, found.at), chord);
    let away = Vector {
        u: found.u.iter().zip(&ahead.u).map(|(a, b)| a - b).collect(),
        p: (found.at[span.axis] - ahead.p) / span.scale(),
        size: last.size(),
    };
    // This form of the comparison also rejects NaN.
    let fits = angle <= LARGEST_ANGLE && away.length() <= LARGEST_DISTANCE * step;
    if !fits {
        return Err(End::Corner);
    }
    let mut orbit = found.complete(map, last.period).map_err(lost)?;
    let unit = map.unit();
    let strays =
        orbit.repeats_sooner(unit) && !last.repeats_sooner(unit) && step > LONGEST_STEP_TO_PARENT;
    if strays {
        return Err(End::Corner);
    }
    let leaves = !span.contains(orbit.at[span.axis]);
    if leaves {
        orbit = at_the_end(map, span, last, &orbit)?;
    }
    let largest = half_branch
        .orbits
        .iter()
        .map(Orbit::size)
        .fold(0.0, f64::max);
    orbit.details.size = orbit.size().max(LEAST_SIZE * largest);
    let from = count.saturating_sub(3);
    let mut knots: Vec<(f64, &Orbit)> = (half_branch.lengths[from..]
        .iter()
        .copied()
        .zip(&half_branch.orbits[from..]))
    .collect();
    knots.push((
        half_branch.lengths[count - 1] + apart(span, last, &orbit),
        &orbit,
    ));
    let found = between(map, span, &knots, go.last_resort).ok_or(End::Corner)?;
    // A branch never passes the same bifurcation twice and never merges where it began. A step with such a result
    // has turned back.
    let first = &half_branch.orbits[0];
    let began = |bifurcation: &Bifurcation| {
        let apart = (bifurcation.orbit.at[span.axis] - first.at[span.axis]).abs();
        bifurcation.merges().is_some()
            && first.repeats_sooner(unit)
            && apart <= AT_START * span.scale()
    };
    let again = |bifurcation: &Bifurcation| {
        half_branch
            .bifurcations
            .iter()
            .any(|known| known.is(bifurcation, span))
    };
    if found
        .iter()
        .any(|bifurcation| again(bifurcation) || began(bifurcation))
    {
        return Err(End::Corner);
    }
    Ok(AcceptedStep {
        angle,
        leaves,
        found,
        orbit,
    })
}

/// The angle between two directions \[rad\].
fn angle(a: &Vector, b: &Vector) -> f64 {
    a.cosine(b).clamp(-1.0, 1.0).acos()
}

/// The orbit at the end of the interval that a step crosses. [`End::Interval`] if the step began at this end.
/// [`End::Corner`] if the orbit found there is far from the step, so that it belongs to another branch.
/// [`End::Lost`] if none is found.
fn at_the_end(
    map: &mut impl CycleMap,
    span: &Span,
    inside: &Orbit,
    outside: &Orbit,
) -> Result<Orbit, End> {
    let (a, b) = (inside.at[span.axis], outside.at[span.axis]);
    let end = if b > span.to { span.to } else { span.from };
    if a == end {
        return Err(End::Interval);
    }
    let guess = Vector {
        u: interpolated(span, inside, outside, end),
        p: end,
        size: inside.size(),
    };
    let orbit = place(map, span, inside, &guess, PathCondition::Parameter)
        .map_err(|reason| End::Lost { reason })?;
    let off = WEIGHT / inside.size() * distance(&orbit.u, &guess.u);
    if off <= LARGEST_DISTANCE * apart(span, inside, outside) {
        Ok(orbit)
    } else {
        Err(End::Corner)
    }
}

/// Adds a step to half a branch. Returns the reason if the branch ends there.
fn take(
    map: &mut impl CycleMap,
    span: &Span,
    half_branch: &mut HalfBranch,
    next: AcceptedStep,
) -> Option<End> {
    let AcceptedStep {
        mut orbit,
        mut found,
        ..
    } = next;
    let last = half_branch.orbits.len() - 1;
    let s = half_branch.lengths[last];
    let home =
        (found.iter()).find_map(|bifurcation| Some((bifurcation.merges()?, bifurcation.clone())));
    if let Some((period, merging)) = &home
        && merging.orbit.period == *period
        && let Ok(end) = merging.orbit.doubled(map)
    {
        // Beyond a merging, the branch contains its own orbits again, each shifted by half a period.
        let knots = [
            (s, &half_branch.orbits[last]),
            (s + apart(span, &half_branch.orbits[last], &end), &end),
        ];
        let turns =
            |bifurcation: &Bifurcation| matches!(bifurcation.kind, Kind::Fold | Kind::BranchPoint);
        found = between(map, span, &knots, true).unwrap_or_default();
        found.retain(|bifurcation| !turns(bifurcation) && bifurcation.merges().is_none());
        let mut merging = merging.clone();
        merging.length = knots[1].0;
        found.push(merging);
        // At a merging a multiplier is +1, so that another multiplier near +1 does not indicate a fold.
        let near = knots[1].0 - 2.0 * LONGEST_STEP_TO_PARENT;
        half_branch
            .bifurcations
            .retain(|bifurcation| !(turns(bifurcation) && bifurcation.length > near));
        orbit = end;
    }
    half_branch
        .lengths
        .push(s + apart(span, &half_branch.orbits[last], &orbit));
    half_branch.orbits.push(orbit);
    half_branch
        .bifurcations
        .extend(found.into_iter().map(|mut bifurcation| {
            bifurcation.after = last;
            bifurcation
        }));
    match home {
        Some((period, _)) => Some(End::Merged { period }),
        None => closes(map, span, half_branch).then_some(End::Closed),
    }
}

/// Whether the last step passes the first orbit, so that the branch is closed.
fn closes(map: &mut impl CycleMap, span: &Span, half_branch: &HalfBranch) -> bool {
    let last = half_branch.orbits.len() - 1;
    let (first, now, before) = (
        &half_branch.orbits[0],
        &half_branch.orbits[last],
        &half_branch.orbits[last - 1],
    );
    let value = first.at[span.axis];
    let passes = (before.at[span.axis] - value) * (now.at[span.axis] - value) <= 0.0;
    let near = 1.5 * distance(&before.u, &now.u);
    let meets = |u: &Vec<f64>| distance(u, &first.u) < near;
    if last <= 8 || !passes || !now.details.strobes.iter().any(meets) {
        return false;
    }
    let guess = Vector {
        u: interpolated(span, before, now, value),
        p: value,
        size: now.size(),
    };
    let again = place(map, span, now, &guess, PathCondition::Parameter);
    again.is_ok_and(|again| same(&again, first))
}
