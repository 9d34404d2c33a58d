//! Eigenvectors of a group of blocks: waves for fast eigenvalues, a subspace for slow ones.

use super::cluster::{Pair, separate};
use crate::propagate::TableError;
use faer::Mat;
use faer::linalg::solvers::{PartialPivLu, Solve};
use num_complex::{Complex64, c64};

/// An invariant group of blocks in its eigenvectors.
pub struct Eigen {
    /// α + iν of every wave, ν ≥ 0.
    pub waves: Vec<Complex64>,
    /// Real columns: 2 Re V and −2 Im V for a wave, V and 0 for a real eigenvalue.
    pub columns: Vec<[Vec<f64>; 2]>,
    /// Basis of the slow subspace.
    pub slow: Vec<Vec<f64>>,
}

/// The fast eigenvalues of a matrix whose imaginary parts are not negative, with their vectors; `None` if they are not
/// found.
fn fast(a: &Mat<f64>, slow_rate: f64) -> Option<Vec<Pair>> {
    let size = a.nrows();
    let found = a.eigen().ok()?;
    let values = found.S().column_vector();
    let mut pairs: Vec<Pair> = (0..size)
        .filter(|&j| values[j].norm() >= slow_rate && values[j].im >= 0.0)
        .map(|j| (values[j], (0..size).map(|i| found.U()[(i, j)]).collect()))
        .collect();
    separate(a.as_ref(), &mut pairs);
    Some(pairs)
}

/// Waves and slow subspace of a matrix.
pub fn eigen(a: &Mat<f64>, slow_rate: f64) -> Result<Eigen, TableError> {
    let failed = TableError::Defective {
        condition: f64::INFINITY,
        error: f64::INFINITY,
    };
    let size = a.nrows();
    let mut found = Eigen {
        waves: Vec::new(),
        columns: Vec::new(),
        slow: Vec::new(),
    };
    for (value, vector) in fast(a, slow_rate).ok_or(failed)? {
        let length = vector.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt();
        let vector = |i: usize| vector[i] / length;
        found.waves.push(value);
        found.columns.push(if value.im > 0.0 {
            [
                (0..size).map(|i| 2.0 * vector(i).re).collect(),
                (0..size).map(|i| -2.0 * vector(i).im).collect(),
            ]
        } else {
            [(0..size).map(|i| vector(i).re).collect(), vec![0.0; size]]
        });
    }
    let count = found
        .waves
        .iter()
        .map(|wave| if wave.im > 0.0 { 2 } else { 1 })
        .sum::<usize>();
    if count == size {
        return Ok(found);
    }
    if count == 0 {
        found.slow = (0..size)
            .map(|i| (0..size).map(|j| f64::from(u8::from(i == j))).collect())
            .collect();
        return Ok(found);
    }
    // The slow subspace is orthogonal to the fast left eigenvectors.
    let mut vectors: Vec<Vec<f64>> = Vec::new();
    for (value, vector) in fast(&a.transpose().to_owned(), slow_rate).ok_or(failed)? {
        vectors.push(vector.iter().map(|v| v.re).collect());
        if value.im > 0.0 {
            vectors.push(vector.iter().map(|v| v.im).collect());
        }
    }
    if vectors.len() != count {
        return Err(failed);
    }
    let q = Mat::from_fn(size, count, |i, j| vectors[j][i])
        .qr()
        .compute_Q();
    found.slow = (count..size)
        .map(|j| (0..size).map(|i| q[(i, j)]).collect())
        .collect();
    Ok(found)
}

/// Steps of refinement; each squares the error.
const REFINEMENTS: usize = 2;

/// Two eigenvalues are not refined if their coupling exceeds this fraction of their distance.
const TOO_CLOSE: f64 = 0.01;

