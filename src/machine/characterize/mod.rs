//! What is this machine worth to a campaign? Memory at every level and on every node, arithmetic,
//! and the production kernels on all of it.
//!
//! | file | question |
//! |---|---|
//! | `settings`, `plan` | what is asked for; what is measured on a machine: a pure decision |
//! | `team`, `figure` | the method: bound threads, best of a round, spread over rounds |
//! | `quiet`, `noise` | waiting for quiet moments; who disturbed |
//! | `description` | what the system says of the machine |
//! | `mountain`, `streaming` | memory by size and stride, by reads and writes |
//! | `chain`, `latency`, `chases`, `loaded` | loads that wait for each other: alone, several at once, beside readers |
//! | `transfer` | lines from core to core |
//! | `operators` | dense products and the structured kernel over rotating tables |
//! | `measured`, `sample` | what one measurement gives, what repeated rounds gave |
//! | `solver`, `tables` | integrating on many threads, and copies of what is integrated with |
//! | `cliffs` | where costs jump, and at which cache |
//! | `measure`, `measured`, `outcome`, `memory_rows` | samples from items, figures from samples, the roofline |
//! | `compare`, `machine_rate` | two machines; what a job would take on another one |
//!
//! Everything is repeated in rounds over the whole plan, with memory taken anew: what differs
//! between rounds is what will differ between runs.

mod buffer;
mod chain;
mod chases;
mod cliffs;
pub mod compare;
mod description;
mod drive;
mod error;
mod figure;
mod latency;
mod loaded;
pub mod machine_rate;
mod measure;
mod measured;
mod memory;
mod memory_rows;
mod mountain;
mod noise;
mod operators;
mod outcome;
mod plan;
mod quiet;
mod sample;
mod settings;
mod solver;
mod streaming;
mod tables;
mod team;
mod transfer;
mod vectors;

pub use error::MeasurementError;
pub use settings::{Extent, Part, Progress, Settings};

use crate::store::{Characteristics, ProgramRecord, timestamp};
use crate::topology::Topology;
use description::Root;
use drive::DefaultDrive;
use noise::Watch;
use plan::Limits;
use quiet::{Probe, QuietMachine};
use sample::Sample;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Instant, SystemTime};
use tables::BuiltTables;

/// This part of the budget may pass with waiting for quiet moments and measuring once more, in
/// every round as much.
const PATIENCE: u32 = 5;

/// Measures a machine; nothing where `called_off` was raised meanwhile.
///
/// # Errors
/// The drive that kernels are timed on cannot be assembled.
pub fn characterize(
    topology: &Topology,
    settings: &Settings,
    watch: &mut dyn FnMut(Progress),
    called_off: &AtomicBool,
) -> Result<Option<Characteristics>, MeasurementError> {
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
            if clock.elapsed() > settings.budget || sample.error.is_some() {
                continue;
            }
            let (of, what) = (items.len(), item.kind());
            watch(Progress {
                round,
                done,
                of,
                what,
            });
            sample.take(quiet.measure(&probe, topology, item.threads(), || {
                measure::measure(topology, &default, &mut built_tables, item, pace)
            }));
        }
        // Only whole rounds after the first.
        let taken = clock.elapsed() - quiet.waited() - begun;
        if clock.elapsed() + taken > settings.budget {
            break;
        }
    }
    missing.extend(outcome::missing(&items, &samples));
    let noise = noise.end(sample::scatter(&samples), &quiet);
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
        loaded: Vec::new(),
        percentiles: Vec::new(),
        parallel: Vec::new(),
        transfer: Vec::new(),
        arithmetic: Vec::new(),
        solver: Vec::new(),
        gain: Vec::new(),
        roofline: Vec::new(),
        missing,
    };
    outcome::fill(&mut found, &items, &samples);
    outcome::find_cliffs(&mut found, &topology.caches);
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
