//! The machine as the files of Linux describe it. `/sys/devices/system` lists the hardware; `/proc/thread-self` and the
//! control group list the part that this process may use.
//!
//! Any file may be missing, as in containers, sandboxes and virtual machines. Hardware threads without a core each
//! count as a core. Cores without a package lie in one package. Without nodes, all memory belongs to one node.
//! `sched_setaffinity` binds threads. Memory comes from the node of the thread that touches it first; it is not bound
//! in any other way.

mod tree;

use super::description::{Cache, Core, NumaNode, Topology, TopologyError};
use super::machine::{bytes_of_kib_field, free_memory};
use super::system::{BindingError, MemoryPath, Source, System};
use rustix::thread::{CpuSet, sched_getaffinity, sched_getcpu, sched_setaffinity};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use tree::{Set, Tree};

/// Levels of cache that are reported, the same as by hwloc.
const LEVELS: std::ops::RangeInclusive<usize> = 1..=3;
/// Cores are sorted by capacity. A new kind starts at a core if this fraction of its capacity exceeds the capacity of
/// the core before it. Cores of one kind in hybrid machines differ by their turbo frequencies.
const ALIKE: f64 = 0.9;

/// The machine that the program runs on.
///
/// # Errors
/// The system reports no processor.
pub(super) fn of_this_machine() -> Result<Topology, TopologyError> {
    let bound = sched_getaffinity(None).ok().map(|set| {
        let threads = 0..CpuSet::MAX_CPU;
        threads
            .filter(|&thread| set.is_set(thread))
            .map(|thread| thread as u32)
            .collect()
    });
    read(Tree::new(Path::new("/")), bound, true)
}

/// The machine that a tree of files describes; `here` if it is this machine. `bound` has the threads of its binding;
/// if it is `None`, the tree gives them. On machines with more than 1024 processors, the system refuses an
/// affinity mask of the usual size.
fn read(tree: Tree, bound: Option<Set>, here: bool) -> Result<Topology, TopologyError> {
    let bound = bound.or_else(|| tree.bound());
    let online = tree.list("sys/devices/system/cpu/online");
    let online = (online.or_else(|| bound.clone())).ok_or(TopologyError::Unknown)?;
    let allowed = common(&online, tree.granted_threads().as_ref());
    let usable = common(&allowed, bound.as_ref());
    let nodes = nodes(&tree, &allowed);
    let units = order(units(&tree, &allowed), &nodes);
    let mut packages: Vec<&Set> = Vec::new();
    let mut cores = Vec::new();
    let kinds = kinds(&tree, &units);
    for (unit, kind) in units.iter().zip(kinds) {
        let package = unit.package.as_ref().map_or(0, |package| {
            let known = packages.iter().position(|known| *known == package);
            known.unwrap_or_else(|| {
                packages.push(package);
                packages.len() - 1
            })
        });
        let threads: Vec<u32> = unit.threads.intersection(&usable).copied().collect();
        if !threads.is_empty() {
            cores.push(Core {
                package,
                numa_node: nearest(&nodes, &unit.threads),
                kind,
                threads,
            });
        }
    }
    let numa_nodes: Vec<NumaNode> = (nodes.into_iter())
        .map(|node| NumaNode {
            index: node.index,
            memory: node.memory,
            free: free_memory(tree.root(), node.index),
            threads: node.threads.intersection(&usable).copied().collect(),
        })
        .collect();
    let only_node = match &numa_nodes[..] {
        [one] => Some(one.index),
        _ => None,
    };
    Ok(Topology {
        packages: packages.len().max(1),
        caches: caches(&units, &allowed),
        cores,
        numa_nodes,
        source: Source::Sys,
        system: Box::new(Files {
            tree,
            here,
            only_node,
        }),
    })
}

/// The intersection of two sets; the first set if the other is unknown or the intersection is empty.
fn common(all: &Set, of: Option<&Set>) -> Set {
    let both: Set = of.map_or_else(Set::new, |of| all.intersection(of).copied().collect());
    if both.is_empty() { all.clone() } else { both }
}

/// A whole core, including threads that the process may not use, if the system reports them.
struct Unit {
    threads: Set,
    package: Option<Set>,
    /// Sets of threads that contain the core: package, die, cluster, caches.
    around: Vec<Set>,
    caches: Vec<ThreadCache>,
    capacity: Option<u64>,
}

struct ThreadCache {
    level: usize,
    size: u64,
    line: Option<usize>,
    threads: Set,
}

