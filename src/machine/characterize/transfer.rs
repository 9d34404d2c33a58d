//! Handing a line of memory back and forth between two cores.

use super::error::MeasurementError;
use super::measured::Measured;
use super::team::{self, HardwareThread, Pace, SPINS};
use crate::topology::Topology;
use std::sync::atomic::{AtomicU64, Ordering};

/// Round trips of a repetition.
const TRIPS: u64 = 1_000;

/// A number on lines of its own: processors fetch lines in pairs.
#[derive(Debug, Default)]
#[repr(align(128))]
struct Flag(AtomicU64);

/// Times of handing a line over, one way: each of two threads exchanges the number that the other
/// has left there for the next one, in one atomic instruction, which takes the line for itself
/// (as `core-to-core-latency` of N. Viennot does).
pub fn measure(
    topology: &Topology,
    pair: &[HardwareThread; 2],
    pace: Pace,
) -> Result<Measured, MeasurementError> {
    let flag = Flag::default();
    let hand_over = |next: &mut u64, _| {
        for _ in 0..TRIPS {
            exchange(&flag, *next);
            *next += 2;
        }
    };
    let worked = team::work(
        topology,
        pair,
        1,
        pace,
        |member| Ok(member as u64),
        hand_over,
        hand_over,
        // The first member has exchanged all even numbers so far, the second all odd ones.
        |next| next,
    )?;
    let right = flag.0.into_inner();
    let ends = worked.results.iter().copied().min();
    if ends != Some(right) {
        return Err(MeasurementError::Wrong {
            what: "handing a line over",
        });
    }
    Ok(worked.per_unit(&[2.0 * TRIPS as f64]).into())
}

/// Waits for a number and replaces it by the next one.
fn exchange(flag: &Flag, number: u64) {
    let mut spins = 0;
    while (flag.0)
        .compare_exchange(number, number + 1, Ordering::AcqRel, Ordering::Relaxed)
        .is_err()
    {
        // The other one may not be running where threads cannot be bound.
        spins += 1;
        if spins > SPINS {
            std::thread::yield_now();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_goes_back_and_forth() {
        let topology = Topology::current().unwrap();
        let threads = topology.cores.iter().flat_map(|core| {
            let node = core.numa_node;
            core.threads
                .iter()
                .map(move |&index| HardwareThread { index, node })
        });
        let threads: Vec<HardwareThread> = threads.cycle().take(2).collect();
        let pace = Pace {
            slice: std::time::Duration::ZERO,
            least: 3,
            most: 3,
        };
        let found = measure(&topology, &[threads[0], threads[1]], pace).unwrap();
        // Light takes longer for a millimetre, and a scheduler no longer to change threads.
        assert_eq!(found.times[0].len(), 3);
        assert!(
            found.times[0]
                .iter()
                .all(|time| (1e-10..1e-1).contains(time)),
            "{found:?}"
        );
    }
}
