//! Latency under load: one thread follows a chain of loads while the others read large arrays, the
//! faster the shorter they pause after each piece, as Intel's Memory Latency Checker does
//! (V. Viswanathan et al., "Intel Memory Latency Checker").

use super::buffer::{Buffer, LANES, LINE};
use super::chain::Chain;
use super::error::MeasurementError;
use super::measured::Measured;
use super::memory;
use super::plan::Walk;
use super::team::{self, HardwareThread, Pace};
use super::vectors::{self, Set};
use crate::topology::Topology;
use std::hint::black_box;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::Instant;

/// Loads of a repetition.
const LOADS: usize = 10_000;

/// Lines that are read between two pauses.
const PIECE: usize = 32;

/// Bytes that one thread has read, on a line of its own.
#[derive(Debug, Default)]
#[repr(align(128))]
struct Read(AtomicU64);

/// A member of the team.
enum Member {
    /// Follows its chain; for every repetition of every task the time of a load \[s\] and what
    /// the others read meanwhile \[bytes/s\].
    Chaser {
        chain: Box<Chain>,
        found: Vec<Vec<[f64; 2]>>,
    },
    /// Reads its array, again and again from where it is.
    Loader {
        array: Buffer,
        at: usize,
        turns: usize,
        right: bool,
    },
}

/// For every pause of the others, in turns of an empty loop (none: they do not read at all): times
/// of a load of the first member of the team, then, of the next index, times of a byte that the
/// others read meanwhile \[s\]. `lines` are those of the chain, `array` those of each of the arrays.
pub fn measure(
    topology: &Topology,
    team: &[HardwareThread],
    lines: usize,
    array: usize,
    walk: Walk,
    pauses: &[Option<u32>],
    pace: Pace,
) -> Result<Measured, MeasurementError> {
    let set = Set::widest();
    let read: Vec<Read> = team.iter().map(|_| Read::default()).collect();
    let all_read = || -> u64 { read.iter().map(|r| r.0.load(Ordering::Relaxed)).sum() };
    // How often the chaser has come to the end of its loads.
    let ended = AtomicUsize::new(0);
    let array = array.next_multiple_of(PIECE);
    let prepare = |member| -> Result<Member, MeasurementError> {
        Ok(match member {
            0 => {
                let mut chain = Box::new(Chain::near(lines, walk)?);
                chain.settle(lines, walk);
                let found = vec![Vec::new(); pauses.len()];
                Member::Chaser { chain, found }
            }
            _ => Member::Loader {
                array: memory::near(array, 1.0)?,
                at: 0,
                turns: 0,
                right: true,
            },
        })
    };
    let load = |own: &Read, array: &Buffer, at: &mut usize, pause: u32| {
        let piece = &array.lines()[*at..*at + PIECE];
        *at = (*at + PIECE) % array.lines().len();
        let sum = vectors::read(set, piece, 1, PIECE, 1);
        own.0.fetch_add((PIECE * LINE) as u64, Ordering::Relaxed);
        for turn in 0..pause {
            black_box(turn);
        }
        sum == (PIECE * LANES) as f64
    };
    let once = |state: &mut (usize, Member), task: usize| match &mut state.1 {
        Member::Chaser { chain, found } => {
            let (begun, before) = (Instant::now(), all_read());
            chain.follow(LOADS);
            let (taken, bytes) = (begun.elapsed().as_secs_f64(), all_read() - before);
            ended.fetch_add(1, Ordering::SeqCst);
            found[task].push([taken / LOADS as f64, bytes as f64 / taken]);
        }
        Member::Loader {
            array,
            at,
            turns,
            right,
        } => {
            *turns += 1;
            while ended.load(Ordering::Relaxed) < *turns {
                match pauses[task] {
                    Some(pause) => *right &= load(&read[state.0], array, at, pause),
                    None => std::hint::spin_loop(),
                }
            }
        }
    };
    // More repetitions than elsewhere: not all of them count.
    let pace = Pace {
        least: 4 * pace.least,
        ..pace
    };
    let worked = team::work(
        topology,
        team,
        pauses.len(),
        pace,
        |member| Ok((member, prepare(member)?)),
        |state, task| {
            once(state, task);
            // That was to warm up.
            if let Member::Chaser { found, .. } = &mut state.1 {
                found[task].clear();
            }
        },
        once,
        |(_, member)| match member {
            Member::Chaser { chain, found } => (chain.is_within(lines), found),
            Member::Loader { right, .. } => (right, Vec::new()),
        },
    )?;
    let checked = worked.checked("loads beside readers")?;
    Ok(Measured {
        times: (checked.results.iter().flatten())
            .flat_map(|found| under_load(found))
            .collect(),
        unbound: checked.unbound,
        ..Measured::default()
    })
}

/// Times of a load, and of a byte that the others read \[s\], of the repetitions during which the
/// others could read as they were to: where the system kept one of them from it, the bandwidth
/// falls, and the latency is not that of the load which was asked for.
fn under_load(repetitions: &[[f64; 2]]) -> [Vec<f64>; 2] {
    /// Part of the highest bandwidth.
    const ENOUGH: f64 = 0.9;
    let highest = repetitions
        .iter()
        .map(|[_, bandwidth]| *bandwidth)
        .fold(0.0, f64::max);
    let kept = || {
        repetitions
            .iter()
            .filter(|[_, bandwidth]| *bandwidth >= ENOUGH * highest)
    };
    let reading = kept().filter(|[_, bandwidth]| *bandwidth > 0.0);
    [
        kept().map(|[latency, _]| *latency).collect(),
        reading.map(|[_, bandwidth]| 1.0 / bandwidth).collect(),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::characterize::buffer::PAGE;

    #[test]
    fn repetitions_without_their_load_do_not_count() {
        let found = under_load(&[[1.0, 8.0], [2.0, 7.5], [9.0, 1.0], [3.0, 7.0]]);
        assert_eq!(found, [vec![1.0, 2.0], vec![1.0 / 8.0, 1.0 / 7.5]]);
        let idle = under_load(&[[1.0, 0.0], [2.0, 0.0]]);
        assert_eq!(idle, [vec![1.0, 2.0], vec![]]);
    }

    /// Readers that do not pause read more than those that do, and idle ones nothing. Where there
    /// is one processor, nobody reads.
    #[test]
    fn pauses_lower_the_load() {
        let topology = Topology::current().unwrap();
        let threads = topology.cores.iter().flat_map(|core| {
            let node = core.numa_node;
            core.threads
                .iter()
                .map(move |&index| HardwareThread { index, node })
        });
        let team: Vec<HardwareThread> = threads.take(2).collect();
        let pace = Pace {
            slice: std::time::Duration::ZERO,
            least: 5,
            most: 5,
        };
        let pauses = [None, Some(1_000_000), Some(0)];
        let lines = 64 * PAGE;
        let found = measure(&topology, &team, lines, 1 << 14, Walk::Hops, &pauses, pace).unwrap();
        assert_eq!(found.times.len(), 2 * pauses.len());
        let loads = found.times.iter().step_by(2);
        assert!(
            loads.flatten().all(|time| (1e-10..1e-3).contains(time)),
            "{found:?}"
        );
        assert!(found.times[1].is_empty());
        if team.len() == 2 {
            let best = |i: usize| found.times[i].iter().copied().fold(f64::INFINITY, f64::min);
            assert!(best(5) < best(3), "{:?}", found.times);
            assert!(best(5) > 1e-12, "{:?}", found.times);
        }
    }
}
