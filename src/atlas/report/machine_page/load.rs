//! Memory under load, spread of its latency, chains at once, mixes, and lines from core to core.

use super::words::{rate_text, seconds, three_digits, time_text};
use crate::report::numbers::plural;
use crate::report::size_text;
use crate::store::{Characteristics, Measurement, TransferKey};
use std::fmt::Write;

/// Percentiles and chains at once, a line a size.
pub fn chases(page: &mut String, machine: &Characteristics) {
    let mut sizes: Vec<u64> = (machine.percentiles.iter().map(|row| row.key.size))
        .chain(machine.parallel.iter().map(|row| row.key.size))
        .collect();
    sizes.sort_unstable();
    sizes.dedup();
    if sizes.is_empty() {
        return;
    }
    let pages = match machine.percentiles.iter().any(|row| row.key.huge_pages) {
        true => " on huge pages",
        false => "",
    };
    _ = writeln!(
        page,
        "\na load{pages}: p50, p90, p99, p99.9 of batches; loads a ns of 1, 2, 4 … chains at once"
    );
    for size in sizes {
        let percentiles = machine
            .percentiles
            .iter()
            .filter(|row| row.key.size == size);
        let times: Vec<String> = percentiles.map(|row| time_text(&row.figure)).collect();
        let chains = machine.parallel.iter().filter(|row| row.key.size == size);
        let rates: Vec<String> = (chains.map(|row| 1e-9 * row.figure.value))
            .map(|rate| format!("{rate:.3}"))
            .collect();
        _ = writeln!(
            page,
            "  {:<10} {:<36} {}",
            size_text(size),
            times.join(", "),
            rates.join(" ")
        );
    }
    if let Some(row) = machine.percentiles.first() {
        _ = writeln!(
            page,
            "  batches of {} loads, less {} of looking at the clock",
            row.key.batch,
            seconds(row.key.clock)
        );
    }
}

/// Latency over bandwidth.
pub fn loaded(page: &mut String, machine: &Characteristics) {
    let Some(first) = machine.loaded.first() else {
        return;
    };
    _ = writeln!(
        page,
        "\na load from {} while {}",
        size_text(first.key.size),
        match first.key.threads {
            1 => "another thread reads".to_owned(),
            threads => format!("{} read", plural(threads as usize, "other thread")),
        }
    );
    for row in &machine.loaded {
        let read = match row.key.pause {
            None => "nothing".to_owned(),
            Some(_) => format!("{} GB/s", three_digits(1e-9 * row.key.bandwidth)),
        };
        _ = writeln!(page, "  {read:<12} {}", time_text(&row.figure));
    }
}

/// Medians over the pairs that share the same.
pub fn transfers(page: &mut String, machine: &Characteristics) {
    if machine.transfer.is_empty() {
        return;
    }
    page.push_str("\na line handed over, one way     pairs   median      from … to\n");
    let kinds = [
        ("core", "threads of a core"),
        ("cache", "sharing the last cache"),
        ("package", "in a package"),
        ("machine", "in different packages"),
    ];
    for (share, name) in kinds {
        let own = |row: &&Measurement<TransferKey>| row.key.share == share;
        let rows = machine.transfer.iter().filter(own);
        let mut times: Vec<f64> = rows.map(|row| row.figure.value).collect();
        times.sort_by(f64::total_cmp);
        if let (Some(first), Some(last)) = (times.first(), times.last()) {
            _ = writeln!(
                page,
                "  {name:<29} {:>5}   {:<11} {} … {}",
                times.len(),
                seconds(times[times.len() / 2]),
                seconds(*first),
                seconds(*last)
            );
        }
    }
}

/// Kernels by what they read and write; all traffic is counted in each.
pub fn mixes(page: &mut String, machine: &Characteristics) {
    const KERNELS: [(&str, &str); 7] = [
        ("read", "reads"),
        ("update_3_1", "3:1"),
        ("update_2_1", "2:1"),
        ("update_1_1", "1:1"),
        ("triad_nt", "2:1 nt"),
        ("copy_nt", "1:1 nt"),
        ("fill_nt", "0:1 nt"),
    ];
    let mixes = (machine.bandwidth.iter()).filter(|row| row.key.kernel == "update_1_1");
    let teams: Vec<u64> = mixes.map(|row| row.key.threads).collect();
    if teams.is_empty() {
        return;
    }
    let heads = KERNELS.map(|(_, head)| format!("{head:<11}"));
    _ = writeln!(page, "\nread:written  {}", heads.join(" ").trim_end());
    for threads in teams {
        let cells = KERNELS.map(|(kernel, _)| {
            let row = machine.bandwidth.iter().find(|row| {
                let key = &row.key;
                (key.kernel.as_str(), key.placement.as_str(), key.threads)
                    == (kernel, "compact", threads)
            });
            let rate = row.map_or_else(String::new, |row| rate_text(&row.figure));
            format!("{rate:<11}")
        });
        let name = plural(threads as usize, "thread");
        _ = writeln!(page, "  {name:<11} {}", cells.join(" ").trim_end());
    }
}
