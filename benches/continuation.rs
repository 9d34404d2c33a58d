//! Time of one orbit along a branch: for an oscillator with a stop, and for the drive of flex80 with forty modes,
//! including everything (models, tables, Newton's method, multipliers, details, repeated steps, bifurcations).
//!
//! ```text
//! cargo bench --bench continuation
//! ```

// Criterion's macros generate undocumented items; a bench may unwrap, like a test.
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

#[path = "../tests/common/stopped.rs"]
mod stopped;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use gearatlas::analysis::continuation::branch::{Branch, StepSettings, follow};
use gearatlas::analysis::continuation::drive::{DriveMap, ParametricDrive};
use gearatlas::analysis::continuation::orbit::Orbit;
use gearatlas::analysis::continuation::path::Span;
use gearatlas::analysis::continuation::search::{OrbitSearchSettings, orbits};
use gearatlas::manifest;
use gearatlas::model::InitialState;
use gearatlas::store::TableStore;
use gearatlas::sweep::{PointFamily, Prepared};
use std::path::Path;
use stopped::{PUBLISHED, Stopped};

const SEARCH: OrbitSearchSettings = OrbitSearchSettings {
    transient: 2000,
    cycles: 10,
    longest: 2,
    guesses: 1,
    initial: InitialState::Static,
};

/// The branch over `span` through the orbit `first`.
fn branch<F: ParametricDrive>(family: &F, span: &Span, first: &Orbit) -> Branch {
    let mut map = DriveMap::new(family, first.at).unwrap();
    follow(&mut map, span, first.clone(), &StepSettings::default()).unwrap()
}

fn measure<F: ParametricDrive>(
    c: &mut Criterion,
    name: &str,
    family: &F,
    at: [f64; 2],
    period: u32,
    span: &Span,
) {
    let mut map = DriveMap::new(family, at).unwrap();
    let found = orbits(&mut map, at, &SEARCH).unwrap();
    let first = found.iter().find(|orbit| orbit.period == period).unwrap();
    let whole = branch(family, span, first);
    let count = whole.orbits.len();
    let steps: u32 = whole.orbits.iter().map(|orbit| orbit.steps).sum();
    println!(
        "{name}: {count} orbits, {:.2} Newton steps each, {} steps refused, {} bifurcations",
        f64::from(steps) / count as f64,
        whole.rejected,
        whole.bifurcations.len()
    );
    let mut group = c.benchmark_group("continuation");
    group.sample_size(10);
    group.throughput(Throughput::Elements(count as u64));
    group.bench_function(name, |b| b.iter(|| branch(family, span, first)));
    group.finish();
}

fn all(c: &mut Criterion) {
    let span = Span {
        axis: 0,
        from: 0.8,
        to: 0.85,
    };
    let family = Stopped {
        damping: 0.01,
        stop: 29.0,
        whirls: false,
    };
    measure(
        c,
        "oscillator with a stop",
        &family,
        [0.82, PUBLISHED],
        2,
        &span,
    );
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("manifests/flex80.toml");
    let job = manifest::load(&manifest).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let parts = Prepared::new(TableStore::open(folder.path()));
    let point = job.points.at(35);
    let speed = job.between.parameter(&point, "speed").unwrap();
    let family = PointFamily::new(point, vec![speed], &job.between, &parts);
    let span = Span {
        axis: 0,
        from: 600.0,
        to: 1500.0,
    };
    measure(c, "forty modes", &family, [750.0, 0.0], 1, &span);
}

criterion_group!(benches, all);
criterion_main!(benches);
