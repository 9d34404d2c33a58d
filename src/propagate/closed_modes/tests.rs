use super::*;
use crate::model::{Drive, InitialState, OperatingPoint, TrajectoryState, fixtures};
use crate::propagate::{Counters, Event, Kernel, Observer, Tangents, Volterra, Window};
use crate::shaft::ModalStructure;

fn structure() -> ModalStructure {
    let mut structure = fixtures::structure(
        &[
            0.0, 0.0, 4288.0, 4864.0, 8171.0, 19757.0, 400.0, 900.0, 7000.0,
        ],
        0.01,
        &[0.61, -0.49, 0.72, 0.64, -0.48, 0.21, 0.1, 0.2, -0.3],
        &[0.61, -0.49, 0.33, -0.21, 0.05, 0.0, 0.1, 0.1, 0.0],
    );
    structure.friction = vec![0.1, 0.2, -0.17, 0.56, 0.3, -0.1, 0.0, 0.2, 0.1];
    structure
}

fn drive() -> Drive {
    Drive {
        friction: 0.1,
        ..fixtures::two_level_mesh(1e-5)
    }
}

/// Events and windows of a motion.
#[derive(Default)]
struct Seen {
    events: Vec<Event>,
    work: f64,
    time: f64,
}

impl Observer for Seen {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        let product = |a: &[f64], b: &[f64]| -> f64 {
            (a.iter().zip(b).enumerate())
                .map(|(n, (a, b))| a * b / (2 * n + 1) as f64)
                .sum()
        };
        self.work += window.duration * product(window.deflection, window.force);
        self.time += window.duration;
    }

    fn event(&mut self, event: &Event) {
        self.events.push(*event);
    }
}

fn motion<K: Kernel>(
    kernel: &K,
    model: &Model,
    cycles: u64,
) -> (TrajectoryState, Tangents, Seen, Counters) {
    let mut trajectory = model.start(&InitialState::Static);
    trajectory.state[2] += 1e-6;
    let mut tangents = Tangents::zeros(model.modes(), 2);
    for (i, x) in tangents.vector_mut(0).iter_mut().enumerate() {
        *x = 1e-7 * (1.0 + i as f64);
    }
    tangents.vector_mut(1)[3] = 1e-6;
    let (mut workspace, mut counters) = (kernel.workspace(), Counters::default());
    let mut seen = Seen::default();
    for _ in 0..cycles {
        kernel
            .advance_cycle(
                &mut trajectory,
                &mut tangents,
                &mut workspace,
                &mut seen,
                &mut counters,
            )
            .unwrap();
    }
    (trajectory, tangents, seen, counters)
}

fn distance(model: &Model, a: &[f64], b: &[f64]) -> f64 {
    let n = model.modes();
    let rate = 1e4;
    (0..n)
        .map(|i| ((a[i] - b[i]).powi(2) + ((a[n + i] - b[n + i]) / rate).powi(2)).sqrt())
        .fold(0.0, f64::max)
}

/// Both kernels pass the same events to the same states, tangents and windows included.
#[test]
fn it_moves_as_volterra_does() {
    for (load, speed) in [(0.1, 1200.0), (0.3, 900.0), (-0.2, 700.0), (0.02, 2500.0)] {
        let point = OperatingPoint { load, speed };
        let model = Model::new(&structure(), &drive(), point).unwrap();
        let arrays = ClosedModes::arrays(&model).unwrap();
        for set in InstructionSet::available() {
            let kernel = ClosedModes::of_kept(&model, 100, &arrays, set).unwrap();
            let reference = Volterra::new(&model, f64::EPSILON, 100);
            let (a, ta, seen, counters) = motion(&kernel, &model, 6);
            let (b, tb, known, _) = motion(&reference, &model, 6);
            assert_eq!(a.contact, b.contact);
            assert_eq!(seen.events.len(), known.events.len());
            assert!(counters.events > 0 || load.abs() > 0.2, "{load} {speed}");
            for (a, b) in seen.events.iter().zip(&known.events) {
                assert_eq!((a.cycle, a.from, a.to), (b.cycle, b.from, b.to));
                assert!(
                    (a.time - b.time).abs() < 1e-11 * model.period(),
                    "{a:?} {b:?}"
                );
            }
            let off = distance(&model, &a.state, &b.state) / model.half_gap;
            assert!(off < 1e-10, "{load} {speed} {} {off:e}", set.name());
            for i in 0..2 {
                let size = distance(&model, tb.vector(i), &vec![0.0; 2 * model.modes()]);
                let off = distance(&model, ta.vector(i), tb.vector(i)) / size;
                assert!(off < 1e-9, "tangent {i}: {off:e}");
            }
            assert!((seen.time / known.time - 1.0).abs() < 1e-12);
            assert!((seen.work - known.work).abs() < 1e-10 * known.work.abs());
        }
    }
}

/// Takes the first window's state.
struct Start {
    read: bool,
    state: Option<Vec<f64>>,
}

impl Observer for Start {
    const WINDOWS: bool = true;

    fn states(&self) -> bool {
        self.read
    }

    fn window(&mut self, window: &Window<'_>) {
        (self.state).get_or_insert_with(|| [window.first, window.second].concat());
    }

    fn event(&mut self, _: &Event) {}
}

#[test]
fn states_are_shown_where_they_are_read_alone() {
    let model = Model::new(&structure(), &drive(), fixtures::strong_rattle()).unwrap();
    let kernel = ClosedModes::new(&model, 100, InstructionSet::best()).unwrap();
    let mut start = model.start(&InitialState::Static);
    start.state[2] += 1e-6;
    for read in [true, false] {
        let mut observer = Start { read, state: None };
        let (mut workspace, mut counters) = (kernel.workspace(), Counters::default());
        kernel
            .advance(
                1,
                &mut start.clone(),
                &mut workspace,
                &mut observer,
                &mut counters,
            )
            .unwrap();
        let shown = observer.state.unwrap();
        assert_eq!(shown.is_empty(), !read);
        if read {
            let off = distance(&model, &shown, &start.state) / model.half_gap;
            assert!(off < 1e-10, "{off:e}");
        }
    }
}

/// A trajectory that is stopped and taken up with other memory has the bits of one that is not.
#[test]
fn a_trajectory_goes_on_from_anywhere() {
    let model = Model::new(&structure(), &drive(), fixtures::strong_rattle()).unwrap();
    let kernel = ClosedModes::new(&model, 100, InstructionSet::best()).unwrap();
    let advance = |fresh: bool| {
        let mut trajectory = model.start(&InitialState::Static);
        let (mut workspace, mut counters) = (kernel.workspace(), Counters::default());
        for _ in 0..8 {
            if fresh {
                workspace = kernel.workspace();
            }
            kernel
                .advance(1, &mut trajectory, &mut workspace, &mut (), &mut counters)
                .unwrap();
        }
        trajectory
    };
    let (kept, fresh) = (advance(false), advance(true));
    assert_eq!(kept.state, fresh.state);
    assert_eq!(kept.contact, fresh.contact);
}
