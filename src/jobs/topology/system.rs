//! The queries of a topology to the system that it was read from: the only interface between this program and its
//! sources.

use serde::{Deserialize, Serialize};
use std::fmt;
use thiserror::Error;

/// Source of the description of cores, caches and NUMA nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// The library hwloc.
    #[cfg(feature = "hwloc")]
    Hwloc,
    /// The files of `/sys` and `/proc`.
    Sys,
}

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            #[cfg(feature = "hwloc")]
            Self::Hwloc => "hwloc",
            Self::Sys => "/sys",
        })
    }
}

/// Why a thread, or its memory, was not bound.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum BindingError {
    /// The topology describes another machine.
    #[error("the topology describes another machine")]
    Elsewhere,
    /// The system refuses to bind.
    #[error("the system refuses to bind: {detail}")]
    Refused {
        /// The system's message.
        detail: String,
    },
    /// The system accepted the request and did something else.
    #[error("the system bound a thread to a core that was not requested")]
    NotKept,
    /// The files of the system do not allow binding memory to a NUMA node; only hwloc does.
    #[error("binding memory to a NUMA node needs hwloc, which is not available here")]
    NoMemoryBinding,
}

/// The path from the cores of a node to the memory of a node, as reported by the firmware (ACPI's Heterogeneous Memory
/// Attribute Table); most machines report none.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct MemoryPath {
    /// Node of the cores, as the system numbers it.
    pub cpu_node: u32,
    /// Node of the memory.
    pub memory_node: u32,
    /// Bandwidth \[MiB/s\].
    pub bandwidth: Option<u64>,
    /// Latency \[ns\].
    pub latency: Option<u64>,
}

/// A machine that accepts queries and bindings.
pub(super) trait System: fmt::Debug + Send + Sync {
    /// Whether this is the machine that the program runs on.
    fn is_this_machine(&self) -> bool;

    /// Binds the calling thread to hardware threads.
    fn bind_thread(&self, threads: &[u32]) -> Result<(), BindingError>;

    /// Makes pages that the calling thread touches first come from a NUMA node.
    fn bind_memory(&self, node: u32) -> Result<(), BindingError>;

    /// The hardware thread that the calling thread last ran on.
    fn last_thread(&self) -> Option<u32>;

    /// NUMA nodes whose memory holds the values; empty if unknown.
    fn nodes_of_memory(&self, values: &[f64]) -> Vec<u32>;

    /// All pairs of nodes with a known path.
    fn memory_paths(&self) -> Vec<MemoryPath>;
}
