//! Which chains belong to a run, and which of them are still to be computed?

use super::chain::ChainState;
use crate::manifest::Job;
use crate::store::{Journal, PointRow, Shard, StoreError};
use std::collections::{BTreeSet, HashMap};

/// Chains of a job that belong to a run, in order; `place` is an index among them.
#[derive(Debug, Clone)]
pub struct ChainSelection {
    /// Number of points in a chain; 1 if points are independent.
    length: usize,
    chains: Chains,
}

#[derive(Debug, Clone)]
enum Chains {
    /// Every `step`-th chain from `first` on.
    Every {
        first: usize,
        step: usize,
        count: usize,
    },
    /// The chains with these numbers.
    Listed(Vec<usize>),
}

impl ChainSelection {
    /// The chains of a shard: every n-th chain of the job, where n is the number of shards. Neighbouring
    /// chains take similar time, so this distributes the time evenly. Without a shard, all chains. On a
    /// refined grid, only the points of the undivided grid, which have the first numbers.
    pub fn of_shard(job: &Job, shard: Option<Shard>) -> Self {
        let points = match &job.refine {
            Some(refine) => refine.nested.places(0),
            None => job.points.len(),
        };
        Self::every(points, job.chain_length(), shard)
    }

    /// A selection of independent points.
    pub(super) fn of_points(points: Vec<usize>) -> Self {
        Self {
            length: 1,
            chains: Chains::Listed(points),
        }
    }

    fn every(points: usize, length: usize, shard: Option<Shard>) -> Self {
        let (first, step) = shard.map_or((0, 1), |s| (s.index as usize - 1, s.count as usize));
        let count = (points / length).saturating_sub(first).div_ceil(step);
        Self {
            length,
            chains: Chains::Every { first, step, count },
        }
    }

    /// Only the chains that contain one of `points`. Chains are computed as a whole, because each point starts from the
    /// end of the previous one.
    pub fn with(&self, points: &BTreeSet<u64>) -> Self {
        let of = |id: &u64| *id as usize / self.length;
        let wanted: BTreeSet<usize> = points.iter().map(of).collect();
        let chains = (0..self.chains()).map(|place| self.chain(place));
        Self {
            length: self.length,
            chains: Chains::Listed(chains.filter(|chain| wanted.contains(chain)).collect()),
        }
    }

    /// Number of chains.
    pub fn chains(&self) -> usize {
        match &self.chains {
            Chains::Every { count, .. } => *count,
            Chains::Listed(chains) => chains.len(),
        }
    }

    /// Number of points.
    pub fn points(&self) -> usize {
        self.chains() * self.length
    }

    /// The number of the chain at index `place` of the selection.
    fn chain(&self, place: usize) -> usize {
        match &self.chains {
            Chains::Every { first, step, .. } => first + place * step,
            Chains::Listed(chains) => chains[place],
        }
    }

    /// The `point_id` of the `n`-th point.
    pub(super) fn id(&self, n: usize) -> usize {
        self.chain(n / self.length) * self.length + n % self.length
    }

    /// All `point_id`s, ascending.
    pub fn ids(self) -> impl Iterator<Item = u64> + Send + 'static {
        (0..self.points()).map(move |n| self.id(n) as u64)
    }
}

/// The points of a chain that are still to be computed.
#[derive(Debug)]
pub(super) struct ChainTask {
    /// Index of the chain among the chains of this run.
    pub place: usize,
    /// Id of the first point of the chain. Points that `link` has passed are already finished.
    pub first: usize,
    /// State of the chain from an earlier run.
    pub link: ChainState,
}

/// Chains that an earlier run has finished, completely or partly.
#[derive(Debug, Default)]
pub(super) struct FinishedChains {
    /// Whether each chain is finished, by its number. Chains beyond the end are not finished.
    done: Vec<bool>,
    links: HashMap<usize, ChainState>,
}

