use super::batch::{Batch, CycleTask};
use super::*;
use crate::model::{Drive, InitialState, Model, OperatingPoint, fixtures};
use crate::propagate::{ClosedModes, Counters, Event, InstructionSet, Kernel, Observer, Tangents};
use crate::structure::{ModalStructure, StructureContact};
use std::cell::{Cell, RefCell};

/// Cycles of each point.
const CYCLES: u64 = 60;

/// A drive of 1 to 3 modes with two flanks, with or without a stop, at various speeds and loads.
fn model(number: usize) -> Model {
    let modes = 1 + number % 3;
    let frequency = [0.0, 4288.0, 8171.0];
    let mesh = [0.61, 0.72, -0.48];
    let torque = [0.61, 0.33, 0.05];
    let mut structure: ModalStructure =
        fixtures::structure(&frequency[..modes], 0.02, &mesh[..modes], &torque[..modes]);
    if number % 4 == 3 {
        let along: Vec<f64> = mesh[..modes].iter().map(|w| 0.7 * w).collect();
        structure.contacts = vec![StructureContact::stop(&along, 2e-5, 3e7)];
    }
    let drive = Drive {
        damping: [1483.0, 0.0][number % 2],
        ..fixtures::two_level_mesh(1e-5)
    };
    let point = OperatingPoint {
        load: 0.02 + 0.01 * (number % 17) as f64,
        speed: 700.0 + 90.0 * (number % 13) as f64,
    };
    Model::new(&structure, &drive, point).unwrap()
}

/// Largest difference of two states relative to `size`, for velocities relative to `1e4 size`.
fn difference(a: &[f64], b: &[f64], size: f64) -> f64 {
    let of_modes = a.len() / 2;
    (a.iter().zip(b).enumerate())
        .map(|(i, (a, b))| (a - b).abs() / if i < of_modes { size } else { 1e4 * size })
        .fold(0.0, f64::max)
}

#[derive(Default)]
struct Events(Vec<Event>);

impl Observer for Events {
    const WINDOWS: bool = false;

    fn event(&mut self, event: &Event) {
        self.0.push(*event);
    }
}

/// The states of a point after every cycle, integrated beside others. Also the numbers of its cycles, of the
/// cycles that were integrated alone, and of its events.
fn follow(number: usize, seat: &Seat<'_>, check: bool) -> (Vec<Vec<f64>>, [u64; 3]) {
    let model = model(number);
    let kernel = ClosedModes::new(&model, 1000, InstructionSet::best()).unwrap();
    let beside = SideBySide::new(&kernel, Some(seat));
    let mut workspaces = (beside.workspace(), kernel.workspace());
    let mut trajectory = model.start(&InitialState::Static);
    trajectory.state[0] += 1e-5;
    let mut tangents = Tangents::zeros(model.modes(), 1 + number % 2);
    for i in 0..tangents.count() {
        tangents.vector_mut(i)[i] = 1e-6;
    }
    let mut states = Vec::new();
    let (mut counters, mut alone) = (Counters::default(), 0);
    for _ in 0..CYCLES {
        let windows = counters.windows;
        let (mut one, mut his) = (trajectory.clone(), tangents.clone());
        let (mut seen, mut known) = (Events::default(), Events::default());
        (beside.advance_cycle(
            &mut trajectory,
            &mut tangents,
            &mut workspaces.0,
            &mut seen,
            &mut counters,
        ))
        .unwrap();
        if check {
            let mut uncounted = Counters::default();
            (kernel.advance_cycle(
                &mut one,
                &mut his,
                &mut workspaces.1,
                &mut known,
                &mut uncounted,
            ))
            .unwrap();
            assert_eq!(
                (one.contact, one.cycle),
                (trajectory.contact, trajectory.cycle)
            );
            assert_eq!(seen.0.len(), known.0.len(), "point {number}");
            for (a, b) in seen.0.iter().zip(&known.0) {
                assert_eq!(
                    (a.cycle, a.from, a.to, a.contact),
                    (b.cycle, b.from, b.to, b.contact)
                );
                assert!(
                    (a.time - b.time).abs() < 1e-11 * model.period(),
                    "{a:?} {b:?}"
                );
                assert!(
                    (a.rate - b.rate).abs() < 1e-9 * (b.rate.abs() + 1e-3),
                    "{a:?} {b:?}"
                );
            }
            let off = difference(&one.state, &trajectory.state, model.half_gap);
            assert!(off < 1e-11, "point {number}, cycle {}: {off:e}", one.cycle);
            for i in 0..his.count() {
                let size = his.vector(i)[..model.modes()]
                    .iter()
                    .fold(0.0, |most: f64, x| most.max(x.abs()));
                let off = difference(his.vector(i), tangents.vector(i), size);
                assert!(off < 1e-9, "point {number}: {off:e}");
            }
        }
        // Lanes do not count windows.
        alone += u64::from(counters.windows > windows);
        states.push(trajectory.state.clone());
    }
    (states, [counters.cycles, alone, counters.events])
}

