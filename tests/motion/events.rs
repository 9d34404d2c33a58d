//! Are events at the right times? One-degree oscillators with closed forms, in cases where root finders fail: grazing,
//! close pairs, starts on a surface, ends of windows, segments and cycles, none at all, hundreds. Counts are exact.

#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::{Events, ROUND_OFF, advance_with, volterra};
use gearatlas::model::{
    ActiveSet, COAST_FLANK, DRIVE_FLANK, Division, Drive, DriveShaft, InitialState, Model,
    OperatingPoint, TorqueRipple, TrajectoryState,
};
use gearatlas::propagate::{Counters, Event, Kernel, Stop, Volterra};
use std::f64::consts::{PI, TAU};

/// One undamped mode `q'' + ω² q = load − F`, which is the deflection itself.
struct Oscillator {
    natural: f64,
    stiffness: f64,
    half_gap: f64,
    /// Acceleration of the mean torque \[m/s²\].
    load: f64,
    /// Pinion speed \[rad/s\]; twenty teeth.
    speed: f64,
}

impl Default for Oscillator {
    fn default() -> Self {
        Self {
            natural: 0.0,
            stiffness: 4e8,
            half_gap: 10e-6,
            load: 0.0,
            speed: 1200.0,
        }
    }
}

impl Oscillator {
    fn model(&self) -> Model {
        self.with_ripple(&[])
    }

    /// The model with accelerations `amplitude cos(ωt + phase)`, ω = order Ω.
    fn with_ripple(&self, ripple: &[(f64, f64, f64)]) -> Model {
        let mut structure = common::structure(&[self.natural], 0.0, &[1.0], &[1.0]);
        structure.rated_force = 1.0;
        structure.pinion_torque = Some(vec![1.0]);
        let drive = Drive {
            mesh: Division::levels(&[self.stiffness; 60], &[]),
            torque_ripple: ripple
                .iter()
                .map(|&(order, amplitude, phase)| TorqueRipple {
                    shaft: DriveShaft::Pinion,
                    order,
                    amplitude,
                    phase,
                })
                .collect(),
            ..common::constant_mesh(self.half_gap, self.stiffness)
        };
        let point = OperatingPoint {
            load: self.load,
            speed: self.speed,
        };
        Model::new(&structure, &drive, point).unwrap()
    }

    /// Angular frequency in contact.
    fn closed(&self) -> f64 {
        (self.natural.powi(2) + self.stiffness).sqrt()
    }

    /// Time in contact after an entry with a speed.
    fn dwell(&self, speed: f64) -> f64 {
        // q − rest = s cos + v/Ω sin with s = (ω² b − load)/Ω²: back at s after twice the
        // angle of the top.
        let closed = self.closed();
        let s = (self.natural.powi(2) * self.half_gap - self.load) / closed.powi(2);
        2.0 * (speed / closed).atan2(s) / closed
    }
}

/// Events of some cycles with the time since the start, and the work.
fn events(
    model: &Model,
    start: &TrajectoryState,
    cycles: u64,
) -> (Vec<(f64, Event)>, Counters, TrajectoryState) {
    let mut seen = Events::default();
    let (end, counters) = advance_with(&volterra(model), start, cycles, &mut seen);
    assert_eq!(counters.events, seen.0.len() as u64);
    let absolute = |e: &Event| e.cycle as f64 * model.period() + e.time;
    let list = seen.0.iter().map(|e| (absolute(e), *e)).collect();
    (list, counters, end)
}

fn start(model: &Model, position: f64, velocity: f64) -> TrajectoryState {
    TrajectoryState::new(model, vec![position, velocity], 0)
}

/// Cycles that cover a time.
fn cover(model: &Model, time: f64) -> u64 {
    (time / model.period()).ceil() as u64
}

