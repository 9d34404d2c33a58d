//! On which hardware threads do teams run? Order of the threads, teams of growing size, caches and nodes of a
//! team.

use super::item::Placement;
use crate::characterize::team::HardwareThread;
use crate::topology::{Cache, Topology};

/// All hardware threads in their order of use: the first threads of all cores before the second ones.
pub fn order(topology: &Topology, placement: Placement) -> Vec<HardwareThread> {
    let mut ranked = Vec::new();
    let mut in_node = std::collections::HashMap::new();
    for (place, core) in topology.cores.iter().enumerate() {
        let rank: &mut usize = in_node.entry(core.numa_node).or_default();
        for (lap, &index) in core.threads.iter().enumerate() {
            let node = core.numa_node;
            let key = match placement {
                Placement::Compact => (lap, node as usize, place),
                Placement::Scattered => (lap, *rank, node as usize),
            };
            ranked.push((key, HardwareThread { index, node }));
        }
        *rank += 1;
    }
    ranked.sort_by_key(|(key, _)| *key);
    ranked.into_iter().map(|(_, thread)| thread).collect()
}

/// Teams of growing size, up to `most` members. Their sizes are powers of two, the largest number of cores of a node,
/// the number of all cores, and the largest possible size.
pub fn teams(topology: &Topology, placement: Placement, most: usize) -> Vec<Vec<HardwareThread>> {
    let order = order(topology, placement);
    let most = order.len().min(most);
    let of_node = |node: u32| {
        topology
            .cores
            .iter()
            .filter(|c| c.numa_node == node)
            .count()
    };
    let nodes = topology.numa_nodes.iter().map(|node| of_node(node.index));
    let mut counts: Vec<usize> = (0..usize::BITS)
        .map(|i| 1 << i)
        .take_while(|&n| n <= most)
        .chain([nodes.max().unwrap_or(1), topology.cores.len(), most])
        .filter(|n| (1..=most).contains(n))
        .collect();
    counts.sort_unstable();
    counts.dedup();
    counts.iter().map(|&n| order[..n].to_vec()).collect()
}

/// Number of last-level caches of a team's cores, at least 1. hwloc lists cores with a common cache next to each other.
pub fn caches_spanned(topology: &Topology, team: &[HardwareThread], cache: &Cache) -> usize {
    let mut before = 0;
    let mut spanned: Vec<usize> = Vec::new();
    for core in &topology.cores {
        if team
            .iter()
            .any(|thread| core.threads.contains(&thread.index))
        {
            spanned.push(before / cache.shared_by.max(1));
        }
        before += core.threads.len();
    }
    spanned.dedup();
    spanned.len().clamp(1, cache.count.max(1))
}

/// Whether `teams` contains a team with the same threads.
pub fn same_places(team: &[HardwareThread], teams: &[Vec<HardwareThread>]) -> bool {
    let sorted = |team: &[HardwareThread]| {
        let mut threads: Vec<u32> = team.iter().map(|thread| thread.index).collect();
        threads.sort_unstable();
        threads
    };
    (teams.iter()).any(|other| other.len() == team.len() && sorted(other) == sorted(team))
}

/// All pairs (node of cores, node of memory): any node with cores, and any node.
pub fn pairs(topology: &Topology) -> Vec<(u32, u32)> {
    let with_cores = |node: u32| topology.cores.iter().any(|core| core.numa_node == node);
    let all = || topology.numa_nodes.iter().map(|node| node.index);
    all()
        .filter(|&node| with_cores(node))
        .flat_map(|node| all().map(move |memory| (node, memory)))
        .collect()
}
