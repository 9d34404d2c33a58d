//! Single precision as in the paper: products in 32 bits, the search for events in 64.
//!
//! The kernel `spectral` is timed in both precisions, and the error of single precision is measured. A product is also
//! timed, alone and with as many matrices as a whole table, to show its share of the time.

use super::rattle::{CELLS, LIMIT, kernels, side_by_side, sixty_levels};
use super::rounds::{Contender, race};
use super::scenes::{Case, drive, model_of, settled};
use faer::Mat;
use gearatlas_core::analysis::EnergyNorm;
use gearatlas_paper::kernels::{Operator, SingleOperator, Spectral};
use gearatlas_verify::verify::candidate::Propagator;
use serde_json::{Map, Value, json};
use std::hint::black_box;

/// Cycles that are compared.
const COMPARED_CYCLES: usize = 20;

/// Time of one product \[ns\] in 64 and in 32 bits, with `operators` matrices in turn.
fn products(operators: usize) -> [f64; 2] {
    const SIZE: usize = 96;
    let matrix = Mat::from_fn(SIZE, SIZE, |i, j| {
        ((7 * i + 3 * j) % 19) as f64 / 19.0 - 0.5
    });
    let double: Vec<Operator> = (0..operators)
        .map(|_| Operator::new(matrix.as_ref()))
        .collect();
    let single: Vec<SingleOperator> = (0..operators)
        .map(|_| SingleOperator::new(matrix.as_ref()))
        .collect();
    let x = [0.3; SIZE];
    let (mut y, mut z) = ([0.0; SIZE], [0.0; SIZE]);
    let (mut at, mut by) = (0, 0);
    let spells = race(&mut [
        Contender::new(|| {
            double[at].apply(black_box(&x), &mut y);
            at = (at + 1) % operators;
        }),
        Contender::new(|| {
            single[by].apply(black_box(&x), &mut z);
            by = (by + 1) % operators;
        }),
    ]);
    [spells[0].median, spells[1].median]
}

/// `spectral` in double and in single precision: times, work, and the largest difference after one cycle from equal
/// starts.
fn path(case: &Case) -> Value {
    let model = model_of(case);
    let start = settled(&model);
    let kernels = kernels(&model, &["spectral", "spectral, single precision"]);
    let mut value = side_by_side(&model, &start, &kernels);
    let double = Spectral::new(&model, CELLS, LIMIT, None).expect("tables");
    let single = Spectral::in_single_precision(&model, CELLS, LIMIT).expect("tables");
    let norm = EnergyNorm::new(&model);
    let (mut state, mut time, mut other_events) = (0.0f64, 0.0f64, 0);
    let mut at = start;
    for _ in 0..COMPARED_CYCLES {
        let [exact, rounded] = [&double, &single].map(|kernel| {
            let passage = kernel.passage(&at, 1);
            passage.expect("the default drive does not diverge")
        });
        let end = exact.end;
        if exact.events.len() == rounded.events.len() {
            state = state.max(norm.distance(&end.state, &rounded.end.state) / norm.unit());
            for (a, b) in exact.events.iter().zip(&rounded.events) {
                time = time.max((a.time - b.time).abs() / model.period());
            }
        } else {
            other_events += 1;
        }
        at = end;
    }
    value["state_error"] = json!(state);
    value["event_time_error"] = json!(time);
    value["cycles_with_other_events"] = json!(other_events);
    value["compared_cycles"] = json!(COMPARED_CYCLES);
    value
}

pub fn precision() -> Value {
    let scenes = [
        ("6 modes", drive(6, 0.05, 1200.0)),
        ("40 modes", sixty_levels(drive(40, 0.05, 1200.0))),
    ];
    let path: Map<String, Value> = (scenes.iter())
        .map(|(name, case)| ((*name).to_owned(), path(case)))
        .collect();
    let [alone, table] = [1, 122].map(products);
    json!({ "path": path, "product_ns": { "alone": alone, "out of 122": table } })
}
