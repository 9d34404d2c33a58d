//! Contacts that open where their force vanishes: a closed form, the limit without a damper, and the absence of pulling
//! forces. Kernels with such contacts are in `tests/motion/any_drive.rs`.

#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::{Events, advance, advance_with, volterra};
use common::{constant_mesh, drives, one_mode, relative_difference};
use gearatlas::model::{Drive, InitialState, Model, OperatingPoint, Release, TrajectoryState};
use gearatlas::numerics::legendre::evaluate;
use gearatlas::propagate::{
    ClosedModes, Event, InstructionSet, Observer, Stepping, TableError, Window,
};
use gearatlas::reference::{Extended, Reference};

/// A free mass of 1 kg between two walls of 1 N/m and of damping ratio ζ, one metre from the middle.
fn bouncing(ratio: f64, release: Release) -> Model {
    let drive = Drive {
        damping: 2.0 * ratio,
        release,
        ..constant_mesh(1.0, 1.0)
    };
    let point = OperatingPoint {
        load: 0.0,
        speed: 1.0,
    };
    Model::new(&one_mode(0.0), &drive, point).unwrap()
}

/// Times at which the mass strikes and is released, if it leaves the middle at some speed.
///
/// From `x'' + 2ζx' + x = 0` the force, `−x''`, vanishes when the damped phase is π − 2 asin ζ. The speed is then that
/// of the impact times `e^{−ζt}`.
fn strokes(ratio: f64, mut speed: f64, count: usize) -> Vec<f64> {
    let damped = (1.0 - ratio * ratio).sqrt();
    let phase = std::f64::consts::PI - 2.0 * ratio.asin();
    let contact = phase / damped;
    let mut time = 1.0 / speed;
    let mut out = Vec::new();
    while out.len() < count {
        out.push(time);
        time += contact;
        out.push(time);
        let kept = (-ratio * contact).exp();
        let indentation = speed / damped * kept * phase.sin();
        speed *= kept;
        time += (2.0 + indentation) / speed;
    }
    out
}

#[test]
fn a_damped_bounce_lasts_as_its_closed_form_says() {
    for ratio in [0.01, 0.1, 0.5, 0.9] {
        let model = bouncing(ratio, Release::Force);
        let start = TrajectoryState::new(&model, vec![0.0, 1.5], 0);
        let exact = strokes(ratio, 1.5, 8);
        let cycles = 1 + (exact[5] / model.period()) as u64;
        let mut seen = Events::default();
        advance_with(&volterra(&model), &start, cycles, &mut seen);
        let of = |cycle: u64, time: f64| cycle as f64 * model.period() + time;
        let volterra: Vec<f64> = seen.0.iter().map(|e| of(e.cycle, e.time)).collect();
        let passage = Reference::new(&model).advance(&start, cycles).unwrap();
        let reference = (passage.crossings.iter()).map(|c| of(c.cycle, c.time));
        let passage = Extended::new(&model).advance(&start, cycles).unwrap();
        let extended = (passage.crossings.iter()).map(|c| of(c.cycle, c.time.value()));
        for times in [volterra, reference.collect(), extended.collect()] {
            assert!(times.len() >= 6, "{ratio}: {times:?}");
            for (time, exact) in times.iter().zip(&exact) {
                assert!(
                    (time - exact).abs() < 1e-12 * exact,
                    "{ratio}: {time} {exact}"
                );
            }
        }
        let mut steps = Events::default();
        advance_with(
            &Stepping::new(&model, 100_000, 100),
            &start,
            cycles,
            &mut steps,
        );
        for (event, exact) in steps.0.iter().zip(&exact) {
            let time = of(event.cycle, event.time);
            assert!(
                (time - exact).abs() < 2e-4 * exact,
                "{ratio}: {time} {exact}"
            );
        }
    }
}

