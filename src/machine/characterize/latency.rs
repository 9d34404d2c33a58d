//! Latency: the time of a load on which the next load depends, as a function of the size of the buffer.

use super::chain::AddressRing;
use super::error::MeasurementError;
use super::measured::Measured;
use super::memory;
use super::plan::Walk;
use super::team::{self, HardwareThread, RepetitionTime};
use crate::topology::Topology;

/// Loads per repetition.
const LOADS: usize = 20_000;

/// Times per load \[s\] in a chain of loads, for each number of lines in `sizes`, in memory on a node.
pub fn measure(
    topology: &Topology,
    thread: HardwareThread,
    node: u32,
    sizes: &[usize],
    walk: Walk,
    pace: RepetitionTime,
) -> Result<Measured, MeasurementError> {
    let most = sizes.iter().copied().max().unwrap_or(1);
    let prepare = |_| {
        if thread.node == node {
            AddressRing::near(most, walk)
        } else {
            Ok(AddressRing::new(memory::on_node(topology, node, most)?))
        }
    };
    let results = team::work(
        topology,
        &[thread],
        sizes.len(),
        pace,
        prepare,
        |ring, task| ring.write_ring(sizes[task], walk),
        |ring, _| ring.follow(LOADS),
        |ring| (ring.place() < most, ()),
    )?;
    let checked = results.checked("a chain of loads")?;
    Ok(checked.per_unit(&vec![LOADS as f64; sizes.len()]).into())
}
