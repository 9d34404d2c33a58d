//! Selects the source that describes this machine: hwloc if the program was built with it and it works,
//! otherwise the files of the system.

use super::description::{Topology, TopologyError};
#[cfg(feature = "hwloc")]
use super::hwloc;
use super::sysfs;

impl Topology {
    /// The machine that the program runs on, or, with hwloc, the one that `HWLOC_SYNTHETIC` describes.
    ///
    /// # Errors
    /// No source reports the processors.
    pub fn current() -> Result<Self, TopologyError> {
        #[cfg(feature = "hwloc")]
        if let Some(found) = hwloc::of_this_machine() {
            return Ok(found);
        }
        sysfs::of_this_machine()
    }

    /// A fictitious machine in hwloc's notation (`package:2 core:4 pu:2`), for trying out decisions. Nothing
    /// is bound to it.
    ///
    /// # Errors
    /// hwloc does not accept the description.
    #[cfg(feature = "hwloc")]
    pub fn synthetic(description: &str) -> Result<Self, TopologyError> {
        hwloc::synthetic(description).map_err(|detail| TopologyError::Synthetic {
            description: description.into(),
            detail,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn this_machine_has_a_core_and_a_node() {
        for topology in [Topology::current(), sysfs::of_this_machine()].map(Result::unwrap) {
            assert!(topology.threads() >= 1 && topology.is_this_system());
            let mut nodes = topology.numa_nodes.iter();
            assert!(nodes.any(|node| !node.threads.is_empty()));
            if let Some(node) = topology.current_numa_node() {
                let mut nodes = topology.numa_nodes.iter();
                assert!(nodes.any(|known| known.index == node));
            }
        }
    }

    /// On the machine of the test, both sources report the same threads and the same sizes.
    #[test]
    #[cfg(feature = "hwloc")]
    fn hwloc_and_the_files_of_the_system_agree() {
        use crate::topology::Source;
        let by_hwloc = hwloc::of_this_machine().unwrap();
        let by_files = sysfs::of_this_machine().unwrap();
        let sources = (by_hwloc.source, by_files.source);
        assert_eq!(sources, (Source::Hwloc, Source::Sys));
        assert_eq!(by_hwloc.packages, by_files.packages);
        assert_eq!(by_hwloc.cores, by_files.cores);
        assert_eq!(by_hwloc.caches, by_files.caches);
        let nodes = |topology: &Topology| {
            let nodes = topology.numa_nodes.iter();
            // Free memory changes between readings.
            let known = nodes.map(|node| (node.index, node.memory, node.threads.clone()));
            known.collect::<Vec<_>>()
        };
        assert_eq!(nodes(&by_hwloc), nodes(&by_files));
        assert_eq!(by_hwloc.memory_paths(), by_files.memory_paths());
    }
}
