//! Which chain comes next: the one that is expected to take longest of the first that wait,
//! so that no long one is begun when the others are done.
//!
//! Before a point was computed nobody knows whether its motion is chaotic (which takes five
//! times as long as settled motion to answer), but its neighbours tell: expected is the work
//! that the manifest asks for, times the mean time per work of the neighbours that are
//! finished, or of all finished chains where no neighbour is. The order moves no number: a
//! chain's results depend on the chain alone.
//!
//! On a machine with several NUMA nodes whose workers have tables of kernels of their own, chains
//! whose tables a worker's node has come before those whose tables are to be kept there, and these
//! before those of other nodes; the longest is sought among the nearest.
//!
//! Only a window of chains is in memory, however many there are.

use super::parts::table_number;
use super::turns::{ChainTask, Share, TakenOver};
use crate::manifest::{Job, Variant};
use crate::topology::{Nearness, Shelves};
use std::cmp::Reverse;
use std::collections::{BTreeMap, VecDeque};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Rows that may wait in memory for the oldest unfinished point; a chain a worker where that
/// is more.
const AHEAD: usize = 4096;

/// Chains that are looked at for the longest, a worker. What is begun before its turn waits in
/// memory until the ones before it are written, so not all are.
const LOOK: usize = 16;

/// Longest rows of the grid whose next row is told how long their chains took: what is told to
/// chains that are not in the window yet is kept.
const LONGEST_ROW: usize = 16_384;

/// Modes whose work equals that of integrating a cycle of none (docs/measured.md).
const FIXED_WORK: f64 = 40.0;

/// Chains that may be begun before their turn.
pub(super) fn look(workers: usize) -> usize {
    LOOK * workers
}

/// Rows that may wait in memory for the oldest unfinished point, with so many workers on chains of
/// such a length.
fn ahead(workers: usize, length: usize) -> usize {
    AHEAD.max(workers * length)
}

/// Hands out chains.
pub(super) struct Queue<'a> {
    job: &'a Job,
    share: Share,
    /// Points of a chain.
    length: usize,
    /// Chains from one to its neighbour along the second fastest axis; 0 where that is not
    /// regular, or far.
    row: usize,
    look: usize,
    ahead: u64,
    known: Mutex<Known>,
}

/// What changes while chains are handed out.
struct Known {
    taken_over: TakenOver,
    /// The first place that has not been in the window.
    next: usize,
    /// Chains that have been in the window.
    entered: usize,
    /// Chains that may come next, by place.
    window: VecDeque<Candidate>,
    /// Over finished neighbours, of places beyond the window.
    near: BTreeMap<usize, Mean>,
    /// Over all finished chains.
    all: Mean,
    /// Which tables lie on which node; of no node where all read the same ones.
    shelves: Shelves,
}

/// A chain that may come next.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    place: usize,
    /// Chains that came into the window before it.
    number: usize,
    /// In cycles times modes.
    work: f64,
    /// The table that it reads, where nodes have their own.
    table: Option<u64>,
    /// Over finished neighbours.
    near: Mean,
}

/// A mean that grows.
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

/// What a worker is to do.
#[derive(Debug)]
enum Next {
    /// Compute this chain, or what is left of it; its work is that in cycles times modes.
    Chain { turn: ChainTask, work: f64 },
    /// Ask again shortly: too much waits for older points.
    Wait,
    /// Nothing is left.
    End,
}

impl<'a> Queue<'a> {
    /// A queue of what an earlier run has left of a share, dealt to so many shards, for so many
    /// workers on so many nodes with tables of their own.
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
        // Which points of a refined grid lie beside each other does not show in their numbers.
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

    /// Work that the chain at a place has left.
    fn work(&self, known: &Known, place: usize) -> f64 {
        let end = (place + 1) * self.length;
        let left = known.taken_over.left(&self.share, place);
        (end - left..end)
            .map(|n| work(self.job.points.variant_near(self.share.id(n))))
            .sum()
    }

    /// The table that the chain at a place reads first, where nodes have their own.
    fn table(&self, known: &Known, place: usize) -> Option<u64> {
        let first = || self.job.points.at(self.share.id(place * self.length));
        (known.shelves.nodes() > 0).then(|| table_number(&first()))?
    }

    /// Lets chains into the window until it reaches as far as may be looked.
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

    /// What comes next for a worker of a node with tables of its own, when so many points have left
    /// the writer's memory. The oldest chain is always among those that may be taken once all
    /// before it are written.
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

    /// Has a worker compute chains until nothing is left, the run is called off, or `compute` breaks one
    /// off. `written` is how many points have left the writer's memory; `pause` waits where too much waits
    /// for older points.
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

    /// Tells what the chain at a place took; its neighbours are expected to take as long.
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

/// Chains from one to the next along the second fastest of the dimensions that tell them apart.
fn row(job: &Job) -> usize {
    let carried = job.carried.as_ref();
    let fastest = (job.dimensions.iter().rev())
        .find(|own| carried.is_none_or(|carried| !own.axes.contains(&carried.axis)))
        .map_or(1, |own| own.length);
    fastest * carried.map_or(1, |carried| carried.directions.len())
}

/// Cycles that a point is asked to integrate at most, times what a cycle takes.
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
