//! Does the small-step kernel have its claimed properties? Its order compared with the reference integrator, its
//! tangents with finite differences.

#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::mean_equilibrium;
use common::{drives, relative_difference};
use gearatlas::model::{Model, Release, TrajectoryState};
use gearatlas::propagate::{Counters, Event, Kernel, Observer, Stepping, Tangents};
use gearatlas::reference::Reference;

/// Advances whole cycles without tangents.
fn advance(model: &Model, start: &TrajectoryState, steps: u32, cycles: u64) -> TrajectoryState {
    advance_with(model, start, steps, cycles, &mut Tangents::none(), &mut ())
}

fn advance_with<O: Observer>(
    model: &Model,
    start: &TrajectoryState,
    steps: u32,
    cycles: u64,
    tangents: &mut Tangents,
    observer: &mut O,
) -> TrajectoryState {
    let kernel = Stepping::new(model, steps, 1000);
    let mut work = kernel.workspace();
    let mut trajectory = start.clone();
    let mut counters = Counters::default();
    for _ in 0..cycles {
        kernel
            .advance_cycle(
                &mut trajectory,
                tangents,
                &mut work,
                observer,
                &mut counters,
            )
            .unwrap();
    }
    assert_eq!(counters.cycles, cycles);
    trajectory
}

/// The case at full load, with its transmission error reduced until contact never opens.
fn constant_contact(mut case: common::Case) -> Model {
    for harmonic in &mut case.1.transmission_error {
        harmonic.amplitude *= 0.01;
    }
    for ripple in &mut case.1.torque_ripple {
        ripple.amplitude *= 0.1;
    }
    case.2.load = 1.0;
    common::model(&case)
}

/// Slope of the error against the step, by least squares on logarithms.
fn observed_order(ladder: &[(u32, f64)]) -> f64 {
    let n = ladder.len() as f64;
    let points = ladder
        .iter()
        .map(|&(steps, error)| (-f64::from(steps).ln(), error.ln()));
    let (x, y) = points
        .clone()
        .fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
    let (top, bottom) = points.fold((0.0, 0.0), |(a, b), (u, v)| {
        (a + (u - x) * (v - y), b + (u - x) * (u - x))
    });
    top / bottom
}

/// A single error is random: it depends on where the crossings fall between two kicks. The geometric mean over several
/// cycles and neighbouring step counts shows the order. `atlas verify` does the same with release by deflection.
#[test]
fn order_is_one_through_rattle_with_release_by_force() {
    const CYCLES: usize = 8;
    const NEIGHBOURS: u32 = 10;
    for (name, mut case) in drives() {
        case.1.release = Release::Force;
        let model = common::model(&case);
        let reference = Reference::new(&model);
        let mut start = advance(&model, &mean_equilibrium(&model), 2000, 40);
        let mut ladder = [480, 960, 1920, 3840, 7680, 15360].map(|steps| (steps, 0.0));
        let mut errors = 0.0;
        for _ in 0..CYCLES {
            let exact = reference.advance(&start, 1).unwrap();
            if exact.crossings.is_empty() {
                // Without a crossing the order is higher, and in free flight there is no error.
                start = exact.end;
                continue;
            }
            errors += f64::from(NEIGHBOURS);
            for (steps, log) in &mut ladder {
                for neighbour in 0..NEIGHBOURS {
                    let steps = *steps + *steps * neighbour / 48;
                    let end = advance(&model, &start, steps, 1);
                    *log += relative_difference(&end.state, &exact.end.state).ln();
                }
            }
            start = exact.end;
        }
        assert!(errors >= 40.0, "{name} crosses in too few cycles");
        let ladder = ladder.map(|(steps, log)| (steps, (log / errors).exp()));
        let order = observed_order(&ladder);
        assert!(
            (0.9..1.2).contains(&order),
            "{name}: {order} from {ladder:?}"
        );
        assert!(ladder[5].1 < 1e-4, "{name}: {ladder:?}");
    }
}

#[derive(Default)]
struct Events(Vec<Event>);

impl Observer for Events {
    const WINDOWS: bool = false;

    fn event(&mut self, event: &Event) {
        self.0.push(*event);
    }
}

