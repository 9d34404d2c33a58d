use super::*;
use crate::model::{Drive, InitialState, OperatingPoint, TrajectoryState, fixtures};
use crate::propagate::vectors::Row;
use crate::propagate::{
    Counters, Event, Kernel, Observer, SharedStorage, Tangents, Volterra, Window,
};
use crate::structure::{Coupling, ModalStructure, StructureContact};
use reached_sets::ReachedSets;
use series::Series;

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
    let mut observed = Seen::default();
    for _ in 0..cycles {
        kernel
            .advance_cycle(
                &mut trajectory,
                &mut tangents,
                &mut workspace,
                &mut observed,
                &mut counters,
            )
            .unwrap();
    }
    (trajectory, tangents, observed, counters)
}

/// Largest distance of two states in a mode \[m √kg\], with velocities divided by a typical rate.
fn distance(model: &Model, a: &[f64], b: &[f64]) -> f64 {
    let (n, rate) = (model.modes(), 1e4);
    let difference: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    let modes = model.basis.turned_modes(&difference);
    (0..n)
        .map(|i| modes[i].hypot(modes[n + i] / rate))
        .fold(0.0, f64::max)
}

/// Both kernels have the same events, states, tangents and windows.
fn moves_as_volterra_does(model: &Model, kernel: &ClosedModes<'_>) {
    let reference = Volterra::new(model, f64::EPSILON, 100);
    let (a, ta, observed, counters) = motion(kernel, model, 6);
    let (b, tb, known, _) = motion(&reference, model, 6);
    assert_eq!(a.contact, b.contact);
    assert_eq!(observed.events.len(), known.events.len());
    assert!(counters.events > 0 || model.load.abs() > 0.2);
    for (a, b) in observed.events.iter().zip(&known.events) {
        assert_eq!((a.cycle, a.from, a.to), (b.cycle, b.from, b.to));
        assert!(
            (a.time - b.time).abs() < 1e-11 * model.period(),
            "{a:?} {b:?}"
        );
    }
    let off = distance(model, &a.state, &b.state) / model.half_gap;
    assert!(off < 1e-10, "{} {off:e}", kernel.instructions.name());
    for i in 0..2 {
        let size = distance(model, tb.vector(i), &vec![0.0; 2 * model.modes()]);
        let off = distance(model, ta.vector(i), tb.vector(i)) / size;
        assert!(off < 1e-9, "tangent {i}: {off:e}");
    }
    assert!((observed.time / known.time - 1.0).abs() < 1e-12);
    assert!((observed.work - known.work).abs() < 1e-10 * known.work.abs());
}

#[test]
fn it_moves_as_volterra_does() {
    for (load, speed) in [(0.1, 1200.0), (0.3, 900.0), (-0.2, 700.0), (0.02, 2500.0)] {
        let point = OperatingPoint { load, speed };
        let model = Model::new(&structure(), &drive(), point).unwrap();
        let arrays = ClosedModes::arrays(&model).unwrap();
        for set in InstructionSet::available() {
            let kernel = ClosedModes::from_kept(&model, 100, &arrays, set).unwrap();
            moves_as_volterra_does(&model, &kernel);
        }
    }
}

/// Products omit two modes on which no contact acts.
#[test]
fn modes_without_contact_are_left_out_of_products() {
    let mut own = fixtures::structure(
        &[0.0, 500.0, 4288.0, 8171.0, 19757.0, 30000.0],
        0.01,
        &[0.61, 0.0, 0.72, -0.48, 0.21, 0.0],
        &[0.61, 0.0, 0.33, 0.05, 0.0, 0.0],
    );
    own.friction = vec![0.1, 0.0, -0.17, 0.3, -0.1, 0.0];
    for (load, speed) in [(0.1, 1200.0), (0.3, 900.0)] {
        let model = Model::new(&own, &drive(), OperatingPoint { load, speed }).unwrap();
        for set in InstructionSet::available() {
            let kernel = ClosedModes::new(&model, 100, set).unwrap();
            assert_eq!(kernel.mixed.modes, [0, 2, 3, 4]);
            moves_as_volterra_does(&model, &kernel);
        }
    }
}

/// Dampers, gyroscopic terms and cross-coupled springs between all modes.
fn coupled(structure: ModalStructure) -> ModalStructure {
    let n = structure.modes();
    let entries = |size: f64, skew: f64| -> Vec<f64> {
        let entry = |i: usize, j: usize| {
            let [low, high] = [i.min(j), i.max(j)];
            let value = size * ((3 * low + 7 * high) as f64).sin() / (1.0 + (high - low) as f64);
            if i > j { skew * value } else { value }
        };
        let all = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        all.map(
            |(i, j)| {
                if skew < 0.0 && i == j { 0.0 } else { entry(i, j) }
            },
        )
        .collect()
    };
    let mut damping = entries(20.0, 1.0);
    for i in 0..n {
        damping[i * n + i] = 200.0;
    }
    ModalStructure {
        coupling: Some(Coupling {
            damping,
            gyroscopic: entries(0.1, -1.0),
            stiffness: entries(1e4, 0.5),
        }),
        ..structure
    }
}

