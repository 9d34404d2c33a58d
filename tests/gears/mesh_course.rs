//! The mesh over its cycle: stiffness that varies within segments, a load centroid that moves along the face, friction
//! that changes its direction at the pitch point.

#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::{Events, ROUND_OFF, advance, advance_with, settled, volterra};
use common::{Case, relative_difference, state_difference};
use gearatlas::analysis::EnergyAudit;
use gearatlas::model::{
    ActiveSet, COAST_FLANK, CoastFlank, Division, Drive, FlankError, InitialState, Model,
    OperatingPoint, Stiffness, TrajectoryState,
};
use gearatlas::propagate::{Counters, InstructionSet, Kernel, Stepping, Tangents, Volterra};
use gearatlas::reference::{Extended, Reference};
use std::f64::consts::TAU;

/// Two pairs in mesh up to 0.6, then one: each stiffness is an arch, as from tooth bending.
fn arches() -> Vec<Division> {
    let arch = |end, top: f64, series: [f64; 3]| Division {
        stiffness: Stiffness::series([
            top,
            series[0] * top,
            -series[1] * top,
            0.0,
            series[2] * top,
            1e-3 * top,
            -2e-4 * top,
            1e-5 * top,
        ]),
        ..Division::level(end, top)
    };
    vec![
        arch(0.3, 4.4e8, [0.02, 0.03, -0.004]),
        arch(0.6, 4.45e8, [-0.02, 0.03, 0.004]),
        arch(1.0, 3.3e8, [0.01, 0.06, -0.01]),
    ]
}

/// Levels on equal divisions, with a load that moves along the face by 4 mm and friction that changes its direction.
fn wandering(count: u32) -> Vec<Division> {
    (0..count)
        .map(|i| {
            let phase = (f64::from(i) + 0.5) / f64::from(count);
            let rubbing = if phase < 0.6 { 1.0 - phase / 0.3 } else { -1.0 };
            Division {
                load_centre: 4e-3 * (TAU * phase).sin(),
                friction: [rubbing, 6e-3 * (phase - 0.5)],
                ..Division::level(
                    f64::from(i + 1) / f64::from(count),
                    if phase < 0.6 { 4.444e8 } else { 3.333e8 },
                )
            }
        })
        .collect()
}

/// Arches of stiffness with a load that moves along the face and friction that changes its direction.
fn everything() -> Vec<Division> {
    let mut divisions = arches();
    for (division, (centre, friction)) in divisions.iter_mut().zip([
        (3e-3, [0.4, -2e-3]),
        (-1e-3, [-0.3, 1e-3]),
        (-4e-3, [-1.0, 4e-3]),
    ]) {
        division.load_centre = centre;
        division.friction = friction;
    }
    divisions
}

/// [`everything`], with an error of loaded flanks up to a third of the half gap. The error varies over each piece and
/// jumps between pieces, also where the stiffness is continuous.
fn relieved(half_gap: f64) -> Vec<Division> {
    let mut divisions = everything();
    let errors = [
        [0.10, 0.06, 0.03, -0.01, 0.004, 1e-3, -2e-4, 1e-4],
        [0.30, -0.05, 0.02, 0.01, -0.003, 5e-4, 1e-4, -5e-5],
        [0.05, 0.04, -0.01, 0.005, 0.0, 0.0, 0.0, 0.0],
    ];
    for (division, error) in divisions.iter_mut().zip(errors) {
        division.error = FlankError::series(error.map(|a| a * half_gap));
    }
    divisions
}

/// Levels with different errors, directly after each other.
fn relieved_levels(half_gap: f64) -> Vec<Division> {
    let mut divisions = wandering(12);
    for (i, division) in (0u32..).zip(&mut divisions) {
        let level = 0.15 * (1.0 + (TAU * f64::from(i) / 12.0).sin());
        let mut series = [0.0; 8];
        series[..3].copy_from_slice(&[level, 0.07, -0.02]);
        division.error = FlankError::series(series.map(|a| a * half_gap));
    }
    divisions
}

