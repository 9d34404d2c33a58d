//! Symmetric banded matrices, such as those of shafts in a row.
//!
//! Stored by rows of the lower half, the diagonal last: entry (i, i − b + k) is `rows[i (b + 1) + k]`.
//! Every operation is a plain loop whose order does not depend on the machine.

use faer::{Mat, MatRef};

/// A symmetric matrix with b diagonals below the main one.
#[derive(Debug, Clone)]
pub(super) struct Banded {
    size: usize,
    band: usize,
    rows: Vec<f64>,
}

impl Banded {
    /// Largest distance from the diagonal of any nonzero entry of matrices of equal size.
    pub fn width(matrices: &[&Mat<f64>]) -> usize {
        let mut width = 0;
        for matrix in matrices {
            for column in 0..matrix.ncols() {
                let mut row = matrix.nrows();
                while row > column + width + 1 {
                    row -= 1;
                    if matrix[(row, column)] != 0.0 {
                        width = row - column;
                    }
                }
            }
        }
        width
    }

    /// The lower half of a matrix within `band` diagonals.
    pub fn of(matrix: &Mat<f64>, band: usize) -> Self {
        let size = matrix.nrows();
        let mut rows = vec![0.0; size * (band + 1)];
        for i in 0..size {
            for j in i.saturating_sub(band)..=i {
                rows[i * (band + 1) + j + band - i] = matrix[(i, j)];
            }
        }
        Self { size, band, rows }
    }

    /// `self + factor other`, of equal size and band.
    pub fn plus(&self, factor: f64, other: &Self) -> Self {
        let rows = self.rows.iter().zip(&other.rows);
        Self {
            rows: rows.map(|(a, b)| a + factor * b).collect(),
            ..*self
        }
    }

    /// Number of rows.
    pub fn size(&self) -> usize {
        self.size
    }

    /// The entries of a row up to the diagonal, and the column of the first.
    fn row(&self, i: usize) -> (usize, &[f64]) {
        let first = i.saturating_sub(self.band);
        let end = (i + 1) * (self.band + 1);
        (first, &self.rows[end - (i + 1 - first)..end])
    }

    /// The entry on the diagonal.
    pub fn diagonal(&self, i: usize) -> f64 {
        self.rows[(i + 1) * (self.band + 1) - 1]
    }

    /// `A X`.
    pub fn product(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        let mut out = Mat::zeros(self.size, x.ncols());
        for column in 0..x.ncols() {
            for i in 0..self.size {
                let (first, row) = self.row(i);
                let (below, diagonal) = row.split_at(row.len() - 1);
                let mut sum = diagonal[0] * x[(i, column)];
                for (j, a) in (first..).zip(below) {
                    sum += a * x[(j, column)];
                    out[(j, column)] += a * x[(i, column)];
                }
                out[(i, column)] += sum;
            }
        }
        out
    }

    /// Sums of the moduli of the terms of `A x`, row by row.
    pub fn sum_of_moduli(&self, x: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; self.size];
        for i in 0..self.size {
            let (first, row) = self.row(i);
            let (below, diagonal) = row.split_at(row.len() - 1);
            out[i] += (diagonal[0] * x[i]).abs();
            for (j, a) in (first..).zip(below) {
                out[i] += (a * x[j]).abs();
                out[j] += (a * x[i]).abs();
            }
        }
        out
    }

    /// `A = L D Lᵀ` without pivoting; `None` if a pivot is zero or not finite.
    pub fn factor(&self) -> Option<Factor> {
        let (band, width) = (self.band, self.band + 1);
        let mut lower = self.rows.clone();
        let mut pivots = vec![0.0; self.size];
        let mut scaled = vec![0.0; width];
        for i in 0..self.size {
            let first = i.saturating_sub(band);
            for j in first..=i {
                // Row j of L reaches back to j − band; so do the known entries of row i.
                let from = first.max(j.saturating_sub(band));
                let mut sum = lower[i * width + j + band - i];
                for k in from..j {
                    sum -= scaled[k + band - i] * lower[j * width + k + band - j];
                }
                if j < i {
                    scaled[j + band - i] = sum;
                    lower[i * width + j + band - i] = sum / pivots[j];
                } else {
                    if sum == 0.0 || !sum.is_finite() {
                        return None;
                    }
                    pivots[i] = sum;
                }
            }
        }
        Some(Factor {
            size: self.size,
            band,
            lower,
            pivots,
        })
    }
}

/// `L D Lᵀ`, L with ones on its diagonal.
#[derive(Debug, Clone)]
pub(super) struct Factor {
    size: usize,
    band: usize,
    lower: Vec<f64>,
    pivots: Vec<f64>,
}

impl Factor {
    /// Number of negative pivots, which is the number of negative eigenvalues (Sylvester).
    pub fn negative(&self) -> usize {
        self.pivots.iter().filter(|pivot| **pivot < 0.0).count()
    }

    /// `A⁻¹ B` in place of B.
    pub fn solve(&self, b: &mut Mat<f64>) {
        let (band, width) = (self.band, self.band + 1);
        for column in 0..b.ncols() {
            for i in 0..self.size {
                let mut sum = b[(i, column)];
                for j in i.saturating_sub(band)..i {
                    sum -= self.lower[i * width + j + band - i] * b[(j, column)];
                }
                b[(i, column)] = sum;
            }
            for i in 0..self.size {
                b[(i, column)] /= self.pivots[i];
            }
            for i in (0..self.size).rev() {
                let value = b[(i, column)];
                for j in i.saturating_sub(band)..i {
                    b[(j, column)] -= self.lower[i * width + j + band - i] * value;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random::Stream;

    /// A random symmetric matrix of a band, with `shift` added to its diagonal.
    fn random(size: usize, band: usize, shift: f64) -> Mat<f64> {
        let mut stream = Stream::new(7, 0, 0);
        let mut matrix = Mat::zeros(size, size);
        for i in 0..size {
            for j in i.saturating_sub(band)..=i {
                let value = stream.uniform() - 0.5;
                matrix[(i, j)] = value;
                matrix[(j, i)] = value;
            }
            matrix[(i, i)] += shift;
        }
        matrix
    }

    #[test]
    fn products_and_solutions_are_those_of_the_whole_matrix() {
        for (size, band) in [(1, 0), (9, 0), (9, 3), (40, 12), (12, 11)] {
            let matrix = random(size, band, 8.0);
            assert!(Banded::width(&[&matrix]) == band.min(size - 1));
            let banded = Banded::of(&matrix, band);
            let x = Mat::from_fn(size, 3, |i, j| ((i * 3 + j) as f64).sin());
            let image = banded.product(x.as_ref());
            assert!((&image - &matrix * &x).norm_max() < 1e-13);
            let mut back = image;
            banded.factor().unwrap().solve(&mut back);
            assert!((back - &x).norm_max() < 1e-13);
        }
    }

    #[test]
    fn negative_pivots_count_negative_eigenvalues() {
        for shift in [-3.0, -0.5, 0.3, 1.0, 4.0] {
            let matrix = random(30, 5, shift);
            let values = matrix.self_adjoint_eigenvalues(faer::Side::Lower).unwrap();
            let negative = values.iter().filter(|value| **value < 0.0).count();
            let factor = Banded::of(&matrix, 5).factor().unwrap();
            assert_eq!(factor.negative(), negative, "{shift}");
        }
    }
}
