//! Are Lyapunov exponents and multipliers right? Comparisons with eigenvalues of an independently computed map in
//! constant contact, the exact sum of all exponents through rattle, closed forms, finite differences, a twin.

#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::{settled, volterra};
use common::drives;
use gearatlas::analysis::{
    Class, Effort, EnergyNorm, LyapunovConfig, LyapunovMethod, PointConfig, Section, TangentGrowth,
    investigate, kaplan_yorke,
};
use gearatlas::model::{Division, DriveShaft, InitialState, Model, TorqueRipple, TrajectoryState};
use gearatlas::numerics::random::{PointSeed, Stream};
use gearatlas::numerics::statistics::standard_error;
use gearatlas::propagate::{Counters, Kernel};
use gearatlas::verify::constant_contact_exponents;
use std::f64::consts::TAU;
use std::sync::atomic::AtomicBool;

fn questions(exponents: usize, transient: u64, cycles: u64) -> PointConfig {
    PointConfig {
        point: PointSeed {
            seed: 1,
            point_id: 2,
        },
        transient,
        cycles,
        settle: false,
        audit_cycles: 0,
        lyapunov: Some(LyapunovConfig {
            exponents,
            align: 50,
            effort: Effort::Survey,
            ..LyapunovConfig::default()
        }),
        poincare_samples: 0,
        section: Section::default(),
        nvh: None,
    }
}

/// The case at full load on a nearly even mesh: contact never opens.
fn quiet(mut case: common::Case) -> Model {
    for harmonic in &mut case.1.transmission_error {
        harmonic.amplitude *= 0.002;
    }
    case.1.torque_ripple.clear();
    case.1.mesh = Division::levels(&[3.4e8, 3.333e8], &[0.6]);
    case.2.load = 1.0;
    common::model(&case)
}

fn worst_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

#[test]
fn investigation_of_steady_contact_gives_them_too() {
    for (name, case) in drives() {
        let model = quiet(case);
        let exact = constant_contact_exponents(&model).unwrap();
        let kernel = volterra(&model);
        let start = model.start(&InitialState::Static);
        let asked = 3.min(exact.len());
        let outcome = investigate(
            &model,
            &kernel,
            start,
            &questions(asked, 4000, 2000),
            &AtomicBool::new(false),
        )
        .unwrap();
        assert_eq!(
            outcome.class,
            Some(Class::SteadyContact(Some(1))),
            "{name}: {}",
            outcome.reason
        );
        let lyapunov = outcome.lyapunov.unwrap();
        assert_eq!(lyapunov.method, LyapunovMethod::Multipliers);
        let error = worst_difference(&lyapunov.exponents, &exact[..asked]);
        println!(
            "{name}: {error:.1e}, twin {:?} {:?}",
            lyapunov.twin, lyapunov.twin_agrees
        );
        assert!(error < 1e-11, "{name}: {error:e}");
        assert!(lyapunov.exponents[0] < 0.0);
        let apart = (lyapunov.twin.unwrap() - exact[0]).abs();
        assert!(apart < 1e-7, "{name}: twin off by {apart:e}");
        assert_eq!(lyapunov.twin_agrees, Some(true), "{name}: {lyapunov:?}");
    }
}

/// Ripple makes the period of permanent contact twenty cycles, over which the smaller multipliers fall below round-off
/// of the map: the exponents per cycle are those without ripple.
#[test]
fn exponents_below_round_off_of_a_long_period_are_those_of_a_cycle() {
    for (name, mut case) in drives() {
        case.0.teeth = 20;
        if case.0.pinion_torque.is_none() {
            case.0.pinion_torque = Some(case.0.mesh.iter().map(|w| 10.0 * w).collect());
        }
        let exact = constant_contact_exponents(&quiet(case.clone())).unwrap();
        let mut rippled = case;
        for harmonic in &mut rippled.1.transmission_error {
            harmonic.amplitude *= 0.002;
        }
        rippled.1.torque_ripple = vec![TorqueRipple {
            shaft: DriveShaft::Pinion,
            order: 1.0,
            amplitude: 0.1,
            phase: 0.0,
        }];
        rippled.1.mesh = Division::levels(&[3.4e8, 3.333e8], &[0.6]);
        rippled.2.load = 1.0;
        let model = common::model(&rippled);
        let asked = PointConfig {
            settle: true,
            ..questions(exact.len(), 400, 2000)
        };
        let interrupt = AtomicBool::new(false);
        let start = model.start(&InitialState::Static);
        let outcome = investigate(&model, &volterra(&model), start, &asked, &interrupt).unwrap();
        let class = Some(Class::SteadyContact(Some(20)));
        assert_eq!(outcome.class, class, "{name}: {}", outcome.reason);
        let lyapunov = outcome.lyapunov.unwrap();
        println!("{name}: {:.3} …", 20.0 * exact[exact.len() - 1]);
        let found = lyapunov.exponents.iter().zip(&lyapunov.errors);
        assert_eq!(found.len(), exact.len());
        for ((found, error), exact) in found.zip(&exact) {
            let off = (found - exact).abs();
            assert!(*error < 1e-8, "{name}: {found} ± {error:e}");
            assert!(off <= error + 1e-11, "{name}: {found} ± {error:e}, {exact}");
        }
    }
}

