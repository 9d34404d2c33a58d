//! What does the system report about the machine? The source is `/proc` and `/sys`. Missing entries are left
//! out.

use crate::store::{Description, HugePages, NodeRecord};
use crate::topology::{Machine, Topology, bytes_of_kib_field, field};
use std::fs;
use std::path::{Path, PathBuf};

/// The root folder of the system. Tests use another one.
#[derive(Debug, Clone)]
pub struct Root(PathBuf);

impl Root {
    /// The root of this machine.
    pub fn of_this_machine() -> Self {
        Self(PathBuf::from("/"))
    }

    /// A file's text without surrounding white space; `None` if it is missing or empty.
    fn text(&self, path: &str) -> Option<String> {
        let text = fs::read_to_string(self.0.join(path)).ok()?;
        let text = text.trim();
        (!text.is_empty()).then(|| text.to_owned())
    }

    fn number(&self, path: &str) -> Option<u64> {
        self.text(path)?.parse().ok()
    }

    fn holds(&self, path: &str) -> bool {
        Path::new(&self.0).join(path).exists()
    }
}

/// Describes the machine of a topology.
pub fn describe(topology: &Topology, root: &Root) -> Description {
    let machine = Machine::current();
    let meminfo = root.text("proc/meminfo").unwrap_or_default();
    let status = root.text("proc/self/status").unwrap_or_default();
    let cpuinfo = root.text("proc/cpuinfo").unwrap_or_default();
    let release = root.text("proc/sys/kernel/osrelease");
    let group = control_group(&root.text("proc/self/cgroup").unwrap_or_default());
    let of_group = |file: &str| {
        root.text(&format!("sys/fs/cgroup{group}/{file}"))
            .or_else(|| root.text(&format!("sys/fs/cgroup/{file}")))
    };
    let frequency = "sys/devices/system/cpu/cpu0/cpufreq";
    let nodes = (topology.numa_nodes.iter()).map(|node| NodeRecord {
        index: node.index,
        memory: node.memory,
        threads: node.threads.len(),
        distances: root
            .text(&format!(
                "sys/devices/system/node/node{}/distance",
                node.index
            ))
            .map(|text| text.split_whitespace().flat_map(str::parse).collect())
            .unwrap_or_default(),
    });
    Description {
        cpu: machine.cpu,
        system: match release {
            Some(release) => format!("{}, {release}", machine.system),
            None => machine.system,
        },
        isa: machine.isa.into_iter().map(str::to_owned).collect(),
        packages: topology.packages,
        cores: topology.cores.len(),
        threads: topology.threads(),
        topology: topology.source.to_string(),
        threads_online: (root.text("sys/devices/system/cpu/online"))
            .map(|list| count_of_list(&list)),
        allowed: field(&status, "Cpus_allowed_list").map(str::to_owned),
        quota_percent: of_group("cpu.max").and_then(|text| quota(&text)),
        caches: topology.caches.clone(),
        nodes: nodes.collect(),
        paths: topology.memory_paths(),
        numa_balancing: (root.number("proc/sys/kernel/numa_balancing"))
            .and_then(|state| u32::try_from(state).ok()),
        memory: machine.memory,
        memory_available: bytes_of_kib_field(&meminfo, "MemAvailable"),
        memory_limit: of_group("memory.max").and_then(|text| text.parse().ok()),
        huge_pages: HugePages {
            transparent: (root.text("sys/kernel/mm/transparent_hugepage/enabled"))
                .and_then(|text| chosen(&text)),
            size: bytes_of_kib_field(&meminfo, "Hugepagesize"),
            reserved: field(&meminfo, "HugePages_Total").and_then(|text| text.parse().ok()),
        },
        governor: root.text(&format!("{frequency}/scaling_governor")),
        frequency: (root.number(&format!("{frequency}/cpuinfo_max_freq"))).map(|khz| 1000 * khz),
        hypervisor: hypervisor(root, &cpuinfo),
        container: container(root),
    }
}

/// Number of elements in a list such as `0-3,8`.
fn count_of_list(list: &str) -> usize {
    list.split(',')
        .filter_map(|range| {
            let (first, last) = range.split_once('-').unwrap_or((range, range));
            let (first, last): (usize, usize) =
                (first.trim().parse().ok()?, last.trim().parse().ok()?);
            Some((last + 1).saturating_sub(first))
        })
        .sum()
}

/// Path of this process's control group in the unified hierarchy; empty for the root group.
fn control_group(text: &str) -> String {
    let path = text.lines().find_map(|line| line.strip_prefix("0::"));
    match path {
        Some("/") | None => String::new(),
        Some(path) => path.to_owned(),
    }
}

/// Limit of processor time in per cent of one processor, from `quota period`; `None` if there is no limit.
fn quota(text: &str) -> Option<u64> {
    let (quota, period) = text.split_once(' ')?;
    let (quota, period): (u64, u64) = (quota.parse().ok()?, period.parse().ok()?);
    Some(100 * quota / period.max(1))
}

/// The word in brackets, which marks the chosen one of several words; `None` without brackets.
fn chosen(text: &str) -> Option<String> {
    let (_, rest) = text.split_once('[')?;
    Some(rest.split_once(']')?.0.to_owned())
}

