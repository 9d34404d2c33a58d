//! Comparison of impacts on a rigid stop with closed forms.

use super::report::worse;
use super::{CheckError, Line, Subjects};
use crate::model::{Drive, InitialState, Model, OperatingPoint, TrajectoryState};
use crate::propagate::Event;
use crate::structure::{ContactLaw, HarmonicLoad, ModalStructure, StructureContact};
use std::f64::consts::TAU;

/// Distance of the stop \[m\].
const GAP: f64 = 0.1;

/// A half gap of the mesh that no motion reaches \[m\].
const FAR: f64 = 1e3;

const RESTITUTION: f64 = 0.8;

/// A unit mass in front of a rigid stop, with a natural frequency \[rad/s\] and a damping ratio.
fn mass(frequency: f64, ratio: f64) -> ModalStructure {
    let law = ContactLaw {
        gap: GAP,
        ..ContactLaw::default()
    };
    let stop = StructureContact::plain("stop".to_owned(), vec![1.0], law);
    ModalStructure {
        contacts: stop.rigid(RESTITUTION).to_vec(),
        ..ModalStructure::of_modes(&[frequency], ratio, &[1.0], &[1.0])
    }
}

fn model(structure: &ModalStructure, speed: f64) -> Result<Model, CheckError> {
    let point = OperatingPoint { load: 0.0, speed };
    Ok(Model::new(structure, &Drive::constant(FAR, 1.0), point)?)
}

/// Times of the impacts of a mass that falls onto the stop, and the time at which it rests. With the acceleration g it
/// arrives at `t₀ = √(2 b/g)` with the speed `v = g t₀`. The flight after impact n takes `2 εⁿ v/g`. All flights
/// together take `2 v/g · ε/(1 − ε)`.
fn falling(subjects: &Subjects, lines: &mut Vec<Line>) -> Result<(), CheckError> {
    let pull = 9.81;
    let structure = ModalStructure {
        constant_load: vec![pull],
        ..mass(0.0, 0.0)
    };
    let model = model(&structure, TAU)?;
    let impact = model.stops[0].impact;
    let first = (2.0 * GAP / pull).sqrt();
    let rest = first * (1.0 + 2.0 * RESTITUTION / (1.0 - RESTITUTION));
    let cycles = (rest / model.period()).ceil() as u64 + 1;
    for kernel in subjects.kernels.iter().filter(|k| k.supports(&model)) {
        let start = model.start(&InitialState::Rest);
        let passage = kernel.on(&model)?.passage(&start, cycles)?;
        let time = |event: &Event| event.cycle as f64 * model.period() + event.time;
        let (mut exact, mut worst, mut count) = (first, 0.0f64, 0);
        let impacts = |event: &&Event| event.contact == impact && event.closes();
        for event in passage.events.iter().filter(impacts) {
            worst = worse(worst, (time(event) - exact).abs());
            count += 1;
            exact += 2.0 * first * RESTITUTION.powi(count);
        }
        let held = passage.events.iter().rfind(|event| event.contact != impact);
        lines.push(Line::at_most(
            format!(
                "{}: times of {count} impacts of a falling mass",
                kernel.name
            ),
            "t0 (1 + 2 (r + r^2 + ...))",
            if count > 20 { worst / first } else { f64::NAN },
            // The last flights are short: round-off of the position divided by their speed moves the impacts.
            1e-11,
            "first fall",
        ));
        lines.push(Line::at_most(
            format!("{}: time at which the mass rests", kernel.name),
            "t0 (1 + 2 r/(1 - r))",
            held.map_or(f64::NAN, |event| (time(event) / rest - 1.0).abs()),
            1e-12,
            "relative",
        ));
    }
    Ok(())
}

/// The sum of the exponents of a shaken mass over single cycles. Each impact contracts areas of the plane of position and
/// velocity by ε², and the damper by `e^{−2ζωT}` per cycle.
fn contraction(subjects: &Subjects, lines: &mut Vec<Line>) -> Result<(), CheckError> {
    let (ratio, shaken) = (0.02, 2.4);
    let structure = ModalStructure {
        harmonic_loads: vec![HarmonicLoad {
            name: "shaker".to_owned(),
            force: vec![1.0],
            turns_per_cycle: 1.0,
            phase: 0.3,
        }],
        ..mass(1.0, ratio)
    };
    let model = model(&structure, shaken)?;
    for kernel in subjects.kernels.iter().filter(|k| k.supports(&model)) {
        let propagator = kernel.on(&model)?;
        let mut start = TrajectoryState::new(&model, vec![0.0; 2], 0);
        let (mut worst, mut impacts) = (0.0f64, 0);
        let cycles = subjects.extent.pick(50, 5000);
        for _ in 0..cycles {
            let passage = propagator.passage(&start, 1)?;
            let multipliers = propagator.multipliers(&model, &start)?;
            let found: Option<f64> = multipliers.map(|all| all.iter().map(|m| m.norm().ln()).sum());
            let count = passage.events.iter().filter(|event| event.closes()).count();
            let exact = 2.0 * count as f64 * RESTITUTION.ln() - 2.0 * ratio * model.period();
            worst = worse(worst, found.map_or(f64::NAN, |found| (found - exact).abs()));
            impacts += count;
            start = passage.end;
        }
        lines.push(Line::at_most(
            format!("{}: sum of both exponents, {impacts} impacts", kernel.name),
            "2 ln r per impact - 2 zeta w T",
            if 2 * impacts > cycles as usize { worst } else { f64::NAN },
            1e-11,
            "1/cycle",
        ));
    }
    Ok(())
}

/// Compares the motion of a mass with a rigid stop with closed forms.
pub fn impacts(subjects: &Subjects) -> Result<Vec<Line>, CheckError> {
    let mut lines = Vec::new();
    falling(subjects, &mut lines)?;
    contraction(subjects, &mut lines)?;
    Ok(lines)
}
