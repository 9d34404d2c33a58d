//! Which chain comes next? The one with the longest expected time among the first waiting ones, so that no long chain
//! starts when the others have finished.
//!
//! Before a point is computed, its motion is unknown (chaos takes five times as long as settled motion), but neighbours
//! are a good guess. The expected time is the requested work times the mean time per work of the finished neighbours.
//! Without finished neighbours, the mean is over all finished chains. The order does not affect results: they depend on
//! the chain alone.
//!
//! On a machine with several NUMA nodes whose workers have separate kernel tables, chains whose tables the node used
//! most recently come first. Then follow chains whose tables have this node as home, then others. The longest is chosen
//! among the nearest.
//!
//! Only a window of chains is in memory, for any number of chains.

use super::chain_tasks::{ChainSelection, ChainTask, FinishedChains};
use super::parts::table_number;
use super::shared::lock;
use crate::manifest::{Job, Variant};
use crate::propagate::{MOST_MODES, Seat, work_side_by_side};
use crate::topology::{NodeTables, TableDistance};
use std::cmp::Reverse;
use std::collections::{BTreeMap, VecDeque};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, Instant};

/// Number of rows that may wait in memory for the oldest unfinished point; at least one chain per worker.
const AHEAD: usize = 4096;

/// Number of chains per worker among which the longest is chosen. It is limited because the rows of a chain that starts
/// early wait in memory until those before it are written.
const CANDIDATES_PER_WORKER: usize = 16;

/// Longest row of the grid, in chains, whose computing times predict those of the next row. The limit bounds the memory
/// for these times.
const LONGEST_ROW: usize = 16_384;

/// Number of modes whose work equals the fixed work of integrating a cycle (docs/measured.md).
const FIXED_WORK: f64 = 40.0;

/// Number of chains that may start early.
pub(super) fn most_candidates(workers: usize) -> usize {
    CANDIDATES_PER_WORKER * workers
}

/// Rows that may wait in memory for the oldest unfinished point, for `workers` workers on chains of this length.
fn ahead(workers: usize, length: usize) -> usize {
    AHEAD.max(workers * length)
}

/// Distributes chains to workers.
pub(super) struct Queue<'a> {
    job: &'a Job,
    selection: ChainSelection,
    /// Points of a chain.
    length: usize,
    /// Distance between neighbours along the second fastest axis, in chains; 0 if it is irregular or large.
    row: usize,
    /// Number of chains that may start early.
    most_candidates: usize,
    ahead: u64,
    state: Mutex<QueueState>,
}

/// The state that changes as chains are distributed.
struct QueueState {
    finished: FinishedChains,
    /// The first place that has not entered the window.
    next: usize,
    /// Number of chains that have entered the window.
    entered: usize,
    /// Chains that may be next, by place.
    window: VecDeque<Candidate>,
    /// Mean time per work of finished neighbours, for places beyond the window.
    near: BTreeMap<usize, Mean>,
    /// Mean time per work of all finished chains.
    all: Mean,
    /// The tables of each node; without nodes if all workers read the same tables.
    node_tables: NodeTables,
}

/// A chain that may be next.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    place: usize,
    /// Number of chains that entered the window before it.
    number: usize,
    /// Remaining work ([`work`]).
    work: f64,
    /// The table that it reads, if nodes have separate tables.
    table: Option<u64>,
    /// Mean time per work of finished neighbours.
    near: Mean,
}

/// A running mean.
#[derive(Debug, Clone, Copy, Default)]
struct Mean {
    sum: f64,
    count: u32,
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1;
    }

    fn value(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / f64::from(self.count))
    }
}

/// The next action of a worker.
#[derive(Debug)]
enum NextAction {
    /// Compute this chain, or its remaining points, of this [`work`].
    Chain { turn: ChainTask, work: f64 },
    /// Ask again later: too many rows wait for older points.
    Wait,
    /// No chain is left.
    End,
}

impl<'a> Queue<'a> {
    /// A queue of the chains of a selection that an earlier run has not finished. The job has `shards`
    /// shards. `nodes` is the number of NUMA nodes whose workers have separate tables.
    pub(super) fn new(
        job: &'a Job,
        selection: ChainSelection,
        finished: FinishedChains,
        shards: usize,
        workers: usize,
        nodes: usize,
    ) -> Self {
        let length = job.chain_length();
        let row = row(job);
        // The numbers of a refined grid's points do not show which points are neighbours.
        let regular =
            job.refine.is_none() && row.is_multiple_of(shards) && row / shards <= LONGEST_ROW;
        let state = QueueState {
            finished,
            next: 0,
            entered: 0,
            window: VecDeque::new(),
            near: BTreeMap::new(),
            all: Mean::default(),
            node_tables: NodeTables::new(nodes),
        };
        Self {
            job,
            selection,
            length,
            row: if regular { row / shards } else { 0 },
            most_candidates: most_candidates(workers),
            ahead: ahead(workers, length) as u64,
            state: Mutex::new(state),
        }
    }

