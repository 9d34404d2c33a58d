//! Is the reference integrator right? Comparison with closed forms, conservation laws, and a third integrator.

#![allow(clippy::unwrap_used)]

use crate::common;
use common::{drives, relative_difference, structure};
use gearatlas::model::{
    ActiveSet, Drive, InitialState, MeshHarmonic, Model, OperatingPoint, TrajectoryState,
};
use gearatlas::reference::{Passage, Reference};
use num_complex::{Complex64, c64};
use std::f64::consts::{PI, TAU};

/// Constant stiffness, no excitation.
fn plain(stiffness: f64, damping: f64, half_gap: f64) -> Drive {
    Drive {
        damping,
        ..common::constant_mesh(half_gap, stiffness)
    }
}

const POINT: OperatingPoint = OperatingPoint {
    load: 0.3,
    speed: 1200.0,
};

fn advance(model: &Model, start: &TrajectoryState, cycles: u64) -> Passage {
    Reference::new(model).advance(start, cycles).unwrap()
}

/// One degree in permanent contact under `e = a cos ωt`: `q'' + 2 β q' + Ω² q = L + w k b +
/// w (k e + c e')`, by complex amplitude plus damped free vibration.
#[test]
fn one_degree_in_contact_follows_its_closed_form() {
    for natural in [0.0, 6000.0] {
        let (w, ratio, k, c, b, a) = (1.3, 0.03, 4e8, 1483.0, 10e-6, 5e-8);
        let structure = structure(&[natural], ratio, &[w], &[w]);
        let mut drive = plain(k, c, b);
        drive.transmission_error = vec![MeshHarmonic::new(1, a, 0.0)];
        let model = Model::new(&structure, &drive, POINT).unwrap();
        let load = w * structure.rated_force * POINT.load;

        let zeta = if natural > 0.0 { ratio } else { 0.0 };
        let beta = zeta * natural + 0.5 * c * w * w;
        let square = natural * natural + k * w * w;
        let damped = (square - beta * beta).sqrt();
        let mean = (load + w * k * b) / square;
        // Complex amplitude of q: w a (k + iωc) / (Ω² − ω² + 2iβω).
        let omega = TAU / model.period();
        let impedance = c64(square - omega * omega, 2.0 * beta * omega);
        let amplitude = w * a * c64(k, omega * c) / impedance;
        let forced = |t: f64| {
            let turned = amplitude * Complex64::cis(omega * t);
            (mean + turned.re, -omega * turned.im)
        };

        // Add a free vibration of 1e-7 m √kg and 0.002 m √kg/s.
        let (p, v) = (1e-7, 2e-3);
        let (q0, v0) = forced(0.0);
        let start = TrajectoryState::new(&model, vec![q0 + p, v0 + v], 0);
        assert_eq!(start.contact, ActiveSet::DRIVE);
        for cycles in [1, 7, 40] {
            let passage = advance(&model, &start, cycles);
            assert!(passage.crossings.is_empty());
            let t = cycles as f64 * model.period();
            let (sin, cos) = (damped * t).sin_cos();
            let fall = (-beta * t).exp();
            let s = (v + beta * p) / damped;
            let (q, r) = forced(0.0);
            let exact = [
                q + fall * (p * cos + s * sin),
                r + fall * (v * cos - (beta * s + damped * p) * sin),
            ];
            let scale = [q0.abs(), (omega * amplitude.norm()).max(v)];
            for i in 0..2 {
                let error = (passage.end.state[i] - exact[i]).abs() / scale[i];
                assert!(error < 1e-13, "component {i}, {cycles} cycles: {error:e}");
            }
        }
    }
}

#[test]
fn free_flight_is_a_parabola_and_a_cosine() {
    let structure = structure(&[0.0, 5000.0], 0.0, &[0.8, 0.4], &[0.8, 0.4]);
    // A gap so wide that nothing ever touches.
    let model = Model::new(&structure, &plain(4e8, 1000.0, 10.0), POINT).unwrap();
    let start = TrajectoryState::new(&model, vec![1e-5, -2e-5, 0.05, 0.1], 0);
    let cycles = 30;
    let passage = advance(&model, &start, cycles);
    assert!(passage.crossings.is_empty());
    let t = cycles as f64 * model.period();
    let load = [0.8, 0.4].map(|p| p * structure.rated_force * POINT.load);
    let rest = load[1] / 5000f64.powi(2);
    let (sin, cos) = (5000.0 * t).sin_cos();
    let x = -2e-5 - rest;
    let exact = [
        1e-5 + 0.05 * t + 0.5 * load[0] * t * t,
        rest + x * cos + 0.1 / 5000.0 * sin,
        0.05 + load[0] * t,
        0.1 * cos - 5000.0 * x * sin,
    ];
    for i in 0..4 {
        let error = (passage.end.state[i] - exact[i]).abs() / exact[i].abs();
        assert!(error < 1e-13, "component {i}: {error:e}");
    }
}

