//! What follows from the figures: the roofline; and what disturbed them.

use crate::store::file::Row;
use crate::store::table::{Table, columns};
use serde::{Deserialize, Serialize};

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

impl RoofRow {
    /// The columns.
    pub fn table() -> Table<Self> {
        Table::new(columns![row: Self;
            text "kernel", "", row.kernel.as_str(), "Name of the kernel";
            u64 "modes", "1", row.modes, "Modes";
            f64 "operations", "1", row.operations, "Operations per mesh cycle";
            f64 "bytes_read", "B", row.bytes_read, "Bytes of tables read per mesh cycle";
            f64 "bytes_distinct", "B", row.bytes_distinct, "Different bytes of tables read per mesh cycle";
            f64 "intensity", "1/B", row.intensity, "Operations divided by different bytes read";
            f64 "rate", "1/s", row.rate, "Operations per second";
        ])
    }
}

impl Row for RoofRow {}

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
    /// Whether the machine was quiet enough for the figures to be those of the machine.
    pub quiet: bool,
    /// What was noticed, a sentence each.
    pub remarks: Vec<String>,
}
