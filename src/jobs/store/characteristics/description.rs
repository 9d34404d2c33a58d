//! A machine as its system describes it.

use crate::topology::{Cache, MemoryPath};
use serde::{Deserialize, Serialize};

/// A machine as its system describes it; what it does not tell is absent or empty.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Description {
    /// Processor, as it names itself.
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
    /// Who told of cores, caches and nodes: `hwloc`, or the files of `/sys`; empty in results of
    /// earlier versions.
    #[serde(default)]
    pub topology: String,
    /// Hardware threads that the machine has, this process's or not.
    pub threads_online: Option<usize>,
    /// The hardware threads this process may use, as the system writes them (`0-3,8`).
    pub allowed: Option<String>,
    /// Processors' worth of time that a control group grants.
    pub quota_percent: Option<u64>,
    /// Data and unified caches, smallest level first.
    pub caches: Vec<Cache>,
    /// NUMA nodes.
    pub nodes: Vec<NodeRecord>,
    /// What the firmware tells of the way from the cores of a node to the memory of a node.
    pub paths: Vec<MemoryPath>,
    /// What the system does about pages on other nodes than the threads that use them: 0 nothing,
    /// 1 moves them, 2 moves them between kinds of memory (`/proc/sys/kernel/numa_balancing`).
    pub numa_balancing: Option<u32>,
    /// Memory \[bytes\].
    pub memory: u64,
    /// Memory that could be taken when the measurements began \[bytes\].
    pub memory_available: Option<u64>,
    /// Most memory that a control group grants \[bytes\].
    pub memory_limit: Option<u64>,
    /// Pages larger than usual.
    pub huge_pages: HugePages,
    /// How the processor chooses its frequency; absent where the system leaves it to others.
    pub governor: Option<String>,
    /// Highest frequency \[Hz\].
    pub frequency: Option<u64>,
    /// The hypervisor, where the machine is virtual.
    pub hypervisor: Option<String>,
    /// The kind of container that this runs in.
    pub container: Option<String>,
}

/// A NUMA node.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct NodeRecord {
    /// As the system numbers it.
    pub index: u32,
    /// Memory it reports \[bytes\].
    pub memory: Option<u64>,
    /// Hardware threads near it that this process may use.
    pub threads: usize,
    /// Distances to all nodes, in the order of their numbers; 10 to itself.
    pub distances: Vec<u32>,
}

/// Pages larger than usual.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct HugePages {
    /// Whether the system makes them by itself: always, madvise (where asked) or never.
    pub transparent: Option<String>,
    /// Size of one \[bytes\].
    pub size: Option<u64>,
    /// How many are set aside.
    pub reserved: Option<u64>,
}
