//! Do the table kernels integrate the same system as the kernel `volterra` and the reference integrator?

#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::{Events, advance, advance_with, settled, volterra};
use common::{Case, drives, relative_difference, state_difference};
use gearatlas::model::{Division, Drive, MeshHarmonic, Model, OperatingPoint, TrajectoryState};
use gearatlas::propagate::{Counters, Kernel, Stepping, Stop, TableError, Tangents};
use gearatlas::reference::Reference;
use gearatlas_paper::kernels::{DenseError, Dyadic, Fused, Hermite, Spectral};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use std::f64::consts::TAU;

/// Unit steps per mesh cycle, as published.
const CELLS: u32 = 60;

/// All table kernels of a model.
struct Ladder<'m> {
    dyadic: Dyadic<'m>,
    hermite: Hermite<'m>,
    spectral: Spectral<'m>,
    fused: Fused<'m>,
}

impl<'m> Ladder<'m> {
    fn new(model: &'m Model, cells: u32) -> Result<Self, DenseError> {
        Ok(Self {
            dyadic: Dyadic::new(model, cells, 1000)?,
            hermite: Hermite::new(model, cells, 1000)?,
            spectral: Spectral::new(model, cells, 1000, None)?,
            fused: Fused::new(model, cells, 1000)?,
        })
    }
}

/// Evaluates one expression for every kernel of a [`Ladder`].
macro_rules! each {
    ($ladder:expr, $name:ident, $kernel:ident => $body:expr) => {{
        let ladder = $ladder;
        for $name in ["dyadic", "hermite", "spectral", "fused"] {
            match $name {
                "dyadic" => {
                    let $kernel = &ladder.dyadic;
                    $body
                }
                "hermite" => {
                    let $kernel = &ladder.hermite;
                    $body
                }
                "spectral" => {
                    let $kernel = &ladder.spectral;
                    $body
                }
                _ => {
                    let $kernel = &ladder.fused;
                    $body
                }
            }
        }
    }};
}

/// Compares a kernel with the reference on a rattling drive, cycle by cycle from a common start.
fn hold<K: Kernel>(name: &str, model: &Model, kernel: &K) {
    let reference = Reference::new(model);
    let mut start = settled(model, 40);
    let (mut state, mut time, mut work) = (0.0f64, 0.0f64, Counters::default());
    for _ in 0..12 {
        let exact = reference.advance(&start, 1).unwrap();
        let mut observed = Events::default();
        let (end, counters) = advance_with(kernel, &start, 1, &mut observed);
        assert_eq!(observed.0.len(), exact.crossings.len(), "{name}");
        for (a, b) in observed.0.iter().zip(&exact.crossings) {
            assert_eq!((a.cycle, a.from, a.to), (b.cycle, b.from, b.to));
            time = time.max((a.time - b.time).abs() / model.period());
        }
        state = state.max(state_difference(model, &end.state, &exact.end.state));
        work += counters;
        start = end;
    }
    assert!(state < 5e-13 && time < 1e-13, "{name}: {state:e} {time:e}");
    assert!(work.events >= 8, "{name} does not rattle");
}

#[test]
fn one_cycle_is_that_of_the_reference() {
    for (drive, case) in drives() {
        let model = common::model(&case);
        let ladder = Ladder::new(&model, CELLS).unwrap();
        each!(&ladder, name, kernel => hold(&format!("{drive}, {name}"), &model, kernel));
    }
}

/// The load moves along the face and friction changes its direction: δ jumps between segments.
fn wandering() -> Vec<Division> {
    (0..12)
        .map(|i| {
            let phase = (f64::from(i) + 0.5) / 12.0;
            Division {
                load_centre: 4e-3 * (TAU * phase).sin(),
                friction: [if phase < 0.6 { 1.0 } else { -1.0 }, 6e-3 * (phase - 0.5)],
                ..Division::level(
                    f64::from(i + 1) / 12.0,
                    4e8 * (1.0 + 0.1 * (TAU * phase).cos()),
                )
            }
        })
        .collect()
}