/// A mass under constant force bounces on an elastic stop: a parabola in flight, a circle about the static deflection
/// in contact, both of known duration.
#[test]
fn bouncing_mass_hits_and_leaves_at_known_times() {
    let (w, k, b) = (1.3, 4e8, 10e-6);
    let structure = structure(&[0.0], 0.0, &[w], &[w]);
    let model = Model::new(&structure, &plain(k, 0.0, b), POINT).unwrap();
    let a = w * w * structure.rated_force * POINT.load;
    let natural = (k * w * w).sqrt();
    // The mass starts 15 µm before the stop, in the other half of the gap.
    let drop = 15e-6;
    let fall = (2.0 * drop / a).sqrt();
    let impact = a * fall;
    let touch = 2.0 * (PI - (impact * natural / a).atan()) / natural;
    let start = TrajectoryState::new(&model, vec![(b - drop) / w, 0.0], 0);
    assert_eq!(start.contact, ActiveSet::FREE);
    let period = 2.0 * fall + touch;
    let cycles = (20.0 * period / model.period()).ceil() as u64;
    let crossings = advance(&model, &start, cycles).crossings;
    assert!(crossings.len() >= 39);
    let mut worst = 0.0f64;
    for (i, crossing) in crossings.iter().enumerate() {
        let entry = i % 2 == 0;
        let bounce = (i / 2) as f64 * period;
        let exact = bounce + fall + if entry { 0.0 } else { touch };
        let time = crossing.cycle as f64 * model.period() + crossing.time;
        worst = worst.max((time - exact).abs() / exact);
        let (to, rate) =
            if entry { (ActiveSet::DRIVE, impact) } else { (ActiveSet::FREE, -impact) };
        assert_eq!(crossing.to, to);
        assert!((crossing.rate - rate).abs() < 1e-12 * impact);
    }
    assert!(worst < 1e-13, "{worst:e}");
}

/// A tangency is not a crossing, and slightly more is a pair of them: the static half gap is just above and just below
/// the top of a cosine.
#[test]
fn grazing_by_a_hair_is_seen() {
    let natural = 5000.0;
    let structure = structure(&[natural], 0.0, &[1.0], &[0.0]);
    let amplitude = 10e-6;
    for (gap, crossings) in [(1.0 + 1e-9, 0), (1.0 - 1e-9, 2)] {
        let model = Model::new(&structure, &plain(4e8, 0.0, amplitude * gap), POINT).unwrap();
        // The motion starts a quarter period before the top; a cycle contains a fifth of a period.
        let start = TrajectoryState::new(&model, vec![0.0, natural * amplitude], 0);
        let cycles = (0.4 * TAU / natural / model.period()).ceil() as u64;
        let found = advance(&model, &start, cycles).crossings;
        assert_eq!(found.len(), crossings, "gap {gap}");
    }
}

#[test]
fn undamped_rattle_conserves_energy() {
    let k = 4e8;
    let (structure, _, point) = common::six_modes();
    let structure = structure_without_damping(structure);
    let model = Model::new(&structure, &plain(k, 0.0, 10e-6), point).unwrap();
    let n = model.modes();
    let energy = |state: &[f64]| -> f64 {
        let mut sum = 0.0;
        for (i, block) in model.blocks.iter().enumerate() {
            let (q, v) = (state[i], state[n + i]);
            let natural = block.natural_frequency();
            sum += 0.5 * (v * v + natural * natural * q * q) - block.static_input[1] * q;
        }
        let (deflection, _) = model.deflection(state, 0.0);
        let squeeze = (deflection.abs() - model.half_gap).max(0.0);
        sum + 0.5 * k * squeeze * squeeze
    };
    // Start in motion, with a modal velocity of 0.1 m √kg/s in every mode with a mesh participation.
    let mut start = model.start(&InitialState::Static);
    for i in 1..n {
        start.state[n + i] = 0.1;
    }
    let before = energy(&start.state);
    let passage = advance(&model, &start, 300);
    assert!(passage.crossings.len() > 300);
    let change = (energy(&passage.end.state) - before).abs() / before.abs();
    assert!(change < 1e-11, "{change:e}");
}

