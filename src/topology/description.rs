//! Which cores may this process use, what do they share, and on which NUMA node is the
//! calling thread?
//!
//! A thin reading of hwloc. Machines without NUMA show as one node, so nothing else in
//! the program needs a special case.

use super::machine::free_memory;
use hwlocality::Topology as Hwloc;
use hwlocality::cpu::binding::CpuBindingFlags;
use hwlocality::cpu::cpuset::CpuSet;
use hwlocality::object::TopologyObject;
use hwlocality::object::attributes::ObjectAttributes;
use hwlocality::object::types::{CacheType, ObjectType};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// The machine cannot be described.
#[derive(Debug, Error)]
pub enum TopologyError {
    /// hwloc does not load this machine's topology.
    #[error("hwloc cannot read this machine's topology: {detail}; check that /sys is mounted")]
    Load {
        /// hwloc's own words.
        detail: String,
    },
    /// A synthetic description that hwloc does not accept.
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
    /// Cores, in hwloc's order: neighbours share caches.
    pub cores: Vec<Core>,
    /// NUMA nodes, at least one.
    pub numa_nodes: Vec<NumaNode>,
    /// Data and unified caches, smallest level first.
    pub caches: Vec<Cache>,
    hwloc: Hwloc,
}

impl Topology {
    /// The machine this runs on, or the one that `HWLOC_SYNTHETIC` describes.
    ///
    /// # Errors
    /// hwloc cannot read the machine.
    pub fn current() -> Result<Self, TopologyError> {
        let hwloc = Hwloc::new().map_err(|error| TopologyError::Load {
            detail: error.to_string(),
        })?;
        Ok(Self::describe(hwloc))
    }

    /// A machine that does not exist, in hwloc's notation (`package:2 core:4 pu:2`); for
    /// trying out decisions. Binding to it succeeds and does nothing.
    ///
    /// # Errors
    /// hwloc does not accept the description.
    pub fn synthetic(description: &str) -> Result<Self, TopologyError> {
        let refused = |detail: String| TopologyError::Synthetic {
            description: description.into(),
            detail,
        };
        let hwloc = Hwloc::builder()
            .from_synthetic(description)
            .map_err(|error| refused(error.to_string()))?
            .build()
            .map_err(|error| refused(error.to_string()))?;
        Ok(Self::describe(hwloc))
    }

    fn describe(hwloc: Hwloc) -> Self {
        let usable = usable(&hwloc);
        let cores = describe_cores(&hwloc, &usable);
        let mut numa_nodes: Vec<NumaNode> = hwloc
            .objects_with_type(ObjectType::NUMANode)
            .map(|node| NumaNode {
                index: os_index(node),
                memory: match node.attributes() {
                    Some(ObjectAttributes::NUMANode(node)) => {
                        node.local_memory().map(std::num::NonZero::get)
                    }
                    _ => None,
                },
                free: (hwloc.is_this_system())
                    .then(|| free_memory(os_index(node)))
                    .flatten(),
                threads: usable_threads(&usable, node),
            })
            .collect();
        if numa_nodes.is_empty() {
            let threads = cores.iter().flat_map(|core| core.threads.clone()).collect();
            numa_nodes.push(NumaNode {
                index: 0,
                memory: None,
                free: None,
                threads,
            });
        }
        let packages = hwloc.objects_with_type(ObjectType::Package).count().max(1);
        let caches = describe_caches(&hwloc);
        Self {
            packages,
            cores,
            numa_nodes,
            caches,
            hwloc,
        }
    }

    /// Hardware threads that this process may use.
    pub fn threads(&self) -> usize {
        self.cores.iter().map(|core| core.threads.len()).sum()
    }

    /// The hwloc topology itself, for binding.
    pub fn hwloc(&self) -> &Hwloc {
        &self.hwloc
    }

    /// Whether this describes the machine it runs on: only then does binding take place.
    pub fn is_this_system(&self) -> bool {
        self.hwloc.is_this_system()
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
        if !self.is_this_system() {
            return None;
        }
        let location = self.hwloc.last_cpu_location(CpuBindingFlags::THREAD).ok()?;
        let thread = u32::try_from(usize::from(location.first_set()?)).ok()?;
        self.numa_node_of(thread)
    }
}

/// hwloc numbers every object used here; one without a number counts as 0.
pub(super) fn os_index(object: &TopologyObject) -> u32 {
    object
        .os_index()
        .and_then(|index| u32::try_from(index).ok())
        .unwrap_or(0)
}

/// Hardware threads that the system allows this process and that it is bound to (`taskset`).
fn usable(hwloc: &Hwloc) -> CpuSet {
    let allowed = hwloc.allowed_cpuset().clone_target();
    match hwloc.cpu_binding(CpuBindingFlags::THREAD) {
        Ok(bound) if hwloc.is_this_system() && bound.intersects(&allowed) => allowed & bound,
        _ => allowed,
    }
}

/// The threads of an object that this process may use.
fn usable_threads(usable: &CpuSet, object: &TopologyObject) -> Vec<u32> {
    let Some(cpuset) = object.cpuset() else {
        return Vec::new();
    };
    cpuset
        .iter_set()
        .filter(|&thread| usable.is_set(thread))
        .filter_map(|thread| u32::try_from(usize::from(thread)).ok())
        .collect()
}

