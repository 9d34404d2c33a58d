//! Do the table kernels march the same system as the structured kernel and the reference?

#![allow(clippy::unwrap_used)]

mod common;

use atlas::model::Model;
use atlas::propagate::{Counters, Dyadic, Hermite, Kernel, Spectral};
use atlas::reference::Reference;
use common::march::{Events, march, march_with, settled, volterra};
use common::{drives, state_difference};

/// Unit steps a mesh cycle, as published.
const CELLS: u32 = 60;

/// Follows a rattling drive beside the reference, every cycle from the reference's own start:
/// worst difference of states, of event times in cycles, work done.
fn beside_reference<K: Kernel>(model: &Model, kernel: &K, cycles: u64) -> (f64, f64, Counters) {
    let reference = Reference::new(model);
    let mut start = settled(model, 40);
    let (mut state, mut time, mut work) = (0.0f64, 0.0f64, Counters::default());
    for _ in 0..cycles {
        let exact = reference.march(&start, 1).unwrap();
        let mut seen = Events::default();
        let (end, counters) = march_with(kernel, &start, 1, &mut seen);
        assert_eq!(seen.0.len(), exact.crossings.len());
        for (a, b) in seen.0.iter().zip(&exact.crossings) {
            assert_eq!((a.cycle, a.from, a.to), (b.cycle, b.from, b.to));
            time = time.max((a.time - b.time).abs() / model.period());
        }
        state = state.max(state_difference(model, &end.state, &exact.end.state));
        work += counters;
        start = march(&volterra(model), &start, 1);
    }
    (state, time, work)
}

fn hold<K: Kernel>(name: &str, model: &Model, kernel: &K) {
    let (state, time, work) = beside_reference(model, kernel, 12);
    println!(
        "{name}: state {state:.1e}, time {time:.1e}, a cycle {:.1} products, {:.1} guards, {:.1} events",
        work.matvecs as f64 / 12.0,
        work.guard_evaluations as f64 / 12.0,
        work.events as f64 / 12.0,
    );
    assert!(state < 1e-12 && time < 1e-13, "{name}: {state:e} {time:e}");
    assert!(work.events >= 8, "{name} does not rattle");
}

#[test]
fn one_cycle_is_that_of_the_reference() {
    for (name, case) in drives() {
        let model = common::model(&case);
        hold(
            &format!("{name}, dyadic"),
            &model,
            &Dyadic::new(&model, CELLS, 1000).unwrap(),
        );
        let spectral = Spectral::new(&model, CELLS, 1000, None).unwrap();
        println!("{:?}", spectral.conditioning());
        hold(&format!("{name}, spectral"), &model, &spectral);
        hold(
            &format!("{name}, hermite"),
            &model,
            &Hermite::new(&model, CELLS, 1000).unwrap(),
        );
    }
}
