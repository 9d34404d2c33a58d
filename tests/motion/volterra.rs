//! Is the structured kernel exact? Comparison with the reference integrator, with the small-step kernel, and with
//! itself on other windows and other instruction sets.

#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::{
    Events, ROUND_OFF, advance, advance_with, mean_equilibrium, settled, volterra,
};
use common::skipped::skipped;
use common::{drives, relative_difference, state_difference};
use gearatlas::model::{Division, MeshHarmonic, Model, TrajectoryState};
use gearatlas::propagate::{InstructionSet, Kernel, Volterra};
use gearatlas::reference::{Passage, Reference};

/// Differences of two integrations over the same time.
#[derive(Debug, Clone, Copy, Default)]
struct Difference {
    /// Relative difference of the final states.
    state: f64,
    /// Difference of event times, in mesh cycles.
    time: f64,
    /// Number of events.
    events: usize,
}

impl Difference {
    fn worst(self, other: Self) -> Self {
        Self {
            state: self.state.max(other.state),
            time: self.time.max(other.time),
            events: self.events + other.events,
        }
    }
}

/// Compares the kernel with the reference; `None` if the sequences of events differ.
fn compare<K: Kernel>(
    model: &Model,
    kernel: &K,
    start: &TrajectoryState,
    exact: &Passage,
) -> Option<Difference> {
    let mut seen = Events::default();
    let cycles = exact.end.cycle - start.cycle;
    let (end, counters) = advance_with(kernel, start, cycles, &mut seen);
    assert_eq!(counters.events, seen.0.len() as u64);
    assert_eq!(end.cycle, exact.end.cycle);
    let same = seen.0.len() == exact.crossings.len()
        && end.contact == exact.end.contact
        && seen
            .0
            .iter()
            .zip(&exact.crossings)
            .all(|(a, b)| (a.cycle, a.from, a.to) == (b.cycle, b.from, b.to));
    let time = seen
        .0
        .iter()
        .zip(&exact.crossings)
        .map(|(a, b)| (a.time - b.time).abs() / model.period())
        .fold(0.0, f64::max);
    same.then(|| Difference {
        state: state_difference(model, &end.state, &exact.end.state),
        time,
        events: seen.0.len(),
    })
}

/// Follows a rattling drive for some cycles, every one from the kernel's own state.
fn follow(model: &Model, cycles: u64) -> Difference {
    let (kernel, reference) = (volterra(model), Reference::new(model));
    let mut start = settled(model, 40);
    let mut worst = Difference::default();
    for _ in 0..cycles {
        let exact = reference.advance(&start, 1).unwrap();
        let one = compare(model, &kernel, &start, &exact).expect("the same events");
        worst = worst.worst(one);
        start = advance(&kernel, &start, 1);
    }
    worst
}

#[test]
fn one_cycle_is_that_of_the_reference() {
    for (name, case) in drives() {
        for load in [0.05, 0.3] {
            let mut case = case.clone();
            case.2.load = load;
            let worst = follow(&common::model(&case), 12);
            println!("{name}, load {load}: {worst:?}");
            assert!(worst.events >= 8, "{name} at load {load} does not rattle");
            assert!(worst.state < 1e-13, "{name} at load {load}: {worst:?}");
            assert!(worst.time < 1e-14, "{name} at load {load}: {worst:?}");
        }
    }
}

/// The mesh may have a different stiffness in every division, or one for all.
#[test]
fn mesh_may_have_sixty_levels_or_one() {
    let (structure, mut drive, point) = common::six_modes();
    let smooth = |i: u32| 4e8 * (1.0 + 0.2 * (f64::from(i) * std::f64::consts::TAU / 60.0).sin());
    for (segments, stiffness) in [
        (60, (0..60).map(smooth).collect::<Vec<_>>()),
        (1, vec![4e8]),
        (1, vec![4e8; 60]),
        (3, vec![4e8, 4e8, 3e8, 3.5e8, 3.5e8, 3.5e8, 3.5e8]),
    ] {
        drive.mesh = Division::levels(&stiffness, &[]);
        let model = Model::new(&structure, &drive, point).unwrap();
        assert_eq!(model.first_cycle().segments.len(), segments);
        let worst = follow(&model, 8);
        println!("{segments} segments: {worst:?}");
        assert!(worst.events >= 8);
        assert!(worst.state < 1e-13 && worst.time < 1e-13, "{worst:?}");
    }
}

