//! Which periodic orbits, stable or not, lie on or near a point's attractor?
//!
//! The trajectory is advanced; where its strobe states nearly return after k cycles, the
//! state midway between a state and its return is a guess for Newton's method on the k-cycle
//! map. A chaotic set is threaded by unstable orbits, which its trajectory visits again and
//! again; of a settled motion the survey finds its own orbit, and midway between the points
//! of a doubled one lies its parent. States that are given are guesses as well.

use super::character::{self, Character};
use super::kick::{self, Kick};
use super::returns;
use super::shooting::{PeriodicOrbit, shoot, shortest};
use crate::analysis::called_off::CalledOff;
use crate::analysis::norm::EnergyNorm;
use crate::analysis::recurrence::Recurrence;
use crate::model::{InitialState, Model, TrajectoryState};
use crate::propagate::{Counters, Kernel, Stop};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};
use std::sync::atomic::AtomicBool;

/// Longest period that can be asked for, in mesh cycles.
pub const LONGEST_PERIOD: u32 = 64;

/// Distance, in half gaps, at which two orbits are one.
const SAME_ORBIT: f64 = 1e-6;

/// What is asked of periodic orbits.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OrbitConfig {
    /// Periods in mesh cycles, each in 1 …= [`LONGEST_PERIOD`].
    pub periods: Vec<u32>,
    /// Newton searches for each period.
    pub guesses: u32,
    /// Mesh cycles that guesses are taken from.
    pub cycles: u32,
    /// Whether the multipliers are kept, not only the largest.
    pub floquet: bool,
    /// Returns that a kick is followed over.
    pub returns: u32,
    /// Further guesses, for every period, at mesh cycle 0.
    pub states: Vec<InitialState>,
}

/// What a survey found.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct OrbitSurvey {
    /// The orbits, by period, then in the order found.
    pub orbits: Vec<OrbitOutcome>,
    /// Given states that led to no orbit, by period, then in the order given.
    pub missed: Vec<MissedState>,
    /// Mesh cycles integrated for guesses; Newton searches are not counted.
    pub cycles: u64,
}

/// A search from a given state that led to no orbit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MissedState {
    /// Which of the given states, from 0.
    pub state: u32,
    /// The period sought \[mesh cycles\].
    pub period: u32,
    /// Why there is no orbit.
    pub reason: String,
}

/// A periodic orbit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OrbitOutcome {
    /// The given state that led to it, from 0; none where a near return did.
    pub state: Option<u32>,
    /// Modal displacements \[m √kg\] and velocities \[m √kg/s\] at the start of a mesh cycle at
    /// which the excitation is as at cycle 0.
    pub start: [Vec<f64>; 2],
    /// Its own, shortest period \[mesh cycles\].
    pub period: u32,
    /// Distance between start and end of a period, in half gaps.
    pub residual: f64,
    /// Mesh deflection δ at the start of the mesh cycle at which it is smallest \[m\].
    pub deflection: f64,
    /// Its rate δ' there \[m/s\].
    pub velocity: f64,
    /// Largest exponent `ln|μ| / k` \[1/cycle\].
    pub lambda: f64,
    /// All multipliers, largest modulus first; empty where not asked for.
    pub multipliers: Vec<Complex64>,
    /// What else is to be said of it.
    pub character: Character,
    /// How a kick grows over several returns.
    pub kick: Kick,
}

/// Seeks periodic orbits from where `trajectory` stands, which is advanced.
///
/// # Errors
/// [`CalledOff`] when `called_off` was raised meanwhile.
pub fn survey<K: Kernel>(
    model: &Model,
    kernel: &K,
    trajectory: &mut TrajectoryState,
    question: &OrbitConfig,
    called_off: &AtomicBool,
) -> Result<OrbitSurvey, CalledOff> {
    let norm = EnergyNorm::new(model);
    let mut workspace = kernel.workspace();
    let mut counters = Counters::default();
    let mut path = vec![trajectory.clone()];
    for _ in 0..question.cycles {
        CalledOff::check(called_off)?;
        let integrated = kernel.advance(1, trajectory, &mut workspace, &mut (), &mut counters);
        // What diverged later may have passed orbits before.
        if integrated.is_err() {
            break;
        }
        path.push(trajectory.clone());
    }
    // Nothing repeats sooner than what drives it.
    let unit = Recurrence::new(model).excitation();
    let mut search = Search {
        model,
        kernel,
        norm: &norm,
        question,
        unit: unit.unwrap_or(1),
        workspace,
        found: Vec::new(),
    };
    let mut missed = Vec::new();
    let mut periods = question.periods.clone();
    periods.sort_unstable();
    periods.dedup();
    for period in periods {
        let possible = unit.is_some_and(|unit| period.is_multiple_of(unit));
        for (state, given) in (0..).zip(&question.states) {
            CalledOff::check(called_off)?;
            let led = if possible {
                search.from(&model.start(given), period, Some(state))
            } else {
                Err("the excitation does not repeat after this period".to_owned())
            };
            missed.extend(led.err().map(|reason| MissedState {
                state,
                period,
                reason,
            }));
        }
        if !possible {
            continue;
        }
        for guess in guesses(&norm, &path, period as usize, question.guesses as usize) {
            CalledOff::check(called_off)?;
            let guess = midway(model, &path[guess], &path[guess + period as usize]);
            // Most near returns belong to no orbit of this period, and no one asked for them.
            _ = search.from(&guess, period, None);
        }
    }
    let mut found = search.found;
    found.sort_by_key(|(_, outcome)| outcome.period);
    Ok(OrbitSurvey {
        orbits: found.into_iter().map(|(_, outcome)| outcome).collect(),
        missed,
        cycles: counters.cycles,
    })
}

