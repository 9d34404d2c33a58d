//! Small dense algebra: products, inverse, linear equations, Cholesky factors, eigenvalues, single
//! eigenvectors. It uses the plain loops of [`plain`] if the process is restricted to portable instructions, and
//! always where they are faster.

use super::instructions::portable;
use super::plain;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::factor::{lu_in_place, lu_in_place_scratch};
use faer::linalg::lu::partial_pivoting::solve::{solve_in_place, solve_in_place_scratch};
use faer::linalg::solvers::{PartialPivLu, Solve};
use faer::traits::ComplexField;
use faer::traits::ext::ComplexFieldExt;
use faer::{Mat, MatMut, MatRef, Par, Side};
use num_complex::{Complex64, c64};

/// `A B`.
pub fn product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    if portable() { plain::product(a, b) } else { a * b }
}

/// The lower triangle of `A = L Lᵀ`; `None` if A is not positive definite.
pub fn cholesky(matrix: &Mat<f64>) -> Option<Mat<f64>> {
    if portable() {
        plain::cholesky(matrix)
    } else {
        Some(matrix.llt(Side::Lower).ok()?.L().to_owned())
    }
}

/// `X = L⁻¹ B` in place of B.
pub fn solve_lower(lower: &Mat<f64>, b: &mut Mat<f64>) {
    if portable() {
        plain::solve_lower(lower, b)
    } else {
        lower.solve_lower_triangular_in_place(b.as_mut())
    }
}

/// `X = L⁻ᵀ B` in place of B.
pub fn solve_upper(lower: &Mat<f64>, b: &mut Mat<f64>) {
    if portable() {
        plain::solve_upper(lower, b)
    } else {
        lower
            .transpose()
            .solve_upper_triangular_in_place(b.as_mut())
    }
}

/// Eigenvalues, ascending, and orthonormal eigenvectors of a symmetric matrix, of which only the lower half
/// is read. `None` if the iteration fails or an entry is not finite.
///
/// Above 128 rows, faer uses a divide-and-conquer method. Its search for a root of the secular equation ends
/// at an absolute change of 2e-16. The values of this equation are about the reciprocals of the matrix
/// entries. With entries of 10¹⁰ and more the search therefore ends at once, and eigenvalues have relative
/// errors of a thousandth. To prevent this, the matrix is scaled to entries of about one, by a power of two
/// to avoid rounding.
pub fn symmetric_eigen(matrix: &Mat<f64>) -> Option<(Vec<f64>, Mat<f64>)> {
    let largest = matrix.norm_max();
    if !largest.is_finite() {
        return None;
    }
    if portable() {
        return plain::symmetric_eigen(matrix);
    }
    let unit = if largest > 0.0 { largest.log2().ceil().exp2() } else { 1.0 };
    let solution = (matrix * faer::Scale(1.0 / unit))
        .self_adjoint_eigen(Side::Lower)
        .ok()?;
    let values = solution.S().column_vector().iter();
    let values = values.map(|value| value * unit).collect();
    Some((values, solution.U().to_owned()))
}

