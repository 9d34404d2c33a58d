//! Drives beyond two flanks on one line with modal damping: every exact kernel compared with the trajectory to 30
//! digits, small steps with their order, tangents with differences, and the energy balance. All tests use contacts that
//! open by their deflection, and by their force.

#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::{Events, advance, advance_with, volterra};
use common::relative_difference;
use gearatlas::analysis::{EnergyAudit, excitation_period};
use gearatlas::model::{
    CoastFlank, Division, Drive, DriveShaft, FlankError, InitialState, MeshHarmonic, Model,
    OperatingPoint, Release, StiffnessHarmonic, TorqueRipple, TrajectoryState,
};
use gearatlas::propagate::{Counters, Kernel, Stepping, Tangents};
use gearatlas::reference::{Extended, Reference};
use gearatlas::structure::{ContactLaw, Coupling, HarmonicLoad, ModalStructure, StructureContact};

/// A case: its name, its model and its start.
type Case = (String, Model, TrajectoryState);

fn zeros(n: usize) -> Vec<f64> {
    vec![0.0; n * n]
}

/// A matrix with some entries, row by row.
fn matrix(n: usize, entries: &[(usize, usize, f64)]) -> Vec<f64> {
    let mut out = zeros(n);
    for &(i, j, value) in entries {
        out[i * n + j] += value;
    }
    out
}

/// Two rotations and four elastic modes, two of which have the opposite sign on the coast flank.
fn two_lines() -> (ModalStructure, Drive, OperatingPoint) {
    let (mut structure, mut drive, point) = common::six_modes();
    structure.coast = Some(common::coast_line(&structure));
    drive.friction = 0.08;
    drive.coast = Some(CoastFlank {
        mesh: Division::mirrored(&drive.mesh, 0.17),
        transmission_error: vec![
            MeshHarmonic::new(1, 4e-6, 0.4),
            MeshHarmonic::new(2, 1e-6, 0.0),
        ],
        further: Vec::new(),
    });
    (structure, drive, point)
}

fn contact(name: &str, participation: Vec<f64>, gap: f64, levels: &[f64]) -> StructureContact {
    StructureContact {
        name: name.to_owned(),
        force: participation.clone(),
        tilt: Vec::new(),
        rubbing: Default::default(),
        sliding: 0.0,
        participation,
        cycles: [1, 1],
        law: ContactLaw {
            gap,
            damping: 200.0,
            ..Division::law(&Division::levels(levels, &[]), 0.0)
        },
        copies: None,
    }
}

/// A contact with a different cycle: three of its cycles take five cycles of the mesh.
fn cycled(contact: StructureContact, error: Vec<MeshHarmonic>) -> StructureContact {
    StructureContact {
        cycles: [3, 5],
        law: ContactLaw {
            phase: 0.3,
            error,
            ..contact.law
        },
        ..contact
    }
}

fn load(force: Vec<f64>, turns_per_cycle: f64, phase: f64) -> HarmonicLoad {
    HarmonicLoad {
        name: "load".to_owned(),
        force,
        turns_per_cycle,
        phase,
    }
}

/// A state with `count` closed contacts, a few half gaps away from rest.
fn with_closed(model: &Model, count: usize) -> TrajectoryState {
    let n = model.modes();
    let base = model.start(&InitialState::Static).state;
    let mut stream = gearatlas::numerics::random::Stream::new(7, 0, 0);
    for _ in 0..100_000 {
        let mut state = base.clone();
        for (i, x) in state.iter_mut().enumerate() {
            let scale = if i < n { 4.0 } else { 4.0 * 2e3 };
            *x += scale * model.half_gap * stream.normal();
        }
        let start = TrajectoryState::new(model, state, 0);
        if start.contact.count() == count {
            return start;
        }
    }
    panic!("no state with {count} contacts closed");
}

/// Six modes under a load with little chaos, whose growth would dominate the errors.
fn loaded() -> (ModalStructure, Drive, OperatingPoint) {
    let (structure, drive, point) = common::six_modes();
    (structure, drive, OperatingPoint { load: 0.3, ..point })
}

fn cases() -> Vec<Case> {
    [Release::Deflection, Release::Force]
        .into_iter()
        .flat_map(cases_of)
        .collect()
}

