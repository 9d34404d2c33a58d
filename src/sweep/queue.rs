//! Which chain comes next: the one that is expected to take longest of the first that wait,
//! so that no long one is begun when the others are done.
//!
//! Before a point was computed nobody knows whether its motion is chaotic (which takes five
//! times as long as settled motion to answer), but its neighbours tell: expected is the work
//! that the manifest asks for, times the mean time per work of the neighbours that are
//! finished, or of all finished chains where no neighbour is. The order moves no number: a
//! chain's results depend on the chain alone.

use super::turns::Turn;
use crate::manifest::{Job, PointSpec};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Rows that may wait in memory for the oldest unfinished point; a chain a worker where that
/// is more.
const AHEAD: usize = 4096;

/// Chains that are looked at for the longest, a worker. What is begun before its turn waits in
/// memory until the ones before it are written, so not all are.
const LOOK: usize = 16;

/// Modes whose work equals that of marching a cycle of none (README, "Measured").
const FIXED_WORK: f64 = 40.0;

/// Chains that may be begun before their turn.
pub(super) fn look(workers: usize) -> usize {
    LOOK * workers
}

/// Hands out chains.
pub(super) struct Queue {
    turns: Vec<Turn>,
    /// Work of each, in cycles times modes.
    work: Vec<f64>,
    /// Turn of each chain of this run, by its place.
    of_place: Vec<Option<usize>>,
    /// Points of a chain.
    length: usize,
    /// Chains from one to its neighbour along the second fastest axis; 0 where that is not
    /// regular.
    row: usize,
    look: usize,
    ahead: u64,
    known: Mutex<Known>,
}

struct Known {
    taken: Vec<bool>,
    /// The first that is not taken.
    first: usize,
    /// Over finished neighbours.
    near: Vec<Mean>,
    /// Over all finished chains.
    all: Mean,
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
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Next {
    /// Compute this chain, an index into [`Queue::turns`].
    Chain(usize),
    /// Ask again shortly: too much waits for older points.
    Wait,
    /// Nothing is left.
    End,
}

impl Queue {
    /// A queue of what is left of a run over `points` of a job, for so many workers.
    pub(super) fn new(
        job: &Job,
        points: usize,
        turns: Vec<Turn>,
        shards: usize,
        workers: usize,
    ) -> Self {
        let length = job.chain_length();
        let mut of_place = vec![None; points / length];
        for (index, turn) in turns.iter().enumerate() {
            of_place[turn.place / length] = Some(index);
        }
        let work = turns
            .iter()
            .map(|turn| {
                let chain = &job.points[turn.first..turn.first + length];
                chain[turn.link.passed()..].iter().map(work).sum()
            })
            .collect();
        let known = Known {
            taken: vec![false; turns.len()],
            first: 0,
            near: vec![Mean::default(); turns.len()],
            all: Mean::default(),
        };
        let row = row(job);
        Self {
            work,
            of_place,
            length,
            row: if row.is_multiple_of(shards) {
                row / shards
            } else {
                0
            },
            look: look(workers),
            ahead: AHEAD.max(workers * length) as u64,
            known: Mutex::new(known),
            turns,
        }
    }

    /// All chains.
    pub(super) fn turns(&self) -> &[Turn] {
        &self.turns
    }

    fn known(&self) -> MutexGuard<'_, Known> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What comes next, when so many points have left the writer's memory. The oldest chain
    /// is always among those that may be taken once all before it are written.
    pub(super) fn next(&self, written: u64) -> Next {
        let mut known = self.known();
        while known.taken.get(known.first) == Some(&true) {
            known.first += 1;
        }
        let Known {
            taken,
            first,
            near,
            all,
        } = &mut *known;
        if *first == self.turns.len() {
            return Next::End;
        }
        let typical = all.value().unwrap_or(1.0);
        let mut longest: Option<(f64, usize)> = None;
        let within = self.turns.len().min(*first + self.look);
        for index in *first..within {
            if self.turns[index].place as u64 >= written + self.ahead {
                break;
            }
            let expected = self.work[index] * near[index].value().unwrap_or(typical);
            if !taken[index] && longest.is_none_or(|(most, _)| expected > most) {
                longest = Some((expected, index));
            }
        }
        match longest {
            None => Next::Wait,
            Some((_, index)) => {
                taken[index] = true;
                Next::Chain(index)
            }
        }
    }

