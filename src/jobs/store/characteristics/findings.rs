//! Results derived from the figures: the roofline, and disturbances of the measurements.

use crate::store::table::{Table, columns};
use serde::{Deserialize, Serialize};

/// A kernel in the roofline model, which limits its rate by arithmetic and bandwidth; one thread.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RoofRow {
    /// The kernel.
    pub kernel: String,
    /// Modes.
    pub modes: u64,
    /// Operations of a mesh cycle: two per number of a table.
    pub operations: f64,
    /// Bytes of tables that a cycle reads, counted as often as they are read.
    pub bytes_read: f64,
    /// Bytes of different table entries that a cycle reads. Memory must deliver these if nothing stays in a cache
    /// between cycles.
    pub bytes_distinct: f64,
    /// Operations divided by `bytes_distinct` \[1/byte\].
    pub intensity: f64,
    /// Operations per second.
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

/// Disturbances of the measurements.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Noise {
    /// Share of the usable processors' time that other programs used.
    pub others: Option<f64>,
    /// Share that the hypervisor took.
    pub stolen: Option<f64>,
    /// Runnable tasks on the machine at the start of the measurements (load average of a minute).
    pub load: Option<f64>,
    /// Difference between the median repetition and the best one, as a median over all measurements.
    pub scatter: Option<f64>,
    /// Whether the machine was quiet enough for reliable figures.
    pub quiet: bool,
    /// Observations, one sentence each.
    pub remarks: Vec<String>,
}
