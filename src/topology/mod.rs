//! Cores, caches and NUMA nodes of this machine.

mod affinity;
mod binding;
mod copies;
mod description;
mod machine;
mod memory_paths;
mod placement;

pub use affinity::{Nearness, Shelves, TABLES_AT_HAND};
pub use binding::BindingError;
pub use copies::{Copies, Room, copies};
pub use description::{Cache, Core, NumaNode, Topology, TopologyError};
pub use machine::{Machine, peak_memory};
pub(crate) use machine::{field, kibibytes};
pub use memory_paths::MemoryPath;
pub use placement::{Pinning, Place, Plan, default_workers, plan};
