//! What does each row of a measurement describe? In words and as columns.

use super::measurement::{Key, Measurement};
use crate::store::table::{Column, columns};
use crate::units::plural;
use serde::{Deserialize, Serialize};

/// Reading a buffer with a stride, one thread.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MountainKey {
    /// Size of the buffer \[bytes\].
    pub size: u64,
    /// Distance between cache lines that are read in succession \[bytes\]. A pass reads every line once, in
    /// `stride` over line size sweeps.
    pub stride: u64,
}

impl Key for MountainKey {
    const NAME: &'static str = "mountain";
    const MEASURED: [&'static str; 3] = ["bandwidth", "B/s", "bytes read per second"];

    fn words(&self) -> String {
        format!("{} B, stride {} B", self.size, self.stride)
    }

    fn columns() -> Vec<Column<Measurement<Self>>> {
        columns![row: Measurement<Self>;
            u64 "size", "B", row.key.size, "Size of the buffer";
            u64 "stride", "B", row.key.stride, "Distance between successive cache lines";
        ]
    }
}

/// Streaming through arrays on several threads.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BandwidthKey {
    /// `read`, `copy`, `triad`, `copy_nt`, `triad_nt` (non-temporal stores).
    pub kernel: String,
    /// `compact` or `scattered` over nodes, or `nodes`: threads of one node, memory of another.
    pub placement: String,
    /// Threads.
    pub threads: u64,
    /// Node of the threads, if all are on one.
    pub cpu_node: Option<u32>,
    /// Node of the memory, if all is on one.
    pub memory_node: Option<u32>,
    /// Size of each array over all threads \[bytes\].
    pub array: u64,
    /// Bytes that a repetition reads and writes according to the program. Lines that the processor fetches before it
    /// overwrites them do not count.
    pub bytes: u64,
}

impl Key for BandwidthKey {
    const NAME: &'static str = "bandwidth";
    const MEASURED: [&'static str; 3] = ["bandwidth", "B/s", "bytes per second"];

    fn words(&self) -> String {
        let nodes = match (self.cpu_node, self.memory_node) {
            (Some(cpu), Some(memory)) => format!(", node {cpu} from node {memory}"),
            _ => String::new(),
        };
        let threads = plural(self.threads as usize, "thread");
        format!("{}, {}, {threads}{nodes}", self.kernel, self.placement)
    }

    fn columns() -> Vec<Column<Measurement<Self>>> {
        columns![row: Measurement<Self>;
            text "kernel", "", row.key.kernel.as_str(), "Name of the kernel";
            text "placement", "", row.key.placement.as_str(), "Placement of the threads: compact, scattered or nodes";
            u64 "threads", "1", row.key.threads, "Threads";
            u32 "cpu_node", "1", row.key.cpu_node, "Node of the threads";
            u32 "memory_node", "1", row.key.memory_node, "Node of the memory";
            u64 "array", "B", row.key.array, "Size of each array";
            u64 "bytes", "B", row.key.bytes, "Bytes read and written per repetition";
        ]
    }
}

/// A chain of loads, each of which depends on the previous one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LatencyKey {
    /// Size of the buffer \[bytes\].
    pub size: u64,
    /// `pages`: in random order within a page, page after page. `hops`: every load goes to another page, so that the
    /// address translation counts and prefetching does not help.
    pub order: String,
    /// Whether huge pages were requested.
    pub huge_pages: bool,
    /// Node of the thread.
    pub cpu_node: u32,
    /// Node of the memory.
    pub memory_node: u32,
}

impl Key for LatencyKey {
    const NAME: &'static str = "latency";
    const MEASURED: [&'static str; 3] = ["latency", "s", "time of a load"];

    fn words(&self) -> String {
        let huge_pages = if self.huge_pages { ", huge pages" } else { "" };
        format!(
            "{} B, {}{huge_pages}, node {} from node {}",
            self.size, self.order, self.cpu_node, self.memory_node
        )
    }

    fn columns() -> Vec<Column<Measurement<Self>>> {
        columns![row: Measurement<Self>;
            u64 "size", "B", row.key.size, "Size of the buffer";
            text "order", "", row.key.order.as_str(), "Order of the loads: pages (random within a page, page after \
                                                       page) or hops (to another page with every load)";
            bool "huge_pages", "", row.key.huge_pages, "Whether the buffer was on huge pages";
            u32 "cpu_node", "1", row.key.cpu_node, "Node of the thread";
            u32 "memory_node", "1", row.key.memory_node, "Node of the memory";
        ]
    }
}

/// Multiply-adds of double-precision numbers in registers; each counts as two operations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ArithmeticKey {
    /// Instruction set.
    pub isa: String,
    /// Threads.
    pub threads: u64,
}

impl Key for ArithmeticKey {
    const NAME: &'static str = "arithmetic";
    const MEASURED: [&'static str; 3] = ["rate", "1/s", "operations per second"];

    fn words(&self) -> String {
        format!("{}, {}", self.isa, plural(self.threads as usize, "thread"))
    }

    fn columns() -> Vec<Column<Measurement<Self>>> {
        columns![row: Measurement<Self>;
            text "isa", "", row.key.isa.as_str(), "Instruction set";
            u64 "threads", "1", row.key.threads, "Threads";
        ]
    }
}

/// Integration of the default drive, with the same trajectories on every thread.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SolverKey {
    /// `volterra` or `closed_modes`.
    pub kernel: String,
    /// `shared`: one copy of the tables for all threads; `node`: one per NUMA node; `private`: one per
    /// thread.
    pub tables: String,
    /// Modes.
    pub modes: u64,
    /// Operating points that every thread cycles through.
    pub points: u64,
    /// Threads.
    pub threads: u64,
    /// Bytes of one table, which belongs to an operating point (`volterra`) or a structure (`closed_modes`).
    pub table_bytes: u64,
    /// Rate divided by the threads and by the rate of one thread, measured alternately: the median over all turns.
    pub efficiency: f64,
}

impl Key for SolverKey {
    const NAME: &'static str = "solver";
    const MEASURED: [&'static str; 3] = ["rate", "1/s", "mesh cycles per second, all threads"];

    fn words(&self) -> String {
        let threads = plural(self.threads as usize, "thread");
        let (kernel, modes, tables, points) = (&self.kernel, self.modes, &self.tables, self.points);
        format!("{kernel}, {modes} modes, {points} points, tables {tables}, {threads}")
    }

    fn columns() -> Vec<Column<Measurement<Self>>> {
        columns![row: Measurement<Self>;
            text "kernel", "", row.key.kernel.as_str(), "Kernel: volterra or closed_modes";
            text "tables", "", row.key.tables.as_str(), "Copies of the tables: shared, node or private";
            u64 "modes", "1", row.key.modes, "Modes";
            u64 "points", "1", row.key.points, "Operating points per thread, computed in turn";
            u64 "threads", "1", row.key.threads, "Threads";
            u64 "table_bytes", "B", row.key.table_bytes, "Size of one table";
            f64 "efficiency", "1", row.key.efficiency, "Rate divided by the rate of one thread and by the number of threads";
        ]
    }
}
