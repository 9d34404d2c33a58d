//! The measurements: what each row is of, in words and as columns.

use super::measurement::{Key, Measurement};
use crate::store::table::{Column, columns};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Reading a buffer with a stride, one thread.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MountainKey {
    /// Size of the buffer \[bytes\].
    pub size: u64,
    /// From line to line \[bytes\]; every line is read once a pass, in `stride` over line size
    /// sweeps.
    pub stride: u64,
}

impl Key for MountainKey {
    const NAME: &'static str = "mountain";
    const FIGURE: [&'static str; 3] = ["bandwidth", "B/s", "bytes read a second"];

    fn words(&self) -> String {
        format!("{} B, stride {} B", self.size, self.stride)
    }

    fn columns() -> Vec<Column<Measurement<Self>>> {
        columns![row: Measurement<Self>;
            u64 "size", "B", row.key.size, "Size of the buffer";
            u64 "stride", "B", row.key.stride, "From line to line";
        ]
    }
}

/// A kernel that goes round a set of tables, one thread; its figure is the time of a product, of
/// a window (`volterra`), of a product with the work on events around it (`spectral`) \[s\].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OperatorKey {
    /// `matvec`, the dense product of the table kernels; `volterra` or `spectral`, whole cycles.
    pub kernel: String,
    /// Rows of the dense operator, or twice the modes plus one.
    pub dimension: u64,
    /// Operators, or operating points with tables of their own.
    pub count: u64,
    /// Bytes of all of them.
    pub working_set: u64,
}

impl Key for OperatorKey {
    const NAME: &'static str = "operators";
    const FIGURE: [&'static str; 3] = ["time", "s", "time of a product or window"];

    fn words(&self) -> String {
        format!(
            "{} of dimension {}, {}",
            self.kernel, self.dimension, self.count
        )
    }

    fn columns() -> Vec<Column<Measurement<Self>>> {
        columns![row: Measurement<Self>;
            text "kernel", "", row.key.kernel.as_str(), "matvec, volterra or spectral";
            u64 "dimension", "1", row.key.dimension, "Rows of the dense operator";
            u64 "count", "1", row.key.count, "Tables in rotation";
            u64 "working_set", "B", row.key.working_set, "Bytes of all of them";
        ]
    }
}

/// Streaming through arrays on some threads.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BandwidthKey {
    /// `read`, `copy`, `triad`, `copy_nt`, `triad_nt` (non-temporal stores); `update_3_1`, `_2_1`,
    /// `_1_1` (so many lines read for one written, which is one of them), `fill_nt`.
    pub kernel: String,
    /// `compact` or `scattered` over nodes, or `nodes`: threads of one node, memory of another.
    pub placement: String,
    /// Threads.
    pub threads: u64,
    /// Node of the threads, where they are of one.
    pub cpu_node: Option<u32>,
    /// Node of the memory, where it is of one.
    pub memory_node: Option<u32>,
    /// Size of each array over all threads \[bytes\].
    pub array: u64,
    /// Bytes a repetition reads and writes, as the program states them: no line fetched before it
    /// is overwritten is counted.
    pub bytes: u64,
}