/// A free oscillation whose amplitude misses or exceeds the gap by 1e-9.
#[test]
fn grazing_free_oscillation() {
    let amplitude = 10e-6;
    for (gap, expected) in [(1.0 + 1e-9, 0), (1.0 - 1e-9, 2)] {
        let o = Oscillator {
            natural: 5000.0,
            half_gap: amplitude * gap,
            ..Oscillator::default()
        };
        let model = o.model();
        let from = start(&model, 0.0, o.natural * amplitude);
        let (list, counters, _) = events(&model, &from, cover(&model, 0.4 * TAU / o.natural));
        assert_eq!((list.len(), counters.grazings), (expected, 0), "gap {gap}");
        if expected == 2 {
            let speed = o.natural * amplitude * (1.0 - gap * gap).sqrt();
            let entry = gap.asin() / o.natural;
            // Round-off of the deflection divided by the crossing speed.
            let slack = 16.0 * f64::EPSILON * amplitude / speed;
            assert!((list[0].0 - entry).abs() < slack);
            assert!((list[0].1.rate - speed).abs() < 1e-6 * speed);
            let dwell = list[1].0 - list[0].0;
            assert!((dwell - o.dwell(speed)).abs() < 1e-6 * dwell);
            assert_eq!(list[1].1.to, ActiveSet::FREE);
        }
    }
}

/// The steady state of a forced oscillator, `A/√((k − w²)² + …)`, grazes both surfaces when
/// the gap equals its amplitude.
#[test]
fn grazing_forced_oscillation() {
    for (gap, expected) in [(1.0 + 1e-9, 0), (1.0 - 1e-9, 4)] {
        let (natural, order) = (5000.0, 3.7);
        let o = Oscillator {
            natural,
            ..Oscillator::default()
        };
        let omega = order * o.speed;
        let force = 40.0;
        let amplitude = force / (natural * natural - omega * omega);
        let o = Oscillator {
            half_gap: amplitude * gap,
            ..o
        };
        let model = o.with_ripple(&[(order, force, -0.5 * PI)]);
        // q = A sin ωt: grazes the drive surface at a quarter period, coast at three quarters.
        let from = start(&model, 0.0, amplitude * omega);
        let cycles = cover(&model, 0.9 * TAU / omega);
        let (list, counters, _) = events(&model, &from, cycles);
        assert_eq!((list.len(), counters.grazings), (expected, 0), "gap {gap}");
        if expected == 4 {
            assert_eq!(list[0].1.contact, DRIVE_FLANK);
            assert_eq!(list[2].1.contact, COAST_FLANK);
            let entry = gap.asin() / omega;
            let speed = (1.0 - gap * gap).sqrt();
            assert!((list[0].0 - entry).abs() * omega < 64.0 * f64::EPSILON / speed);
        } else {
            // The oscillator never touches, for any number of cycles.
            let (list, counters, _) = events(&model, &from, 2000);
            assert_eq!((list.len(), counters.grazings), (0, 0));
        }
    }
}

/// If amplitude and gap are equal to the last digit, the tangency is counted, whether it touches or not.
#[test]
fn tangency_within_round_off_is_counted() {
    let o = Oscillator {
        natural: 5000.0,
        ..Oscillator::default()
    };
    let model = o.model();
    let from = start(&model, 0.0, o.natural * o.half_gap);
    let (list, counters, end) = events(&model, &from, cover(&model, 0.4 * TAU / o.natural));
    assert!(counters.grazings > 0 || list.len() == 2);
    assert!(list.len().is_multiple_of(2));
    let t = end.cycle as f64 * model.period();
    let exact = o.half_gap * (o.natural * t).sin();
    assert!((end.state[0] - exact).abs() < 1e-9 * o.half_gap);
}

