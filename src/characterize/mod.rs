//! What is this machine worth to a campaign? Memory at every level and on every node, arithmetic,
//! and the production kernels on all of it.
//!
//! | file | question |
//! |---|---|
//! | `plan` | what is measured on a machine: a pure decision |
//! | `team`, `figure` | the method: bound threads, best of a round, spread over rounds |
//! | `quiet`, `noise` | waiting for quiet moments; who disturbed |
//! | `description` | what the system says of the machine |
//! | `mountain`, `streaming`, `latency` | memory |
//! | `operators` | dense products and the structured kernel over rotating tables |
//! | `solver`, `tables` | integrating on many threads, and copies of what is integrated with |
//! | `cliffs` | where costs jump, and at which cache |
//! | `measure`, `outcome` | samples from items, figures from samples, the roofline |
//! | `compare`, `machine_rate` | two machines; what a job would take on another one |
//!
//! Everything is repeated in rounds over the whole plan, with memory taken anew: what differs
//! between rounds is what will differ between runs.

mod buffer;
mod cliffs;
pub mod compare;
mod description;
mod drive;
mod figure;
mod latency;
pub mod machine_rate;
mod measure;
mod memory;
mod mountain;
mod noise;
mod operators;
mod outcome;
mod plan;
mod quiet;
mod solver;
mod streaming;
mod tables;
mod team;
mod trouble;
mod vectors;

pub use trouble::Trouble;

use crate::store::{Characteristics, ProgramRecord, timestamp};
use crate::topology::Topology;
use clap::ValueEnum;
use description::Root;
use drive::DefaultDrive;
use noise::Watch;
use outcome::Sample;
use plan::{Item, Limits};
use quiet::{Probe, QuietMachine};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime};
use strum::{IntoStaticStr, VariantArray};
use tables::BuiltTables;
use team::Pace;

/// How much is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
pub enum Extent {
    /// Under a minute.
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
    fn rounds(self) -> usize {
        match self {
            Self::Quick => 3,
            Self::Default => 5,
            Self::Full => 9,
        }
    }

    fn pace(self) -> Pace {
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
    /// Dense products and the structured kernel over rotating tables.
    Operators,
    /// Integrating over threads, modes and kinds of tables.
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

/// This part of the budget may pass with waiting for quiet moments and measuring once more, in
/// every round as much.
const PATIENCE: u32 = 5;

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

/// Measures a machine; nothing where `called_off` was raised meanwhile.
///
/// # Errors
/// The drive that kernels are timed on cannot be assembled.
pub fn characterize(
    topology: &Topology,
    settings: &Settings,
    watch: &mut dyn FnMut(Progress),
    called_off: &AtomicBool,
) -> Result<Option<Characteristics>, Trouble> {
    let started = SystemTime::now();
    let clock = Instant::now();
    let description = description::describe(topology, &Root::of_this_machine());
    let limits = limits(topology, settings, &description);
    let plan = plan::plan(topology, settings.extent, limits);
    let (items, mut missing) = plan.only(&settings.only);
    let (default, mut built_tables) = (DefaultDrive::new()?, BuiltTables::default());
    let threads = (topology.cores.iter()).flat_map(|core| core.threads.clone());
    let noise = Watch::new(threads.collect());
    let probed = default.probed()?;
    let (probe, mut quiet) = (Probe::new(&probed)?, QuietMachine::new(called_off));
    let mut samples: Vec<Sample> = items.iter().map(|_| Sample::default()).collect();
    let pace = settings.extent.pace();
    let most = settings.extent.rounds();
    let rounds = settings.rounds.unwrap_or(most).clamp(1, most);
    for round in 0..rounds {
        quiet.allow(settings.budget / PATIENCE / rounds as u32);
        let begun = clock.elapsed() - quiet.waited();
        for (done, (item, sample)) in items.iter().zip(&mut samples).enumerate() {
            if called_off.load(Ordering::Relaxed) {
                return Ok(None);
            }
            if clock.elapsed() > settings.budget || sample.trouble.is_some() {
                continue;
            }
            let (of, what) = (items.len(), item.kind());
            watch(Progress {
                round,
                done,
                of,
                what,
            });
            sample.take(quiet.measure(&probe, topology, item.seats(), || {
                measure::measure(topology, &default, &mut built_tables, item, pace)
            }));
        }
        // Only whole rounds after the first.
        let taken = clock.elapsed() - quiet.waited() - begun;
        if clock.elapsed() + taken > settings.budget {
            break;
        }
    }
    missing.extend(outcome::troubles(&items, &samples));
    let noise = noise.end(outcome::scatter(&samples), &quiet);
    let mut found = Characteristics {
        format: Characteristics::format(),
        host: host(),
        started: timestamp(started),
        seconds: clock.elapsed().as_secs_f64(),
        extent: settings.extent.name().to_owned(),
        program: ProgramRecord::current(),
        description,
        noise,
        mountain: Vec::new(),
        operators: Vec::new(),
        cliffs: Vec::new(),
        bandwidth: Vec::new(),
        latency: Vec::new(),
        arithmetic: Vec::new(),
        solver: Vec::new(),
        roofline: Vec::new(),
        missing,
    };
    outcome::fill(&mut found, &items, &samples);
    outcome::place_cliffs(&mut found, &topology.caches);
    Ok(Some(found))
}

/// What may be taken.
fn limits(
    topology: &Topology,
    settings: &Settings,
    description: &crate::store::Description,
) -> Limits {
    /// Where the system tells nothing.
    const USUAL: u64 = 1 << 30;
    let free = (description.memory_available.into_iter())
        .chain(description.memory_limit)
        .min()
        .unwrap_or(USUAL);
    let parallelism = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    Limits {
        memory: settings.memory.unwrap_or(free / 4).max(1 << 20),
        processors: parallelism.min(topology.threads()).max(1),
        huge_pages: (description.huge_pages.transparent.as_deref())
            .is_some_and(|given| given != "never"),
    }
}

/// The machine's name.
pub fn host() -> String {
    let named = |path: &str| {
        let text = std::fs::read_to_string(path).ok()?;
        let name: String = (text.trim().chars())
            .map(|c| {
                if c.is_ascii_alphanumeric() || c == '-' {
                    c
                } else {
                    '-'
                }
            })
            .collect();
        (!name.is_empty()).then_some(name)
    };
    named("/proc/sys/kernel/hostname")
        .or_else(|| named("/etc/hostname"))
        .unwrap_or_else(|| "unnamed".to_owned())
}

impl Item {
    /// The part that it belongs to.
    fn part(&self) -> Part {
        match self {
            Self::Arithmetic { .. } => Part::Arithmetic,
            Self::Streams { .. } | Self::Nodes { .. } => Part::Bandwidth,
            Self::Operators { .. } | Self::Points { .. } => Part::Operators,
            Self::Solver { .. } => Part::Solver,
            Self::Mountain { .. } => Part::Mountain,
            Self::Latency { .. } => Part::Latency,
        }
    }

    /// What it measures, in a word or two.
    fn kind(&self) -> &'static str {
        match self {
            Self::Arithmetic { .. } => "arithmetic",
            Self::Streams { .. } => "bandwidth",
            Self::Nodes { .. } => "bandwidth between nodes",
            Self::Operators { .. } => "rotating operators",
            Self::Points { .. } => "rotating points",
            Self::Solver { .. } => "solver scaling",
            Self::Mountain { .. } => "memory mountain",
            Self::Latency { .. } => "latency",
        }
    }
}
