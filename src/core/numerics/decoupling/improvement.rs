//! Newton steps with compensated residuals, which make the blocks accurate to round-off.

use super::parts::{Block, EQUAL_EIGENVALUES, IMPROVEMENTS};
use crate::numerics::linalg::dot;
use faer::{Mat, prelude::*};
use multiversion::multiversion;

/// Improves all invariant planes at once by Newton's method with compensated residuals. Returns the norm of
/// the residual.
///
/// From `A T = T (B + E)` follows `B_i X_ij - X_ij B_j = -E_ij`; then `T + T X` has the blocks
/// `B_i + E_ii` up to the square of the correction.
pub(super) fn improve(a: &Mat<f64>, blocks: &mut [Block]) -> f64 {
    let size = a.nrows();
    let rows: Vec<Vec<(usize, f64)>> = (0..size)
        .map(|i| {
            (0..size)
                .map(|k| (k, a[(i, k)]))
                .filter(|e| e.1 != 0.0)
                .collect()
        })
        .collect();
    let residual = |blocks: &[Block]| {
        let t: Vec<Vec<f64>> = (0..size)
            .map(|k| row(blocks, |b, c| b.columns[c][k]))
            .collect();
        let generator = [0, 1].map(|k| row(blocks, |b, c| b.generator[k][c]));
        compensated(size, |i, sums| {
            for (k, v) in &rows[i] {
                sums.add_multiple(*v, &t[*k]);
            }
            for (k, generator) in generator.iter().enumerate() {
                sums.add(&row(blocks, |b, _| -b.columns[k][i]), generator);
            }
        })
    };
    // Divide each row of a residual by the largest entry of this row of A, because a light drag makes small rows.
    let weight: Vec<f64> = rows
        .iter()
        .map(|r| r.iter().fold(0.0_f64, |m, e| m.max(e.1.abs())))
        .collect();
    let measure = |r: &Mat<f64>| {
        let entry = |i: usize, c: usize| {
            if weight[i] > 0.0 { r[(i, c)] / weight[i] } else { r[(i, c)] }
        };
        Mat::from_fn(size, size, entry).norm_l2()
    };
    let mut current = residual(blocks);
    for _ in 0..IMPROVEMENTS {
        let before = measure(&current);
        if before.is_nan() || before <= f64::EPSILON {
            break;
        }
        let t = columns(blocks);
        let e = t.partial_piv_lu().solve(&current);
        let mut x = Mat::<f64>::zeros(size, size);
        // A column whose residual is exactly zero is not changed.
        let exact: Vec<bool> = (0..size)
            .map(|c| (0..size).all(|k| current[(k, c)] == 0.0))
            .collect();
        for (i, j) in (0..blocks.len())
            .flat_map(|i| (0..blocks.len()).map(move |j| (i, j)))
            .filter(|(i, j)| i != j)
        {
            let target = [0, 1].map(|p| [0, 1].map(|q| -e[(2 * i + p, 2 * j + q)]));
            let step = sylvester(
                blocks[i].generator,
                blocks[j].generator,
                target,
                [exact[2 * j], exact[2 * j + 1]],
            );
            // The planes of blocks with common eigenvalues are arbitrary and give large steps: leave them
            // unchanged.
            if step.as_flattened().iter().all(|v| v.abs() < 0.5) {
                for (p, q) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    x[(2 * i + p, 2 * j + q)] = step[p][q];
                }
            }
        }
        let change = &t * &x;
        let next: Vec<Block> = blocks
            .iter()
            .enumerate()
            .map(|(b, block)| Block {
                columns: [0, 1].map(|c| {
                    (0..size)
                        .map(|i| block.columns[c][i] + change[(i, 2 * b + c)])
                        .collect()
                }),
                generator: [0, 1].map(|p| {
                    [0, 1].map(|q| {
                        block.generator[p][q]
                            + if exact[2 * b + q] { 0.0 } else { e[(2 * b + p, 2 * b + q)] }
                    })
                }),
                is_rotation: block.is_rotation,
            })
            .collect();
        let after = residual(&next);
        if measure(&after) < before || 2.0 * after.norm_l2() < current.norm_l2() {
            current = after;
            blocks
                .iter_mut()
                .zip(next)
                .for_each(|(old, new)| *old = new);
        } else {
            break;
        }
    }
    current.norm_l2()
}

