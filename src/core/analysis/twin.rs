//! Do two full trajectories give the same exponent as a tangent?
//!
//! A twin starts a small distance away and is pulled back to that distance after every cycle (Benettin
//! et al. 1976). It uses neither tangents nor saltations, so that agreement with them is meaningful.

use super::averages::CycleAverages;
use super::norm::EnergyNorm;
use crate::model::{Model, TrajectoryState};
use crate::numerics::statistics::{mean, standard_error};

/// Round-off of a cycle, relative to the state.
pub(super) const ROUND_OFF: f64 = 32.0 * f64::EPSILON;

/// Default distance of a twin, in half gaps: far above round-off, far below the gap.
pub const SEPARATION: f64 = 1e-7;

/// Allowance for the effect of a finite distance of [`SEPARATION`] on a twin's exponent \[1/cycle\]. Near grazing
/// contacts, the effect is up to 2.9e-4. It is proportional to the distance: 2.5e-3 at 1e-6, 3e-5 at 1e-8. At 3e-9,
/// round-off changes the exponent of integrable motion by 2.4e-3. The allowance is half the exponent that counts
/// as zero, so that no verdict depends on it.
const FINITE_DISTANCE: f64 = 5e-4;

/// A twin of a trajectory.
#[derive(Debug, Clone)]
pub struct Twin {
    trajectory: TrajectoryState,
    /// Distance to which the twin is pulled back, in half gaps.
    separation: f64,
    /// The same distance in the norm.
    distance: f64,
    /// Averages of the tangent's growth minus the twin's.
    differences: CycleAverages,
    /// Norm of the largest state.
    largest: f64,
}

impl Twin {
    /// A twin of `trajectory`, displaced in the direction of a tangent. If neighbours separate in proportion
    /// to time, directions turn slowly too, and the exponent of a twin in another direction would differ for
    /// long.
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
            separation,
            distance: separation * norm.unit(),
            differences: CycleAverages::default(),
            largest: 0.0,
        }
    }

    /// The twin's trajectory, to be integrated by a kernel.
    pub fn trajectory(&mut self) -> &mut TrajectoryState {
        &mut self.trajectory
    }

    /// Forgets all growth and keeps the direction.
    pub fn restart(&mut self) {
        self.differences = CycleAverages::default();
    }

    /// Records the growth and pulls the twin back. Must be called after every integrated cycle of both.
    ///
    /// * `tangent`: growth of the tangent in this cycle.
    pub fn cycle(
        &mut self,
        model: &Model,
        norm: &EnergyNorm,
        trajectory: &TrajectoryState,
        tangent: f64,
    ) {
        self.largest = self.largest.max(norm.length(&trajectory.state));
        let distance = norm.distance(&self.trajectory.state, &trajectory.state);
        // Trajectories that are equal to the last bit have contracted by at least the machine precision.
        let distance = distance.max(f64::EPSILON * self.distance);
        let growth = (distance / self.distance).ln();
        self.differences.push(tangent - growth);
        let scale = self.distance / distance;
        let mut state = std::mem::take(&mut self.trajectory.state);
        for (x, y) in state.iter_mut().zip(&trajectory.state) {
            *x -= y;
        }
        // The distance ignores displacements without effect, so they are removed from the difference.
        norm.project(&mut state);
        for (x, y) in state.iter_mut().zip(&trajectory.state) {
            *x = y + scale * *x;
        }
        self.trajectory = TrajectoryState::new(model, state, trajectory.cycle);
    }

    /// Whether the exponents of twin and tangent agree: the mean difference of their growth is zero within
    /// three standard errors. `None` if there are too few averages for an error.
    ///
    /// Differences below [`FINITE_DISTANCE`], increased for larger separations, always count as agreement. So
    /// do differences from round-off, which do not average out if the state is large.
    pub fn agrees(&self) -> Option<bool> {
        let finite = FINITE_DISTANCE * (self.separation / SEPARATION).max(1.0);
        let differences = self.differences.values();
        let error = standard_error(differences);
        let allowed = 3.0 * error + finite + self.round_off();
        error
            .is_finite()
            .then(|| mean(differences).abs() <= allowed)
    }

    /// Effect of round-off of the states on the exponent \[1/cycle\].
    fn round_off(&self) -> f64 {
        ROUND_OFF * self.largest / self.distance
    }

    /// Exponent of this twin minus the tangent's over the same cycles \[1/cycle\], and its standard error.
    pub fn excess(&self) -> [f64; 2] {
        let differences = self.differences.values();
        [-mean(differences), standard_error(differences)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::norm::tests::dragged;

    /// Under drag the angle of the whole drive has no effect. A twin that is displaced in this angle and in
    /// other components is pulled back to the distance along the components with an effect.
    #[test]
    fn a_twin_is_pulled_back_along_what_is_felt() {
        let model = dragged(0.05);
        let norm = EnergyNorm::new(&model);
        let trajectory = TrajectoryState::new(&model, vec![0.3; 8], 0);
        let mut along = vec![0.4, -0.2, 0.3, 0.1, -0.2, 0.5, 0.3, -0.6];
        norm.project(&mut along);
        let mut twin = Twin::new(&model, &norm, &trajectory, &along, 1e-3);
        let [unfelt] = &model.unrestrained_displacements()[..] else {
            panic!("one displacement is not felt");
        };
        for (x, n) in twin.trajectory.state.iter_mut().zip(unfelt) {
            *x += 1e-3 * n;
        }
        twin.cycle(&model, &norm, &trajectory, 0.0);
        let known = 1e-3 * norm.unit() / norm.length(&along);
        let states = twin.trajectory.state.iter().zip(&trajectory.state);
        for ((x, y), a) in states.zip(&along) {
            assert!((x - y - known * a).abs() < 1e-12 * norm.unit(), "{x} {y}");
        }
    }
}
