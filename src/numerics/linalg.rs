//! Small dense algebra: inverse, linear solve, eigenvalues, the leading eigenvector.

use faer::linalg::solvers::{PartialPivLu, Solve};
use faer::{Mat, MatRef};

/// Inverse of the matrix given by columns, `columns[j][i] = A_ij`; columns of the inverse.
/// Gauss–Jordan elimination in place with partial pivoting: for a matrix this small a general
/// solver's preparations would take longer.
pub fn invert<const P: usize>(columns: &[[f64; P]; P]) -> [[f64; P]; P] {
    // Columns of A are rows of its transpose, and so are those of the inverse.
    let mut a = *columns;
    let mut pivots = [0; P];
    for k in 0..P {
        let mut pivot = k;
        for i in k + 1..P {
            if a[i][k].abs() > a[pivot][k].abs() {
                pivot = i;
            }
        }
        pivots[k] = pivot;
        a.swap(k, pivot);
        let inverse = 1.0 / a[k][k];
        a[k][k] = 1.0;
        for value in &mut a[k] {
            *value *= inverse;
        }
        let row = a[k];
        for (i, other) in a.iter_mut().enumerate() {
            if i != k {
                let factor = other[k];
                other[k] = 0.0;
                for (o, r) in other.iter_mut().zip(&row) {
                    *o -= factor * r;
                }
            }
        }
    }
    for k in (0..P).rev() {
        for row in &mut a {
            row.swap(k, pivots[k]);
        }
    }
    a
}

/// Solution of `A x = b` by partial pivoting.
pub fn solve(matrix: MatRef<'_, f64>, rhs: &[f64]) -> Vec<f64> {
    let b = Mat::from_fn(rhs.len(), 1, |i, _| rhs[i]);
    let x = PartialPivLu::new(matrix).solve(&b);
    (0..rhs.len()).map(|i| x[(i, 0)]).collect()
}

/// Eigenvalues of a real matrix as (re, im), largest modulus first; none where the
/// iteration fails or the matrix is not finite.
pub fn eigenvalues(matrix: MatRef<'_, f64>) -> Option<Vec<(f64, f64)>> {
    let mut values: Vec<(f64, f64)> = matrix
        .eigenvalues()
        .ok()?
        .iter()
        .map(|c| (c.re, c.im))
        .collect();
    let modulus = |v: &(f64, f64)| v.0.hypot(v.1);
    values.sort_by(|a, b| {
        modulus(b)
            .total_cmp(&modulus(a))
            .then(b.0.total_cmp(&a.0))
            .then(b.1.total_cmp(&a.1))
    });
    Some(values)
}

/// Right eigenvector of the eigenvalue of largest modulus as real and imaginary part, of unit
/// Euclidean norm together; none where the iteration fails or the matrix is not finite. Of a
/// complex pair the vector of either.
pub fn leading_eigenvector(matrix: MatRef<'_, f64>) -> Option<[Vec<f64>; 2]> {
    let decomposition = matrix.eigen().ok()?;
    let values = decomposition.S().column_vector();
    let n = matrix.nrows();
    let leading = (0..n).max_by(|&a, &b| values[a].norm().total_cmp(&values[b].norm()))?;
    let vectors = decomposition.U();
    let length = (0..n)
        .map(|i| vectors[(i, leading)].norm_sqr())
        .sum::<f64>()
        .sqrt();
    Some([
        (0..n).map(|i| vectors[(i, leading)].re / length).collect(),
        (0..n).map(|i| vectors[(i, leading)].im / length).collect(),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_and_solve_undo_the_matrix() {
        let columns = [[4.0, 1.0, 0.0], [2.0, 3.0, 1.0], [0.5, 0.0, 2.0]];
        let inverse = invert(&columns);
        for i in 0..3 {
            for j in 0..3 {
                let product: f64 = (0..3).map(|k| columns[k][i] * inverse[j][k]).sum();
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-15);
            }
        }
        let a = Mat::from_fn(3, 3, |i, j| columns[j][i]);
        let x = solve(a.as_ref(), &[1.0, -2.0, 0.5]);
        let back: f64 = (0..3).map(|k| columns[k][1] * x[k]).sum();
        assert!((back + 2.0).abs() < 1e-15);
    }

    #[test]
    fn inverse_of_a_permutation_and_of_a_small_first_pivot() {
        let p = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        assert_eq!(
            invert(&p),
            [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]
        );
        let inverse = invert(&[[1e-20, 1.0], [1.0, 1.0]]);
        for (found, exact) in inverse.as_flattened().iter().zip([-1.0, 1.0, 1.0, -1e-20]) {
            assert!((found - exact).abs() < 1e-15);
        }
    }

    #[test]
    fn eigenvalues_of_a_scaled_rotation() {
        let (r, phi): (f64, f64) = (0.9, 0.4);
        let (c, s) = (r * phi.cos(), r * phi.sin());
        let a = Mat::from_fn(3, 3, |i, j| {
            [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 0.3]][i][j]
        });
        let values = eigenvalues(a.as_ref()).unwrap();
        assert!((values[0].0.hypot(values[0].1) - r).abs() < 1e-15);
        assert!((values[0].1.atan2(values[0].0).abs() - phi).abs() < 1e-15);
        assert!((values[2].0 - 0.3).abs() < 1e-15);
    }

    #[test]
    fn the_leading_eigenvector_is_turned_and_scaled_only() {
        let a = Mat::from_fn(3, 3, |i, j| {
            [[0.1, -0.8, 0.2], [0.9, 0.2, 0.0], [0.3, 0.0, 0.4]][i][j]
        });
        let [re, im] = leading_eigenvector(a.as_ref()).unwrap();
        let times = |x: &[f64]| -> Vec<f64> {
            (0..3)
                .map(|i| (0..3).map(|j| a[(i, j)] * x[j]).sum())
                .collect()
        };
        let (along, across) = (times(&re), times(&im));
        let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(a, b)| a * b).sum::<f64>();
        assert!((dot(&re, &re) + dot(&im, &im) - 1.0).abs() < 1e-14);
        let value = (
            dot(&re, &along) + dot(&im, &across),
            dot(&re, &across) - dot(&im, &along),
        );
        let largest = eigenvalues(a.as_ref()).unwrap()[0];
        assert!((value.0 - largest.0).abs() < 1e-14);
        assert!((value.1.abs() - largest.1.abs()).abs() < 1e-14);
        for i in 0..3 {
            let (x, y) = (
                value.0 * re[i] - value.1 * im[i],
                value.0 * im[i] + value.1 * re[i],
            );
            assert!((along[i] - x).abs() + (across[i] - y).abs() < 1e-14);
        }
    }
}