impl Key for BandwidthKey {
    const NAME: &'static str = "bandwidth";
    const FIGURE: [&'static str; 3] = ["bandwidth", "B/s", "bytes a second"];

    fn words(&self) -> String {
        let nodes = match (self.cpu_node, self.memory_node) {
            (Some(cpu), Some(memory)) => format!(", node {cpu} from node {memory}"),
            _ => String::new(),
        };
        let threads = Threads(self.threads);
        format!("{}, {}, {threads}{nodes}", self.kernel, self.placement)
    }

    fn columns() -> Vec<Column<Measurement<Self>>> {
        columns![row: Measurement<Self>;
            text "kernel", "", row.key.kernel.as_str(), "What was run";
            text "placement", "", row.key.placement.as_str(), "compact, scattered or nodes";
            u64 "threads", "1", row.key.threads, "Threads";
            u32 "cpu_node", "1", row.key.cpu_node, "Node of the threads";
            u32 "memory_node", "1", row.key.memory_node, "Node of the memory";
            u64 "array", "B", row.key.array, "Size of each array";
            u64 "bytes", "B", row.key.bytes, "Bytes read and written a repetition";
        ]
    }
}

/// A chain of loads, each of which depends on the one before.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LatencyKey {
    /// Size of the buffer \[bytes\].
    pub size: u64,
    /// `pages`: in random order within a page, page after page; `hops`: to another page with
    /// every load, so that the search for the page's place counts and no prefetch helps.
    pub order: String,
    /// Whether huge pages were asked for.
    pub huge_pages: bool,
    /// Node of the thread.
    pub cpu_node: u32,
    /// Node of the memory.
    pub memory_node: u32,
}

impl Key for LatencyKey {
    const NAME: &'static str = "latency";
    const FIGURE: [&'static str; 3] = ["latency", "s", "time of a load"];

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
            text "order", "", row.key.order.as_str(), "pages or hops";
            bool "huge_pages", "", row.key.huge_pages, "Whether they were asked for";
            u32 "cpu_node", "1", row.key.cpu_node, "Node of the thread";
            u32 "memory_node", "1", row.key.memory_node, "Node of the memory";
        ]
    }
}

/// Multiply-adds of double-precision numbers in registers, two operations each.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ArithmeticKey {
    /// Instruction set.
    pub isa: String,
    /// Threads.
    pub threads: u64,
}

impl Key for ArithmeticKey {
    const NAME: &'static str = "arithmetic";
    const FIGURE: [&'static str; 3] = ["rate", "1/s", "operations a second"];

    fn words(&self) -> String {
        format!("{}, {}", self.isa, Threads(self.threads))
    }

    fn columns() -> Vec<Column<Measurement<Self>>> {
        columns![row: Measurement<Self>;
            text "isa", "", row.key.isa.as_str(), "Instruction set";
            u64 "threads", "1", row.key.threads, "Threads";
        ]
    }
}

/// Integrating the default drive, the same trajectory on every thread.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SolverKey {
    /// `volterra`, `spectral` or `fused`.
    pub kernel: String,
    /// `shared`: one table for all threads; `node`: one a NUMA node; `eight`: one for each of
    /// eight operating points, between which every thread changes.
    pub tables: String,
    /// Modes.
    pub modes: u64,
    /// Threads.
    pub threads: u64,
    /// Bytes of one table.
    pub table_bytes: u64,
    /// Rate over that of one thread, measured in turn, and over the threads.
    pub efficiency: Option<f64>,
}

impl Key for SolverKey {
    const NAME: &'static str = "solver";
    const FIGURE: [&'static str; 3] = ["rate", "1/s", "mesh cycles a second, all threads"];

    fn words(&self) -> String {
        let threads = Threads(self.threads);
        let (kernel, modes, tables) = (&self.kernel, self.modes, &self.tables);
        format!("{kernel}, {modes} modes, tables {tables}, {threads}")
    }

    fn columns() -> Vec<Column<Measurement<Self>>> {
        columns![row: Measurement<Self>;
            text "kernel", "", row.key.kernel.as_str(), "What was run";
            text "tables", "", row.key.tables.as_str(), "shared, node or eight";
            u64 "modes", "1", row.key.modes, "Modes";
            u64 "threads", "1", row.key.threads, "Threads";
            u64 "table_bytes", "B", row.key.table_bytes, "Bytes of one table";
            f64 "efficiency", "1", row.key.efficiency, "Rate over that of one thread times the threads";
        ]
    }
}

/// `1 thread`, `4 threads`.
pub(super) struct Threads(pub u64);

impl fmt::Display for Threads {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} thread{}", self.0, if self.0 == 1 { "" } else { "s" })
    }
}
