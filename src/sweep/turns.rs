//! Which chains belong to a run, and which of them are still to be computed.

use super::chain::Link;
use crate::manifest::Job;
use crate::store::{Journal, PointRow, Shard, StoreError};
use std::collections::{BTreeSet, HashMap};

/// Indices into a job's points that belong to a shard: every n-th chain, so that neighbours,
/// which cost alike, are dealt out evenly. `chain` is the length of a chain, 1 where points
/// are independent.
pub fn shard_points(points: usize, chain: usize, shard: Option<Shard>) -> Vec<usize> {
    let (first, step) = shard.map_or((0, 1), |s| (s.index as usize - 1, s.count as usize));
    (0..points)
        .step_by(chain)
        .skip(first)
        .step_by(step)
        .flat_map(|begin| begin..begin + chain)
        .collect()
}

/// All points of the chains that hold one of some points: what one has left, the next
/// starts from, so a chain is computed anew as a whole.
pub fn whole_chains(points: &BTreeSet<u64>, chain: usize) -> BTreeSet<u64> {
    let chain = chain as u64;
    points
        .iter()
        .flat_map(|id| {
            let first = id / chain * chain;
            first..first + chain
        })
        .collect()
}

/// A chain that is not finished.
#[derive(Debug)]
pub(super) struct Turn {
    /// Where it stands among all points of this run.
    pub place: usize,
    /// Its first point.
    pub first: usize,
    /// What is known of it from an earlier run.
    pub link: Link,
}

/// Which chains an earlier run has finished, wholly or in part.
pub(super) struct TakenOver<'a> {
    job: &'a Job,
    done: Vec<bool>,
    links: HashMap<usize, Link>,
}

impl<'a> TakenOver<'a> {
    /// Reads the journal; every point in it is handed to `take` once.
    ///
    /// # Errors
    /// The journal cannot be read or holds points that are not of this job, or what `take`
    /// says.
    pub(super) fn replay(
        job: &'a Job,
        journal: &mut Journal,
        mut take: impl FnMut(PointRow) -> Result<(), StoreError>,
    ) -> Result<Self, StoreError> {
        let length = job.chain_length();
        let mut taken = Self {
            job,
            done: vec![false; job.points.len() / length],
            links: HashMap::new(),
        };
        journal.replay(|row| match taken.pass(&row)? {
            true => take(row),
            // Twice the same point, twice the same numbers.
            false => Ok(()),
        })?;
        Ok(taken)
    }

    /// Whether the point is new.
    fn pass(&mut self, row: &PointRow) -> Result<bool, StoreError> {
        let point_id = row.point_id;
        let length = self.job.chain_length();
        let (chain, place) = (point_id as usize / length, point_id as usize % length);
        let done = self
            .done
            .get_mut(chain)
            .ok_or(StoreError::UnexpectedPoint { point_id })?;
        if *done {
            return Ok(false);
        }
        let link = self.links.entry(chain).or_default();
        if place < link.passed() {
            return Ok(false);
        }
        if place > link.passed() {
            return Err(StoreError::UnexpectedPoint { point_id });
        }
        link.pass(self.job, row);
        if link.passed() == length {
            *done = true;
            self.links.remove(&chain);
        }
        Ok(true)
    }

    /// What is left of a run over `all`, indices into the job's points, chains whole.
    pub(super) fn rest(mut self, all: &[usize]) -> Vec<Turn> {
        let length = self.job.chain_length();
        (0..all.len())
            .step_by(length)
            .filter(|&place| !self.done[all[place] / length])
            .map(|place| Turn {
                place,
                first: all[place],
                link: self
                    .links
                    .remove(&(all[place] / length))
                    .unwrap_or_default(),
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_cover_every_point_once() {
        for (points, chain, count) in [(0, 1, 1), (1, 1, 3), (80, 1, 7), (81, 1, 80), (84, 12, 3)] {
            let mut seen = vec![0; points];
            for index in 1..=count {
                let own = shard_points(points, chain, Some(Shard { index, count }));
                for whole in own.chunks(chain) {
                    assert!(whole[0].is_multiple_of(chain), "chains stay whole");
                    assert!(whole.windows(2).all(|pair| pair[1] == pair[0] + 1));
                }
                for i in own {
                    seen[i] += 1;
                }
            }
            assert!(seen.iter().all(|n| *n == 1));
            assert_eq!(shard_points(points, chain, None).len(), points);
        }
    }

    #[test]
    fn chains_are_taken_whole() {
        let of = |points: &[u64], chain| {
            let whole = whole_chains(&points.iter().copied().collect(), chain);
            whole.into_iter().collect::<Vec<u64>>()
        };
        assert_eq!(of(&[3, 7], 1), [3, 7]);
        assert_eq!(of(&[3, 4, 11], 4), [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]);
        assert_eq!(of(&[], 4), [0; 0]);
    }
}
