//! Which NUMA nodes get a copy of what all workers read?
//!
//! A pure decision over the places of workers: where workers are bound and run on several nodes,
//! each of these nodes has a copy, which its own workers make and read; anywhere else one copy
//! does for all, since a worker that moves would leave its copy behind.

use super::{Plan, Topology};
use hwlocality::memory::binding::MemoryBindingFlags;
use hwlocality::memory::nodeset::NodeSet;
use std::fmt;

/// Copies of read-only data, by NUMA node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Copies {
    /// Node of each copy, as the system numbers it; none where one copy does for all.
    pub nodes: Vec<u32>,
    /// Which copy each worker reads, an index into `nodes`; none for the one of all.
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

impl Topology {
    /// NUMA nodes that the memory of some values lies on, as the system numbers them; none where
    /// it does not tell or the topology is not that of this machine.
    pub fn nodes_of_memory<T>(&self, values: &[T]) -> Vec<u32> {
        if !self.is_this_system() || size_of_val(values) == 0 {
            return Vec::new();
        }
        let found: Result<NodeSet, _> =
            (self.hwloc()).area_memory_location(values, MemoryBindingFlags::empty());
        let number = |node| u32::try_from(usize::from(node)).ok();
        found.map_or_else(
            |_| Vec::new(),
            |nodes| nodes.iter_set().filter_map(number).collect(),
        )
    }
}

#[cfg(test)]
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
        // Three of four nodes are used.
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
