//! Name, memory and instruction sets of the machine for the record, clocks of processor time, and the parsing of files
//! of Linux.

use rustix::time::{ClockId, clock_gettime};
use std::fs;
use std::path::Path;

/// Description of a machine in words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Machine {
    /// Name of the processor; `unknown` if the system does not report it.
    pub cpu: String,
    /// Memory \[bytes\]; 0 if unknown.
    pub memory: u64,
    /// Instruction sets beyond the baseline, widest last.
    pub isa: Vec<&'static str>,
    /// Operating system and architecture.
    pub system: String,
}

impl Machine {
    /// The machine that the program runs on.
    pub fn current() -> Self {
        let read = |path| fs::read_to_string(path).unwrap_or_default();
        Self {
            cpu: field(&read("/proc/cpuinfo"), "model name")
                .unwrap_or("unknown")
                .to_owned(),
            memory: bytes_of_kib_field(&read("/proc/meminfo"), "MemTotal").unwrap_or(0),
            isa: instruction_sets(),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        }
    }
}

/// Largest resident memory of this process so far \[bytes\]; `None` if the system does not report it.
pub fn peak_memory() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    bytes_of_kib_field(&status, "VmHWM")
}

/// A clock of processor time, which does not run while other programs use the core.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProcessorClock {
    /// Time of the calling thread.
    Thread,
    /// Time of all threads of the process.
    Process,
}

impl ProcessorClock {
    /// Processor time used so far \[s\].
    pub fn now(self) -> f64 {
        let time = clock_gettime(match self {
            Self::Thread => ClockId::ThreadCPUTime,
            Self::Process => ClockId::ProcessCPUTime,
        });
        time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
    }
}

/// Free memory of a NUMA node \[bytes\]; `None` if the system does not report it. `root` is `/` except in tests.
pub(super) fn free_memory(root: &Path, node: u32) -> Option<u64> {
    let path = format!("sys/devices/system/node/node{node}/meminfo");
    let text = fs::read_to_string(root.join(path)).ok()?;
    bytes_of_kib_field(&text, &format!("Node {node} MemFree"))
}

/// Value of the first line `key : value` with this key.
pub fn field<'a>(text: &'a str, key: &str) -> Option<&'a str> {
    text.lines().find_map(|line| {
        let (name, value) = line.split_once(':')?;
        (name.trim() == key).then(|| value.trim())
    })
}

/// Value in bytes of the line `key : value kB`, which counts in KiB; `None` if there is no such line.
pub fn bytes_of_kib_field(text: &str, key: &str) -> Option<u64> {
    let kibibytes = field(text, key)?.strip_suffix("kB")?.trim();
    Some(1024 * kibibytes.parse::<u64>().ok()?)
}

#[cfg(target_arch = "x86_64")]
fn instruction_sets() -> Vec<&'static str> {
    let sets = [
        ("avx", is_x86_feature_detected!("avx")),
        ("fma", is_x86_feature_detected!("fma")),
        ("avx2", is_x86_feature_detected!("avx2")),
        ("avx512f", is_x86_feature_detected!("avx512f")),
    ];
    sets.into_iter()
        .filter_map(|(name, offered)| offered.then_some(name))
        .collect()
}

#[cfg(not(target_arch = "x86_64"))]
fn instruction_sets() -> Vec<&'static str> {
    Vec::new()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_the_kernel_s_own_format() {
        let cpuinfo = "processor\t: 0\nmodel name\t: Some CPU @ 2.40GHz\nflags\t\t: fpu avx\n";
        assert_eq!(field(cpuinfo, "model name"), Some("Some CPU @ 2.40GHz"));
        assert_eq!(field(cpuinfo, "model"), None);
        assert_eq!(
            bytes_of_kib_field("MemTotal:       16384 kB\n", "MemTotal"),
            Some(16 << 20)
        );
        assert_eq!(bytes_of_kib_field("MemTotal: unknown\n", "MemTotal"), None);
        let node = "Node 0 MemTotal:  100 kB\nNode 0 MemFree:   60 kB\n";
        assert_eq!(bytes_of_kib_field(node, "Node 0 MemFree"), Some(60 << 10));
    }
}
