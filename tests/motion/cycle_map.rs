//! The map of mesh cycles over many states: the bits of the kernel, for any further requests and any distribution of
//! the states.

#![allow(clippy::unwrap_used)]

use gearatlas::manifest::{self, Job};
use gearatlas::model::TrajectoryState;
use gearatlas::propagate::{Counters, Event, Kernel, Observer, Tangents, Volterra};
use gearatlas::store::TableStore;
use gearatlas::sweep::{CycleMap, MapConfig, MapImage, MapTangents, Prepared};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Mesh cycles of the map.
const CYCLES: u64 = 3;

fn job() -> Job {
    let text = include_str!("../../manifests/quickstart.toml");
    let text = text.replacen("[run]", "[run]\nkernel = \"volterra\"\n#", 1);
    manifest::parse(&text, "quickstart.toml", Path::new("")).unwrap()
}

/// The map of a rattling point, and states along its trajectory.
fn rattling(job: &Job) -> (CycleMap, Vec<f64>) {
    let folder = tempfile::tempdir().unwrap();
    let parts = Arc::new(Prepared::new(TableStore::open(folder.path())));
    let map = CycleMap::new(job.points.at(0), parts).unwrap();
    let mut states = Vec::new();
    let mut state = map.start();
    for _ in 0..17 {
        state = image(&map, &state, MapTangents::None, false, 40).states;
        states.extend_from_slice(&state);
    }
    (map, states)
}

fn image(
    map: &CycleMap,
    states: &[f64],
    tangents: MapTangents<'_>,
    events: bool,
    cycles: u64,
) -> MapImage {
    let config = MapConfig {
        states,
        first_cycle: 0,
        cycles,
        tangents,
        by: &[],
        events,
        threads: 1,
    };
    map.image(&config, &AtomicBool::new(false)).unwrap()
}

#[derive(Default)]
struct Log(Vec<Event>);

impl Observer for Log {
    const WINDOWS: bool = false;

    fn event(&mut self, event: &Event) {
        self.0.push(*event);
    }
}

/// The image of states by the kernel alone: states, matrices, events.
fn by_the_kernel(map: &CycleMap, states: &[f64]) -> (Vec<f64>, Vec<f64>, Vec<(usize, Event)>) {
    let model = map.model();
    let kernel = Volterra::new(model, f64::EPSILON, map.point().run.event_limit);
    let (n, mut workspace) = (map.dimension(), kernel.workspace());
    let (mut ends, mut matrices, mut events) = (Vec::new(), Vec::new(), Vec::new());
    for (row, state) in states.chunks_exact(n).enumerate() {
        let mut trajectory = TrajectoryState::new(model, state.to_vec(), 0);
        let mut tangents = Tangents::zeros(n / 2, n);
        (0..n).for_each(|i| tangents.vector_mut(i)[i] = 1.0);
        let (mut log, mut counters) = (Log::default(), Counters::default());
        for _ in 0..CYCLES {
            kernel
                .advance_cycle(
                    &mut trajectory,
                    &mut tangents,
                    &mut workspace,
                    &mut log,
                    &mut counters,
                )
                .unwrap();
        }
        ends.extend(trajectory.state);
        for i in 0..n {
            matrices.extend((0..n).map(|j| tangents.vector(j)[i]));
        }
        events.extend(log.0.into_iter().map(|event| (row, event)));
    }
    (ends, matrices, events)
}

#[test]
fn the_map_has_the_bits_of_the_kernel() {
    let job = job();
    let (map, states) = rattling(&job);
    let (ends, matrices, events) = by_the_kernel(&map, &states);
    assert!(events.len() > states.len() / map.dimension(), "it rattles");
    let plain = image(&map, &states, MapTangents::None, false, CYCLES);
    assert!(plain.stops.is_empty());
    assert_eq!(plain.states, ends);
    let all = image(&map, &states, MapTangents::Jacobian, true, CYCLES);
    assert_eq!((all.states, all.events), (ends, events));
    assert_eq!(all.tangents, matrices);
}

#[test]
fn states_may_be_dealt_out() {
    let job = job();
    let (map, states) = rattling(&job);
    let load = job.between.parameter(map.point(), "load").unwrap();
    let by = [map.derivative(&job, load, &[]).unwrap()];
    let question = |threads| MapConfig {
        states: &states,
        first_cycle: 0,
        cycles: CYCLES,
        tangents: MapTangents::Jacobian,
        by: &by,
        events: true,
        threads,
    };
    let flag = AtomicBool::new(false);
    let alone = map.image(&question(1), &flag).unwrap();
    assert_eq!(alone, map.image(&question(3), &flag).unwrap());
    assert_eq!(alone.states, by_the_kernel(&map, &states).0);
}

#[test]
fn what_cannot_be_integrated_is_said_of_its_state_alone() {
    let job = job();
    let (map, mut states) = rattling(&job);
    let n = map.dimension();
    states[2 * n..3 * n].fill(1e9);
    let found = image(&map, &states, MapTangents::Jacobian, false, 1);
    let stopped: Vec<usize> = found.stops.iter().map(|(row, _)| *row).collect();
    assert_eq!(stopped, [2]);
    let finite = |row: usize| {
        found.states[row * n..(row + 1) * n]
            .iter()
            .all(|x| x.is_finite())
    };
    assert!(found.states[2 * n..3 * n].iter().all(|x| x.is_nan()));
    assert!(
        found.tangents[2 * n * n..3 * n * n]
            .iter()
            .all(|x| x.is_nan())
    );
    assert!(finite(1) && finite(3));
}

#[test]
fn raising_the_flag_ends_it() {
    let job = job();
    let (map, states) = rattling(&job);
    let config = MapConfig {
        states: &states,
        first_cycle: 0,
        cycles: u64::MAX,
        tangents: MapTangents::None,
        by: &[],
        events: false,
        threads: 1,
    };
    let found = map.image(&config, &AtomicBool::new(true)).unwrap();
    assert_eq!(found.stops.len(), states.len() / map.dimension());
}
