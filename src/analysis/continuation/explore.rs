//! All branches over a parameter that some orbits lead to.
//!
//! Orbits are sought at some values of the parameter. Each that lies on no branch known so far is
//! followed both ways, and so are the branches that begin where a period doubles or branches cross.
//! Everything happens in a fixed order, so that the same bits come of it.

use super::branch::{Branch, Steps, follow, follow_away, interpolated};
use super::drive::{DriveMap, Family};
use super::map::{At, CycleMap, MapError};
use super::orbit::{Border, Orbit, distance, find, same};
use super::path::Span;
use super::search::{Search, orbits, take};
use super::switch;
use crate::analysis::called_off::CalledOff;
use std::collections::VecDeque;
use std::sync::atomic::AtomicBool;

/// What is followed.
#[derive(Debug, Clone, PartialEq)]
pub struct Exploration {
    /// The parameter and its interval.
    pub span: Span,
    /// Values of the parameter at which orbits are sought.
    pub starts: Vec<f64>,
    /// How they are sought.
    pub search: Search,
    /// States to begin with, at a value of the parameter, with their period.
    pub states: Vec<GivenState>,
    /// How branches are followed.
    pub steps: Steps,
    /// Most branches.
    pub most: usize,
}

/// A state given to begin with.
#[derive(Debug, Clone, PartialEq)]
pub struct GivenState {
    /// Value of the parameter.
    pub value: f64,
    /// Period in cycles.
    pub period: u32,
    /// The state, as a trajectory starts.
    pub state: crate::model::InitialState,
}

/// How a branch was come by.
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
    /// In words; `first` is the number of the line's first branch.
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
    /// The branches, with where they come from.
    pub all: Vec<(Origin, Branch)>,
    /// What did not work, in sentences.
    pub failures: Vec<String>,
    /// Orbits from which nothing was followed, since they lie on known branches.
    pub known: usize,
}

/// Why nothing was explored.
#[derive(Debug, thiserror::Error)]
pub enum ExploreError {
    /// There is no map.
    #[error(transparent)]
    Map(#[from] MapError),
    /// It was called off.
    #[error(transparent)]
    CalledOff(#[from] CalledOff),
}

/// Explores a family of drives over its first parameter, the second being `second`.
///
/// # Errors
/// [`ExploreError`].
pub fn explore<F: Family>(
    map: &mut DriveMap<'_, F>,
    second: f64,
    asked: &Exploration,
    called_off: &AtomicBool,
) -> Result<Branches, ExploreError> {
    let span = &asked.span;
    let at = |value: f64| -> At { [value, second] };
    let mut out = Branches::default();
    for (number, given) in asked.states.iter().enumerate() {
        CalledOff::check(called_off)?;
        let start = map.model(at(given.value))?.start(&given.state);
        let guess = map.coordinates(&start.state);
        let mut found = Vec::new();
        take(map, &mut found, &guess, at(given.value), given.period);
        if found.is_empty() {
            out.failures.push(format!(
                "no orbit of period {} lies next to given state {number} at {}; give a nearer state, or its period",
                given.period, given.value
            ));
        }
        for orbit in found {
            begin(
                map,
                span,
                asked,
                orbit,
                Origin::Given(number),
                &mut out,
                called_off,
            )?;
        }
    }
    for &value in &asked.starts {
        CalledOff::check(called_off)?;
        for orbit in orbits(map, at(value), &asked.search)? {
            begin(
                map,
                span,
                asked,
                orbit,
                Origin::Found(value),
                &mut out,
                called_off,
            )?;
        }
    }
    // Integrations that were called off look as if orbits were not found.
    CalledOff::check(called_off)?;
    Ok(out)
}

/// Follows the branch of an orbit, and those that begin on it.
fn begin(
    map: &mut impl CycleMap,
    span: &Span,
    asked: &Exploration,
    orbit: Orbit,
    origin: Origin,
    out: &mut Branches,
    called_off: &AtomicBool,
) -> Result<(), ExploreError> {
    if out.all.len() >= asked.most {
        return Ok(());
    }
    if is_known(map, span, out, &orbit) {
        out.known += 1;
        return Ok(());
    }
    let value = orbit.at[span.axis];
    let period = orbit.period;
    let branch = match follow(map, span, orbit, &asked.steps) {
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
        let bifurcations = out.all[parent].1.bifurcations.clone();
        for (number, bifurcation) in bifurcations.iter().enumerate() {
            CalledOff::check(called_off)?;
            if bifurcation.kind == super::bifurcation::Kind::PeriodDoubling
                && 2 * bifurcation.orbit.period > asked.search.longest
            {
                continue;
            }
            for [first, second] in switch::branches(map, span, bifurcation) {
                if out.all.len() >= asked.most || !span.holds(second.at[span.axis]) {
                    continue;
                }
                if is_known(map, span, out, &second) {
                    out.known += 1;
                    continue;
                }
                let branch = follow_away(map, span, first, second, &asked.steps);
                queue.push_back(out.all.len());
                out.all.push((Origin::Bifurcation(parent, number), branch));
            }
        }
    }
    Ok(())
}

/// Whether an orbit lies on a known branch.
fn is_known(map: &mut impl CycleMap, span: &Span, known: &Branches, orbit: &Orbit) -> bool {
    let value = orbit.at[span.axis];
    let branches = known.all.iter().map(|(_, branch)| branch);
    let pairs = branches.flat_map(|branch| branch.orbits.windows(2));
    for pair in pairs {
        let crossed = (pair[0].at[span.axis] - value) * (pair[1].at[span.axis] - value) <= 0.0;
        if pair[0].period != orbit.period || !crossed {
            continue;
        }
        let guess = interpolated(span, &pair[0], &pair[1], value);
        let near = orbit
            .details
            .strobes
            .iter()
            .any(|u| distance(u, &guess) < NEAR);
        if near
            && find(map, &guess, orbit.at, orbit.period, &Border::Parameters)
                .is_ok_and(|found| same(&found, orbit))
        {
            return true;
        }
    }
    false
}

/// Distance \[half gaps\] from a branch, linear between its orbits, from which an orbit is not on it.
const NEAR: f64 = 0.5;