/// The cores to which these threads belong.
fn units(tree: &Tree, threads: &Set) -> Vec<Unit> {
    let mut units = BTreeMap::new();
    for &thread in threads {
        let siblings = tree.siblings(thread, &["core_cpus_list", "thread_siblings_list"]);
        let of_core = siblings.unwrap_or_else(|| Set::from([thread]));
        units.entry(of_core).or_insert(thread);
    }
    let unit = |(of_core, thread): (Set, u32)| {
        let package = tree.siblings(thread, &["package_cpus_list", "core_siblings_list"]);
        let caches = thread_caches(tree, thread);
        let parts = ["die_cpus_list", "cluster_cpus_list"];
        let parts = parts.map(|part| tree.siblings(thread, &[part]));
        let shared = caches.iter().map(|cache| cache.threads.clone());
        let around = package.iter().cloned();
        Unit {
            around: around
                .chain(parts.into_iter().flatten())
                .chain(shared)
                .collect(),
            capacity: tree.number(&format!("{}/cpu_capacity", tree::of_thread(thread))),
            threads: of_core,
            package,
            caches,
        }
    };
    units.into_iter().map(unit).collect()
}

/// Data and unified caches of a thread.
fn thread_caches(tree: &Tree, thread: u32) -> Vec<ThreadCache> {
    let mut caches = Vec::new();
    for index in 0.. {
        let file = |name: &str| format!("{}/cache/index{index}/{name}", tree::of_thread(thread));
        let Some(kind) = tree.text(&file("type")) else {
            return caches;
        };
        let level = tree
            .number(&file("level"))
            .and_then(|l| usize::try_from(l).ok());
        if let (Some(level), Some(threads)) = (level, tree.list(&file("shared_cpu_list")))
            && kind != "Instruction"
            && LEVELS.contains(&level)
        {
            let line = tree.number(&file("coherency_line_size"));
            caches.push(ThreadCache {
                level,
                size: tree.text(&file("size")).map_or(0, |text| bytes(&text)),
                line: line.and_then(|line| usize::try_from(line).ok()),
                threads,
            });
        }
    }
    caches
}

/// `32K` in bytes; 0 if it is not a size.
fn bytes(text: &str) -> u64 {
    let (digits, unit) = match text.strip_suffix('K') {
        Some(digits) => (digits, 1 << 10),
        None => text
            .strip_suffix('M')
            .map_or((text, 1), |digits| (digits, 1 << 20)),
    };
    digits.parse::<u64>().map_or(0, |number| number * unit)
}

/// Orders cores so that neighbours share caches. The sets of threads around a core are nested. The sort key
/// of a core is the first threads of these sets, from the largest set to the smallest.
fn order(units: Vec<Unit>, nodes: &[Node]) -> Vec<Unit> {
    let place = |unit: &Unit| {
        let mut around = unit.around.clone();
        around.push(unit.threads.clone());
        let holds = |node: &&Node| unit.threads.is_subset(&node.near);
        around.extend(nodes.iter().filter(holds).map(|node| node.near.clone()));
        around.sort_by_key(|set| std::cmp::Reverse(set.len()));
        around
            .iter()
            .filter_map(|set| set.first().copied())
            .collect::<Vec<u32>>()
    };
    let mut units = units;
    units.sort_by_cached_key(place);
    units
}

/// The kind of each core, slow ones first: from Intel's hybrid processors, or by capacity.
fn kinds(tree: &Tree, units: &[Unit]) -> Vec<u32> {
    let hybrid =
        ["cpu_atom", "cpu_core"].map(|kind| tree.list(&format!("sys/devices/{kind}/cpus")));
    if let [Some(_), Some(fast)] = &hybrid {
        let is_fast = |unit: &Unit| u32::from(!unit.threads.is_disjoint(fast));
        return units.iter().map(is_fast).collect();
    }
    let mut capacities: Vec<u64> = units.iter().filter_map(|unit| unit.capacity).collect();
    if capacities.len() < units.len() {
        return vec![0; units.len()];
    }
    capacities.sort_unstable();
    // The smallest capacity of every kind.
    let mut least: Vec<u64> = Vec::new();
    for pair in std::iter::once(&0).chain(&capacities).zip(&capacities) {
        if (*pair.0 as f64) < ALIKE * *pair.1 as f64 {
            least.push(*pair.1);
        }
    }
    let kind = |capacity: u64| least.iter().filter(|least| **least <= capacity).count();
    let of = |unit: &Unit| {
        unit.capacity
            .map_or(0, |c| kind(c).saturating_sub(1) as u32)
    };
    units.iter().map(of).collect()
}

/// One entry per level of cache. The first cache of a level represents all.
fn caches(units: &[Unit], allowed: &Set) -> Vec<Cache> {
    let mut levels: BTreeMap<usize, (Cache, BTreeSet<&Set>)> = BTreeMap::new();
    for cache in units.iter().flat_map(|unit| &unit.caches) {
        let first = || Cache {
            level: cache.level,
            size: cache.size,
            line: cache.line,
            count: 0,
            shared_by: cache.threads.intersection(allowed).count(),
        };
        let (_, sets) = (levels.entry(cache.level)).or_insert_with(|| (first(), BTreeSet::new()));
        sets.insert(&cache.threads);
    }
    let counted = |(cache, sets): (Cache, BTreeSet<&Set>)| Cache {
        count: sets.len(),
        ..cache
    };
    levels.into_values().map(counted).collect()
}

