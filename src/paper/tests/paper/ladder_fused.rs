//! Runs of cells, whole cycles and millions of cycles in one product: do they equal integration, and how much work do
//! they save?

#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::{Events, advance, advance_with, mean_equilibrium, settled, volterra};
use common::{drives, relative_difference, state_difference};
use gearatlas::model::{Division, InitialState, Model, OperatingPoint, TrajectoryState};
use gearatlas::propagate::{Counters, Kernel, Tangents};
use gearatlas_paper::kernels::{Dyadic, Fused, Hermite, PowerJumps, Spectral};

/// Unit steps per mesh cycle, as published.
const CELLS: u32 = 60;

#[test]
fn fused_runs_are_the_cells_they_stand_for() {
    for (name, case) in drives() {
        let model = common::model(&case);
        let fused = Fused::new(&model, CELLS, 1000).unwrap();
        let spectral = Spectral::new(&model, CELLS, 1000, None).unwrap();
        let mut start = settled(&model, 40);
        let (mut saved, mut worst) = (0, 0.0f64);
        for _ in 0..20 {
            let (mut fast, mut slow) = (Events::default(), Events::default());
            let (end, few) = advance_with(&fused, &start, 1, &mut fast);
            let (exact, many) = advance_with(&spectral, &start, 1, &mut slow);
            assert_eq!(fast.0.len(), slow.0.len());
            saved += many.matvecs - few.matvecs;
            worst = worst.max(state_difference(&model, &end.state, &exact.state));
            start = exact;
        }
        println!(
            "{name}: {worst:.1e}, {} products saved a cycle",
            saved as f64 / 20.0
        );
        assert!(worst < 1e-13, "{name}: {worst:e}");
        assert!(saved > 20 * 10, "{name}: {saved} products saved");
    }
}

/// Drives in constant contact: light excitation under full load.
fn quiet() -> Vec<(&'static str, Model)> {
    drives()
        .into_iter()
        .map(|(name, (structure, mut drive, point))| {
            for harmonic in &mut drive.transmission_error {
                harmonic.amplitude *= 0.002;
            }
            drive.mesh = Division::levels(&[3.4e8, 3.333e8], &[0.6]);
            for ripple in &mut drive.torque_ripple {
                ripple.amplitude *= 0.1;
            }
            let point = OperatingPoint { load: 1.0, ..point };
            (name, Model::new(&structure, &drive, point).unwrap())
        })
        .collect()
}

/// A settled cycle of contact takes one product, with the same state as the kernel `volterra`.
#[test]
fn a_cycle_of_contact_is_one_product() {
    for (name, model) in quiet() {
        let fused = Fused::new(&model, CELLS, 1000).unwrap();
        let start = settled(&model, 2000);
        let (end, work) = advance_with(&fused, &start, 50, &mut ());
        assert_eq!((work.matvecs, work.events), (50, 0), "{name}");
        let off = state_difference(
            &model,
            &end.state,
            &advance(&volterra(&model), &start, 50).state,
        );
        println!("{name}: {off:.1e}");
        assert!(off < 1e-12, "{name}: {off:e}");
        // Tangents use the same map.
        let mut tangents = [
            Tangents::zeros(model.modes(), 1),
            Tangents::zeros(model.modes(), 1),
        ];
        for tangent in &mut tangents {
            tangent.vector_mut(0)[0] = 1.0;
        }
        let [a, b] = &mut tangents;
        step(&fused, &mut start.clone(), a);
        step(&volterra(&model), &mut start.clone(), b);
        let off = relative_difference(a.vector(0), b.vector(0));
        assert!(off < 1e-11, "{name}: {off:e}");
    }
}

fn step<K: Kernel>(kernel: &K, trajectory: &mut TrajectoryState, tangents: &mut Tangents) {
    let (mut workspace, mut counters) = (kernel.workspace(), Counters::default());
    kernel
        .advance_cycle(trajectory, tangents, &mut workspace, &mut (), &mut counters)
        .unwrap();
}

/// A million cycles by twenty products equal a million integrated cycles. The free rotation accumulates the
/// round-off of a million integration steps; in all other components it decays.
#[test]
fn a_jump_is_the_integration_it_stands_for() {
    let cycles = 1_000_000;
    for (name, model) in quiet().into_iter().take(3) {
        let mut jumps = PowerJumps::new(&model, cycles).unwrap();
        let start = settled(&model, 100);
        let fused = Fused::new(&model, CELLS, 1000).unwrap();
        let integrated = advance(&fused, &start, cycles);
        let mut jumped = start.clone();
        let products = jumps.jump(&mut jumped, cycles);
        assert!(products <= 20, "{products} products");
        assert_eq!(jumped.cycle, integrated.cycle);
        let n = model.modes();
        let projected = |state: &[f64]| -> Vec<f64> {
            let kept = (0..2 * n).filter(|i| !model.neutral.contains(&(i % n)));
            kept.map(|i| state[i]).collect()
        };
        let off = relative_difference(&projected(&jumped.state), &projected(&integrated.state));
        let drift = relative_difference(&jumped.state, &integrated.state);
        println!("{name}: {off:.1e}, with the neutral rotation {drift:.1e}");
        assert!(off < 1e-10 && drift < 1e-9, "{name}: {off:e}, {drift:e}");
        // Any number of cycles is a sum of powers of two.
        let mut parts = start.clone();
        for part in [1, 2, 4, 393, 999_600] {
            jumps.jump(&mut parts, part);
        }
        let off = relative_difference(&projected(&parts.state), &projected(&jumped.state));
        assert!(off < 1e-11, "{name}: {off:e}");
    }
}

#[test]
fn a_flight_is_not_jumped() {
    let model = common::model(&common::one_degree());
    let mut start = model.start(&InitialState::Rest);
    let before = start.clone();
    assert_eq!(PowerJumps::new(&model, 8).unwrap().jump(&mut start, 8), 0);
    assert_eq!(start, before);
}

/// Work of a fixed case. Instruction sets differ only in rounding, which changes no decision here. Any difference comes
/// from a change of an algorithm.
#[test]
fn work_of_a_fixed_case_is_known() {
    let model = common::model(&common::six_modes());
    let start = mean_equilibrium(&model);
    let work = |counters: Counters| {
        [
            counters.matvecs,
            counters.guard_evaluations,
            counters.events,
        ]
    };
    let dyadic = Dyadic::new(&model, CELLS, 100).unwrap();
    let hermite = Hermite::new(&model, CELLS, 100).unwrap();
    let spectral = Spectral::new(&model, CELLS, 100, None).unwrap();
    let fused = Fused::new(&model, CELLS, 100).unwrap();
    let found = [
        work(advance_with(&dyadic, &start, 6, &mut ()).1),
        work(advance_with(&hermite, &start, 6, &mut ()).1),
        work(advance_with(&spectral, &start, 6, &mut ()).1),
        work(advance_with(&fused, &start, 6, &mut ()).1),
    ];
    insta::assert_debug_snapshot!(found);
    // `hermite` needs fewer products than `dyadic`, because rows replace some, and `fused` fewer than `spectral`.
    assert!(found[0][0] > found[1][0] && found[2][0] > found[3][0]);
}
