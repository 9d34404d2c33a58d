//! The description of a machine and its measured figures, as text.

use crate::report::numbers::plural;
use crate::report::size_text;
use crate::store::{Description, Figure};
use crate::topology::Cache;
use std::fmt::Write;

pub fn processor(d: &Description) -> String {
    let mut text = format!(
        "{}; {}, {}, {} here",
        d.cpu,
        plural(d.packages, "package"),
        plural(d.cores, "core"),
        plural(d.threads, "thread"),
    );
    if let Some(online) = d.threads_online.filter(|online| *online != d.threads) {
        _ = write!(text, " of {online} online");
    }
    if let Some(percent) = d.quota_percent {
        _ = write!(text, "; quota of {} processors", percent as f64 / 100.0);
    }
    if let Some(isa) = d.isa.last() {
        _ = write!(text, "; {isa}");
    }
    text
}

pub fn caches(d: &Description) -> String {
    let one = |cache: &Cache| {
        let size = size_text(cache.size);
        format!("L{} {size} × {}", cache.level, cache.count)
    };
    d.caches.iter().map(one).collect::<Vec<_>>().join(", ")
}

pub fn memory_words(d: &Description) -> String {
    let mut text = format!(
        "{} on {}",
        size_text(d.memory),
        plural(d.nodes.len(), "node")
    );
    if d.nodes.len() > 1 {
        let far = d.nodes.iter().flat_map(|node| &node.distances).max();
        if let Some(far) = far {
            _ = write!(text, ", distances to {far} (10 is near)");
        }
    }
    if let Some(mode) = &d.huge_pages.transparent {
        _ = write!(text, "; huge pages: {mode}");
    }
    match d.numa_balancing {
        Some(1) => text.push_str(
            "; NUMA balancing is on: pages move to the threads that use them, so figures between nodes drift to \
             figures within a node",
        ),
        Some(2..) => text.push_str("; NUMA balancing moves pages between kinds of memory"),
        Some(0) | None => {}
    }
    if let Some(limit) = d.memory_limit {
        _ = write!(text, "; limit {}", size_text(limit));
    }
    text
}

pub fn system(d: &Description) -> String {
    let mut parts = vec![d.system.clone()];
    parts.push(match &d.hypervisor {
        Some(name) => format!("virtual ({name})"),
        None => "not virtual".to_owned(),
    });
    if !d.topology.is_empty() {
        parts.push(format!("topology from {}", d.topology));
    }
    parts.extend(d.container.iter().map(|name| format!("in {name}")));
    parts.push(match &d.governor {
        Some(governor) => format!("governor {governor}"),
        None => "governor unknown".to_owned(),
    });
    parts.join(", ")
}

/// `12.3 GB/s`.
pub fn rate_text(figure: &Figure) -> String {
    let (value, unit) = match figure.value {
        value if value >= 1e12 => (1e-12 * value, "TB/s"),
        value if value >= 1e9 => (1e-9 * value, "GB/s"),
        value => (1e-6 * value, "MB/s"),
    };
    format!("{} {unit}", three_digits(value))
}

pub fn time_text(figure: &Figure) -> String {
    seconds(figure.value)
}

/// `1.23 µs`.
pub fn seconds(value: f64) -> String {
    let (scaled, unit) = match value {
        value if value >= 1.0 => (value, "s"),
        value if value >= 1e-3 => (1e3 * value, "ms"),
        value if value >= 1e-6 => (1e6 * value, "µs"),
        value => (1e9 * value, "ns"),
    };
    format!("{} {unit}", three_digits(scaled))
}

pub fn three_digits(value: f64) -> String {
    let digits = match value {
        value if value >= 100.0 => 0,
        value if value >= 10.0 => 1,
        _ => 2,
    };
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// If the kernel moves pages (NUMA balancing), bandwidths between nodes are not reliable.
    #[test]
    fn balancing_is_said_where_it_is_on() {
        let words = |numa_balancing| {
            memory_words(&Description {
                numa_balancing,
                ..Description::default()
            })
        };
        assert!(words(Some(1)).contains("NUMA balancing is on"));
        assert!(words(Some(2)).contains("between kinds of memory"));
        assert_eq!(words(Some(0)), words(None));
    }

    #[test]
    fn figures_have_three_digits() {
        for (value, text) in [
            (1.234e-7, "123 ns"),
            (2.5e-6, "2.50 µs"),
            (0.0314, "31.4 ms"),
        ] {
            assert_eq!(seconds(value), text);
        }
        let figure = |value| Figure {
            value,
            best: value,
            median: value,
            spread: None,
            rounds: 1,
            repetitions: 1,
        };
        for (value, text) in [
            (12.34e9, "12.3 GB/s"),
            (1.5e12, "1.50 TB/s"),
            (9e8, "900 MB/s"),
        ] {
            assert_eq!(rate_text(&figure(value)), text);
        }
    }
}