    fn state(&self) -> MutexGuard<'_, QueueState> {
        lock(&self.state)
    }

    /// Remaining work of the chain at a place.
    fn work(&self, state: &QueueState, place: usize) -> f64 {
        let end = (place + 1) * self.length;
        let left = state.finished.left(&self.selection, place);
        (end - left..end)
            .map(|n| work(self.job.points.variant_near(self.selection.id(n))))
            .sum()
    }

    /// The table that the chain at a place reads first, if nodes have separate tables.
    fn table(&self, state: &QueueState, place: usize) -> Option<u64> {
        let first = || self.job.points.at(self.selection.id(place * self.length));
        (state.node_tables.nodes() > 0).then(|| table_number(&first()))?
    }

    /// Adds chains to the window until it has its full length.
    fn fill(&self, state: &mut QueueState) {
        while state.next < self.selection.chains() {
            let oldest = state.window.front().map_or(state.entered, |c| c.number);
            if state.entered >= oldest + self.most_candidates {
                return;
            }
            let place = state.next;
            state.next += 1;
            let near = state.near.remove(&place).unwrap_or_default();
            if state.finished.has(&self.selection, place) {
                continue;
            }
            let candidate = Candidate {
                place,
                number: state.entered,
                work: self.work(state, place),
                table: self.table(state, place),
                near,
            };
            state.entered += 1;
            state.window.push_back(candidate);
        }
    }

    /// The next chain for a worker, when `written` points have left the writer's memory. `node` is the node
    /// of the worker if nodes have separate tables. The oldest chain can always be taken once all chains
    /// before it are written.
    fn next(&self, written: u64, node: Option<usize>) -> NextAction {
        let mut state = self.state();
        self.fill(&mut state);
        if state.window.is_empty() {
            return NextAction::End;
        }
        let typical = state.all.value().unwrap_or(1.0);
        let mut best: Option<(Reverse<TableDistance>, f64, usize)> = None;
        for (at, candidate) in state.window.iter().enumerate() {
            if (candidate.place * self.length) as u64 >= written + self.ahead {
                break;
            }
            let expected = candidate.work * candidate.near.value().unwrap_or(typical);
            let distance = node.map_or(TableDistance::AtHand, |node| {
                state.node_tables.distance(candidate.table, node)
            });
            let distance = Reverse(distance);
            if best.is_none_or(|(nearest, most, _)| (distance, expected) > (nearest, most)) {
                best = Some((distance, expected, at));
            }
        }
        let Some(candidate) = best.and_then(|(.., at)| state.window.remove(at)) else {
            return NextAction::Wait;
        };
        if let Some(node) = node {
            state.node_tables.take(candidate.table, node);
        }
        NextAction::Chain {
            turn: state.finished.turn(&self.selection, candidate.place),
            work: candidate.work,
        }
    }

    /// Makes a worker compute chains until none is left, the run is interrupted, or `compute` stops. Chains of points
    /// with few modes are computed side by side. `written` and `node` are those of [`next`](Self::next). `pause` waits
    /// while too many rows wait for older points.
    pub(super) fn serve(
        &self,
        written: impl Fn() -> u64,
        pause: impl Fn(),
        node: Option<usize>,
        interrupt: &AtomicBool,
        compute: impl Fn(ChainTask, Option<&Seat<'_>>) -> Option<()>,
    ) {
        let serve = |seat: Option<&Seat<'_>>| {
            while !interrupt.load(Ordering::Relaxed) {
                match self.next(written(), node) {
                    NextAction::Chain { turn, work } => {
                        let (place, clock) = (turn.place, Instant::now());
                        if compute(turn, seat).is_none() {
                            return;
                        }
                        self.finished(place, work, clock.elapsed());
                    }
                    NextAction::Wait => seat.map_or_else(&pause, Seat::pause),
                    NextAction::End => return,
                }
            }
        };
        if !(self.has_few_modes() && work_side_by_side(&|seat| serve(Some(seat)), &pause)) {
            serve(None);
        }
    }

    /// Whether the structure of the first point has few modes.
    fn has_few_modes(&self) -> bool {
        self.job.points.variant_near(0).model.retained <= MOST_MODES
    }

    /// Records the time of the chain at a place as an estimate for its neighbours.
    fn finished(&self, place: usize, work: f64, time: Duration) {
        let ratio = time.as_secs_f64() / work;
        let mut state = self.state();
        state.all.add(ratio);
        for step in [1, self.row] {
            let neighbours = [place.checked_sub(step), place.checked_add(step)];
            for place in neighbours.into_iter().flatten().filter(|_| step > 0) {
                if place >= self.selection.chains() {
                    continue;
                }
                if place >= state.next {
                    state.near.entry(place).or_default().add(ratio);
                } else if let Ok(at) = state.window.binary_search_by_key(&place, |c| c.place) {
                    state.window[at].near.add(ratio);
                }
            }
        }
    }
}

/// Distance in chains along the second fastest dimension of chains.
fn row(job: &Job) -> usize {
    let carried = job.carried.as_ref();
    let fastest = (job.dimensions.iter().rev())
        .find(|dimension| carried.is_none_or(|carried| !dimension.axes.contains(&carried.axis)))
        .map_or(1, |dimension| dimension.length);
    fastest * carried.map_or(1, |carried| carried.directions.len())
}

/// Work of a point: the largest number of cycles of its trajectory, probes and cells, times the modes plus
/// [`FIXED_WORK`].
pub(super) fn work(point: &Variant) -> f64 {
    let run = &point.run;
    let mut cycles = (run.transient + run.cycles) as f64;
    if let Some(config) = &point.analyses.multistability {
        let side = config.slice.map_or(0.0, |slice| f64::from(slice.count));
        let trajectories = f64::from(config.initial_conditions) + side * side;
        cycles += trajectories * (config.transient + config.cycles) as f64;
    }
    cycles.max(1.0) * (FIXED_WORK + point.model.retained as f64)
}

#[cfg(test)]
mod interleavings;
#[cfg(test)]
mod tests;
