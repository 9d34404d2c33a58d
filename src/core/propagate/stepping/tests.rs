use super::cubic::{derivative, hermite};
use super::*;
use crate::model::{ActiveSet, Division, Drive, InitialState, MeshHarmonic, fixtures};
use crate::propagate::Window;
use crate::structure::ModalStructure;

fn structure() -> ModalStructure {
    ModalStructure {
        rated_force: 1000.0,
        ..fixtures::structure(&[0.0, 5000.0], 0.02, &[1.0, 0.5], &[1.0, 0.2])
    }
}

fn model(stiffness: &[f64]) -> Model {
    let drive = Drive {
        mesh: Division::levels(stiffness, &[]),
        damping: 1000.0,
        transmission_error: vec![MeshHarmonic::new(1, 5e-6, 0.3)],
        ..fixtures::constant_mesh(1e-5, 4e8)
    };
    Model::new(&structure(), &drive, fixtures::strong_rattle()).unwrap()
}

/// A recorded window.
struct RecordedWindow {
    start: f64,
    duration: f64,
    contact: ActiveSet,
    deflection: [f64; 4],
    force: [f64; 4],
    state: Vec<f64>,
}

/// Records windows and events.
#[derive(Default)]
struct Record {
    windows: Vec<RecordedWindow>,
    events: Vec<Event>,
}

impl Observer for Record {
    const WINDOWS: bool = true;

    fn window(&mut self, w: &Window<'_>) {
        self.windows.push(RecordedWindow {
            start: w.start,
            duration: w.duration,
            contact: w.contact,
            deflection: w.deflection.try_into().unwrap(),
            force: w.force.try_into().unwrap(),
            state: [w.first, w.second].concat(),
        });
    }

    fn event(&mut self, event: &Event) {
        self.events.push(*event);
    }
}

#[test]
fn steps_are_rounded_up_to_the_segment_boundaries() {
    let mut two_level = vec![4e8; 36];
    two_level.extend(vec![3e8; 24]);
    // Boundaries at 0.6 of the cycle: multiples of five steps.
    let kernel = Stepping::new(&model(&two_level), 101, 10);
    assert_eq!(kernel.steps(), 105);
    let split = kernel.contacts[0]
        .middles
        .iter()
        .position(|m| m.segment == 1)
        .unwrap();
    assert_eq!(split, 63);
    assert_eq!(kernel.contacts[0].middles.len(), 105);
    assert_eq!(Stepping::new(&model(&[4e8]), 101, 10).steps(), 101);
    assert_eq!(Stepping::new(&model(&[4e8, 3e8, 2e8]), 0, 10).steps(), 3);
}

#[test]
fn cubic_reproduces_values_and_rates_at_both_ends() {
    let duration = 0.4;
    let a = hermite([1.3, -0.7], [2.1, 5.0], duration);
    let r = derivative(a, duration);
    let ends = |a: [f64; 4]| (a[0] - a[1] + a[2] - a[3], a.iter().sum::<f64>());
    let close = |x: f64, y: f64| assert!((x - y).abs() < 1e-14, "{x} {y}");
    close(ends(a).0, 1.3);
    close(ends(a).1, 2.1);
    close(ends(r).0, -0.7);
    close(ends(r).1, 5.0);
}

#[test]
fn windows_tile_the_cycle_and_agree_with_the_model() {
    let model = model(&[4.4e8, 4.4e8, 3.3e8]);
    let kernel = Stepping::new(&model, 900, 100);
    let mut trajectory = model.start(&InitialState::Static);
    let mut record = Record::default();
    let mut work = kernel.workspace();
    let mut counters = Counters::default();
    kernel
        .advance(1, &mut trajectory, &mut work, &mut record, &mut counters)
        .unwrap();
    assert_eq!(record.windows.len(), 900);
    assert_eq!(counters.windows, 900);
    assert_eq!(counters.events as usize, record.events.len());
    let left = |a: [f64; 4]| a[0] - a[1] + a[2] - a[3];
    for (j, window) in record.windows.iter().enumerate() {
        let start = model.period() * j as f64 / 900.0;
        assert!((window.start - start).abs() < 1e-18);
        assert!((window.duration - model.period() / 900.0).abs() < 1e-18);
        let (deflection, rate) = model.deflection(&window.state, start);
        assert!((left(window.deflection) - deflection).abs() < 1e-13 * model.half_gap);
        let segment = &model.first_cycle().segments[usize::from(j >= 600)];
        let closed = window.contact.only();
        let force = closed.map_or(0.0, |contact| {
            model.contacts[contact].force(segment, start, deflection, rate)
        });
        assert!((left(window.force) - force).abs() < 1e-9 * (1.0 + force.abs()));
    }
}