/// The name of the hypervisor, if the machine is virtual: as the system, the firmware (vendor and product) or
/// the processor reports it.
fn hypervisor(root: &Root, cpuinfo: &str) -> Option<String> {
    let has_hypervisor_flag = field(cpuinfo, "flags")
        .is_some_and(|flags| flags.split_whitespace().any(|flag| flag == "hypervisor"));
    let named = root.text("sys/hypervisor/type");
    if !has_hypervisor_flag && named.is_none() {
        return None;
    }
    let maker = || {
        let parts = ["sys_vendor", "product_name"];
        let texts = parts.map(|part| root.text(&format!("sys/class/dmi/id/{part}")));
        let known: Vec<String> = texts.into_iter().flatten().collect();
        (!known.is_empty()).then(|| known.join(" "))
    };
    let known = named.or_else(maker).or_else(answering_hypervisor);
    Some(known.unwrap_or_else(|| "unnamed".to_owned()))
}

/// The hypervisor that the processor reports.
#[cfg(target_arch = "x86_64")]
fn answering_hypervisor() -> Option<String> {
    use raw_cpuid::{CpuId, Hypervisor};
    match CpuId::new().get_hypervisor_info()?.identify() {
        Hypervisor::Unknown(..) => None,
        known => Some(format!("{known:?}")),
    }
}

/// Other processors do not report a hypervisor.
#[cfg(not(target_arch = "x86_64"))]
fn answering_hypervisor() -> Option<String> {
    None
}

fn container(root: &Root) -> Option<String> {
    let marks = [(".dockerenv", "docker"), ("run/.containerenv", "podman")];
    (marks.iter())
        .find(|(mark, _)| root.holds(mark))
        .map(|(_, name)| (*name).to_owned())
        .or_else(|| {
            let environment = root.text("proc/1/environ")?;
            let entry = environment
                .split('\0')
                .find_map(|e| e.strip_prefix("container="))?;
            Some(entry.to_owned())
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn root(files: &[(&str, &str)]) -> (tempfile::TempDir, Root) {
        let folder = tempfile::tempdir().unwrap();
        for (path, text) in files {
            let path = folder.path().join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        let root = Root(folder.path().to_path_buf());
        (folder, root)
    }

    #[test]
    #[cfg(feature = "hwloc")]
    fn a_system_is_read_as_it_describes_itself() {
        let (_folder, root) = root(&[
            (
                "proc/meminfo",
                "MemTotal: 100 kB\nMemAvailable: 2048 kB\nHugePages_Total: 3\nHugepagesize: 2048 kB\n",
            ),
            ("proc/self/status", "Name: x\nCpus_allowed_list:\t0-3,8\n"),
            ("proc/self/cgroup", "0::/work\n"),
            ("proc/cpuinfo", "flags : fpu avx hypervisor\n"),
            ("sys/class/dmi/id/sys_vendor", "QEMU\n"),
            ("sys/fs/cgroup/work/cpu.max", "150000 100000\n"),
            ("sys/fs/cgroup/memory.max", "4096\n"),
            ("sys/devices/system/cpu/online", "0-7\n"),
            ("proc/sys/kernel/numa_balancing", "1\n"),
            (
                "sys/devices/system/cpu/cpu0/cpufreq/scaling_governor",
                "powersave\n",
            ),
            (
                "sys/devices/system/cpu/cpu0/cpufreq/cpuinfo_max_freq",
                "2400000\n",
            ),
            ("sys/devices/system/node/node1/distance", "21 10\n"),
            (
                "sys/kernel/mm/transparent_hugepage/enabled",
                "always [madvise] never\n",
            ),
            (".dockerenv", "x"),
        ]);
        let topology = Topology::synthetic("package:2 [numa] core:2 pu:1").unwrap();
        let found = describe(&topology, &root);
        assert_eq!(found.memory_available, Some(2 << 20));
        assert_eq!(found.allowed.as_deref(), Some("0-3,8"));
        assert_eq!((found.threads, found.threads_online), (4, Some(8)));
        assert_eq!(found.quota_percent, Some(150));
        assert_eq!(found.memory_limit, Some(4096));
        assert_eq!(found.numa_balancing, Some(1));
        // A synthetic machine has no firmware.
        assert!(found.paths.is_empty());
        assert_eq!(found.governor.as_deref(), Some("powersave"));
        assert_eq!(found.frequency, Some(2_400_000_000));
        assert_eq!(found.hypervisor.as_deref(), Some("QEMU"));
        assert_eq!(found.container.as_deref(), Some("docker"));
        assert_eq!(found.nodes[1].distances, [21, 10]);
        assert!(found.nodes[0].distances.is_empty());
        let pages = found.huge_pages;
        assert_eq!(pages.transparent.as_deref(), Some("madvise"));
        assert_eq!((pages.size, pages.reserved), (Some(2 << 20), Some(3)));
    }

    #[test]
    #[cfg(feature = "hwloc")]
    fn a_system_that_tells_nothing_leaves_gaps() {
        let (_folder, root) = root(&[("sys/fs/cgroup/cpu.max", "max 100000\n")]);
        let topology = Topology::synthetic("pu:1").unwrap();
        let found = describe(&topology, &root);
        assert_eq!((found.quota_percent, found.memory_limit), (None, None));
        assert_eq!((&found.hypervisor, &found.container), (&None, &None));
        assert_eq!(found.huge_pages, HugePages::default());
        assert_eq!((found.cores, found.nodes.len()), (1, 1));
    }

    #[test]
    fn lists_are_counted() {
        for (list, count) in [("0", 1), ("0-3,8", 5), ("", 0), ("3-1", 0), ("0,2,4-5", 4)] {
            assert_eq!(count_of_list(list), count, "{list}");
        }
    }
}