fn cases_of(release: Release) -> Vec<Case> {
    let mut out: Vec<Case> = Vec::new();
    let named = |name: &str| format!("{name} ({release:?})");
    let mut add = |name, (structure, drive, point): (ModalStructure, Drive, OperatingPoint)| {
        let drive = Drive { release, ..drive };
        let model = Model::new(&structure, &drive, point).unwrap();
        let start = advance(&volterra(&model), &model.start(&InitialState::Static), 20);
        out.push((named(name), model, start));
    };
    add("mirrored flanks", two_lines());
    add("flanks on one line", loaded());

    // Gaps that jump and open, with stiffness that jumps with them.
    let (structure, mut drive, point) = two_lines();
    let lacks = [[0.0; 8], [3e-7, 2e-7, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]];
    for (division, lack) in drive.mesh.iter_mut().zip(lacks) {
        division.error = FlankError::series(lack);
    }
    add("flanks that lack something", (structure, drive, point));

    // A second mesh with three cycles in five cycles of the first, and other participations.
    let (mut structure, drive, mut point) = loaded();
    point.load = 0.5;
    structure.contacts = vec![
        cycled(
            contact(
                "drive flank of mesh 2",
                vec![0.2, 0.1, -0.4, 0.3, 0.2, -0.1],
                4e-6,
                &[3e8, 2e8],
            ),
            vec![MeshHarmonic::new(1, 3e-6, 0.2)],
        ),
        cycled(
            contact(
                "coast flank of mesh 2",
                vec![-0.2, -0.1, -0.4, -0.3, 0.1, 0.1],
                4e-6,
                &[2e8, 3e8],
            ),
            Vec::new(),
        ),
    ];
    add("two meshes, 3/5", (structure, drive, point));

    // Drag acts on the rotation of the drive and on the relative rotation.
    let (mut structure, drive, point) = loaded();
    structure.coupling = Some(Coupling {
        damping: matrix(6, &[(0, 0, 3.0), (0, 1, -2.0), (1, 0, -2.0), (1, 1, 30.0)]),
        gyroscopic: zeros(6),
        stiffness: zeros(6),
    });
    add("drag", (structure, drive, point));

    let (mut structure, drive, point) = common::six_modes();
    structure.coupling = Some(Coupling {
        damping: matrix(6, &[(2, 3, 50.0), (3, 2, 50.0), (2, 2, 60.0), (3, 3, 80.0)]),
        gyroscopic: matrix(6, &[(2, 3, 0.4), (3, 2, -0.4), (4, 5, 0.3), (5, 4, -0.3)]),
        stiffness: matrix(6, &[(2, 3, 3e5), (3, 2, -3e5)]),
    });
    add("gyroscopic, cross-coupled", (structure, drive, point));

    let (mut structure, drive, point) = common::six_modes();
    structure.damping[3] = 2.5;
    structure.coupling = Some(Coupling {
        damping: matrix(6, &[(4, 5, 400.0), (5, 4, 400.0)]),
        gyroscopic: zeros(6),
        stiffness: zeros(6),
    });
    add("overdamped beside light modes", (structure, drive, point));

    let (mut structure, drive, mut point) = two_lines();
    // This load gives little chaos, whose growth would dominate the errors.
    point.load = 0.3;
    // No stop acts on the rotation of the whole drive, which would otherwise move away from the stop.
    let turning = |scale: f64, rest: [f64; 4]| -> Vec<f64> {
        let relative = structure.mesh[..2].iter().map(|w| scale * w);
        relative.chain(rest).collect()
    };
    let [one, other, stage] = [
        turning(0.2, [0.3, -0.2, 0.4, 0.1]),
        turning(-0.2, [-0.3, 0.2, -0.4, -0.1]),
        turning(0.3, [-0.2, 0.2, 0.1, 0.3]),
    ];
    structure.contacts = vec![
        contact("stop", one, 1e-7, &[2e8]),
        contact("other stop", other, 2e-7, &[1e8]),
        contact("stage", stage, -1e-7, &[5e7]),
    ];
    add("contacts within one window", (structure, drive, point));

    let (structure, mut drive, point) = two_lines();
    drive.mesh = Division::fourier(
        4e8,
        &[StiffnessHarmonic {
            harmonic: 2,
            amplitude: 5e7,
            phase: 0.3,
        }],
    );
    add("stiffness as a Fourier series", (structure, drive, point));

    let (mut structure, drive, mut point) = loaded();
    point.load = 0.8;
    structure.harmonic_loads = vec![
        load(vec![0.0, 3.0, 12.0, -8.0, 4.0, 2.0], 0.6, 0.7),
        load(vec![0.0, -2.0, 0.0, 16.0, 0.0, 4.0], 2f64.sqrt(), -1.0),
    ];
    add("loads of any frequency", (structure, drive, point));

    let (structure, mut drive, point) = two_lines();
    drive.release = release;
    let model = Model::new(&structure, &drive, point).unwrap();
    let start = with_closed(&model, 2);
    out.push((named("tight mesh"), model, start));
    out
}

