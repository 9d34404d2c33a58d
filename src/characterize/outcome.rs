//! From items to samples, from samples to rows.

use super::buffer::LINE;
use super::cliffs::{self, Jump};
use super::figure::{Kind, figure, median};
use super::measure::Measured;
use super::plan::{Item, Mesh, Seat, Sharing, StreamKernel, Walk};
use super::solver::Work;
use super::trouble::Trouble;
use super::{operators, streaming};
use crate::store::{
    ArithmeticRow, BandwidthRow, Characteristics, Cliff, Figure, LatencyRow, MountainRow,
    OperatorRow, RoofRow, SolverRow,
};
use crate::topology::Cache;

/// What all rounds of an item gave.
#[derive(Debug, Default)]
pub struct Sample {
    /// Times of a unit of work, by figure and round \[s\].
    figures: Vec<Vec<Vec<f64>>>,
    bytes: usize,
    work: Work,
    unbound: Option<String>,
    /// Why there is nothing more.
    pub trouble: Option<Trouble>,
}

impl Sample {
    /// Takes up one more round, of one measurement or several.
    pub fn take(&mut self, round: Result<Vec<Measured>, Trouble>) {
        let measured = match round {
            Err(trouble) => {
                self.trouble = Some(trouble);
                return;
            }
            Ok(measured) => measured,
        };
        for (i, measured) in measured.into_iter().enumerate() {
            self.figures.resize(measured.times.len(), Vec::new());
            for (rounds, times) in self.figures.iter_mut().zip(measured.times) {
                match rounds.last_mut().filter(|_| i > 0) {
                    Some(round) => round.extend(times),
                    None => rounds.push(times),
                }
            }
            self.bytes = measured.bytes;
            self.work = measured.work;
            self.unbound = self.unbound.take().or(measured.unbound);
        }
    }

    fn figure(&self, index: usize, kind: Kind) -> Option<Figure> {
        figure(self.figures.get(index)?, kind)
    }
}

/// How far the median repetition lies behind the best, in the middle of all rounds.
pub fn scatter(samples: &[Sample]) -> Option<f64> {
    let mut behind: Vec<f64> = (samples.iter())
        .flat_map(|sample| sample.figures.iter().flatten())
        .filter(|times| times.len() > 1)
        .map(|times| {
            let best = times.iter().copied().fold(f64::INFINITY, f64::min);
            median(&mut times.clone()) / best - 1.0
        })
        .collect();
    (!behind.is_empty()).then(|| median(&mut behind))
}

/// What went wrong, a sentence each.
pub fn troubles(items: &[Item], samples: &[Sample]) -> Vec<String> {
    let mut said: Vec<String> = Vec::new();
    let mut say = |sentence: String| {
        if !said.contains(&sentence) {
            said.push(sentence);
        }
    };
    for (item, sample) in items.iter().zip(samples) {
        if let Some(trouble) = &sample.trouble {
            say(format!("{}: {trouble}", item.kind()));
        }
        if let Some(detail) = &sample.unbound {
            say(format!("threads bound to cores: {detail}"));
        }
    }
    let skipped = (items.iter().zip(samples))
        .filter(|(_, sample)| sample.figures.is_empty() && sample.trouble.is_none());
    let mut kinds: Vec<&str> = skipped.map(|(item, _)| item.kind()).collect();
    if !kinds.is_empty() {
        let count = kinds.len();
        kinds.dedup();
        say(format!(
            "{count} of {} measurements, for lack of time (--budget): {}",
            items.len(),
            kinds.join(", ")
        ));
    }
    said
}

/// Turns samples into rows.
pub fn fill(found: &mut Characteristics, items: &[Item], samples: &[Sample]) {
    for (item, sample) in items.iter().zip(samples) {
        rows(found, item, sample);
    }
    roof(found, items, samples);
}

fn rows(found: &mut Characteristics, item: &Item, sample: &Sample) {
    let first_node = |team: &[Seat]| team.first().map(|seat| seat.node);
    match item {
        Item::Arithmetic { set, team } => {
            let rate = sample.figure(0, Kind::Rate(1.0));
            found.arithmetic.extend(rate.map(|rate| ArithmeticRow {
                isa: set.to_string(),
                threads: team.len() as u64,
                rate,
            }));
        }
        Item::Streams {
            placement,
            team,
            lines,
        } => {
            for (i, kernel) in StreamKernel::available().into_iter().enumerate() {
                let bytes = streaming::bytes(kernel, team.len(), *lines);
                let bandwidth = sample.figure(i, Kind::Rate(bytes as f64));
                found
                    .bandwidth
                    .extend(bandwidth.map(|bandwidth| BandwidthRow {
                        kernel: kernel.name().to_owned(),
                        placement: placement.name().to_owned(),
                        threads: team.len() as u64,
                        cpu_node: None,
                        memory_node: None,
                        array: (team.len() * lines * LINE) as u64,
                        bytes,
                        bandwidth,
                    }));
            }
        }
        Item::Nodes {
            team,
            memory,
            lines,
        } => {
            let bytes = streaming::bytes(StreamKernel::Read, team.len(), *lines);
            let bandwidth = sample.figure(0, Kind::Rate(bytes as f64));
            found
                .bandwidth
                .extend(bandwidth.map(|bandwidth| BandwidthRow {
                    kernel: StreamKernel::Read.name().to_owned(),
                    placement: "nodes".to_owned(),
                    threads: team.len() as u64,
                    cpu_node: first_node(team),
                    memory_node: Some(*memory),
                    array: bytes,
                    bytes,
                    bandwidth,
                }));
        }
        Item::Operators {
            dimension, counts, ..
        } => rotating(found, "matvec", *dimension, counts, sample),
        Item::Points { mesh, counts, .. } => {
            let kernel = match mesh {
                Mesh::TwoLevels => "volterra",
                Mesh::SixtyLevels => "volterra, 60 levels",
            };
            rotating(found, kernel, 2 * operators::MODES + 1, counts, sample);
        }
        Item::Solver {
            solver,
            sharing,
            modes,
            teams,
        } => {
            let alone = sample.figure(0, Kind::Rate(1.0));
            for (i, team) in teams.iter().enumerate() {
                let rate = sample.figure(i, Kind::Rate(1.0));
                let ideal = alone.map(|alone| alone.value * team.len() as f64);
                found.solver.extend(rate.map(|rate| SolverRow {
                    kernel: solver.name().to_owned(),
                    tables: sharing.name().to_owned(),
                    modes: *modes as u64,
                    threads: team.len() as u64,
                    table_bytes: sample.bytes as u64,
                    efficiency: ideal.map(|ideal| rate.value / ideal),
                    rate,
                }));
            }
        }
        Item::Mountain { lines, strides, .. } => {
            for (i, stride) in strides.iter().enumerate() {
                let bandwidth = sample.figure(i, Kind::Rate(LINE as f64));
                found
                    .mountain
                    .extend(bandwidth.map(|bandwidth| MountainRow {
                        size: (lines * LINE) as u64,
                        stride: (stride * LINE) as u64,
                        bandwidth,
                    }));
            }
        }
        Item::Latency {
            seat,
            memory,
            sizes,
            walk,
        } => {
            for (i, lines) in sizes.iter().enumerate() {
                let latency = sample.figure(i, Kind::Time(1.0));
                found.latency.extend(latency.map(|latency| LatencyRow {
                    size: (lines * LINE) as u64,
                    order: walk.name().to_owned(),
                    huge_pages: *walk == Walk::HopsHuge,
                    cpu_node: seat.node,
                    memory_node: *memory,
                    latency,
                }));
            }
        }
    }
}

