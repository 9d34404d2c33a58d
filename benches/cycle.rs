//! Time of one mesh cycle of the default drive, in rattle or in constant contact, by kernel, number of modes, load,
//! speed, number of tangents and instruction set; its counted work; and the limits of the machine.
//!
//! ```text
//! scripts/record cycle            runs this and records it under benches/runs/
//! ```
//!
//! All kernels run in one process, so that their ratios are comparable. Every bench continues a settled trajectory.

// Criterion's macros generate undocumented items; a bench may unwrap, like a test.
#![allow(missing_docs, clippy::unwrap_used)]

#[path = "cycle/ceilings.rs"]
mod ceilings;
#[path = "../tests/common/mod.rs"]
mod common;
#[path = "cycle/scenes.rs"]
mod scenes;

use common::Case;
use criterion::{Bencher, BenchmarkId, Criterion, criterion_group, criterion_main};
use gearatlas::analysis::Nvh;
use gearatlas::model::{Division, Model};
use gearatlas::propagate::{
    ClosedModes, Counters, InstructionSet, Kernel, Observer, Stepping, Tangents, Volterra,
};
use gearatlas::reference::Reference;
use scenes::{computed, drive, quiet, settled, volterra};
use serde_json::{Map, Value, json};
use std::hint::black_box;
use std::path::Path;
use std::time::Duration;

const MODES: [usize; 9] = [2, 6, 12, 20, 40, 81, 160, 320, 640];
const LOADS: [f64; 2] = [0.05, 0.30];
/// Speeds \[rad/s\] in addition to 1200 rad/s, the speed of the scenes by number of modes: each scene is timed once.
const SPEEDS: [f64; 5] = [600.0, 900.0, 1100.0, 1500.0, 2400.0];

/// Advances a settled trajectory, cycle after cycle.
fn advance<K: Kernel>(bench: &mut Bencher<'_>, kernel: &K, model: &Model, tangents: usize) {
    advance_watched(bench, kernel, model, tangents, &mut ());
}

/// Advances a settled trajectory with an observer, cycle after cycle.
fn advance_watched<K: Kernel, O: Observer>(
    bench: &mut Bencher<'_>,
    kernel: &K,
    model: &Model,
    tangents: usize,
    observer: &mut O,
) {
    let mut trajectory = settled(model);
    let mut tangent = Tangents::zeros(model.modes(), tangents);
    let mut workspace = kernel.workspace();
    let mut counters = Counters::default();
    bench.iter(|| {
        for i in 0..tangents {
            tangent.vector_mut(i).fill(1e-9);
        }
        kernel
            .advance_cycle(
                black_box(&mut trajectory),
                &mut tangent,
                &mut workspace,
                observer,
                &mut counters,
            )
            .expect("the default drive does not diverge");
    });
}

/// Every scene's name and drive.
fn scenes() -> Vec<(String, Case)> {
    let mut scenes = Vec::new();
    for modes in MODES {
        for load in LOADS {
            scenes.push((format!("load-{load}/{modes}"), drive(modes, load, 1200.0)));
        }
        scenes.push((format!("constant-contact/{modes}"), quiet(modes)));
    }
    for speed in SPEEDS {
        for load in LOADS {
            scenes.push((format!("speed-{speed}/{load}"), drive(40, load, speed)));
        }
    }
    for ratio in [1.6, 1.63] {
        let mut case = drive(40, 0.05, 1200.0);
        case.1.mesh = Division::levels(&[4.444e8, 3.333e8], &[ratio - 1.0]);
        scenes.push((format!("continuous/{ratio}"), case));
    }
    scenes.push(("computed/60".to_owned(), computed(Some(60))));
    scenes.push(("computed/course".to_owned(), computed(None)));
    scenes
}

fn cycles(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("cycle");
    for (name, case) in scenes() {
        let model = common::model(&case);
        let (kind, parameter) = name.split_once('/').unwrap();
        group.bench_function(BenchmarkId::new(kind, parameter), |b| {
            advance(b, &volterra(&model), &model, 0);
        });
    }
    group.finish();
}

fn tangents(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("tangents");
    for modes in MODES {
        let model = common::model(&drive(modes, 0.05, 1200.0));
        for count in [1, 8] {
            group.bench_function(BenchmarkId::new(count.to_string(), modes), |b| {
                advance(b, &volterra(&model), &model, count);
            });
        }
    }
    group.finish();
}

/// The two exact kernels, without and with a tangent.
fn closed_modes(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("closed-modes");
    for modes in [2, 6, 20, 40] {
        let model = common::model(&drive(modes, 0.05, 1200.0));
        let arrays = ClosedModes::arrays(&model).unwrap();
        let set = InstructionSet::best();
        let kernel = ClosedModes::from_kept(&model, 1000, &arrays, set).unwrap();
        for count in [0, 1] {
            group.bench_function(BenchmarkId::new(format!("closed-{count}"), modes), |b| {
                advance(b, &kernel, &model, count);
            });
            group.bench_function(BenchmarkId::new(format!("volterra-{count}"), modes), |b| {
                advance(b, &volterra(&model), &model, count);
            });
        }
        group.bench_function(BenchmarkId::new("bases", modes), |b| {
            b.iter(|| ClosedModes::arrays(black_box(&model)));
        });
        group.bench_function(BenchmarkId::new("set-up", modes), |b| {
            b.iter(|| {
                let kernel = ClosedModes::from_kept(black_box(&model), 1000, &arrays, set).unwrap();
                advance_once(&kernel, &model);
            });
        });
    }
    group.finish();
}

