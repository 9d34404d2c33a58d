//! Single precision where the paper tried it: operators in 32 bits, the guard in 64. What an
//! operator costs in either, alone and out of a whole table, and what the rounding does to a
//! mesh cycle and its events.

use super::rattle::{CELLS, LIMIT, sixty_levels};
use super::rounds::{Contender, race};
use super::scenes::{drive, model_of, settled};
use gearatlas_core::analysis::EnergyNorm;
use gearatlas_paper::kernels::Spectral;
use gearatlas_verify::verify::candidate::Propagator;
use multiversion::multiversion;
use serde_json::{Value, json};
use std::hint::black_box;

/// Cycles that are compared.
const COMPARED: usize = 20;

/// Rows that are summed at once: as many sums as hide the latency of an addition.
const PANEL: usize = 48;

macro_rules! product {
    ($name:ident, $number:ty, $lanes:literal) => {
        /// `y = A x`, panels of rows, column after column, as the kernels' own products.
        #[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
        fn $name(a: &[$number], x: &[$number], y: &mut [$number]) {
            const GROUPS: usize = PANEL / $lanes;
            let mut rest = a;
            for y in y.chunks_exact_mut(PANEL) {
                let (panel, after) = rest.split_at(PANEL * x.len());
                let (lanes, _) = panel.as_chunks::<$lanes>();
                let mut sums = [[0.0; $lanes]; GROUPS];
                for (column, x) in lanes.as_chunks::<GROUPS>().0.iter().zip(x) {
                    for g in 0..GROUPS {
                        for l in 0..$lanes {
                            sums[g][l] = column[g][l].mul_add(*x, sums[g][l]);
                        }
                    }
                }
                y.copy_from_slice(sums.as_flattened());
                rest = after;
            }
        }
    };
}

product!(double, f64, 8);
product!(single, f32, 16);

/// Time of one product \[ns\] in 64 and in 32 bits, with `operators` of them in turn.
fn products(operators: usize) -> [f64; 2] {
    let columns: usize = 84;
    let rows = columns.next_multiple_of(PANEL);
    let entry = |i: usize| ((7 * i) % 19) as f64 / 19.0 - 0.5;
    let a: Vec<f64> = (0..operators * rows * columns).map(entry).collect();
    let b: Vec<f32> = a.iter().map(|a| *a as f32).collect();
    let x: Vec<f64> = (0..columns).map(entry).collect();
    let z: Vec<f32> = x.iter().map(|x| *x as f32).collect();
    let (mut y, mut w) = (vec![0.0; rows], vec![0.0; rows]);
    let size = rows * columns;
    let (mut at, mut by) = (0, 0);
    let spells = race(&mut [
        Contender::new(|| {
            double(&a[at * size..][..size], black_box(&x), &mut y);
            at = (at + 1) % operators;
        }),
        Contender::new(|| {
            single(&b[by * size..][..size], black_box(&z), &mut w);
            by = (by + 1) % operators;
        }),
    ]);
    [spells[0].median, spells[1].median]
}

pub fn precision() -> Value {
    let model = model_of(&sixty_levels(drive(40, 0.05, 1200.0)));
    let exact = Spectral::new(&model, CELLS, LIMIT, None).expect("tables");
    let mut arrays = Spectral::arrays(&model).expect("tables");
    for array in &mut arrays {
        if ["inverse", "matrix"].contains(&array.name) {
            for value in array.values.iter_mut() {
                *value = f64::from(*value as f32);
            }
        }
    }
    let rounded = Spectral::of_kept(&model, CELLS, LIMIT, None, &arrays).expect("tables");
    let norm = EnergyNorm::new(&model);
    let (mut state, mut time, mut astray) = (0.0f64, 0.0f64, 0);
    let mut start = settled(&model);
    for _ in 0..COMPARED {
        let [told, other] = [&exact, &rounded].map(|kernel| {
            kernel
                .passage(&start, 1)
                .expect("the default drive does not diverge")
        });
        let end = told.end;
        if told.events.len() == other.events.len() {
            state = state.max(norm.distance(&end.state, &other.end.state) / norm.unit());
            for (a, b) in told.events.iter().zip(&other.events) {
                time = time.max((a.time - b.time).abs() / model.period());
            }
        } else {
            astray += 1;
        }
        start = end;
    }
    let [alone, table] = [1, 122].map(products);
    json!({
        "state_error": state,
        "event_time_error": time,
        "cycles_astray": astray,
        "compared_cycles": COMPARED,
        "product_ns": { "alone": alone, "out of 122": table },
    })
}
