//! Time of one mesh cycle by kernel: the dense tables published for this class of drive beside
//! the structured kernel, in one run; the products and guard evaluations they take, and the size
//! of their tables.
//!
//! ```text
//! cargo bench --bench ladder
//! ```
//!
//! Scenes: 6 degrees of freedom in strong (1200 rad/s) and sparse (1400 rad/s) rattle, 40 modes
//! near resonance, with the two levels of the default mesh and with sixty different ones, 20
//! modes with the rest as residual flexibility, and constant contact. `cells-1` are cells as
//! long as the closed forms allow.

// Criterion's macros generate undocumented items; a bench may end on an unwrap as a test may.
#![allow(missing_docs, clippy::unwrap_used)]

#[path = "../tests/common/mod.rs"]
mod common;
#[allow(dead_code)]
#[path = "cycle/scenes.rs"]
mod scenes;

use atlas::model::{Division, Model, TrajectoryState};
use atlas::propagate::{
    Counters, Dyadic, Fused, Hermite, Kernel, PowerJumps, Spectral, TableSize, Tangents, Volterra,
};
use common::Case;
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use scenes::{drive, quiet, settled};
use serde_json::{Map, Value, json};
use std::f64::consts::TAU;
use std::hint::black_box;
use std::path::Path;
use std::time::Duration;

/// Unit steps a mesh cycle, as published.
const CELLS: u32 = 60;

/// Cycles over which work is counted.
const COUNTED: u64 = 500;

fn sixty_levels(mut case: Case) -> Case {
    let levels: Vec<f64> = (0..60)
        .map(|i| 4e8 * (1.0 + 0.14 * (TAU * (f64::from(i) + 0.5) / 60.0).sin()))
        .collect();
    case.1.mesh = Division::levels(&levels, &[]);
    case
}

fn all_scenes() -> Vec<(&'static str, Case)> {
    vec![
        ("6-strong", drive(6, 0.05, 1200.0)),
        ("6-sparse", drive(6, 0.05, 1400.0)),
        ("40-strong", drive(40, 0.05, 1200.0)),
        ("40-sixty-levels", sixty_levels(drive(40, 0.05, 1200.0))),
        ("20-residual", common::twenty_modes()),
        ("6-contact", quiet(6)),
        ("40-contact", quiet(40)),
    ]
}

/// Marches a settled trajectory on, cycle after cycle.
fn march<K: Kernel>(
    bench: &mut criterion::Bencher<'_>,
    kernel: &K,
    start: &TrajectoryState,
    counters: &mut Counters,
) {
    let mut trajectory = start.clone();
    let mut workspace = kernel.workspace();
    bench.iter(|| go(kernel, black_box(&mut trajectory), &mut workspace, counters));
}

fn go<K: Kernel>(
    kernel: &K,
    trajectory: &mut TrajectoryState,
    workspace: &mut K::Workspace,
    counters: &mut Counters,
) {
    kernel
        .march(
            trajectory,
            &mut Tangents::none(),
            workspace,
            &mut (),
            counters,
        )
        .expect("the default drive does not diverge");
}

/// Work of some cycles, a cycle.
fn work<K: Kernel>(kernel: &K, start: &TrajectoryState, size: Option<TableSize>) -> Value {
    let mut trajectory = start.clone();
    let (mut workspace, mut counters) = (kernel.workspace(), Counters::default());
    for _ in 0..COUNTED {
        go(kernel, &mut trajectory, &mut workspace, &mut counters);
    }
    let mean = |count: u64| count as f64 / COUNTED as f64;
    json!({
        "matvecs": mean(counters.matvecs),
        "guard_evaluations": mean(counters.guard_evaluations),
        "events": mean(counters.events),
        "windows": mean(counters.windows),
        "table_bytes": size.map(|size| size.bytes),
        "cells": size.map(|size| size.cells),
    })
}

fn ladder(criterion: &mut Criterion) {
    let mut facts = Map::new();
    let mut group = criterion.benchmark_group("ladder");
    for (scene, case) in all_scenes() {
        let model = common::model(&case);
        let start = settled(&model);
        let mut run = |name: &str, size: Option<TableSize>, kernel: &dyn Bench| {
            facts.insert(format!("{scene}/{name}"), kernel.work(&start, size));
            group.bench_function(BenchmarkId::new(name, scene), |b| kernel.bench(b, &start));
        };
        run("volterra", None, &Volterra::new(&model, f64::EPSILON, 1000));
        let dyadic = Dyadic::new(&model, CELLS, 1000).unwrap();
        run("dyadic", Some(dyadic.bytes()), &dyadic);
        let hermite = Hermite::new(&model, CELLS, 1000).unwrap();
        run("hermite", Some(hermite.bytes()), &hermite);
        for (suffix, cells) in [("", CELLS), ("-cells-1", 1)] {
            let spectral = Spectral::new(&model, cells, 1000, None).unwrap();
            run(
                &format!("spectral{suffix}"),
                Some(spectral.bytes()),
                &spectral,
            );
            let fused = Fused::new(&model, cells, 1000).unwrap();
            run(&format!("fused{suffix}"), Some(fused.bytes()), &fused);
        }
    }
    group.finish();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/criterion");
    std::fs::create_dir_all(&folder).unwrap();
    let facts = Value::Object(facts);
    std::fs::write(folder.join("ladder.json"), format!("{facts:#}\n")).unwrap();
}

/// A kernel of any type.
trait Bench {
    fn bench(&self, bench: &mut criterion::Bencher<'_>, start: &TrajectoryState);
    fn work(&self, start: &TrajectoryState, size: Option<TableSize>) -> Value;
}

impl<K: Kernel> Bench for K {
    fn bench(&self, bench: &mut criterion::Bencher<'_>, start: &TrajectoryState) {
        march(bench, self, start, &mut Counters::default());
    }

    fn work(&self, start: &TrajectoryState, size: Option<TableSize>) -> Value {
        work(self, start, size)
    }
}

fn jumps(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("jump");
    for modes in [6, 40] {
        let model: Model = common::model(&quiet(modes));
        let mut jumps = PowerJumps::new(&model, 1_000_000).unwrap();
        let mut trajectory = settled(&model);
        group.bench_function(BenchmarkId::new("1e6-cycles", modes), |b| {
            b.iter(|| jumps.jump(black_box(&mut trajectory), 1_000_000));
        });
    }
    group.finish();
}

fn quick() -> Criterion {
    Criterion::default()
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(500))
        .sample_size(20)
        .nresamples(2000)
}

criterion_group! {
    name = benches;
    config = quick();
    targets = ladder, jumps
}
criterion_main!(benches);
