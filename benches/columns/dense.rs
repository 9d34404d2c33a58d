//! Products of a dense operator with 1, 2, 4 and 8 columns: the operators of the table kernels, in
//! their panels, read once for all columns.

use crate::rounds::{Contender, race};
use crate::{COLUMNS, told};
use faer::Mat;
use gearatlas_paper::kernels::Operator;
use multiversion::multiversion;
use serde_json::{Value, json};

const LANES: usize = 8;

/// Lane groups in a panel of an operator.
const PANEL: usize = 6;

/// Rows and columns of the operators of 40, 160 and 640 modes.
const DIMENSIONS: [usize; 3] = [81, 321, 1281];

/// Bytes of the alternating operators: a single one, the 18 MB of a table of 40 modes in 60 segments, and more than the
/// share of one process in a shared cache.
const SETS: [(&str, usize); 3] = [("one", 0), ("18 MiB", 18 << 20), ("768 MiB", 768 << 20)];

/// `y += A x` for `C` columns, consecutive in `x` and `y`; sums of `G` lane groups at a time stay in registers.
#[inline(always)]
fn strip<const C: usize, const G: usize>(
    panel: &[[f64; LANES]],
    width: usize,
    from: usize,
    x: &[f64],
    y: &mut [f64],
    row: usize,
) {
    let (n, rows) = (x.len() / C, y.len() / C);
    let mut sums = [[[0.0; LANES]; G]; C];
    let columns: [&[f64]; C] = std::array::from_fn(|c| &x[c * n..][..n]);
    for (j, column) in panel.chunks_exact(width).enumerate() {
        let lanes = &column[from..][..G];
        for c in 0..C {
            let value = columns[c][j];
            for g in 0..G {
                for l in 0..LANES {
                    sums[c][g][l] = lanes[g][l].mul_add(value, sums[c][g][l]);
                }
            }
        }
    }
    for (c, sums) in sums.iter().enumerate() {
        y[c * rows + row..][..G * LANES].copy_from_slice(sums.as_flattened());
    }
}

/// Products with `C` columns, by strips of at most `G` lane groups.
#[inline(always)]
fn panels<const C: usize, const G: usize>(numbers: &[f64], x: &[f64], y: &mut [f64]) {
    let (mut data, _) = numbers.as_chunks::<LANES>();
    let (n, groups) = (x.len() / C, y.len() / C / LANES);
    for first in (0..groups).step_by(PANEL) {
        let width = PANEL.min(groups - first);
        let (panel, rest) = data.split_at(width * n);
        let mut from = 0;
        while from < width {
            let row = (first + from) * LANES;
            if width - from >= G {
                strip::<C, G>(panel, width, from, x, y, row);
                from += G;
            } else {
                strip::<C, 1>(panel, width, from, x, y, row);
                from += 1;
            }
        }
        data = rest;
    }
}

macro_rules! product {
    ($name:ident, $columns:literal, $groups:literal) => {
        #[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
        fn $name(numbers: &[f64], x: &[f64], y: &mut [f64]) {
            panels::<$columns, $groups>(numbers, x, y);
        }
    };
}

product!(two, 2, 6);
product!(four, 4, 6);
product!(eight, 8, 3);

fn apply(columns: usize, operator: &Operator, x: &[f64], y: &mut [f64]) {
    match columns {
        1 => operator.apply(x, y),
        2 => two(operator.numbers(), x, y),
        4 => four(operator.numbers(), x, y),
        _ => eight(operator.numbers(), x, y),
    }
}

/// Asserts that products with several columns equal those of single columns.
fn check(operator: &Operator, dimension: usize) {
    let rows = dimension.next_multiple_of(LANES);
    for columns in COLUMNS {
        let x: Vec<f64> = (0..columns * dimension)
            .map(|i| (i % 13) as f64 - 6.0)
            .collect();
        let mut y = vec![f64::NAN; columns * rows];
        apply(columns, operator, &x, &mut y);
        for c in 0..columns {
            let mut alone = vec![f64::NAN; rows];
            operator.apply(&x[c * dimension..][..dimension], &mut alone);
            assert_eq!(alone, y[c * rows..][..rows], "column {c} of {columns}");
        }
    }
}

/// Nanoseconds of a product, by dimension and by set of alternating operators.
pub fn products() -> Value {
    let mut found = Vec::new();
    for dimension in DIMENSIONS {
        // Sums of integers are exact in any order.
        let matrix = Mat::from_fn(dimension, dimension, |i, j| {
            ((7 * i + 13 * j) % 19) as f64 - 9.0
        });
        check(&Operator::new(matrix.as_ref()), dimension);
        for (name, bytes) in SETS {
            let one = Operator::new(matrix.as_ref());
            let count = (bytes / one.bytes()).max(1);
            let operators: Vec<Operator> =
                (0..count).map(|_| Operator::new(matrix.as_ref())).collect();
            let operators = &operators;
            let rows = dimension.next_multiple_of(LANES);
            let mut contenders: Vec<Contender<'_>> = (COLUMNS.iter())
                .map(|&columns| {
                    let x = vec![0.5; columns * dimension];
                    let mut y = vec![0.0; columns * rows];
                    let mut at = 0;
                    Contender::new(move || {
                        at = (at + 1) % operators.len();
                        apply(columns, &operators[at], &x, &mut y);
                    })
                })
                .collect();
            found.push(json!({
                "dimension": dimension,
                "set": name,
                "operators": count,
                "product_ns": told(&race(&mut contenders)),
            }));
        }
    }
    Value::Array(found)
}