/// A mass moves from flank to flank through a gap so narrow that release and entry are within 1e-9 of a cycle:
/// alternating pairs, all at their times.
#[test]
fn drive_to_coast_within_a_billionth_of_a_cycle() {
    let o = Oscillator {
        half_gap: 1e-14,
        ..Oscillator::default()
    };
    let model = o.model();
    let speed = 0.1;
    let flight = 2.0 * o.half_gap / speed;
    assert!(flight < 1e-9 * model.period());
    let from = start(&model, o.half_gap, speed);
    assert_eq!(from.contact, ActiveSet::DRIVE);
    let half = o.dwell(speed) + flight;
    let cycles = cover(&model, 20.3 * half);
    let (list, _, _) = events(&model, &from, cycles);
    let total = cycles as f64 * model.period();
    let expected = (0..)
        .flat_map(|i| {
            let release = f64::from(i) * half + o.dwell(speed);
            [release, release + flight]
        })
        .take_while(|t| *t < total)
        .collect::<Vec<_>>();
    assert_eq!(list.len(), expected.len());
    for (i, ((time, event), exact)) in list.iter().zip(&expected).enumerate() {
        assert!((time - exact).abs() < 1e-14 * total, "event {i}");
        let to = [
            ActiveSet::FREE,
            ActiveSet::COAST,
            ActiveSet::FREE,
            ActiveSet::DRIVE,
        ][i % 4];
        assert_eq!(event.to, to, "event {i}");
        assert!((event.rate.abs() - speed).abs() < 1e-9 * speed);
    }
}

/// A mass crosses the gap from the drive to the coast flank and back within one window.
#[test]
fn crossing_the_gap_within_a_window() {
    let o = Oscillator {
        half_gap: 1e-7,
        speed: 100.0,
        ..Oscillator::default()
    };
    let model = o.model();
    let speed = 0.5;
    let from = start(&model, 0.0, speed);
    let kernel = volterra(&model);
    let window = model.period() / kernel.windows_per_cycle() as f64;
    assert!(2.0 * o.half_gap / speed < 0.1 * window);
    let (list, _, _) = events(&model, &from, 1);
    let flight = 2.0 * o.half_gap / speed;
    let expected: Vec<f64> = (0..)
        .flat_map(|i| {
            let entry = 0.5 * flight + f64::from(i) * (o.dwell(speed) + flight);
            [entry, entry + o.dwell(speed)]
        })
        .take_while(|t| *t < model.period())
        .collect();
    assert!(expected.len() > 20);
    assert_eq!(list.len(), expected.len());
    for (i, ((time, _), exact)) in list.iter().zip(&expected).enumerate() {
        assert!((time - exact).abs() < 1e-13 * model.period(), "event {i}");
    }
}

#[test]
fn start_on_a_surface() {
    let o = Oscillator::default();
    let model = o.model();
    let (b, speed) = (o.half_gap, 0.05);
    let flight = 2.0 * b / speed;
    let dwell = o.dwell(speed);
    // The mass moves into the flank: the first event is the release.
    for side in [1.0, -1.0] {
        let from = start(&model, side * b, side * speed);
        assert!(from.contact.touching());
        let (list, _, _) = events(&model, &from, cover(&model, dwell));
        assert_eq!(list.len(), 1);
        assert!((list[0].0 - dwell).abs() < 1e-14 * dwell.max(model.period()));
        // The mass moves away from the flank: the first event is the entry on the other side.
        let from = start(&model, side * b, -side * speed);
        assert_eq!(from.contact, ActiveSet::FREE);
        let cycles = cover(&model, flight);
        let (list, _, _) = events(&model, &from, cycles);
        assert!((list[0].0 - flight).abs() < 1e-14 * flight);
        assert_eq!(list[0].1.to.sign(), -side);
        let total = cycles as f64 * model.period();
        assert_eq!(list.len(), 1 + usize::from(total > flight + dwell));
        // The mass is at rest without load: it stays there.
        let from = start(&model, side * b, 0.0);
        let (list, counters, end) = events(&model, &from, 50);
        assert_eq!((list.len(), end.state), (0, vec![side * b, 0.0]));
        assert!(counters.grazings > 0, "resting on a surface is a tangency");
    }
}

