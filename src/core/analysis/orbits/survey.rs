//! Which periodic orbits, stable or not, lie on or near a point's attractor?
//!
//! The trajectory is advanced. If its strobe states nearly return after k cycles, the midpoint of a state and its
//! return is a guess for Newton's method on the k-cycle map. A chaotic set contains unstable orbits that its
//! trajectory approaches again and again. For a settled motion, the survey finds its periodic orbit. If its period has
//! doubled, the midpoint between its points leads to the unstable parent orbit. Given states are guesses as well.

use super::character::{self, Character};
use super::kick::{self, Kick};
use super::returns;
use super::shooting::{PeriodicOrbit, shoot, shortest};
use crate::analysis::interrupt::Interrupted;
use crate::analysis::norm::EnergyNorm;
use crate::analysis::recurrence::Recurrence;
use crate::model::{InitialState, Model, TrajectoryState};
use crate::propagate::{Counters, Kernel, Stop};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};
use std::sync::atomic::AtomicBool;

/// Upper limit of the periods \[mesh cycles\].
pub const LONGEST_PERIOD: u32 = 64;

/// Distance, in half gaps, below which two orbits are the same.
const SAME_ORBIT: f64 = 1e-6;

/// Settings of a survey of periodic orbits.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OrbitConfig {
    /// Periods in mesh cycles, each in 1 …= [`LONGEST_PERIOD`]. A period that is not a multiple of the
    /// excitation's period is instead a number of periods of the excitation.
    pub periods: Vec<u32>,
    /// Maximum number of Newton searches for each period.
    pub guesses: u32,
    /// Number of mesh cycles in which near returns are sought as guesses.
    pub cycles: u32,
    /// Whether all multipliers are stored, or only the largest.
    pub floquet: bool,
    /// Number of returns over which a kick is followed.
    pub returns: u32,
    /// Further guesses, for every period, at mesh cycle 0.
    pub states: Vec<InitialState>,
}

/// Results of a survey.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct OrbitSurvey {
    /// The orbits, by period, then in the order found.
    pub orbits: Vec<OrbitOutcome>,
    /// Given states near which no orbit was found, by period, then in the given order.
    pub missed: Vec<MissedState>,
    /// Mesh cycles integrated for guesses; Newton searches are not counted.
    pub cycles: u64,
}

/// A search from a given state that found no orbit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MissedState {
    /// Index of the given state, from 0.
    pub state: u32,
    /// The period sought \[mesh cycles\].
    pub period: u32,
    /// The reason.
    pub reason: String,
}

/// A periodic orbit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OrbitOutcome {
    /// Index of the given state that led to it, from 0; `None` if it was found by a near return.
    pub state: Option<u32>,
    /// Modal displacements \[m √kg\] and velocities \[m √kg/s\] at the start of a mesh cycle with the same excitation
    /// as cycle 0.
    pub start: [Vec<f64>; 2],
    /// Shortest period \[mesh cycles\].
    pub period: u32,
    /// Distance between start and end of a period, in half gaps.
    pub residual: f64,
    /// Smallest mesh deflection δ at the start of a mesh cycle of the period \[m\].
    pub deflection: f64,
    /// Rate δ' of the mesh deflection at that time \[m/s\].
    pub velocity: f64,
    /// Largest exponent `ln|μ| / k` \[1/cycle\].
    pub lambda: f64,
    /// All multipliers, largest modulus first; empty if `floquet` is not set.
    pub multipliers: Vec<Complex64>,
    /// Other properties of the orbit.
    pub character: Character,
    /// How a kick grows over several returns.
    pub kick: Kick,
}

