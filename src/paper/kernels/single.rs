//! Products in single precision: entries and sums have 32 bits, the vectors 64.

use faer::MatRef;
use multiversion::multiversion;
use multiversion::target::target_cfg_f;

/// Floats in a lane group.
const LANES: usize = 16;

/// Lane groups in a panel, as in [`Operator`](super::Operator).
const PANEL: usize = 6;

/// A dense matrix in single precision, ready for products with a vector.
#[derive(Debug)]
pub struct SingleOperator {
    numbers: Vec<[f32; LANES]>,
    rows: usize,
    columns: usize,
}

impl SingleOperator {
    /// Rounds a matrix to 32 bits.
    pub fn new(matrix: MatRef<'_, f64>) -> Self {
        let (rows, columns) = (matrix.nrows(), matrix.ncols());
        let groups = rows.div_ceil(LANES);
        let entry = |row: usize, column: usize| {
            if row < rows { matrix[(row, column)] as f32 } else { 0.0 }
        };
        let mut numbers = Vec::with_capacity(groups * columns);
        for panel in (0..groups).step_by(PANEL) {
            for column in 0..columns {
                for group in panel..groups.min(panel + PANEL) {
                    numbers.push(std::array::from_fn(|l| entry(group * LANES + l, column)));
                }
            }
        }
        Self {
            numbers,
            rows,
            columns,
        }
    }

    /// Writes the product with `x` (at least one entry per column) to the first entries of `y`, one per row.
    pub fn apply(&self, x: &[f64], y: &mut [f64]) {
        multiply(&self.numbers, &x[..self.columns], &mut y[..self.rows]);
    }

    /// Bytes of the table.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.numbers[..])
    }
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
fn multiply(numbers: &[[f32; LANES]], x: &[f64], y: &mut [f64]) {
    if target_cfg_f!(target_feature = "fma") {
        panels::<true>(numbers, x, y);
    } else {
        panels::<false>(numbers, x, y);
    }
}

#[inline(always)]
fn panels<const FUSED: bool>(mut numbers: &[[f32; LANES]], x: &[f64], y: &mut [f64]) {
    for y in y.chunks_mut(PANEL * LANES) {
        let groups = y.len().div_ceil(LANES);
        let (panel, rest) = numbers.split_at(groups * x.len());
        match groups {
            6 => rows::<6, FUSED>(panel, x, y),
            5 => rows::<5, FUSED>(panel, x, y),
            4 => rows::<4, FUSED>(panel, x, y),
            3 => rows::<3, FUSED>(panel, x, y),
            2 => rows::<2, FUSED>(panel, x, y),
            _ => rows::<1, FUSED>(panel, x, y),
        }
        numbers = rest;
    }
}

/// A panel of `G` lane groups.
#[inline(always)]
fn rows<const G: usize, const FUSED: bool>(panel: &[[f32; LANES]], x: &[f64], y: &mut [f64]) {
    let mut sums = [[0.0f32; LANES]; G];
    let (columns, _) = panel.as_chunks::<G>();
    for (column, value) in columns.iter().zip(x) {
        let value = *value as f32;
        for g in 0..G {
            for l in 0..LANES {
                let (a, sum) = (column[g][l], &mut sums[g][l]);
                *sum = if FUSED { a.mul_add(value, *sum) } else { a * value + *sum };
            }
        }
    }
    for (y, sum) in y.iter_mut().zip(sums.as_flattened()) {
        *y = f64::from(*sum);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;

    /// Sums of small integers are exact in 32 bits, for any shape and padding; thirds are not.
    #[test]
    fn products_are_rounded_to_32_bits() {
        for (rows, columns) in [(1, 1), (16, 3), (17, 17), (83, 83), (176, 80), (200, 5)] {
            let entry = |i: usize, j: usize| ((7 * i + 13 * j) % 19) as f64 - 9.0;
            let matrix = Mat::from_fn(rows, columns, entry);
            let operator = SingleOperator::new(matrix.as_ref());
            let x: Vec<f64> = (0..columns).map(|j| (j % 5) as f64 - 2.0).collect();
            let mut y = vec![f64::NAN; rows + 1];
            operator.apply(&x, &mut y);
            for (i, y) in y[..rows].iter().enumerate() {
                let exact: f64 = (0..columns).map(|j| entry(i, j) * x[j]).sum();
                assert_eq!(*y, exact, "{rows} × {columns}, row {i}");
            }
            assert!(y[rows].is_nan());
            assert_eq!(operator.bytes(), 4 * rows.next_multiple_of(LANES) * columns);
        }
        let third = Mat::from_fn(1, 1, |_, _| 1.0 / 3.0);
        let mut y = [0.0];
        SingleOperator::new(third.as_ref()).apply(&[1.0], &mut y);
        assert_eq!(y[0], f64::from(1.0f32 / 3.0));
    }
}