/// Drives in which tilt matters, with each of these meshes.
fn models() -> Vec<(String, Model)> {
    let mut six = common::six_modes();
    six.0.mesh_tilt = vec![0.0, 0.0, 4.0, -3.0, 6.0, -2.0];
    six.0.friction_lever = vec![3.0, 1.0, -4.0, 2.0, 5.0, 1.0];
    let drives: [(&str, Case); 3] = [
        ("one degree", common::one_degree()),
        ("six modes", six),
        ("forty modes", common::forty_modes()),
    ];
    let mut models = Vec::new();
    for (name, (structure, drive, point)) in drives {
        for (course, mesh) in [
            ("arches", arches()),
            ("12 wandering", wandering(12)),
            ("60 wandering", wandering(60)),
            ("everything", everything()),
            ("relieved", relieved(drive.half_gap)),
            ("12 relieved", relieved_levels(drive.half_gap)),
        ] {
            let drive = Drive {
                mesh,
                friction: 0.1,
                ..drive.clone()
            };
            let model = Model::new(&structure, &drive, point).unwrap();
            models.push((format!("{name}, {course}"), model));
        }
    }
    models
}

/// A settled trajectory whose next cycle has events: a chaotic one may also have a cycle without.
fn rattling(model: &Model) -> TrajectoryState {
    let kernel = volterra(model);
    let mut start = settled(model, 40);
    loop {
        let (next, counters) = advance_with(&kernel, &start, 1, &mut ());
        if counters.events > 0 {
            return start;
        }
        start = next;
    }
}

/// Asserts the same events. Returns the largest difference of states and event times over single cycles, and the number
/// of events.
fn against_reference(model: &Model, kernel: &Volterra<'_>, cycles: u64) -> (f64, f64, usize) {
    let reference = Reference::new(model);
    let mut start = settled(model, 40);
    let (mut state, mut time, mut events) = (0.0f64, 0.0f64, 0);
    for _ in 0..cycles {
        let exact = reference.advance(&start, 1).unwrap();
        let mut seen = Events::default();
        let (end, _) = advance_with(kernel, &start, 1, &mut seen);
        assert_eq!(seen.0.len(), exact.crossings.len());
        for (a, b) in seen.0.iter().zip(&exact.crossings) {
            assert_eq!((a.from, a.to), (b.from, b.to));
            time = time.max((a.time - b.time).abs() / model.period());
        }
        state = state.max(state_difference(model, &end.state, &exact.end.state));
        events += seen.0.len();
        start = end;
    }
    (state, time, events)
}

#[test]
fn the_structured_kernel_is_the_reference_on_every_instruction_set() {
    for (name, model) in models() {
        for set in InstructionSet::available() {
            let kernel = Volterra::with_instructions(&model, ROUND_OFF, 10_000, set);
            let (state, time, events) = against_reference(&model, &kernel, 8);
            println!(
                "{name}, {}: state {state:.1e}, time {time:.1e}, {events} events, {} windows",
                set.name(),
                kernel.windows_per_cycle()
            );
            assert!(state < 1e-13 && time < 1e-14, "{name}: {state:e} {time:e}");
            assert!(events > 6, "{name} does not rattle");
        }
    }
}

#[test]
fn the_structured_kernel_is_exact_to_thirty_digits() {
    for (name, model) in models() {
        let (extended, kernel) = (Extended::new(&model), volterra(&model));
        let mut start = settled(&model, 40);
        for _ in 0..3 {
            let exact = extended.advance(&start, 1).unwrap();
            let end = advance(&kernel, &start, 1);
            let off = state_difference(&model, &end.state, &exact.end().state);
            assert!(off < 1e-13, "{name}: {off:e}");
            start = end;
        }
    }
}

/// Small steps use no series, certificates or cuts. They converge with order one through rattle.
#[test]
fn small_steps_converge_to_it() {
    for (name, model) in models().into_iter().skip(6).take(6) {
        // An event's error depends on its position in the step: use the mean of some cycles.
        let starts: Vec<_> = (40..60).map(|cycles| settled(&model, cycles)).collect();
        let errors = [2_000, 16_000, 128_000].map(|steps| {
            let stepping = Stepping::new(&model, steps, 10_000);
            let error = |start| {
                let exact = advance(&volterra(&model), start, 1);
                let end = advance(&stepping, start, 1);
                relative_difference(&end.state, &exact.state)
            };
            starts.iter().map(error).sum::<f64>() / starts.len() as f64
        });
        println!("{name}: {errors:?}");
        assert!(errors[2] < 2e-5, "{name}: {errors:?}");
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).log(8.0);
            assert!((0.6..1.6).contains(&order), "{name}: {errors:?}");
        }
    }
}

