//! Where does memory limit the number of modes, operating points and threads on this machine? It measures
//! memory at every level and on every node, arithmetic, and the kernels that integrate.
//!
//! | file | question |
//! |---|---|
//! | `settings`, `plan` | the request; the measurements on a machine: a pure decision |
//! | `team`, `figure` | the method: bound threads, best of a round, spread over rounds |
//! | `noise` | load by others on the machine |
//! | `description` | the system's description of the machine |
//! | `mountain`, `streaming` | memory by size and stride, by reads and writes |
//! | `chain`, `latency` | loads that wait for each other |
//! | `drive`, `solver` | integrating: modes, operating points, threads, copies of tables |
//! | `measure`, `measured`, `sample`, `outcome` | measurements from items, samples from rounds, rows from samples |
//! | `compare` | two runs, two machines |
//!
//! All measurements are repeated in rounds over the whole plan, with new memory in each round. The
//! differences between rounds are then like those between runs.

mod buffer;
mod chain;
pub mod compare;
mod description;
mod drive;
mod error;
mod figure;
mod latency;
mod measure;
mod measured;
mod memory;
mod mountain;
mod noise;
mod outcome;
mod plan;
mod sample;
mod settings;
mod solver;
mod streaming;
mod team;
mod vectors;

pub use error::MeasurementError;
pub use settings::{Extent, Part, Progress, Settings};

use crate::store::{Characteristics, ProgramRecord, timestamp};
use crate::topology::Topology;
use description::Root;
use drive::DefaultDrive;
use noise::NoiseMonitor;
use plan::Limits;
use sample::Sample;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Instant, SystemTime};

/// Measures a machine. The result is `None` if `interrupt` is set during the measurements.
///
/// # Errors
/// The drive for timing kernels cannot be assembled.
pub fn characterize(
    topology: &Topology,
    settings: &Settings,
    watch: &mut dyn FnMut(Progress),
    interrupt: &AtomicBool,
) -> Result<Option<Characteristics>, MeasurementError> {
    let started = SystemTime::now();
    let clock = Instant::now();
    let description = description::describe(topology, &Root::of_this_machine());
    let limits = limits(topology, settings, &description);
    let plan = plan::plan(topology, settings.extent, limits);
    let (items, mut missing) = plan.only(&settings.only);
    let default = DefaultDrive::new()?;
    let threads = (topology.cores.iter()).flat_map(|core| core.threads.clone());
    let noise = NoiseMonitor::new(threads.collect());
    let mut samples: Vec<Sample> = items.iter().map(|_| Sample::default()).collect();
    let pace = settings.extent.pace();
    let most = settings.extent.rounds();
    let rounds = settings.rounds.unwrap_or(most).clamp(1, most);
    for round in 0..rounds {
        let begun = clock.elapsed();
        for (done, (item, sample)) in items.iter().zip(&mut samples).enumerate() {
            if interrupt.load(Ordering::Relaxed) {
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
            sample.take(measure::measure(topology, &default, item, pace));
        }
        // After the first round, begin only rounds that fit.
        if 2 * clock.elapsed() > settings.budget + begun {
            break;
        }
    }
    missing.extend(outcome::missing(&items, &samples));
    let noise = noise.end(sample::scatter(&samples));
    let mut characteristics = Characteristics {
        format: Characteristics::format(),
        host: host(),
        started: timestamp(started),
        seconds: clock.elapsed().as_secs_f64(),
        extent: settings.extent.name().to_owned(),
        program: ProgramRecord::current(),
        description,
        noise,
        mountain: Vec::new(),
        bandwidth: Vec::new(),
        latency: Vec::new(),
        arithmetic: Vec::new(),
        solver: Vec::new(),
        roofline: Vec::new(),
        missing,
    };
    outcome::fill(&mut characteristics, &items, &samples);
    Ok(Some(characteristics))
}

/// Limits of resources.
fn limits(
    topology: &Topology,
    settings: &Settings,
    description: &crate::store::Description,
) -> Limits {
    /// Memory \[bytes\] that counts as free if the system reports none.
    const DEFAULT_MEMORY: u64 = 1 << 30;
    let free = (description.memory_available.into_iter())
        .chain(description.memory_limit)
        .min()
        .unwrap_or(DEFAULT_MEMORY);
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
            .map(
                |c| {
                    if c.is_ascii_alphanumeric() || c == '-' { c } else { '-' }
                },
            )
            .collect();
        (!name.is_empty()).then_some(name)
    };
    named("/proc/sys/kernel/hostname")
        .or_else(|| named("/etc/hostname"))
        .unwrap_or_else(|| "unnamed".to_owned())
}
