//! A branch of periodic orbits over a parameter: step by step along the curve, through folds.
//!
//! A step guesses by a polynomial through the last orbits and corrects by Newton's method, at the
//! guessed parameter where the branch is not steep, on a plane across it where it is. The step
//! follows the angle between successive chords and the number of Newton steps. The map is once
//! differentiable through a change of the contact sequence, with a curvature that may be large, so
//! that nothing but the observed angle tells how far a step may go there.

use super::bifurcation::{Bifurcation, Kind, between};
use super::map::CycleMap;
use super::orbit::{NoOrbit, Orbit, distance, same};
use super::path::{Span, Vector, apart, guess, place, tangent};

/// How a branch is followed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steps {
    /// First step, as a part of the parameter's interval.
    pub first: f64,
    /// Longest step.
    pub longest: f64,
    /// Shortest step: where a shorter one would be needed the branch ends.
    pub shortest: f64,
    /// Most orbits in one direction.
    pub most: usize,
}

impl Default for Steps {
    fn default() -> Self {
        Self {
            first: 2e-3,
            longest: 0.02,
            shortest: 1e-9,
            most: 4000,
        }
    }
}

/// Largest angle between successive chords \[rad\].
const LARGEST_ANGLE: f64 = 0.35;

/// Angle below which the step grows.
const SMALL_ANGLE: f64 = 0.12;

/// Newton steps up to which the step grows.
const FEW_STEPS: u32 = 3;

/// Refusals after which the exact tangent is taken instead of the last orbits.
const FEW_REFUSALS: u32 = 2;

/// Part of a step by which an orbit may be away from its guess.
const OFF: f64 = 0.5;

/// Longest step, as a part of the parameter's interval, by which a branch of doubled period comes home to the
/// orbits of half of it; by a longer one Newton's method has only strayed there.
const HOMECOMING: f64 = 1e-4;

/// Why a branch goes no further.
#[derive(Debug, Clone, PartialEq)]
pub enum End {
    /// The parameter's interval ends.
    Interval,
    /// It is back where it began.
    Closed,
    /// It meets the orbits of a part of its period: it is the branch that doubled there.
    Merged {
        /// Their period.
        period: u32,
    },
    /// As many orbits as asked for.
    Full,
    /// No orbit is found beyond, however small the step.
    Lost {
        /// Why not.
        reason: NoOrbit,
    },
    /// The branch turns by more than the largest angle, however small the step.
    Corner,
    /// It was to be followed one way only.
    Start,
}

impl std::fmt::Display for End {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Interval => f.write_str("the interval ends"),
            Self::Closed => f.write_str("back at the first orbit"),
            Self::Merged { period } => write!(f, "merges into the orbits of period {period}"),
            Self::Full => f.write_str("as many orbits as asked for"),
            Self::Lost { reason } => write!(f, "no orbit beyond: {reason}"),
            Self::Corner => f.write_str("a corner that no step resolves"),
            Self::Start => f.write_str("its first orbit"),
        }
    }
}

/// A branch of orbits.
#[derive(Debug, Clone)]
pub struct Branch {
    /// The orbits, in order.
    pub orbits: Vec<Orbit>,
    /// Length of branch from the first orbit to each.
    pub lengths: Vec<f64>,
    /// Its bifurcations, in order.
    pub bifurcations: Vec<Bifurcation>,
    /// Why it ends, at its first and its last orbit.
    pub ends: [End; 2],
    /// Steps that had to be made again.
    pub rejected: u64,
}

impl Branch {
    /// Whether the orbit before or after a bifurcation of this branch is stable.
    pub fn is_stable_beside(&self, bifurcation: &Bifurcation) -> bool {
        let beside = self.orbits.iter().skip(bifurcation.after).take(2);
        beside.into_iter().any(|orbit| orbit.unstable() == 0)
    }
}

/// Half a branch: from its first orbit one way.
struct Arm {
    orbits: Vec<Orbit>,
    lengths: Vec<f64>,
    bifurcations: Vec<Bifurcation>,
    end: End,
    rejected: u64,
}

/// Follows the branch of an orbit both ways.
///
/// # Errors
/// [`NoOrbit`] where the map has no derivative at the first orbit.
pub fn follow(
    map: &mut impl CycleMap,
    span: &Span,
    start: Orbit,
    steps: &Steps,
) -> Result<Branch, NoOrbit> {
    let direction = tangent(map, span, &start)?;
    let up = arm(map, span, vec![start.clone()], direction.clone(), steps);
    if up.end == End::Closed {
        return Ok(up.into_branch(End::Closed));
    }
    let back = direction.reversed();
    let down = arm(map, span, vec![start], back, steps);
    Ok(down.joined(up))
}