fn rotating(
    found: &mut Characteristics,
    kernel: &str,
    dimension: usize,
    counts: &[usize],
    sample: &Sample,
) {
    for (i, count) in counts.iter().enumerate() {
        let time = sample.figure(i, Kind::Time(1.0));
        found.operators.extend(time.map(|time| OperatorRow {
            kernel: kernel.to_owned(),
            dimension: dimension as u64,
            count: *count as u64,
            working_set: (count * sample.bytes) as u64,
            time,
        }));
    }
}

/// Places the kernels under the roof, from counted work and the time of one thread.
fn roof(found: &mut Characteristics, items: &[Item], samples: &[Sample]) {
    for (item, sample) in items.iter().zip(samples) {
        let Item::Solver {
            solver,
            sharing: Sharing::Shared,
            modes,
            ..
        } = item
        else {
            continue;
        };
        let Some(cycles) = sample.figure(0, Kind::Rate(1.0)) else {
            continue;
        };
        let operations = 2.0 * sample.work.numbers;
        found.roofline.push(RoofRow {
            kernel: solver.name().to_owned(),
            modes: *modes as u64,
            operations,
            bytes_read: 8.0 * sample.work.numbers,
            bytes_distinct: sample.work.distinct,
            intensity: operations / sample.work.distinct,
            rate: operations * cycles.value,
        });
    }
}

/// Finds the cliffs of all curves over the working set, of best figures, lest a disturbance pass
/// for one, and says of which reported cache none was seen.
pub fn place_cliffs(found: &mut Characteristics, caches: &[Cache]) {
    let mut curves: Vec<(String, Vec<[f64; 2]>)> = Vec::new();
    let mut add =
        |of: String, place: [f64; 2]| match curves.iter_mut().find(|(known, _)| *known == of) {
            Some((_, curve)) => curve.push(place),
            None => curves.push((of, vec![place])),
        };
    for row in &found.operators {
        let of = format!("{} of dimension {}", row.kernel, row.dimension);
        add(of, [row.working_set as f64, row.time.best]);
    }
    for row in found
        .mountain
        .iter()
        .filter(|row| row.stride == LINE as u64)
    {
        add(
            "reading line after line".to_owned(),
            [row.size as f64, 1.0 / row.bandwidth.best],
        );
    }
    let local = |row: &&LatencyRow| row.order == "pages" && row.cpu_node == row.memory_node;
    for row in found.latency.iter().filter(local) {
        let of = format!("latency on node {}", row.cpu_node);
        add(of, [row.size as f64, row.latency.best]);
    }
    let cliff = |of: &str, jump: Jump| Cliff {
        of: of.to_owned(),
        size: jump.size,
        from: jump.between[0],
        to: jump.between[1],
        ratio: jump.ratio,
        cache: cliffs::cache_of(&jump, caches),
    };
    for (of, curve) in &curves {
        let jumps = cliffs::jumps(curve);
        found
            .cliffs
            .extend(jumps.into_iter().map(|jump| cliff(of, jump)));
    }
    let largest = curves
        .iter()
        .flat_map(|(_, curve)| curve)
        .map(|place| place[0]);
    let largest = largest.fold(0.0, f64::max);
    for cache in caches {
        let seen = found
            .cliffs
            .iter()
            .any(|cliff| cliff.cache == Some(cache.level));
        if seen || largest == 0.0 {
            continue;
        }
        let reason = match (
            largest < 2.0 * cache.size as f64,
            &found.description.hypervisor,
        ) {
            (true, _) => "working sets end too early",
            (false, Some(_)) => "the machine is virtual, and the cache may be shared with others",
            (false, None) => "costs climb elsewhere, or not at once",
        };
        found.missing.push(format!(
            "a cliff within a factor of two of the reported L{} cache ({} KiB): {reason}",
            cache.level,
            cache.size >> 10
        ));
    }
}
