//! Dense algebra in plain loops, whose sums have the same order on every processor. [`super::linalg`] uses it
//! if the process is restricted to portable instructions, and always for eigenvalues of general real matrices and
//! for few linear equations, where it is faster. Otherwise it uses the library faer, which chooses vector
//! instructions, fused multiply-adds and block sizes by the processor.

mod general;
mod symmetric;

pub use general::eigenvalues;
pub use symmetric::symmetric_eigen;

use faer::{Mat, MatRef};
use num_complex::Complex64;

/// `A B`.
pub fn product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let mut out = Mat::zeros(a.nrows(), b.ncols());
    for j in 0..b.ncols() {
        for k in 0..a.ncols() {
            let factor = b[(k, j)];
            for i in 0..a.nrows() {
                out[(i, j)] += a[(i, k)] * factor;
            }
        }
    }
    out
}

/// A dot product, computed as eight partial sums, which use the vector instructions of the processor.
#[inline(always)]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (a, b) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = (a.remainder().iter().zip(b.remainder()))
        .map(|(a, b)| a * b)
        .sum();
    for (a, b) in a.zip(b) {
        for i in 0..8 {
            sums[i] += a[i] * b[i];
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// The factors of a matrix, `P A = L U`, with rows swapped such that every pivot is the largest entry of its
/// column.
#[derive(Debug)]
pub struct Lu {
    factors: Mat<f64>,
    rows: Vec<usize>,
}

impl Lu {
    /// Factorises a square matrix.
    pub fn new(matrix: Mat<f64>) -> Self {
        let (n, mut a) = (matrix.nrows(), matrix);
        let mut rows: Vec<usize> = (0..n).collect();
        for k in 0..n {
            let mut pivot = k;
            for i in k + 1..n {
                if a[(i, k)].abs() > a[(pivot, k)].abs() {
                    pivot = i;
                }
            }
            if pivot != k {
                rows.swap(k, pivot);
                for j in 0..n {
                    let kept = a[(k, j)];
                    a[(k, j)] = a[(pivot, j)];
                    a[(pivot, j)] = kept;
                }
            }
            for i in k + 1..n {
                a[(i, k)] /= a[(k, k)];
            }
            for j in k + 1..n {
                let factor = a[(k, j)];
                for i in k + 1..n {
                    a[(i, j)] -= a[(i, k)] * factor;
                }
            }
        }
        Self { factors: a, rows }
    }

    /// Solution of `A x = b`.
    pub fn solve(&self, b: &[f64]) -> Vec<f64> {
        let (n, a) = (b.len(), &self.factors);
        let mut x: Vec<f64> = self.rows.iter().map(|&row| b[row]).collect();
        for k in 0..n {
            for i in k + 1..n {
                x[i] -= a[(i, k)] * x[k];
            }
        }
        for k in (0..n).rev() {
            x[k] /= a[(k, k)];
            for i in 0..k {
                x[i] -= a[(i, k)] * x[k];
            }
        }
        x
    }
}

/// The lower triangle of `A = L Lᵀ`; `None` if A is not positive definite.
pub fn cholesky(matrix: &Mat<f64>) -> Option<Mat<f64>> {
    let n = matrix.nrows();
    let mut lower: Mat<f64> = Mat::zeros(n, n);
    for j in 0..n {
        for i in j..n {
            let mut sum = matrix[(i, j)];
            for k in 0..j {
                sum -= lower[(i, k)] * lower[(j, k)];
            }
            lower[(i, j)] = match i == j {
                // This form of the condition rejects a NaN.
                true if sum > 0.0 => sum.sqrt(),
                true => return None,
                false => sum / lower[(j, j)],
            };
        }
    }
    Some(lower)
}

/// `X = L⁻¹ B` in place of B.
pub fn solve_lower(lower: &Mat<f64>, b: &mut Mat<f64>) {
    for column in 0..b.ncols() {
        for k in 0..lower.nrows() {
            b[(k, column)] /= lower[(k, k)];
            let x = b[(k, column)];
            for i in k + 1..lower.nrows() {
                b[(i, column)] -= lower[(i, k)] * x;
            }
        }
    }
}

/// `X = L⁻ᵀ B` in place of B.
pub fn solve_upper(lower: &Mat<f64>, b: &mut Mat<f64>) {
    for column in 0..b.ncols() {
        for k in (0..lower.nrows()).rev() {
            let mut sum = b[(k, column)];
            for i in k + 1..lower.nrows() {
                sum -= lower[(i, k)] * b[(i, column)];
            }
            b[(k, column)] = sum / lower[(k, k)];
        }
    }
}

/// The discrete Fourier transform of real values, whose number n must be a power of two: the terms 0 to n/2.
///
/// # Panics
/// If n is not a power of two.
pub fn transform(values: &[f64]) -> Vec<Complex64> {
    let n = values.len();
    assert!(n.is_power_of_two(), "{n} values");
    let bits = n.trailing_zeros();
    let place = |i: usize| i.reverse_bits().unbounded_shr(usize::BITS - bits);
    let mut z: Vec<Complex64> = (0..n).map(|i| values[place(i)].into()).collect();
    let mut half = 1;
    while half < n {
        for k in 0..half {
            let turn = Complex64::cis(-std::f64::consts::PI * k as f64 / half as f64);
            for i in (k..n).step_by(2 * half) {
                let (a, turned) = (z[i], z[i + half] * turn);
                (z[i], z[i + half]) = (a + turned, a - turned);
            }
        }
        half *= 2;
    }
    z.truncate(n / 2 + 1);
    z
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random::Stream;

    fn random(n: usize, number: u64) -> Mat<f64> {
        let mut stream = Stream::new(11, number, 0);
        Mat::from_fn(n, n, |_, _| stream.normal())
    }

    fn symmetric(n: usize, number: u64) -> Mat<f64> {
        let a = random(n, number);
        Mat::from_fn(n, n, |i, j| 0.5 * (a[(i, j)] + a[(j, i)]))
    }

    #[test]
    fn factors_solve_what_they_were_made_of() {
        for n in [1, 2, 7, 40] {
            let a = random(n, 1);
            let b: Vec<f64> = (0..n).map(|i| (i as f64).cos()).collect();
            let x = Lu::new(a.clone()).solve(&b);
            let x = Mat::from_fn(n, 1, |i, _| x[i]);
            let back = product(a.as_ref(), x.as_ref());
            for i in 0..n {
                assert!((back[(i, 0)] - b[i]).abs() < 1e-12, "{n}");
            }
            let definite = product(a.as_ref(), a.transpose());
            let lower = cholesky(&definite).unwrap();
            let mut whole = definite.clone();
            solve_lower(&lower, &mut whole);
            solve_upper(&lower, &mut whole);
            for i in 0..n {
                for j in 0..n {
                    let identity = f64::from(u8::from(i == j));
                    assert!((whole[(i, j)] - identity).abs() < 1e-8, "{n}");
                }
            }
            let indefinite = Mat::from_fn(n, n, |i, j| -definite[(i, j)]);
            assert!(cholesky(&indefinite).is_none());
        }
        assert!(cholesky(&Mat::from_fn(2, 2, |_, _| 1.0)).is_none());
    }

    #[test]
    fn symmetric_matrices_are_rebuilt_from_their_eigenvectors() {
        for n in [1, 2, 3, 24, 70] {
            for a in [symmetric(n, 2), Mat::identity(n, n), Mat::zeros(n, n)] {
                let (values, v) = symmetric_eigen(&a).unwrap();
                assert!(values.is_sorted());
                let scaled = Mat::from_fn(n, n, |i, j| v[(i, j)] * values[j]);
                let back = product(scaled.as_ref(), v.transpose());
                let unit = product(v.transpose(), v.as_ref());
                for i in 0..n {
                    for j in 0..n {
                        assert!((back[(i, j)] - a[(i, j)]).abs() < 1e-13 * n as f64, "{n}");
                        let identity = f64::from(u8::from(i == j));
                        assert!((unit[(i, j)] - identity).abs() < 1e-14 * n as f64, "{n}");
                    }
                }
            }
        }
    }

    #[test]
    fn eigenvalues_are_those_of_the_library() {
        let rotation = Mat::from_fn(4, 4, |i, j| {
            [
                [0.0, -1.0, 0.0, 0.0],
                [1.0, 0.0, 0.0, 0.0],
                [0.0, 0.0, 0.0, -1.0],
                [0.0, 0.0, 1.0, 0.0],
            ][i][j]
        });
        let cases = [1, 2, 3, 4, 12, 50].map(|n| random(n, 3));
        for a in cases
            .into_iter()
            .chain([rotation, Mat::identity(5, 5), Mat::zeros(3, 3)])
        {
            let mut known = a.eigenvalues().unwrap();
            let found = eigenvalues(a.as_ref()).unwrap();
            assert_eq!(known.len(), found.len());
            for value in found {
                let far = |v: &Complex64| (v - value).norm();
                let nearest = (0..known.len())
                    .min_by(|&a, &b| far(&known[a]).total_cmp(&far(&known[b])))
                    .unwrap();
                let distance = far(&known.swap_remove(nearest));
                assert!(distance < 1e-12 * a.nrows() as f64, "{value}: {distance}");
            }
        }
        assert!(eigenvalues(Mat::from_fn(2, 2, |_, _| f64::NAN).as_ref()).is_none());
    }

    /// The matrix maps each coordinate to the next one. Ordinary shifts are then zero, and a step returns the
    /// same matrix. Only exceptional shifts change it.
    #[test]
    fn roots_of_unity_are_found_where_ordinary_steps_stand_still() {
        for n in 3..=12 {
            let cycle = Mat::from_fn(n, n, |i, j| f64::from(u8::from(i == (j + 1) % n)));
            let mut found = eigenvalues(cycle.as_ref()).unwrap();
            for k in 0..n {
                let root = Complex64::cis(std::f64::consts::TAU * k as f64 / n as f64);
                let far = |v: &Complex64| (v - root).norm();
                let nearest =
                    (0..found.len()).min_by(|&a, &b| far(&found[a]).total_cmp(&far(&found[b])));
                let distance = far(&found.swap_remove(nearest.unwrap()));
                assert!(distance < 1e-14, "{n} {k}: {distance:e}");
            }
        }
    }

    /// A block matrix of maps exp(r [0 1; -1 -2 z]), with damping ratios z near 1 and nearly equal rates r,
    /// and of rotations. Random reflections transform the whole matrix.
    #[test]
    fn clusters_of_nearly_double_eigenvalues_are_found() {
        for number in 0..300 {
            let mut stream = Stream::new(12, number, 0);
            let size = 2 * (4 + number as usize % 4);
            let rate = 0.5 + 2.0 * stream.uniform();
            let missing = 10f64.powf(-4.0 - 5.0 * stream.uniform());
            let (z, w) = (1.0 - missing, (missing * (2.0 - missing)).sqrt());
            let (mut matrix, mut known) = (Mat::zeros(size, size), Vec::new());
            for k in (0..size).step_by(2) {
                let (root, block) = if k % 4 == 0 {
                    let r = rate * (1.0 + 1e-6 * stream.normal());
                    let root = (r * Complex64::new(-z, w)).exp();
                    let (a, b) = (root.re + root.im * z / w, root.im / w);
                    (root, [[a, b], [-b, 2.0 * root.re - a]])
                } else {
                    let root = Complex64::cis(3.0 * stream.uniform());
                    (root, [[root.re, root.im], [-root.im, root.re]])
                };
                known.extend([root, root.conj()]);
                for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    matrix[(k + i, k + j)] = block[i][j];
                }
            }
            for _ in 0..size {
                let u = Mat::from_fn(size, 1, |_, _| stream.normal());
                let square = product(u.transpose(), u.as_ref())[(0, 0)];
                let reflection = Mat::from_fn(size, size, |i, j| {
                    f64::from(u8::from(i == j)) - 2.0 * u[(i, 0)] * u[(j, 0)] / square
                });
                let half = product(reflection.as_ref(), matrix.as_ref());
                matrix = product(half.as_ref(), reflection.as_ref());
            }
            let found = eigenvalues(matrix.as_ref());
            let mut found = found.unwrap_or_else(|| panic!("not found: {number}"));
            for root in known {
                let far = |v: &Complex64| (v - root).norm();
                let nearest =
                    (0..found.len()).min_by(|&a, &b| far(&found[a]).total_cmp(&far(&found[b])));
                let distance = far(&found.swap_remove(nearest.unwrap()));
                assert!(distance < 1e-9, "{number}: {distance:e}");
            }
        }
    }

    #[test]
    fn the_transform_is_its_sum() {
        let values: Vec<f64> = (0..16).map(|i| (0.3 * i as f64).sin() + 0.1).collect();
        let terms = transform(&values);
        assert_eq!(terms.len(), 9);
        for (k, term) in terms.into_iter().enumerate() {
            let mut sum = Complex64::ZERO;
            for (i, value) in values.iter().enumerate() {
                sum += value * Complex64::cis(-std::f64::consts::TAU * (k * i) as f64 / 16.0);
            }
            assert!((sum - term).norm() < 1e-13, "{k}");
        }
        assert_eq!(transform(&[2.0]), [Complex64::from(2.0)]);
    }
}
