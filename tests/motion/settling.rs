//! Orbits from Newton's method are those on which integration settles.

#![allow(clippy::unwrap_used)]

use crate::common;
use common::relative_difference;
use faer::Mat;
use gearatlas::analysis::orbits::attracting::approaches;
use gearatlas::analysis::orbits::shooting::{shoot, shortest};
use gearatlas::analysis::orbits::twins::leading_exponent;
use gearatlas::analysis::{
    Class, Effort, EnergyNorm, LyapunovConfig, LyapunovMethod, NvhConfig, PointConfig,
    PointOutcome, Section, Signals, investigate,
};
use gearatlas::model::{
    Division, Drive, DriveShaft, InitialState, MeshHarmonic, Model, OperatingPoint, TorqueRipple,
    TrajectoryState,
};
use gearatlas::numerics::linalg::{eigenpair, eigenvalues};
use gearatlas::numerics::random::PointSeed;
use gearatlas::propagate::{Counters, Kernel, Volterra};
use gearatlas::reference::Reference;
use gearatlas::structure::{ContactLaw, HarmonicLoad, ModalStructure, StructureContact};
use std::sync::atomic::AtomicBool;

fn questions(transient: u64) -> PointConfig {
    PointConfig {
        point: PointSeed {
            seed: 3,
            point_id: 1,
        },
        transient,
        cycles: 12_000,
        settle: true,
        audit_cycles: 0,
        lyapunov: Some(LyapunovConfig {
            stop_at_stderr: Some(0.02),
            align: 50,
            twin: false,
            effort: Effort::Survey,
            ..LyapunovConfig::default()
        }),
        poincare_samples: 0,
        section: Section::default(),
        nvh: None,
    }
}

fn ask(model: &Model, settle: bool, transient: u64) -> PointOutcome {
    let questions = PointConfig {
        settle,
        ..questions(transient)
    };
    investigate(
        model,
        &Volterra::new(model, f64::EPSILON, 1000),
        model.start(&InitialState::Static),
        &questions,
        &AtomicBool::new(false),
    )
    .unwrap()
}

/// One degree at a load and a speed.
fn one_degree(load: f64, speed: f64) -> Model {
    common::model_at(&common::one_degree(), load, speed)
}

/// Forty modes at a load and a speed.
fn forty_modes(load: f64, speed: f64) -> Model {
    common::model_at(&common::forty_modes(), load, speed)
}

/// One degree under ripple of half a revolution of the pinion: period 20 in mesh cycles of 40 teeth.
fn rippled() -> Model {
    let (mut structure, mut drive, mut point) = common::one_degree();
    structure.teeth = 40;
    structure.pinion_torque = Some(vec![10.0]);
    drive.torque_ripple = vec![TorqueRipple {
        shaft: DriveShaft::Pinion,
        order: 2.0,
        amplitude: 1.0,
        phase: 0.4,
    }];
    (point.load, point.speed) = (0.3, 300.0);
    Model::new(&structure, &drive, point).unwrap()
}

fn advance(model: &Model, state: &mut TrajectoryState, cycles: u32) {
    let kernel = Volterra::new(model, f64::EPSILON, 1000);
    let mut workspace = kernel.workspace();
    kernel
        .advance(
            u64::from(cycles),
            state,
            &mut workspace,
            &mut (),
            &mut Counters::default(),
        )
        .unwrap();
}

#[test]
fn shooting_and_integrating_agree() {
    for (name, model, class) in [
        (
            "steady_contact",
            one_degree(1.0, 400.0),
            Class::SteadyContact(Some(1)),
        ),
        ("period 1", one_degree(0.3, 600.0), Class::Periodic(1)),
        ("period 2", one_degree(0.2, 1800.0), Class::Periodic(2)),
        ("period 3", one_degree(2.0, 1500.0), Class::Periodic(3)),
        ("ripple", rippled(), Class::Periodic(20)),
        ("forty modes", forty_modes(0.1, 700.0), Class::Periodic(1)),
    ] {
        let quick = ask(&model, true, 2000);
        let slow = ask(&model, false, 2000);
        assert_eq!(
            (quick.class, slow.class),
            (Some(class), Some(class)),
            "{name}: {} / {}",
            quick.reason,
            slow.reason
        );
        assert!(quick.reason.contains("Newton"), "{name}: {}", quick.reason);
        assert!(slow.reason.contains("integrated to the end"), "{name}");
        assert_eq!(quick.events_per_cycle, slow.events_per_cycle, "{name}");
        let (quick_lambda, slow_lambda) = (quick.lyapunov.unwrap(), slow.lyapunov.unwrap());
        assert_eq!(quick_lambda.method, LyapunovMethod::Multipliers);
        let error = (quick_lambda.exponents[0] - slow_lambda.exponents[0]).abs();
        println!(
            "{name}: {} against {} cycles, exponents differ by {error:.1e}",
            quick.cycles, slow.cycles
        );
        assert!(error < 1e-8, "{name}: {error:e}");
        assert!(2 * quick.cycles < slow.cycles, "{name}");
    }
}

