//! Stiffness that changes at its breakpoints, not at the borders of a grid of segments.

#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::{Events, advance, advance_with, settled, volterra};
use common::{Case, drives, relative_difference, state_difference};
use gearatlas::model::{Division, Drive, Model};
use gearatlas::propagate::{Stepping, Volterra};
use gearatlas::reference::Reference;

const DOUBLE_PAIR: f64 = 4.444e8;
const SINGLE_PAIR: f64 = 3.333e8;

/// A mesh with one step down, at a phase of the cycle.
fn step_at(phase: f64, drive: Drive) -> Drive {
    Drive {
        mesh: Division::levels(&[DOUBLE_PAIR, SINGLE_PAIR], &[phase]),
        ..drive
    }
}

/// The mesh with a step on equal segments; the segment that contains the step has the average over its width.
fn on_segments(segments: u32, phase: f64, drive: Drive) -> Drive {
    let place = phase * f64::from(segments);
    let level = |i| {
        let double = (place - f64::from(i)).clamp(0.0, 1.0);
        double * DOUBLE_PAIR + (1.0 - double) * SINGLE_PAIR
    };
    let levels: Vec<_> = (0..segments).map(level).collect();
    Drive {
        mesh: Division::levels(&levels, &[]),
        ..drive
    }
}

fn model((structure, drive, point): &Case, change: impl Fn(Drive) -> Drive) -> Model {
    Model::new(structure, &change(drive.clone()), *point).unwrap()
}

/// The largest one-cycle difference from the reference over some cycles of rattle, and the number of events.
fn against_reference(model: &Model, kernel: &Volterra<'_>, cycles: u64) -> (f64, usize) {
    let reference = Reference::new(model);
    let mut start = settled(model, 40);
    let (mut worst, mut events) = (0.0f64, 0);
    for _ in 0..cycles {
        let exact = reference.advance(&start, 1).unwrap();
        let mut seen = Events::default();
        let (end, _) = advance_with(kernel, &start, 1, &mut seen);
        let kinds = |a: &gearatlas::propagate::Event, b: &gearatlas::reference::Crossing| {
            (a.from, a.to) == (b.from, b.to)
        };
        assert_eq!(seen.0.len(), exact.crossings.len());
        assert!(
            seen.0
                .iter()
                .zip(&exact.crossings)
                .all(|(a, b)| kinds(a, b))
        );
        worst = worst.max(state_difference(model, &end.state, &exact.end.state));
        events += seen.0.len();
        start = end;
    }
    (worst, events)
}

/// Steps on a grid, off every grid, near either end of the cycle, and so close to it that a window is a millionth of
/// the cycle long.
#[test]
fn a_step_anywhere_is_that_of_the_reference() {
    for (name, case) in drives() {
        for phase in [0.6, 0.63, 1.0 / 2f64.sqrt(), 0.02, 0.999, 1e-6] {
            let model = model(&case, |drive| step_at(phase, drive));
            let (worst, events) = against_reference(&model, &volterra(&model), 4);
            println!("{name}, step at {phase}: {worst:.1e}, {events} events");
            assert!(worst < 1e-13, "{name}, step at {phase}: {worst:e}");
            assert!(events > 0, "{name}, step at {phase} does not rattle");
        }
    }
}

/// Several steps at once, with windows of as many lengths and with more lengths than tables.
#[test]
fn many_uneven_segments_are_those_of_the_reference() {
    let (structure, drive, point) = common::six_modes();
    for count in [3, 9u32] {
        let transitions: Vec<f64> = (1..count)
            .map(|i| (f64::from(i) / f64::from(count)).powf(1.3))
            .collect();
        let stiffness: Vec<_> = (0..count).map(|i| 3e8 + 2e7 * f64::from(i)).collect();
        let drive = Drive {
            mesh: Division::levels(&stiffness, &transitions),
            ..drive.clone()
        };
        let model = Model::new(&structure, &drive, point).unwrap();
        assert_eq!(model.first_cycle().segments.len(), count as usize);
        let (worst, events) = against_reference(&model, &volterra(&model), 8);
        println!("{count} segments: {worst:.1e}, {events} events");
        assert!(worst < 1e-13, "{count} segments: {worst:e}");
        assert!(events >= 8);
    }
}

