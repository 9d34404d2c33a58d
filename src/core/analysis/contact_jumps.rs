//! Advances a trajectory over many mesh cycles at once while no contact opens or closes.
//!
//! While no contact opens or closes, a period of the excitation is an affine map of the state, `x ↦ x₁ + A (x − x₀)`,
//! where a period leads from x₀ to x₁. Repeated squaring gives the map of n periods. A jump is taken only if contact
//! is certain to last throughout (`lasting_contact`). Otherwise the cycles are integrated.

use super::lasting_contact::LastingContact;
use super::norm::EnergyNorm;
use super::recurrence::excitation_period;
use crate::model::{Model, TrajectoryState};
use crate::numerics::linalg::{product, solve};
use crate::propagate::{Counters, Kernel, Tangents};
use faer::Mat;

/// Number of integrated cycles at the first attempt to jump. Each further attempt follows when this number
/// has doubled.
const FIRST_ATTEMPT: u64 = 64;

/// Smallest number of remaining cycles per mode at which an attempt is worth its time: an attempt takes as
/// long as some hundred cycles.
const LEAST_CYCLES_PER_MODE: u64 = 50;

/// Longest period of the excitation for which jumps are attempted \[mesh cycles\].
const LONGEST_PERIOD: usize = 64;

/// Jumps of a trajectory over cycles of constant contact, for one model.
#[derive(Debug)]
pub struct ContactJumps<'m> {
    model: &'m Model,
    norm: EnergyNorm,
    period: Option<u32>,
    integrated_cycles: u64,
    next: u64,
}

/// The affine map of a period of constant contact, `x ↦ x₁ + A (x − x₀)`.
struct Period {
    /// A − I for all components.
    increment: Mat<f64>,
    /// x₁ − x₀.
    drift: Vec<f64>,
    /// A for the components with a weight in the norm, in energy coordinates.
    weighted: Mat<f64>,
    /// x₁ − x₀ for the same components, in energy coordinates.
    weighted_drift: Vec<f64>,
}

impl<'m> ContactJumps<'m> {
    /// The jumps of a model, before its first integrated cycle.
    pub fn new(model: &'m Model) -> Self {
        let period = excitation_period(model).filter(|period| *period <= LONGEST_PERIOD);
        Self {
            model,
            norm: EnergyNorm::new(model),
            period: period.map(|period| period as u32),
            integrated_cycles: 0,
            next: FIRST_ATTEMPT,
        }
    }

    /// Counts an integrated cycle.
    pub fn count_integrated_cycle(&mut self) {
        self.integrated_cycles += 1;
    }

    /// Advances a trajectory by whole periods of the excitation, up to `cycles` mesh cycles, if contact is
    /// certain to last. Returns the number of cycles: 0 if no attempt is due, if the excitation has no short
    /// period, if too few cycles remain, or if contact is not certain to last.
    pub fn jump<K: Kernel>(
        &mut self,
        kernel: &K,
        trajectory: &mut TrajectoryState,
        cycles: u64,
        workspace: &mut K::Workspace,
    ) -> u64 {
        let Some(period) = self.period else {
            return 0;
        };
        let worth = LEAST_CYCLES_PER_MODE * self.model.modes() as u64;
        if self.integrated_cycles < self.next || cycles < worth.max(u64::from(period)) {
            return 0;
        }
        self.next = 2 * self.integrated_cycles;
        let periods = cycles / u64::from(period);
        let jumped = (self.map(kernel, trajectory, period, workspace))
            .filter(|map| self.certain(kernel, trajectory, period, map, workspace))
            .and_then(|map| displacement_over(map, periods))
            .map(|displacement| {
                for (x, change) in trajectory.state.iter_mut().zip(displacement) {
                    *x += change;
                }
                trajectory.cycle += periods * u64::from(period);
                periods * u64::from(period)
            });
        jumped.unwrap_or(0)
    }