/// Windows that are many times shorter change only round-off, and so does the coarsest setting, whose windows are as
/// long as the exponential series allow.
#[test]
fn windows_of_any_length_give_the_same() {
    for (name, case) in drives() {
        let model = common::model(&case);
        let start = settled(&model, 40);
        let usual = volterra(&model);
        let fine = Volterra::new(&model, 1e-60, 10_000);
        let coarse = Volterra::new(&model, 1e-6, 10_000);
        let windows = [&coarse, &usual, &fine].map(Volterra::windows_per_cycle);
        assert!(windows[0] <= windows[1], "{windows:?}");
        assert!(windows[2] >= 5 * windows[1], "{windows:?}");
        let ends = [&coarse, &usual, &fine].map(|kernel| advance(kernel, &start, 1));
        let shorter = relative_difference(&ends[2].state, &ends[1].state);
        let longest = relative_difference(&ends[0].state, &ends[1].state);
        println!("{name}: windows {windows:?}, shorter {shorter:.1e}, longest {longest:.1e}");
        assert!(shorter < 1e-11, "{name}: {shorter:e}");
        assert!(longest < 1e-10, "{name}: {longest:e}");
    }
}

#[test]
fn instruction_sets_agree_within_rounding() {
    let sets = InstructionSet::available();
    assert_eq!(sets[0], InstructionSet::PORTABLE);
    assert_eq!(sets.last(), Some(&InstructionSet::best()));
    let names: Vec<_> = sets.iter().map(|set| set.name()).collect();
    for missing in ["avx2", "avx512"] {
        if !names.contains(&missing) {
            skipped(format!("{missing}, which this processor does not have"));
        }
    }
    for (name, case) in drives() {
        let model = common::model(&case);
        let mut start = settled(&model, 40);
        for _ in 0..10 {
            let ends: Vec<_> = sets
                .iter()
                .map(|&set| {
                    let kernel = Volterra::with_instructions(&model, ROUND_OFF, 10_000, set);
                    advance(&kernel, &start, 1)
                })
                .collect();
            for (set, end) in sets.iter().zip(&ends).skip(1) {
                assert_eq!(end.contact, ends[0].contact);
                let difference = relative_difference(&end.state, &ends[0].state);
                assert!(difference < 1e-11, "{name}, {}: {difference:e}", set.name());
            }
            start = ends[0].clone();
        }
    }
}

/// One instruction set gives the same bits after any earlier use of the workspace.
#[test]
fn integrating_is_repeatable_to_the_bit() {
    let model = common::model(&common::six_modes());
    let kernel = volterra(&model);
    let start = settled(&model, 40);
    let whole = advance(&kernel, &start, 30);
    let half = advance(&kernel, &start, 15);
    assert_eq!(advance(&kernel, &half, 15), whole);
}

