//! The measurements of a machine, on one page of a terminal.

mod words;

use crate::report::numbers::plural;
use crate::report::size_text;
use crate::store::{Characteristics, Measurement, MountainKey, SolverKey};
use std::fmt::Write;
use words::{caches, memory_words, processor, rate_text, seconds, system, time_text};

/// Number of modes for which solver scaling is shown; if it was not measured, the nearest number that was.
const SHOWN_MODES: u64 = 40;

/// The page as text.
pub fn machine_page(machine: &Characteristics) -> String {
    let mut page = String::new();
    head(&mut page, machine);
    memory(&mut page, machine);
    bandwidth(&mut page, machine);
    arithmetic(&mut page, machine);
    solver(&mut page, machine);
    if !machine.missing.is_empty() {
        page.push_str("\nnot measured or not found\n");
        for sentence in &machine.missing {
            _ = writeln!(page, "  {sentence}");
        }
    }
    page
}

fn head(page: &mut String, machine: &Characteristics) {
    let d = &machine.description;
    _ = writeln!(
        page,
        "{}  measured {} in {:.0} s ({}), {}",
        machine.host, machine.started, machine.seconds, machine.extent, machine.program
    );
    let mut line = |name: &str, text: String| {
        if !text.is_empty() {
            _ = writeln!(page, "  {name:<11} {text}");
        }
    };
    line("processor", processor(d));
    line("caches", caches(d));
    line("memory", memory_words(d));
    line("system", system(d));
    let noise = &machine.noise;
    let verdict = if noise.quiet {
        "quiet".to_owned()
    } else {
        format!("NOT QUIET: {}", noise.remarks.join("; "))
    };
    line("noise", verdict);
}

/// Names of the levels of memory, each with a size of a buffer that fits well into the level \[bytes\]. For
/// the first cache this is half its size. For a later cache it is the geometric mean of its size and the size
/// of the cache before it, because a large shared cache may be only partly available. Caches without a measured
/// buffer of this size are omitted. The last level is `memory`, with the largest measured buffer, if this exceeds
/// the last cache by 20 %.
pub(super) fn levels(machine: &Characteristics) -> Vec<(String, u64)> {
    let Some(largest) = machine.mountain.iter().map(|row| row.key.size).max() else {
        return Vec::new();
    };
    let mut before = None;
    let mut places = Vec::new();
    for cache in &machine.description.caches {
        let smaller = before.replace(cache.size as f64);
        let size = match smaller {
            None => 0.5 * cache.size as f64,
            Some(smaller) => (smaller * cache.size as f64).sqrt(),
        };
        if size <= largest as f64 {
            places.push((format!("L{}", cache.level), size as u64));
        }
    }
    if before.is_none_or(|last| largest as f64 > 1.2 * last) {
        places.push(("memory".to_owned(), largest));
    }
    places
}

/// Appends bandwidth of reads and latency of loads: at every level of memory, between nodes, and as the firmware
/// reports them.
fn memory(page: &mut String, machine: &Characteristics) {
    let places = levels(machine);
    if places.is_empty() {
        return;
    }
    page.push_str(
        "\none thread   buffer      line by line   every 4 KiB      a load    to another page\n",
    );
    for (name, size) in places {
        let near = |other: u64| (other as f64 / size as f64).ln().abs();
        let at = |stride: u64| {
            let rows = machine
                .mountain
                .iter()
                .filter(|row| row.key.stride == stride);
            rows.min_by(|a, b| near(a.key.size).total_cmp(&near(b.key.size)))
                .filter(|row| near(row.key.size) < 0.4)
        };
        let load = |order: &str| {
            (machine.latency.iter())
                .filter(|row| row.key.order == order && !row.key.huge_pages)
                .filter(|row| row.key.cpu_node == row.key.memory_node)
                .min_by(|a, b| near(a.key.size).total_cmp(&near(b.key.size)))
                .map_or_else(String::new, |row| time_text(&row.figure))
        };
        let rate = |row: Option<&Measurement<MountainKey>>| {
            row.map_or_else(String::new, |row| rate_text(&row.figure))
        };
        let shown = at(64).map_or(size, |row| row.key.size);
        _ = writeln!(
            page,
            "  {name:<10} {:<11} {:<14} {:<14} {:<14} {}",
            size_text(shown),
            rate(at(64)),
            rate(at(4096)),
            load("pages"),
            load("hops"),
        );
    }
    for row in machine.latency.iter().filter(|row| row.key.huge_pages) {
        _ = writeln!(
            page,
            "  a load to another page in {}, on huge pages: {}",
            size_text(row.key.size),
            time_text(&row.figure)
        );
    }
    nodes(page, machine);
    for path in &machine.description.paths {
        let bandwidth = path
            .bandwidth
            .map(|b| format!("{:.1} GB/s", b as f64 * 1.048_576e-3));
        let latency = path.latency.map(|l| format!("{l} ns"));
        let figures: Vec<String> = bandwidth.into_iter().chain(latency).collect();
        _ = writeln!(
            page,
            "  {} → {} as the firmware reports: {}",
            path.cpu_node,
            path.memory_node,
            figures.join(", ")
        );
    }
}