/// A contraction by e^-1000 and more underflows over a period, but has an exponent. If it underflows within a single
/// cycle, there is none.
#[test]
fn multipliers_that_underflow_stop_no_point() {
    let (w, damping) = (1.3, 20_000.0);
    let mut structure = common::structure(&[3000.0], 0.3, &[w], &[w]);
    structure.teeth = 20;
    structure.pinion_torque = Some(vec![10.0]);
    let mut drive = common::two_level_mesh(10e-6);
    drive.mesh = Division::levels(&[4e8], &[]);
    drive.damping = damping;
    drive.transmission_error.clear();
    let mut point = common::strong_rattle();
    for (order, speed, period) in [(1.0, 60.0, 20), (0.0, 3.0, 1)] {
        (point.load, point.speed) = (1.0, speed);
        drive.torque_ripple = match period {
            1 => Vec::new(),
            _ => vec![TorqueRipple {
                shaft: DriveShaft::Pinion,
                order,
                amplitude: 0.1,
                phase: 0.0,
            }],
        };
        let model = Model::new(&structure, &drive, point).unwrap();
        let exact = -(0.3 * 3000.0 + 0.5 * damping * w * w) * model.period();
        let asked = PointConfig {
            settle: true,
            ..questions(2, 100, 1000)
        };
        let interrupt = AtomicBool::new(false);
        let start = model.start(&InitialState::Static);
        let outcome = investigate(&model, &volterra(&model), start, &asked, &interrupt).unwrap();
        assert!(exact * f64::from(period) < -800.0, "{exact}");
        let class = Some(Class::SteadyContact(Some(period)));
        assert_eq!(outcome.class, class, "{}", outcome.reason);
        let found = outcome.lyapunov.map(|found| found.exponents);
        println!("{exact} {found:?}");
        match period {
            1 => assert_eq!(found, None),
            _ => assert!(worst_difference(&found.unwrap(), &[exact, exact]) < 1e-9),
        }
    }
}

/// One degree at rest in contact, constant stiffness: a fixed point whose exponents are both
/// `−(ζω + c w²/2) T`.
#[test]
fn stable_fixed_point_has_its_negative_exponent() {
    for natural in [0.0, 3000.0] {
        let (w, ratio, c) = (1.3, 0.02, 400.0);
        let structure = common::structure(&[natural], ratio, &[w], &[w]);
        let mut drive = common::two_level_mesh(10e-6);
        drive.mesh = Division::levels(&[4e8], &[]);
        drive.damping = c;
        drive.transmission_error.clear();
        let mut point = common::strong_rattle();
        point.load = 0.5;
        let model = Model::new(&structure, &drive, point).unwrap();
        let zeta = if natural > 0.0 { ratio } else { 0.0 };
        let exact = -(zeta * natural + 0.5 * c * w * w) * model.period();
        let outcome = investigate(
            &model,
            &volterra(&model),
            model.start(&InitialState::Static),
            &questions(2, 100, 1000),
            &AtomicBool::new(false),
        )
        .unwrap();
        assert_eq!(
            outcome.class,
            Some(Class::SteadyContact(Some(1))),
            "{}",
            outcome.reason
        );
        let lyapunov = outcome.lyapunov.unwrap();
        let error = worst_difference(&lyapunov.exponents, &[exact, exact]);
        assert!(error < 1e-13, "{error:e}");
        assert!(lyapunov.stderr() < 1e-13);
    }
}

/// Two rigid bodies have the exponents of their relative rotation, without those of the neutral pair (two exponents 0).
#[test]
fn neutral_pair_is_left_out() {
    let (structure, mut drive, mut point) = common::two_modes();
    drive.mesh = Division::levels(&[4e8, 3.6e8], &[]);
    drive.transmission_error[0].amplitude = 1e-8;
    point.load = 1.0;
    let pair = Model::new(&structure, &drive, point).unwrap();
    let w = structure.mesh[0].hypot(structure.mesh[1]);
    let single = common::structure(&[0.0], 0.0, &[w], &[w]);
    let single = Model::new(&single, &drive, point).unwrap();
    assert_eq!((pair.neutral.len(), single.neutral.len()), (1, 0));
    let ask = |model: &Model| {
        let start: TrajectoryState = model.start(&InitialState::Static);
        let questions = questions(2, 500, 1000);
        let interrupt = AtomicBool::new(false);
        let outcome = investigate(model, &volterra(model), start, &questions, &interrupt).unwrap();
        outcome.lyapunov.unwrap().exponents
    };
    let (two, one) = (ask(&pair), ask(&single));
    assert!(worst_difference(&two, &one) < 1e-12, "{two:?} {one:?}");

    // In rattle, too, tangents of unit length never rotate into the neutral pair.
    let model = common::model(&common::two_modes());
    let norm = EnergyNorm::new(&model);
    let kernel = volterra(&model);
    let mut trajectory = settled(&model, 20);
    let mut growth = TangentGrowth::new(&norm, 2, 2, &mut Stream::new(3, 1, 4));
    for _ in 0..50 {
        kernel
            .advance_cycle(
                &mut trajectory,
                growth.tangents(),
                &mut kernel.workspace(),
                &mut (),
                &mut Counters::default(),
            )
            .unwrap();
        growth.cycle(&norm);
        let neutral = model.neutral[0];
        for i in 0..2 {
            let vector = growth.tangents().vector(i).to_vec();
            assert_eq!((vector[neutral], vector[2 + neutral]), (0.0, 0.0));
            assert!((norm.length(&vector) - 1.0).abs() < 1e-14);
        }
    }
}

