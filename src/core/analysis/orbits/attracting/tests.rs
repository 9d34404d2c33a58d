//! Known approaches to orbits of maps with two components. A test kernel applies such a map instead of a mesh
//! cycle.

use super::*;
use crate::model::OperatingPoint;
use crate::model::fixtures::{constant_mesh, one_mode};
use crate::propagate::{Observer, Tangents};
use std::f64::consts::FRAC_PI_2;

/// A map of a cycle and its derivative, in energy coordinates and half gaps.
trait Map {
    fn image(&self, y: [f64; 2]) -> [f64; 2];

    fn derivative(&self, y: [f64; 2]) -> [[f64; 2]; 2] {
        let step = 1e-7;
        let column = |j: usize| {
            let moved = |by: f64| {
                let mut y = y;
                y[j] += by;
                self.image(y)
            };
            let [ahead, behind] = [moved(step), moved(-step)];
            [0, 1].map(|i| (ahead[i] - behind[i]) / (2.0 * step))
        };
        let [first, second] = [column(0), column(1)];
        [0, 1].map(|i| [first[i], second[i]])
    }
}

/// A kernel that applies a map in every cycle. It counts an event per cycle, because an orbit without events
/// would be treated as affine.
struct Cycles<M> {
    map: M,
    weights: [f64; 2],
    unit: f64,
}

impl<M: Map> Kernel for Cycles<M> {
    type Workspace = ();

    fn workspace(&self) {}

    fn advance_cycle<O: Observer>(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        (): &mut (),
        _: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        let w = self.weights;
        let y = [0, 1].map(|i| w[i] * trajectory.state[i] / self.unit);
        let slope = self.map.derivative(y);
        for index in 0..tangents.count() {
            let dx = tangents.vector_mut(index);
            let dy = [0, 1].map(|i| w[i] * dx[i]);
            for i in [0, 1] {
                dx[i] = (slope[i][0] * dy[0] + slope[i][1] * dy[1]) / w[i];
            }
        }
        let image = self.map.image(y);
        for i in [0, 1] {
            trajectory.state[i] = image[i] * self.unit / w[i];
        }
        trajectory.cycle += 1;
        counters.cycles += 1;
        counters.events += 1;
        Ok(())
    }
}

/// A model whose states have two components, a norm and a map.
struct TestModel<M> {
    model: Model,
    norm: EnergyNorm,
    kernel: Cycles<M>,
}

impl<M: Map> TestModel<M> {
    fn new(map: M) -> Self {
        let point = OperatingPoint {
            load: 1.0,
            speed: 1.0,
        };
        let model = Model::new(&one_mode(1.0), &constant_mesh(1.0, 1.0), point).unwrap();
        let norm = EnergyNorm::new(&model);
        let kernel = Cycles {
            map,
            weights: [norm.weights()[0], norm.weights()[1]],
            unit: norm.unit(),
        };
        Self {
            model,
            norm,
            kernel,
        }
    }

    fn state(&self, y: [f64; 2]) -> TrajectoryState {
        let x = [0, 1].map(|i| y[i] * self.kernel.unit / self.kernel.weights[i]);
        TrajectoryState::new(&self.model, x.to_vec(), 0)
    }

    fn coordinate(&self, state: &TrajectoryState) -> f64 {
        self.kernel.weights[0] * state.state[0] / self.kernel.unit
    }

    /// How a trajectory approaches the fixed point at the origin.
    fn comes_from(&self, y: [f64; 2]) -> Option<Approach> {
        let (model, kernel, norm) = (&self.model, &self.kernel, &self.norm);
        let origin = self.state([0.0; 2]);
        let orbit = shoot(model, kernel, norm, &origin, 1, &mut ())
            .unwrap()
            .unwrap();
        let mut trajectory = self.state(y);
        let mut counters = Counters::default();
        let found = observe_approach(
            model,
            kernel,
            norm,
            &orbit,
            &mut trajectory,
            &mut (),
            &mut counters,
        );
        assert!(counters.cycles <= (2 + MOST_BETWEEN as u64) * LONGEST_WATCH as u64);
        found.unwrap()
    }

    /// The orbit that attracts a trajectory, sought up to four times as the trajectory advances.
    fn attracting(&self, y: [f64; 2]) -> Option<Attracting> {
        let (model, kernel, norm) = (&self.model, &self.kernel, &self.norm);
        let mut trajectory = self.state(y);
        let mut counters = Counters::default();
        (0..4).find_map(|_| {
            let periods = [1, 1];
            attracting(
                model,
                kernel,
                norm,
                &mut trajectory,
                periods,
                &mut (),
                &mut counters,
            )
            .unwrap()
        })
    }
}

/// Near a period doubling: `u' = −(1 + excess) u + cubic u³` on a curved line, to which the other component decays.
struct Flip {
    excess: f64,
    cubic: f64,
}

impl Map for Flip {
    fn image(&self, [u, w]: [f64; 2]) -> [f64; 2] {
        let next = -(1.0 + self.excess) * u + self.cubic * u * u * u;
        [next, 0.3 * w + 0.5 * u * u]
    }

    fn derivative(&self, [u, _]: [f64; 2]) -> [[f64; 2]; 2] {
        [
            [-(1.0 + self.excess) + 3.0 * self.cubic * u * u, 0.0],
            [u, 0.3],
        ]
    }
}