/// Ten cycles: single cycles agree to 1e-13 of the state and of the cycle, with the same events, and consecutive ones
/// within the growth by the motion's chaos.
#[test]
fn ten_cycles_to_thirty_digits() {
    for (name, model, start) in cases() {
        let exact = Extended::new(&model).advance(&start, 10).unwrap();
        let mut seen = Events::default();
        let (end, _) = advance_with(&volterra(&model), &start, 10, &mut seen);
        let worst = relative_difference(&end.state, &exact.end().state);
        let several = exact.crossings.iter().filter(|c| c.to.count() > 1).count();
        assert_eq!(seen.0.len(), exact.crossings.len(), "{name}");
        let mut late = 0.0f64;
        for (event, crossing) in seen.0.iter().zip(&exact.crossings) {
            assert_eq!(
                (event.from, event.to, event.cycle),
                (crossing.from, crossing.to, crossing.cycle)
            );
            late = late.max((event.time - crossing.time.value()).abs() / model.period());
        }
        println!(
            "{name}: states {worst:.1e}, times {late:.1e} of a cycle, {} events, {several} with several closed",
            seen.0.len()
        );
        assert!(seen.0.len() > 10, "{name}: {} events", seen.0.len());
        // With contacts that open by their force, differences grow by two and a half per cycle: 1e4 times in ten.
        let grown = if name.contains("Force") { 30.0 } else { 1.0 };
        assert!(worst < 1e-12 * grown, "{name}: {worst:e}");
        assert!(late < 1e-13 * grown, "{name}: {late:e}");
        let [apart, late] = largest_of_single_cycles(&model, &start, 10);
        println!("{name}: single cycles {apart:.1e}, times {late:.1e}");
        assert!(apart < 1e-13 && late < 1e-13, "{name}: {apart:e} {late:e}");
        if name.contains("tight") || name.contains("one window") {
            assert!(several > 0, "{name}");
        }
        let passage = Reference::new(&model).advance(&start, 10).unwrap();
        let other = relative_difference(&passage.end.state, &exact.end().state);
        assert!(other < 1e-10, "{name}: {other:e}");
    }
}

/// Largest difference of a state after a cycle, and of an event's time \[cycles\], from the trajectory to
/// 30 digits that starts with that cycle.
fn largest_of_single_cycles(model: &Model, start: &TrajectoryState, cycles: u32) -> [f64; 2] {
    let (kernel, exact) = (volterra(model), Extended::new(model));
    let mut largest = [0.0f64; 2];
    let mut state = start.clone();
    for _ in 0..cycles {
        let mut seen = Events::default();
        let (end, _) = advance_with(&kernel, &state, 1, &mut seen);
        let passage = exact.advance(&state, 1).unwrap();
        assert_eq!(seen.0.len(), passage.crossings.len());
        let apart = relative_difference(&end.state, &passage.end().state);
        largest[0] = largest[0].max(apart);
        for (event, crossing) in seen.0.iter().zip(&passage.crossings) {
            let late = (event.time - crossing.time.value()).abs() / model.period();
            largest[1] = largest[1].max(late);
        }
        state = end;
    }
    largest
}

/// For contacts with different cycles, the base period follows from the teeth.
#[test]
fn contacts_of_another_mesh_set_the_base_period() {
    let cases = cases();
    let (_, model, _) = cases
        .iter()
        .find(|(name, ..)| name.contains("3/5"))
        .unwrap();
    assert_eq!(model.base_cycles(), 5);
}

/// Loads and contacts together determine the period; a load with an irrational frequency ratio has none.
#[test]
fn harmonic_loads_count_in_the_base_period() {
    let period = |turns: &[f64], cycles: [u32; 2]| {
        let structure = ModalStructure {
            harmonic_loads: turns.iter().map(|&t| load(vec![1.0], t, 0.0)).collect(),
            contacts: vec![StructureContact {
                cycles,
                ..contact("stop", vec![1.0], 3.0, &[2.0, 1.0])
            }],
            ..ModalStructure::of_modes(&[1.0], 0.1, &[1.0], &[1.0])
        };
        let point = OperatingPoint {
            load: 0.1,
            speed: 1.0,
        };
        let model = Model::new(&structure, &common::constant_mesh(1.0, 1.0), point).unwrap();
        excitation_period(&model)
    };
    assert_eq!(period(&[2.0], [1, 1]), Some(1));
    assert_eq!(period(&[3.0 / 5.0], [1, 1]), Some(5));
    assert_eq!(period(&[3.0 / 5.0, 1.5], [2, 3]), Some(30));
    assert_eq!(period(&[2f64.sqrt()], [1, 1]), None);
}