/// The orbits of a model, as far as they are found.
struct Search<'a, K: Kernel> {
    model: &'a Model,
    kernel: &'a K,
    norm: &'a EnergyNorm,
    question: &'a OrbitConfig,
    /// Cycles after which the excitation repeats.
    unit: u32,
    workspace: K::Workspace,
    /// Strobe states and what is reported.
    found: Vec<(Vec<TrajectoryState>, OrbitOutcome)>,
}

impl<K: Kernel> Search<'_, K> {
    /// Seeks the orbit next to a guess, and adds it where it is a new one.
    ///
    /// # Errors
    /// Why there is no orbit; an iterate that diverges or storms is no fault of the point.
    fn from(
        &mut self,
        guess: &TrajectoryState,
        period: u32,
        state: Option<u32>,
    ) -> Result<(), String> {
        let (model, kernel, norm) = (self.model, self.kernel, self.norm);
        let stopped = |stop: Stop| match stop {
            Stop::FarStart { half_gaps, .. } => {
                format!(
                    "the mesh deflection of the state is {half_gaps:.1e} half gaps, which is too large"
                )
            }
            other => other.to_string(),
        };
        let orbit = seek(model, kernel, norm, guess, period, &mut self.workspace)
            .map_err(stopped)?
            .ok_or("Newton's method does not converge from this state")?;
        let known = (self.found.iter()).any(|(points, _)| passes(norm, points, &orbit));
        if !known {
            let described = self.describe(&orbit, state).map_err(stopped)?;
            self.found.push(described);
        }
        Ok(())
    }

    /// The strobe states of an orbit, and what is reported of it.
    fn describe(
        &mut self,
        orbit: &PeriodicOrbit,
        state: Option<u32>,
    ) -> Result<(Vec<TrajectoryState>, OrbitOutcome), Stop> {
        let (model, kernel, norm) = (self.model, self.kernel, self.norm);
        let workspace = &mut self.workspace;
        let (points, character) = character::of(model, kernel, norm, orbit, workspace)?;
        let (deflection, velocity) = points
            .iter()
            .map(|point| model.deflection(&point.state, 0.0))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap_or_default();
        let as_at_first =
            |point: &&TrajectoryState| point.cycle.is_multiple_of(u64::from(self.unit));
        let start = points.iter().find(as_at_first).unwrap_or(&orbit.start);
        let outcome = OrbitOutcome {
            state,
            start: model.basis.modes(&start.state),
            period: orbit.period,
            residual: orbit.residual,
            deflection,
            velocity,
            lambda: orbit.spectral_radius().ln() / f64::from(orbit.period),
            multipliers: if self.question.floquet { orbit.multipliers.clone() } else { Vec::new() },
            character,
            kick: kick::follow(model, kernel, norm, orbit, self.question.returns, workspace),
        };
        Ok((points, outcome))
    }
}

/// Places on the path that nearly return after `period` cycles, nearest first, no two within
/// a period of each other.
fn guesses(norm: &EnergyNorm, path: &[TrajectoryState], period: usize, most: usize) -> Vec<usize> {
    let apart = |n: usize| norm.distance(&path[n].state, &path[n + period].state);
    let places = 0..path.len().saturating_sub(period);
    returns::nearest(places, apart, period, most)
}

/// The state midway between two, at the time of the first.
fn midway(model: &Model, a: &TrajectoryState, b: &TrajectoryState) -> TrajectoryState {
    let middle = |(x, y): (&f64, &f64)| 0.5 * (x + y);
    let state = a.state.iter().zip(&b.state).map(middle).collect();
    TrajectoryState::new(model, state, a.cycle)
}

/// The orbit next to a guess, with its own period.
fn seek<K: Kernel>(
    model: &Model,
    kernel: &K,
    norm: &EnergyNorm,
    guess: &TrajectoryState,
    period: u32,
    workspace: &mut K::Workspace,
) -> Result<Option<PeriodicOrbit>, Stop> {
    match shoot(model, kernel, norm, guess, period, workspace)? {
        Some(orbit) => shortest(model, kernel, norm, orbit, 1, workspace).map(Some),
        None => Ok(None),
    }
}

/// Whether an orbit of these strobe states passes through the start of another.
fn passes(norm: &EnergyNorm, points: &[TrajectoryState], orbit: &PeriodicOrbit) -> bool {
    points.len() == orbit.period as usize
        && points.iter().any(|point| {
            norm.distance(&point.state, &orbit.start.state) <= SAME_ORBIT * norm.unit()
        })
}