/// The map of a cycle in constant contact is affine: its fixed point needs no transient.
#[test]
fn constant_contact_is_solved_before_anything_is_integrated() {
    for (name, model) in [
        ("one degree", one_degree(3.0, 300.0)),
        ("forty modes", forty_modes(4.0, 250.0)),
    ] {
        let quick = ask(&model, true, 2000);
        let slow = ask(&model, false, 2000);
        assert_eq!(
            (quick.class, slow.class),
            (
                Some(Class::SteadyContact(Some(1))),
                Some(Class::SteadyContact(Some(1)))
            )
        );
        assert!(
            quick.reason.contains("after 0 cycles"),
            "{name}: {}",
            quick.reason
        );
        let [a, b] = [&quick, &slow].map(|o| o.lyapunov.as_ref().unwrap().exponents[0]);
        println!("{name}: {} against {} cycles", quick.cycles, slow.cycles);
        assert!((a - b).abs() < 1e-9, "{name}: {a} {b}");
        assert!(10 * quick.cycles < slow.cycles, "{name}");
    }
}

#[test]
fn chaos_is_not_settled_away() {
    for model in [one_degree(0.05, 1200.0), forty_modes(0.05, 1200.0)] {
        let outcome = ask(&model, true, 500);
        assert_eq!(outcome.class, Some(Class::Chaotic), "{}", outcome.reason);
        assert_eq!(outcome.lyapunov.unwrap().method, LyapunovMethod::Tangent);
    }
}

#[test]
fn an_orbit_is_closed_by_the_reference_too() {
    for (name, model, period) in [
        ("period 1", one_degree(0.3, 600.0), 1),
        ("period 2", one_degree(0.2, 1800.0), 2),
        ("period 3", one_degree(2.0, 1500.0), 3),
    ] {
        let kernel = Volterra::new(&model, f64::EPSILON, 1000);
        let norm = EnergyNorm::new(&model);
        let mut workspace = kernel.workspace();
        let mut guess = model.start(&InitialState::Static);
        advance(&model, &mut guess, 300);
        let orbit = shoot(&model, &kernel, &norm, &guess, period, &mut workspace)
            .unwrap()
            .unwrap_or_else(|| panic!("{name}: not found"));
        assert!(orbit.residual < 1e-12, "{name}: {:e}", orbit.residual);
        assert!(orbit.spectral_radius() < 1.0);
        let end = Reference::new(&model)
            .advance(&orbit.start, u64::from(period))
            .unwrap()
            .end;
        let open = relative_difference(&end.state, &orbit.start.state);
        assert!(open < 1e-12, "{name}: {open:e}");

        // A search with four times the period finds the orbit with its shortest period.
        let long = shoot(&model, &kernel, &norm, &guess, 4 * period, &mut workspace)
            .unwrap()
            .unwrap();
        let short = shortest(&model, &kernel, &norm, long, 1, &mut workspace).unwrap();
        assert_eq!(short.period, period, "{name}");
    }
}

#[test]
fn motion_in_constant_contact_is_solved_in_one_step() {
    let model = forty_modes(1.0, 250.0);
    let kernel = Volterra::new(&model, f64::EPSILON, 1000);
    let norm = EnergyNorm::new(&model);
    let mut workspace = kernel.workspace();
    let mut guess = model.start(&InitialState::Static);
    // The start is far from settled, but in contact.
    advance(&model, &mut guess, 3);
    let orbit = shoot(&model, &kernel, &norm, &guess, 1, &mut workspace)
        .unwrap()
        .unwrap();
    assert!(orbit.residual < 1e-11, "{:e}", orbit.residual);
    let mut state = orbit.start.clone();
    let mut counters = Counters::default();
    kernel
        .advance(10, &mut state, &mut workspace, &mut (), &mut counters)
        .unwrap();
    assert_eq!(counters.events, 0, "the drive stays in contact");
    assert!(norm.distance(&state.state, &orbit.start.state) < 1e-10 * norm.unit());
}

