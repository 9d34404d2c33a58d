//! Cores, caches and NUMA nodes of this machine.
//!
//! hwloc tells of them where the program is built with the feature `hwloc`, the files of the system
//! anywhere else; nothing outside this module knows the difference.

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

pub use affinity::{Nearness, Shelves, TABLES_AT_HAND};
pub use copies::{Copies, Room, copies};
pub use description::{Cache, Core, NumaNode, Topology, TopologyError};
pub use machine::{Machine, ProcessorClock, peak_memory};
pub use machine::{field, kibibytes};
pub use placement::{Pinning, Place, Plan, default_workers, plan};
pub use system::{BindingError, MemoryPath, Source};
