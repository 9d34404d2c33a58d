//! How large are the errors of the kernels? Comparison with the integrator in extended precision with some 30 digits:
//! states and event times of single mesh cycles.

#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::{Events, advance_with, settled, volterra};
use gearatlas::analysis::EnergyNorm;
use gearatlas::model::{Model, TrajectoryState};
use gearatlas::reference::{Extended, ExtendedPassage, Reference};

/// Error of a state in the energy norm, in half gaps.
fn error(model: &Model, exact: &ExtendedPassage, state: &[f64]) -> f64 {
    let norm = EnergyNorm::new(model);
    norm.length(&exact.difference(state)) / norm.unit()
}

/// Drives in rattle, and the number of cycles for each.
fn drives() -> [(&'static str, Model, u64); 3] {
    [
        ("one degree", common::model(&common::one_degree()), 40),
        ("six modes", common::model(&common::six_modes()), 40),
        ("forty modes", common::model(&common::forty_modes()), 40),
    ]
}

/// The extended trajectory of every cycle, each from a kernel's own state.
fn follow(model: &Model, cycles: u64, mut each: impl FnMut(&TrajectoryState, &ExtendedPassage)) {
    let extended = Extended::new(model);
    let mut start = settled(model, 40);
    for _ in 0..cycles {
        let exact = extended.advance(&start, 1).unwrap();
        each(&start, &exact);
        start = exact.end();
    }
}

#[test]
fn one_cycle_of_the_structured_kernel_is_exact_to_round_off() {
    for (name, model, cycles) in drives() {
        let kernel = volterra(&model);
        let (mut state, mut time, mut events) = (0.0f64, 0.0f64, 0);
        follow(&model, cycles, |start, exact| {
            let mut seen = Events::default();
            let (end, _) = advance_with(&kernel, start, 1, &mut seen);
            assert_eq!(seen.0.len(), exact.crossings.len(), "{name}");
            for (a, b) in seen.0.iter().zip(&exact.crossings) {
                assert_eq!((a.from, a.to), (b.from, b.to), "{name}");
                let late = (a.time - b.time.value()) - b.time.rest();
                time = time.max(late.abs() / model.period());
            }
            state = state.max(error(&model, exact, &end.state));
            events += seen.0.len();
        });
        println!("{name}: state {state:.1e}, event time {time:.1e}, {events} events");
        assert!(events as u64 > cycles, "{name} does not rattle");
        assert!(state < 1e-13, "{name}: {state:e}");
        assert!(time < 1e-14, "{name}: {time:e}");
    }
}

/// Measures the error of the reference integrator that other tests use.
#[test]
fn one_cycle_of_the_reference_is_exact_to_round_off() {
    for (name, model, _) in drives() {
        let reference = Reference::new(&model);
        let mut state = 0.0f64;
        follow(&model, 4, |start, exact| {
            let passage = reference.advance(start, 1).unwrap();
            assert_eq!(passage.crossings.len(), exact.crossings.len(), "{name}");
            state = state.max(error(&model, exact, &passage.end.state));
        });
        println!("{name}: {state:.1e}");
        assert!(state < 1e-13, "{name}: {state:e}");
    }
}

/// Steps of another length give the same 25 digits on a rattling drive with all inputs.
#[test]
fn extended_trajectory_does_not_depend_on_its_steps() {
    for (name, model, _) in drives() {
        let start = settled(&model, 40);
        let usual = Extended::new(&model).advance(&start, 5).unwrap();
        let other = Extended::new(&model).refined(2).advance(&start, 5).unwrap();
        assert!(!usual.crossings.is_empty(), "{name} does not rattle");
        let difference: Vec<f64> = usual
            .state
            .iter()
            .zip(&other.state)
            .map(|(a, b)| (*a - *b).value())
            .collect();
        let norm = EnergyNorm::new(&model);
        let error = norm.length(&difference) / norm.unit();
        println!("{name}: {error:.1e}");
        assert!(error < 1e-25, "{name}: {error:e}");
    }
}