/// Inverse of a matrix. Both are stored by columns, `columns[j][i] = A_ij`. The method is Gauss–Jordan
/// elimination in place with partial pivoting. For small matrices the preparations of a general solver would
/// take longer.
pub fn invert<const P: usize>(columns: &[[f64; P]; P]) -> [[f64; P]; P] {
    // The columns of A are the rows of its transpose, and the same holds for the inverse: invert the
    // transpose by rows.
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

/// Largest number of equations for which the preparations of a general solver take longer than the
/// elimination.
const SMALL: usize = 8;

/// Solution of `A x = b`, by elimination with partial pivoting.
pub fn solve(matrix: MatRef<'_, f64>, rhs: &[f64]) -> Vec<f64> {
    if portable() || rhs.len() <= SMALL {
        return plain::Lu::new(matrix.to_owned()).solve(rhs);
    }
    // Call the parts of the library's decomposition directly, which avoids copies of both factors.
    let n = rhs.len();
    let (mut factors, mut x) = (matrix.to_owned(), rhs.to_vec());
    let (mut order, mut inverse) = (vec![0_usize; n], vec![0_usize; n]);
    let needed = lu_in_place_scratch::<usize, f64>(n, n, Par::Seq, Default::default())
        .or(solve_in_place_scratch::<usize, f64>(n, 1, Par::Seq));
    let mut buffer = MemBuffer::new(needed);
    let stack = MemStack::new(&mut buffer);
    let rows = (&mut order[..], &mut inverse[..]);
    let matrix = factors.as_mut();
    let (_, order) = lu_in_place(matrix, rows.0, rows.1, Par::Seq, stack, Default::default());
    let [lower, upper] = [factors.as_ref(); 2];
    let column = MatMut::from_column_major_slice_mut(&mut x, n, 1);
    solve_in_place(lower, upper, order, column, Par::Seq, stack);
    x
}

/// Inverse of a matrix.
pub fn inverse(matrix: MatRef<'_, f64>) -> Mat<f64> {
    let n = matrix.nrows();
    if !portable() {
        return matrix.partial_piv_lu().solve(Mat::<f64>::identity(n, n));
    }
    let factors = plain::Lu::new(matrix.to_owned());
    let mut inverse = Mat::zeros(n, n);
    for j in 0..n {
        let mut unit = vec![0.0; n];
        unit[j] = 1.0;
        for (i, value) in factors.solve(&unit).into_iter().enumerate() {
            inverse[(i, j)] = value;
        }
    }
    inverse
}

/// A power of two near the largest entry of a matrix, if products of its entries could underflow or
/// overflow; otherwise 1.
fn unit(largest: f64) -> f64 {
    if largest == 0.0 || (1e-100..1e100).contains(&largest) {
        1.0
    } else {
        // Limit the exponent, because the reciprocals of the smallest numbers are infinite.
        largest.log2().floor().clamp(-1022.0, 1022.0).exp2()
    }
}

/// Eigenvalues of a real matrix, largest modulus first. `None` if the
/// iteration fails or the matrix is not finite.
pub fn eigenvalues(matrix: MatRef<'_, f64>) -> Option<Vec<Complex64>> {
    let largest = matrix.norm_max();
    if !largest.is_finite() {
        return None;
    }
    let unit = unit(largest);
    let mut values = if unit == 1.0 {
        plain::eigenvalues(matrix)?
    } else {
        plain::eigenvalues((matrix * faer::Scale(1.0 / unit)).as_ref())?
    };
    values.iter_mut().for_each(|value| *value *= unit);
    values.sort_by(|a, b| {
        (b.norm().total_cmp(&a.norm()))
            .then(b.re.total_cmp(&a.re))
            .then(b.im.total_cmp(&a.im))
    });
    Some(values)
}

/// An eigenvalue and its right eigenvector.
#[derive(Debug, Clone)]
pub struct EigenPair {
    /// The eigenvalue.
    pub value: Complex64,
    /// Real and imaginary part of the eigenvector, whose Euclidean norm is 1. The imaginary part is zero for
    /// a real eigenvalue.
    pub vector: [Vec<f64>; 2],
}

/// Largest number of steps of inverse iteration. One is enough if the shift is an eigenvalue to round-off.
/// Otherwise each step multiplies the error by the ratio of the distances of the nearest and the second nearest
/// eigenvalue from the shift.
const MOST_INVERSE_STEPS: usize = 12;

/// Residual, relative to the matrix, of a converged eigenvector.
const EIGENVECTOR_RESIDUAL: f64 = 1e-13;

/// The eigenvalue nearest to `near` with its right eigenvector, by inverse iteration. It needs one
/// factorisation, whereas a complete eigenvalue decomposition takes about as long as twenty. `None` if the
/// matrix is not finite or the iteration does not converge.
pub fn eigenpair(matrix: MatRef<'_, f64>, near: Complex64) -> Option<EigenPair> {
    let n = matrix.nrows();
    // The bits of a maximum, unlike those of a sum, do not depend on the order.
    let size = matrix.norm_max();
    if n == 0 || !size.is_finite() {
        return None;
    }
    let unit = unit(size);
    if unit != 1.0 {
        let mut pair = eigenpair((matrix * faer::Scale(1.0 / unit)).as_ref(), near / unit)?;
        pair.value *= unit;
        return Some(pair);
    }
    // This start is unlikely to be orthogonal to an eigenvector.
    let start = Mat::from_fn(n, 1, |i, _| {
        c64((1.0 + i as f64).sin(), (0.5 + i as f64).cos())
    });
    // With an exact eigenvalue the shifted matrix would be singular. The first shift may hit an eigenvalue,
    // so try two.
    let (factors, mut vector) = [1.0, 4.0].into_iter().find_map(|offset| {
        let shift = near + offset * f64::EPSILON * size;
        let shifted = Mat::from_fn(n, n, |i, j| {
            let diagonal = if i == j { shift } else { Complex64::ZERO };
            c64(matrix[(i, j)], 0.0) - diagonal
        });
        let factors = Shifted::new(&shifted, portable());
        let vector = factors.solve(&start);
        norm(&vector).is_finite().then_some((factors, vector))
    })?;
    for _ in 0..MOST_INVERSE_STEPS {
        let length = norm(&vector);
        if !(length.is_finite() && length > 0.0) {
            return None;
        }
        for i in 0..n {
            vector[(i, 0)] /= length;
        }
        let image = image(matrix, &vector);
        let value: Complex64 = (0..n).map(|i| vector[(i, 0)].conj() * image[i]).sum();
        let residual = (0..n)
            .map(|i| (image[i] - value * vector[(i, 0)]).norm_sqr())
            .sum::<f64>()
            .sqrt();
        if residual <= EIGENVECTOR_RESIDUAL * size * (n as f64).sqrt() {
            return Some(polished(value, &vector, near.im == 0.0));
        }
        vector = factors.solve(&vector);
    }
    None
}

/// The factors of a shifted matrix.
enum Shifted {
    Library(PartialPivLu<Complex64>),
    /// Factors of the equivalent real matrix for the real parts followed by the imaginary parts.
    Plain(plain::Lu),
}

impl Shifted {
    fn new(matrix: &Mat<Complex64>, plain: bool) -> Self {
        if !plain {
            return Self::Library(PartialPivLu::new(matrix.as_ref()));
        }
        let n = matrix.nrows();
        Self::Plain(plain::Lu::new(Mat::from_fn(2 * n, 2 * n, |i, j| {
            let z = matrix[(i % n, j % n)];
            match (i < n, j < n) {
                (true, false) => -z.im,
                (false, true) => z.im,
                _ => z.re,
            }
        })))
    }

    fn solve(&self, vector: &Mat<Complex64>) -> Mat<Complex64> {
        let factors = match self {
            Self::Library(factors) => return factors.solve(vector),
            Self::Plain(factors) => factors,
        };
        let n = vector.nrows();
        let parts: Vec<f64> = (0..n)
            .map(|i| vector[(i, 0)].re)
            .chain((0..n).map(|i| vector[(i, 0)].im))
            .collect();
        let x = factors.solve(&parts);
        Mat::from_fn(n, 1, |i, _| c64(x[i], x[n + i]))
    }
}

/// Euclidean norm of a real or complex vector.
pub fn norm<T: ComplexField<Real = f64>>(vector: &Mat<T>) -> f64 {
    if portable() {
        let squares = (0..vector.nrows()).map(|i| vector[(i, 0)].abs2());
        squares.sum::<f64>().sqrt()
    } else {
        vector.norm_l2()
    }
}

fn image(matrix: MatRef<'_, f64>, vector: &Mat<Complex64>) -> Vec<Complex64> {
    let n = matrix.nrows();
    let mut image = vec![Complex64::ZERO; n];
    for j in 0..n {
        for (i, value) in image.iter_mut().enumerate() {
            *value += vector[(j, 0)] * matrix[(i, j)];
        }
    }
    image
}

/// The eigenpair from an iterate. The vector of a real eigenvalue is multiplied by a phase that makes it
/// real.
fn polished(value: Complex64, vector: &Mat<Complex64>, real: bool) -> EigenPair {
    let n = vector.nrows();
    let mut turn = c64(1.0, 0.0);
    if real {
        let largest = (0..n).max_by(|&a, &b| {
            let size = |i: usize| vector[(i, 0)].norm_sqr();
            size(a).total_cmp(&size(b))
        });
        if let Some(largest) = largest.map(|i| vector[(i, 0)]) {
            turn = largest.conj() / largest.norm();
        }
    }
    let imaginary = |part: f64| if real { 0.0 } else { part };
    let mut turned: Vec<Complex64> = (0..n).map(|i| turn * vector[(i, 0)]).collect();
    if real {
        // For a multiple eigenvalue, the imaginary part may be another eigenvector. It is dropped.
        let length = turned.iter().map(|z| z.re * z.re).sum::<f64>().sqrt();
        turned.iter_mut().for_each(|z| *z /= length);
    }
    EigenPair {
        value: c64(value.re, imaginary(value.im)),
        vector: [
            turned.iter().map(|z| z.re).collect(),
            turned.iter().map(|z| imaginary(z.im)).collect(),
        ],
    }
}

/// `Σ a b` over the common length.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `a += factor b` over the common length.
pub fn add_scaled(a: &mut [f64], factor: f64, b: &[f64]) {
    for (a, b) in a.iter_mut().zip(b) {
        *a += factor * b;
    }
}

/// The part of a vector that is orthogonal to the orthonormal vectors `basis`, by two passes of Gram–Schmidt. The
/// second pass removes the round-off of the first.
pub fn orthogonal_part(vector: &[f64], basis: &[Vec<f64>]) -> Vec<f64> {
    let mut left = vector.to_vec();
    for unit in basis.iter().chain(basis) {
        let along = dot(unit, &left);
        add_scaled(&mut left, -along, unit);
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random::Stream;

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
        assert!((values[0].norm() - r).abs() < 1e-15);
        assert!((values[0].arg().abs() - phi).abs() < 1e-15);
        assert!((values[2].re - 0.3).abs() < 1e-15);
    }

    #[test]
    fn an_eigenpair_is_what_the_matrix_only_turns_and_scales() {
        // A complex pair and a real eigenvalue, each from a shift with a small offset.
        let a = Mat::from_fn(3, 3, |i, j| {
            [[0.1, -0.8, 0.2], [0.9, 0.2, 0.0], [0.3, 0.0, 0.4]][i][j]
        });
        let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(a, b)| a * b).sum::<f64>();
        for known in eigenvalues(a.as_ref()).unwrap() {
            for off in [0.0, 1e-9, 1e-3] {
                let EigenPair { value, vector } = eigenpair(a.as_ref(), known + off).unwrap();
                assert!((value - known).norm() < 1e-12);
                let [re, im] = &vector;
                assert!((dot(re, re) + dot(im, im) - 1.0).abs() < 1e-14);
                assert_eq!(known.im == 0.0, im.iter().all(|u| *u == 0.0));
                for i in 0..3 {
                    let row: Vec<f64> = (0..3).map(|j| a[(i, j)]).collect();
                    let off = c64(dot(&row, re), dot(&row, im)) - value * c64(re[i], im[i]);
                    assert!(off.norm() < 1e-12);
                }
            }
        }
    }

    /// Every vector is an eigenvector here. The result is nevertheless real and has unit length.
    #[test]
    fn the_vector_of_a_multiple_eigenvalue_has_unit_length() {
        for n in [2, 3] {
            let a = Mat::from_fn(n, n, |i, j| if i == j { -0.85 } else { 0.0 });
            for off in [1e-12, 1e-9] {
                let near = Complex64::from(-0.85 + off);
                let [re, im] = eigenpair(a.as_ref(), near).unwrap().vector;
                let length = re.iter().map(|x| x * x).sum::<f64>().sqrt();
                assert!((length - 1.0).abs() < 1e-14, "{n} {off}: {length}");
                assert!(im.iter().all(|x| *x == 0.0));
            }
        }
    }

    #[test]
    fn both_factors_solve_complex_systems() {
        for n in [1, 2, 3, 5] {
            let mut stream = Stream::new(3, n as u64, 0);
            let matrix = Mat::from_fn(n, n, |_, _| c64(stream.normal(), stream.normal()));
            let vector = Mat::from_fn(n, 1, |i, _| c64(1.0, i as f64));
            let [a, b] = [false, true].map(|plain| Shifted::new(&matrix, plain).solve(&vector));
            for i in 0..n {
                assert!((a[(i, 0)] - b[(i, 0)]).norm() < 1e-12, "{n} {i}");
            }
        }
    }

    /// The eigenvalue may be any double close to the given number: no shift makes the shifted matrix
    /// singular.
    #[test]
    fn eigenvalues_beside_the_given_one_are_found() {
        for n in [1, 2] {
            for units in -8..=8 {
                let own = 1.0 + f64::from(units) * f64::EPSILON;
                let a = Mat::from_fn(n, n, |i, j| [[own, 0.0], [0.3, 0.5]][i][j]);
                let found = eigenpair(a.as_ref(), Complex64::ONE).unwrap();
                assert!((found.value.re - own).abs() < 1e-15, "{n} {units}");
            }
        }
    }

    /// Eigenvalues are found even if products of entries underflow or overflow.
    #[test]
    fn eigenvalues_scale_with_the_matrix() {
        let entries = [[0.1, -0.8, 0.2], [0.9, 0.2, 0.0], [0.3, 0.0, 0.4]];
        let whole = Mat::from_fn(3, 3, |i, j| entries[i][j]);
        let known = eigenvalues(whole.as_ref()).unwrap();
        for power in [-980, -600, 600, 1000] {
            let scale = f64::from(power).exp2();
            let scaled = Mat::from_fn(3, 3, |i, j| scale * entries[i][j]);
            for (found, known) in eigenvalues(scaled.as_ref()).unwrap().iter().zip(&known) {
                assert!((found / scale - known).norm() < 1e-15, "{power}");
                let pair = eigenpair(scaled.as_ref(), *found).unwrap();
                assert!((pair.value / scale - known).norm() < 1e-13, "{power}");
            }
        }
        let subnormal = Mat::from_fn(1, 1, |_, _| 5e-324);
        assert_eq!(eigenvalues(subnormal.as_ref()).unwrap()[0].re, 5e-324);
    }

    #[test]
    fn a_matrix_that_is_not_finite_has_no_eigenpair() {
        let a = Mat::from_fn(2, 2, |i, _| if i == 0 { f64::NAN } else { 1.0 });
        assert!(eigenpair(a.as_ref(), Complex64::ONE).is_none());
        let nothing: Mat<f64> = Mat::zeros(0, 0);
        assert!(eigenpair(nothing.as_ref(), Complex64::ONE).is_none());
    }
}
