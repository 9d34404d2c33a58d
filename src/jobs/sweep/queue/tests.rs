//! Are chains taken in the right order: long ones first, within a bounded window?

use super::*;
use crate::manifest;
use std::collections::BTreeSet;
use std::path::Path;

/// A job of independent points of equal work: `loads` rows of `speeds` points.
pub(super) fn job(loads: usize, speeds: usize) -> Job {
    let text = include_str!("../../../../tests/data/oscillator.toml")
        .replace("to = 0.3, count = 2", &format!("to = 0.3, count = {loads}"))
        .replace(
            "to = 1500, count = 3",
            &format!("to = 1500, count = {speeds}"),
        );
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data");
    let job = manifest::parse(&text, "m.toml", &data).unwrap();
    assert_eq!(job.points.len(), loads * speeds);
    job
}

fn queue<'a>(job: &'a Job, most_candidates: usize, ahead: u64) -> Queue<'a> {
    let selection = ChainSelection::of_shard(job, None);
    let finished = FinishedChains::default();
    let mut queue = Queue::new(job, selection, finished, 1, 1, 0);
    (queue.most_candidates, queue.ahead) = (most_candidates, ahead);
    queue
}

fn taken(queue: &Queue<'_>, written: u64) -> usize {
    match queue.next(written, None) {
        NextAction::Chain { turn, .. } => turn.place,
        other => panic!("{other:?}"),
    }
}

/// Records a time for a chain of unit work.
fn finish(queue: &Queue<'_>, place: usize, seconds: u64) {
    queue.finished(place, 1.0, Duration::from_secs(seconds));
}

#[test]
fn neighbours_of_long_chains_come_first_and_of_short_ones_last() {
    let job = job(3, 4);
    let queue = queue(&job, 12, 100);
    assert_eq!(taken(&queue, 0), 0, "in order where nothing is known");
    finish(&queue, 0, 1);
    // 1 and 4 are neighbours of 0; all others take its time as the mean.
    assert_eq!(taken(&queue, 0), 1);
    finish(&queue, 1, 9);
    // The mean is 5; neighbours of 1 are 2 and 5 (9), and 4 is a neighbour of 0 (1).
    let order: Vec<usize> = (0..10).map(|_| taken(&queue, 0)).collect();
    assert_eq!(order, [2, 5, 3, 6, 7, 8, 9, 10, 11, 4]);
    assert!(matches!(queue.next(0, None), NextAction::End));
}

#[test]
fn what_waits_in_memory_is_bounded() {
    let job = job(2, 10);
    let queue = queue(&job, 3, 4);
    taken(&queue, 0);
    assert_eq!(
        [taken(&queue, 0), taken(&queue, 0), taken(&queue, 0)],
        [1, 2, 3]
    );
    assert!(
        matches!(queue.next(0, None), NextAction::Wait),
        "point 0 is not written yet"
    );
    assert_eq!(taken(&queue, 1), 4);
    // Only three chains from the oldest waiting one are candidates, even if the fourth is much longer.
    for (place, ratio) in [(9, 100.0), (7, 10.0)] {
        queue.state().near.entry(place).or_default().add(ratio);
    }
    assert_eq!(taken(&queue, 5), 7);
    assert_eq!([taken(&queue, 5), taken(&queue, 5)], [5, 6]);
    assert_eq!(taken(&queue, 6), 9);
}

/// Times of neighbours outside the window are kept, and the window does not grow with the grid.
#[test]
fn only_the_window_is_in_memory() {
    let job = job(100, 1000);
    let queue = queue(&job, 4, 1_000_000);
    finish(&queue, 5, 9);
    finish(&queue, 0, 1);
    let order: Vec<usize> = (0..6).map(|_| taken(&queue, 0)).collect();
    assert_eq!(
        order,
        [0, 4, 2, 3, 1, 6],
        "4 and 6 lie beside 5, 1 beside 0"
    );
    for place in 0..5000 {
        taken(&queue, 0);
        finish(&queue, place, 5);
    }
    let state = queue.state();
    assert!(state.window.len() <= 4, "{}", state.window.len());
    assert!(state.near.len() <= 1001, "{}", state.near.len());
}

