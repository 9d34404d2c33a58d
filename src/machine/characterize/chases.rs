//! What one core's loads can do beside their mean time: chains that it follows at once, and how
//! the times of short stretches of one chain are spread.

use super::chain::Chain;
use super::error::MeasurementError;
use super::figure::{median, percentile};
use super::measured::Measured;
use super::plan::Walk;
use super::team::{self, HardwareThread, Pace};
use crate::topology::Topology;
use std::time::Instant;

/// Chains at once.
pub const CHAINS: [usize; 6] = [1, 2, 4, 8, 12, 16];

/// Loads of every chain in a repetition.
const LOADS: usize = 10_000;

/// Loads between two looks at the clock: enough that a clock of nanoseconds can tell them apart in
/// the first-level cache.
pub const BATCH: usize = 32;

/// Looks at the clock: twenty of them lie beyond the last percentile.
const BATCHES: usize = 20_000;

/// The percentiles.
pub const PERCENTILES: [f64; 4] = [50.0, 90.0, 99.0, 99.9];

/// Times of a load while [`CHAINS`] chains are followed at once, for every size of the buffer
/// \[lines\], the number of chains changing first.
pub fn parallel(
    topology: &Topology,
    thread: HardwareThread,
    sizes: &[usize],
    walk: Walk,
    pace: Pace,
) -> Result<Measured, MeasurementError> {
    let most = sizes.iter().copied().max().unwrap_or(1);
    let tasks = sizes.len() * CHAINS.len();
    let chains = |task: usize| CHAINS[task % CHAINS.len()];
    let worked = team::work(
        topology,
        &[thread],
        tasks,
        pace,
        |_| Chain::near(most, walk),
        |chain, task| {
            if task % CHAINS.len() == 0 {
                chain.settle(sizes[task / CHAINS.len()], walk);
            }
            follow(chain, chains(task));
        },
        |chain, task| follow(chain, chains(task)),
        |chain| (chain.is_within(most), ()),
    )?;
    let checked = worked.checked("chains of loads at once")?;
    let loads: Vec<f64> = (0..tasks)
        .map(|task| (LOADS * chains(task)) as f64)
        .collect();
    Ok(checked.per_unit(&loads).into())
}

/// The loop of every number of chains is compiled by itself, so that places stay in registers
/// where there are enough.
fn follow(chain: &mut Chain, chains: usize) {
    match chains {
        1 => chain.follow_several::<1>(LOADS),
        2 => chain.follow_several::<2>(LOADS),
        4 => chain.follow_several::<4>(LOADS),
        8 => chain.follow_several::<8>(LOADS),
        12 => chain.follow_several::<12>(LOADS),
        _ => chain.follow_several::<16>(LOADS),
    }
}

/// [`PERCENTILES`] of the time of a load in batches of [`BATCH`], for every size of the buffer
/// \[lines\], a value each; and last the time of looking at the clock, which was subtracted from
/// every batch \[s\].
pub fn percentiles(
    topology: &Topology,
    thread: HardwareThread,
    sizes: &[usize],
    walk: Walk,
) -> Result<Measured, MeasurementError> {
    /// The batches are the repetition.
    const ONCE: Pace = Pace {
        slice: std::time::Duration::ZERO,
        least: 1,
        most: 1,
    };
    let most = sizes.iter().copied().max().unwrap_or(1);
    let worked = team::work(
        topology,
        &[thread],
        sizes.len(),
        ONCE,
        |_| Ok((Chain::near(most, walk)?, Vec::new(), look_at_clock())),
        |(chain, ..): &mut (Chain, Vec<Vec<f64>>, f64), task| {
            chain.settle(sizes[task], walk);
        },
        |(chain, batches, look), _| batches.push(follow_batches(chain, *look)),
        |(chain, batches, look)| (chain.is_within(most), (batches, look)),
    )?;
    let checked = worked.checked("a chain of loads in batches")?;
    let unbound = checked.unbound;
    let mut times = Vec::new();
    for (batches, look) in checked.results {
        for mut batches in batches {
            batches.sort_by(f64::total_cmp);
            times.extend(PERCENTILES.map(|percent| vec![percentile(&batches, percent)]));
        }
        times.push(vec![look]);
    }
    Ok(Measured {
        times,
        unbound,
        ..Measured::default()
    })
}

/// Time of a load in each of many batches \[s\].
fn follow_batches(chain: &mut Chain, look: f64) -> Vec<f64> {
    let mut times = vec![0.0; BATCHES];
    for time in &mut times {
        let begun = Instant::now();
        chain.follow(BATCH);
        *time = (begun.elapsed().as_secs_f64() - look).max(0.0) / BATCH as f64;
    }
    times
}

/// Median time between two looks at the clock with nothing between them \[s\].
fn look_at_clock() -> f64 {
    let mut times: Vec<f64> = (0..10_001)
        .map(|_| Instant::now().elapsed().as_secs_f64())
        .collect();
    median(&mut times)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::characterize::buffer::PAGE;

    const SIZES: [usize; 2] = [PAGE, 32 * PAGE];

    fn place(topology: &Topology) -> HardwareThread {
        HardwareThread {
            index: topology.cores[0].threads[0],
            node: topology.cores[0].numa_node,
        }
    }

    /// Orders of magnitude: a load takes less than 10 µs even on a machine that is busy.
    #[test]
    fn percentiles_ascend() {
        let topology = Topology::current().unwrap();
        let found = percentiles(&topology, place(&topology), &SIZES, Walk::Hops).unwrap();
        assert_eq!(found.times.len(), SIZES.len() * PERCENTILES.len() + 1);
        for of_size in found.times.chunks_exact(PERCENTILES.len()) {
            assert!(of_size.is_sorted_by(|a, b| a[0] <= b[0]), "{of_size:?}");
            assert!((1e-11..1e-5).contains(&of_size[0][0]), "{of_size:?}");
        }
    }

    #[test]
    fn chains_at_once_have_a_time_each() {
        let topology = Topology::current().unwrap();
        let pace = Pace {
            slice: std::time::Duration::ZERO,
            least: 2,
            most: 2,
        };
        let found = parallel(&topology, place(&topology), &SIZES, Walk::Hops, pace).unwrap();
        assert_eq!(found.times.len(), SIZES.len() * CHAINS.len());
        for times in &found.times {
            assert_eq!(times.len(), 2);
            assert!(
                times.iter().all(|time| (1e-11..1e-4).contains(time)),
                "{times:?}"
            );
        }
    }
}
