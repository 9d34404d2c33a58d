//! Trees of files as kernels show them, from `tests/data/topology`: one line per line of a file, as `grep -r` prints
//! them.

use super::*;
use std::fs;
use std::io::Write;
use tempfile::TempDir;

const TWO_SOCKETS: &str = include_str!("../../../../tests/data/topology/two-sockets.txt");
const CLUSTERS: &str = include_str!("../../../../tests/data/topology/clusters.txt");
const HYBRID: &str = include_str!("../../../../tests/data/topology/hybrid.txt");
const OFFLINE: &str = include_str!("../../../../tests/data/topology/offline.txt");
const BARE: &str = include_str!("../../../../tests/data/topology/bare.txt");
const CAPACITY: &str = include_str!("../../../../tests/data/topology/capacity.txt");

/// A folder with the files of `text`. Lines that contain `without` are omitted; `more` adds lines.
fn folder(text: &str, without: &str, more: &str) -> TempDir {
    let root = tempfile::tempdir().unwrap();
    let kept = text
        .lines()
        .filter(|line| without.is_empty() || !line.contains(without));
    for line in kept
        .chain(more.lines())
        .filter(|line| !line.starts_with('#'))
    {
        let (path, content) = line.split_once(':').unwrap();
        let path = root.path().join(path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        let mut file = fs::File::options()
            .create(true)
            .append(true)
            .open(path)
            .unwrap();
        writeln!(file, "{content}").unwrap();
    }
    root
}

fn changed(text: &str, without: &str, more: &str) -> Topology {
    read(Tree::new(folder(text, without, more).path()), None, false).unwrap()
}

fn of(text: &str) -> Topology {
    changed(text, "", "")
}

fn threads(topology: &Topology) -> Vec<Vec<u32>> {
    topology
        .cores
        .iter()
        .map(|core| core.threads.clone())
        .collect()
}

fn nodes(topology: &Topology) -> Vec<u32> {
    topology.cores.iter().map(|core| core.numa_node).collect()
}

/// Level, size, number, and number of threads that share one.
fn sizes(topology: &Topology) -> Vec<[u64; 4]> {
    let caches = topology.caches.iter();
    let figures = caches.map(|c| [c.level as u64, c.size, c.count as u64, c.shared_by as u64]);
    figures.collect()
}

#[test]
fn two_sockets_of_cores_with_two_threads() {
    let root = folder(TWO_SOCKETS, "", "");
    let topology = read(Tree::new(root.path()), None, false).unwrap();
    assert_eq!((topology.packages, topology.threads()), (2, 16));
    let wanted = [
        [0, 8],
        [2, 10],
        [4, 12],
        [6, 14],
        [1, 9],
        [3, 11],
        [5, 13],
        [7, 15],
    ];
    assert_eq!(threads(&topology), wanted, "cores of a socket side by side");
    let packages: Vec<usize> = topology.cores.iter().map(|core| core.package).collect();
    assert_eq!(packages, [0, 0, 0, 0, 1, 1, 1, 1]);
    assert_eq!(nodes(&topology), [0, 0, 0, 0, 1, 1, 1, 1]);
    assert!(topology.cores.iter().all(|core| core.kind == 0));
    let wanted = [[1, 48 << 10, 8, 2], [2, 2 << 20, 8, 2], [3, 36 << 20, 2, 8]];
    assert_eq!(sizes(&topology), wanted, "no cache of instructions");
    assert!(topology.caches.iter().all(|cache| cache.line == Some(64)));
    let memory = topology
        .numa_nodes
        .iter()
        .map(|node| (node.index, node.memory, node.free));
    let half = Some(98_304_000 * 512);
    let whole = half.map(|half| 2 * half);
    assert!(memory.eq([(0, whole, half), (1, whole, half)]));
    assert_eq!(topology.numa_node_of(9), Some(1));
    assert_eq!(topology.numa_node_of(16), None);
    assert_eq!(topology.memory_paths(), []);
    // The topology of another machine: no thread runs there, and nothing is bound to it.
    assert_eq!(topology.current_numa_node(), None);
    assert!(topology.nodes_of_memory(&[1.0]).is_empty());
    let refused = topology.bind_current_thread(&[0]);
    assert_eq!(refused, Err(BindingError::Elsewhere));
}

#[test]
fn caches_and_nodes_that_are_no_neighbours_order_the_cores() {
    let root = folder(CLUSTERS, "", "");
    let topology = read(Tree::new(root.path()), None, false).unwrap();
    assert_eq!(topology.packages, 1);
    assert_eq!(threads(&topology).concat(), [0, 1, 4, 5, 2, 3, 6, 7]);
    assert_eq!(nodes(&topology), [0, 0, 0, 0, 1, 1, 1, 1]);
    let wanted = [
        [1, 32 << 10, 8, 1],
        [2, 512 << 10, 8, 1],
        [3, 32 << 20, 4, 2],
    ];
    assert_eq!(sizes(&topology), wanted);
    let of_memory_alone = &topology.numa_nodes[2];
    assert_eq!(of_memory_alone.memory, Some(128 << 30));
    assert!(of_memory_alone.threads.is_empty());
    let path = |cpu_node, memory_node, bandwidth, latency| MemoryPath {
        cpu_node,
        memory_node,
        bandwidth: Some(bandwidth),
        latency: Some(latency),
    };
    let wanted = [
        path(0, 0, 40_000, 95),
        path(0, 2, 20_000, 250),
        path(1, 1, 40_000, 95),
        path(1, 2, 20_000, 250),
    ];
    assert_eq!(topology.memory_paths(), wanted);
}

#[test]
fn slow_cores_and_fast_ones() {
    let topology = of(HYBRID);
    let kinds: Vec<u32> = topology.cores.iter().map(|core| core.kind).collect();
    assert_eq!(kinds, [1, 1, 0, 0, 0, 0]);
    let wanted = [vec![0, 1], vec![2, 3], vec![4], vec![5], vec![6], vec![7]];
    assert_eq!(threads(&topology), wanted);
    // The first cache of a level represents all.
    let wanted = [
        [1, 48 << 10, 6, 2],
        [2, 1280 << 10, 3, 2],
        [3, 12 << 20, 1, 8],
    ];
    assert_eq!(sizes(&topology), wanted);
    assert_eq!(topology.numa_nodes[0].memory, Some(16_384_000 << 10));
    assert_eq!(topology.numa_nodes[0].threads, [0, 1, 2, 3, 4, 5, 6, 7]);
    let by_capacity = of(CAPACITY);
    let kinds: Vec<u32> = by_capacity.cores.iter().map(|core| core.kind).collect();
    assert_eq!(kinds, [0, 0, 1, 1]);
    // Capacities are ignored if some cores have none.
    let cut = changed(CAPACITY, "cpu3/cpu_capacity", "");
    assert!(cut.cores.iter().all(|core| core.kind == 0));
}

#[test]
fn a_thread_that_is_switched_off_is_not_there() {
    let topology = of(OFFLINE);
    assert_eq!(threads(&topology), [vec![0], vec![2, 3]]);
    assert_eq!(sizes(&topology), [[1, 32 << 10, 2, 1]]);
    assert_eq!(topology.numa_nodes[0].threads, [0, 2, 3]);
}

#[test]
fn what_is_missing_leaves_the_rest() {
    let topology = of(BARE);
    assert_eq!(threads(&topology), [[1], [3]], "a thread is a core");
    assert_eq!((topology.packages, sizes(&topology)), (1, Vec::new()));
    assert_eq!(nodes(&topology), [0, 0]);
    assert_eq!(topology.numa_nodes[0].memory, Some(2_048_000 << 10));
    for (without, cores, packages, levels) in [
        ("/topology/core_cpus_list", 16, 2, 3),
        ("/topology/package_cpus_list", 8, 1, 3),
        ("/cache/", 8, 2, 0),
        ("index3/shared_cpu_list", 8, 2, 2),
        ("system/node", 8, 2, 3),
        ("cpu/online", 8, 2, 3),
    ] {
        let topology = changed(TWO_SOCKETS, without, "");
        let found = (
            topology.cores.len(),
            topology.packages,
            topology.caches.len(),
        );
        assert_eq!(found, (cores, packages, levels), "{without}");
        assert_eq!(topology.threads(), 16, "{without}");
        let near = topology.numa_nodes.iter().map(|node| node.threads.len());
        assert_eq!(near.sum::<usize>(), 16, "{without}");
    }
    // Kernels before 2019 use other names of files.
    let old = TWO_SOCKETS.replace("core_cpus_list", "thread_siblings_list");
    let old = old.replace("package_cpus_list", "core_siblings_list");
    assert_eq!(threads(&of(&old)), threads(&of(TWO_SOCKETS)));
    let nothing = read(Tree::new(folder("", "", "").path()), None, false);
    assert!(matches!(nothing, Err(TopologyError::Unknown)));
}

/// A process bound by `taskset`: the caches stay the same, the usable threads shrink.
#[test]
fn a_bound_process_sees_its_cores_alone() {
    let status = "proc/thread-self/status:Cpus_allowed_list:\t3,8-9\n";
    let topology = changed(TWO_SOCKETS, "Cpus_allowed_list", status);
    assert_eq!(threads(&topology), [[8], [9], [3]]);
    assert_eq!(
        (topology.packages, sizes(&topology)[0]),
        (2, [1, 48 << 10, 8, 2])
    );
    assert_eq!(topology.numa_nodes[0].threads, [8]);
    // The mask from the system takes precedence over the file.
    let root = folder(TWO_SOCKETS, "", "");
    let bound = Set::from([1, 2]);
    let topology = read(Tree::new(root.path()), Some(bound), false).unwrap();
    assert_eq!(threads(&topology), [[2], [1]]);
}

/// A process with part of a machine, granted by its control group, sees only this part.
#[test]
fn a_container_sees_what_it_is_granted() {
    let status = "proc/thread-self/status:Cpus_allowed_list:\t1,9,3,11\n\
                  proc/thread-self/status:Mems_allowed_list:\t1\n";
    let second = "proc/self/cgroup:0::/box\n\
                  sys/fs/cgroup/box/cpuset.cpus.effective:1,3,9,11\n";
    let first = "proc/self/cgroup:4:memory:/other\nproc/self/cgroup:3:cpuset,cpu:/box\n\
                 proc/self/cgroup:0::/\nsys/fs/cgroup/cpuset/box/cpuset.effective_cpus:1,3,9,11\n";
    // Inside a container, the files of the process's group are in the root folder.
    let inside = "proc/self/cgroup:0::/not/here\nsys/fs/cgroup/cpuset.cpus.effective:1,3,9,11\n";
    for group in [second, first, inside] {
        let topology = changed(TWO_SOCKETS, "allowed_list", &format!("{status}{group}"));
        assert_eq!(threads(&topology), [[1, 9], [3, 11]]);
        assert_eq!((topology.packages, topology.cores[0].package), (1, 0));
        assert_eq!(nodes(&topology), [1, 1]);
        assert_eq!(topology.numa_nodes.len(), 1);
        let wanted = [[1, 48 << 10, 2, 2], [2, 2 << 20, 2, 2], [3, 36 << 20, 1, 4]];
        assert_eq!(sizes(&topology), wanted);
    }
}