/// Released at rest on the surface: a load towards the flank presses it in, one away lets it drop off.
#[test]
fn start_at_rest_on_a_surface_under_load() {
    for load in [20.0, -20.0] {
        let o = Oscillator {
            load,
            ..Oscillator::default()
        };
        let model = o.model();
        let from = start(&model, o.half_gap, 0.0);
        let (list, _, end) = events(&model, &from, 1);
        let t = model.period();
        if load > 0.0 {
            // q = b + load/Ω² (1 − cos Ωt): back on the surface only after 2π/Ω > T.
            assert!(TAU / o.closed() > t);
            assert_eq!(list.len(), 1);
            assert_eq!(list[0].1.to, ActiveSet::DRIVE);
            assert!(list[0].0 < 1e-6 * t, "{}", list[0].0 / t);
            let swing = load / o.stiffness;
            let exact = o.half_gap + swing * (1.0 - (o.closed() * t).cos());
            assert!((end.state[0] - exact).abs() < 1e-12 * swing);
        } else {
            assert_eq!(list.len(), 0);
            let exact = o.half_gap + 0.5 * load * t * t;
            assert!((end.state[0] - exact).abs() < 1e-15 * o.half_gap);
        }
    }
}

/// An entry or release within a few units in the last place of a window's edge, a segment's boundary or the cycle's end
/// occurs once, at its time.
#[test]
fn event_on_an_edge() {
    let o = Oscillator::default();
    let speed = 0.05;
    let mut structure = common::structure(&[0.0], 0.0, &[1.0], &[1.0]);
    structure.rated_force = 1.0;
    for divisions in [1, 3, 60] {
        // Alternating levels with a difference too small for the closed forms.
        let levels: Vec<_> = (0..divisions)
            .map(|i| o.stiffness * (1.0 + 1e-15 * f64::from(i % 2)))
            .collect();
        let drive = Drive {
            mesh: Division::levels(&levels, &[]),
            ..common::constant_mesh(o.half_gap, o.stiffness)
        };
        let point = OperatingPoint {
            load: 0.0,
            speed: o.speed,
        };
        let model = Model::new(&structure, &drive, point).unwrap();
        assert_eq!(model.first_cycle().segments.len(), divisions as usize);
        let t = model.period();
        let cells = volterra(&model).windows_per_cycle();
        for cell in [1, cells.div_ceil(2), cells] {
            for shift in -3..=3 {
                let edge = t * cell as f64 / cells as f64;
                let edge = edge * (1.0 + f64::from(shift) * f64::EPSILON);
                // The entry is on the edge.
                let from = start(&model, o.half_gap - speed * edge, speed);
                let cycles = cover(&model, edge + o.dwell(speed)).max(2);
                let (list, _, _) = events(&model, &from, cycles);
                let mut exact = vec![edge, edge + o.dwell(speed)];
                let mut next = exact[1] + 2.0 * o.half_gap / speed;
                while next < cycles as f64 * t {
                    exact.push(next);
                    exact.push(next + o.dwell(speed));
                    next = exact[exact.len() - 1] + 2.0 * o.half_gap / speed;
                }
                exact.retain(|e| *e < cycles as f64 * t);
                assert_eq!(list.len(), exact.len(), "cell {cell} of {cells}, {shift}");
                for (found, exact) in list.iter().zip(&exact) {
                    assert!((found.0 - exact).abs() < 1e-14 * t, "{} {exact}", found.0);
                }
                // The release is on the edge: start from the state in contact that reaches the surface there.
                let before = o.closed() * edge;
                let position = o.half_gap + speed / o.closed() * before.sin();
                if before < PI {
                    let from = start(&model, position, -speed * before.cos());
                    assert_eq!(from.contact, ActiveSet::DRIVE);
                    let (list, _, _) = events(&model, &from, 2);
                    assert!((list[0].0 - edge).abs() < 1e-14 * t);
                    assert_eq!(list[0].1.to, ActiveSet::FREE);
                    let again = edge + 2.0 * o.half_gap / speed;
                    let expected = 1 + usize::from(again < 2.0 * t);
                    assert_eq!(
                        list.len(),
                        expected,
                        "release, cell {cell} of {cells}, {shift}"
                    );
                }
            }
        }
    }
}

