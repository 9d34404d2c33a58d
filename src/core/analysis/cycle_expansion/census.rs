//! Which periodic orbits of some periods does a chaotic set have, and how many are missing?
//!
//! The states of a trajectory that nearly return after n iterations, and those between, are a
//! guess for [`close`]. The nearest returns are taken in the order in which the trajectory passes
//! them, so that some of them are a fair sample of all. Searches go on until a doubling of their
//! number finds no orbit more or their number is spent. How often each orbit was found tells how
//! many were not (Chao 1984):
//!
//! ```text
//! unseen ≈ f₁ (f₁ − 1) / 2 (f₂ + 1)
//! ```
//!
//! with f₁ orbits found by one search alone and f₂ by two. A search may end far from where it began,
//! on an orbit that the set does not contain: such are set apart, by how near the trajectory comes
//! to them.

use super::closing::{Closed, close};
use super::observables::{Cycles, GROWTH, SUMS, Sums};
use crate::analysis::called_off::CalledOff;
use crate::analysis::norm::EnergyNorm;
use crate::analysis::orbits::returns;
use crate::model::{Model, TrajectoryState};
use crate::propagate::{Counters, Kernel};
use num_complex::Complex64;
use std::sync::atomic::AtomicBool;

/// Searches after which it is first looked whether as many again found more.
const FIRST_LOOK: usize = 512;

/// Distance, in half gaps, at which two orbits are one, and two points.
const SAME_ORBIT: f64 = 1e-6;

/// Points of the trajectory of which the nearest other is sought.
const SAMPLED: usize = 256;

/// Times the largest of their distances that a point of the set may be from the trajectory.
const SLACK: f64 = 2.0;

/// An orbit of the census.
#[derive(Debug, Clone)]
pub struct Found {
    /// Its states, an iteration apart.
    pub points: Vec<TrajectoryState>,
    /// Its multipliers.
    pub multipliers: Vec<Complex64>,
    /// Sums over the mesh cycles of its period.
    pub sums: Sums,
    /// Searches for its own period that found it.
    pub hits: u64,
    /// Whether the trajectory comes as near to all of its points as to points of its own.
    pub belongs: bool,
}

/// Searches for one period, and what came of them.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Effort {
    /// Searches.
    pub searches: u64,
    /// Searches that ended on an orbit, of this or a shorter period.
    pub closed: u64,
}

/// Every orbit found, and the work of it.
#[derive(Debug, Clone, Default)]
pub struct Census {
    /// Unstable orbits by period, then in the order found.
    pub orbits: Vec<Found>,
    /// Work by period, from 1.
    pub efforts: Vec<Effort>,
    /// Mesh cycles integrated with all tangents.
    pub cycles: u64,
}

/// The chaotic set whose orbits are sought.
pub struct Set<'a, K: Kernel> {
    /// The drive.
    pub model: &'a Model,
    /// What integrates it.
    pub kernel: &'a K,
    /// What distances are measured in.
    pub norm: &'a EnergyNorm,
    /// States of its trajectory, an iteration apart.
    pub path: &'a [TrajectoryState],
    /// Mesh cycles in an iteration.
    pub unit: u32,
}