/// All statistics with ten harmonics, by both exact kernels, and the same cycles without observer.
fn nvh(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("nvh");
    for modes in [6, 40] {
        let model = common::model(&drive(modes, 0.05, 1200.0));
        let arrays = ClosedModes::arrays(&model).unwrap();
        let closed = ClosedModes::from_kept(&model, 1000, &arrays, InstructionSet::best()).unwrap();
        let structured = volterra(&model);
        for harmonics in [None, Some(0), Some(10)] {
            let name = harmonics.map_or("bare".to_owned(), |h| format!("harmonics-{h}"));
            let mut watch = |kernel: &str, advance: &mut dyn FnMut(&mut Bencher<'_>)| {
                group.bench_function(BenchmarkId::new(format!("{kernel}-{name}"), modes), advance);
            };
            let statistics = || harmonics.map(|h| Nvh::new(&model, h));
            watch("closed", &mut |b| watched(b, &closed, &model, statistics()));
            watch("volterra", &mut |b| {
                watched(b, &structured, &model, statistics())
            });
        }
    }
    group.finish();
}

/// Advances a settled trajectory with the statistics `nvh`, if any.
fn watched<K: Kernel>(bench: &mut Bencher<'_>, kernel: &K, model: &Model, nvh: Option<Nvh>) {
    match nvh {
        Some(mut nvh) => advance_watched(bench, kernel, model, 0, &mut nvh),
        None => advance(bench, kernel, model, 0),
    }
}

/// One cycle from rest, to build all tables in advance.
fn advance_once<K: Kernel>(kernel: &K, model: &Model) {
    let mut trajectory = model.start(&gearatlas::model::InitialState::Static);
    let (mut workspace, mut counters) = (kernel.workspace(), Counters::default());
    kernel
        .advance(1, &mut trajectory, &mut workspace, &mut (), &mut counters)
        .expect("the default drive does not diverge");
}

fn set_up(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("set-up");
    for modes in MODES {
        let model = common::model(&drive(modes, 0.05, 1200.0));
        group.bench_function(BenchmarkId::new("tables", modes), |b| {
            b.iter(|| volterra(black_box(&model)));
        });
    }
    group.finish();
}

fn instruction_sets(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("set");
    for set in InstructionSet::available() {
        for (scene, case) in [("load-0.05", drive(40, 0.05, 1200.0)), ("quiet", quiet(40))] {
            let model = common::model(&case);
            let kernel = Volterra::with_instructions(&model, f64::EPSILON, 1000, set);
            group.bench_function(BenchmarkId::new(set.name(), scene), |b| {
                advance(b, &kernel, &model, 0);
            });
        }
    }
    group.finish();
}

fn others(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("others");
    group.sample_size(10);
    for modes in [2, 6, 12, 20, 40] {
        let model = common::model(&drive(modes, 0.05, 1200.0));
        // Steps of 100 ns, as published for small-step integration of this class of drive.
        let stepping = Stepping::new(&model, (model.period() / 100e-9) as u32, 1000);
        group.bench_function(BenchmarkId::new("stepping-100ns", modes), |b| {
            advance(b, &stepping, &model, 0);
        });
        let reference = Reference::new(&model);
        let start = settled(&model);
        group.bench_function(BenchmarkId::new("reference", modes), |b| {
            b.iter(|| {
                reference
                    .advance(black_box(&start), 1)
                    .expect("it advances")
            });
        });
    }
    group.finish();
}

/// Counts the work of every scene, measures the machine's limits, and stores both with Criterion's estimates.
fn facts(_: &mut Criterion) {
    let work: Map<String, Value> = scenes()
        .iter()
        .map(|(name, case)| (format!("cycle/{name}"), scenes::work(case)))
        .collect();
    let reading: Map<String, Value> = MODES
        .iter()
        .map(|&modes| {
            let model = common::model(&quiet(modes));
            let numbers = volterra(&model).numbers_per_window();
            (modes.to_string(), json!(ceilings::reading(numbers)))
        })
        .collect();
    let facts = json!({
        "instructions": InstructionSet::best().name(),
        "work": work,
        "multiply_adds_per_ns": ceilings::multiply_adds(),
        "bytes_per_ns": {
            "16 KiB": 16384.0 / ceilings::reading(16384 / 8),
            "512 KiB": 524288.0 / ceilings::reading(524288 / 8),
        },
        "reading_tables_ns": reading,
    });
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/criterion");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("facts.json"), format!("{facts:#}\n")).unwrap();
}

fn quick() -> Criterion {
    Criterion::default()
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(700))
        .sample_size(30)
        .nresamples(2000)
}

criterion_group! {
    name = benches;
    config = quick();
    targets = facts, cycles, tangents, closed_modes, nvh, set_up, instruction_sets, others
}
criterion_main!(benches);