    /// The map of the next period; `None` if no contact is closed, if one changes, or if the kernel stops.
    fn map<K: Kernel>(
        &self,
        kernel: &K,
        start: &TrajectoryState,
        period: u32,
        workspace: &mut K::Workspace,
    ) -> Option<Period> {
        let size = start.state.len();
        if !start.contact.touching() {
            return None;
        }
        let mut counters = Counters::default();
        let mut next_state = start.clone();
        // The first integration is without tangents, because it is cheap and detects rattle.
        kernel
            .advance(
                u64::from(period),
                &mut next_state,
                workspace,
                &mut (),
                &mut counters,
            )
            .ok()?;
        if counters.events > 0 {
            return None;
        }
        let mut next_state = start.clone();
        let mut tangents = Tangents::zeros(size / 2, size);
        for i in 0..size {
            tangents.vector_mut(i)[i] = 1.0;
        }
        for _ in 0..period {
            kernel
                .advance_cycle(
                    &mut next_state,
                    &mut tangents,
                    workspace,
                    &mut (),
                    &mut counters,
                )
                .ok()?;
        }
        if counters.events > 0 || next_state.contact != start.contact {
            return None;
        }
        let unit = |i: usize, j: usize| f64::from(u8::from(i == j));
        let increment = Mat::from_fn(size, size, |i, j| tangents.vector(j)[i] - unit(i, j));
        for j in 0..size {
            self.norm.project(tangents.vector_mut(j));
        }
        let (weights, weighted) = (self.norm.weights(), self.norm.weighted_components());
        Some(Period {
            increment,
            drift: (next_state.state.iter().zip(&start.state))
                .map(|(end, start)| end - start)
                .collect(),
            weighted: Mat::from_fn(weighted.len(), weighted.len(), |row, column| {
                let (i, j) = (weighted[row], weighted[column]);
                weights[i] * tangents.vector(j)[i] / weights[j]
            }),
            weighted_drift: self.norm.difference(&next_state.state, &start.state),
        })
    }

    /// Whether contact certainly lasts for ever, if `map` is the map of the next period.
    fn certain<K: Kernel>(
        &self,
        kernel: &K,
        start: &TrajectoryState,
        period: u32,
        map: &Period,
        workspace: &mut K::Workspace,
    ) -> bool {
        let size = map.weighted_drift.len();
        let rest = Mat::from_fn(size, size, |i, j| {
            f64::from(u8::from(i == j)) - map.weighted[(i, j)]
        });
        let next_state = solve(rest.as_ref(), &map.weighted_drift);
        let mut end = start.clone();
        self.norm.displace(&mut end.state, 1.0, &next_state);
        let lasting = LastingContact::new(self.model, &self.norm, &map.weighted, (end, period));
        let away: Vec<f64> = next_state.iter().map(|x| -x).collect();
        lasting.is_some_and(|mut lasting| lasting.is_certain(kernel, &away, workspace))
    }
}

/// Displacement of x₀ over a number of periods; `None` if it is not finite.
fn displacement_over(map: Period, periods: u64) -> Option<Vec<f64>> {
    let size = map.drift.len();
    let (mut increment, mut drift) = (map.increment, map.drift);
    let mut displacement = vec![0.0; size];
    let through = |increment: &Mat<f64>, x: &[f64], y: &[f64]| -> Vec<f64> {
        let sum = |i: usize| (0..size).map(|j| increment[(i, j)] * x[j]).sum::<f64>();
        (0..size).map(|i| x[i] + sum(i) + y[i]).collect()
    };
    let mut left = periods;
    while left > 0 {
        if left & 1 == 1 {
            displacement = through(&increment, &displacement, &drift);
        }
        left >>= 1;
        if left > 0 {
            drift = through(&increment, &drift, &drift);
            let square = product(increment.as_ref(), increment.as_ref());
            increment = Mat::from_fn(size, size, |i, j| 2.0 * increment[(i, j)] + square[(i, j)]);
        }
    }
    displacement
        .iter()
        .all(|x| x.is_finite())
        .then_some(displacement)
}
