//! Which core does a worker run on?
//!
//! The decision depends only on a list of cores. Each core gets one worker, fast cores first. If there are
//! more cores than workers, the workers are spread over NUMA nodes and packages. Only if there are more workers
//! than cores, several share a core, each on one of its hardware threads. By default, workers are pinned if they
//! take every core. Fewer workers are not pinned: the system may then move them away from cores that other
//! programs, or other shards of the job, use.

use super::Core;
use std::cmp::Reverse;
use std::collections::HashMap;
use std::fmt;

/// Whether workers are bound to their cores.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Pinning {
    /// If they take every core.
    #[default]
    Full,
    /// Always.
    Always,
    /// Never.
    Never,
}

/// The place of a worker.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// Index into the list of cores.
    pub core: usize,
    /// NUMA node of the core, numbered as by the system.
    pub numa_node: u32,
    /// Hardware threads that the worker may use, numbered as by the system: all of the core if no other worker runs
    /// there.
    pub threads: Vec<u32>,
}

/// The places of all workers, in order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plan {
    /// One place per worker; empty if the cores are unknown.
    pub places: Vec<Place>,
    /// Whether workers are bound to their places.
    pub pinned: bool,
    /// Number of usable cores.
    pub cores: usize,
}

/// The default number of workers: one per core, or fewer if the system gives this process less time (`parallelism`
/// includes quotas that a list of cores does not show).
pub fn default_workers(cores: usize, parallelism: Option<usize>) -> usize {
    match (cores, parallelism) {
        (0, None) => 1,
        (0, Some(parallelism)) => parallelism.max(1),
        (cores, parallelism) => cores.min(parallelism.unwrap_or(cores)).max(1),
    }
}

/// Places `workers` on cores; `cores` is empty if the machine is unknown.
pub fn plan(cores: &[Core], workers: usize, pinning: Pinning) -> Plan {
    let pinned = !cores.is_empty()
        && match pinning {
            Pinning::Full => workers >= cores.len(),
            Pinning::Always => true,
            Pinning::Never => false,
        };
    let order = preference(cores);
    let mut on_core = vec![0; cores.len()];
    for &core in order.iter().cycle().take(workers) {
        on_core[core] += 1;
    }
    let mut places: Vec<(usize, Place)> = Vec::new();
    for (index, (core, &count)) in cores.iter().zip(&on_core).enumerate() {
        for lap in 0..count {
            let threads = match count {
                1 => core.threads.clone(),
                _ => vec![core.threads[lap % core.threads.len()]],
            };
            let place = Place {
                core: index,
                numa_node: core.numa_node,
                threads,
            };
            places.push((lap, place));
        }
    }
    // First threads of all cores, then second threads.
    places.sort_by_key(|(lap, place)| (*lap, place.core));
    Plan {
        places: places.into_iter().map(|(_, place)| place).collect(),
        pinned,
        cores: cores.len(),
    }
}

/// Indices of the cores in order of preference: fast kinds first, then one core of every NUMA node in turn.
fn preference(cores: &[Core]) -> Vec<usize> {
    let mut in_node: HashMap<(u32, u32), usize> = HashMap::new();
    let mut nodes_of_package: HashMap<usize, Vec<u32>> = HashMap::new();
    let mut keyed: Vec<_> = cores
        .iter()
        .enumerate()
        .map(|(index, core)| {
            let rank = in_node.entry((core.kind, core.numa_node)).or_default();
            *rank += 1;
            let nodes = nodes_of_package.entry(core.package).or_default();
            let node = nodes
                .iter()
                .position(|known| *known == core.numa_node)
                .unwrap_or_else(|| {
                    nodes.push(core.numa_node);
                    nodes.len() - 1
                });
            ((Reverse(core.kind), *rank, node, core.package), index)
        })
        .collect();
    keyed.sort();
    keyed.into_iter().map(|(_, index)| index).collect()
}

impl fmt::Display for Plan {
    /// `4 workers on 4 of 8 cores, 2 NUMA nodes; not pinned`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.cores == 0 {
            return f.write_str("not pinned: the cores of this machine are unknown");
        }
        let distinct = |pick: fn(&Place) -> u64| {
            let mut values: Vec<u64> = self.places.iter().map(pick).collect();
            values.sort_unstable();
            values.dedup();
            values.len()
        };
        let plural = |count: usize, noun: &str| match count {
            1 => format!("1 {noun}"),
            _ => format!("{count} {noun}s"),
        };
        let (used, nodes) = (
            distinct(|place| place.core as u64),
            distinct(|place| place.numa_node.into()),
        );
        write!(
            f,
            "{} on {used} of {}, {}; {}",
            plural(self.places.len(), "worker"),
            plural(self.cores, "core"),
            plural(nodes, "NUMA node"),
            if self.pinned { "pinned" } else { "not pinned" },
        )
    }
}

