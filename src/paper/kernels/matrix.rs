//! Dense operators and their products with a vector: the inner loops of the table kernels.
//!
//! An operator is stored in panels of up to 48 rows. Within a panel, columns are consecutive, so that a product reads
//! memory once and in order while its sums stay in registers. Rows are padded to a multiple of 8 doubles and start on
//! cache lines. The instruction set is chosen at run time. Results differ between sets within rounding (fused or
//! separate multiply-add), but never between runs with one set.

use faer::MatRef;
use multiversion::multiversion;
use multiversion::target::target_cfg_f;

/// Doubles in a lane group.
pub const LANES: usize = 8;

/// Lane groups in a panel: enough sums to hide the latency of an addition.
const PANEL: usize = 6;

/// Bytes of a cache line.
const LINE: usize = 64;

/// `count` rounded up to whole lane groups.
pub fn padded(count: usize) -> usize {
    count.next_multiple_of(LANES)
}

/// A dense matrix, ready for products with a vector.
#[derive(Debug)]
pub struct Operator {
    data: Vec<f64>,
    /// Index in `data` of the first number, which is at the start of a cache line.
    from: usize,
    groups: usize,
    columns: usize,
}

impl Operator {
    /// The operator of a matrix.
    pub fn new(matrix: MatRef<'_, f64>) -> Self {
        let (rows, columns) = (matrix.nrows(), matrix.ncols());
        let groups = padded(rows) / LANES;
        let entry = |row: usize, column: usize| {
            if row < rows { matrix[(row, column)] } else { 0.0 }
        };
        let mut data: Vec<f64> = Vec::with_capacity(groups * columns * LANES + LANES);
        let from = data.as_ptr().align_offset(LINE).min(LANES);
        data.resize(from, 0.0);
        for panel in (0..groups).step_by(PANEL) {
            for column in 0..columns {
                for group in panel..groups.min(panel + PANEL) {
                    let row = group * LANES;
                    data.extend((row..row + LANES).map(|row| entry(row, column)));
                }
            }
        }
        Self {
            data,
            from,
            groups,
            columns,
        }
    }

    /// All entries and the padding, in the order in which a product reads them.
    pub fn numbers(&self) -> &[f64] {
        &self.data[self.from..]
    }

    /// One entry.
    pub fn entry(&self, row: usize, column: usize) -> f64 {
        let group = row / LANES;
        let panel = group - group % PANEL;
        let width = PANEL.min(self.groups - panel);
        let lanes = panel * self.columns + column * width + group - panel;
        self.numbers()[lanes * LANES + row % LANES]
    }

    /// Writes the product with `x` (at least one entry per column) to `y` (at least one entry per padded row).
    pub fn apply(&self, x: &[f64], y: &mut [f64]) {
        y[..self.groups * LANES].fill(0.0);
        self.apply_more(x, y);
    }

    /// Adds the product with `x` to `y`, lengths as for [`apply`](Self::apply).
    pub fn apply_more(&self, x: &[f64], y: &mut [f64]) {
        multiply(
            self.numbers(),
            &x[..self.columns],
            &mut y[..self.groups * LANES],
        );
    }

    /// Bytes of the table.
    pub fn bytes(&self) -> usize {
        size_of_val(self.numbers())
    }
}

/// Numbers of an operator with these rows and columns, including padding.
pub fn numbers_of(rows: usize, columns: usize) -> usize {
    padded(rows) * columns
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
fn multiply(numbers: &[f64], x: &[f64], y: &mut [f64]) {
    let (data, _) = numbers.as_chunks::<LANES>();
    if target_cfg_f!(target_feature = "fma") {
        panels::<true>(data, x, y);
    } else {
        panels::<false>(data, x, y);
    }
}

#[inline(always)]
fn panels<const FUSED: bool>(mut data: &[[f64; LANES]], x: &[f64], y: &mut [f64]) {
    for y in y.chunks_mut(PANEL * LANES) {
        let groups = y.len() / LANES;
        let (panel, rest) = data.split_at(groups * x.len());
        match groups {
            6 => rows::<6, FUSED>(panel, x, y),
            5 => rows::<5, FUSED>(panel, x, y),
            4 => rows::<4, FUSED>(panel, x, y),
            3 => rows::<3, FUSED>(panel, x, y),
            2 => rows::<2, FUSED>(panel, x, y),
            _ => rows::<1, FUSED>(panel, x, y),
        }
        data = rest;
    }
}

/// A panel of `G` lane groups.
#[inline(always)]
fn rows<const G: usize, const FUSED: bool>(panel: &[[f64; LANES]], x: &[f64], y: &mut [f64]) {
    let mut sums = [[0.0; LANES]; G];
    sums.as_flattened_mut().copy_from_slice(y);
    let (columns, _) = panel.as_chunks::<G>();
    for (column, value) in columns.iter().zip(x) {
        for g in 0..G {
            for l in 0..LANES {
                sums[g][l] = fma::<FUSED>(column[g][l], *value, sums[g][l]);
            }
        }
    }
    y.copy_from_slice(sums.as_flattened());
}

#[inline(always)]
pub(super) fn fma<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

/// `Σ a b`, over whole lane groups.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [[0.0; LANES]; 2];
    let (a, _) = a.as_chunks::<LANES>();
    let (b, _) = b.as_chunks::<LANES>();
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        for l in 0..LANES {
            sums[i % 2][l] += a[l] * b[l];
        }
    }
    fold(&sums)
}

