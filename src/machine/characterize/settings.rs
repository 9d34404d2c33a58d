//! What is asked for, and how far it is done.

use super::team::Pace;
use clap::ValueEnum;
use std::time::Duration;
use strum::{IntoStaticStr, VariantArray};

/// How much is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
pub enum Extent {
    /// About a minute.
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

    /// Time that it is meant to take.
    pub fn budget(self) -> Duration {
        Duration::from_secs(match self {
            Self::Quick => 55,
            Self::Default => 240,
            Self::Full => 2400,
        })
    }

    /// Rounds at most.
    pub fn rounds(self) -> usize {
        match self {
            Self::Quick => 3,
            Self::Default => 5,
            Self::Full => 9,
        }
    }

    /// How long something is repeated in a round.
    pub fn pace(self) -> Pace {
        let (slice, least) = match self {
            Self::Quick => (6, 3),
            Self::Default => (15, 5),
            Self::Full => (40, 7),
        };
        Pace {
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
    /// Read, copy and triad over threads, and from node to node.
    Bandwidth,
    /// Integrating over modes, operating points, threads and copies of tables.
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

/// What is asked for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Settings {
    /// How much is measured.
    pub extent: Extent,
    /// Time after which nothing new is begun.
    pub budget: Duration,
    /// Only these parts; all where none is named.
    pub only: Vec<Part>,
    /// Rounds at most, where fewer than usual are wanted.
    pub rounds: Option<usize>,
    /// Most memory to take \[bytes\]; else a quarter of what is free, or granted by a control
    /// group.
    pub memory: Option<u64>,
}

/// How far the measurements are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Rounds done.
    pub round: usize,
    /// Measurements done in this round.
    pub done: usize,
    /// Measurements of a round.
    pub of: usize,
    /// What is being measured.
    pub what: &'static str,
}