/// At contact ratio 1.6 the step is on the border of a sixtieth.
#[test]
fn sixty_segments_are_exact_where_the_step_lies_on_a_border() {
    for (name, case) in drives() {
        let exact = model(&case, |drive| step_at(0.6, drive));
        let sixty = model(&case, |drive| on_segments(60, 0.6, drive));
        let mut start = settled(&exact, 40);
        for _ in 0..8 {
            let end = advance(&volterra(&exact), &start, 1);
            let other = advance(&volterra(&sixty), &start, 1);
            let difference = relative_difference(&other.state, &end.state);
            assert!(difference < 1e-12, "{name}: {difference:e}");
            start = end;
        }
    }
}

/// The largest difference over a cycle of constant contact between the exact step and the step on 60, 600 and 6000
/// segments.
fn errors_of_segments(phase: f64) -> [f64; 3] {
    let mut case = common::forty_modes();
    case.1.transmission_error.clear();
    case.2.load = 1.0;
    let exact = model(&case, |drive| step_at(phase, drive));
    let start = settled(&exact, 3);
    let end = advance(&volterra(&exact), &start, 1);
    [60, 600, 6000].map(|segments| {
        let rounded = model(&case, |drive| on_segments(segments, phase, drive));
        let kernel = volterra(&rounded);
        // The kernel has windows for the three different segments, not for sixty and more.
        assert!(kernel.windows_per_cycle() < 20);
        relative_difference(&advance(&kernel, &start, 1).state, &end.state)
    })
}

/// A segment that contains the step has only the mean stiffness, so that its error decreases with the square of its
/// width while the contact lasts.
#[test]
fn segments_converge_to_the_step() {
    // The segments with the step are 0.43, 0.26 and 0.64 full; their errors are proportional to s (1 − s).
    let share = [0.43, 0.26, 0.64].map(|s| s * (1.0 - s));
    let errors = errors_of_segments(1.0 / 2f64.sqrt());
    println!("{errors:?}");
    for i in 1..3 {
        let order = (errors[i - 1] / errors[i] * share[i] / share[i - 1]).log10();
        assert!((1.9..2.1).contains(&order), "{errors:?}");
    }
}

/// At contact ratio 1.63 the step is a border of six hundred segments, but not of sixty.
#[test]
fn segments_with_the_step_on_a_border_are_exact() {
    let [coarse, fine, finer] = errors_of_segments(0.63);
    println!("{coarse:e} {fine:e} {finer:e}");
    assert!(coarse > 1e-6, "{coarse:e}");
    assert!(fine < 1e-12 && finer < 1e-12, "{fine:e} {finer:e}");
}

/// Small steps find a step on their grid, and round another one to it.
#[test]
fn small_steps_converge_to_it() {
    let mut case = common::six_modes();
    case.1
        .transmission_error
        .iter_mut()
        .for_each(|h| h.amplitude *= 0.01);
    case.1.torque_ripple.clear();
    case.2.load = 1.0;
    for (phase, least, most) in [(0.63, 3.8, 4.2), (0.5 + 1.0 / 7919.0, 1.0, 100.0)] {
        let model = model(&case, |drive| step_at(phase, drive));
        let start = settled(&model, 3);
        let end = advance(&volterra(&model), &start, 1);
        let [coarse, fine] = [1900, 3800].map(|steps| {
            let small = Stepping::new(&model, steps, 100);
            relative_difference(&advance(&small, &start, 1).state, &end.state)
        });
        println!("step at {phase}: {coarse:.1e}, {fine:.1e}");
        assert!(coarse < 1e-3);
        assert!((least..most).contains(&(coarse / fine)), "{coarse} {fine}");
    }
}
