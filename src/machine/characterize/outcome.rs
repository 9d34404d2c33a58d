//! From items to samples, from samples to rows.

use super::buffer::LINE;
use super::cliffs::cliffs;
use super::figure::Kind;
use super::plan::{Item, Mesh, Placement, Sharing, StreamKernel, Walk};
use super::sample::Sample;
use super::{memory_rows, operators, streaming};
use crate::store::{
    ArithmeticKey, BandwidthKey, Characteristics, GainKey, LatencyKey, Measurement, MountainKey,
    OperatorKey, RoofRow, SolverKey,
};
use crate::topology::Cache;

/// What was not measured as planned, and why, a sentence each.
pub fn missing(items: &[Item], samples: &[Sample]) -> Vec<String> {
    let mut said: Vec<String> = Vec::new();
    let mut say = |sentence: String| {
        if !said.contains(&sentence) {
            said.push(sentence);
        }
    };
    for (item, sample) in items.iter().zip(samples) {
        if let Some(error) = &sample.error {
            say(format!("{}: {error}", item.kind()));
        }
        if let Some(detail) = &sample.unbound {
            say(format!("threads bound to cores: {detail}"));
        }
    }
    let skipped = (items.iter().zip(samples))
        .filter(|(_, sample)| sample.figures.is_empty() && sample.error.is_none());
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
    match item {
        Item::Arithmetic { set, team } => {
            let key = ArithmeticKey {
                isa: set.to_string(),
                threads: team.len() as u64,
            };
            let row = sample.measurement(0, Kind::Rate(1.0), key);
            found.arithmetic.extend(row);
        }
        Item::Streams {
            placement,
            team,
            lines,
        } => {
            let kernels = StreamKernel::available();
            streams(found, &kernels, *placement, team.len(), *lines, sample);
        }
        Item::Mixes { team, lines } => {
            let (kernels, placement) = (StreamKernel::mixes(), Placement::Compact);
            streams(found, &kernels, placement, team.len(), *lines, sample);
        }
        Item::Nodes {
            team,
            memory,
            lines,
        } => {
            let bytes = streaming::bytes(StreamKernel::Read, team.len(), *lines);
            let key = BandwidthKey {
                kernel: StreamKernel::Read.name().to_owned(),
                placement: "nodes".to_owned(),
                threads: team.len() as u64,
                cpu_node: team.first().map(|thread| thread.node),
                memory_node: Some(*memory),
                array: bytes,
                bytes,
            };
            let row = sample.measurement(0, Kind::Rate(bytes as f64), key);
            found.bandwidth.extend(row);
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
            for (i, team) in teams.iter().enumerate() {
                let rate = sample.figure(i, Kind::Rate(1.0));
                let threads = team.len() as u64;
                let gain_key = GainKey {
                    kernel: solver.name().to_owned(),
                    tables: sharing.name().to_owned(),
                    modes: *modes as u64,
                    threads,
                };
                // Ratios come after the rates, from the second team on.
                let gain = match i {
                    0 => None,
                    _ => sample.measurement(teams.len() + i - 1, Kind::Middle, gain_key),
                };
                let gained = gain.as_ref().map_or(1.0, |gain| gain.figure.value);
                found.gain.extend(gain);
                let key = SolverKey {
                    kernel: solver.name().to_owned(),
                    tables: sharing.name().to_owned(),
                    modes: *modes as u64,
                    threads,
                    table_bytes: sample.bytes as u64,
                    efficiency: Some(gained / threads as f64),
                };
                let row = rate.map(|figure| Measurement { key, figure });
                found.solver.extend(row);
            }
        }
        Item::Mountain { lines, strides, .. } => {
            for (i, stride) in strides.iter().enumerate() {
                let key = MountainKey {
                    size: (lines * LINE) as u64,
                    stride: (stride * LINE) as u64,
                };
                let row = sample.measurement(i, Kind::Rate(LINE as f64), key);
                found.mountain.extend(row);
            }
        }
        Item::Latency {
            thread,
            memory,
            sizes,
            walk,
        } => {
            for (i, lines) in sizes.iter().enumerate() {
                let key = LatencyKey {
                    size: (lines * LINE) as u64,
                    order: walk.name().to_owned(),
                    huge_pages: *walk == Walk::HopsHuge,
                    cpu_node: thread.node,
                    memory_node: *memory,
                };
                let row = sample.measurement(i, Kind::Time(1.0), key);
                found.latency.extend(row);
            }
        }
        Item::Parallel { sizes, walk, .. } => memory_rows::parallel(found, sizes, *walk, sample),
        Item::Percentiles { sizes, walk, .. } => {
            memory_rows::percentiles(found, sizes, *walk, sample);
        }
        Item::Loaded {
            team,
            lines,
            walk,
            pauses,
            ..
        } => memory_rows::loaded(found, team, *lines, *walk, pauses, sample),
        Item::Transfer { pair, relation } => {
            memory_rows::transfer(found, pair, *relation, sample);
        }
    }
}

fn streams(
    found: &mut Characteristics,
    kernels: &[StreamKernel],
    placement: Placement,
    members: usize,
    lines: usize,
    sample: &Sample,
) {
    for (i, &kernel) in kernels.iter().enumerate() {
        let key = BandwidthKey {
            kernel: kernel.name().to_owned(),
            placement: placement.name().to_owned(),
            threads: members as u64,
            cpu_node: None,
            memory_node: None,
            array: (members * lines * LINE) as u64,
            bytes: streaming::bytes(kernel, members, lines),
        };
        let row = sample.measurement(i, Kind::Rate(key.bytes as f64), key);
        found.bandwidth.extend(row);
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
        let key = OperatorKey {
            kernel: kernel.to_owned(),
            dimension: dimension as u64,
            count: *count as u64,
            working_set: (count * sample.bytes) as u64,
        };
        let row = sample.measurement(i, Kind::Time(1.0), key);
        found.operators.extend(row);
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
pub fn find_cliffs(found: &mut Characteristics, caches: &[Cache]) {
    let mut curves: Vec<(String, Vec<[f64; 2]>)> = Vec::new();
    let mut add =
        |of: String, place: [f64; 2]| match curves.iter_mut().find(|(known, _)| *known == of) {
            Some((_, curve)) => curve.push(place),
            None => curves.push((of, vec![place])),
        };
    for row in &found.operators {
        let of = format!("{} of dimension {}", row.key.kernel, row.key.dimension);
        add(of, [row.key.working_set as f64, row.figure.best]);
    }
    for row in (found.mountain.iter()).filter(|row| row.key.stride == LINE as u64) {
        let of = "reading line after line".to_owned();
        add(of, [row.key.size as f64, 1.0 / row.figure.best]);
    }
    for Measurement { key, figure } in &found.latency {
        if key.order == "pages" && key.cpu_node == key.memory_node {
            let of = format!("latency on node {}", key.cpu_node);
            add(of, [key.size as f64, figure.best]);
        }
    }
    let of_curves = (curves.iter()).flat_map(|(of, curve)| cliffs(of, curve, caches));
    found.cliffs.extend(of_curves);
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
