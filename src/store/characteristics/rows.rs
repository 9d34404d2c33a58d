//! The rows of every measurement, and the figure that each carries.

use crate::store::file::Row;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A measured figure, in the unit of its row.
///
/// A measurement is repeated within a round, and rounds are repeated, minutes apart and with
/// memory taken anew. Disturbances only ever make a repetition worse, so a round gives its best
/// one; what differs between rounds is what will differ in the next run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// Median over the rounds of the best repetition of each.
    pub value: f64,
    /// Best repetition of all.
    pub best: f64,
    /// Median of all repetitions.
    pub median: f64,
    /// Another run's value lies within this part of `value` with 95 %; absent after one round.
    pub spread: Option<f64>,
    /// Rounds.
    pub rounds: u64,
    /// Repetitions of all rounds.
    pub repetitions: u64,
}

/// Reading a buffer with a stride, one thread.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MountainRow {
    /// Size of the buffer \[bytes\].
    pub size: u64,
    /// From line to line \[bytes\]; every line is read once a pass, in `stride` over line size
    /// sweeps.
    pub stride: u64,
    /// Bytes read a second.
    pub bandwidth: Figure,
}

/// A kernel that goes round a set of tables, one thread.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OperatorRow {
    /// `matvec`, the dense product of the table kernels; `volterra` or `spectral`, whole cycles.
    pub kernel: String,
    /// Rows of the dense operator, or twice the modes plus one.
    pub dimension: u64,
    /// Operators, or operating points with tables of their own.
    pub count: u64,
    /// Bytes of all of them.
    pub working_set: u64,
    /// Time of a product, of a window (`volterra`), of a product with the work on events around
    /// it (`spectral`) \[s\].
    pub time: Figure,
}

/// Where the cost of one kernel jumps as its working set grows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Cliff {
    /// What was measured, in words.
    pub of: String,
    /// Working set at the middle of the jump \[bytes\].
    pub size: f64,
    /// The jump starts after this \[bytes\].
    pub from: f64,
    /// It ends before this \[bytes\].
    pub to: f64,
    /// Cost after over cost before.
    pub ratio: f64,
    /// Level of the reported cache that it belongs to.
    pub cache: Option<usize>,
}

/// Streaming through arrays on some threads.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BandwidthRow {
    /// `read`, `copy`, `triad`, `copy_nt`, `triad_nt` (non-temporal stores).
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
    /// Bytes a second.
    pub bandwidth: Figure,
}

/// Time of a load that depends on the one before.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LatencyRow {
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
    /// Time of a load \[s\].
    pub latency: Figure,
}

/// Multiply-adds of numbers in registers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ArithmeticRow {
    /// Instruction set.
    pub isa: String,
    /// Threads.
    pub threads: u64,
    /// Double-precision operations a second, two a multiply-add.
    pub rate: Figure,
}

/// Integrating the default drive, the same trajectory on every thread.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SolverRow {
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
    /// Mesh cycles a second, all threads together.
    pub rate: Figure,
    /// Rate over that of one thread times the threads.
    pub efficiency: Option<f64>,
}

/// A kernel under the roof of arithmetic and bandwidth; one thread.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RoofRow {
    /// The kernel.
    pub kernel: String,
    /// Modes.
    pub modes: u64,
    /// Operations of a mesh cycle, counted: two a number of a table.
    pub operations: f64,
    /// Bytes of tables that a cycle reads, each as often as it is read.
    pub bytes_read: f64,
    /// Bytes of different table entries that a cycle reads: what memory must deliver if nothing
    /// stays in a cache from cycle to cycle.
    pub bytes_distinct: f64,
    /// Operations over different bytes.
    pub intensity: f64,
    /// Operations a second.
    pub rate: f64,
}

/// What disturbed the measurements.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Noise {
    /// Part of the usable processors' time that other programs took.
    pub others: Option<f64>,
    /// Part that the hypervisor took.
    pub stolen: Option<f64>,
    /// Runnable tasks on the machine when the measurements began (load average of a minute).
    pub load: Option<f64>,
    /// How far the median repetition lies behind the best, in the middle of all measurements.
    pub scatter: Option<f64>,
    /// Part of the measurements before or after which mesh cycles took longer than at their
    /// best.
    #[serde(default)]
    pub slowed: Option<f64>,
    /// Time spent waiting for them to be fast again, and measuring once more \[s\].
    #[serde(default)]
    pub waited: f64,
    /// Whether the machine was quiet enough for the figures to be those of the machine.
    pub quiet: bool,
    /// What was noticed, a sentence each.
    pub remarks: Vec<String>,
}

/// A row that can be found again in another run.
pub trait Keyed {
    /// What was measured, in words: equal for the same measurement of another run.
    fn key(&self) -> String;
    /// What came out.
    fn figure(&self) -> &Figure;
}

/// `read, compact, 4 threads`: a BandwidthRow in words, and so on.
macro_rules! keyed {
    ($row:ty, $figure:ident, |$self:ident| $key:expr) => {
        impl Keyed for $row {
            fn key(&self) -> String {
                let $self = self;
                $key
            }
            fn figure(&self) -> &Figure {
                &self.$figure
            }
        }
        impl Row for $row {}
    };
}

keyed!(MountainRow, bandwidth, |row| format!(
    "mountain, {} B, stride {} B",
    row.size, row.stride
));
keyed!(OperatorRow, time, |row| format!(
    "operators, {} of dimension {}, {}",
    row.kernel, row.dimension, row.count
));
keyed!(BandwidthRow, bandwidth, |row| {
    let nodes = match (row.cpu_node, row.memory_node) {
        (Some(cpu), Some(memory)) => format!(", node {cpu} from node {memory}"),
        _ => String::new(),
    };
    let (kernel, placement, threads) = (&row.kernel, &row.placement, Threads(row.threads));
    format!("bandwidth, {kernel}, {placement}, {threads}{nodes}")
});
keyed!(LatencyRow, latency, |row| format!(
    "latency, {} B, {}{}, node {} from node {}",
    row.size,
    row.order,
    if row.huge_pages { ", huge pages" } else { "" },
    row.cpu_node,
    row.memory_node
));
keyed!(ArithmeticRow, rate, |row| format!(
    "arithmetic, {}, {}",
    row.isa,
    Threads(row.threads)
));
keyed!(SolverRow, rate, |row| format!(
    "solver, {}, {} modes, tables {}, {}",
    row.kernel,
    row.modes,
    row.tables,
    Threads(row.threads)
));

impl Row for RoofRow {}

/// `1 thread`, `4 threads`.
struct Threads(u64);

impl fmt::Display for Threads {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} thread{}", self.0, if self.0 == 1 { "" } else { "s" })
    }
}
