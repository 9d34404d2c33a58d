//! Cycles of constant contact skipped at once, compared with step-by-step integration.

use crate::common::advance::{advance, mean_equilibrium};
use crate::common::{Case, state_difference};
use gearatlas::analysis::ContactJumps;
use gearatlas::model::{Model, TrajectoryState};
use gearatlas::propagate::{Counters, Kernel};

/// The drive below its resonance, with little error, under a load that keeps it in contact.
pub fn loaded(mut case: Case) -> Case {
    (case.2.load, case.2.speed) = (3.0, 400.0);
    for harmonic in &mut case.1.transmission_error {
        harmonic.amplitude *= 0.2;
    }
    case
}

/// Skips cycles like a trace; also returns the number of skipped cycles.
pub fn skip<K: Kernel>(
    model: &Model,
    kernel: &K,
    start: &TrajectoryState,
    cycles: u64,
) -> (TrajectoryState, u64) {
    let mut jumps = ContactJumps::new(model);
    let mut workspace = kernel.workspace();
    let (mut trajectory, mut counters) = (start.clone(), Counters::default());
    let (mut left, mut jumped) = (cycles, 0);
    while left > 0 {
        let leap = jumps.jump(kernel, &mut trajectory, left, &mut workspace);
        (jumped, left) = (jumped + leap, left - leap);
        if left > 0 {
            kernel
                .advance(1, &mut trajectory, &mut workspace, &mut (), &mut counters)
                .unwrap();
            jumps.count_integrated_cycle();
            left -= 1;
        }
    }
    assert_eq!(trajectory.cycle, start.cycle + cycles);
    (trajectory, jumped)
}

/// Skipping reaches the state of integration, and skips most cycles.
pub fn agrees<K: Kernel>(name: &str, model: &Model, kernel: &K, cycles: u64) {
    let start = mean_equilibrium(model);
    let (found, jumped) = skip(model, kernel, &start, cycles);
    assert!(jumped > cycles / 2, "{name}: {jumped} of {cycles}");
    let marched = advance(kernel, &start, cycles);
    assert_eq!(found.contact, marched.contact);
    let off = state_difference(model, &found.state, &marched.state);
    assert!(off < 1e-11, "{name}: {off:e}");
}