    /// Tells what a chain took; its neighbours are expected to take as long.
    pub(super) fn finished(&self, index: usize, time: Duration) {
        let ratio = time.as_secs_f64() / self.work[index];
        let place = self.turns[index].place / self.length;
        let mut known = self.known();
        known.all.add(ratio);
        for step in [1, self.row] {
            let beside = [place.checked_sub(step), place.checked_add(step)];
            for place in beside.into_iter().flatten().filter(|_| step > 0) {
                if let Some(Some(index)) = self.of_place.get(place) {
                    known.near[*index].add(ratio);
                }
            }
        }
    }
}

/// Chains from one to the next along the second fastest of the axes that tell them apart.
fn row(job: &Job) -> usize {
    let carried = job.carried.as_ref();
    let fastest = (0..job.axes.len())
        .rev()
        .find(|axis| carried.is_none_or(|carried| carried.axis != *axis))
        .map_or(1, |axis| job.axes[axis].values.len());
    fastest * carried.map_or(1, |carried| carried.directions.len())
}

/// Cycles that a point is asked to march at most, times what a cycle takes.
pub(super) fn work(point: &PointSpec) -> f64 {
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
mod tests {
    use super::super::chain::Link;
    use super::*;

    /// A queue of chains of one point and equal work, in rows.
    fn queue(count: usize, row: usize, look: usize, ahead: u64) -> Queue {
        let turn = |place| Turn {
            place,
            first: place,
            link: Link::default(),
        };
        Queue {
            turns: (0..count).map(turn).collect(),
            work: vec![1.0; count],
            of_place: (0..count).map(Some).collect(),
            length: 1,
            row,
            look,
            ahead,
            known: Mutex::new(Known {
                taken: vec![false; count],
                first: 0,
                near: vec![Mean::default(); count],
                all: Mean::default(),
            }),
        }
    }

    fn taken(queue: &Queue, written: u64) -> usize {
        match queue.next(written) {
            Next::Chain(index) => index,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn neighbours_of_long_chains_come_first_and_of_short_ones_last() {
        let queue = queue(12, 4, 12, 100);
        assert_eq!(taken(&queue, 0), 0, "in order where nothing is known");
        queue.finished(0, Duration::from_secs(1));
        // 1 and 4 are expected to be like 0, and so are all others.
        assert_eq!(taken(&queue, 0), 1);
        queue.finished(1, Duration::from_secs(9));
        // On average 5; beside 1 lie 2 and 5 (9), beside 0 lies 4 (1).
        let order: Vec<usize> = (0..10).map(|_| taken(&queue, 0)).collect();
        assert_eq!(order, [2, 5, 3, 6, 7, 8, 9, 10, 11, 4]);
        assert_eq!(queue.next(0), Next::End);
    }

    #[test]
    fn what_waits_in_memory_is_bounded() {
        let queue = queue(10, 0, 3, 4);
        // Everything but 0 is known to be long; 0 still comes once the window is used up.
        taken(&queue, 0);
        assert_eq!(
            [taken(&queue, 0), taken(&queue, 0), taken(&queue, 0)],
            [1, 2, 3]
        );
        assert_eq!(queue.next(0), Next::Wait, "point 0 is not written yet");
        assert_eq!(taken(&queue, 1), 4);
        // Three ahead of the oldest that is not taken, however long the fourth would be.
        queue.known().near[9].add(100.0);
        queue.known().near[7].add(10.0);
        assert_eq!(taken(&queue, 5), 7);
        assert_eq!([taken(&queue, 5), taken(&queue, 5)], [5, 6]);
        assert_eq!(taken(&queue, 6), 9);
    }
}