/// Removes the round-off of the eigenvalue iteration from waves and slow subspace. With the matrix W of all columns, it
/// cancels to first order the entries of `W⁻¹ A W` that couple them.
pub fn refine(a: &Mat<f64>, found: &mut Eigen) {
    let (size, count, slow) = (a.nrows(), found.waves.len(), found.slow.len());
    let index: Vec<usize> = (0..size).collect();
    for _ in 0..REFINEMENTS {
        let Some((inverse, _)) = invert(&index, &found.columns, &found.slow) else {
            return;
        };
        let pairs = found.columns.iter().flatten();
        let all: Vec<&Vec<f64>> = pairs.chain(&found.slow).collect();
        let forward = Mat::from_fn(size, all.len(), |i, j| all[j][i]);
        let coupling = &inverse * (a * &forward);
        for (j, wave) in found.waves.iter_mut().enumerate() {
            let entry = |i: usize, k: usize| coupling[(2 * j + i, 2 * j + k)];
            *wave = if wave.im > 0.0 {
                c64(
                    0.5 * (entry(0, 0) + entry(1, 1)),
                    0.5 * (entry(1, 0) - entry(0, 1)),
                )
            } else {
                entry(0, 0).into()
            };
        }
        let lambda = &found.waves;
        let undo = |part: Complex64, distance: Complex64| {
            if part.norm() < TOO_CLOSE * distance.norm() {
                part / distance
            } else {
                Complex64::ZERO
            }
        };
        // New coordinates in terms of old ones: the identity and small corrections.
        let mut change = Mat::<f64>::identity(all.len(), all.len());
        for j in 0..count {
            for i in 0..count {
                let entry = |p: usize, q: usize| coupling[(2 * i + p, 2 * j + q)];
                let (a, b, c, d) = (entry(0, 0), entry(0, 1), entry(1, 0), entry(1, 1));
                let (along, across) = (c64(a + d, c - b) * 0.5, c64(a - d, c + b) * 0.5);
                let mut x = Complex64::ZERO;
                if i != j {
                    x = undo(along, lambda[j] - lambda[i]);
                }
                let w = undo(across, lambda[j].conj() - lambda[i]);
                change[(2 * i, 2 * j)] += x.re + w.re;
                change[(2 * i + 1, 2 * j)] += x.im + w.im;
                change[(2 * i, 2 * j + 1)] += w.im - x.im;
                change[(2 * i + 1, 2 * j + 1)] += x.re - w.re;
            }
            for k in 2 * count..2 * count + slow {
                let driven = c64(coupling[(k, 2 * j)], -coupling[(k, 2 * j + 1)]);
                let t = undo(driven, lambda[j]);
                change[(k, 2 * j)] += t.re;
                change[(k, 2 * j + 1)] -= t.im;
                let driving = c64(coupling[(2 * j, k)], coupling[(2 * j + 1, k)]);
                let x = undo(-driving, lambda[j]);
                change[(2 * j, k)] += x.re;
                change[(2 * j + 1, k)] += x.im;
            }
        }
        let better = forward * change;
        let column = |j: usize| -> Vec<f64> { (0..size).map(|i| better[(i, j)]).collect() };
        for (j, pair) in found.columns.iter_mut().enumerate() {
            let real = found.waves[j].im == 0.0;
            *pair = [
                column(2 * j),
                if real { vec![0.0; size] } else { column(2 * j + 1) },
            ];
        }
        for (k, vector) in found.slow.iter_mut().enumerate() {
            *vector = column(2 * count + k);
        }
    }
}

/// Inverse of the basis over the components at `index`, with the rows u₀, v₀, u₁, … and the slow ones, and condition
/// number of the basis. v of a real wave has a zero row. `None` if the basis is not square.
pub fn invert(
    index: &[usize],
    columns: &[[Vec<f64>; 2]],
    slow: &[Vec<f64>],
) -> Option<(Mat<f64>, f64)> {
    let size = index.len();
    let real = |pair: &[Vec<f64>; 2]| pair[1].iter().all(|v| *v == 0.0);
    let mut kept: Vec<(usize, &Vec<f64>)> = Vec::new();
    for (w, pair) in columns.iter().enumerate() {
        kept.push((2 * w, &pair[0]));
        if !real(pair) {
            kept.push((2 * w + 1, &pair[1]));
        }
    }
    kept.extend(
        slow.iter()
            .enumerate()
            .map(|(i, v)| (2 * columns.len() + i, v)),
    );
    if kept.len() != size {
        return None;
    }
    let mut inverse = Mat::<f64>::zeros(2 * columns.len() + slow.len(), size);
    if size == 0 {
        return Some((inverse, 1.0));
    }
    let basis = Mat::from_fn(size, size, |i, j| kept[j].1[index[i]]);
    let singular = basis.singular_values().ok()?;
    let condition = singular[0] / singular[size - 1];
    let identity = Mat::<f64>::identity(size, size);
    let lu = PartialPivLu::new(basis.as_ref());
    let mut rows = lu.solve(&identity);
    // One step of Newton and Schulz removes the solver's round-off.
    let error = &identity - &basis * &rows;
    rows = &rows + &rows * error;
    for (i, (row, _)) in kept.iter().enumerate() {
        for j in 0..size {
            inverse[(*row, j)] = rows[(i, j)];
        }
    }
    Some((inverse, condition))
}