#[test]
fn a_trajectory_elsewhere_is_not_taken_for_one_that_approaches() {
    let model = one_degree(0.3, 600.0);
    let kernel = Volterra::new(&model, f64::EPSILON, 1000);
    let norm = EnergyNorm::new(&model);
    let mut workspace = kernel.workspace();
    let mut guess = model.start(&InitialState::Static);
    advance(&model, &mut guess, 300);
    let orbit = shoot(&model, &kernel, &norm, &guess, 1, &mut workspace)
        .unwrap()
        .unwrap();
    let mut near = orbit.start.clone();
    near.state[0] += 1e-3 * model.half_gap;
    let mut far = orbit.start.clone();
    far.state[1] += 50.0 * norm.unit();
    for (state, expected) in [(near, true), (far, false)] {
        let mut state = TrajectoryState::new(&model, state.state, state.cycle);
        let verdict = approaches(
            &kernel,
            &norm,
            &orbit,
            &mut state,
            &mut workspace,
            &mut Counters::default(),
        )
        .unwrap();
        assert_eq!(verdict, expected);
    }
}

/// Two orbits attract. The trajectory settles on the orbit of three cycles. After 200 cycles it passes the orbit of two
/// cycles at half a gap. It leaves this neighbourhood by chance nearly as the monodromy matrix predicts, but with other
/// events.
#[test]
fn the_orbit_does_not_depend_on_when_it_is_sought() {
    let (mut structure, mut drive, mut point) = common::one_degree();
    structure.teeth = 20;
    structure.rated_force = 1330.0;
    (structure.mesh, structure.torque) = (vec![1.1704014971926109], vec![1.1704014971926109]);
    drive.half_gap = 2.5761973079064692e-5;
    drive.damping = 118.64158630758287;
    let (soft, stiff) = (1.008096211746803e8, 1.5206286085380644e8);
    drive.mesh = Division::levels(&[stiff, stiff, stiff, soft, soft], &[]);
    drive.transmission_error = vec![MeshHarmonic::new(
        1,
        8.913419175418612e-7,
        0.9100065072676591,
    )];
    (point.load, point.speed) = (0.16324561300966856, 724.6612419268087);
    let model = Model::new(&structure, &drive, point).unwrap();
    for transient in [100, 1300] {
        let found = ask(&model, true, transient);
        assert_eq!(found.class, Some(Class::Periodic(3)), "{}", found.reason);
    }
    let integrated = ask(&model, false, 1300);
    assert_eq!(
        integrated.class,
        Some(Class::Periodic(3)),
        "{}",
        integrated.reason
    );
}

/// Twins do not use saltations: they find the multiplier of a rattling orbit, and disagree with a wrong monodromy
/// matrix.
#[test]
fn twins_confirm_the_multiplier_of_a_rattling_orbit() {
    for (name, model, period) in [
        ("period 1", one_degree(0.3, 600.0), 1),
        ("period 2", one_degree(0.2, 1800.0), 2),
        ("forty modes", forty_modes(0.1, 700.0), 1),
    ] {
        let kernel = Volterra::new(&model, f64::EPSILON, 1000);
        let norm = EnergyNorm::new(&model);
        let mut workspace = kernel.workspace();
        let mut guess = model.start(&InitialState::Static);
        advance(&model, &mut guess, 300);
        let orbit = shoot(&model, &kernel, &norm, &guess, period, &mut workspace)
            .unwrap()
            .unwrap();
        let exact = orbit.spectral_radius().ln() / f64::from(period);
        let mut ask = |matrix: &Mat<f64>| {
            let leading = eigenvalues(matrix.as_ref()).unwrap()[0];
            let direction = eigenpair(matrix.as_ref(), leading).unwrap().vector;
            leading_exponent(
                &model,
                &kernel,
                &norm,
                &orbit.start,
                period,
                &direction,
                &mut workspace,
            )
            .unwrap()
            .unwrap()
        };
        let twin = ask(&orbit.monodromy);
        println!("{name}: {exact} {twin:?}");
        assert!((twin.exponent - exact).abs() < 1e-7, "{name}: {twin:?}");
        assert!(twin.error < 1e-4 && twin.agrees, "{name}: {twin:?}");
        let mut off = orbit.monodromy.clone();
        off[(0, 1)] += 1e-2;
        off[(1, 0)] -= 1e-2;
        assert!(!ask(&off).agrees, "{name}");
    }
}

