//! How fast is a general-purpose solver at the same accuracy?
//!
//! ```text
//! scripts/record peers        builds this, runs it and records table and picture under benches/runs/
//! ```
//!
//! Every solver advances the same stretches of five rattling cycles from the same settled states. Errors are those of
//! the final states against the extended-precision integrator, in the energy norm and half gaps. Set-up (tables, solver
//! objects) is not timed. The clock is the thread's processor time. All run in one process on one thread, so that their
//! ratios are comparable.

#[path = "../../../tests/common/mod.rs"]
mod common;

mod clock;
mod cvode;
mod events;
mod field;
mod measure;
mod packaged;
mod runge_kutta;
mod sundials;
mod vectors;

use cvode::{Cvode, Method, Vectors};
use events::Failure;
use field::Field;
use gearatlas::propagate::{Stepping, Volterra};
use gearatlas::reference::Reference;
use measure::{CYCLES, Problem, Sample};
use packaged::Packaged;
use runge_kutta::RungeKutta;
use serde_json::{Value, json};

/// Number of sweeps over all solvers. Processors change their speed, which affects alternating codes equally.
const ROUNDS: usize = 3;

/// Tolerances of the adaptive solvers: 10⁻⁴ … 10⁻¹⁴.
fn tolerances() -> impl Iterator<Item = f64> {
    (4..=14).map(|e| 10f64.powi(-e))
}

fn main() {
    let problems = [
        Problem::new("40 modes", &common::forty_modes()),
        Problem::new("6 modes", &common::six_modes()),
    ];
    let mut results = Vec::new();
    for problem in &problems {
        eprintln!(
            "{}: {:.1} events a cycle; extended run within {:.0e} half gaps",
            problem.name, problem.events_per_cycle, problem.uncertainty
        );
        let sweep = || adaptive(problem).into_iter().chain(kernels(problem));
        let mut samples: Vec<Sample> = sweep().collect();
        for _ in 1..ROUNDS {
            for (sample, again) in samples.iter_mut().zip(sweep()) {
                sample.merge(again);
            }
        }
        for sample in &samples {
            eprintln!("  {}", sample.line());
            results.push(sample.json(problem));
        }
    }
    let record = json!({
        "cycles": CYCLES,
        "problems": problems.iter().map(Problem::json).collect::<Vec<Value>>(),
        "samples": results,
    });
    println!("{record:#}");
}

/// The general-purpose solvers, over tolerances.
fn adaptive(problem: &Problem) -> Vec<Sample> {
    let scale = problem.scale();
    let field = Field::new(&problem.model, 0);
    let mut samples = Vec::new();
    for tolerance in tolerances() {
        let mut add = |name: &str, solver: &mut dyn FnMut(usize) -> Result<Vec<f64>, Failure>| {
            samples.push(problem.measure(name, tolerance, solver));
        };
        for (name, method, vectors) in [
            ("CVODE Adams", Method::Adams, Vectors::Compiled),
            ("CVODE Adams (Debian)", Method::Adams, Vectors::Packaged),
            ("CVODE BDF", Method::Bdf, Vectors::Compiled),
        ] {
            let mut solver = Cvode::new(method, vectors, &field, tolerance, &scale);
            add(name, &mut |i| problem.adaptive(&mut solver, i));
        }
        let mut solver = RungeKutta::dop853(tolerance, &scale);
        add("DOP853", &mut |i| problem.adaptive(&mut solver, i));
        let mut solver = RungeKutta::verner98(tolerance, &scale);
        add("Verner 9(8)", &mut |i| problem.adaptive(&mut solver, i));
        let mut solver = Packaged::new(tolerance, &scale);
        add("DOP853 (crate)", &mut |i| problem.adaptive(&mut solver, i));
    }
    samples
}

/// The program's kernels and its reference integrator, over their settings.
fn kernels(problem: &Problem) -> Vec<Sample> {
    let model = &problem.model;
    let mut samples = Vec::new();
    for tolerance in [1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14, f64::EPSILON] {
        let kernel = Volterra::new(model, tolerance, 1000);
        let mut integration = problem.kernel(&kernel);
        samples.push(problem.measure("volterra", tolerance, &mut integration));
    }
    for step in [1e-6, 3e-7, 1e-7, 3e-8, 1e-8] {
        let kernel = Stepping::new(model, (model.period() / step) as u32, 1000);
        let mut integration = problem.kernel(&kernel);
        samples.push(problem.measure("stepping", step, &mut integration));
    }
    let reference = Reference::new(model);
    samples.push(problem.measure("reference", 0.0, &mut |i| {
        let passage = reference.advance(&problem.starts[i], CYCLES);
        let passage = passage.map_err(|e| Failure(e.to_string()))?;
        Ok(passage.end.state)
    }));
    samples
}