/// Solves `B X - X C = E` for 2x2 matrices by elimination with complete pivoting; fixed columns of
/// `X` are zero.
pub(super) fn sylvester(
    b: [[f64; 2]; 2],
    c: [[f64; 2]; 2],
    e: [[f64; 2]; 2],
    fixed: [bool; 2],
) -> [[f64; 2]; 2] {
    let mut m = [[0.0; 5]; 4];
    for (p, q, k) in (0..8).map(|s| (s & 1, s >> 1 & 1, s >> 2)) {
        m[2 * p + q][2 * k + q] += if fixed[q] { 0.0 } else { b[p][k] };
        m[2 * p + q][2 * p + k] -= if fixed[k] { 0.0 } else { c[k][q] };
        m[2 * p + q][4] = e[p][q];
    }
    let (mut order, mut rank) = ([0, 1, 2, 3], 4);
    for k in 0..4 {
        let (mut row, mut column) = (k, k);
        for (i, j) in (k..4).flat_map(|i| (k..4).map(move |j| (i, j))) {
            if m[i][order[j]].abs() > m[row][order[column]].abs() {
                (row, column) = (i, j);
            }
        }
        // If the blocks have common eigenvalues, some unknowns are undetermined: set them to zero.
        if m[row][order[column]].abs() <= EQUAL_EIGENVALUES * m[0][order[0]].abs() {
            rank = k;
            break;
        }
        m.swap(k, row);
        order.swap(k, column);
        for i in k + 1..4 {
            let factor = m[i][order[k]] / m[k][order[k]];
            for j in 0..5 {
                m[i][j] -= factor * m[k][j];
            }
        }
    }
    let mut x = [0.0; 4];
    for k in (0..rank).rev() {
        let known: f64 = (k + 1..rank).map(|j| m[k][order[j]] * x[order[j]]).sum();
        x[order[k]] = (m[k][4] - known) / m[k][order[k]];
    }
    [[x[0], x[1]], [x[2], x[3]]]
}

/// Transforms a block for `mu ± i nu` to the form `[[mu, nu], [-nu, mu]]`; leaves other blocks unchanged. The free
/// phase is chosen such that the displacements in the first column are as large as possible. The columns have a
/// root mean square length of 1.
pub(super) fn standardise(block: &mut Block) {
    if !block.is_rotation {
        return;
    }
    let [[a, b], [c, d]] = block.generator;
    let (mu, half) = (0.5 * (a + d), 0.5 * (a - d));
    let nu = (-b * c - half * half).sqrt();
    // The columns of [[b, 0], [mu - a, nu]] give the real and imaginary part of the eigenvector. This matrix
    // is nearly nu I.
    let [first, second] = &block.columns;
    let size = first.len();
    let real: Vec<f64> = (0..size)
        .map(|i| (b * first[i] + (mu - a) * second[i]) / nu)
        .collect();
    let imaginary = second.clone();
    let half_size = size / 2;
    let (p, q) = (&real[..half_size], &imaginary[..half_size]);
    let phase = -0.5 * f64::atan2(2.0 * dot(p, q), dot(p, p) - dot(q, q));
    let length = (0.5 * (dot(&real, &real) + dot(&imaginary, &imaginary))).sqrt();
    let (sine, cosine) = (phase.sin() / length, phase.cos() / length);
    block.columns = [
        (0..size)
            .map(|i| real[i] * cosine - imaginary[i] * sine)
            .collect(),
        (0..size)
            .map(|i| real[i] * sine + imaginary[i] * cosine)
            .collect(),
    ];
    block.generator = [[mu, nu], [-nu, mu]];
}

/// A row with one number for each column of all blocks.
fn row(blocks: &[Block], value: impl Fn(&Block, usize) -> f64) -> Vec<f64> {
    let both = |block| [value(block, 0), value(block, 1)];
    blocks.iter().flat_map(both).collect()
}

/// Sums of products in twice the working precision, one per column of a matrix.
pub(super) struct Sums {
    sum: Vec<f64>,
    error: Vec<f64>,
}

impl Sums {
    /// Adds `factors[c] · values[c]` to the sum of every column c.
    fn add(&mut self, factors: &[f64], values: &[f64]) {
        add_products(factors, values, &mut self.sum, &mut self.error);
    }

    /// Adds `factor · values[c]` to the sum of every column c.
    pub(super) fn add_multiple(&mut self, factor: f64, values: &[f64]) {
        self.add(&vec![factor; values.len()], values);
    }
}

/// A square matrix whose rows are sums of products. `add` adds the products of a row.
pub(super) fn compensated(size: usize, add: impl Fn(usize, &mut Sums)) -> Mat<f64> {
    let mut out = Mat::zeros(size, size);
    for i in 0..size {
        let mut sums = Sums {
            sum: vec![0.0; size],
            error: vec![0.0; size],
        };
        add(i, &mut sums);
        for (c, (sum, error)) in sums.sum.iter().zip(&sums.error).enumerate() {
            out[(i, c)] = sum + error;
        }
    }
    out
}

/// Adds products to `sums`, and their rounding errors to `errors`. The error of a product is exact with any
/// instructions, so that all versions give the same bits. Without a fused multiply-add instruction, `mul_add`
/// is a function call, which takes most of the time of a decoupling.
#[multiversion(targets("x86_64+avx512f+fma", "x86_64+avx2+fma"))]
fn add_products(factors: &[f64], values: &[f64], sums: &mut [f64], errors: &mut [f64]) {
    let pairs = factors.iter().zip(values);
    for ((x, y), (sum, error)) in pairs.zip(sums.iter_mut().zip(errors)) {
        let product = x * y;
        let total = *sum + product;
        let back = total - *sum;
        *error += x.mul_add(*y, -product) + ((*sum - (total - back)) + (product - back));
        *sum = total;
    }
}

pub(super) fn norm(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

pub(super) fn unit_length(x: &[f64]) -> Vec<f64> {
    let length = norm(x);
    x.iter().map(|v| v / length).collect()
}

pub(super) fn columns(blocks: &[Block]) -> Mat<f64> {
    Mat::from_fn(2 * blocks.len(), 2 * blocks.len(), |i, c| {
        blocks[c / 2].columns[c % 2][i]
    })
}