/// Result of a simulated run of workers on nodes, with a simulated clock: copies and steals of tables, the order of
/// chains, and the end of the last one.
struct Simulated {
    copies: usize,
    steals: u64,
    order: Vec<usize>,
    end: f64,
}

/// Simulates a run: each chain takes some time, plus a fixed time for a table that the node does not have in memory.
fn simulate(job: &Job, nodes: usize, workers: usize, near: bool) -> Simulated {
    const FETCH: f64 = 1.0;
    let selection = ChainSelection::of_shard(job, None);
    let queue = Queue::new(job, selection, FinishedChains::default(), 1, workers, nodes);
    let mut node_tables = NodeTables::new(nodes);
    let mut free: Vec<f64> = vec![0.0; workers];
    let mut simulated = Simulated {
        copies: 0,
        steals: 0,
        order: Vec::new(),
        end: 0.0,
    };
    loop {
        // The worker that is free first; of several, the one with the lowest number.
        let earliest = |best: usize, worker: usize| {
            if free[worker] < free[best] { worker } else { best }
        };
        let worker = (1..workers).fold(0, earliest);
        let node = worker * nodes / workers;
        let NextAction::Chain { turn, .. } = queue.next(1_000_000, near.then_some(node)) else {
            break;
        };
        let table = table_number(&job.points.at(turn.first));
        let fetched = node_tables.distance(table, node) != TableDistance::AtHand;
        node_tables.take(table, node);
        simulated.copies += usize::from(fetched);
        // Times of chains differ by a factor of three, in a fixed pattern over their places.
        let time = 1.0 + (turn.place * 7 % 5) as f64 / 2.0;
        free[worker] += time + f64::from(u8::from(fetched)) * FETCH;
        simulated.end = simulated.end.max(free[worker]);
        simulated.order.push(turn.place);
        queue.finished(turn.place, 1.0, Duration::from_secs_f64(time));
    }
    simulated.steals = node_tables.steals();
    simulated
}

/// Two sockets, four nodes, and a package divided into eight: every chain is computed once, few tables are copied to
/// other nodes than their home, and no worker waits long at the end.
#[test]
fn workers_keep_to_the_tables_of_their_node() {
    let text = include_str!("../../../../tests/data/oscillator.toml")
        .replace("to = 0.3, count = 2", "to = 0.3, count = 12")
        .replace(
            "speed = { from = 600, to = 1500, count = 3 }",
            "speed = 1200\n\"mesh.mean_stiffness\" = { from = \"4e8 N/m\", to = \"5e8 N/m\", count = 24 }",
        )
        .replace("[run]", "[run]\nkernel = \"closed_modes\"");
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data");
    let job = manifest::parse(&text, "m.toml", &data).unwrap();
    let numbers: BTreeSet<_> = (0..288)
        .map(|id| table_number(&job.points.at(id)))
        .collect();
    assert_eq!(numbers.len(), 24, "a table a mesh");
    for (nodes, workers) in [(2, 8), (4, 8), (8, 16)] {
        let [near, far] = [true, false].map(|near| simulate(&job, nodes, workers, near));
        for simulated in [&near, &far] {
            let mut all = simulated.order.clone();
            all.sort_unstable();
            assert_eq!(all, (0..288).collect::<Vec<_>>());
        }
        println!(
            "{nodes} nodes: {} copies, {} stolen, end {}; without: {}, {}, {}",
            near.copies, near.steals, near.end, far.copies, far.steals, far.end
        );
        assert!(2 * near.copies < far.copies && 2 * near.steals < far.steals);
        assert!(near.end <= far.end, "{} {}", near.end, far.end);
    }
    let alone = simulate(&job, 1, 4, true);
    assert_eq!(alone.steals, 0, "one node has nobody to steal from");
}
