//! Time of one mesh cycle of the default drive, rattling or in constant contact, by kernel,
//! number of modes and number of tangents.
//!
//! ```text
//! scripts/bench            runs this and records it under benches/runs/
//! ```
//!
//! All kernels run in one process, so ratios between them hold. Every bench marches a
//! settled trajectory on and checks that it still rattles, or that it does not where it
//! should not.

// Criterion's macros generate undocumented items; a bench may end on an unwrap as a test may.
#![allow(missing_docs, clippy::unwrap_used)]

#[path = "../tests/common/mod.rs"]
mod common;

use atlas::model::{InitialState, Model, OperatingPoint, TrajectoryState};
use atlas::propagate::{Counters, Kernel, Stepping, Tangents, Volterra};
use atlas::reference::Reference;
use common::Case;
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use std::hint::black_box;

/// Cycles marched before the clock starts.
const TRANSIENT: u32 = 200;

/// The default drive with its `modes` lowest modes; beyond 40, its elastic modes again,
/// slightly detuned and felt little by the mesh.
fn drive(modes: usize, load: f64) -> Case {
    let (mut structure, mesh, point) = common::forty_modes();
    let known = structure.frequency.len();
    for i in known..modes {
        let like = 2 + i % (known - 2);
        let detuning = 1.0 - 5e-4 * (i / known) as f64;
        structure
            .frequency
            .push(detuning * structure.frequency[like]);
        structure.damping.push(structure.damping[like]);
        structure.mesh.push(0.05 * structure.mesh[like]);
        for column in [
            &mut structure.mesh_tilt,
            &mut structure.torque,
            &mut structure.friction,
            &mut structure.friction_lever,
        ] {
            column.push(0.0);
        }
    }
    for column in [
        &mut structure.frequency,
        &mut structure.damping,
        &mut structure.mesh,
        &mut structure.mesh_tilt,
        &mut structure.torque,
        &mut structure.friction,
        &mut structure.friction_lever,
    ] {
        column.truncate(modes);
    }
    (structure, mesh, OperatingPoint { load, ..point })
}

/// A trajectory past its transient.
fn settled(model: &Model) -> TrajectoryState {
    let kernel = Volterra::new(model, f64::EPSILON, 1000);
    let mut workspace = kernel.workspace();
    let mut trajectory = model.start(&InitialState::Static);
    let mut counters = Counters::default();
    for _ in 0..TRANSIENT {
        kernel
            .march(
                &mut trajectory,
                &mut Tangents::none(),
                &mut workspace,
                &mut (),
                &mut counters,
            )
            .expect("the default drive does not diverge");
    }
    trajectory
}

fn march<K: Kernel>(
    bench: &mut criterion::Bencher<'_>,
    kernel: &K,
    model: &Model,
    tangents: usize,
) {
    let mut trajectory = settled(model);
    let rattles = !model.transmission_error.is_empty();
    let mut tangent = Tangents::zeros(model.modes(), tangents);
    let mut workspace = kernel.workspace();
    let mut counters = Counters::default();
    bench.iter(|| {
        for i in 0..tangents {
            tangent.vector_mut(i).fill(1e-9);
        }
        kernel
            .march(
                black_box(&mut trajectory),
                &mut tangent,
                &mut workspace,
                &mut (),
                &mut counters,
            )
            .expect("the default drive does not diverge");
    });
    if rattles {
        assert!(counters.events > counters.cycles, "no rattle");
    } else {
        assert_eq!(counters.events, 0, "leaves contact");
    }
}

fn by_modes(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("cycle");
    for modes in [2, 6, 12, 20, 40, 81, 160, 320, 640] {
        let case = drive(modes, 0.05);
        let model = common::model(&case);
        let volterra = Volterra::new(&model, f64::EPSILON, 1000);
        group.bench_function(BenchmarkId::new("volterra", modes), |b| {
            march(b, &volterra, &model, 0);
        });
        if modes > 40 {
            continue;
        }
        // Steps of 100 ns, as published for small-step integration of this class of drive.
        let stepping = Stepping::new(&model, (model.period() / 100e-9) as u32, 1000);
        group.bench_function(BenchmarkId::new("stepping-100ns", modes), |b| {
            march(b, &stepping, &model, 0);
        });
    }
    group.finish();
}

fn forty_modes(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("forty-modes");
    for load in [0.05, 0.30] {
        let case = drive(40, load);
        let model = common::model(&case);
        let kernel = Volterra::new(&model, f64::EPSILON, 1000);
        for tangents in [0, 1, 4, 8] {
            let name = format!("volterra-{tangents}-tangents");
            group.bench_function(BenchmarkId::new(name, load), |b| {
                march(b, &kernel, &model, tangents);
            });
        }
        group.bench_function(BenchmarkId::new("set-up", load), |b| {
            b.iter(|| Volterra::new(black_box(&model), f64::EPSILON, 1000));
        });
    }
    // Full load and no transmission error: the mesh never opens.
    let mut case = drive(40, 1.0);
    case.1.transmission_error.clear();
    let model = common::model(&case);
    let kernel = Volterra::new(&model, f64::EPSILON, 1000);
    group.bench_function("constant-contact", |b| march(b, &kernel, &model, 0));

    let case = drive(40, 0.05);
    let model = common::model(&case);
    let reference = Reference::new(&model);
    let start = settled(&model);
    group.sample_size(20);
    group.bench_function(BenchmarkId::new("reference", 0.05), |b| {
        b.iter(|| reference.march(black_box(&start), 1).expect("it marches"));
    });
    group.finish();
}

criterion_group!(benches, by_modes, forty_modes);
criterion_main!(benches);