#[test]
fn without_a_damper_both_laws_are_one() {
    let [by_deflection, by_force] =
        [Release::Deflection, Release::Force].map(|release| bouncing(0.0, release));
    assert_eq!(by_deflection, by_force);
    // The motion with a weak damper is near the limit without one, and releases with hardly any indentation left.
    let ends = [0.0, 1e-9, 1e-15].map(|ratio| {
        let model = bouncing(ratio, Release::Force);
        let start = TrajectoryState::new(&model, vec![0.0, 1.5], 0);
        advance(&volterra(&model), &start, 10).state
    });
    for (weak, error) in [(&ends[1], 1e-6), (&ends[2], 1e-12)] {
        let away = (weak[0] - ends[0][0]).hypot(weak[1] - ends[0][1]);
        assert!(away < error, "{away:e}");
    }
}

/// The forces and events of a trajectory.
struct Pushes<'m> {
    model: &'m Model,
    largest: f64,
    hardest_pull: f64,
    retaken: usize,
}

impl Observer for Pushes<'_> {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        for closed in window.closed {
            let side = self.model.contacts[closed.contact].side;
            for i in 0..=40 {
                let push = side * evaluate(closed.force, f64::from(i) / 20.0 - 1.0);
                self.largest = self.largest.max(push);
                self.hardest_pull = self.hardest_pull.max(-push);
            }
        }
    }

    fn event(&mut self, event: &Event) {
        let side = self.model.contacts[event.contact].side;
        self.retaken += usize::from(event.closes() && side * event.rate < 0.0);
    }
}

/// A contact never pulls, not even with a strong damper, between opening and becoming free.
#[test]
fn a_contact_never_pulls() {
    let mut retaken = 0;
    for (name, (structure, drive, point)) in drives() {
        for stronger in [1.0, 8.0] {
            let drive = Drive {
                damping: stronger * drive.damping,
                release: Release::Force,
                ..drive.clone()
            };
            let model = Model::new(&structure, &drive, point).unwrap();
            let mut pushes = Pushes {
                model: &model,
                largest: 0.0,
                hardest_pull: 0.0,
                retaken: 0,
            };
            let start = model.start(&InitialState::Static);
            advance_with(&volterra(&model), &start, 200, &mut pushes);
            let share = pushes.hardest_pull / pushes.largest;
            println!(
                "{name}: pulls {share:.1e} of its push, takes hold again {} times",
                pushes.retaken
            );
            assert!(share < 1e-12, "{name}: {share:e}");
            retaken += pushes.retaken;
        }
    }
    assert!(retaken > 0);
}

/// Dampers so strong that contacts close again before they are free, cycle by cycle compared with the trajectory to 30
/// digits.
#[test]
fn cycles_of_strong_dampers_to_thirty_digits() {
    let mut retaken = 0;
    for (name, (structure, drive, point)) in drives().into_iter().take(4) {
        for stronger in [3.0, 8.0, 20.0] {
            let drive = Drive {
                damping: stronger * drive.damping,
                release: Release::Force,
                ..drive.clone()
            };
            let model = Model::new(&structure, &drive, point).unwrap();
            let (kernel, exact) = (volterra(&model), Extended::new(&model));
            let mut state = model.start(&InitialState::Static);
            let (mut worst, mut late) = (0.0f64, 0.0f64);
            for _ in 0..60 {
                let mut seen = Events::default();
                let (end, _) = advance_with(&kernel, &state, 1, &mut seen);
                let passage = exact.advance(&state, 1).unwrap();
                worst = worst.max(relative_difference(&end.state, &passage.end().state));
                assert_eq!(seen.0.len(), passage.crossings.len(), "{name}");
                for (event, crossing) in seen.0.iter().zip(&passage.crossings) {
                    assert_eq!(
                        (event.from, event.to),
                        (crossing.from, crossing.to),
                        "{name}"
                    );
                    late = late.max((event.time - crossing.time.value()).abs() / model.period());
                    let side = model.contacts[event.contact].side;
                    retaken += usize::from(event.closes() && side * event.rate < 0.0);
                }
                state = end;
            }
            println!("{name}, damping × {stronger}: states {worst:.1e}, times {late:.1e}");
            assert!(worst < 1e-12 && late < 1e-13, "{name}: {worst:e} {late:e}");
        }
    }
    assert!(retaken > 10, "{retaken}");
}

#[test]
fn tables_refuse_it() {
    let model = bouncing(0.1, Release::Force);
    let refused = ClosedModes::new(&model, 100, InstructionSet::best()).err();
    assert_eq!(refused, Some(TableError::Release));
}
