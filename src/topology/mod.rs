//! Cores, caches and NUMA nodes of this machine.

mod binding;
mod copies;
mod description;
mod machine;
mod placement;

pub use binding::BindingError;
pub use copies::{Copies, copies};
pub use description::{Cache, Core, NumaNode, Topology, TopologyError};
pub use machine::{Machine, peak_memory};
pub use placement::{Pinning, Plan, Seat, default_workers, plan};
