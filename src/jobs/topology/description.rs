//! Which cores may this process use, what do they share, and on which NUMA node is the calling thread?
//!
//! A machine without NUMA has one node, so the rest of the program needs no special case.

use super::system::{MemoryPath, Source, System};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// The machine cannot be described.
#[derive(Debug, Error)]
pub enum TopologyError {
    /// The system reports no processor.
    #[error(
        "the system reports neither its processors nor the processors that this process may use; check that /proc and \
         /sys are mounted"
    )]
    Unknown,
    /// A synthetic description that hwloc does not accept.
    #[cfg(feature = "hwloc")]
    #[error("`{description}` is not a synthetic topology: {detail}; try \"package:2 core:4 pu:2\"")]
    Synthetic {
        /// The text.
        description: String,
        /// hwloc's message.
        detail: String,
    },
}

/// A core that this process may use, at least in part.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Core {
    /// Package, counted from 0.
    pub package: usize,
    /// The NUMA node from which it prefers memory, numbered as by the system.
    pub numa_node: u32,
    /// Kind of core, slow ones first; all 0 if they are alike or the kind is unknown.
    pub kind: u32,
    /// Hardware threads of the core that this process may use, numbered as by the system.
    pub threads: Vec<u32>,
}

/// A NUMA node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NumaNode {
    /// Number by the system.
    pub index: u32,
    /// Memory it reports \[bytes\]; virtual machines and containers often report none.
    pub memory: Option<u64>,
    /// Free memory when the topology was read \[bytes\]; `None` if unknown.
    pub free: Option<u64>,
    /// Hardware threads near it that this process may use.
    pub threads: Vec<u32>,
}

/// A kind of data cache; all caches of a kind are assumed to be alike.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Cache {
    /// Level: 1, 2 or 3.
    pub level: usize,
    /// Size of one cache \[bytes\].
    pub size: u64,
    /// Length of a line \[bytes\]; `None` if unknown.
    pub line: Option<usize>,
    /// Number of caches.
    pub count: usize,
    /// Number of hardware threads that share one.
    pub shared_by: usize,
}

/// Cores, caches and NUMA nodes that this process may use.
#[derive(Debug)]
pub struct Topology {
    /// Processor packages.
    pub packages: usize,
    /// Cores, in an order in which neighbours share caches.
    pub cores: Vec<Core>,
    /// NUMA nodes, at least one.
    pub numa_nodes: Vec<NumaNode>,
    /// Data and unified caches, smallest level first.
    pub caches: Vec<Cache>,
    /// Source of the description.
    pub source: Source,
    pub(super) system: Box<dyn System>,
}

impl Topology {
    /// Hardware threads that this process may use.
    pub fn threads(&self) -> usize {
        self.cores.iter().map(|core| core.threads.len()).sum()
    }

    /// Whether this describes the machine that the program runs on: only then are threads bound.
    pub fn is_this_system(&self) -> bool {
        self.system.is_this_machine()
    }

    /// NUMA node near a hardware thread, both numbered as by the system.
    pub fn numa_node_of(&self, thread: u32) -> Option<u32> {
        self.numa_nodes
            .iter()
            .find(|node| node.threads.contains(&thread))
            .map(|node| node.index)
    }

    /// NUMA node on which the calling thread last ran; `None` if the system does not report it or the topology
    /// describes another machine.
    pub fn current_numa_node(&self) -> Option<u32> {
        if self.is_this_system() {
            self.numa_node_of(self.system.last_thread()?)
        } else {
            None
        }
    }

    /// NUMA nodes whose memory holds the values, numbered as by the system; empty if the system does not report it or
    /// the topology describes another machine.
    pub fn nodes_of_memory(&self, values: &[f64]) -> Vec<u32> {
        if self.is_this_system() && !values.is_empty() {
            self.system.nodes_of_memory(values)
        } else {
            Vec::new()
        }
    }

    /// All pairs of a node's cores and a node's memory for which the firmware reports a bandwidth or latency.
    pub fn memory_paths(&self) -> Vec<MemoryPath> {
        self.system.memory_paths()
    }
}