/// `Σ a |b|`, over whole lane groups.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
pub fn reach(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [[0.0; LANES]; 2];
    let (a, _) = a.as_chunks::<LANES>();
    let (b, _) = b.as_chunks::<LANES>();
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        for l in 0..LANES {
            sums[i % 2][l] += a[l] * b[l].abs();
        }
    }
    fold(&sums)
}

/// Adds `scale · x` to `y`.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
pub fn add_scaled(scale: f64, x: &[f64], y: &mut [f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += scale * x;
    }
}

/// Multiplies by a number.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
pub fn scale(by: f64, x: &mut [f64]) {
    for x in x {
        *x *= by;
    }
}

/// Writes to `out` the products of 2 × 2 blocks, given by their entries 11, 12, 21, 22, with `z` (first components,
/// then second ones), plus two scaled inputs.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
pub fn blocks_and_inputs(
    [a, b, c, d]: [&[f64]; 4],
    z: &[f64],
    [(p, g), (q, h)]: [(f64, &[f64]); 2],
    out: &mut [f64],
) {
    let n = a.len();
    let (x, y) = (&z[..n], &z[n..][..n]);
    let (first, second) = out.split_at_mut(n);
    for (rows, at, out) in [([a, b], 0, first), ([c, d], n, second)] {
        let (g, h) = (&g[at..][..n], &h[at..][..n]);
        let [a, b] = rows.map(|row| &row[..n]);
        for (i, out) in out[..n].iter_mut().enumerate() {
            *out = a[i] * x[i] + b[i] * y[i] + p * g[i] + q * h[i];
        }
    }
}

#[inline(always)]
fn fold(sums: &[[f64; LANES]; 2]) -> f64 {
    let s: [f64; LANES] = std::array::from_fn(|l| sums[0][l] + sums[1][l]);
    ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;

    /// Sums of integers are exact in any order, for any shape and padding.
    #[test]
    fn products_are_those_of_the_matrix() {
        for (rows, columns) in [
            (1, 1),
            (8, 3),
            (9, 8),
            (17, 17),
            (32, 5),
            (40, 41),
            (83, 83),
        ] {
            let entry = |i: usize, j: usize| ((7 * i + 13 * j) % 19) as f64 - 9.0;
            let matrix = Mat::from_fn(rows, columns, entry);
            let operator = Operator::new(matrix.as_ref());
            let x: Vec<f64> = (0..padded(columns)).map(|j| (j % 5) as f64 - 2.0).collect();
            let mut y = vec![f64::NAN; padded(rows)];
            operator.apply(&x, &mut y);
            for (i, y) in y.iter().enumerate() {
                let exact: f64 =
                    if i < rows { (0..columns).map(|j| entry(i, j) * x[j]).sum() } else { 0.0 };
                assert_eq!(*y, exact, "{rows} × {columns}, row {i}");
            }
            assert!(operator.numbers().as_ptr().addr().is_multiple_of(LINE));
            assert_eq!(
                operator.entry(rows - 1, columns / 2),
                entry(rows - 1, columns / 2)
            );
            assert_eq!(operator.bytes(), 8 * padded(rows) * columns);
        }
    }

    #[test]
    fn sums_are_those_of_their_terms() {
        let a: Vec<f64> = (0..24).map(f64::from).collect();
        let b: Vec<f64> = (0..24).map(|i| f64::from(i % 7 - 3)).collect();
        let exact: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
        let size: f64 = a.iter().zip(&b).map(|(a, b)| a * b.abs()).sum();
        assert_eq!((dot(&a, &b), reach(&a, &b)), (exact, size));
    }
}