fn describe_cores(hwloc: &Hwloc, usable: &CpuSet) -> Vec<Core> {
    let kinds: Vec<CpuSet> = match hwloc.cpu_kinds() {
        // Sorted by speed where that is known.
        Ok(kinds) if kinds.clone().all(|kind| kind.efficiency.is_some()) => {
            kinds.map(|kind| kind.cpuset).collect()
        }
        _ => Vec::new(),
    };
    let kind = |object: &TopologyObject| {
        let own = object.cpuset();
        let at = own.and_then(|own| kinds.iter().position(|kind| kind.includes(own)));
        at.map_or(0, |at| at as u32)
    };
    let core = |object: &TopologyObject| Core {
        package: object
            .first_ancestor_with_type(ObjectType::Package)
            .map_or(0, TopologyObject::logical_index),
        numa_node: nearest_node(object),
        kind: kind(object),
        threads: usable_threads(usable, object),
    };
    let has_threads = |core: &Core| !core.threads.is_empty();
    let cores: Vec<Core> = hwloc
        .objects_with_type(ObjectType::Core)
        .map(core)
        .filter(has_threads)
        .collect();
    if !cores.is_empty() {
        return cores;
    }
    // Some virtual machines report hardware threads but no cores.
    hwloc
        .objects_with_type(ObjectType::PU)
        .map(core)
        .filter(has_threads)
        .collect()
}

/// The node attached to the closest ancestor that has one.
fn nearest_node(object: &TopologyObject) -> u32 {
    std::iter::once(object)
        .chain(object.ancestors())
        .flat_map(TopologyObject::memory_children)
        .find(|child| child.object_type() == ObjectType::NUMANode)
        .map_or(0, os_index)
}

fn describe_caches(hwloc: &Hwloc) -> Vec<Cache> {
    let levels = [
        ObjectType::L1Cache,
        ObjectType::L2Cache,
        ObjectType::L3Cache,
    ];
    let mut caches = Vec::new();
    for level in levels {
        let mut objects = hwloc.objects_with_type(level).peekable();
        let Some(first) = objects.peek() else {
            continue;
        };
        let Some(ObjectAttributes::Cache(cache)) = first.attributes() else {
            continue;
        };
        if cache.cache_type() == CacheType::Instruction {
            continue;
        }
        caches.push(Cache {
            level: cache.depth(),
            size: cache.size().map_or(0, std::num::NonZero::get),
            line: cache.line_size().map(std::num::NonZero::get),
            shared_by: first.cpuset().and_then(|set| set.weight()).unwrap_or(1),
            count: objects.count(),
        });
    }
    caches
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_sockets() {
        let topology =
            Topology::synthetic("package:2 [numa] l3:1(size=36700160) core:14 pu:2").unwrap();
        assert_eq!(topology.packages, 2);
        assert_eq!(topology.cores.len(), 28);
        assert_eq!(topology.threads(), 56);
        assert_eq!(topology.numa_nodes.len(), 2);
        assert_eq!(topology.cores[13].package, 0);
        assert_eq!(topology.cores[14].package, 1);
        assert_eq!(topology.cores[14].numa_node, 1);
        assert_eq!(topology.cores[14].threads, [28, 29]);
        assert_eq!(topology.numa_node_of(27), Some(0));
        assert_eq!(topology.numa_node_of(28), Some(1));
        assert_eq!(topology.numa_node_of(56), None);
        let [cache] = topology.caches[..] else {
            panic!("{:?}", topology.caches)
        };
        assert_eq!((cache.level, cache.size), (3, 36_700_160));
        assert_eq!((cache.count, cache.shared_by), (2, 28));
    }

    #[test]
    fn several_nodes_in_a_package() {
        let topology = Topology::synthetic("package:1 numa:4 core:2 pu:1").unwrap();
        let nodes: Vec<u32> = topology.cores.iter().map(|core| core.numa_node).collect();
        assert_eq!(nodes, [0, 0, 1, 1, 2, 2, 3, 3]);
        assert_eq!(topology.packages, 1);
    }

    #[test]
    fn threads_without_cores_count_as_cores() {
        let topology = Topology::synthetic("pu:3").unwrap();
        assert_eq!(topology.cores.len(), 3);
        assert_eq!(topology.numa_nodes.len(), 1);
        assert_eq!(topology.numa_nodes[0].threads, [0, 1, 2]);
    }

    #[test]
    fn nobody_runs_on_a_synthetic_machine() {
        let topology = Topology::synthetic("package:2 core:2 pu:1").unwrap();
        assert!(!topology.is_this_system());
        assert_eq!(topology.current_numa_node(), None);
    }

    #[test]
    fn a_bad_description_says_how_to_write_a_good_one() {
        let error = Topology::synthetic("wheels:4").unwrap_err();
        assert!(
            error.to_string().contains("package:2 core:4 pu:2"),
            "{error}"
        );
    }

    #[test]
    fn this_machine_has_a_core_and_a_node() {
        let topology = Topology::current().unwrap();
        assert!(topology.threads() >= 1);
        assert!(
            topology
                .numa_nodes
                .iter()
                .any(|node| !node.threads.is_empty())
        );
        if let Some(node) = topology.current_numa_node() {
            assert!(topology.numa_nodes.iter().any(|known| known.index == node));
        }
    }
}
