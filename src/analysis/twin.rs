//! The same exponent from two full trajectories.
//!
//! A twin starts a small distance away and is pulled back to that distance after every
//! cycle (Benettin et al. 1976). It knows nothing of tangents or saltations, so agreement
//! with them means something.

use super::lyapunov::CYCLES_PER_AVERAGE;
use super::norm::EnergyNorm;
use crate::model::{Model, TrajectoryState};

/// Round-off of a cycle, relative to the state.
pub(super) const ROUND_OFF: f64 = 32.0 * f64::EPSILON;

/// A twin of a trajectory.
#[derive(Debug, Clone)]
pub struct Twin {
    trajectory: TrajectoryState,
    distance: f64,
    sum: f64,
    pending: u32,
    averages: Vec<f64>,
    /// Norm of the largest state met.
    largest: f64,
}

impl Twin {
    /// A twin of `trajectory` in the direction of a tangent. Where neighbours part in proportion
    /// to time directions turn as slowly, and a twin in another one would differ for as long.
    ///
    /// * `separation`: distance, in half gaps.
    pub fn new(
        model: &Model,
        norm: &EnergyNorm,
        trajectory: &TrajectoryState,
        tangent: &[f64],
        separation: f64,
    ) -> Self {
        let scale = separation * norm.unit() / norm.length(tangent);
        let state = trajectory
            .state
            .iter()
            .zip(tangent)
            .map(|(x, d)| x + scale * d)
            .collect();
        Self {
            trajectory: TrajectoryState::new(model, state, trajectory.cycle),
            distance: separation * norm.unit(),
            sum: 0.0,
            pending: 0,
            averages: Vec::new(),
            largest: 0.0,
        }
    }

    /// The twin's own trajectory, to be integrated by a kernel.
    pub fn trajectory(&mut self) -> &mut TrajectoryState {
        &mut self.trajectory
    }

    /// Forgets all growth so far, keeps the direction.
    pub fn restart(&mut self) {
        self.sum = 0.0;
        self.pending = 0;
        self.averages.clear();
    }

    /// To be called after every integrated cycle of both: notes the growth, pulls the twin back.
    pub fn cycle(&mut self, model: &Model, norm: &EnergyNorm, trajectory: &TrajectoryState) {
        self.largest = self.largest.max(norm.length(&trajectory.state));
        let apart = norm.distance(&self.trajectory.state, &trajectory.state);
        // Trajectories that merged to the last bit have contracted by at least round-off.
        let apart = apart.max(f64::EPSILON * self.distance);
        self.sum += (apart / self.distance).ln();
        let scale = self.distance / apart;
        let weights = norm.weights();
        for ((x, y), w) in self
            .trajectory
            .state
            .iter_mut()
            .zip(&trajectory.state)
            .zip(weights)
        {
            *x = if *w > 0.0 { y + scale * (*x - y) } else { *y };
        }
        let state = std::mem::take(&mut self.trajectory.state);
        self.trajectory = TrajectoryState::new(model, state, trajectory.cycle);
        self.pending += 1;
        if self.pending == CYCLES_PER_AVERAGE {
            self.averages.push(self.sum / f64::from(CYCLES_PER_AVERAGE));
            self.sum = 0.0;
            self.pending = 0;
        }
    }

    /// What round-off of the states may do to the exponent \[1/cycle\].
    pub fn round_off(&self) -> f64 {
        ROUND_OFF * self.largest / self.distance
    }

    /// Averages of the exponent over successive stretches of ten cycles.
    pub fn averages(&self) -> &[f64] {
        &self.averages
    }
}
