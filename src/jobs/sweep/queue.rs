//! Which chain comes next? The one with the longest expected time among the first waiting ones, so that no long chain
//! starts when the others have finished.
//!
//! Before a point is computed, its motion is unknown (chaos takes five times as long as settled motion), but neighbours
//! are a good guess. The expected time is the requested work times the mean time per work of the finished neighbours.
//! Without finished neighbours, the mean is over all finished chains. The order does not affect results: they depend on
//! the chain alone.
//!
//! On a machine with several NUMA nodes whose workers have separate kernel tables, chains with tables at hand come
//! first. Then follow chains whose tables have this node as home, then others. The longest is chosen among the nearest.
//!
//! Only a window of chains is in memory, for any number of chains.

use super::parts::table_number;
use super::turns::{ChainTask, Share, TakenOver};
use crate::manifest::{Job, Variant};
use crate::topology::{Nearness, Shelves};
use std::cmp::Reverse;
use std::collections::{BTreeMap, VecDeque};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Number of rows that may wait in memory for the oldest unfinished point; at least one chain per worker.
const AHEAD: usize = 4096;

/// Number of chains per worker among which the longest is chosen. It is limited because the rows of a chain that starts
/// early wait in memory until those before it are written.
const LOOK: usize = 16;

/// Longest row of the grid for which times are passed on to the next row: times for chains beyond the window are
/// stored.
const LONGEST_ROW: usize = 16_384;

/// Number of modes whose work equals the fixed work of integrating a cycle (docs/measured.md).
const FIXED_WORK: f64 = 40.0;

/// Number of chains that may start early.
pub(super) fn look(workers: usize) -> usize {
    LOOK * workers
}

/// Rows that may wait in memory for the oldest unfinished point, for `workers` workers on chains of this length.
fn ahead(workers: usize, length: usize) -> usize {
    AHEAD.max(workers * length)
}

/// Distributes chains to workers.
pub(super) struct Queue<'a> {
    job: &'a Job,
    share: Share,
    /// Points of a chain.
    length: usize,
    /// Distance between neighbours along the second fastest axis, in chains; 0 if it is irregular or large.
    row: usize,
    look: usize,
    ahead: u64,
    known: Mutex<Known>,
}

/// The state that changes as chains are distributed.
struct Known {
    taken_over: TakenOver,
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
    shelves: Shelves,
}

/// A chain that may be next.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    place: usize,
    /// Number of chains that entered the window before it.
    number: usize,
    /// Cycles times modes.
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
enum Next {
    /// Compute this chain, or its remaining points; `work` is in cycles times modes.
    Chain { turn: ChainTask, work: f64 },
    /// Ask again later: too many rows wait for older points.
    Wait,
    /// No chain is left.
    End,
}

impl<'a> Queue<'a> {
    /// A queue of the chains that an earlier run has left of a share. The job has `shards` shards; workers run on nodes
    /// with separate tables.
    pub(super) fn new(
        job: &'a Job,
        share: Share,
        taken_over: TakenOver,
        shards: usize,
        workers: usize,
        nodes: usize,
    ) -> Self {
        let length = job.chain_length();
        let row = row(job);
        // The numbers of a refined grid's points do not show which points are neighbours.
        let regular =
            job.refine.is_none() && row.is_multiple_of(shards) && row / shards <= LONGEST_ROW;
        let known = Known {
            taken_over,
            next: 0,
            entered: 0,
            window: VecDeque::new(),
            near: BTreeMap::new(),
            all: Mean::default(),
            shelves: Shelves::new(nodes),
        };
        Self {
            job,
            share,
            length,
            row: if regular { row / shards } else { 0 },
            look: look(workers),
            ahead: ahead(workers, length) as u64,
            known: Mutex::new(known),
        }
    }

    fn known(&self) -> MutexGuard<'_, Known> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Remaining work of the chain at a place.
    fn work(&self, known: &Known, place: usize) -> f64 {
        let end = (place + 1) * self.length;
        let left = known.taken_over.left(&self.share, place);
        (end - left..end)
            .map(|n| work(self.job.points.variant_near(self.share.id(n))))
            .sum()
    }

    /// The table that the chain at a place reads first, if nodes have separate tables.
    fn table(&self, known: &Known, place: usize) -> Option<u64> {
        let first = || self.job.points.at(self.share.id(place * self.length));
        (known.shelves.nodes() > 0).then(|| table_number(&first()))?
    }

