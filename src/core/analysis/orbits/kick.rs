//! How does the distance of a trajectory from a periodic orbit grow after a kick?
//!
//! The kick has the direction in which the monodromy matrix M grows most in one return, its leading right singular
//! vector u. After n returns, the linear prediction is `|Mⁿ u|` times the kick. Its growth is the largest singular
//! value in the first return and tends to the leading multiplier later.

use super::shooting::PeriodicOrbit;
use crate::analysis::norm::EnergyNorm;
use crate::model::{Model, TrajectoryState};
use crate::numerics::linalg::{norm, product};
use crate::propagate::{Counters, Kernel, Stop};
use faer::Mat;
use serde::{Deserialize, Serialize};

/// Size of the kick, in half gaps.
pub const KICK: f64 = 1e-5;

/// Largest number of power iterations for the direction of strongest growth. The iteration ends when the direction
/// converges.
const MOST_ITERATIONS: usize = 200;

/// Change of the direction in an iteration below which the direction has converged.
const CONVERGED: f64 = 1e-10;

/// Distances from an orbit after a kick of [`KICK`].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Kick {
    /// After 0, 1, 2, … returns of the full system, in half gaps. The list ends before a return that diverges or has
    /// too many events.
    pub distance: Vec<f64>,
    /// The same distances as predicted by the monodromy matrix.
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
    let mut kicked = KickedTrajectory::new(model, norm, orbit);
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

/// A trajectory kicked off an orbit, and the kick's image under the monodromy matrix.
pub(super) struct KickedTrajectory<'a> {
    norm: &'a EnergyNorm,
    orbit: &'a PeriodicOrbit,
    trajectory: TrajectoryState,
    /// The kick in energy coordinates, initially of unit norm.
    linear: Mat<f64>,
}

impl<'a> KickedTrajectory<'a> {
    /// A trajectory at the start of the orbit, kicked in the direction of strongest growth.
    pub(super) fn new(model: &Model, norm: &'a EnergyNorm, orbit: &'a PeriodicOrbit) -> Self {
        let linear = strongest(&orbit.monodromy);
        let mut state = orbit.start.state.clone();
        norm.displace(&mut state, KICK * norm.unit(), linear.col_as_slice(0));
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

/// The unit vector that a matrix stretches most, by power iteration on `Mᵀ M`.
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
        if turned <= CONVERGED {
            break;
        }
    }
    direction
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The squares of the singular values of a shear are the roots of `x² − 3x + 1`.
    #[test]
    fn the_direction_of_strongest_growth_is_that_of_the_largest_singular_value() {
        let shear = Mat::from_fn(2, 2, |i, j| f64::from(u8::from(j >= i)));
        let direction = strongest(&shear);
        let growth = norm(&product(shear.as_ref(), direction.as_ref()));
        let expected = (0.5 * (3.0 + 5.0_f64.sqrt())).sqrt();
        assert!((norm(&direction) - 1.0).abs() < 1e-14);
        assert!((growth - expected).abs() < 1e-14, "{growth} {expected}");
    }

    /// A zero matrix stretches nothing, so any unit vector is right.
    #[test]
    fn a_matrix_of_zeros_has_a_direction_of_unit_norm() {
        for size in [1, 2, 5] {
            let direction = strongest(&Mat::zeros(size, size));
            assert!((norm(&direction) - 1.0).abs() < 1e-14);
        }
    }
}