impl FinishedChains {
    /// Reads the journal and passes every point in it to `take` once.
    ///
    /// # Errors
    /// The journal cannot be read, it has points of another job, or an error of `take`.
    pub(super) fn replay(
        job: &Job,
        journal: &mut Journal,
        mut take: impl FnMut(PointRow) -> Result<(), StoreError>,
    ) -> Result<Self, StoreError> {
        let mut finished = Self::default();
        journal.replay(|row| {
            if finished.pass(job, &row)? {
                take(row)
            } else {
                // Repeated records of a point have the same results.
                Ok(())
            }
        })?;
        Ok(finished)
    }

    /// Adds a point; returns whether it is new.
    fn pass(&mut self, job: &Job, row: &PointRow) -> Result<bool, StoreError> {
        let point_id = row.point_id;
        let length = job.chain_length();
        let (chain, place) = (point_id as usize / length, point_id as usize % length);
        if point_id >= job.points.len() as u64 {
            return Err(StoreError::UnexpectedPoint { point_id });
        }
        if self.is_done(chain) {
            return Ok(false);
        }
        let link = self.links.entry(chain).or_default();
        if place < link.passed() {
            return Ok(false);
        }
        if place > link.passed() {
            return Err(StoreError::UnexpectedPoint { point_id });
        }
        link.pass(job, row);
        if link.passed() == length {
            if self.done.len() <= chain {
                self.done.resize(chain + 1, false);
            }
            self.done[chain] = true;
            self.links.remove(&chain);
        }
        Ok(true)
    }

    fn is_done(&self, chain: usize) -> bool {
        self.done.get(chain) == Some(&true)
    }

    /// Whether the chain at a place is finished.
    pub(super) fn has(&self, selection: &ChainSelection, place: usize) -> bool {
        self.is_done(selection.chain(place))
    }

    /// Number of remaining points of an unfinished chain.
    pub(super) fn left(&self, selection: &ChainSelection, place: usize) -> usize {
        let passed = self
            .links
            .get(&selection.chain(place))
            .map_or(0, ChainState::passed);
        selection.length - passed
    }

    /// The task to compute the chain at a place. Call this once per chain.
    pub(super) fn turn(&mut self, selection: &ChainSelection, place: usize) -> ChainTask {
        let chain = selection.chain(place);
        ChainTask {
            place,
            first: chain * selection.length,
            link: self.links.remove(&chain).unwrap_or_default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_cover_every_point_once() {
        for (points, chain, count) in [
            (0, 1, 1),
            (1, 1, 3),
            (80, 1, 7),
            (81, 1, 80),
            (84, 12, 3),
            (12, 12, 8),
        ] {
            let mut counts = vec![0; points];
            for index in 1..=count {
                let own = ChainSelection::every(points, chain, Some(Shard { index, count }));
                let ids: Vec<u64> = own.clone().ids().collect();
                assert_eq!(ids.len(), own.points());
                assert!(ids.is_sorted());
                for whole in ids.chunks(chain) {
                    assert!(whole[0].is_multiple_of(chain as u64), "chains stay whole");
                    assert!(whole.windows(2).all(|pair| pair[1] == pair[0] + 1));
                }
                for i in ids {
                    counts[i as usize] += 1;
                }
            }
            assert!(counts.iter().all(|n| *n == 1));
            assert_eq!(ChainSelection::every(points, chain, None).points(), points);
        }
    }

    #[test]
    fn chains_are_taken_whole() {
        let of = |points: &[u64], chain, shard| {
            let own =
                ChainSelection::every(24, chain, shard).with(&points.iter().copied().collect());
            own.ids().collect::<Vec<u64>>()
        };
        assert_eq!(of(&[3, 7], 1, None), [3, 7]);
        let whole: Vec<u64> = (0..12).collect();
        assert_eq!(of(&[3, 4, 11], 4, None), whole);
        assert_eq!(of(&[], 4, None), [0; 0]);
        // A point of another shard is ignored.
        let second = Some(Shard { index: 2, count: 2 });
        assert_eq!(of(&[1, 5, 8], 4, second), [4, 5, 6, 7]);
    }
}
