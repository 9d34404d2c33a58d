//! Which NUMA nodes get a copy of data that all workers read?
//!
//! The decision depends only on the places of the workers. If workers are bound and run on several nodes,
//! each node gets a copy, which its workers make and read. Otherwise all workers share one copy: a worker that
//! is not bound may move to another node.

use super::{Plan, TABLES_AT_HAND, Topology};
use std::fmt;

/// Copies of read-only data, by NUMA node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Copies {
    /// Node of each copy, numbered as by the system; empty if all workers share one copy.
    pub nodes: Vec<u32>,
    /// The copy that each worker reads, as an index into `nodes`; `None` for the shared one.
    pub of_worker: Vec<Option<usize>>,
}

/// The copies for workers at these places.
pub fn copies(plan: &Plan) -> Copies {
    let mut nodes: Vec<u32> = plan.places.iter().map(|place| place.numa_node).collect();
    nodes.sort_unstable();
    nodes.dedup();
    if !plan.pinned || nodes.len() < 2 {
        nodes.clear();
    }
    let copy = |node: u32| nodes.binary_search(&node).ok();
    Copies {
        of_worker: plan
            .places
            .iter()
            .map(|place| copy(place.numa_node))
            .collect(),
        nodes,
    }
}

/// The room of a NUMA node for copies of tables that kernels read while they integrate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CopyRoom {
    /// Free memory of the node \[bytes\]; `None` if the system does not report it.
    pub free: Option<u64>,
    /// Largest private cache of a core \[bytes\]; 0 if unknown.
    pub private_cache: u64,
}

impl CopyRoom {
    /// Copies take at most this part, `1/SHARE`, of the free memory.
    const SHARE: u64 = 8;

    /// Whether a copy of a table of `bytes` on this node saves time. A table that fits in a core's private
    /// cache is read from another node only once. The copies of all tables at hand must fit in the part
    /// `1/SHARE` of the free memory.
    pub fn should_copy(&self, bytes: u64) -> bool {
        let all = bytes.saturating_mul(TABLES_AT_HAND as u64);
        let fits = self.free.is_none_or(|free| all <= free / Self::SHARE);
        bytes > self.private_cache && fits
    }
}

impl Topology {
    /// The room of each node with a copy, in the order of the copies.
    pub fn rooms(&self, copies: &Copies) -> Vec<CopyRoom> {
        let private_caches = self.caches.iter().filter(|cache| {
            let threads = self.cores.iter().map(|core| core.threads.len());
            cache.shared_by <= threads.max().unwrap_or(1)
        });
        let private_cache = private_caches.map(|cache| cache.size).max().unwrap_or(0);
        let free = |node: &u32| {
            self.numa_nodes
                .iter()
                .find(|known| known.index == *node)?
                .free
        };
        (copies.nodes.iter())
            .map(|node| CopyRoom {
                free: free(node),
                private_cache,
            })
            .collect()
    }
}

impl fmt::Display for Copies {
    /// `a copy on each of NUMA nodes 0, 1`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.nodes.is_empty() {
            return f.write_str("one copy for all workers");
        }
        let nodes: Vec<String> = self.nodes.iter().map(u32::to_string).collect();
        write!(f, "a copy on each of NUMA nodes {}", nodes.join(", "))
    }
}

#[cfg(test)]
#[cfg(feature = "hwloc")]
mod tests {
    use super::*;
    use crate::topology::{Pinning, plan};

    fn planned(description: &str, workers: usize, pinning: Pinning) -> Copies {
        let topology = Topology::synthetic(description).unwrap();
        copies(&plan(&topology.cores, workers, pinning))
    }