/// Follows a branch from a second orbit on, away from the first.
pub fn follow_away(
    map: &mut impl CycleMap,
    span: &Span,
    first: Orbit,
    second: Orbit,
    steps: &Steps,
) -> Branch {
    let direction = Vector::between(span, &first, &second);
    arm(map, span, vec![first, second], direction, steps).into_branch(End::Start)
}

impl Arm {
    fn into_branch(self, first: End) -> Branch {
        Branch {
            orbits: self.orbits,
            lengths: self.lengths,
            bifurcations: self.bifurcations,
            ends: [first, self.end],
            rejected: self.rejected,
        }
    }

    /// This arm backwards, then the other.
    fn joined(self, other: Self) -> Branch {
        let whole = self.lengths.last().copied().unwrap_or(0.0);
        let mut orbits: Vec<Orbit> = self.orbits.into_iter().rev().collect();
        let mut lengths: Vec<f64> = self.lengths.iter().rev().map(|s| whole - s).collect();
        let before = orbits.len();
        orbits.extend(other.orbits.into_iter().skip(1));
        lengths.extend(other.lengths.iter().skip(1).map(|s| whole + s));
        let mut bifurcations: Vec<Bifurcation> = self.bifurcations;
        for own in &mut bifurcations {
            own.length = whole - own.length;
            own.after = before - 2 - own.after;
        }
        bifurcations.reverse();
        bifurcations.extend(other.bifurcations.into_iter().map(|mut own| {
            own.length += whole;
            own.after += before - 1;
            own
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

/// Follows a branch one way from the last of some orbits.
fn arm(
    map: &mut impl CycleMap,
    span: &Span,
    orbits: Vec<Orbit>,
    direction: Vector,
    steps: &Steps,
) -> Arm {
    let mut lengths = vec![0.0];
    for pair in orbits.windows(2) {
        lengths.push(lengths[lengths.len() - 1] + apart(span, &pair[0], &pair[1]));
    }
    let mut arm = Arm {
        orbits,
        lengths,
        bifurcations: Vec::new(),
        end: End::Full,
        rejected: 0,
    };
    let mut step = steps.first;
    // Along the exact tangent where it is known, else along the last chord.
    let mut ahead = Ahead {
        direction,
        exact: arm.orbits.len() == 1,
    };
    let mut refusals = 0;
    while arm.orbits.len() < steps.most {
        let last = arm.orbits.len() - 1;
        let s = arm.lengths[last];
        match advance(map, span, &arm, &ahead, step) {
            Ok((orbit, angle)) => {
                let leaves = !span.holds(orbit.at[span.axis]);
                let orbit = match leaves {
                    false => orbit,
                    true => match at_the_end(map, span, &arm.orbits[last], &orbit) {
                        Ok(Some(orbit)) => orbit,
                        Ok(None) => {
                            arm.end = End::Interval;
                            break;
                        }
                        Err(reason) => {
                            arm.end = End::Lost { reason };
                            break;
                        }
                    },
                };
                let few = orbit.steps <= FEW_STEPS;
                ahead = Ahead {
                    direction: Vector::between(span, &arm.orbits[last], &orbit),
                    exact: false,
                };
                refusals = 0;
                arm.lengths.push(s + apart(span, &arm.orbits[last], &orbit));
                arm.orbits.push(orbit);
                let ended = look_back(map, span, &mut arm);
                if ended || leaves {
                    if !ended {
                        arm.end = End::Interval;
                    }
                    break;
                }
                if few && angle < SMALL_ANGLE {
                    step = (1.5 * step).min(steps.longest);
                }
            }
            Err(refused) => {
                arm.rejected += 1;
                refusals += 1;
                step *= 0.4;
                if refusals == FEW_REFUSALS
                    && let Ok(mut exact) = tangent(map, span, &arm.orbits[last])
                {
                    if exact.cosine(&ahead.direction) < 0.0 {
                        exact = exact.reversed();
                    }
                    ahead = Ahead {
                        direction: exact,
                        exact: true,
                    };
                }
                if step < steps.shortest {
                    arm.end = refused;
                    break;
                }
            }
        }
    }
    arm
}

/// Where a branch goes on.
struct Ahead {
    direction: Vector,
    /// Whether that is the tangent.
    exact: bool,
}

/// The next orbit, and the angle by which the branch turns to it.
fn advance(
    map: &mut impl CycleMap,
    span: &Span,
    arm: &Arm,
    go: &Ahead,
    step: f64,
) -> Result<(Orbit, f64), End> {
    let lost = |reason| End::Lost { reason };
    let count = arm.orbits.len();
    let last = &arm.orbits[count - 1];
    let s = arm.lengths[count - 1] + step;
    let chord = &go.direction;
    let ahead = match go.exact {
        true => {
            let factor = step / chord.length();
            Vector {
                u: last
                    .u
                    .iter()
                    .zip(&chord.u)
                    .map(|(u, t)| u + factor * t)
                    .collect(),
                p: last.at[span.axis] + factor * chord.p * span.scale(),
            }
        }
        false => {
            let knots: Vec<(f64, &Orbit)> = (arm.lengths.iter().copied().zip(&arm.orbits))
                .skip(count.saturating_sub(4))
                .collect();
            guess(span, &knots, s)
        }
    };
    let orbit = place(map, span, last, &ahead, chord).map_err(lost)?;
    let now = Vector::between(span, last, &orbit);
    let angle = now.cosine(chord).clamp(-1.0, 1.0).acos();
    let away = Vector {
        u: orbit.u.iter().zip(&ahead.u).map(|(a, b)| a - b).collect(),
        p: (orbit.at[span.axis] - ahead.p) / span.scale(),
    };
    let strays = orbit.repeats_sooner() && !last.repeats_sooner() && step > HOMECOMING;
    if angle > LARGEST_ANGLE || away.length() > OFF * step || strays {
        return Err(End::Corner);
    }
    Ok((orbit, angle))
}

/// The orbit on the end of the interval that a step passes; none where the step began there.
fn at_the_end(
    map: &mut impl CycleMap,
    span: &Span,
    inside: &Orbit,
    outside: &Orbit,
) -> Result<Option<Orbit>, NoOrbit> {
    let (a, b) = (inside.at[span.axis], outside.at[span.axis]);
    let end = if b > span.to { span.to } else { span.from };
    if a == end {
        return Ok(None);
    }
    let part = (end - a) / (b - a);
    let guess = Vector {
        u: inside
            .u
            .iter()
            .zip(&outside.u)
            .map(|(a, b)| a + part * (b - a))
            .collect(),
        p: end,
    };
    place(
        map,
        span,
        inside,
        &guess,
        &Vector {
            u: vec![0.0; inside.u.len()],
            p: 1.0,
        },
    )
    .map(Some)
}

/// What happened between the last two orbits: bifurcations are noted; whether the branch ends.
fn look_back(map: &mut impl CycleMap, span: &Span, arm: &mut Arm) -> bool {
    let last = arm.orbits.len() - 1;
    let from = last.saturating_sub(3);
    let knots: Vec<(f64, &Orbit)> =
        (arm.lengths[from..].iter().copied().zip(&arm.orbits[from..])).collect();
    let found = between(map, span, &knots);
    let merged = found.iter().find_map(|own| own.merges());
    arm.bifurcations.extend(found.into_iter().map(|mut own| {
        own.after = last - 1;
        own
    }));
    if let Some(period) = merged {
        // A multiplier is +1 where the branch comes home; next to there it is no turn of the branch.
        let home = arm.lengths[last] - 2.0 * HOMECOMING;
        let turns = |own: &Bifurcation| matches!(own.kind, Kind::Fold | Kind::BranchPoint);
        arm.bifurcations
            .retain(|own| !(turns(own) && own.length > home));
        arm.end = End::Merged { period };
        return true;
    }
    let (first, now, before) = (&arm.orbits[0], &arm.orbits[last], &arm.orbits[last - 1]);
    let passes = (before.at[span.axis] - first.at[span.axis])
        * (now.at[span.axis] - first.at[span.axis])
        <= 0.0;
    if last > 8
        && passes
        && now
            .details
            .strobes
            .iter()
            .any(|u| distance(u, &first.u) < 1.5 * distance(&before.u, &now.u))
    {
        let chord = Vector {
            u: vec![0.0; first.u.len()],
            p: 1.0,
        };
        let guess = Vector {
            u: first.u.clone(),
            p: first.at[span.axis],
        };
        let again = place(
            map,
            span,
            now,
            &Vector {
                u: interpolated(span, before, now, guess.p),
                p: guess.p,
            },
            &chord,
        );
        if again.is_ok_and(|again| same(&again, first)) {
            arm.end = End::Closed;
            return true;
        }
    }
    false
}

/// Coordinates between two orbits at a value of the parameter.
pub fn interpolated(span: &Span, a: &Orbit, b: &Orbit, value: f64) -> Vec<f64> {
    let (from, to) = (a.at[span.axis], b.at[span.axis]);
    let part = if from == to {
        0.5
    } else {
        (value - from) / (to - from)
    };
    a.u.iter()
        .zip(&b.u)
        .map(|(a, b)| a + part * (b - a))
        .collect()
}