/// Drives with a mesh force of changing direction, also with coarse and uneven cells.
#[test]
fn steps_of_the_deflection_are_those_of_the_reference() {
    let mut six = common::six_modes();
    six.0.mesh_tilt = vec![0.0, 0.0, 4.0, -3.0, 6.0, -2.0];
    six.0.friction_lever = vec![3.0, 1.0, -4.0, 2.0, 5.0, 1.0];
    for (structure, drive, point) in [six, common::forty_modes()] {
        let mesh = wandering();
        let drive = Drive {
            mesh,
            friction: 0.1,
            ..drive
        };
        let model = Model::new(&structure, &drive, point).unwrap();
        for cells in [1, 17, 60] {
            let ladder = Ladder::new(&model, cells).unwrap();
            each!(&ladder, name, kernel => hold(&format!("{cells} cells, {name}"), &model, kernel));
        }
    }
}

/// Compares the tangents of one cycle with those of `volterra`.
#[test]
fn tangents_are_those_of_the_structured_kernel() {
    for (drive, case) in drives() {
        let model = common::model(&case);
        let n = model.modes();
        let ladder = Ladder::new(&model, CELLS).unwrap();
        let start = settled(&model, 41);
        let mut exact = Tangents::zeros(n, 3);
        for (index, component) in [0, n - 1, 2 * n - 1].into_iter().enumerate() {
            exact.vector_mut(index)[component] = 1.0;
        }
        let seed = exact.clone();
        let go = |tangents: &mut Tangents, kernel: &dyn Fn(&mut TrajectoryState, &mut Tangents)| {
            kernel(&mut start.clone(), tangents);
        };
        go(&mut exact, &|trajectory, tangents| {
            let kernel = volterra(&model);
            let (mut w, mut c) = (kernel.workspace(), Counters::default());
            kernel
                .advance_cycle(trajectory, tangents, &mut w, &mut (), &mut c)
                .unwrap();
        });
        each!(&ladder, name, kernel => {
            let mut found = seed.clone();
            go(&mut found, &|trajectory, tangents| {
                let (mut w, mut c) = (kernel.workspace(), Counters::default());
                kernel.advance_cycle(trajectory, tangents, &mut w, &mut (), &mut c).unwrap();
                assert!(c.tangent_windows > 0);
            });
            for index in 0..3 {
                let off = relative_difference(found.vector(index), exact.vector(index));
                assert!(off < 1e-11, "{drive}, {name}: {off:e}");
            }
        });
    }
}

/// Any drive: one to forty modes, rates over four decades, nearly rigid modes, friction,
/// misalignment, loads, gaps.
fn any_case() -> impl Strategy<Value = Case> {
    let mode = (
        prop_oneof![
            1 => Just(0.0),
            1 => -3.0..0.0f64,
            8 => 1.3..5.3f64,
        ],
        -1.0..1.0f64,
        -8.0..8.0f64,
        -0.5..0.5f64,
    );
    (
        prop::collection::vec(mode, 1..=40),
        0.002..0.05f64,
        (0.02..1.5f64, 300.0..3000.0f64),
        (3e-6..3e-5f64, 0.0..0.3f64, 0.0..3000.0f64),
        prop::collection::vec((2.0..6.0f64, -4.0..4.0f64, -1.0..1.0f64), 1..5),
        (0.5e-6..1e-5f64, 1u32..4),
    )
        .prop_map(
            |(modes, ratio, (load, speed), (gap, friction, damping), mesh, (te, harmonic))| {
                // At least one rigid rotation, so that the load moves something.
                let frequency: Vec<f64> = (modes.iter().enumerate())
                    .map(
                        |(i, mode)| {
                            if mode.0 == 0.0 || i == 0 { 0.0 } else { 10f64.powf(mode.0) }
                        },
                    )
                    .collect();
                let count = frequency.len();
                let size = (count as f64).sqrt().recip();
                let weights: Vec<f64> = (modes.iter().enumerate())
                    .map(|(i, mode)| if i == 0 { 1.0 } else { size * mode.1 })
                    .collect();
                // A torque would displace a nearly rigid mode by kilometres.
                let torque: Vec<f64> = (frequency.iter().zip(&weights))
                    .map(|(f, w)| if (1e-9..20.0).contains(f) { 0.0 } else { *w })
                    .collect();
                let mut structure = common::structure(&frequency, ratio, &weights, &torque);
                let rigid = |i: usize| frequency[i] == 0.0;
                structure.mesh_tilt = (0..count)
                    .map(|i| if rigid(i) { 0.0 } else { size * modes[i].2 })
                    .collect();
                structure.friction = modes.iter().map(|mode| size * mode.3).collect();
                let parts = mesh.len() as f64;
                let drive = Drive {
                    mesh: (mesh.iter().enumerate())
                        .map(|(i, &(level, centre, turn))| Division {
                            load_centre: 1e-3 * centre,
                            friction: [turn, 0.0],
                            ..Division::level((i + 1) as f64 / parts, 1e8 * level)
                        })
                        .collect(),
                    damping,
                    friction,
                    transmission_error: vec![MeshHarmonic::new(harmonic, te, 0.4)],
                    ..common::two_level_mesh(gap)
                };
                (structure, drive, OperatingPoint { load, speed })
            },
        )
}