#[test]
fn no_events_where_nothing_touches() {
    let o = Oscillator {
        natural: 3000.0,
        ..Oscillator::default()
    };
    let model = o.model();
    // The mass starts at rest in the middle, or swings over half the gap.
    for position in [0.0, 5e-6] {
        let (list, counters, end) = events(&model, &start(&model, position, 0.0), 1000);
        assert_eq!((list.len(), counters.grazings), (0, 0));
        let exact = position * (o.natural * model.period() * 1000.0).cos();
        assert!((end.state[0] - exact).abs() < 1e-12 * o.half_gap);
    }
}

#[test]
fn hundreds_of_events_in_a_cycle_and_their_limit() {
    let o = Oscillator {
        speed: 5.0,
        half_gap: 1e-6,
        ..Oscillator::default()
    };
    let model = o.model();
    let speed = 0.1;
    let from = start(&model, o.half_gap, speed);
    let half = o.dwell(speed) + 2.0 * o.half_gap / speed;
    let whole = (model.period() / half).floor();
    let rest = model.period() - whole * half;
    let expected = 2 * whole as u32 + u32::from(rest > o.dwell(speed));
    assert!(expected > 400);
    let run = |limit: u32| {
        let kernel = Volterra::new(&model, ROUND_OFF, limit);
        let mut counters = Counters::default();
        let mut trajectory = from.clone();
        let result = kernel.advance(
            1,
            &mut trajectory,
            &mut kernel.workspace(),
            &mut (),
            &mut counters,
        );
        (result, counters.events)
    };
    assert_eq!(run(expected), (Ok(()), u64::from(expected)));
    let limit = expected - 1;
    assert_eq!(run(limit).0, Err(Stop::EventStorm { cycle: 0, limit }));
    assert_eq!(run(0).0, Err(Stop::EventStorm { cycle: 0, limit: 0 }));
}

/// A trajectory with a wrong contact state is corrected by one event at its start.
#[test]
fn wrong_contact_state_is_put_right() {
    let o = Oscillator::default();
    let model = o.model();
    // The mass is deep in contact and moves outwards: the release must be at the surface.
    for (position, contact) in [(12e-6, ActiveSet::FREE), (3e-6, ActiveSet::DRIVE)] {
        let right = start(&model, position, 0.05);
        let mut wrong = right.clone();
        wrong.contact = contact;
        let (expected, _, end) = events(&model, &right, 3);
        let (found, _, corrected) = events(&model, &wrong, 3);
        assert_eq!((found[0].0, found[0].1.to), (0.0, right.contact));
        assert_eq!(found[1..], expected);
        assert_eq!(corrected, end);
    }
}

#[test]
fn nonsense_diverges_at_once() {
    let model = common::model(&common::six_modes());
    let kernel = volterra(&model);
    let rest = model.start(&InitialState::Static);
    for component in [1, 3, 7, 11] {
        for value in [
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            1e300,
            -1e300,
            1e9,
        ] {
            let mut state = rest.state.clone();
            state[component] = value;
            let mut trajectory = TrajectoryState::new(&model, state, 7);
            let stop = kernel.advance(
                1,
                &mut trajectory,
                &mut kernel.workspace(),
                &mut (),
                &mut Counters::default(),
            );
            let diverged = Err(Stop::Diverged { cycle: 7 });
            assert_eq!(stop, diverged, "component {component} = {value}");
        }
    }
}