#[test]
fn coupled_modes_move_as_volterra_moves_them() {
    for (load, speed) in [(0.1, 1200.0), (0.3, 900.0), (0.02, 2500.0)] {
        let point = OperatingPoint { load, speed };
        let model = Model::new(&coupled(structure()), &drive(), point).unwrap();
        let arrays = ClosedModes::arrays(&model).unwrap();
        let kernel = ClosedModes::from_kept(&model, 100, &arrays, InstructionSet::best()).unwrap();
        moves_as_volterra_does(&model, &kernel);
    }
}

/// Tables with shared memory for the sets that are reached.
struct Shared(Vec<TableArray>, SharedStorage);

impl KeptTables for Shared {
    fn numbers(&self, name: &str) -> Option<&[f64]> {
        self.0.numbers(name)
    }

    fn shared_storage(&self) -> Option<&SharedStorage> {
        Some(&self.1)
    }
}

/// Six contacts with two levels each have 729 sets. Their tables are computed on demand, once for two loads.
/// The bits do not depend on the motion that reaches them first.
#[test]
fn sets_of_many_contacts_are_made_when_they_are_met() {
    for couple in [false, true] {
        let mut own = structure();
        for (k, gap) in [2e-6, 5e-6, 8e-6, -1e-6].into_iter().enumerate() {
            let felt: Vec<f64> = (0..9)
                .map(|i| 0.4 * ((i * i + 5 * k) as f64).cos())
                .collect();
            let mut stop = StructureContact::stop(&felt, gap, 2e8);
            let mut stiffer = stop.law.stiffness[0];
            stiffer.1[0] = 3e8;
            stop.law.stiffness = vec![(0.3 + 0.1 * k as f64, stop.law.stiffness[0].1), stiffer];
            own.contacts.push(stop);
        }
        if couple {
            own = coupled(own);
        }
        let models = [0.1, 0.4].map(|load| {
            let point = OperatingPoint {
                load,
                speed: 1200.0,
            };
            Model::new(&own, &drive(), point).unwrap()
        });
        let shared = || {
            Shared(
                ClosedModes::arrays(&models[0]).unwrap(),
                SharedStorage::new(),
            )
        };
        let (one, other) = (shared(), shared());
        let set = InstructionSet::best();
        let moved = |model: &Model, tables: &Shared| {
            let kernel = ClosedModes::from_kept(model, 100, tables, set).unwrap();
            moves_as_volterra_does(model, &kernel);
            motion(&kernel, model, 6).0.state
        };
        let alone = [moved(&models[0], &one), moved(&models[1], &other)];
        assert_eq!(moved(&models[1], &one), alone[1]);
        assert_eq!(moved(&models[0], &other), alone[0]);
        let [reached, same] =
            [&one, &other].map(|tables| ReachedSets::stored_in(tables.shared_storage()).count());
        assert!(reached > 10 && reached < 200, "{reached}");
        assert_eq!(same, reached);
    }
}

/// Records the state of the first window.
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

/// A trajectory that is stopped and continued with another workspace has the same bits as an uninterrupted one.
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

/// Sums of rows with one, two and three significant groups of terms.
#[test]
fn series_are_sums_of_rows() {
    let rows: Vec<Row> = (0..37)
        .map(|i| {
            let ratio = [0.0, 1e-3, 0.05, 0.5, 0.9][i % 5];
            let term = |k: usize| (1.7 * (i * k) as f64).cos() * f64::powi(ratio, k as i32);
            Row(std::array::from_fn(term))
        })
        .collect();
    let weights: Vec<f64> = (0..40).map(|i| (0.3 * (i * i) as f64).sin()).collect();
    let series = Series::new(&rows);
    assert!(series.0.iter().all(|terms| !terms.places.is_empty()));
    for set in InstructionSet::available() {
        let mut out = Row::ZERO;
        lanes::series(set, &series.0, &weights, &mut out);
        for (k, found) in out.0.iter().enumerate() {
            let exact: f64 = rows.iter().zip(&weights).map(|(row, w)| row.0[k] * w).sum();
            assert!((found - exact).abs() < 1e-14, "{k}: {found} {exact}");
        }
    }
}