/// Follows points on eight stacks.
fn follow_all(points: &[usize], check: bool) -> (Vec<Vec<Vec<f64>>>, [u64; 3]) {
    let results = RefCell::new(vec![Vec::new(); points.len()]);
    let (next, sums) = (Cell::new(0), Cell::new([0; 3]));
    let work = |seat: &Seat<'_>| {
        while next.get() < points.len() {
            let place = next.replace(next.get() + 1);
            let (states, counts) = follow(points[place], seat, check);
            results.borrow_mut()[place] = states;
            sums.set(std::array::from_fn(|i| sums.get()[i] + counts[i]));
        }
    };
    assert!(work_side_by_side(&work, &|| panic!("nobody pauses")));
    (results.into_inner(), sums.get())
}

/// Every cycle in a lane has the same events, states and tangents as with the kernel alone.
#[test]
fn cycles_are_those_of_a_point_alone() {
    let points: Vec<usize> = (0..60).collect();
    let (_, [cycles, alone, events]) = follow_all(&points, true);
    assert_eq!(cycles, 60 * CYCLES);
    assert!(
        events > cycles && 20 * alone < cycles,
        "{alone} of {cycles} alone"
    );
}

/// The results of a point have the same bits alone and beside any other points.
#[test]
fn neighbours_do_not_matter() {
    let points: Vec<usize> = (0..24).collect();
    let reversed: Vec<usize> = points.iter().rev().copied().collect();
    let (all, _) = follow_all(&points, false);
    let (mut again, _) = follow_all(&reversed, false);
    again.reverse();
    assert!(all == again);
    for number in [0, 5, 11] {
        let (alone, _) = follow_all(&[number], false);
        assert!(alone[0] == all[number], "{number}");
    }
}

/// The lanes of every instruction set advance states and tangents alike.
#[test]
fn instruction_sets_agree() {
    let models: Vec<Model> = (0..9).map(model).collect();
    for model in &models {
        let kernel = ClosedModes::new(model, 1000, InstructionSet::PORTABLE).unwrap();
        let tables = kernel.point_tables().unwrap();
        let advanced = InstructionSet::available().into_iter().map(|set| {
            let mut batch = Batch::new(tables.shape, set);
            let mut task = Box::new(CycleTask::new(tables.clone()));
            task.trajectory = model.start(&InitialState::Static);
            task.trajectory.state[0] += 1e-5;
            task.tangents = Tangents::zeros(model.modes(), 1);
            task.tangents.vector_mut(0)[0] = model.half_gap;
            for _ in 0..5 {
                assert!(batch.begin(0, task).is_none());
                let mut finished = None;
                while finished.is_none() {
                    batch.advance(&mut |_, task| finished = Some(task));
                }
                task = finished.unwrap();
                assert!(task.done);
            }
            (task.trajectory.state, task.tangents)
        });
        let advanced: Vec<_> = advanced.collect();
        for (state, tangents) in &advanced {
            let off = difference(state, &advanced[0].0, model.half_gap);
            let tangents_off =
                difference(tangents.vector(0), advanced[0].1.vector(0), model.half_gap);
            assert!(
                off < 1e-11 && tangents_off < 1e-9,
                "{off:e} {tangents_off:e}"
            );
        }
    }
}

/// A member that pauses lets the others work. It goes on when they have finished, or between their cycles.
#[test]
fn a_pause_ends() {
    let (working, pauses) = (Cell::new(0), Cell::new(0));
    let work = |seat: &Seat<'_>| {
        let mine = working.replace(working.get() + 1);
        while mine == 0 && working.get() < 8 {
            seat.pause();
        }
    };
    assert!(work_side_by_side(&work, &|| pauses.set(pauses.get() + 1)));
    assert_eq!((working.get(), pauses.get()), (8, 1));
}

/// Items are mapped in order, with a kernel of few modes and with one of many.
#[test]
fn items_are_mapped_in_order() {
    let few = model(1);
    let many = {
        let structure = fixtures::structure(&[0.0, 4e3, 5e3, 6e3], 0.02, &[0.6; 4], &[0.6; 4]);
        let drive = fixtures::two_level_mesh(1e-5);
        Model::new(&structure, &drive, fixtures::strong_rattle()).unwrap()
    };
    for (model, has_tables) in [(&few, true), (&many, false)] {
        let kernel = ClosedModes::new(model, 1000, InstructionSet::best()).unwrap();
        assert_eq!(kernel.point_tables().is_some(), has_tables);
        let items: Vec<u32> = (0..100).collect();
        fn end<K: Kernel>(model: &Model, kernel: &K, item: u32) -> Vec<f64> {
            let mut trajectory = model.start(&InitialState::Static);
            trajectory.state[0] += 1e-7 * f64::from(item);
            let (mut workspace, mut counters) = (kernel.workspace(), Counters::default());
            (kernel.advance(3, &mut trajectory, &mut workspace, &mut (), &mut counters)).unwrap();
            trajectory.state
        }
        let mapped = map_side_by_side(&kernel, &items, |kernel, &item| end(model, kernel, item));
        assert_eq!(mapped.len(), items.len());
        for (item, state) in items.iter().zip(&mapped) {
            let off = difference(state, &end(model, &kernel, *item), model.half_gap);
            assert!(off < 1e-10, "{item}: {off:e}");
        }
    }
}
