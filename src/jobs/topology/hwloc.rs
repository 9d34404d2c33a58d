//! The machine as hwloc describes it. Only this file uses the library.

use super::description::{Cache, Core, NumaNode, Topology};
use super::machine::free_memory;
use super::system::{BindingError, MemoryPath, Source, System};
use hwlocality::Topology as Hwloc;
use hwlocality::bitmap::BitmapIndex as NodeIndex;
use hwlocality::cpu::binding::CpuBindingFlags;
use hwlocality::cpu::cpuset::CpuSet;
use hwlocality::memory::attribute::MemoryAttribute;
use hwlocality::memory::binding::{MemoryBindingFlags, MemoryBindingPolicy};
use hwlocality::memory::nodeset::NodeSet;
use hwlocality::object::TopologyObject;
use hwlocality::object::attributes::ObjectAttributes;
use hwlocality::object::types::{CacheType, ObjectType};
use std::path::Path;

/// This machine, or the one that `HWLOC_SYNTHETIC` describes; `None` if hwloc cannot read it.
pub(super) fn of_this_machine() -> Option<Topology> {
    Hwloc::new().ok().map(describe)
}

/// A fictitious machine; hwloc's message if it does not accept the description.
pub(super) fn synthetic(description: &str) -> Result<Topology, String> {
    let builder = Hwloc::builder().from_synthetic(description);
    let builder = builder.map_err(|error| error.to_string())?;
    let built = builder.build().map_err(|error| error.to_string())?;
    Ok(describe(built))
}

fn describe(hwloc: Hwloc) -> Topology {
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
                .then(|| free_memory(Path::new("/"), os_index(node)))
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
    Topology {
        packages,
        cores,
        numa_nodes,
        caches,
        source: Source::Hwloc,
        system: Box::new(hwloc),
    }
}

fn refused(detail: impl ToString) -> BindingError {
    BindingError::Refused {
        detail: detail.to_string(),
    }
}

impl System for Hwloc {
    fn is_this_machine(&self) -> bool {
        self.is_this_system()
    }

    fn bind_thread(&self, threads: &[u32]) -> Result<(), BindingError> {
        let mut set = CpuSet::new();
        for unit in self.objects_with_type(ObjectType::PU) {
            let known = unit.os_index().and_then(|index| u32::try_from(index).ok());
            if let (Some(index), Some(unit_cpus)) = (known, unit.cpuset())
                && threads.contains(&index)
            {
                set |= &*unit_cpus;
            }
        }
        self.bind_cpu(&set, CpuBindingFlags::THREAD)
            .map_err(refused)?;
        let bound = self.cpu_binding(CpuBindingFlags::THREAD).map_err(refused)?;
        if bound == set { Ok(()) } else { Err(BindingError::NotKept) }
    }

    fn bind_memory(&self, node: u32) -> Result<(), BindingError> {
        let index = NodeIndex::try_from(node as usize).map_err(|_| refused("no such node"))?;
        let (policy, flags) = (MemoryBindingPolicy::Bind, MemoryBindingFlags::THREAD);
        Hwloc::bind_memory(self, &NodeSet::from(index), policy, flags).map_err(refused)
    }

    fn last_thread(&self) -> Option<u32> {
        let location = self.last_cpu_location(CpuBindingFlags::THREAD).ok()?;
        u32::try_from(usize::from(location.first_set()?)).ok()
    }

    fn nodes_of_memory(&self, values: &[f64]) -> Vec<u32> {
        let nodes: Result<NodeSet, _> =
            self.area_memory_location(values, MemoryBindingFlags::empty());
        let number = |node| u32::try_from(usize::from(node)).ok();
        nodes.map_or_else(
            |_| Vec::new(),
            |nodes| nodes.iter_set().filter_map(number).collect(),
        )
    }

    fn memory_paths(&self) -> Vec<MemoryPath> {
        let bandwidths = [
            MemoryAttribute::bandwidth(self),
            MemoryAttribute::read_bandwidth(self),
        ];
        let latencies = [
            MemoryAttribute::latency(self),
            MemoryAttribute::read_latency(self),
        ];
        let nodes: Vec<&TopologyObject> = self.objects_with_type(ObjectType::NUMANode).collect();
        let mut paths = Vec::new();
        for cores in nodes.iter().copied() {
            let Some(cpuset) = cores.cpuset().filter(|set| !set.is_empty()) else {
                continue;
            };
            for memory in nodes.iter().copied() {
                // Attributes that this machine does not have give an error: their values are unknown.
                let first_known = |attributes: &[MemoryAttribute<'_>; 2]| {
                    let value = |a: &MemoryAttribute<'_>| a.value(Some((&*cpuset).into()), memory);
                    attributes.iter().find_map(|a| value(a).ok().flatten())
                };
                let path = MemoryPath {
                    cpu_node: os_index(cores),
                    memory_node: os_index(memory),
                    bandwidth: first_known(&bandwidths),
                    latency: first_known(&latencies),
                };
                if path.bandwidth.or(path.latency).is_some() {
                    paths.push(path);
                }
            }
        }
        paths
    }
}

/// hwloc numbers every object that is used here; one without a number counts as 0.
fn os_index(object: &TopologyObject) -> u32 {
    object
        .os_index()
        .and_then(|index| u32::try_from(index).ok())
        .unwrap_or(0)
}

/// Hardware threads that the system allows this process and that the calling thread is bound to (`taskset`).
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
        // hwloc sorts the kinds, slow ones first, if it knows their efficiency.
        Ok(kinds) if kinds.clone().all(|kind| kind.efficiency.is_some()) => {
            kinds.map(|kind| kind.cpuset).collect()
        }
        _ => Vec::new(),
    };
    let kind = |object: &TopologyObject| {
        let cpus = object.cpuset();
        let at = cpus.and_then(|cpus| kinds.iter().position(|kind| kind.includes(cpus)));
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

/// The NUMA node attached to the object or to its closest ancestor that has one; 0 if none has.
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
}
