//! Which branches over a parameter can be reached from a few orbits?
//!
//! Orbits are sought at some values of the parameter. A branch is followed in both directions from each orbit that
//! lies on no known branch. Branches that begin at period doublings and branch points are followed as well. The order
//! is fixed, so that results are reproducible bit by bit.

use super::bifurcation::{Bifurcation, Unfollowed};
use super::branch::{Branch, StepSettings, follow, follow_away};
use super::drive::{DriveMap, ParametricDrive};
use super::end::End;
use super::kind::Kind;
use super::map::{CycleMap, MapError, MapParameters};
use super::orbit::{Orbit, distance, same};
use super::path::{PathCondition, Span, Vector, guess, place};
use super::search::{OrbitSearchSettings, orbits, take};
use super::switch;
use crate::analysis::interrupt::Interrupted;
use std::collections::VecDeque;
use std::sync::atomic::AtomicBool;

/// Settings of an exploration.
#[derive(Debug, Clone, PartialEq)]
pub struct ExplorationSettings {
    /// The parameter and its interval.
    pub span: Span,
    /// Values of the parameter at which orbits are sought.
    pub starts: Vec<f64>,
    /// How orbits are sought.
    pub search: OrbitSearchSettings,
    /// Initial states, each with its parameter value and period.
    pub states: Vec<GivenState>,
    /// How branches are followed.
    pub steps: StepSettings,
    /// Largest number of branches.
    pub most: usize,
}

/// A given initial state near which an orbit is sought.
#[derive(Debug, Clone, PartialEq)]
pub struct GivenState {
    /// Value of the parameter.
    pub value: f64,
    /// Period in cycles.
    pub period: u32,
    /// The state at the start of a trajectory.
    pub state: crate::model::InitialState,
}

/// How a branch was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Origin {
    /// An orbit found at a value of the parameter.
    Found(f64),
    /// A given state, by its number.
    Given(usize),
    /// A bifurcation of another branch: that branch and its bifurcation, by number.
    Bifurcation(usize, usize),
}

impl Origin {
    /// A description in words. `first` is the number that the first branch of this exploration has in the results.
    pub fn text(&self, first: usize) -> String {
        match self {
            Self::Found(value) => format!("an orbit at {value}"),
            Self::Given(number) => format!("given state {number}"),
            Self::Bifurcation(branch, number) => {
                format!("bifurcation {number} of branch {}", first + branch)
            }
        }
    }
}

/// Branches over a parameter.
#[derive(Debug, Clone, Default)]
pub struct Branches {
    /// The branches, each with its origin.
    pub all: Vec<(Origin, Branch)>,
    /// Descriptions of failures.
    pub failures: Vec<String>,
    /// Orbits that were not followed because they lie on known branches.
    pub repeated_orbits: usize,
}

