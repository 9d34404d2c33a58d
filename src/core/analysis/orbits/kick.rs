//! How does a kick grow over the returns to a periodic orbit?
//!
//! The kick points where the monodromy matrix M grows most in one return, along its leading right
//! singular vector u. After n returns the linear prediction is `|Mⁿ u|` times the kick: near a
//! return its largest singular value, later its leading multiplier.

use super::shooting::PeriodicOrbit;
use crate::analysis::norm::EnergyNorm;
use crate::model::{Model, TrajectoryState};
use crate::numerics::linalg::{norm, product};
use crate::propagate::{Counters, Kernel, Stop};
use faer::Mat;
use serde::{Deserialize, Serialize};

/// Size of the kick that an orbit is tried with, in half gaps.
pub const KICK: f64 = 1e-5;

/// Power iterations for the direction of strongest growth; they stop when it stands still.
const MOST_ITERATIONS: usize = 200;

/// Turn of the direction, per iteration, at which it stands still.
const STILL: f64 = 1e-10;

/// Distances from an orbit after a kick of [`KICK`].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Kick {
    /// After 0, 1, 2, … returns, integrated in full, in half gaps; cut short before a return that
    /// diverges or storms.
    pub distance: Vec<f64>,
    /// The same as the monodromy matrix predicts it.
    pub linear: Vec<f64>,
}

/// Follows a kick over some returns.
pub fn follow<K: Kernel>(
    model: &Model,
    kernel: &K,
    norm: &EnergyNorm,
    orbit: &PeriodicOrbit,
    returns: u32,
    workspace: &mut K::Workspace,
) -> Kick {
    let mut kicked = Kicked::new(model, norm, orbit);
    let mut kick = Kick {
        distance: vec![KICK],
        linear: vec![KICK],
    };
    for _ in 0..returns {
        let Ok([distance, linear]) = kicked.after_return(kernel, workspace) else {
            break;
        };
        kick.distance.push(distance);
        kick.linear.push(linear);
    }
    kick
}

/// A trajectory that was kicked off an orbit, and what the monodromy matrix makes of the kick.
pub(super) struct Kicked<'a> {
    norm: &'a EnergyNorm,
    orbit: &'a PeriodicOrbit,
    trajectory: TrajectoryState,
    /// The kick in energy coordinates, of unit norm at first.
    linear: Mat<f64>,
}

impl<'a> Kicked<'a> {
    /// At the start of the orbit, kicked in the direction of strongest growth.
    pub(super) fn new(model: &Model, norm: &'a EnergyNorm, orbit: &'a PeriodicOrbit) -> Self {
        let linear = strongest(&orbit.monodromy);
        let mut state = orbit.start.state.clone();
        for (row, &i) in norm.felt().iter().enumerate() {
            state[i] += KICK * norm.unit() * linear[(row, 0)] / norm.weights()[i];
        }
        Self {
            norm,
            orbit,
            trajectory: TrajectoryState::new(model, state, orbit.start.cycle),
            linear,
        }
    }

    /// Distances from the orbit after one more return, in full and linearised, in half gaps.
    ///
    /// # Errors
    /// [`Stop`] as for any integration.
    pub(super) fn after_return<K: Kernel>(
        &mut self,
        kernel: &K,
        workspace: &mut K::Workspace,
    ) -> Result<[f64; 2], Stop> {
        kernel.advance(
            u64::from(self.orbit.period),
            &mut self.trajectory,
            workspace,
            &mut (),
            &mut Counters::default(),
        )?;
        self.linear = product(self.orbit.monodromy.as_ref(), self.linear.as_ref());
        let start = &self.orbit.start.state;
        let distance = self.norm.distance(&self.trajectory.state, start) / self.norm.unit();
        Ok([distance, KICK * norm(&self.linear)])
    }
}

/// The direction of unit norm that a matrix stretches most: power iteration on `Mᵀ M`.
fn strongest(matrix: &Mat<f64>) -> Mat<f64> {
    let n = matrix.nrows();
    let mut direction = Mat::from_fn(n, 1, |i, _| 1.0 + 0.1 * (i as f64).sin());
    direction = &direction * (1.0 / norm(&direction));
    for _ in 0..MOST_ITERATIONS {
        let image = product(matrix.as_ref(), direction.as_ref());
        let back = product(matrix.transpose(), image.as_ref());
        let length = norm(&back);
        if length == 0.0 {
            break;
        }
        let next = &back * (1.0 / length);
        let turned = norm(&(&next - &direction));
        direction = next;
        if turned <= STILL {
            break;
        }
    }
    direction
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A shear stretches by the larger root of `x² − 3x + 1`, the square of its singular values.
    #[test]
    fn the_direction_of_strongest_growth_is_that_of_the_largest_singular_value() {
        let shear = Mat::from_fn(2, 2, |i, j| f64::from(u8::from(j >= i)));
        let direction = strongest(&shear);
        let growth = norm(&product(shear.as_ref(), direction.as_ref()));
        let expected = (0.5 * (3.0 + 5.0_f64.sqrt())).sqrt();
        assert!((norm(&direction) - 1.0).abs() < 1e-14);
        assert!((growth - expected).abs() < 1e-14, "{growth} {expected}");
    }

    /// A matrix that forgets everything stretches nothing most: any direction does, of unit norm.
    #[test]
    fn a_matrix_of_zeros_has_a_direction_of_unit_norm() {
        for size in [1, 2, 5] {
            let direction = strongest(&Mat::zeros(size, size));
            assert!((norm(&direction) - 1.0).abs() < 1e-14);
        }
    }
}
