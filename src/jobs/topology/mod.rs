//! Cores, caches and NUMA nodes of this machine.
//!
//! hwloc describes them if the program is built with the feature `hwloc`, otherwise the files of the system. Nothing
//! outside this module depends on the source.

mod affinity;
mod binding;
mod copies;
mod current;
mod description;
#[cfg(feature = "hwloc")]
mod hwloc;
mod machine;
mod placement;
mod sysfs;
mod system;

pub use affinity::{NodeTables, TABLES_AT_HAND, TableDistance};
pub use copies::{Copies, CopyRoom, copies};
pub use description::{Cache, Core, NumaNode, Topology, TopologyError};
pub use machine::{Machine, ProcessorClock, peak_memory};
pub use machine::{bytes_of_kib_field, field};
pub use placement::{Pinning, Place, Plan, default_workers, plan};
pub use system::{BindingError, MemoryPath, Source};
