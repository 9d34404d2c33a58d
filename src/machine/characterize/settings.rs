//! The request for measurements, and their progress.

use super::team::RepetitionTime;
use clap::ValueEnum;
use std::time::Duration;
use strum::{IntoStaticStr, VariantArray};

/// Amount of measurements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
pub enum Extent {
    /// About one minute.
    Quick,
    /// Some minutes.
    Default,
    /// Up to an hour, larger working sets, more modes.
    Full,
}

impl Extent {
    /// Its name in the record.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// Intended time.
    pub fn budget(self) -> Duration {
        Duration::from_secs(match self {
            Self::Quick => 55,
            Self::Default => 240,
            Self::Full => 2400,
        })
    }

    /// Largest number of rounds.
    pub fn rounds(self) -> usize {
        match self {
            Self::Quick => 3,
            Self::Default => 5,
            Self::Full => 9,
        }
    }

    /// Duration and number of the repetitions in a round.
    pub fn pace(self) -> RepetitionTime {
        let (slice, least) = match self {
            Self::Quick => (6, 3),
            Self::Default => (15, 5),
            Self::Full => (40, 7),
        };
        RepetitionTime {
            slice: Duration::from_millis(slice),
            least,
            most: 1000,
        }
    }
}

/// A part of the measurements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantArray, ValueEnum)]
#[strum(serialize_all = "lowercase")]
pub enum Part {
    /// Multiply-adds in registers, by instruction set.
    Arithmetic,
    /// Read, copy and triad for several numbers of threads, and reading from node to node.
    Bandwidth,
    /// Integrating with several numbers of modes, operating points, threads and copies of tables.
    Solver,
    /// Reading buffers by size and stride.
    Mountain,
    /// Loads that depend on each other.
    Latency,
}

impl Part {
    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// The request for measurements.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Settings {
    /// Amount of measurements.
    pub extent: Extent,
    /// Time after which no measurement begins.
    pub budget: Duration,
    /// The requested parts; all if empty.
    pub only: Vec<Part>,
    /// Largest number of rounds, if smaller than usual.
    pub rounds: Option<usize>,
    /// Largest memory to use \[bytes\]. The default is a quarter of the free memory, or of a smaller limit of
    /// the control group.
    pub memory: Option<u64>,
}

/// Progress of the measurements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Number of finished rounds.
    pub round: usize,
    /// Number of finished measurements in this round.
    pub done: usize,
    /// Number of measurements per round.
    pub of: usize,
    /// Name of the current measurement.
    pub what: &'static str,
}