/// Reasons why an exploration fails.
#[derive(Debug, thiserror::Error)]
pub enum ExploreError {
    /// There is no map.
    #[error(transparent)]
    Map(#[from] MapError),
    /// The exploration was interrupted.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

/// Finds the branches of a family of drives over its first parameter, at the value `second` of the second
/// one.
///
/// # Errors
/// [`ExploreError`].
pub fn explore<F: ParametricDrive>(
    map: &mut DriveMap<'_, F>,
    second: f64,
    settings: &ExplorationSettings,
    interrupt: &AtomicBool,
) -> Result<Branches, ExploreError> {
    let span = &settings.span;
    let at = |value: f64| -> MapParameters { [value, second] };
    let mut out = Branches::default();
    for (number, given) in settings.states.iter().enumerate() {
        Interrupted::check(interrupt)?;
        let start = map.model(at(given.value))?.start(&given.state);
        let guess = map.coordinates(&start.state);
        let mut orbits_near_guess = Vec::new();
        take(
            map,
            &mut orbits_near_guess,
            &guess,
            at(given.value),
            given.period,
        );
        if orbits_near_guess.is_empty() {
            out.failures.push(format!(
                "no orbit of period {} is near given state {number} at {}; give a closer state, or correct its period",
                given.period, given.value
            ));
        }
        for orbit in orbits_near_guess {
            begin(
                map,
                span,
                settings,
                orbit,
                Origin::Given(number),
                &mut out,
                interrupt,
            )?;
        }
    }
    for &value in &settings.starts {
        Interrupted::check(interrupt)?;
        let orbits_at_value = match orbits(map, at(value), &settings.search) {
            // The modes of another start may have nothing in common with those of the first.
            Err(MapError::NoModel(reason)) if value != settings.starts[0] => {
                out.failures
                    .push(format!("no orbit is sought at {value}: {reason}"));
                continue;
            }
            found => found?,
        };
        if orbits_at_value.is_empty() {
            out.failures.push(format!(
                "no orbit of period {} or shorter is found at {value}; raise continuation.guesses or longest_period",
                settings.search.longest
            ));
        }
        for orbit in orbits_at_value {
            begin(
                map,
                span,
                settings,
                orbit,
                Origin::Found(value),
                &mut out,
                interrupt,
            )?;
        }
    }
    // An interrupted search ends like a search that finds no orbit, so the interrupt is checked once more.
    Interrupted::check(interrupt)?;
    report_lost_branches(&mut out, span);
    Ok(out)
}

/// Reports branches that could not be followed, except those that were followed from their other ends.
fn report_lost_branches(out: &mut Branches, span: &Span) {
    for branch in 0..out.all.len() {
        for number in 0..out.all[branch].1.bifurcations.len() {
            let bifurcation = &out.all[branch].1.bifurcations[number];
            let Some(Unfollowed::Lost { period, .. }) = bifurcation.unfollowed_branch else {
                continue;
            };
            if is_end(out, span, bifurcation, period) {
                out.all[branch].1.bifurcations[number].unfollowed_branch = None;
            } else if let Some(unfollowed_branch) = &bifurcation.unfollowed_branch {
                let message = format!(
                    "at {}: {unfollowed_branch}",
                    bifurcation.orbit.at[span.axis]
                );
                out.failures.push(message);
            }
        }
    }
}

/// Follows the branch of an orbit, and the branches that begin on it.
fn begin(
    map: &mut impl CycleMap,
    span: &Span,
    settings: &ExplorationSettings,
    orbit: Orbit,
    origin: Origin,
    out: &mut Branches,
    interrupt: &AtomicBool,
) -> Result<(), ExploreError> {
    if is_known(map, span, out, &orbit) {
        out.repeated_orbits += 1;
        return Ok(());
    }
    if out.all.len() >= settings.most {
        let message =
            "more orbits are found than continuation.branches allows; raise continuation.branches";
        if !out.failures.iter().any(|failure| failure == message) {
            out.failures.push(message.to_owned());
        }
        return Ok(());
    }
    let value = orbit.at[span.axis];
    let period = orbit.period;
    let branch = match follow(map, span, orbit, &settings.steps) {
        Ok(branch) => branch,
        Err(reason) => {
            out.failures.push(format!(
                "the orbit of period {period} at {value} cannot be followed: {reason}"
            ));
            return Ok(());
        }
    };
    let mut queue = VecDeque::from([out.all.len()]);
    out.all.push((origin, branch));
    while let Some(parent) = queue.pop_front() {
        for number in 0..out.all[parent].1.bifurcations.len() {
            Interrupted::check(interrupt)?;
            let before = out.all.len();
            let unfollowed_branch = follow_branches_at(map, span, settings, (parent, number), out);
            queue.extend(before..out.all.len());
            out.all[parent].1.bifurcations[number].unfollowed_branch = unfollowed_branch;
        }
    }
    Ok(())
}

/// Follows the branches that begin at a bifurcation, given by its branch and its number. If a branch could
/// not be followed, returns its period and the reason.
fn follow_branches_at(
    map: &mut impl CycleMap,
    span: &Span,
    settings: &ExplorationSettings,
    (parent, number): (usize, usize),
    out: &mut Branches,
) -> Option<Unfollowed> {
    let bifurcation = out.all[parent].1.bifurcations[number].clone();
    let period = match bifurcation.kind {
        Kind::PeriodDoubling => 2 * bifurcation.orbit.period,
        _ => bifurcation.orbit.period,
    };
    if is_end(out, span, &bifurcation, period) {
        out.repeated_orbits += 1;
        return None;
    }
    if bifurcation.kind == Kind::PeriodDoubling && period > settings.search.longest {
        return Some(Unfollowed::PeriodTooLong { period });
    }
    let mut unfollowed_branch = None;
    for begins in switch::branches(map, span, &bifurcation) {
        let reason = match begins {
            Err(reason) => reason.to_string(),
            Ok([_, second]) if is_known(map, span, out, &second) => {
                out.repeated_orbits += 1;
                continue;
            }
            Ok(_) if out.all.len() >= settings.most => {
                format!(
                    "{} branches are followed, the limit of continuation.branches",
                    settings.most
                )
            }
            Ok([_, second]) if !span.contains(second.at[span.axis]) => {
                "it leaves the interval".to_owned()
            }
            Ok([first, second]) => {
                let branch = follow_away(map, span, first, second, &settings.steps);
                out.all.push((Origin::Bifurcation(parent, number), branch));
                continue;
            }
        };
        unfollowed_branch.get_or_insert(Unfollowed::Lost { period, reason });
    }
    unfollowed_branch
}

/// Whether the branch that begins at a period doubling has already been followed, in either direction.
fn is_end(branches: &Branches, span: &Span, at: &Bifurcation, period: u32) -> bool {
    if at.kind != Kind::PeriodDoubling {
        return false;
    }
    let meets = |orbit: &Orbit| {
        let difference = (orbit.at[span.axis] - at.orbit.at[span.axis]).abs();
        let near = |u: &Vec<f64>| distance(u, &at.orbit.u) <= SAME_PLACE * at.orbit.size();
        orbit.period == period
            && difference <= SAME_PLACE * span.scale()
            && orbit.details.strobes.iter().any(near)
    };
    branches.all.iter().any(|(_, branch)| {
        let ends = [branch.orbits.first(), branch.orbits.last()];
        let begins = |end: &End| matches!(end, End::Start | End::Merged { .. });
        (branch.ends.iter().zip(ends)).any(|(end, orbit)| begins(end) && orbit.is_some_and(meets))
    })
}

/// Difference below which two orbits or two period doublings are the same, relative to the interval and to
/// the size of the motion.
const SAME_PLACE: f64 = 1e-5;

/// Whether an orbit lies on a known branch. For each chord of the branch, the orbit of the branch is computed
/// on a plane across the chord and through the given orbit. The given orbit lies on the branch if both orbits
/// are the same.
fn is_known(map: &mut impl CycleMap, span: &Span, branches: &Branches, orbit: &Orbit) -> bool {
    for (_, branch) in &branches.all {
        if branch.orbits[0].period != orbit.period {
            continue;
        }
        for last in 1..branch.orbits.len() {
            for start in &orbit.details.strobes {
                if passes(map, span, (branch, last), (start, orbit)) {
                    return true;
                }
            }
        }
    }
    false
}

/// Whether a branch passes a given orbit between its orbits `last − 1` and `last`. `start` is one of the
/// strobe states of the given orbit.
fn passes(
    map: &mut impl CycleMap,
    span: &Span,
    (branch, last): (&Branch, usize),
    (start, orbit): (&Vec<f64>, &Orbit),
) -> bool {
    let [a, b] = [&branch.orbits[last - 1], &branch.orbits[last]];
    let chord = Vector::between(span, a, b);
    let offset = Vector {
        u: start.iter().zip(&a.u).map(|(x, a)| x - a).collect(),
        p: (orbit.at[span.axis] - a.at[span.axis]) / span.scale(),
        size: chord.size,
    };
    let along = offset.cosine(&chord) * offset.length() / chord.length();
    if !(-PAST_CHORD..=1.0 + PAST_CHORD).contains(&along) || offset.length() > 2.0 * chord.length()
    {
        return false;
    }
    let from = last.saturating_sub(2);
    let knots: Vec<(f64, &Orbit)> = (branch.lengths[from..].iter().copied())
        .zip(&branch.orbits[from..])
        .take(4)
        .collect();
    let s = branch.lengths[last - 1];
    let near = guess(span, &knots, s + along * (branch.lengths[last] - s));
    // A second guess: the point on the chord that is nearest to the given orbit.
    let on_plane = Vector {
        u: (a.u.iter().zip(&chord.u))
            .map(|(a, c)| a + along * c)
            .collect(),
        p: a.at[span.axis] + along * chord.p * span.scale(),
        size: chord.size,
    };
    [near, on_plane].into_iter().any(|guess| {
        let branch_orbit = place(map, span, a, &guess, PathCondition::Always(&chord));
        branch_orbit.is_ok_and(|branch_orbit| {
            same(&branch_orbit, orbit) && {
                let difference = (branch_orbit.at[span.axis] - orbit.at[span.axis]).abs();
                difference <= SAME_PLACE * span.scale()
            }
        })
    })
}

/// Fraction of a chord beyond its ends within which an orbit may still lie on the branch.
const PAST_CHORD: f64 = 0.1;
