//! A machine as its system describes it.

use crate::topology::{Cache, MemoryPath};
use serde::{Deserialize, Serialize};

/// A machine as its system describes it; unknown parts are absent or empty.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Description {
    /// Name of the processor.
    pub cpu: String,
    /// Operating system, its kernel's version and architecture.
    pub system: String,
    /// Instruction sets that kernels can use, widest last.
    pub isa: Vec<String>,
    /// Processor packages.
    pub packages: usize,
    /// Cores this process may use.
    pub cores: usize,
    /// Hardware threads this process may use.
    pub threads: usize,
    /// Source of cores, caches and nodes: `hwloc`, or the files of `/sys`; empty in results of earlier versions.
    #[serde(default)]
    pub topology: String,
    /// Hardware threads of the machine, including those that this process may not use.
    pub threads_online: Option<usize>,
    /// The hardware threads this process may use, as the system writes them (`0-3,8`).
    pub allowed: Option<String>,
    /// Processor time that a control group grants, in percent of one processor.
    pub quota_percent: Option<u64>,
    /// Data and unified caches, smallest level first.
    pub caches: Vec<Cache>,
    /// NUMA nodes.
    pub nodes: Vec<NodeRecord>,
    /// Bandwidths and latencies from the cores of a node to the memory of a node, as reported by the firmware.
    pub paths: Vec<MemoryPath>,
    /// The system's treatment of pages on other nodes than the threads that use them: 0 leaves them, 1 moves them, 2
    /// moves them between kinds of memory (`/proc/sys/kernel/numa_balancing`).
    pub numa_balancing: Option<u32>,
    /// Memory \[bytes\].
    pub memory: u64,
    /// Available memory at the start of the measurements \[bytes\].
    pub memory_available: Option<u64>,
    /// Largest memory that a control group grants \[bytes\].
    pub memory_limit: Option<u64>,
    /// Huge pages: pages of memory larger than usual.
    pub huge_pages: HugePages,
    /// The processor's rule for its frequency; absent if the system does not control it.
    pub governor: Option<String>,
    /// Highest frequency \[Hz\].
    pub frequency: Option<u64>,
    /// The hypervisor of a virtual machine.
    pub hypervisor: Option<String>,
    /// The kind of container that the program runs in.
    pub container: Option<String>,
}

/// A NUMA node.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct NodeRecord {
    /// Number of the node in the system.
    pub index: u32,
    /// Memory that the node reports \[bytes\].
    pub memory: Option<u64>,
    /// Hardware threads near the node that this process may use.
    pub threads: usize,
    /// Distances to all nodes, in the order of their numbers; 10 to the node itself.
    pub distances: Vec<u32>,
}

/// Huge pages: pages of memory larger than usual.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct HugePages {
    /// When the system makes them automatically: always, madvise (on request) or never.
    pub transparent: Option<String>,
    /// Size of a huge page \[bytes\].
    pub size: Option<u64>,
    /// Number of reserved huge pages.
    pub reserved: Option<u64>,
}
