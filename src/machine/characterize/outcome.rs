//! How are the samples of the items converted to rows of the record?

use super::buffer::LINE;
use super::figure::Kind;
use super::plan::{Item, POINTS, Placement, StreamKernel, Walk};
use super::sample::Sample;
use super::streaming;
use crate::store::{
    ArithmeticKey, BandwidthKey, Characteristics, LatencyKey, MountainKey, RoofRow, SolverKey,
};

/// Measurements that were not made as planned, with the reason, one sentence each.
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
            "{count} of {} measurements, because time ran out (--budget): {}",
            items.len(),
            kinds.join(", ")
        ));
    }
    said
}

/// Converts samples to rows.
pub fn fill(characteristics: &mut Characteristics, items: &[Item], samples: &[Sample]) {
    for (item, sample) in items.iter().zip(samples) {
        rows(characteristics, item, sample);
    }
    add_roofline(characteristics, items, samples);
}

fn rows(characteristics: &mut Characteristics, item: &Item, sample: &Sample) {
    match item {
        Item::Arithmetic { set, team } => {
            let key = ArithmeticKey {
                isa: set.to_string(),
                threads: team.len() as u64,
            };
            let row = sample.measurement(0, Kind::Rate(1.0), key);
            characteristics.arithmetic.extend(row);
        }
        Item::Streams {
            placement,
            team,
            lines,
        } => {
            streams(characteristics, *placement, team.len(), *lines, sample);
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
            characteristics.bandwidth.extend(row);
        }
        Item::Solver { campaign, teams } => {
            for (i, team) in teams.iter().enumerate() {
                let threads = team.len() as u64;
                let key = SolverKey {
                    kernel: campaign.solver.name().to_owned(),
                    tables: campaign.sharing.name().to_owned(),
                    modes: campaign.modes as u64,
                    points: campaign.points as u64,
                    threads,
                    table_bytes: sample.bytes as u64,
                    efficiency: sample.gain(i) / threads as f64,
                };
                let row = sample.measurement(i, Kind::Rate(1.0), key);
                characteristics.solver.extend(row);
            }
        }
        Item::MemoryMountain { lines, strides, .. } => {
            for (i, stride) in strides.iter().enumerate() {
                let key = MountainKey {
                    size: (lines * LINE) as u64,
                    stride: (stride * LINE) as u64,
                };
                let row = sample.measurement(i, Kind::Rate(LINE as f64), key);
                characteristics.mountain.extend(row);
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
                characteristics.latency.extend(row);
            }
        }
    }
}

fn streams(
    characteristics: &mut Characteristics,
    placement: Placement,
    members: usize,
    lines: usize,
    sample: &Sample,
) {
    for (i, kernel) in StreamKernel::available().into_iter().enumerate() {
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
        characteristics.bandwidth.extend(row);
    }
}

/// Adds the kernels to the roofline, from the counted work and the time of one thread.
fn add_roofline(characteristics: &mut Characteristics, items: &[Item], samples: &[Sample]) {
    for (item, sample) in items.iter().zip(samples) {
        let Item::Solver { campaign, .. } = item else {
            continue;
        };
        if campaign.points != POINTS || campaign.sharing != campaign.solver.usual_sharing() {
            continue;
        }
        let Some(cycles) = sample.figure(0, Kind::Rate(1.0)) else {
            continue;
        };
        let operations = 2.0 * sample.work.numbers;
        characteristics.roofline.push(RoofRow {
            kernel: campaign.solver.name().to_owned(),
            modes: campaign.modes as u64,
            operations,
            bytes_read: 8.0 * sample.work.numbers,
            bytes_distinct: sample.work.distinct,
            intensity: operations / sample.work.distinct,
            rate: operations * cycles.value,
        });
    }
}