/// The mesh does work where its stiffness or half gap vary and where they or δ jump; friction dissipates some.
#[test]
fn energy_closes() {
    for (name, model) in models() {
        let kernel = volterra(&model);
        let mut audit = EnergyAudit::new(&model);
        let start = settled(&model, 40);
        let (end, counters) = advance_with(&kernel, &start, 200, &mut audit);
        let residual = audit.residual(&end).unwrap();
        println!(
            "{name}: residual {residual:.1e}, {} events",
            counters.events
        );
        assert!(residual < 1e-11, "{name}: {residual:e}");
    }
}

/// A tangent is the difference of two close trajectories, for windows of any length and across any jump of δ.
#[test]
fn tangents_are_differences() {
    for (name, model) in models() {
        let kernel = volterra(&model);
        let start = settled(&model, 41);
        let n = model.modes();
        let size = model.half_gap;
        for component in [0, n - 1, n, 2 * n - 1] {
            let step = 1e-7 * size * if component < n { 1.0 } else { 1e4 };
            let moved = |by: f64| {
                let mut from = start.clone();
                from.state[component] += by;
                advance(&kernel, &TrajectoryState::new(&model, from.state, 41), 1).state
            };
            let (ahead, behind) = (moved(step), moved(-step));
            let mut tangents = Tangents::zeros(n, 1);
            tangents.vector_mut(0)[component] = 1.0;
            let mut trajectory = start.clone();
            kernel
                .advance_cycle(
                    &mut trajectory,
                    &mut tangents,
                    &mut kernel.workspace(),
                    &mut (),
                    &mut Counters::default(),
                )
                .unwrap();
            let difference: Vec<f64> = (ahead.iter().zip(&behind))
                .map(|(a, b)| (a - b) / (2.0 * step))
                .collect();
            let off = relative_difference(tangents.vector(0), &difference);
            assert!(off < 1e-4, "{name}, component {component}: {off:e}");
        }
    }
}

/// Sixty levels of an arch converge to the arch with the square of their number, at a higher cost.
#[test]
fn levels_converge_to_the_course() {
    let (structure, drive, point) = common::six_modes();
    let exact = Drive {
        mesh: arches(),
        ..drive.clone()
    };
    let smooth = Model::new(&structure, &exact, point).unwrap();
    let start = rattling(&smooth);
    let end = advance(&volterra(&smooth), &start, 1);
    let errors = [60u32, 240, 960].map(|count| {
        let mesh = (0..count)
            .map(|i| {
                let phase = (f64::from(i) + 0.5) / f64::from(count);
                let segment = smooth.first_cycle().segment_at(phase * smooth.period());
                let level = segment.stiffness_at(phase);
                Division::level(f64::from(i + 1) / f64::from(count), level)
            })
            .collect();
        let model = Model::new(
            &structure,
            &Drive {
                mesh,
                ..drive.clone()
            },
            point,
        )
        .unwrap();
        let coarse = advance(&volterra(&model), &start, 1);
        relative_difference(&coarse.state, &end.state)
    });
    println!("{errors:?}");
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log(4.0);
        assert!((1.7..2.3).contains(&order), "{errors:?}");
    }
}

/// Both flanks have the error of loaded flanks: a mesh in reverse, with reversed load, has the same motion.
#[test]
fn back_flanks_lack_as_much() {
    let (structure, drive, point) = common::six_modes();
    let model = |load: f64| {
        let drive = Drive {
            mesh: relieved(drive.half_gap),
            transmission_error: Vec::new(),
            torque_ripple: Vec::new(),
            ..drive.clone()
        };
        Model::new(&structure, &drive, OperatingPoint { load, ..point }).unwrap()
    };
    let (front, back) = (model(point.load), model(-point.load));
    let start = rattling(&front);
    let mirrored: Vec<f64> = start.state.iter().map(|x| -x).collect();
    let mirrored = TrajectoryState::new(&back, mirrored, start.cycle);
    assert_eq!(mirrored.contact.sign(), -start.contact.sign());
    let (end, counters) = advance_with(&volterra(&front), &start, 8, &mut ());
    let turned: Vec<f64> = (advance(&volterra(&back), &mirrored, 8).state.iter())
        .map(|x| -x)
        .collect();
    assert!(counters.events > 4);
    assert!(state_difference(&front, &turned, &end.state) < 1e-12);
}