/// The end of a cycle and its number of events.
fn cycle<K: Kernel>(
    kernel: &K,
    start: &TrajectoryState,
) -> Result<(TrajectoryState, Events), Stop> {
    let (mut trajectory, mut events) = (start.clone(), Events::default());
    let (mut workspace, mut counters) = (kernel.workspace(), Counters::default());
    kernel.advance(
        1,
        &mut trajectory,
        &mut workspace,
        &mut events,
        &mut counters,
    )?;
    Ok((trajectory, events))
}

/// Compares the four kernels of the ladder with the kernel `volterra` on a few cycles of a drive; returns the
/// number of comparisons.
fn agree(case: &Case) -> Result<usize, TestCaseError> {
    let model = common::model(case);
    let ladder = match Ladder::new(&model, 24) {
        Ok(ladder) => ladder,
        // A refusal is acceptable. `random.rs` asserts that tables accept at least half of its drives.
        Err(DenseError::Table(TableError::Defective { .. })) => return Ok(0),
        Err(other) => return Err(TestCaseError::fail(other.to_string())),
    };
    for basis in ladder.spectral.conditioning() {
        prop_assert!(basis.reconstruction <= 1e-11, "{basis:?}");
    }
    let exact = volterra(&model);
    // Start at rest, just in contact: nearly rigid modes have no equilibrium nearby.
    let rigid = model.relative_rotation().unwrap();
    let mut state = vec![0.0; 2 * model.modes()];
    state[rigid] = 1.2 * model.half_gap / model.first_gains()[rigid].deflection[0];
    let mut start = TrajectoryState::new(&model, state, 0);
    let mut compared = 0;
    for _ in 0..6 {
        let Ok((end, events)) = cycle(&exact, &start) else {
            break;
        };
        // Growth of a disturbance of 10⁻⁹ over one cycle.
        let moved: Vec<f64> = start.state.iter().map(|x| x * (1.0 + 1e-9)).collect();
        let shifted = TrajectoryState {
            state: moved,
            ..start.clone()
        };
        let Ok((shifted, events_beside)) = cycle(&exact, &shifted) else {
            break;
        };
        let gain = 1e9 * state_difference(&model, &shifted.state, &end.state);
        if events_beside.0.len() == events.0.len() && gain < 1e3 {
            let allowed = 1e-12 * gain.max(1.0);
            each!(&ladder, name, kernel => {
                let (found, observed) = cycle(kernel, &start)
                    .map_err(|stop| TestCaseError::fail(format!("{name}: {stop}")))?;
                prop_assert_eq!(observed.0.len(), events.0.len(), "{}", name);
                let off = state_difference(&model, &found.state, &end.state);
                prop_assert!(off < allowed, "{}: {:e} of {:e}", name, off, allowed);
                compared += 1;
            });
        }
        start = end;
    }
    Ok(compared)
}

