//! Which cores may this process use, what do they share, and on which NUMA node is the
//! calling thread?
//!
//! Machines without NUMA show as one node, so nothing else in the program needs a special case.

use super::system::{MemoryPath, Source, System};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// The machine cannot be described.
#[derive(Debug, Error)]
pub enum TopologyError {
    /// The system tells of no processor.
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
        /// hwloc's own words.
        detail: String,
    },
}

/// A core that this process may use, at least in part.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Core {
    /// Package it lies in, counted from 0.
    pub package: usize,
    /// NUMA node its memory comes from first, as the system numbers it.
    pub numa_node: u32,
    /// Which kind of core, slow ones first; all 0 where they are alike or nobody tells.
    pub kind: u32,
    /// Its hardware threads that this process may use, as the system numbers them.
    pub threads: Vec<u32>,
}

/// A NUMA node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NumaNode {
    /// As the system numbers it.
    pub index: u32,
    /// Memory it reports \[bytes\]; virtual machines and containers often report none.
    pub memory: Option<u64>,
    /// Memory free on it when the topology was read \[bytes\], where the system tells.
    pub free: Option<u64>,
    /// Hardware threads near it that this process may use.
    pub threads: Vec<u32>,
}

/// A kind of data cache; all of one kind are taken to be alike.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Cache {
    /// 1, 2, 3 …
    pub level: usize,
    /// Size of one \[bytes\].
    pub size: u64,
    /// Length of a line \[bytes\], where known.
    pub line: Option<usize>,
    /// How many there are.
    pub count: usize,
    /// Hardware threads that share one.
    pub shared_by: usize,
}

/// Cores, caches and NUMA nodes that this process may use.
#[derive(Debug)]
pub struct Topology {
    /// Processor packages.
    pub packages: usize,
    /// Cores: neighbours share caches.
    pub cores: Vec<Core>,
    /// NUMA nodes, at least one.
    pub numa_nodes: Vec<NumaNode>,
    /// Data and unified caches, smallest level first.
    pub caches: Vec<Cache>,
    /// Who told of all this.
    pub source: Source,
    pub(super) system: Box<dyn System>,
}

impl Topology {
    /// Hardware threads that this process may use.
    pub fn threads(&self) -> usize {
        self.cores.iter().map(|core| core.threads.len()).sum()
    }

    /// Whether this describes the machine it runs on: only then does binding take place.
    pub fn is_this_system(&self) -> bool {
        self.system.is_here()
    }

    /// NUMA node near a hardware thread, both as the system numbers them.
    pub fn numa_node_of(&self, thread: u32) -> Option<u32> {
        self.numa_nodes
            .iter()
            .find(|node| node.threads.contains(&thread))
            .map(|node| node.index)
    }

    /// NUMA node where the calling thread last ran; none where the system does not tell
    /// or the topology is not that of this machine.
    pub fn current_numa_node(&self) -> Option<u32> {
        if self.is_this_system() {
            self.numa_node_of(self.system.last_thread()?)
        } else {
            None
        }
    }

    /// NUMA nodes that the memory of some values lies on, as the system numbers them; none where
    /// it does not tell or the topology is not that of this machine.
    pub fn nodes_of_memory(&self, values: &[f64]) -> Vec<u32> {
        if self.is_this_system() && !values.is_empty() {
            self.system.nodes_of_memory(values)
        } else {
            Vec::new()
        }
    }

    /// All ways from the cores of a node to the memory of a node of which the firmware tells
    /// something.
    pub fn memory_paths(&self) -> Vec<MemoryPath> {
        self.system.memory_paths()
    }
}
