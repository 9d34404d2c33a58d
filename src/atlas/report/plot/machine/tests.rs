use super::*;
use crate::store::{
    ArithmeticKey, BandwidthKey, Description, Figure, LatencyKey, Measurement, MountainKey, Noise,
    ProgramRecord, RoofRow, SolverKey,
};
use crate::topology::Cache;

fn figure(value: f64) -> Figure {
    Figure {
        value,
        best: value,
        median: value,
        spread: Some(0.02),
        rounds: 3,
        repetitions: 30,
    }
}

/// A small record of a machine with two nodes and two caches.
fn machine() -> Characteristics {
    let cache = |level, size| Cache {
        level,
        size,
        line: Some(64),
        count: 2,
        shared_by: 1,
    };
    let sizes = [16u64 << 10, 256 << 10, 64 << 20];
    let bandwidth =
        |placement: &str, kernel: &str, threads, nodes: Option<(u32, u32)>| Measurement {
            key: BandwidthKey {
                kernel: kernel.to_owned(),
                placement: placement.to_owned(),
                threads,
                cpu_node: nodes.map(|n| n.0),
                memory_node: nodes.map(|n| n.1),
                array: 1 << 30,
                bytes: 1 << 30,
            },
            figure: figure(1e10 * threads as f64),
        };
    let solver = |kernel: &str, tables: &str, [modes, points, threads]: [u64; 3]| Measurement {
        key: SolverKey {
            kernel: kernel.to_owned(),
            tables: tables.to_owned(),
            modes,
            points,
            threads,
            table_bytes: 9000 * modes,
            efficiency: 1.0,
        },
        figure: figure(1e5 / modes as f64 * threads as f64),
    };
    Characteristics {
        format: Characteristics::format(),
        host: "there".to_owned(),
        started: "2026-03-01T12:00:00Z".to_owned(),
        seconds: 42.0,
        extent: "quick".to_owned(),
        program: ProgramRecord::current(),
        description: Description {
            cpu: "A <processor>".to_owned(),
            caches: vec![cache(1, 48 << 10), cache(2, 2 << 20)],
            ..Description::default()
        },
        noise: Noise {
            others: Some(0.3),
            stolen: None,
            load: None,
            scatter: None,
            quiet: false,
            remarks: Vec::new(),
        },
        mountain: (sizes.iter())
            .flat_map(|&size| [64, 4096].map(|stride| (size, stride)))
            .map(|(size, stride)| Measurement {
                key: MountainKey { size, stride },
                figure: figure(1e17 / size as f64 / stride as f64),
            })
            .collect(),
        bandwidth: vec![
            bandwidth("compact", "read", 1, None),
            bandwidth("compact", "read", 2, None),
            bandwidth("scattered", "read", 2, None),
            bandwidth("nodes", "read", 2, Some((0, 0))),
            bandwidth("nodes", "read", 1, Some((0, 1))),
        ],
        latency: ([("pages", false), ("hops", false), ("hops", true)].iter())
            .flat_map(|&(order, huge_pages)| {
                sizes.iter().map(move |&size| Measurement {
                    key: LatencyKey {
                        size,
                        order: order.to_owned(),
                        huge_pages,
                        cpu_node: 0,
                        memory_node: 0,
                    },
                    figure: figure(1e-15 * size as f64),
                })
            })
            .collect(),
        arithmetic: vec![Measurement {
            key: ArithmeticKey {
                isa: "avx2".to_owned(),
                threads: 1,
            },
            figure: figure(4e10),
        }],
        solver: [("volterra", "private"), ("closed_modes", "shared")]
            .into_iter()
            .flat_map(|(kernel, tables)| {
                [[10, 8, 1], [40, 8, 1], [40, 8, 2], [40, 64, 1]]
                    .map(|numbers| solver(kernel, tables, numbers))
            })
            .collect(),
        roofline: vec![RoofRow {
            kernel: "volterra".to_owned(),
            modes: 40,
            operations: 1e6,
            bytes_read: 4e6,
            bytes_distinct: 1e5,
            intensity: 10.0,
            rate: 1e10,
        }],
        missing: Vec::new(),
    }
}

#[test]
fn every_picture_of_a_whole_record_is_drawn_and_says_what_it_shows() {
    let drawn = pictures(&machine());
    let names: Vec<&str> = drawn.iter().map(|picture| picture.name.as_str()).collect();
    let wanted = ["mountain", "bandwidth", "solver", "roofline"];
    assert_eq!(names, wanted.map(|name| format!("machine-{name}")));
    let words: [&[&str]; 4] = [
        &[
            "every line",
            "every 4 KiB",
            "page by page",
            "page to page",
            "on huge pages",
            "read bandwidth [GB/s]",
            "L2 2 MiB",
            "1 MiB",
        ],
        &["threads [–]", "nodes in turn"],
        &[
            "depth: modes, one thread",
            "breadth: points, 40 modes, one thread",
            "breadth: threads, 40 modes",
            "volterra",
            "shared",
            "blue: closed_modes, by the sharing of its tables",
            "ideal",
        ],
        &["avx2", "memory", "volterra 40"],
    ];
    for (picture, words) in drawn.iter().zip(words) {
        let svg = picture.svg().unwrap();
        let document = roxmltree::Document::parse(&svg).unwrap();
        let texts: Vec<&str> = (document.descendants())
            .filter_map(|node| node.text().map(str::trim))
            .collect();
        for word in words
            .iter()
            .chain(&["there  ·  A <processor>  ·  2026-03-01  ·  machine not quiet"])
        {
            assert!(texts.contains(word), "{}: {word}: {texts:?}", picture.name);
        }
    }
}

#[test]
fn a_record_without_figures_has_no_pictures() {
    let mut empty = machine();
    empty.mountain.clear();
    empty.bandwidth.clear();
    empty.latency.clear();
    empty.solver.clear();
    empty.roofline.clear();
    assert_eq!(pictures(&empty), []);
}
