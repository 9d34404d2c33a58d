//! Rows of the further measurements of memory, from the samples of their items.

use super::buffer::LINE;
use super::chases::{BATCH, CHAINS, PERCENTILES};
use super::figure::Kind;
use super::plan::{Relation, Walk};
use super::sample::Sample;
use super::team::HardwareThread;
use crate::store::{
    Characteristics, LoadedKey, Measurement, ParallelKey, PercentileKey, TransferKey,
};

/// Chains at once.
pub fn parallel(found: &mut Characteristics, sizes: &[usize], walk: Walk, sample: &Sample) {
    let keys = sizes.iter().flat_map(|lines| {
        CHAINS.map(|chains| ParallelKey {
            size: (lines * LINE) as u64,
            huge_pages: walk == Walk::HopsHuge,
            chains: chains as u64,
        })
    });
    let rows = keys.enumerate();
    let rows = rows.filter_map(|(i, key)| sample.measurement(i, Kind::Rate(1.0), key));
    found.parallel.extend(rows);
}

/// Percentiles; the figure after the last one is the clock's.
pub fn percentiles(found: &mut Characteristics, sizes: &[usize], walk: Walk, sample: &Sample) {
    let last = sizes.len() * PERCENTILES.len();
    let Some(clock) = sample.figure(last, Kind::Middle) else {
        return;
    };
    let keys = sizes.iter().flat_map(|lines| {
        PERCENTILES.map(|percentile| PercentileKey {
            size: (lines * LINE) as u64,
            huge_pages: walk == Walk::HopsHuge,
            percentile,
            batch: BATCH as u64,
            clock: clock.value,
        })
    });
    let rows = keys.enumerate();
    let rows = rows.filter_map(|(i, key)| sample.measurement(i, Kind::Middle, key));
    found.percentiles.extend(rows);
}

/// Two figures a pause: the time of a load, and of a byte that others read.
pub fn loaded(
    found: &mut Characteristics,
    team: &[HardwareThread],
    lines: usize,
    walk: Walk,
    pauses: &[Option<u32>],
    sample: &Sample,
) {
    for (i, &pause) in pauses.iter().enumerate() {
        let bandwidth = sample.figure(2 * i + 1, Kind::MiddleRate(1.0));
        let key = LoadedKey {
            size: (lines * LINE) as u64,
            huge_pages: walk == Walk::HopsHuge,
            threads: team.len() as u64 - 1,
            pause,
            bandwidth: bandwidth.map_or(0.0, |figure| figure.value),
        };
        let row = sample.measurement(2 * i, Kind::Middle, key);
        found.loaded.extend(row);
    }
}

/// One figure.
pub fn transfer(
    found: &mut Characteristics,
    pair: &[HardwareThread; 2],
    relation: Relation,
    sample: &Sample,
) {
    let key = TransferKey {
        a: pair[0].index,
        b: pair[1].index,
        share: relation.name().to_owned(),
    };
    let row: Option<Measurement<TransferKey>> = sample.measurement(0, Kind::Middle, key);
    found.transfer.extend(row);
}
