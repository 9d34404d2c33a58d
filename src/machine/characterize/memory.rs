//! Buffers on a chosen node.

use super::buffer::{Buffer, LINE};
use super::error::MeasurementError;
use crate::topology::Topology;

/// A buffer filled with `value`. The calling thread touches it first, so that it is near this thread under
/// the system's default policy.
pub fn near(lines: usize, value: f64) -> Result<Buffer, MeasurementError> {
    let mut buffer = untouched(lines)?;
    buffer.fill(value);
    Ok(buffer)
}

/// As [`near`], on huge pages.
pub fn on_huge_pages(lines: usize, value: f64) -> Result<Buffer, MeasurementError> {
    let mut buffer = untouched(lines)?;
    let refused = |source| MeasurementError::HugePages { source };
    buffer.ask_for_huge_pages().map_err(refused)?;
    buffer.fill(value);
    Ok(buffer)
}

/// A buffer of untouched pages.
pub fn untouched(lines: usize) -> Result<Buffer, MeasurementError> {
    Buffer::new(lines).map_err(|source| MeasurementError::Memory {
        bytes: lines * LINE,
        source,
    })
}

/// A buffer on a node, filled with 1. A new thread touches it first. This thread is bound to the cores of the node; if
/// the node has none, the memory of the thread is bound to the node.
pub fn on_node(topology: &Topology, node: u32, lines: usize) -> Result<Buffer, MeasurementError> {
    let cores = topology.cores.iter().filter(|core| core.numa_node == node);
    let threads: Vec<u32> = cores.flat_map(|core| core.threads.clone()).collect();
    let touch = || {
        let bound = if threads.is_empty() {
            topology.bind_memory_of_current_thread(node)
        } else {
            topology.bind_current_thread(&threads)
        };
        bound.map_err(|error| MeasurementError::Node {
            node,
            detail: error.to_string(),
        })?;
        near(lines, 1.0)
    };
    std::thread::scope(|scope| {
        let toucher = scope.spawn(touch);
        (toucher.join()).unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}
