//! What does the firmware tell of the way from cores to memory? Tables of servers (ACPI's
//! Heterogeneous Memory Attribute Table) that hwloc reads; most machines have none.

use super::Topology;
use super::description::os_index;
use hwlocality::memory::attribute::MemoryAttribute;
use hwlocality::object::TopologyObject;
use hwlocality::object::types::ObjectType;
use serde::{Deserialize, Serialize};

/// The way from the cores of a node to the memory of a node.
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

impl Topology {
    /// All ways of which something is told.
    pub fn memory_paths(&self) -> Vec<MemoryPath> {
        let hwloc = self.hwloc();
        let bandwidths = [
            MemoryAttribute::bandwidth(hwloc),
            MemoryAttribute::read_bandwidth(hwloc),
        ];
        let latencies = [
            MemoryAttribute::latency(hwloc),
            MemoryAttribute::read_latency(hwloc),
        ];
        let nodes: Vec<&TopologyObject> = hwloc.objects_with_type(ObjectType::NUMANode).collect();
        let mut paths = Vec::new();
        for cores in nodes.iter().copied() {
            let Some(cpuset) = cores.cpuset().filter(|set| !set.is_empty()) else {
                continue;
            };
            for memory in nodes.iter().copied() {
                // Attributes that this machine does not have are refused: nothing is told.
                let told = |attributes: &[MemoryAttribute<'_>; 2]| {
                    let value = |a: &MemoryAttribute<'_>| a.value(Some((&*cpuset).into()), memory);
                    attributes.iter().find_map(|a| value(a).ok().flatten())
                };
                let path = MemoryPath {
                    cpu_node: os_index(cores),
                    memory_node: os_index(memory),
                    bandwidth: told(&bandwidths),
                    latency: told(&latencies),
                };
                if path.bandwidth.or(path.latency).is_some() {
                    paths.push(path);
                }
            }
        }
        paths
    }
}