/// Slope of the logarithm of the error over that of the step, from `coarse` parts of the cycle to 16 times as many.
/// A single error depends on the positions of events between two steps; a mean over neighbouring numbers of parts does
/// not. `None` if the error is negligible.
fn order(coarse: u32, error: impl Fn(u32) -> f64) -> Option<f64> {
    // The logarithm of a delay between zero and a step has a standard deviation of 1. The order then has one of
    // √2 / ln 16 / √32 = 0.09.
    const NEIGHBOURS: u32 = 32;
    let mean = |parts: u32| {
        let sum = (0..NEIGHBOURS)
            .map(|i| error(parts + parts * i / 256).max(1e-15).ln())
            .sum::<f64>();
        sum / f64::from(NEIGHBOURS)
    };
    let fine = mean(16 * coarse);
    (fine > 1e-11f64.ln()).then(|| (mean(coarse) - fine) / 16f64.ln())
}

/// Convergence of small steps and of events on a grid, on cycles with events; returns the number of observed orders.
fn converge(case: &Case) -> Result<usize, TestCaseError> {
    let model = common::model(case);
    if Spectral::new(&model, 24, 1000, None).is_err() {
        return Ok(0);
    }
    let exact = volterra(&model);
    let rigid = model.relative_rotation().unwrap();
    let mut state = vec![0.0; 2 * model.modes()];
    state[rigid] = 1.2 * model.half_gap / model.first_gains()[rigid].deflection[0];
    let mut start = TrajectoryState::new(&model, state, 0);
    let mut observed = 0;
    for _ in 0..6 {
        let Ok((end, events)) = cycle(&exact, &start) else {
            break;
        };
        // Use cycles with few and fast crossings: the delay of a slow crossing is the square root of the step.
        let quick = |event: &gearatlas::propagate::Event| {
            event.rate.abs() > 0.3 * TAU * model.half_gap / model.period()
        };
        if (1..=3).contains(&events.0.len()) && events.0.iter().all(quick) {
            let off = |found: Result<(TrajectoryState, Events), Stop>| {
                found.map_or(1.0, |(found, _)| {
                    state_difference(&model, &found.state, &end.state)
                })
            };
            let stepping = order(2_000, |steps| {
                off(cycle(&Stepping::new(&model, steps, 1000), &start))
            });
            let gridded = order(20_000, |parts| {
                let kernel = Spectral::new(&model, 24, 1000, Some(parts)).unwrap();
                off(cycle(&kernel, &start))
            });
            for (name, order) in [("stepping", stepping), ("event_grid", gridded)] {
                let Some(order) = order else { continue };
                prop_assert!((0.5..2.5).contains(&order), "{}: order {}", name, order);
                observed += 1;
            }
            break;
        }
        start = end;
    }
    Ok(observed)
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 8,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn approximate_kernels_converge_on_any_drive(case in any_case()) {
        converge(&case)?;
    }
}

/// The property above observes orders of convergence on random drives.
#[test]
fn orders_are_seen() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let observed: usize = (0..12)
        .map(|_| {
            let case = any_case().new_tree(&mut runner).unwrap().current();
            converge(&case).unwrap()
        })
        .sum();
    assert!(observed >= 4, "{observed}");
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 12,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn any_drive_is_integrated_alike(case in any_case()) {
        agree(&case)?;
    }
}

/// An event on a grid is late by half a grid step on average: the error is of first order.
#[test]
fn an_event_grid_is_of_first_order() {
    for case in [common::six_modes(), common::twenty_modes()] {
        let model = common::model(&case);
        let starts: Vec<_> = (40..104).map(|cycles| settled(&model, cycles)).collect();
        let errors = [6_000, 60_000, 600_000].map(|parts| {
            let late = Spectral::new(&model, CELLS, 1000, Some(parts)).unwrap();
            let error = |start: &TrajectoryState| {
                let exact = advance(&volterra(&model), start, 1);
                relative_difference(&advance(&late, start, 1).state, &exact.state)
            };
            starts.iter().map(error).sum::<f64>() / starts.len() as f64
        });
        println!("{errors:?}");
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).log10();
            assert!((0.7..1.3).contains(&order), "{errors:?}");
        }
    }
}

