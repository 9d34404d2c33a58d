//! Times of products of operators with a state, over the number of alternating operators: Figures 4 and 5a.

use super::rounds::{Contender, race};
use faer::Mat;
use gearatlas_paper::kernels::Operator;
use serde_json::{Value, json};
use std::hint::black_box;

/// Rows and columns of the paper's operators.
const DIMENSIONS: [usize; 3] = [31, 41, 81];

/// Number of operators in a table of the paper. A single operator, which stays in the nearest cache, and operators of
/// [`BEYOND_CACHES`] bytes are measured too.
const TABLE: usize = 120;
const BEYOND_CACHES: usize = 256 << 20;

/// Time of a matrix-vector product \[ns\], by dimension and by number of operators applied in turn.
pub fn product_times() -> Value {
    let mut found = Vec::new();
    for dimension in DIMENSIONS {
        let most = BEYOND_CACHES / (8 * dimension * dimension);
        for operators in [1, TABLE, most] {
            let (ns, bytes) = time_of_product(dimension, operators);
            found.push(json!({
                "dimension": dimension,
                "operators": operators,
                "bytes": bytes,
                "ns": ns,
            }));
        }
    }
    Value::Array(found)
}

/// Median time of a product of matrix and vector \[ns\], with `count` matrices in turn, and the size of all matrices
/// \[bytes\].
fn time_of_product(dimension: usize, count: usize) -> (f64, usize) {
    let entry = |i: usize, j: usize| ((7 * i + 13 * j) % 19) as f64 / 19.0 - 0.5;
    let matrix = Mat::from_fn(dimension, dimension, entry);
    let operators: Vec<Operator> = (0..count).map(|_| Operator::new(matrix.as_ref())).collect();
    let x = vec![0.5; dimension.next_multiple_of(8)];
    let mut y = x.clone();
    let mut at = 0;
    let spell = race(&mut [Contender::new(|| {
        operators[at].apply(black_box(&x), &mut y);
        at = (at + 1) % count;
    })])[0];
    let bytes = operators.iter().map(Operator::bytes).sum();
    (spell.median, bytes)
}