/// Seeks periodic orbits from `trajectory`, which is advanced.
///
/// # Errors
/// [`Interrupted`] if `interrupt` was raised.
pub fn survey<K: Kernel>(
    model: &Model,
    kernel: &K,
    trajectory: &mut TrajectoryState,
    config: &OrbitConfig,
    interrupt: &AtomicBool,
) -> Result<OrbitSurvey, Interrupted> {
    let norm = EnergyNorm::new(model);
    let mut workspace = kernel.workspace();
    let mut counters = Counters::default();
    let mut path = vec![trajectory.clone()];
    for _ in 0..config.cycles {
        Interrupted::check(interrupt)?;
        let integrated = kernel.advance(1, trajectory, &mut workspace, &mut (), &mut counters);
        // A trajectory that diverges may have passed orbits before, so the survey continues with its earlier
        // states.
        if integrated.is_err() {
            break;
        }
        path.push(trajectory.clone());
    }
    // No motion repeats sooner than the excitation.
    let unit = Recurrence::new(model).excitation();
    let mut search = Search {
        model,
        kernel,
        norm: &norm,
        config,
        unit: unit.unwrap_or(1),
        workspace,
        found: Vec::new(),
    };
    let mut missed = Vec::new();
    let in_cycles = |period: &u32| match unit {
        Some(unit) if !period.is_multiple_of(unit) => period * unit,
        _ => *period,
    };
    let mut periods: Vec<u32> = config.periods.iter().map(in_cycles).collect();
    periods.sort_unstable();
    periods.dedup();
    for period in periods {
        for (state, given) in (0..).zip(&config.states) {
            Interrupted::check(interrupt)?;
            let result = if unit.is_some() {
                search.from(&model.start(given), period, Some(state))
            } else {
                Err("the excitation does not repeat".to_owned())
            };
            missed.extend(result.err().map(|reason| MissedState {
                state,
                period,
                reason,
            }));
        }
        if unit.is_none() {
            continue;
        }
        // States of the path that nearly return after a period, nearest first, no two within a period of each other.
        let returns_after = |n: usize| &path[n + period as usize];
        let return_distance = |n: usize| norm.distance(&path[n].state, &returns_after(n).state);
        let places = 0..path.len().saturating_sub(period as usize);
        let most = config.guesses as usize;
        for guess in returns::nearest(places, return_distance, period as usize, most) {
            Interrupted::check(interrupt)?;
            let guess = midway(model, &path[guess], returns_after(guess));
            // Most near returns belong to no orbit of this period, and the caller did not ask for them.
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

/// A search for orbits, and the orbits found so far.
struct Search<'a, K: Kernel> {
    model: &'a Model,
    kernel: &'a K,
    norm: &'a EnergyNorm,
    config: &'a OrbitConfig,
    /// Period of the excitation \[mesh cycles\].
    unit: u32,
    workspace: K::Workspace,
    /// The strobe states and the result of each orbit.
    found: Vec<(Vec<TrajectoryState>, OrbitOutcome)>,
}

impl<K: Kernel> Search<'_, K> {
    /// Seeks the orbit near a guess, and adds it if it is new.
    ///
    /// # Errors
    /// The reason why there is no orbit. An iterate that diverges or has too many events is not an error of the
    /// point.
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
        let workspace = &mut self.workspace;
        let orbit = shoot(model, kernel, norm, guess, period, workspace)
            .map_err(stopped)?
            .ok_or("Newton's method does not converge from this state")?;
        let orbit = shortest(model, kernel, norm, orbit, self.unit, workspace).map_err(stopped)?;
        let known = (self.found.iter()).any(|(points, _)| passes(norm, points, &orbit));
        if !known {
            let described = self.describe(&orbit, state).map_err(stopped)?;
            self.found.push(described);
        }
        Ok(())
    }

    /// The strobe states and the result of an orbit.
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
            multipliers: if self.config.floquet { orbit.multipliers.clone() } else { Vec::new() },
            character,
            kick: kick::follow(model, kernel, norm, orbit, self.config.returns, workspace),
        };
        Ok((points, outcome))
    }
}

/// The state midway between two, at the time of the first.
fn midway(model: &Model, a: &TrajectoryState, b: &TrajectoryState) -> TrajectoryState {
    let middle = |(x, y): (&f64, &f64)| 0.5 * (x + y);
    let state = a.state.iter().zip(&b.state).map(middle).collect();
    TrajectoryState::new(model, state, a.cycle)
}

/// Whether an orbit with the strobe states `points` passes through the start of `orbit`.
fn passes(norm: &EnergyNorm, points: &[TrajectoryState], orbit: &PeriodicOrbit) -> bool {
    points.len() == orbit.period as usize
        && points.iter().any(|point| {
            norm.distance(&point.state, &orbit.start.state) <= SAME_ORBIT * norm.unit()
        })
}