struct Node {
    index: u32,
    memory: Option<u64>,
    /// Threads near the node.
    near: Set,
    /// Threads near the node that are online and granted by the control group.
    threads: Set,
}

/// The nodes that this process may use, at least one.
fn nodes(tree: &Tree, allowed: &Set) -> Vec<Node> {
    let memory = |path: &str, key: &str| {
        let bytes = tree
            .text(path)
            .and_then(|text| bytes_of_kib_field(&text, key));
        bytes.filter(|bytes| *bytes > 0)
    };
    let known = tree
        .list("sys/devices/system/node/online")
        .unwrap_or_default();
    let granted = common(&known, tree.granted_nodes().as_ref());
    let node = |index: u32| {
        let folder = format!("sys/devices/system/node/node{index}");
        let near = tree.list(&format!("{folder}/cpulist")).unwrap_or_default();
        Node {
            index,
            memory: memory(
                &format!("{folder}/meminfo"),
                &format!("Node {index} MemTotal"),
            ),
            threads: near.intersection(allowed).copied().collect(),
            near,
        }
    };
    let nodes: Vec<Node> = granted.into_iter().map(node).collect();
    if nodes.iter().any(|node| !node.threads.is_empty()) {
        return nodes;
    }
    vec![Node {
        index: 0,
        memory: memory("proc/meminfo", "MemTotal"),
        near: allowed.clone(),
        threads: allowed.clone(),
    }]
}

/// Number of the smallest node that contains a thread of a core, or of the first node if none does.
fn nearest(nodes: &[Node], threads: &Set) -> u32 {
    let near = nodes
        .iter()
        .filter(|node| !node.threads.is_disjoint(threads));
    let nearest = near.min_by_key(|node| node.threads.len());
    nearest.or(nodes.first()).map_or(0, |node| node.index)
}

/// The files of the system, which answer later queries.
#[derive(Debug)]
struct Files {
    tree: Tree,
    here: bool,
    /// The node of all memory, if there is only one.
    only_node: Option<u32>,
}

impl System for Files {
    fn is_this_machine(&self) -> bool {
        self.here
    }

    fn bind_thread(&self, threads: &[u32]) -> Result<(), BindingError> {
        let refused = |detail: String| BindingError::Refused { detail };
        let mut set = CpuSet::new();
        for &thread in threads {
            if thread as usize >= CpuSet::MAX_CPU {
                let most = CpuSet::MAX_CPU;
                return Err(refused(format!(
                    "thread {thread} is beyond the first {most}"
                )));
            }
            set.set(thread as usize);
        }
        sched_setaffinity(None, &set).map_err(|error| refused(error.to_string()))?;
        if sched_getaffinity(None).is_ok_and(|bound| bound == set) {
            Ok(())
        } else {
            Err(BindingError::NotKept)
        }
    }

    fn bind_memory(&self, _node: u32) -> Result<(), BindingError> {
        Err(BindingError::NoMemoryBinding)
    }

    fn last_thread(&self) -> Option<u32> {
        u32::try_from(sched_getcpu()).ok()
    }

    fn nodes_of_memory(&self, _values: &[f64]) -> Vec<u32> {
        self.only_node.into_iter().collect()
    }

    fn memory_paths(&self) -> Vec<MemoryPath> {
        let nodes = self.tree.list("sys/devices/system/node/online");
        let nodes = nodes.unwrap_or_default();
        let path = |memory_node: u32, cpu_node: u32| {
            // Class 1 covers processors only, class 0 everything that reads memory.
            ["access1", "access0"].into_iter().find_map(|class| {
                let folder =
                    format!("sys/devices/system/node/node{memory_node}/{class}/initiators");
                let initiator = format!("{folder}/node{cpu_node}");
                let number = |name: &str| self.tree.number(&format!("{folder}/{name}"));
                let (bandwidth, latency) = (number("read_bandwidth"), number("read_latency"));
                (self.tree.holds(&initiator) && bandwidth.or(latency).is_some()).then_some(
                    MemoryPath {
                        cpu_node,
                        memory_node,
                        bandwidth,
                        latency,
                    },
                )
            })
        };
        let from = |cpu_node: &u32| {
            let to = nodes.iter().copied();
            let paths = to.filter_map(|memory_node| path(memory_node, *cpu_node));
            paths.collect::<Vec<_>>()
        };
        nodes.iter().flat_map(from).collect()
    }
}

#[cfg(test)]
mod tests;