    #[test]
    fn bound_workers_on_several_nodes_have_a_copy_a_node() {
        let two = "package:2 [numa] core:2 pu:2";
        let found = planned(two, 4, Pinning::Full);
        assert_eq!(found.nodes, [0, 1]);
        assert_eq!(found.of_worker, [Some(0), Some(0), Some(1), Some(1)]);
        assert_eq!(found.to_string(), "a copy on each of NUMA nodes 0, 1");
        // Second hardware threads read the copy of their core's node.
        let found = planned(two, 8, Pinning::Full);
        assert_eq!(found.of_worker[4..], [Some(0), Some(0), Some(1), Some(1)]);
        let four = planned("package:2 numa:2 core:1 pu:1", 4, Pinning::Full);
        assert_eq!(four.nodes, [0, 1, 2, 3]);
        // Workers use three of four nodes.
        let three = planned("package:2 numa:2 core:1 pu:1", 3, Pinning::Always);
        assert_eq!(three.nodes, [0, 1, 2]);
    }

    #[test]
    fn anywhere_else_one_copy_does() {
        let two = "package:2 [numa] core:2 pu:2";
        for (description, workers, pinning) in [
            ("package:1 core:4 pu:2", 4, Pinning::Full),
            (two, 2, Pinning::Full),
            (two, 4, Pinning::Never),
            (two, 1, Pinning::Always),
        ] {
            let found = planned(description, workers, pinning);
            assert!(found.nodes.is_empty(), "{description} {workers}");
            assert_eq!(found.of_worker, vec![None; workers]);
            assert_eq!(found.to_string(), "one copy for all workers");
        }
        let unknown = copies(&plan(&[], 3, Pinning::Always));
        assert!(unknown.nodes.is_empty() && unknown.of_worker.is_empty());
    }

    /// One node, two sockets, four nodes of unequal memory, and a package divided into eight.
    #[test]
    fn tables_are_copied_where_there_is_room_and_a_use() {
        const TABLE: u64 = 7 << 20;
        let should_copy = |description: &str, free: &[Option<u64>], bytes: u64| -> Vec<bool> {
            let topology = Topology::synthetic(description).unwrap();
            let plan = plan(&topology.cores, topology.cores.len(), Pinning::Full);
            let mut rooms = topology.rooms(&copies(&plan));
            for (room, free) in rooms.iter_mut().zip(free) {
                room.free = *free;
            }
            rooms.iter().map(|room| room.should_copy(bytes)).collect()
        };
        let plenty = Some(64 << 30);
        let one = "package:1 l2(size=1MB):4 core:1 pu:2";
        assert!(
            should_copy(one, &[plenty], TABLE).is_empty(),
            "one node, no copy"
        );
        let two = "package:2 [numa] l2(size=1MB):4 core:1 pu:2";
        assert_eq!(should_copy(two, &[plenty; 2], TABLE), [true, true]);
        assert_eq!(
            should_copy(two, &[None; 2], TABLE),
            [true, true],
            "nobody tells"
        );
        assert_eq!(
            should_copy(two, &[plenty; 2], 1 << 19),
            [false, false],
            "in cache"
        );
        let four = "package:4 [numa] l2(size=1MB):2 core:1 pu:1";
        let free = [plenty, Some(200 << 20), Some(224 << 20), None];
        assert_eq!(should_copy(four, &free, TABLE), [true, false, true, true]);
        let clusters = "package:2 numa:4 l2(size=2MB):2 core:1 pu:2";
        assert_eq!(should_copy(clusters, &[plenty; 8], TABLE), [true; 8]);
        assert_eq!(should_copy(clusters, &[plenty; 8], u64::MAX), [false; 8]);
    }

    #[test]
    fn memory_lies_on_a_node_of_this_machine() {
        let topology = Topology::current().unwrap();
        let values = vec![1.0; 4096];
        for node in topology.nodes_of_memory(&values) {
            assert!(topology.numa_nodes.iter().any(|known| known.index == node));
        }
        let elsewhere = Topology::synthetic("package:2 [numa] core:2 pu:1").unwrap();
        assert!(elsewhere.nodes_of_memory(&values).is_empty());
    }
}