#[cfg(test)]
#[cfg(feature = "hwloc")]
mod tests {
    use super::*;
    use crate::topology::Topology;

    fn placed(description: &str, workers: usize) -> Plan {
        let topology = Topology::synthetic(description).unwrap();
        plan(&topology.cores, workers, Pinning::Full)
    }

    fn cores(plan: &Plan) -> Vec<usize> {
        plan.places.iter().map(|place| place.core).collect()
    }

    fn threads(plan: &Plan) -> Vec<Vec<u32>> {
        plan.places
            .iter()
            .map(|place| place.threads.clone())
            .collect()
    }

    #[test]
    fn one_node_has_a_worker_a_core() {
        let plan = placed("package:1 core:4 pu:2", 4);
        assert_eq!(cores(&plan), [0, 1, 2, 3]);
        assert_eq!(threads(&plan), [[0, 1], [2, 3], [4, 5], [6, 7]]);
        assert!(plan.pinned);
        assert_eq!(
            plan.to_string(),
            "4 workers on 4 of 4 cores, 1 NUMA node; pinned"
        );
    }

    #[test]
    fn few_workers_are_spread_over_two_sockets_and_left_unpinned() {
        let two = "package:2 [numa] core:14 pu:2";
        let few = placed(two, 4);
        assert_eq!(cores(&few), [0, 1, 14, 15]);
        assert!(!few.pinned);
        assert_eq!(
            few.to_string(),
            "4 workers on 4 of 28 cores, 2 NUMA nodes; not pinned"
        );
        assert!(placed(two, 28).pinned);
        assert_eq!(cores(&placed(two, 28)), (0..28).collect::<Vec<_>>());
    }

    #[test]
    fn clusters_of_a_package_come_after_other_packages() {
        // Two packages, each with two nodes of two cores.
        let clusters = "package:2 numa:2 core:2 pu:1";
        assert_eq!(cores(&placed(clusters, 2)), [0, 4]);
        assert_eq!(cores(&placed(clusters, 4)), [0, 2, 4, 6]);
        assert_eq!(cores(&placed(clusters, 5)), [0, 1, 2, 4, 6]);
    }

    #[test]
    fn second_threads_come_after_all_cores_and_then_cores_are_shared() {
        let plan = placed("package:1 core:2 pu:2", 3);
        assert_eq!(threads(&plan), [vec![0], vec![2, 3], vec![1]]);
        let plan = placed("package:1 core:2 pu:2", 6);
        assert_eq!(threads(&plan), [[0], [2], [1], [3], [0], [2]]);
        assert!(plan.pinned);
    }

    /// Fast cores with two threads and slow ones with one, as in desktop processors; and a package of which a cpuset
    /// leaves one core.
    #[test]
    fn hybrid_and_asymmetric_machines() {
        let core = |package, kind, threads: &[u32]| Core {
            package,
            numa_node: package as u32,
            kind,
            threads: threads.to_vec(),
        };
        let hybrid = [
            core(0, 0, &[8]),
            core(0, 0, &[9]),
            core(0, 1, &[0, 1]),
            core(0, 1, &[2, 3]),
        ];
        assert_eq!(cores(&plan(&hybrid, 2, Pinning::Full)), [2, 3]);
        assert_eq!(cores(&plan(&hybrid, 3, Pinning::Full)), [0, 2, 3]);
        let more = plan(&hybrid, 5, Pinning::Always);
        assert_eq!(
            threads(&more),
            [vec![8], vec![9], vec![0], vec![2, 3], vec![1]]
        );
        let asymmetric = [
            core(0, 0, &[0]),
            core(0, 0, &[1]),
            core(0, 0, &[2]),
            core(1, 0, &[6]),
        ];
        assert_eq!(cores(&plan(&asymmetric, 3, Pinning::Full)), [0, 1, 3]);
        assert!(plan(&asymmetric, 1, Pinning::Always).pinned);
        assert!(!plan(&asymmetric, 9, Pinning::Never).pinned);
    }

    #[test]
    fn an_unknown_machine_has_no_places() {
        let plan = plan(&[], 3, Pinning::Always);
        assert!(plan.places.is_empty() && !plan.pinned);
        assert!(plan.to_string().contains("unknown"));
    }

    #[test]
    fn quotas_count_where_nothing_was_asked() {
        assert_eq!(default_workers(28, Some(56)), 28);
        assert_eq!(default_workers(64, Some(4)), 4);
        assert_eq!(default_workers(0, Some(2)), 2);
        assert_eq!(default_workers(0, None), 1);
    }
}