#[test]
fn watching_does_not_change_the_trajectory() {
    let model = model(&[4.4e8, 3.3e8]);
    let kernel = Stepping::new(&model, 500, 100);
    let mut work = kernel.workspace();
    let mut counters = Counters::default();
    let mut observed = model.start(&InitialState::Static);
    let mut unseen = observed.clone();
    let mut record = Record::default();
    for _ in 0..20 {
        kernel
            .advance(1, &mut observed, &mut work, &mut record, &mut counters)
            .unwrap();
        kernel
            .advance(1, &mut unseen, &mut work, &mut (), &mut counters)
            .unwrap();
    }
    assert_eq!(observed, unseen);
    // Each event starts from the contact state of the previous one, and the last one ends in that of the trajectory.
    assert!(!record.events.is_empty());
    for pair in record.events.windows(2) {
        assert_eq!(pair[0].to, pair[1].from);
    }
    assert_eq!(record.events.last().unwrap().to, observed.contact);
    let own = model.active_set(&model.segments_at(0, 0.0), 0, &observed.state, 0.0);
    assert_eq!(own, observed.contact);
}

#[test]
fn event_limit_and_divergence_stop_the_integration() {
    let model = model(&[4.4e8, 3.3e8]);
    let mut counters = Counters::default();
    let mut advance = |kernel: &Stepping, trajectory: &mut TrajectoryState| {
        kernel.advance(
            50,
            trajectory,
            &mut kernel.workspace(),
            &mut (),
            &mut counters,
        )
    };
    let mut trajectory = model.start(&InitialState::Static);
    let stop = advance(&Stepping::new(&model, 500, 0), &mut trajectory);
    assert!(matches!(stop, Err(Stop::EventStorm { limit: 0, .. })));

    let mut lost = model.start(&InitialState::Static);
    lost.state[0] = f64::NAN;
    lost.cycle = 3;
    let stop = advance(&Stepping::new(&model, 500, 100), &mut lost);
    assert_eq!(stop, Err(Stop::Diverged { cycle: 3 }));
    // A motion that diverges: 1e9 m/s for a period is far beyond a million half gaps of 10 µm.
    let mut lost = model.start(&InitialState::Static);
    lost.state[2] = 1e9;
    let stop = advance(&Stepping::new(&model, 500, 100), &mut lost);
    assert!(matches!(stop, Err(Stop::Diverged { .. })));
}

/// If a contact's line changes at the start of a segment shorter than a step, the next step has the change.
#[test]
fn a_segment_without_a_step_hides_no_turn() {
    let mut structure = structure();
    structure.mesh_tilt = vec![0.0, 20.0];
    let tilted = |end: f64, stiffness: f64| Division {
        load_centre: 5e-3,
        ..Division::level(end, stiffness)
    };
    let middle = [
        Division::level(0.5, 4e8),
        tilted(0.5 + 1e-6, 4e8),
        tilted(1.0, 3e8),
    ];
    let last = [
        tilted(0.5, 4e8),
        Division::level(1.0 - 1e-6, 4e8),
        tilted(1.0, 3e8),
    ];
    for mesh in [middle, last] {
        let drive = Drive {
            mesh: mesh.to_vec(),
            ..fixtures::constant_mesh(1e-5, 4e8)
        };
        let model = Model::new(&structure, &drive, fixtures::strong_rattle()).unwrap();
        let kernel = Stepping::new(&model, 100, 10);
        let turned: Vec<usize> = (0..kernel.steps())
            .filter(|&j| kernel.middle(0, 0, j).turned)
            .collect();
        assert_eq!((turned, kernel.steps()), (vec![0, 50], 100));
    }
}
