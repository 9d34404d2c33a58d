//! What is measured of memory beside bandwidth and latency alone: mixes of reads and writes, chains
//! at once, percentiles, latency under load, and lines that go from core to core.

use super::item::{Item, Placement, Walk};
use super::places::{core_pairs, order};
use super::{LINE, Limits, Missing, PAGE, Scale, array_lines};
use crate::characterize::settings::Part;
use crate::characterize::team::HardwareThread;
use crate::topology::Topology;

/// Cores between which all pairs are measured; of more, so many are chosen.
const MOST_CORES: usize = 16;

/// Mixes on one thread and on as many as there are.
pub fn mixes(
    items: &mut Vec<Item>,
    topology: &Topology,
    teams: &[Vec<HardwareThread>],
    scale: &Scale,
    limits: Limits,
) {
    let mut chosen: Vec<_> = teams.first().into_iter().chain(teams.last()).collect();
    chosen.dedup();
    items.extend(chosen.into_iter().map(|team| Item::Mixes {
        team: team.clone(),
        lines: array_lines(topology, team, 3, scale, limits).0,
    }));
}

/// Chains at once and percentiles at every level of memory.
pub fn chases(
    items: &mut Vec<Item>,
    topology: &Topology,
    thread: HardwareThread,
    largest: u64,
    limits: Limits,
) {
    let sizes = level_sizes(topology, largest);
    let walk = walk(limits);
    items.push(Item::Parallel {
        thread,
        sizes: sizes.clone(),
        walk,
    });
    items.push(Item::Percentiles {
        thread,
        sizes,
        walk,
    });
}

/// Huge pages where there are any, so that it is the load that is timed and not the search for its
/// page.
fn walk(limits: Limits) -> Walk {
    match limits.huge_pages {
        true => Walk::HopsHuge,
        false => Walk::Hops,
    }
}

/// Lines of a buffer that lies well inside of every level of memory: half of the first cache, the
/// geometric middle of each later one and the one before it, and the largest.
fn level_sizes(topology: &Topology, largest: u64) -> Vec<usize> {
    let mut before = None;
    let caches = topology.caches.iter().map(|cache| {
        let size = cache.size as f64;
        match before.replace(size) {
            None => 0.5 * size,
            Some(smaller) => (smaller * size).sqrt(),
        }
    });
    let mut lines: Vec<usize> = (caches.collect::<Vec<f64>>().into_iter())
        .map(|size| size as u64)
        .filter(|size| *size < largest)
        .chain([largest])
        .map(|size| (size as usize / LINE / PAGE).max(1) * PAGE)
        .collect();
    lines.dedup();
    lines
}

/// One core follows a chain, all others read; the second thread of a core only where there is no
/// other.
pub fn loaded(
    items: &mut Vec<Item>,
    missing: &mut Vec<Missing>,
    topology: &Topology,
    largest: u64,
    scale: &Scale,
    limits: Limits,
) {
    let mut team = order(topology, Placement::Compact);
    team.truncate(topology.cores.len().max(2).min(limits.processors));
    if team.len() < 2 {
        missing.push(Missing {
            of: &[Part::Loaded],
            said: "latency under load: there is one thread, and nobody to load it".to_owned(),
        });
        return;
    }
    let (array, _) = array_lines(topology, &team, 2, scale, limits);
    items.push(Item::Loaded {
        team,
        lines: (largest.min(limits.memory / 2) as usize / LINE / PAGE).max(1) * PAGE,
        array,
        walk: walk(limits),
        pauses: scale.pauses.to_vec(),
    });
}

/// Pairs of cores, and of the threads of each core.
pub fn transfers(
    items: &mut Vec<Item>,
    missing: &mut Vec<Missing>,
    topology: &Topology,
    limits: Limits,
) {
    if topology.threads().min(limits.processors) < 2 {
        missing.push(Missing {
            of: &[Part::Transfer],
            said: "a line handed from core to core: there is one thread".to_owned(),
        });
        return;
    }
    let cores = chosen_cores(topology.cores.len());
    if cores.len() < topology.cores.len() {
        missing.push(Missing {
            of: &[Part::Transfer],
            said: format!(
                "a line handed between all {} cores: {} were chosen, neighbours in twos from all \
                 over the machine",
                topology.cores.len(),
                cores.len()
            ),
        });
    }
    let transfers = core_pairs(topology, &cores).into_iter();
    items.extend(transfers.map(|(pair, relation)| Item::Transfer { pair, relation }));
}

/// All of few cores; of many, neighbours in twos, evenly spread, so that near and far pairs are
/// among them.
fn chosen_cores(count: usize) -> Vec<usize> {
    const TWOS: usize = MOST_CORES / 2;
    match count {
        0..=MOST_CORES => (0..count).collect(),
        _ => (0..TWOS)
            .map(|i| i * (count - 2) / (TWOS - 1))
            .flat_map(|first| [first, first + 1])
            .collect(),
    }
}