/// Tables refuse a model that they cannot represent, and the message says why.
#[test]
fn varying_stiffness_is_refused() {
    let (structure, mut drive, point) = common::six_modes();
    let mut slope = [0.0; 8];
    (slope[0], slope[1]) = (4e8, 1e7);
    drive.mesh[0].stiffness = gearatlas::model::Stiffness::series(slope);
    let model = Model::new(&structure, &drive, point).unwrap();
    let refused = Dyadic::new(&model, CELLS, 10).map(|_| ()).unwrap_err();
    assert_eq!(refused, TableError::VaryingStiffness.into());
    assert!(refused.to_string().contains("piecewise"));
}

/// An undamped mode with excitation at its own frequency has no steady response.
#[test]
fn resonance_without_damping_is_refused() {
    // At the mesh frequency, and at less than half a radian per mesh cycle.
    for order in [20.0, 0.5] {
        let mut case = common::one_degree();
        case.0 = common::structure(&[0.0, order * 1200.0], 0.0, &[1.0, 0.0], &[1.0, 0.0]);
        case.0.pinion_torque = Some(vec![1.0, 1.0]);
        case.1.torque_ripple = vec![gearatlas::model::TorqueRipple {
            shaft: gearatlas::model::DriveShaft::Pinion,
            order,
            amplitude: 1.0,
            phase: 0.0,
        }];
        let model = common::model(&case);
        let refused = Spectral::new(&model, CELLS, 10, None)
            .map(|_| ())
            .unwrap_err();
        assert!(
            matches!(refused, DenseError::Table(TableError::Resonance { .. })),
            "{refused}"
        );
        assert!(Dyadic::new(&model, CELLS, 10).is_ok());
        // Now the ripple is off resonance. Only at order 20 the mesh error is in resonance with the mode.
        case.1.torque_ripple[0].order = 1.001 * order;
        let shifted = Spectral::new(&common::model(&case), CELLS, 10, None).map(|_| ());
        let in_resonance = matches!(
            shifted,
            Err(DenseError::Table(TableError::Resonance { .. }))
        );
        assert_eq!(in_resonance, order == 20.0, "{shifted:?}");
    }
}

/// Observers get windows from which the energy balance closes.
#[test]
fn work_seen_in_windows_closes_the_energy_balance() {
    let model = common::model(&common::six_modes());
    let ladder = Ladder::new(&model, CELLS).unwrap();
    let start = settled(&model, 40);
    each!(&ladder, name, kernel => {
        let mut audit = gearatlas::analysis::EnergyAudit::new(&model);
        let (end, _) = advance_with(kernel, &start, 20, &mut audit);
        let residual = audit.residual(&end).unwrap();
        assert!(residual < 1e-10, "{name}: {residual:e}");
        // Observation changes nothing.
        assert_eq!(advance(kernel, &start, 20), end, "{name}");
    });
}

/// Products in 32 bits find the events of a cycle, with errors of 32 bits and not less.
#[test]
fn single_precision_keeps_the_events() {
    for case in [common::six_modes(), common::forty_modes()] {
        let model = common::model(&case);
        let single = Spectral::in_single_precision(&model, CELLS, 1000).unwrap();
        let mut start = settled(&model, 40);
        let mut found_events = 0;
        for _ in 0..10 {
            let (mut exact, mut found) = (Events::default(), Events::default());
            let (end, _) = advance_with(&volterra(&model), &start, 1, &mut exact);
            let (other, _) = advance_with(&single, &start, 1, &mut found);
            assert_eq!(found.0.len(), exact.0.len());
            for (a, b) in found.0.iter().zip(&exact.0) {
                let late = (a.time - b.time).abs() / model.period();
                assert!(late < 1e-4 && a.to == b.to, "{late:e}");
            }
            let off = state_difference(&model, &other.state, &end.state);
            assert!((1e-9..1e-3).contains(&off), "{off:e}");
            found_events += found.0.len();
            start = end;
        }
        assert!(found_events > 10, "{found_events}");
    }
}