/// Work of a fixed case on the portable path. Any difference comes from a change of the algorithm; `cargo insta review`
/// accepts it.
#[test]
fn work_of_a_fixed_case_is_known() {
    let model = common::model(&common::six_modes());
    let kernel = Volterra::with_instructions(&model, ROUND_OFF, 100, InstructionSet::PORTABLE);
    let start = mean_equilibrium(&model);
    let (_, counters) = advance_with(&kernel, &start, 6, &mut ());
    insta::assert_debug_snapshot!(counters, @r"
    Counters {
        cycles: 6,
        windows: 38,
        partial_windows: 17,
        certified: 24,
        bisections: 4,
        newton_steps: 16,
        events: 9,
        grazings: 0,
        tangent_windows: 0,
        factorised: 0,
        matvecs: 0,
        guard_evaluations: 0,
    }
    ");
}

mod random_drives {
    use super::*;
    use gearatlas::model::{Drive, DriveShaft, OperatingPoint, Release, TorqueRipple};
    use gearatlas::structure::ModalStructure;
    use proptest::collection::vec;
    use proptest::prelude::*;

    fn structures() -> impl Strategy<Value = ModalStructure> {
        let modes = prop_oneof![1..=3usize, 4..=12usize, 13..=40usize];
        (modes, 0..=2usize, 0.0..=4.0f64, 0.0..0.3f64).prop_flat_map(
            |(n, rigid, decades, ratio)| {
                let gains = || vec(-1.0..1.0f64, n);
                (vec(0.0..1.0f64, n), gains(), gains(), gains(), gains()).prop_map(
                    move |(place, mesh, torque, friction, ripple)| {
                        let frequency: Vec<f64> = (0..n)
                            .map(|i| {
                                let slow = 600.0;
                                if i < rigid { 0.0 } else { slow * 10f64.powf(decades * place[i]) }
                            })
                            .collect();
                        let mut s = common::structure(&frequency, ratio, &mesh, &torque);
                        s.friction = friction;
                        s.pinion_torque = Some(ripple.iter().map(|p| 10.0 * p).collect());
                        s
                    },
                )
            },
        )
    }

    fn meshes() -> impl Strategy<Value = Drive> {
        let stiffness = prop_oneof![
            vec(1e8..5e8f64, 1),
            vec(1e8..5e8f64, 5),
            (1e8..5e8f64, 1e8..5e8f64, 1..59usize)
                .prop_map(|(a, b, cut)| { (0..60).map(|i| if i < cut { a } else { b }).collect() }),
        ];
        (
            (2e-6..30e-6f64, stiffness, 0.0..3000.0f64, 0.0..0.2f64),
            vec((1..6u32, 0.0..8e-6f64, -3.0..3.0f64), 0..3),
            vec((0.3..40.0f64, 0.0..3.0f64, -3.0..3.0f64), 0..2),
        )
            .prop_map(
                |((half_gap, stiffness, damping, friction), error, ripple)| Drive {
                    coast: None,
                    half_gap,
                    mesh: Division::levels(&stiffness, &[]),
                    damping,
                    friction,
                    release: Release::Deflection,
                    transmission_error: (error.into_iter())
                        .map(|(harmonic, amplitude, phase)| {
                            MeshHarmonic::new(harmonic, amplitude, phase)
                        })
                        .collect(),
                    torque_ripple: ripple
                        .into_iter()
                        .map(|(order, amplitude, phase)| TorqueRipple {
                            shaft: DriveShaft::Pinion,
                            order,
                            amplitude,
                            phase,
                        })
                        .collect(),
                    further: Vec::new(),
                    imposed_motion: Vec::new(),
                    tooth_cycles: Default::default(),
                    film: None,
                },
            )
    }

    proptest! {
        #![proptest_config(ProptestConfig {
            cases: 96,
            max_global_rejects: 10,
            failure_persistence: None,
            ..ProptestConfig::default()
        })]

        #[test]
        fn one_cycle_is_that_of_the_reference(
            structure in structures(),
            drive in meshes(),
            load in -1.0..1.0f64,
            speed in 200.0..3000.0f64,
        ) {
            let point = OperatingPoint { load, speed };
            let model = Model::new(&structure, &drive, point).unwrap();
            let kernel = volterra(&model);
            let start = advance(&kernel, &mean_equilibrium(&model), 5);
            let exact = Reference::new(&model).advance(&start, 1).unwrap();
            let found = compare(&model, &kernel, &start, &exact);
            // A grazing within round-off may fall on either side.
            prop_assume!(found.is_some());
            let found = found.unwrap();
            prop_assert!(found.state < 1e-9, "{found:?}");
        }
    }
}