/// Sets the entries of the waves' columns in the blocks `apart`, which the waves drive: for each of these blocks
/// `(λ − A) X = A_other V`, with the column V in the other blocks.
pub fn follow(a: &Mat<f64>, apart: &[usize], waves: &[Complex64], columns: &mut [[Vec<f64>; 2]]) {
    let n = a.nrows() / 2;
    for (&lambda, pair) in waves.iter().zip(columns) {
        let mut found = Vec::with_capacity(apart.len());
        for &i in apart {
            let driven = |row: usize| -> Complex64 {
                (0..2 * n)
                    .map(|k| c64(a[(row, k)] * pair[0][k], -a[(row, k)] * pair[1][k]))
                    .sum()
            };
            let (f, g) = (driven(i), driven(n + i));
            let (p, q) = (lambda - a[(i, i)], c64(-a[(i, n + i)], 0.0));
            let (r, s) = (c64(-a[(n + i, i)], 0.0), lambda - a[(n + i, n + i)]);
            let det = p * s - q * r;
            found.push((i, (s * f - q * g) / det, (p * g - r * f) / det));
        }
        for (i, x, y) in found {
            (pair[0][i], pair[1][i]) = (x.re, -x.im);
            (pair[0][n + i], pair[1][n + i]) = (y.re, -y.im);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random::Stream;

    /// Two damped waves, a decay, and a displacement with its constant speed.
    const WAVES: [[f64; 2]; 3] = [[-10.0, 300.0], [-20.0, 1000.0], [-500.0, 0.0]];

    const SIZE: usize = 7;

    /// A matrix with these eigenvalues and the slow pair, in slightly oblique coordinates.
    fn matrix(number: u64) -> Mat<f64> {
        let mut stream = Stream::new(5, number, 0);
        let mut own = Mat::<f64>::zeros(SIZE, SIZE);
        for (j, [alpha, nu]) in WAVES[..2].iter().enumerate() {
            for i in 0..2 {
                own[(2 * j + i, 2 * j + i)] = *alpha;
            }
            own[(2 * j, 2 * j + 1)] = -nu;
            own[(2 * j + 1, 2 * j)] = *nu;
        }
        own[(4, 4)] = WAVES[2][0];
        own[(5, 6)] = 1.0;
        let askew = Mat::from_fn(SIZE, SIZE, |i, j| {
            f64::from(u8::from(i == j)) + 0.2 * stream.normal()
        });
        let back = PartialPivLu::new(askew.as_ref()).solve(Mat::<f64>::identity(SIZE, SIZE));
        askew * own * back
    }

    /// The largest entry of `W⁻¹ A W` that couples waves and slow subspace, relative to its norm.
    fn coupling(a: &Mat<f64>, found: &Eigen) -> f64 {
        let index: Vec<usize> = (0..SIZE).collect();
        let (inverse, condition) = invert(&index, &found.columns, &found.slow).unwrap();
        assert!(condition.is_finite());
        let all: Vec<&Vec<f64>> = found.columns.iter().flatten().chain(&found.slow).collect();
        let forward = Mat::from_fn(SIZE, all.len(), |i, j| all[j][i]);
        let mut rest = &inverse * (a * &forward);
        for (j, wave) in found.waves.iter().enumerate() {
            for (p, q, value) in [
                (0, 0, wave.re),
                (1, 1, wave.re),
                (1, 0, wave.im),
                (0, 1, -wave.im),
            ] {
                // A real eigenvalue has no second column.
                if wave.im > 0.0 || p + q == 0 {
                    rest[(2 * j + p, 2 * j + q)] -= value;
                }
            }
        }
        let slow = 2 * found.waves.len();
        for i in slow..slow + found.slow.len() {
            for j in slow..slow + found.slow.len() {
                rest[(i, j)] = 0.0;
            }
        }
        rest.norm_max() / a.norm_l2()
    }

    fn sorted(waves: &[Complex64]) -> Vec<Complex64> {
        let mut waves = waves.to_vec();
        waves.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
        waves
    }

    #[test]
    fn waves_and_the_slow_subspace_are_invariant() {
        for number in 0..8 {
            let a = matrix(number);
            let found = eigen(&a, 1.0).unwrap();
            assert_eq!((found.waves.len(), found.slow.len()), (3, 2));
            for (wave, [alpha, nu]) in sorted(&found.waves)
                .into_iter()
                .zip([WAVES[0], WAVES[2], WAVES[1]])
            {
                assert!((wave - c64(alpha, nu)).norm() < 1e-9, "{wave}");
            }
            let off = coupling(&a, &found);
            assert!(off < 1e-12, "{off:e}");
        }
        // All eigenvalues are slow, then none is slow.
        let a = matrix(9);
        let still = eigen(&a, 1e4).unwrap();
        assert_eq!((still.waves.len(), still.slow.len()), (0, SIZE));
        let turning = Mat::from_fn(2, 2, |i, j| [[0.0, -3.0], [3.0, 0.0]][i][j]);
        let mut alone = eigen(&turning, 1.0).unwrap();
        // Equal waves without coupling need no correction.
        let twice = Mat::from_fn(4, 4, |i, j| {
            if i / 2 == j / 2 { turning[(i % 2, j % 2)] } else { 0.0 }
        });
        let column = |one: usize| [0, 1, 2, 3].map(|i| f64::from(u8::from(i == one))).to_vec();
        let mut pair = Eigen {
            waves: vec![c64(0.0, 3.0); 2],
            columns: vec![[column(0), column(1)], [column(2), column(3)]],
            slow: Vec::new(),
        };
        refine(&twice, &mut pair);
        assert_eq!(pair.waves, [c64(0.0, 3.0); 2]);
        assert_eq!(
            pair.columns,
            [[column(0), column(1)], [column(2), column(3)]]
        );
        refine(&turning, &mut alone);
        assert_eq!((alone.waves.len(), alone.slow.len()), (1, 0));
        assert!((alone.waves[0] - c64(0.0, 3.0)).norm() < 1e-14);
    }

    /// Errors of one millionth in eigenvectors are reduced to round-off.
    #[test]
    fn refinement_squares_the_error() {
        for number in 0..8 {
            let a = matrix(number);
            let mut found = eigen(&a, 1.0).unwrap();
            let mut stream = Stream::new(6, number, 0);
            for (pair, wave) in found.columns.iter_mut().zip(&found.waves) {
                let parts = if wave.im > 0.0 { 2 } else { 1 };
                for x in pair[..parts].iter_mut().flatten() {
                    *x += 1e-6 * stream.normal();
                }
            }
            for x in found.slow.iter_mut().flatten() {
                *x += 1e-6 * stream.normal();
            }
            let before = coupling(&a, &found);
            refine(&a, &mut found);
            let after = coupling(&a, &found);
            assert!(before > 1e-8 && after < 1e-13, "{before:e} {after:e}");
            assert!(
                found
                    .columns
                    .iter()
                    .zip(&found.waves)
                    .all(|(pair, wave)| { wave.im > 0.0 || pair[1].iter().all(|x| *x == 0.0) })
            );
        }
    }

    /// With their contributions to a block that affects no other, waves are eigenvectors of the whole matrix.
    #[test]
    fn blocks_apart_follow_the_waves() {
        let mut stream = Stream::new(7, 0, 0);
        // Three blocks, first components before second ones; the others affect only the first.
        let mut a = Mat::<f64>::zeros(6, 6);
        for (block, (frequency, damping)) in [(0.0, 0.3), (40.0, 1.0), (90.0, 2.0)]
            .into_iter()
            .enumerate()
        {
            a[(block, 3 + block)] = 1.0;
            a[(3 + block, block)] = -frequency * frequency;
            a[(3 + block, 3 + block)] = -damping;
        }
        for row in 3..6 {
            for column in [1, 2, 4, 5] {
                a[(row, column)] += 5.0 * stream.normal();
            }
        }
        (a[(0, 1)], a[(0, 5)]) = (0.7, -0.4);
        let rest = [1, 2, 4, 5];
        let part = Mat::from_fn(4, 4, |i, j| a[(rest[i], rest[j])]);
        let found = eigen(&part, 1.0).unwrap();
        assert_eq!(found.waves.len(), 2);
        let mut columns: Vec<[Vec<f64>; 2]> = (found.columns.iter())
            .map(|pair| {
                pair.each_ref().map(|part| {
                    let mut whole = vec![0.0; 6];
                    rest.iter().zip(part).for_each(|(&i, x)| whole[i] = *x);
                    whole
                })
            })
            .collect();
        follow(&a, &[0], &found.waves, &mut columns);
        for (wave, [u, v]) in found.waves.iter().zip(&columns) {
            for i in 0..6 {
                let image = |x: &[f64]| (0..6).map(|k| a[(i, k)] * x[k]).sum::<f64>();
                let off = [
                    image(u) - (wave.re * u[i] + wave.im * v[i]),
                    image(v) - (wave.re * v[i] - wave.im * u[i]),
                ];
                assert!(off.iter().all(|x| x.abs() < 1e-10), "{i}: {off:?}");
            }
        }
    }
}