impl<K: Kernel> Set<'_, K> {
    /// The orbits of up to `longest` iterations, by at most `guesses` searches for each period.
    ///
    /// # Errors
    /// [`CalledOff`] when `called_off` was raised meanwhile.
    pub fn census(
        &self,
        longest: usize,
        guesses: usize,
        called_off: &AtomicBool,
    ) -> Result<Census, CalledOff> {
        let mut census = Census::default();
        let mut workspace = self.kernel.workspace();
        for period in 1..=longest {
            let mut effort = Effort::default();
            let (mut look, mut known) = (FIRST_LOOK, 0);
            for place in self.returns(period, guesses) {
                CalledOff::check(called_off)?;
                if effort.searches as usize == look {
                    let now = census.orbits.len();
                    if known == now && effort.closed > 0 {
                        break;
                    }
                    (look, known) = (2 * look, now);
                }
                effort.searches += 1;
                if self.search(place, period, &mut census, &mut workspace) {
                    effort.closed += 1;
                }
            }
            census.efforts.push(effort);
        }
        let reach = self.reach();
        for orbit in &mut census.orbits {
            CalledOff::check(called_off)?;
            orbit.belongs = orbit.points.iter().all(|point| {
                let near =
                    |other: &TrajectoryState| self.norm.within(reach, &other.state, &point.state);
                self.path.iter().any(near)
            });
        }
        Ok(census)
    }

    /// How far from the trajectory a point of the set may be: some times the largest distance of
    /// points of the trajectory from the nearest other.
    fn reach(&self) -> f64 {
        let step = self.path.len().div_ceil(SAMPLED);
        let nearest = |place: usize| {
            let own = &self.path[place].state;
            let others = self.path.iter().enumerate().filter(|(n, _)| *n != place);
            others
                .map(|(_, other)| self.norm.distance(own, &other.state))
                .fold(f64::INFINITY, f64::min)
        };
        let places = (0..self.path.len()).step_by(step);
        SLACK * places.map(nearest).fold(0.0, f64::max)
    }

    /// The places of the path that return nearest after `period` iterations, in the order of the path,
    /// no two within a period of each other.
    fn returns(&self, period: usize, most: usize) -> Vec<usize> {
        let apart =
            |n: usize| (self.norm).distance(&self.path[n].state, &self.path[n + period].state);
        let places = 0..self.path.len().saturating_sub(period);
        let mut chosen = returns::nearest(places, apart, period, most);
        chosen.sort_unstable();
        chosen
    }

    /// A search from the path at `place`; whether it ended on an orbit.
    fn search(
        &self,
        place: usize,
        period: usize,
        census: &mut Census,
        workspace: &mut K::Workspace,
    ) -> bool {
        let mut counters = Counters::default();
        let mut points = self.path[place..place + period].to_vec();
        let ahead = &self.path[place + period];
        let first = &mut points[0];
        let middle = (first.state.iter().zip(&ahead.state)).map(|(a, b)| 0.5 * (a + b));
        *first = TrajectoryState::new(self.model, middle.collect(), first.cycle);
        let found = close(
            self.model,
            self.kernel,
            self.norm,
            points,
            self.unit,
            workspace,
            &mut counters,
        );
        census.cycles += counters.cycles;
        // An iterate that diverges or storms is no orbit, and no fault of the point.
        let Ok(Some(closed)) = found else {
            return false;
        };
        self.enter(closed, census, workspace);
        true
    }

    /// Enters an orbit into the census, or one more search that found it.
    fn enter(&self, closed: Closed, census: &mut Census, workspace: &mut K::Workspace) {
        let same = |a: &TrajectoryState, b: &TrajectoryState| {
            let limit = SAME_ORBIT * self.norm.unit();
            self.norm.within(limit, &a.state, &b.state)
        };
        let period = closed.points.len();
        let start = &closed.points[0];
        let repeats = |n: &usize| period.is_multiple_of(*n) && same(&closed.points[*n], start);
        // The searches for its own period find the shorter orbit.
        if (1..period).any(|n| repeats(&n)) {
            return;
        }
        let known = (census.orbits.iter_mut())
            .filter(|orbit| orbit.points.len() == period)
            .find(|orbit| orbit.points.iter().any(|point| same(point, start)));
        if let Some(orbit) = known {
            orbit.hits += 1;
            return;
        }
        // An orbit that attracts is a motion of its own.
        let Some(leading) = closed.multipliers.first().filter(|m| m.norm() > 1.0) else {
            return;
        };
        let mut sums = [0.0; SUMS];
        let mut cycles = Cycles::new(self.model);
        let mut counters = Counters::default();
        for point in &closed.points {
            let mut state = point.clone();
            for _ in 0..self.unit {
                let passed =
                    (self.kernel).advance(1, &mut state, workspace, &mut cycles, &mut counters);
                if passed.is_err() {
                    return;
                }
                let own = cycles.close();
                for (sum, x) in sums.iter_mut().zip(own) {
                    *sum += x;
                }
            }
        }
        sums[GROWTH] = leading.norm().ln();
        census.orbits.push(Found {
            points: closed.points,
            multipliers: closed.multipliers,
            sums,
            hits: 1,
            belongs: false,
        });
    }
}