/// Exponents beyond the dimension of a model are not reported.
#[test]
fn exponents_beyond_the_dimension_are_not_reported() {
    let model = common::model(&common::two_modes());
    let outcome = investigate(
        &model,
        &volterra(&model),
        model.start(&InitialState::Static),
        &questions(9, 100, 500),
        &AtomicBool::new(false),
    )
    .unwrap();
    assert_eq!(outcome.lyapunov.unwrap().exponents.len(), 2);
}

/// Tangents of a planar map, measured like those of a drive, in the plain norm of one mode.
fn planar_map(
    start: [f64; 2],
    cycles: usize,
    map: impl Fn([f64; 2]) -> ([f64; 2], [[f64; 2]; 2]),
) -> TangentGrowth {
    let norm = EnergyNorm::raw(&common::model(&common::one_degree()));
    let mut growth = TangentGrowth::new(&norm, 1, 2, &mut Stream::new(3, 1, 4));
    let mut at = start;
    for cycle in 0..cycles + 100 {
        let (next, jacobian) = map(at);
        at = next;
        for i in 0..2 {
            let [x, y] = [0, 1].map(|j| growth.tangents().vector(i)[j]);
            for (value, row) in growth.tangents().vector_mut(i).iter_mut().zip(&jacobian) {
                *value = row[0] * x + row[1] * y;
            }
        }
        growth.cycle(&norm);
        if cycle + 1 == 100 {
            growth.restart();
        }
    }
    growth
}

/// Hénon's map at a = 1.4, b = 0.3: exponents 0.41922 and −1.62319, Kaplan–Yorke dimension 1.25827 (Sprott, Chaos and
/// Time-Series Analysis, 2003). The uncertainty of the sum is only round-off.
#[test]
fn henons_map_has_its_published_exponents_and_dimension() {
    let henon = |[x, y]: [f64; 2]| {
        (
            [1.0 - 1.4 * x * x + y, 0.3 * x],
            [[-2.8 * x, 1.0], [0.3, 0.0]],
        )
    };
    let growth = planar_map([0.1, 0.1], 200_000, henon);
    let exponents = growth.exponents().unwrap();
    let series = growth.series();
    let errors: Vec<f64> = series.iter().map(|s| standard_error(s)).collect();
    for ((found, error), published) in exponents.iter().zip(&errors).zip([0.419_22, -1.623_19]) {
        assert!((1e-5..2e-3).contains(error), "{error:e}");
        assert!(
            (found - published).abs() < 3.0 * error + 1e-5,
            "{found} {error:e}"
        );
    }
    let sum: f64 = exponents.iter().sum();
    assert!((sum - 0.3f64.ln()).abs() < 1e-12, "{sum}");
    let filled = kaplan_yorke(&series, &exponents, 0.0, 2).unwrap();
    assert!(
        (filled.value - 1.258_27).abs() < 3.0 * filled.stderr + 1e-5 && filled.stderr < 1e-3,
        "{filled:?}"
    );
}

/// The standard map preserves areas: its exponents are ± one number, and at K = 10 that is `ln(K/2)` (Chirikov 1979)
/// within a few per cent; the chaotic sea fills the plane.
#[test]
fn the_standard_map_keeps_areas() {
    const K: f64 = 10.0;
    let standard = |[angle, momentum]: [f64; 2]| {
        let momentum = momentum + K * angle.sin();
        let jacobian = [[1.0 + K * angle.cos(), 1.0], [K * angle.cos(), 1.0]];
        (
            [(angle + momentum).rem_euclid(TAU), momentum.rem_euclid(TAU)],
            jacobian,
        )
    };
    let growth = planar_map([1.0, 2.0], 100_000, standard);
    let exponents = growth.exponents().unwrap();
    assert!((exponents[0] + exponents[1]).abs() < 1e-12, "{exponents:?}");
    assert!(
        (exponents[0] / (0.5 * K).ln() - 1.0).abs() < 0.03,
        "{exponents:?}"
    );
    let filled = kaplan_yorke(&growth.series(), &exponents, 0.0, 2).unwrap();
    assert!(
        (filled.value - 2.0).abs() < 1e-10 && filled.stderr < 1e-10,
        "{filled:?}"
    );
}