#[test]
fn small_steps_come_near() {
    for (name, model, start) in cases() {
        let exact = Extended::new(&model).advance(&start, 1).unwrap().end();
        let errors = [4_000, 64_000].map(|steps| {
            let end = advance(&Stepping::new(&model, steps, 10_000), &start, 1);
            relative_difference(&end.state, &exact.state)
        });
        println!("{name}: {errors:?}");
        assert!(
            errors[1] < 2e-3 && errors[1] < 0.8 * errors[0],
            "{name}: {errors:?}"
        );
    }
}

/// Tangents compared with differences of trajectories to 30 digits.
#[test]
fn tangents_are_those_of_neighbours() {
    for (name, model, start) in cases() {
        let n = start.state.len();
        let direction: Vec<f64> = (0..n)
            .map(|i| if i < n / 2 { 1e-6 } else { 1e-2 } * (1.0 + i as f64).sin())
            .collect();
        let mut tangents = Tangents::zeros(n / 2, 1);
        tangents.vector_mut(0).copy_from_slice(&direction);
        let kernel = volterra(&model);
        let (mut workspace, mut trajectory) = (kernel.workspace(), start.clone());
        kernel
            .advance_cycle(
                &mut trajectory,
                &mut tangents,
                &mut workspace,
                &mut (),
                &mut Counters::default(),
            )
            .unwrap();
        let kick = 1e-5;
        let ends = [kick, -kick].map(|kick| {
            let state: Vec<f64> = (start.state.iter().zip(&direction))
                .map(|(x, d)| x + kick * d)
                .collect();
            let moved = TrajectoryState {
                state,
                ..start.clone()
            };
            Extended::new(&model).advance(&moved, 1).unwrap()
        });
        let [more, less] = &ends;
        let difference: Vec<f64> = (more.state.iter().zip(&less.state))
            .map(|(a, b)| (*a - *b).value() / (2.0 * kick))
            .collect();
        let error = relative_difference(tangents.vector(0), &difference);
        println!("{name}: tangents {error:.1e}");
        assert!(error < 1e-5, "{name}: {error:e}");
    }
}

#[test]
fn energy_closes_to_round_off() {
    for (name, model, start) in cases() {
        let mut audit = EnergyAudit::new(&model);
        let (end, _) = advance_with(&volterra(&model), &start, 50, &mut audit);
        let residual = audit.residual(&end).unwrap();
        println!("{name}: {residual:.1e}");
        assert!(residual < 1e-12, "{name}: {residual:e}");
    }
}

/// Kahraman & Singh 1991, with a time-varying stiffness and three harmonics of the error:
/// `x'' + 2ζx' + K(t) B(x) = F_m + Σ F_j (jΩ)² cos jΩt`, ζ = 0.05, Ω = 0.5, F_m = 0.1. From rest the motion has the
/// period of the mesh. The strobe state comes from an integration with another program.
#[test]
fn a_published_oscillator_under_drag() {
    let omega = 0.5;
    let structure = ModalStructure {
        coupling: Some(Coupling {
            damping: vec![0.1],
            gyroscopic: vec![0.0],
            stiffness: vec![0.0],
        }),
        pinion_torque: Some(vec![1.0]),
        ..ModalStructure::of_modes(&[0.0], 0.0, &[1.0], &[1.0])
    };
    let harmonic = |(harmonic, amplitude): (u32, f64)| StiffnessHarmonic {
        harmonic,
        amplitude: -amplitude,
        phase: 0.0,
    };
    let ripple = |(order, amplitude): (f64, f64)| TorqueRipple {
        shaft: DriveShaft::Pinion,
        order,
        amplitude: amplitude * (order * omega).powi(2),
        phase: 0.0,
    };
    let drive = Drive {
        mesh: Division::fourier(1.0, &[(1, 0.2), (2, 0.1), (3, 0.05)].map(harmonic)),
        torque_ripple: [(1.0, 0.01), (2.0, 0.004), (3.0, 0.002)]
            .map(ripple)
            .to_vec(),
        ..common::constant_mesh(1.0, 1.0)
    };
    let point = OperatingPoint {
        load: 0.1,
        speed: omega,
    };
    let model = Model::new(&structure, &drive, point).unwrap();
    let kernel = volterra(&model);
    let end = advance(&kernel, &model.start(&InitialState::Rest), 500);
    let next = advance(&kernel, &end, 1);
    assert!(relative_difference(&next.state, &end.state) < 1e-9);
    println!("{:?}", end.state);
    assert!((end.state[0] - 1.0382529).abs() < 1e-7, "{:?}", end.state);
    assert!((end.state[1] - 0.0885743).abs() < 1e-7, "{:?}", end.state);
}