fn structure_without_damping(
    mut s: gearatlas::structure::ModalStructure,
) -> gearatlas::structure::ModalStructure {
    s.damping.fill(0.0);
    s
}

#[test]
fn every_drive_rattles_and_a_finer_step_agrees() {
    for (name, case) in drives() {
        let model = common::model(&case);
        let reference = Reference::new(&model);
        let settled = advance(&model, &model.start(&InitialState::Static), 60);
        let late = settled.crossings.iter().filter(|c| c.cycle >= 40).count();
        assert!(late >= 20, "{name}: {late} events in 20 cycles");

        let coarse = reference.advance(&settled.end, 2).unwrap();
        let fine = reference
            .clone()
            .refined(3)
            .advance(&settled.end, 2)
            .unwrap();
        let error = relative_difference(&coarse.end.state, &fine.end.state);
        assert!(error < 1e-12, "{name}: {error:e}");
        assert!(!fine.crossings.is_empty());
        assert_eq!(coarse.crossings.len(), fine.crossings.len());
        for (a, b) in coarse.crossings.iter().zip(&fine.crossings) {
            assert_eq!((a.cycle, a.from, a.to), (b.cycle, b.from, b.to));
            assert!((a.time - b.time).abs() < 1e-13 * model.period());
        }
    }
}

/// Two cycles at once equal two single ones.
#[test]
fn an_integration_can_be_split() {
    let model = common::model(&common::six_modes());
    let start = model.start(&InitialState::Static);
    let whole = advance(&model, &start, 6);
    let half = advance(&model, &start, 3);
    let rest = advance(&model, &half.end, 3);
    assert_eq!(rest.end.cycle, whole.end.cycle);
    assert_eq!(rest.end.contact, whole.end.contact);
    let error = relative_difference(&rest.end.state, &whole.end.state);
    assert!(error < 1e-13, "{error:e}");
    let joined = half.crossings.len() + rest.crossings.len();
    assert_eq!(joined, whole.crossings.len());
}

/// A third integrator: Verner's 9(8) pair of the `differential-equations` crate between two crossings.
mod general_purpose {
    use super::*;
    use differential_equations::methods::ExplicitRungeKutta;
    use differential_equations::ode::{ODE, OrdinaryNumericalMethod};
    use gearatlas::model::Segment;

    struct Smooth<'m> {
        model: &'m Model,
        segment: &'m Segment,
        contact: ActiveSet,
    }

    impl ODE<f64, Vec<f64>> for Smooth<'_> {
        fn diff(&self, t: f64, y: &Vec<f64>, out: &mut Vec<f64>) {
            self.model
                .derivative(&[*self.segment; 2], self.contact, 0, t, y, out);
        }
    }

    #[test]
    fn solver_agrees_on_a_cycle_in_contact() {
        let (structure, mut drive, point) = common::forty_modes();
        drive.transmission_error = vec![MeshHarmonic::new(1, 2e-8, 0.0)];
        let model = Model::new(&structure, &drive, point).unwrap();
        let start = model.start(&InitialState::Static);
        let passage = advance(&model, &start, 1);
        assert!(passage.crossings.is_empty(), "left contact");

        let mut state = start.state.clone();
        for (index, segment) in model.first_cycle().segments.iter().enumerate() {
            let (left, right) = (
                model.first_cycle().start(index),
                model.first_cycle().end(index),
            );
            let smooth = Smooth {
                model: &model,
                segment,
                contact: ActiveSet::DRIVE,
            };
            // At least seventeen steps per radian of the fastest mode, and no error control.
            let h = (right - left) / 400.0;
            let mut solver = ExplicitRungeKutta::rkv988e()
                .h0(h)
                .h_max(h)
                .rtol(1.0)
                .atol(1.0);
            solver.init(&smooth, left, right, &state).unwrap();
            for _ in 0..400 {
                solver.set_h(h);
                solver.step(&smooth).unwrap();
            }
            assert!((solver.t() - right).abs() < 1e-12 * right);
            state.clone_from(solver.y());
        }
        let error = relative_difference(&state, &passage.end.state);
        assert!(error < 1e-11, "{error:e}");
    }
}
