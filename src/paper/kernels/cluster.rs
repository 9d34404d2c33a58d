//! Eigenvectors of nearly equal eigenvalues.
//!
//! Modes of equal frequency, or identical shafts, give a generator the same eigenvalue several times. Any basis of its
//! subspace consists of eigenvectors, but a general decomposition returns nearly parallel ones. This module finds the
//! subspace as a whole, by inverse iteration on a block, with an orthonormal basis V: `A V = V B` with `B = Vᴴ A V`.
//! For a repeated eigenvalue, B is that value times the identity, to round-off, and V contains its eigenvectors. If
//! eigenvalues differ by more than round-off, the eigenvectors of the small matrix B rotate V. They are computed from
//! the deviation of B from its mean only, so that they are as independent as the problem allows. A defective subspace
//! keeps a nearly parallel basis, so that users must check its condition.

use faer::linalg::solvers::{PartialPivLu, Solve};
use faer::{Mat, MatRef};
use num_complex::{Complex64, c64};

/// Largest distance between neighbours in a cluster, relative to the size of the matrix.
const TOGETHER: f64 = 1e-9;

/// Round-off of the deviations of B from its mean, relative to the size of the matrix.
const ROUND_OFF: f64 = 64.0 * f64::EPSILON;

/// Distance of the shift from a cluster, relative to the distance to the next eigenvalue. One step of inverse iteration
/// reduces all other components by this factor.
const SHIFT: f64 = 1e-4;

/// Steps of inverse iteration: two more than a factor of 1e-4 per step needs to reach round-off.
const STEPS: usize = 6;

/// An eigenvalue with its vector.
pub type Pair = (Complex64, Vec<Complex64>);

/// Replaces nearly equal complex eigenvalues of `a`, and their vectors. All others, also real ones, stay unchanged.
/// `pairs`: eigenvalues with non-negative imaginary parts.
pub fn separate(a: MatRef<'_, f64>, pairs: &mut [Pair]) {
    let size = a.norm_max() * a.nrows() as f64;
    for members in clusters(pairs, TOGETHER * size) {
        if let Some(better) = basis(a, pairs, &members, size) {
            for (&member, pair) in members.iter().zip(better) {
                pairs[member] = pair;
            }
        }
    }
}

/// Groups of two and more complex eigenvalues, each within `reach` of another of its group.
fn clusters(pairs: &[Pair], reach: f64) -> Vec<Vec<usize>> {
    let mut left: Vec<usize> = (0..pairs.len())
        .filter(|&j| pairs[j].0.im > reach)
        .collect();
    let mut found = Vec::new();
    while let Some(first) = left.pop() {
        let mut members = vec![first];
        let mut known = 0;
        while known < members.len() {
            let near = |j: &usize| (pairs[*j].0 - pairs[members[known]].0).norm() <= reach;
            let (more, rest) = left.iter().partition::<Vec<usize>, _>(|j| near(j));
            members.extend(more);
            left = rest;
            known += 1;
        }
        if members.len() > 1 {
            members.sort_unstable();
            found.push(members);
        }
    }
    found
}

/// New pairs for the members of a cluster; `None` if the iteration breaks down.
fn basis(a: MatRef<'_, f64>, pairs: &[Pair], members: &[usize], size: f64) -> Option<Vec<Pair>> {
    let (n, m) = (a.nrows(), members.len());
    let mean = members.iter().map(|&j| pairs[j].0).sum::<Complex64>() / m as f64;
    let others = (0..pairs.len())
        .filter(|j| !members.contains(j))
        .map(|j| (pairs[j].0 - mean).norm());
    // The conjugates are eigenvalues too.
    let gap = others.fold(2.0 * mean.im, f64::min);
    let shift = mean + SHIFT * gap;
    let shifted = Mat::from_fn(n, n, |i, j| {
        let diagonal = if i == j { shift } else { Complex64::ZERO };
        c64(a[(i, j)], 0.0) - diagonal
    });
    let factors = PartialPivLu::new(shifted.as_ref());
    // Start from vectors that are unlikely to be orthogonal to the subspace of the cluster.
    let mut v = Mat::from_fn(n, m, |i, j| {
        let place = (1 + i + n * j) as f64;
        c64((1.3 * place * place).sin(), (0.7 * place * place).cos())
    });
    for _ in 0..STEPS {
        v = orthonormal(factors.solve(&v))?;
    }
    let image = product(a, &v);
    let b = v.adjoint() * &image;
    let mean = (0..m).map(|j| b[(j, j)]).sum::<Complex64>() / m as f64;
    let deviation = Mat::from_fn(m, m, |i, j| {
        b[(i, j)] - if i == j { mean } else { Complex64::ZERO }
    });
    let column = |v: &Mat<Complex64>, j: usize| (0..n).map(|i| v[(i, j)]).collect::<Vec<_>>();
    let unit = deviation.norm_max();
    if unit <= ROUND_OFF * size {
        return Some((0..m).map(|j| (mean, column(&v, j))).collect());
    }
    let small = Mat::from_fn(m, m, |i, j| deviation[(i, j)] / unit);
    let turned = small.eigen().ok()?;
    let values = turned.S().column_vector();
    let mut turn = turned.U().to_owned();
    for j in 0..m {
        let length = turn.col(j).norm_l2();
        for i in 0..m {
            turn[(i, j)] /= length;
        }
    }
    let v = &v * &turn;
    Some(
        (0..m)
            .map(|j| (mean + values[j] * unit, column(&v, j)))
            .collect(),
    )
}