/// A contact under a force smaller than the jump of the error opens at the jump, and not before.
#[test]
fn a_step_of_the_half_gap_opens_the_contact() {
    let (structure, drive, point) = common::one_degree();
    let step = 0.2 * drive.half_gap;
    let mut mesh = Division::levels(&[4e8, 4e8], &[0.4]);
    let mut error = [0.0; 8];
    error[0] = step;
    mesh[1].error = FlankError::series(error);
    let drive = Drive {
        mesh,
        transmission_error: Vec::new(),
        ..drive
    };
    let model = Model::new(&structure, &drive, point).unwrap();
    let start = model.start(&InitialState::Static);
    let mut seen = Events::default();
    advance_with(&volterra(&model), &start, 1, &mut seen);
    let first = seen.0.first().unwrap();
    assert_eq!((first.from, first.to), (ActiveSet::DRIVE, ActiveSet::FREE));
    assert_eq!(first.time, model.first_cycle().start(1));
}

/// A jump of the error of the coast flank may close it from free flight: from there on its windows start at separate
/// breakpoints.
#[test]
fn a_step_of_the_half_gap_closes_the_coast_flank() {
    let (structure, drive, point) = common::one_degree();
    let mut coast = Division::levels(&[4e8, 3e8, 2e8], &[0.37, 0.63]);
    coast[0].error = FlankError::series([0.3 * drive.half_gap, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let drive = Drive {
        mesh: Division::levels(&[4.4e8, 4.2e8, 4e8, 3.6e8, 3.3e8], &[0.1, 0.2, 0.3, 0.55]),
        coast: Some(CoastFlank {
            mesh: coast,
            transmission_error: Vec::new(),
            further: Vec::new(),
        }),
        transmission_error: Vec::new(),
        ..drive
    };
    let model = Model::new(&structure, &drive, point).unwrap();
    let (reference, kernel) = (Reference::new(&model), volterra(&model));
    let place = -1.15 * drive.half_gap / model.deflection(&[1.0, 0.0], 0.0).0;
    let mut start = TrajectoryState::new(&model, vec![place, 0.0], 0);
    let mut seen = Events::default();
    for _ in 0..3 {
        let exact = reference.advance(&start, 1).unwrap();
        let (end, _) = advance_with(&kernel, &start, 1, &mut seen);
        let off = state_difference(&model, &end.state, &exact.end.state);
        assert!(off < 1e-12, "{off:e}");
        start = end;
    }
    let first = seen.0.first().unwrap();
    assert_eq!((first.from, first.to), (ActiveSet::FREE, ActiveSet::COAST));
    assert_eq!(first.time, model.contacts[COAST_FLANK].cycle(0).start(1));
}

/// The static start is in balance to round-off for any mesh at phase 0, also with a transmission error that moves
/// there.
#[test]
fn the_static_start_is_in_balance() {
    for (name, mut model) in models() {
        // Mean torques only.
        model.ripple.clear();
        let start = model.start(&InitialState::Static);
        let segment = &model.first_cycle().segments[0];
        let n = model.modes();
        let mut rates = vec![0.0; 2 * n];
        model.derivative(
            &[*segment; 2],
            start.contact,
            0,
            0.0,
            &start.state,
            &mut rates,
        );
        let (deflection, rate) = model.deflection(&start.state, 0.0);
        let force = model.contacts[0].force(segment, 0.0, deflection, rate);
        for (i, gain) in model.gains(segment).iter().enumerate() {
            if model.neutral.contains(&i) {
                continue;
            }
            let scale = (gain.mesh_input[1] * force).abs() + model.blocks[i].static_input[1].abs();
            let left = rates[n + i].abs();
            assert!(
                left < 1e-9 * scale,
                "{name}, mode {i}: {left:e} of {scale:e}"
            );
        }
        assert!(force > 0.0 && start.contact == ActiveSet::DRIVE, "{name}");
    }
}