/// Orbits that contract to round-off within a period: their twins are separated again. If a single cycle leaves nothing
/// of their distance, no multiplier is reported. Neither is a false alarm.
#[test]
fn twins_of_orbits_that_contract_strongly_raise_no_alarm() {
    // A hundred cycles of ripple with a multiplier of e^-34.
    let mut structure = common::structure(&[3000.0], 0.02, &[1.3], &[1.3]);
    structure.teeth = 100;
    structure.pinion_torque = Some(vec![26.0]);
    let mut drive = common::two_level_mesh(10e-6);
    drive.damping = 1483.24;
    drive.torque_ripple = vec![TorqueRipple {
        shaft: DriveShaft::Pinion,
        order: 1.0,
        amplitude: 3.0,
        phase: 0.0,
    }];
    let mut point = common::strong_rattle();
    (point.load, point.speed) = (0.1, 160.0);
    let rippled = Model::new(&structure, &drive, point).unwrap();
    // A cycle that contracts by e^-100 and more.
    let mut drive = common::two_level_mesh(10e-6);
    drive.damping = 20_000.0;
    drive.transmission_error = vec![MeshHarmonic::new(1, 1e-7, 0.0)];
    let structure = common::structure(&[3000.0], 0.3, &[1.3], &[1.3]);
    (point.load, point.speed) = (1.0, 50.0);
    let heavy = Model::new(&structure, &drive, point).unwrap();
    for (model, told) in [(rippled, true), (heavy, false)] {
        let kernel = Volterra::new(&model, f64::EPSILON, 1000);
        let start = model.start(&InitialState::Static);
        let asked = PointConfig {
            lyapunov: Some(LyapunovConfig {
                align: 50,
                effort: Effort::Survey,
                ..LyapunovConfig::default()
            }),
            ..questions(300)
        };
        let interrupt = AtomicBool::new(false);
        let outcome = investigate(&model, &kernel, start, &asked, &interrupt).unwrap();
        let lyapunov = outcome.lyapunov.unwrap();
        println!("{:?} {lyapunov:?}", outcome.class);
        assert_eq!(lyapunov.method, LyapunovMethod::Multipliers);
        assert_eq!(lyapunov.twin_agrees, told.then_some(true), "{lyapunov:?}");
        assert_eq!(lyapunov.twin.is_some(), told);
        if let Some(twin) = lyapunov.twin {
            assert!((twin - lyapunov.exponents[0]).abs() < 1e-6, "{lyapunov:?}");
        }
    }
}

/// A driven mode with a stop, and an undamped mode that moves for ever. Newton's orbit leaves the latter at rest, so the
/// motion does not settle on it, whatever the round-off of its multipliers.
#[test]
fn an_undamped_mode_does_not_settle() {
    let mut structure = ModalStructure::of_modes(&[1.0, 1.37], 0.0, &[0.0, 1.0], &[0.0, 1.0]);
    structure.damping = vec![0.05, 0.0];
    let law = ContactLaw {
        stiffness: vec![(1.0, [30.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])],
        ..ContactLaw::default()
    };
    let stop = StructureContact::plain("stop".to_owned(), vec![1.0, 0.0], law);
    structure.contacts.push(stop);
    structure.harmonic_loads = vec![HarmonicLoad {
        name: "load".to_owned(),
        force: vec![1.0, 0.0],
        turns_per_cycle: 1.0,
        phase: 0.0,
    }];
    for speed in [2.2, 2.8, 3.0] {
        let point = OperatingPoint { load: 0.0, speed };
        let model = Model::new(&structure, &Drive::constant(1e3, 1.0), point).unwrap();
        let mut questions = questions(500);
        questions.nvh = Some(NvhConfig {
            harmonics: 0,
            outputs: Signals::NONE,
            power: false,
            spectrum: None,
            orders: None,
            stop_at_stderr: None,
        });
        let found = investigate(
            &model,
            &Volterra::new(&model, f64::EPSILON, 1000),
            TrajectoryState::new(&model, vec![0.1, 2.0, 0.0, 0.0], 0),
            &questions,
            &AtomicBool::new(false),
        )
        .unwrap();
        let rms = found.nvh.unwrap().values.deflection_rms;
        assert!(
            (rms - 2.0_f64.sqrt()).abs() < 1e-2,
            "{speed}: {rms} {}",
            found.reason
        );
    }
}