/// Columns orthonormalised twice by Gram and Schmidt; `None` if one vanishes or is not finite.
fn orthonormal(mut v: Mat<Complex64>) -> Option<Mat<Complex64>> {
    let (n, m) = (v.nrows(), v.ncols());
    for j in 0..m {
        for _ in 0..2 {
            for k in 0..j {
                let along: Complex64 = (0..n).map(|i| v[(i, k)].conj() * v[(i, j)]).sum();
                for i in 0..n {
                    let part = v[(i, k)] * along;
                    v[(i, j)] -= part;
                }
            }
            let length = v.col(j).norm_l2();
            if !(length.is_finite() && length > 0.0) {
                return None;
            }
            for i in 0..n {
                v[(i, j)] /= length;
            }
        }
    }
    Some(v)
}

fn product(a: MatRef<'_, f64>, v: &Mat<Complex64>) -> Mat<Complex64> {
    Mat::from_fn(a.nrows(), v.ncols(), |i, j| {
        (0..a.ncols()).map(|k| v[(k, j)] * a[(i, k)]).sum()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Blocks `[α, −ν; ν, α]`, transformed by a matrix that is not orthogonal.
    fn turned(blocks: &[(f64, f64)]) -> Mat<f64> {
        let n = 2 * blocks.len();
        let a = Mat::from_fn(n, n, |i, j| match (i / 2 == j / 2, i % 2, j % 2) {
            (false, ..) => 0.0,
            (true, p, q) if p == q => blocks[i / 2].0,
            (true, p, _) => blocks[i / 2].1 * if p == 1 { 1.0 } else { -1.0 },
        });
        let w = Mat::from_fn(n, n, |i, j| {
            f64::from(u8::from(i == j)) + 0.3 * ((1 + i + n * j) as f64).sin()
        });
        let inverse = PartialPivLu::new(w.as_ref()).solve(Mat::<f64>::identity(n, n));
        w * a * inverse
    }

    fn residual(a: &Mat<f64>, (value, vector): &Pair) -> f64 {
        let n = a.nrows();
        let row = |i: usize| -> Complex64 { (0..n).map(|k| vector[k] * a[(i, k)]).sum() };
        let off = (0..n).map(|i| (row(i) - value * vector[i]).norm());
        off.fold(0.0, f64::max)
    }

    /// For any input vectors, those of a repeated eigenvalue become orthonormal.
    #[test]
    fn a_repeated_eigenvalue_has_independent_vectors() {
        let a = turned(&[(-0.3, 5.0), (-0.1, 2.0), (-0.3, 5.0), (-0.3, 5.0)]);
        let value = c64(-0.3, 5.0);
        let parallel = vec![c64(1.0, 0.0); 8];
        let mut pairs = vec![(value, parallel); 3];
        pairs.insert(1, (c64(-0.1, 2.0), vec![Complex64::ZERO; 8]));
        separate(a.as_ref(), &mut pairs);
        assert_eq!(pairs[1].1, vec![Complex64::ZERO; 8]);
        for i in [0, 2, 3] {
            assert!((pairs[i].0 - value).norm() < 1e-13);
            assert!(
                residual(&a, &pairs[i]) < 1e-13,
                "{}",
                residual(&a, &pairs[i])
            );
            for j in [0, 2, 3] {
                let dot: Complex64 = (pairs[i].1.iter().zip(&pairs[j].1))
                    .map(|(x, y)| x.conj() * y)
                    .sum();
                let unit = c64(f64::from(u8::from(i == j)), 0.0);
                assert!((dot - unit).norm() < 1e-14);
            }
        }
    }

    /// Slightly different eigenvalues keep their difference, each with a separate vector.
    #[test]
    fn near_eigenvalues_are_told_apart() {
        let apart = 1e-11;
        let a = turned(&[(-0.3, 5.0), (-0.1, 2.0), (-0.3, 5.0 + apart)]);
        let mut pairs: Vec<Pair> = [5.0, 5.0 + apart, 2.0]
            .map(|nu| {
                (
                    c64(if nu > 3.0 { -0.3 } else { -0.1 }, nu),
                    vec![Complex64::ZERO; 6],
                )
            })
            .to_vec();
        separate(a.as_ref(), &mut pairs);
        let [first, second] = [&pairs[0], &pairs[1]];
        assert!(((first.0 - second.0).norm() / apart - 1.0).abs() < 1e-3);
        for pair in [first, second] {
            assert!(residual(&a, pair) < 1e-13);
        }
        let dot: Complex64 = (first.1.iter().zip(&second.1))
            .map(|(x, y)| x.conj() * y)
            .sum();
        assert!(dot.norm() < 0.9, "{dot}");
    }

    #[test]
    fn eigenvalues_apart_and_real_ones_are_left_alone() {
        let a = turned(&[(-0.3, 5.0), (-0.1, 2.0)]);
        let pairs = vec![
            (c64(-0.3, 5.0), vec![Complex64::ZERO; 4]),
            (c64(-0.1, 2.0), vec![Complex64::ZERO; 4]),
            (c64(-0.1, 0.0), vec![Complex64::ZERO; 4]),
            (c64(-0.1, 0.0), vec![Complex64::ZERO; 4]),
        ];
        let mut same = pairs.clone();
        separate(a.as_ref(), &mut same);
        assert_eq!(same, pairs);
    }
}
