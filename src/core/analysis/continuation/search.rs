//! First orbits at given parameters: the orbit in lasting contact, and the orbits that a trajectory approaches.

use super::drive::{DriveMap, ParametricDrive};
use super::map::{CycleMap, MapError, MapParameters};
use super::orbit::{Orbit, OrbitCondition, distance, find, length, same};
use crate::analysis::orbits::returns;
use crate::model::{InitialState, TrajectoryState};

/// Settings of the search for orbits.
#[derive(Debug, Clone, PartialEq)]
pub struct OrbitSearchSettings {
    /// Number of cycles before the search for near returns.
    pub transient: u64,
    /// Number of cycles in which near returns are sought.
    pub cycles: u64,
    /// Longest period.
    pub longest: u32,
    /// Maximum number of Newton searches for each period from the first trajectory. Further ones have one search each.
    pub guesses: usize,
    /// Initial state of the first trajectory.
    pub initial: InitialState,
}

/// The orbits found at given parameters, each with its shortest period: first the orbit near static equilibrium, then
/// by period.
///
/// # Errors
/// [`MapError`] if there is no model.
pub fn orbits<F: ParametricDrive>(
    map: &mut DriveMap<'_, F>,
    at: MapParameters,
    search: &OrbitSearchSettings,
) -> Result<Vec<Orbit>, MapError> {
    let start = map.model(at)?.start(&search.initial);
    let unit = map.unit();
    let mut found: Vec<Orbit> = Vec::new();
    let resting = map.model(at)?.start(&InitialState::Static);
    let guess = map.coordinates(&resting.state);
    take(map, &mut found, &guess, at, unit);
    let Ok(path) = strobes(map, at, start, search, unit) else {
        return Ok(found);
    };
    // After a chaotic transient, round-off decides which orbit a trajectory reaches. Further trajectories
    // therefore start at other distances from the mean of the first one.
    let others = DISTANCE_FACTORS.map(|factor| widened(&path, factor));
    let mut paths = vec![path];
    for start in others {
        let start = map.state(&start);
        paths.extend(strobes(map, at, start, search, unit).ok());
    }
    for period in (unit..=search.longest).step_by(unit as usize) {
        for (number, path) in paths.iter().enumerate() {
            let guesses = if number == 0 { search.guesses } else { 1 };
            for guess in near_returns(path, period as usize, unit as usize, guesses) {
                take(map, &mut found, &guess, at, period);
            }
        }
    }
    Ok(found)
}

/// Finds the orbit near a guess, reduces it to its shortest period, and adds it to `orbits` if it is new.
pub fn take(
    map: &mut impl CycleMap,
    orbits: &mut Vec<Orbit>,
    guess: &[f64],
    at: MapParameters,
    period: u32,
) {
    let Ok(mut orbit) = find(map, guess, at, period, &OrbitCondition::Parameters) else {
        return;
    };
    let unit = map.unit();
    let shorter = (1..period).filter(|d| period.is_multiple_of(*d) && d.is_multiple_of(unit));
    for cycles in shorter {
        if length(&orbit.offset(cycles)) < SAME_POINT * orbit.size() {
            if let Ok(refined) = find(map, &orbit.u, at, cycles, &OrbitCondition::Parameters) {
                orbit = refined;
            }
            break;
        }
    }
    if !orbits.iter().any(|known| same(known, &orbit)) {
        orbits.push(orbit);
    }
}

/// Factors from the last state's displacement from the mean of the trajectory to that of each additional
/// start.
const DISTANCE_FACTORS: [f64; 3] = [-1.0, 2.0, -3.0];

/// The state at `factor` times the displacement of the last state from the mean of a path.
fn widened(path: &[Vec<f64>], factor: f64) -> Vec<f64> {
    let last = &path[path.len() - 1];
    let mean = |i: usize| path.iter().map(|u| u[i]).sum::<f64>() / path.len() as f64;
    (last.iter().enumerate())
        .map(|(i, u)| mean(i) + factor * (u - mean(i)))
        .collect()
}

/// Distance, in sizes of the motion, below which two points of an orbit are the same.
const SAME_POINT: f64 = 1e-7;

fn strobes<F: ParametricDrive>(
    map: &mut DriveMap<'_, F>,
    at: MapParameters,
    start: TrajectoryState,
    search: &OrbitSearchSettings,
    unit: u32,
) -> Result<Vec<Vec<f64>>, MapError> {
    let mut state = start;
    // Newton's method integrates from the start of the excitation's period, so the path starts there.
    let transient = search.transient.next_multiple_of(u64::from(unit));
    map.advance(at, transient, &mut state, &mut ())?;
    let mut path = vec![map.coordinates(&state.state)];
    for _ in 0..search.cycles {
        map.advance(at, 1, &mut state, &mut ())?;
        path.push(map.coordinates(&state.state));
    }
    Ok(path)
}

/// Midpoints between a state of the path and its return after `period` cycles, nearest returns first. No two
/// of them are within a period of each other. All have the same phase of the excitation as the start of the
/// path.
fn near_returns(path: &[Vec<f64>], period: usize, unit: usize, most: usize) -> Vec<Vec<f64>> {
    let return_distance = |n: usize| distance(&path[n], &path[n + period]);
    let places = (0..path.len().saturating_sub(period)).step_by(unit);
    let chosen = returns::nearest(places, return_distance, period, most);
    let midway = |n: usize| {
        path[n]
            .iter()
            .zip(&path[n + period])
            .map(|(a, b)| 0.5 * (a + b))
            .collect()
    };
    chosen.into_iter().map(midway).collect()
}