/// Appends one line per pair of nodes, `threads → memory`: bandwidth of reads, and latency of loads.
fn nodes(page: &mut String, machine: &Characteristics) {
    let between = (machine.bandwidth.iter()).filter(|row| row.key.placement == "nodes");
    let rows: Vec<_> = between.collect();
    if rows.is_empty() {
        return;
    }
    let latency = |cpu: Option<u32>, memory: Option<u32>| {
        let hops = (machine.latency.iter())
            .filter(|row| row.key.order == "hops" && !row.key.huge_pages)
            .filter(|row| Some(row.key.cpu_node) == cpu && Some(row.key.memory_node) == memory);
        hops.max_by_key(|row| row.key.size)
    };
    page.push_str("\ncores of node → memory of node: reading, a load to another page\n");
    for row in rows {
        let name = |node: Option<u32>| node.map_or_else(String::new, |node| node.to_string());
        _ = writeln!(
            page,
            "  {} → {}: {}, {}",
            name(row.key.cpu_node),
            name(row.key.memory_node),
            rate_text(&row.figure),
            latency(row.key.cpu_node, row.key.memory_node)
                .map_or_else(String::new, |row| time_text(&row.figure)),
        );
    }
}

fn bandwidth(page: &mut String, machine: &Characteristics) {
    let kernels = ["read", "copy", "triad", "copy_nt", "triad_nt"];
    let mut teams: Vec<(&str, u64)> = (machine.bandwidth.iter())
        .filter(|row| row.key.placement != "nodes" && row.key.kernel == "read")
        .map(|row| (row.key.placement.as_str(), row.key.threads))
        .collect();
    teams.dedup();
    if teams.is_empty() {
        return;
    }
    page.push_str("\nthreads      read        copy        triad       copy nt     triad nt\n");
    for (placement, threads) in teams {
        let cell = |kernel: &str| {
            let row = machine.bandwidth.iter().find(|row| {
                row.key.kernel == kernel
                    && row.key.placement == placement
                    && row.key.threads == threads
            });
            row.map_or_else(String::new, |row| rate_text(&row.figure))
        };
        let name = match placement {
            "compact" => threads.to_string(),
            _ => format!("{threads} scattered"),
        };
        let cells = kernels.map(|kernel| format!("{:<11}", cell(kernel)));
        _ = writeln!(page, "  {name:<10} {}", cells.join(" ").trim_end());
    }
}

fn arithmetic(page: &mut String, machine: &Characteristics) {
    let mut sets: Vec<&str> = machine
        .arithmetic
        .iter()
        .map(|row| row.key.isa.as_str())
        .collect();
    sets.dedup();
    if sets.is_empty() {
        return;
    }
    page.push_str("\nmultiply-adds, 10⁹ operations per second\n");
    for set in sets {
        let rows = machine.arithmetic.iter().filter(|row| row.key.isa == set);
        let cells: Vec<String> = rows
            .map(|row| {
                let threads = plural(row.key.threads as usize, "thread");
                format!("{threads} {:.1}", 1e-9 * row.figure.value)
            })
            .collect();
        _ = writeln!(page, "  {set:<10} {}", cells.join(", "));
    }
}

fn solver(page: &mut String, machine: &Characteristics) {
    let modes = machine.solver.iter().map(|row| row.key.modes);
    let Some(modes) = modes.min_by_key(|modes| modes.abs_diff(SHOWN_MODES)) else {
        return;
    };
    let rows = || machine.solver.iter().filter(|row| row.key.modes == modes);
    _ = writeln!(
        page,
        "\nintegrating, {modes} modes           points   one table   one thread      best of threads"
    );
    let campaign = |row: &Measurement<SolverKey>| {
        let key = &row.key;
        (key.kernel.clone(), key.tables.clone(), key.points)
    };
    let mut campaigns: Vec<_> = rows().map(campaign).collect();
    campaigns.sort();
    campaigns.dedup();
    for wanted in campaigns {
        let campaign_rows = rows().filter(|row| campaign(row) == wanted);
        let alone = campaign_rows.clone().find(|row| row.key.threads == 1);
        let best = campaign_rows.max_by(|a, b| a.figure.value.total_cmp(&b.figure.value));
        let (Some(alone), Some(best)) = (alone, best) else {
            continue;
        };
        let (kernel, tables, points) = wanted;
        let (threads, efficiency) = (best.key.threads, best.key.efficiency);
        _ = writeln!(
            page,
            "  {:<31} {points:<8} {:<11} {:<15} {:.2} × on {}{}",
            format!("{kernel}, {tables} tables"),
            size_text(alone.key.table_bytes),
            format!("{} a cycle", seconds(1.0 / alone.figure.value)),
            efficiency * threads as f64,
            plural(threads as usize, "thread"),
            match threads {
                1 => String::new(),
                _ => format!(", {:.0} % of ideal", 100.0 * efficiency),
            },
        );
    }
}
