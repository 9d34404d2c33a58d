//! Further measurements of memory: under load, by percentiles, of several chains, and from core to
//! core; and what threads gain.

use super::keys::Threads;
use super::measurement::{Key, Measurement};
use crate::store::table::{Column, columns};
use serde::{Deserialize, Serialize};

/// A chain of loads on one core while others read; in the middle of the repetitions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LoadedKey {
    /// Size of the buffer that the chain goes through \[bytes\].
    pub size: u64,
    /// Whether huge pages were asked for.
    pub huge_pages: bool,
    /// Threads that read.
    pub threads: u64,
    /// Turns of an empty loop that they make after every 2 KiB; none where they do not read.
    pub pause: Option<u32>,
    /// What they read a second \[bytes/s\]; 0 where they do not read.
    pub bandwidth: f64,
}

impl Key for LoadedKey {
    const NAME: &'static str = "loaded";
    const FIGURE: [&'static str; 3] = ["latency", "s", "time of a load"];
    const REPETITION: &'static str = "middle";

    fn words(&self) -> String {
        match self.pause {
            Some(pause) => format!("{} read, pause {pause}", Threads(self.threads)),
            None => "nobody reads".to_owned(),
        }
    }

    fn columns() -> Vec<Column<Measurement<Self>>> {
        columns![row: Measurement<Self>;
            u64 "size", "B", row.key.size, "Size of the buffer that the chain goes through";
            bool "huge_pages", "", row.key.huge_pages, "Whether they were asked for";
            u64 "threads", "1", row.key.threads, "Threads that read";
            u32 "pause", "1", row.key.pause, "Turns of an empty loop after every 2 KiB that they read";
            f64 "bandwidth", "B/s", row.key.bandwidth, "What they read a second";
        ]
    }
}

/// A percentile of the time of a load in short batches; of a round each.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PercentileKey {
    /// Size of the buffer \[bytes\].
    pub size: u64,
    /// Whether huge pages were asked for.
    pub huge_pages: bool,
    /// So many per cent of the batches were not slower.
    pub percentile: f64,
    /// Loads of a batch.
    pub batch: u64,
    /// Time of looking at the clock, which was subtracted from every batch \[s\].
    pub clock: f64,
}

impl Key for PercentileKey {
    const NAME: &'static str = "percentiles";
    const FIGURE: [&'static str; 3] = ["latency", "s", "time of a load in a batch"];
    const REPETITION: &'static str = "middle";

    fn words(&self) -> String {
        format!("{} B, p{}", self.size, self.percentile)
    }

    fn columns() -> Vec<Column<Measurement<Self>>> {
        columns![row: Measurement<Self>;
            u64 "size", "B", row.key.size, "Size of the buffer";
            bool "huge_pages", "", row.key.huge_pages, "Whether they were asked for";
            f64 "percentile", "1", row.key.percentile, "Per cent of the batches that were not slower";
            u64 "batch", "1", row.key.batch, "Loads of a batch";
            f64 "clock", "s", row.key.clock, "Time of looking at the clock, subtracted from every batch";
        ]
    }
}

/// Several chains of loads that one core follows at once.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ParallelKey {
    /// Size of the buffer that they share \[bytes\].
    pub size: u64,
    /// Whether huge pages were asked for.
    pub huge_pages: bool,
    /// Chains.
    pub chains: u64,
}

impl Key for ParallelKey {
    const NAME: &'static str = "parallel";
    const FIGURE: [&'static str; 3] = ["rate", "1/s", "loads a second"];

    fn words(&self) -> String {
        format!("{} B, {} chains", self.size, self.chains)
    }

    fn columns() -> Vec<Column<Measurement<Self>>> {
        columns![row: Measurement<Self>;
            u64 "size", "B", row.key.size, "Size of the buffer";
            bool "huge_pages", "", row.key.huge_pages, "Whether they were asked for";
            u64 "chains", "1", row.key.chains, "Chains of loads at once";
        ]
    }
}

/// A line of memory that two hardware threads hand back and forth, one way; in the middle of the
/// repetitions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TransferKey {
    /// One of them, as the system numbers it.
    pub a: u32,
    /// The other one.
    pub b: u32,
    /// The nearest thing that they share: `core`, `cache`, `package` or `machine`.
    pub share: String,
}

impl Key for TransferKey {
    const NAME: &'static str = "transfer";
    const FIGURE: [&'static str; 3] = ["latency", "s", "time of handing a line over, one way"];
    const REPETITION: &'static str = "middle";

    fn words(&self) -> String {
        format!("{} and {}", self.a, self.b)
    }

    fn columns() -> Vec<Column<Measurement<Self>>> {
        columns![row: Measurement<Self>;
            u32 "a", "1", row.key.a, "One hardware thread";
            u32 "b", "1", row.key.b, "The other one";
            text "share", "", row.key.share.as_str(), "core, cache, package or machine";
        ]
    }
}

/// What a team gains over one thread: the ratio of their rates, measured in turn; the median of a
/// round's ratios.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GainKey {
    /// `volterra`, `spectral` or `fused`.
    pub kernel: String,
    /// `shared`, `node` or `eight`.
    pub tables: String,
    /// Modes.
    pub modes: u64,
    /// Threads.
    pub threads: u64,
}

impl Key for GainKey {
    const NAME: &'static str = "gain";
    const FIGURE: [&'static str; 3] = ["gain", "1", "rate over that of one thread, in turn"];
    const REPETITION: &'static str = "middle";

    fn words(&self) -> String {
        let (kernel, modes, tables) = (&self.kernel, self.modes, &self.tables);
        let threads = Threads(self.threads);
        format!("{kernel}, {modes} modes, tables {tables}, {threads}")
    }

    fn columns() -> Vec<Column<Measurement<Self>>> {
        columns![row: Measurement<Self>;
            text "kernel", "", row.key.kernel.as_str(), "What was run";
            text "tables", "", row.key.tables.as_str(), "shared, node or eight";
            u64 "modes", "1", row.key.modes, "Modes";
            u64 "threads", "1", row.key.threads, "Threads";
        ]
    }
}