    /// Adds chains to the window until it has its full length.
    fn fill(&self, known: &mut Known) {
        while known.next < self.share.chains() {
            let oldest = known.window.front().map_or(known.entered, |c| c.number);
            if known.entered >= oldest + self.look {
                return;
            }
            let place = known.next;
            known.next += 1;
            let near = known.near.remove(&place).unwrap_or_default();
            if known.taken_over.has(&self.share, place) {
                continue;
            }
            let candidate = Candidate {
                place,
                number: known.entered,
                work: self.work(known, place),
                table: self.table(known, place),
                near,
            };
            known.entered += 1;
            known.window.push_back(candidate);
        }
    }

    /// The next chain for a worker of a node with separate tables, when `written` points have left the writer's memory.
    /// The oldest chain can always be taken once all chains before it are written.
    fn next(&self, written: u64, node: Option<usize>) -> Next {
        let mut known = self.known();
        self.fill(&mut known);
        if known.window.is_empty() {
            return Next::End;
        }
        let typical = known.all.value().unwrap_or(1.0);
        let mut best: Option<(Reverse<Nearness>, f64, usize)> = None;
        for (at, candidate) in known.window.iter().enumerate() {
            if (candidate.place * self.length) as u64 >= written + self.ahead {
                break;
            }
            let expected = candidate.work * candidate.near.value().unwrap_or(typical);
            let nearness = node.map_or(Nearness::AtHand, |node| {
                known.shelves.nearness(candidate.table, node)
            });
            let nearness = Reverse(nearness);
            if best.is_none_or(|(nearest, most, _)| (nearness, expected) > (nearest, most)) {
                best = Some((nearness, expected, at));
            }
        }
        let Some(candidate) = best.and_then(|(.., at)| known.window.remove(at)) else {
            return Next::Wait;
        };
        if let Some(node) = node {
            known.shelves.take(candidate.table, node);
        }
        Next::Chain {
            turn: known.taken_over.turn(&self.share, candidate.place),
            work: candidate.work,
        }
    }

    /// Makes a worker compute chains until none is left, the run is interrupted, or `compute` stops. `written` is the
    /// number of points that have left the writer's memory. `pause` waits while too many rows wait for older points.
    pub(super) fn serve(
        &self,
        written: impl Fn() -> u64,
        pause: impl Fn(),
        node: Option<usize>,
        called_off: &AtomicBool,
        mut compute: impl FnMut(ChainTask) -> Option<()>,
    ) {
        while !called_off.load(Ordering::Relaxed) {
            match self.next(written(), node) {
                Next::Chain { turn, work } => {
                    let (place, clock) = (turn.place, Instant::now());
                    if compute(turn).is_none() {
                        return;
                    }
                    self.finished(place, work, clock.elapsed());
                }
                Next::Wait => pause(),
                Next::End => return,
            }
        }
    }

    /// Records the time of the chain at a place as an estimate for its neighbours.
    fn finished(&self, place: usize, work: f64, time: Duration) {
        let ratio = time.as_secs_f64() / work;
        let mut known = self.known();
        known.all.add(ratio);
        for step in [1, self.row] {
            let beside = [place.checked_sub(step), place.checked_add(step)];
            for place in beside.into_iter().flatten().filter(|_| step > 0) {
                if place >= self.share.chains() {
                    continue;
                }
                if place >= known.next {
                    known.near.entry(place).or_default().add(ratio);
                } else if let Ok(at) = known.window.binary_search_by_key(&place, |c| c.place) {
                    known.window[at].near.add(ratio);
                }
            }
        }
    }
}

/// Distance in chains along the second fastest dimension of chains.
fn row(job: &Job) -> usize {
    let carried = job.carried.as_ref();
    let fastest = (job.dimensions.iter().rev())
        .find(|own| carried.is_none_or(|carried| !own.axes.contains(&carried.axis)))
        .map_or(1, |own| own.length);
    fastest * carried.map_or(1, |carried| carried.directions.len())
}

/// Largest number of cycles that a point may integrate, times the work per cycle.
pub(super) fn work(point: &Variant) -> f64 {
    let run = &point.run;
    let mut cycles = (run.transient + run.cycles) as f64;
    if let Some(asked) = &point.analyses.multistability {
        let side = asked.slice.map_or(0.0, |slice| f64::from(slice.count));
        let trajectories = f64::from(asked.initial_conditions) + side * side;
        cycles += trajectories * (asked.transient + asked.cycles) as f64;
    }
    cycles.max(1.0) * (FIXED_WORK + point.model.retained as f64)
}

#[cfg(test)]
mod interleavings;
#[cfg(test)]
mod tests;
