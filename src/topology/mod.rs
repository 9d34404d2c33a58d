//! Cores, caches and NUMA nodes of this machine.

mod description;
mod machine;

pub use description::{Cache, Core, NumaNode, Topology, TopologyError};
pub use machine::Machine;