#[test]
fn events_are_those_of_the_reference() {
    for (name, case) in drives() {
        let model = common::model(&case);
        let start = advance(&model, &mean_equilibrium(&model), 2000, 40);
        let exact = Reference::new(&model).advance(&start, 2).unwrap();
        let mut seen = Events::default();
        advance_with(&model, &start, 20_000, 2, &mut Tangents::none(), &mut seen);
        assert_eq!(seen.0.len(), exact.crossings.len(), "{name}");
        for (event, crossing) in seen.0.iter().zip(&exact.crossings) {
            assert_eq!(event.cycle, crossing.cycle, "{name}");
            assert_eq!((event.from, event.to), (crossing.from, crossing.to));
            let late = (event.time - crossing.time).abs() / model.period();
            assert!(late < 1e-4, "{name}: {late:e}");
            assert!((event.rate - crossing.rate).abs() < 1e-2 * crossing.rate.abs());
        }
    }
}

/// Columns of the identity, scaled so that displacements and velocities are comparable.
fn columns(model: &Model, scale: [f64; 2]) -> Tangents {
    let n = model.modes();
    let mut tangents = Tangents::zeros(n, 2 * n);
    for i in 0..2 * n {
        tangents.vector_mut(i)[i] = scale[i / n];
    }
    tangents
}

/// In constant contact the map is affine, so a difference of any size is exact.
#[test]
fn tangents_are_the_differences_in_constant_contact() {
    for case in [
        common::two_modes(),
        common::six_modes(),
        common::forty_modes(),
    ] {
        let model = constant_contact(case);
        let n = model.modes();
        let start = mean_equilibrium(&model);
        let scale = [1e-8, 1e-4];
        let mut tangents = columns(&model, scale);
        let base = advance_with(&model, &start, 600, 2, &mut tangents, &mut ());
        for i in 0..2 * n {
            let mut moved = start.clone();
            moved.state[i] += scale[i / n];
            let end = advance(&model, &moved, 600, 2);
            // Round-off of displacements of 1e-4 and velocities of 1e-2 limits the accuracy of a difference.
            let error = (0..2 * n)
                .map(|j| {
                    let difference = end.state[j] - base.state[j];
                    (difference - tangents.vector(i)[j]).abs() / scale[j / n]
                })
                .fold(0.0, f64::max);
            assert!(error < 1e-9, "column {i}: {error:e}");
        }
    }
}

/// Tangents through impacts are compared with central differences of the reference. Without the saltation they would
/// converge to another limit.
#[test]
fn tangents_converge_to_those_of_the_flow_through_impacts() {
    for (name, case) in [
        ("one degree", common::one_degree()),
        ("six modes", common::six_modes()),
        ("forty modes", common::forty_modes()),
    ] {
        let model = common::model(&case);
        let n = model.modes();
        let start = advance(&model, &mean_equilibrium(&model), 2000, 40);
        let reference = Reference::new(&model);
        let crossings = reference.advance(&start, 1).unwrap().crossings.len();
        assert!(crossings >= 1, "{name} has no impact");
        let scale = [1e-10, 1e-6];
        let errors: Vec<f64> = [2000, 8000, 32000]
            .iter()
            .map(|&steps| {
                let mut tangents = columns(&model, scale);
                advance_with(&model, &start, steps, 1, &mut tangents, &mut ());
                let mut worst = 0.0f64;
                for i in (0..2 * n).step_by(n.div_ceil(2)) {
                    let end = |side: f64| {
                        let mut moved = start.clone();
                        moved.state[i] += side * scale[i / n];
                        reference.advance(&moved, 1).unwrap().end.state
                    };
                    let difference: Vec<_> = end(1.0)
                        .iter()
                        .zip(end(-1.0))
                        .map(|(a, b)| 0.5 * (a - b))
                        .collect();
                    worst = worst.max(relative_difference(tangents.vector(i), &difference));
                }
                worst
            })
            .collect();
        assert!(errors[2] < 1e-3, "{name}: {errors:?}");
        assert!(errors[2] < 0.2 * errors[0], "{name}: {errors:?}");
    }
}