/// The distance decreases as the inverse square root of time. Far from the orbit, the decrease is thousands
/// of times as fast as near it.
#[test]
fn an_orbit_about_to_double_attracts() {
    let place = TestModel::new(Flip {
        excess: -2.5e-6,
        cubic: 100.0,
    });
    assert_eq!(place.comes_from([1e-6, 0.0]), Some(Approach::AsPredicted));
    for start in [[5e-3, 0.0], [-2e-3, 1e-4]] {
        assert_eq!(place.comes_from(start), Some(Approach::AlongALine));
        let found = place.attracting(start).unwrap();
        assert!(!found.doubled && found.orbit.period == 1);
    }
}

#[test]
fn beside_an_orbit_that_has_just_doubled_the_doubled_one_attracts() {
    for excess in [1e-6, 4e-5, 1e-3, 0.05] {
        let place = TestModel::new(Flip { excess, cubic: 2.0 });
        // Where `u' = −u`.
        let amplitude = (excess / 2.0).sqrt();
        for start in [1e-9, -1e-6, 0.7 * amplitude, -1.2 * amplitude] {
            let found = place.attracting([start, 0.0]);
            let found = found.unwrap_or_else(|| panic!("{excess} {start}"));
            assert_eq!(
                (found.doubled, found.orbit.period),
                (true, 2),
                "{excess} {start}"
            );
            let there = place.coordinate(&found.orbit.start).abs();
            assert!(
                (there / amplitude - 1.0).abs() < 1e-6,
                "{excess} {start}: {there}"
            );
        }
    }
}

/// A subcritical doubling leaves no orbit near the unstable one. Before it, an unstable orbit of twice the period
/// surrounds the stable one.
#[test]
fn a_doubling_without_a_stable_orbit_gives_none() {
    let past = TestModel::new(Flip {
        excess: 4e-5,
        cubic: -2.0,
    });
    assert!(past.attracting([1e-9, 0.0]).is_none());
    let before = TestModel::new(Flip {
        excess: -4e-5,
        cubic: -2.0,
    });
    let amplitude = (4e-5f64 / 2.0).sqrt();
    assert!(before.comes_from([1.01 * amplitude, 0.0]).is_none());
    assert_eq!(
        before.comes_from([0.1 * amplitude, 0.0]),
        Some(Approach::AsPredicted)
    );
}

/// Two fixed points on a line attract; the one between separates their basins.
struct TwoOnALine;

impl Map for TwoOnALine {
    fn image(&self, [u, w]: [f64; 2]) -> [f64; 2] {
        [u - 1e-5 * u * (1.0 - u / 0.02) * (1.0 - u / 0.04), 0.3 * w]
    }
}

#[test]
fn a_neighbour_on_the_line_keeps_its_states() {
    let place = TestModel::new(TwoOnALine);
    for start in [0.04, 0.035, 0.0201, 0.02] {
        assert_eq!(place.comes_from([start, 0.0]), None, "{start}");
    }
    assert_eq!(place.comes_from([0.01, 1e-3]), Some(Approach::AlongALine));
    assert_eq!(
        place.comes_from([-0.0005, 1e-3]),
        Some(Approach::AsPredicted)
    );
}

/// A stable orbit inside an unstable torus, which lies inside a stable torus. All are flat in the energy norm.
struct Tori {
    angle: f64,
    flat: f64,
}

const UNSTABLE: f64 = 0.02;
const STABLE: f64 = 0.04;

impl Map for Tori {
    fn image(&self, [p, q]: [f64; 2]) -> [f64; 2] {
        let (x, y) = (p, q / self.flat);
        let square = x * x + y * y;
        let rate = 1e-5 * (1.0 - square / UNSTABLE.powi(2)) * (1.0 - square / STABLE.powi(2));
        let (sin, cos) = self.angle.sin_cos();
        let size = 1.0 - rate;
        [
            size * (cos * x - sin * y),
            self.flat * size * (sin * x + cos * y),
        ]
    }
}

#[test]
fn a_torus_around_an_orbit_is_not_taken_for_its_approach() {
    for (angle, flat) in [
        (0.7, 1.0),
        (0.7, 0.02),
        (FRAC_PI_2 + 3.67e-6, 0.02),
        (2.0 + 1e-4, 0.3),
    ] {
        let place = TestModel::new(Tori { angle, flat });
        for turn in 0..60 {
            let (sin, cos) = (0.1047 * f64::from(turn)).sin_cos();
            for radius in [1.1 * UNSTABLE, STABLE, 1.1 * STABLE] {
                let start = [radius * cos, flat * radius * sin];
                assert_eq!(
                    place.comes_from(start),
                    None,
                    "{angle} {flat} {turn} {radius}"
                );
            }
            let inside = [0.1 * UNSTABLE * cos, flat * 0.1 * UNSTABLE * sin];
            let seen = place.comes_from(inside);
            // If an observation ends on the long axis of the flat torus, a later one decides.
            assert!(
                flat < 1.0 || seen == Some(Approach::AsPredicted),
                "{angle} {flat} {turn}"
            );
            assert_ne!(seen, Some(Approach::AlongALine));
        }
    }
}

/// Offsets grow a hundredfold before they decay.
struct Shear {
    slow: f64,
}

impl Map for Shear {
    fn image(&self, [u, w]: [f64; 2]) -> [f64; 2] {
        [self.slow * u + 50.0 * w, 0.5 * w]
    }
}

#[test]
fn growth_before_decay_puts_off_the_verdict() {
    let quick = TestModel::new(Shear { slow: 0.9 });
    assert_eq!(quick.comes_from([0.0, 1e-3]), None);
    assert_eq!(quick.comes_from([0.1, 0.0]), Some(Approach::AsPredicted));
    // The growth has decayed before the second observation.
    let slow = TestModel::new(Shear { slow: 1.0 - 1e-5 });
    assert_eq!(slow.comes_from([0.0, 1e-3]), Some(Approach::AsPredicted));
}
