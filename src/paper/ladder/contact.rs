//! Constant contact: small steps for Table 1, segments and fused cycles, jumps over a million cycles, and a
//! work-precision comparison with adaptive solvers (Figure 6).

use super::adaptive::{Adaptive, Extrapolation, RungeKutta};
use super::rattle::{AnyKernel, CELLS, LIMIT, kernels, side_by_side};
use super::rounds::{Contender, race};
use super::scenes::{drive, model_of, quiet, relative_difference, settled};
use gearatlas_core::analysis::EnergyNorm;
use gearatlas_core::model::{Model, TrajectoryState};
use gearatlas_paper::kernels::{Fused, PowerJumps};
use gearatlas_verify::reference::Extended;
use serde_json::{Map, Value, json};
use std::hint::black_box;

/// Mesh cycles of a solution on the work-precision plane.
const SOLVED: u64 = 5;

/// Cycles after which segments and fused cycles are compared.
const COMPARED_CYCLES: u64 = 200;

const JUMP: u64 = 1_000_000;

/// Table 1: time of a mesh cycle with rattle by steps of 100 ns and by `volterra`, by number of modes.
pub fn small_steps() -> Value {
    let mut found = Map::new();
    for modes in [2, 6, 12, 20, 40] {
        let model = model_of(&drive(modes, 0.05, 1200.0));
        let start = settled(&model);
        let kernels = kernels(&model, &["stepping", "volterra"]);
        let mut value = side_by_side(&model, &start, &kernels);
        let steps = (model.period() / 1e-7).round();
        let cycle = value["stepping"]["ns"].as_f64().unwrap_or(f64::NAN);
        value["ns_a_step"] = json!(cycle / steps);
        found.insert(modes.to_string(), value);
    }
    Value::Object(found)
}

fn rubbed(modes: usize) -> Model {
    let mut case = quiet(modes);
    case.1.friction = 0.1;
    model_of(&case)
}

/// Entries of a state without those of the free rotation, which accumulates the round-off of a million integration
/// steps.
fn without_free_rotation(model: &Model, state: &[f64]) -> Vec<f64> {
    let n = model.modes();
    let kept = (0..2 * n).filter(|i| !model.neutral.contains(&(i % n)));
    kept.map(|i| state[i]).collect()
}

/// A cycle of constant contact by segments, by fused cells, by small steps and by `volterra`, and a million cycles at
/// once.
pub fn cycles() -> Value {
    let mut found = Map::new();
    for modes in [2, 6, 40] {
        let model = rubbed(modes);
        let start = settled(&model);
        let names = ["stepping", "hermite", "spectral", "fused", "volterra"];
        let kernels = kernels(&model, &names);
        let mut value = side_by_side(&model, &start, &kernels);
        let norm = EnergyNorm::new(&model);
        let end = |name: &str| -> TrajectoryState {
            let named = kernels.iter().find(|(known, ..)| known == name);
            let (.., kernel) = named.expect("a kernel of the list");
            kernel.go(&start, COMPARED_CYCLES).0
        };
        let distance = |a: &str, b: &str| norm.distance(&end(a).state, &end(b).state) / norm.unit();
        value["segments_against_fused"] = json!(distance("spectral", "fused"));
        value["volterra_against_fused"] = json!(distance("volterra", "fused"));
        value["compared_cycles"] = json!(COMPARED_CYCLES);
        value["jump"] = jump(&model, &start);
        found.insert(modes.to_string(), value);
    }
    Value::Object(found)
}

/// A million cycles by squaring, and their deviation from integration.
fn jump(model: &Model, start: &TrajectoryState) -> Value {
    let mut jumps = PowerJumps::new(model, JUMP).expect("tables");
    let mut jumped = start.clone();
    let products = jumps.jump(&mut jumped, JUMP);
    let integrated = Fused::new(model, CELLS, LIMIT)
        .expect("tables")
        .go(start, JUMP)
        .0;
    let [a, b] = [&jumped, &integrated].map(|end| without_free_rotation(model, &end.state));
    let mut on = start.clone();
    let spell = race(&mut [Contender::new(|| {
        jumps.jump(black_box(&mut on), JUMP);
    })])[0];
    json!({
        "ns": spell.median,
        "range": spell.range,
        "products": products,
        "against_integrating": relative_difference(&a, &b),
        "table_bytes": jumps.bytes().bytes,
    })
}

/// Figure 6: time of a solution over some cycles of constant contact against its error.
pub fn work_precision() -> Value {
    let model = model_of(&quiet(40));
    // Start from a state that is not settled, so that the solvers must follow the decay of the transient.
    let mut start = settled(&model);
    for x in &mut start.state {
        *x *= 1.0 + 1e-2;
    }
    let exact = Extended::new(&model)
        .advance(&start, SOLVED)
        .expect("no event");
    assert!(exact.crossings.is_empty(), "leaves contact");
    let norm = EnergyNorm::new(&model);
    let error = |state: &[f64]| norm.length(&exact.difference(state)) / norm.unit();
    let names = ["stepping", "spectral", "fused", "volterra"];
    let kernels = kernels(&model, &names);
    let mut jumps = PowerJumps::new(&model, SOLVED).expect("tables");
    let mut end = start.clone();
    jumps.jump(&mut end, SOLVED);
    let jumped = error(&end.state);
    let mut records = Vec::new();
    let mut contenders = Vec::new();
    for (name, _, kernel) in &kernels {
        let end = kernel.go(&start, SOLVED).0;
        records.push(json!({ "solver": name, "error": error(&end.state) }));
        let start = &start;
        contenders.push(Contender::new(move || {
            black_box(kernel.go(black_box(start), SOLVED));
        }));
    }
    records.push(json!({ "solver": "jump", "error": jumped }));
    contenders.push(Contender::new(|| {
        let mut on = start.clone();
        jumps.jump(black_box(&mut on), SOLVED);
    }));
    let scale = scale(&norm);
    for tolerance in (3..=13).map(|exponent| 10f64.powi(-exponent)) {
        let solvers: [(&str, Box<dyn Adaptive>); 2] = [
            (
                "Dormand-Prince 5(4)",
                Box::new(RungeKutta::new(&scale, tolerance)),
            ),
            (
                "extrapolation, order 14",
                Box::new(Extrapolation::new(&scale, tolerance)),
            ),
        ];
        for (name, mut solver) in solvers {
            let (state, evaluations) = solver.contact(&model, &start, SOLVED);
            records.push(json!({
                "solver": name,
                "tolerance": tolerance,
                "error": error(&state),
                "evaluations": evaluations,
            }));
            let (model, start) = (&model, &start);
            contenders.push(Contender::new(move || {
                black_box(solver.contact(model, start, SOLVED));
            }));
        }
    }
    let spells = race(&mut contenders);
    for (record, spell) in records.iter_mut().zip(spells) {
        record["ns"] = json!(spell.median);
    }
    let samples = Value::Array(records);
    json!({ "cycles": SOLVED, "period": model.period(), "modes": 40, "samples": samples })
}

/// The magnitude of each component with the energy of a displacement by half a gap.
fn scale(norm: &EnergyNorm) -> Vec<f64> {
    let scale = |weight: &f64| {
        if *weight > 0.0 { norm.unit() / weight } else { 1e30 }
    };
    norm.weights().iter().map(scale).collect()
}
