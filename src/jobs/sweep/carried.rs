//! The state that a point takes from the previous point of a chain.
//!
//! If a point ends on a periodic orbit, its state lies on that orbit to round-off. At the next point the
//! orbit may be unstable, but a trajectory that starts on it leaves it only when round-off has grown. The
//! start is therefore displaced, in a direction that depends only on seed and point. The start has the same bits
//! if a run is split, interrupted or traced.

use crate::analysis::{EnergyNorm, displaced};
use crate::model::{Model, TrajectoryState};
use crate::numerics::random::PointSeed;
use crate::store::ChainEnd;

/// Number of the random stream that draws the direction in which the start of a point is displaced; differs
/// from the streams of probes, horizons and covariant vectors.
const STREAM: u64 = 1 << 36;

/// The end of the previous point, and the distance of the next start from it.
#[derive(Debug, Clone, Copy)]
pub(super) struct CarriedState<'a> {
    pub end: &'a ChainEnd,
    /// Distance of the start from this end, in half gaps.
    pub displacement: f64,
}

impl CarriedState<'_> {
    /// The start of a point. Components of the state that have no effect on the motion are not displaced.
    pub fn start(self, model: &Model, seed: PointSeed) -> TrajectoryState {
        let state = model.basis.state_of_turned(&self.end.state);
        let end = TrajectoryState::new(model, state, self.end.cycle);
        if self.displacement > 0.0 {
            let mut stream = seed.stream(STREAM);
            let norm = EnergyNorm::new(model);
            return displaced(model, &norm, &end, self.displacement, &mut stream);
        }
        end
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Drive, OperatingPoint};
    use crate::structure::{Coupling, ModalStructure};

    /// A drive with one neutral rotation.
    fn model() -> Model {
        let mesh = [0.8, -0.6, 0.5, 0.1];
        let structure = ModalStructure::of_modes(&[0.0, 0.0, 2.0, 3.0], 0.1, &mesh, &mesh);
        let point = OperatingPoint {
            load: 1.0,
            speed: 1.0,
        };
        Model::new(&structure, &Drive::constant(1.0, 1.0), point).unwrap()
    }

    fn start(model: &Model, displacement: f64, point_id: u64) -> TrajectoryState {
        let end = ChainEnd {
            state: (0..2 * model.modes()).map(|i| i as f64).collect(),
            cycle: 7,
        };
        let carried = CarriedState {
            end: &end,
            displacement,
        };
        carried.start(model, PointSeed { seed: 1, point_id })
    }

    /// The speed changes the coordinates of coupled modes, but not the modal displacements and velocities of the state.
    #[test]
    fn a_state_keeps_its_modes_where_they_are_coupled() {
        let at = |speed: f64| {
            let structure = ModalStructure {
                coupling: Some(Coupling {
                    damping: vec![0.1, 0.02, 0.02, 0.2],
                    gyroscopic: vec![0.0, 0.4, -0.4, 0.0],
                    stiffness: vec![0.0; 4],
                }),
                ..ModalStructure::of_modes(&[2.0, 3.0], 0.1, &[0.8, 0.5], &[0.8, 0.5])
            };
            let point = OperatingPoint { load: 1.0, speed };
            Model::new(&structure, &Drive::constant(1.0, 1.0), point).unwrap()
        };
        let modes = [0.3, -0.7, 1.1, 0.4];
        let end = ChainEnd {
            state: modes.to_vec(),
            cycle: 7,
        };
        for speed in [1.0, 2.0] {
            let model = at(speed);
            let carried = CarriedState {
                end: &end,
                displacement: 0.0,
            };
            let seed = PointSeed {
                seed: 1,
                point_id: 0,
            };
            let start = carried.start(&model, seed);
            let found = model.basis.turned_modes(&start.state);
            assert!(
                found.iter().zip(modes).all(|(a, b)| (a - b).abs() < 1e-12),
                "{found:?}"
            );
        }
    }

    #[test]
    fn starts_are_as_far_away_as_asked_for_and_depend_on_the_point_alone() {
        let model = model();
        let norm = EnergyNorm::new(&model);
        let chain_end = start(&model, 0.0, 3);
        assert!(
            chain_end
                .state
                .iter()
                .enumerate()
                .all(|(i, x)| *x == i as f64)
        );
        for displacement in [1e-6, 0.3] {
            let here = start(&model, displacement, 3);
            let distance = norm.distance(&here.state, &chain_end.state) / norm.unit();
            assert!((distance / displacement - 1.0).abs() < 1e-8, "{distance}");
            for (i, weight) in norm.weights().iter().enumerate() {
                assert_eq!(here.state[i] == chain_end.state[i], *weight == 0.0, "{i}");
            }
            assert_eq!(here.cycle, 7);
            assert_eq!(here.state, start(&model, displacement, 3).state);
            assert_ne!(here.state, start(&model, displacement, 4).state);
        }
    }
}
