//! The invariant planes of a matrix, each given by two columns.

use super::clusters::separate;
use super::improvement::{norm, unit_length};
use super::parts::{
    Block, Direction, LEAST_IMAGINARY, MOST_EIGENVECTOR_CONDITION, OFFSET, PARALLEL_COSINE,
    PLANE_CONDITION, POOR_RESIDUAL, ROUND_OFF, SPLIT_IMAGINARY,
};
use crate::numerics::linalg::{dot, orthogonal_part};
use faer::{Mat, prelude::*};
use std::cmp::Reverse;

/// A real eigenvalue and its eigenvector of the inner matrix.
type RealPair = (f64, Vec<f64>);

/// Starting values of the blocks, from the eigenvectors of the matrix without its known columns. `None` if an
/// iteration does not converge.
pub(super) fn plane_bases(a: &Mat<f64>, kind: &[Direction]) -> Option<Vec<Block>> {
    let columns = Columns::new(a, kind);
    let inner = columns.inner();
    let mut blocks = columns.free_blocks();
    let real = columns.complex_blocks(&inner, &mut blocks)?;
    let left = columns.rigid_blocks(real, &mut blocks)?;
    for [(l1, y1), (l2, y2)] in paired(left) {
        let sine = (1.0 - dot(&y1, &y2).abs()).max(f64::MIN_POSITIVE);
        let plane = plane(&inner, [y1, y2], (2.0 / sine).sqrt(), l1 + l2, l1 * l2)?;
        let generator = project(&inner, &plane);
        blocks.push(columns.lift(plane, generator, false));
    }
    (blocks.len() == kind.len()).then_some(blocks)
}

/// The columns of a matrix. Those of free directions and of unsprung displacements are known. The other ones
/// form the inner matrix.
struct Columns<'a> {
    a: &'a Mat<f64>,
    rest: Vec<usize>,
    free: Vec<usize>,
    zero: Vec<usize>,
}

impl<'a> Columns<'a> {
    fn new(a: &'a Mat<f64>, kind: &[Direction]) -> Self {
        let m = kind.len();
        let with = |wanted| (0..m).filter(move |i| kind[*i] == wanted).collect();
        let rest = (0..a.nrows()).filter(|k| match kind[k % m] {
            Direction::General => true,
            Direction::Free => false,
            Direction::Unsprung => *k >= m,
        });
        Self {
            a,
            rest: rest.collect(),
            free: with(Direction::Free),
            zero: with(Direction::Unsprung),
        }
    }

    /// The matrix without the known columns.
    fn inner(&self) -> Mat<f64> {
        let (rest, size) = (&self.rest, self.rest.len());
        Mat::from_fn(size, size, |i, j| self.a[(rest[i], rest[j])])
    }

    /// One block per free direction.
    fn free_blocks(&self) -> Vec<Block> {
        let (a, size) = (self.a, self.a.nrows());
        let m = size / 2;
        let unit = |k: usize| {
            (0..size)
                .map(|i| if i == k { 1.0 } else { 0.0 })
                .collect::<Vec<f64>>()
        };
        (self.free.iter())
            .map(|i| Block {
                columns: [unit(*i), unit(m + i)],
                generator: [[0.0, a[(*i, m + i)]], [0.0, 0.0]],
                is_rotation: false,
            })
            .collect()
    }

    /// Adds a block for each pair of complex eigenvalues of the inner matrix. Returns the real eigenvalues.
    fn complex_blocks(&self, inner: &Mat<f64>, blocks: &mut Vec<Block>) -> Option<Vec<RealPair>> {
        let eigen = inner.eigen().ok()?;
        let values: Vec<c64> = eigen.S().column_vector().iter().copied().collect();
        let mut vectors = eigen.U().to_owned();
        let size = inner.norm_l2();
        separate(inner, &values, &mut vectors, LEAST_IMAGINARY * size);
        let mut real = Vec::new();
        for (k, value) in values.into_iter().enumerate() {
            // The conjugate eigenvalue has the same plane.
            if value.im < 0.0 {
                continue;
            }
            let mut vector = vectors.col(k).to_owned();
            refine_vector(inner, value, &mut vector);
            let parts = [
                vector.iter().map(|v| v.re).collect::<Vec<f64>>(),
                vector.iter().map(|v| v.im).collect(),
            ];
            if value.im == 0.0 {
                let length = norm(&parts[0]);
                real.push((value.re, parts[0].iter().map(|v| v / length).collect()));
                continue;
            }
            let condition = condition(&parts);
            if value.im <= SPLIT_IMAGINARY * size && condition <= MOST_EIGENVECTOR_CONDITION {
                // Round-off has split a double real eigenvalue with two eigenvectors.
                real.extend(orthonormal(parts).map(|vector| (value.re, vector)));
            } else if value.im > LEAST_IMAGINARY * size && condition <= MOST_EIGENVECTOR_CONDITION {
                let generator = [[value.re, value.im], [-value.im, value.re]];
                blocks.push(self.lift(parts, generator, true));
            } else {
                let (trace, det) = (2.0 * value.re, value.re.powi(2) + value.im.powi(2));
                let plane = plane(inner, parts, condition, trace, det)?;
                let generator = project(inner, &plane);
                blocks.push(self.lift(plane, generator, false));
            }
        }
        Some(real)
    }

    /// Adds the blocks of the unsprung displacements. Returns the remaining real eigenvalues.
    ///
    /// The zero eigenvalue of a rigid displacement shares a block with the slow decay of its speed. If the
    /// drag is light, the eigenvectors of both are nearly parallel.
    fn rigid_blocks(
        &self,
        mut real: Vec<RealPair>,
        blocks: &mut Vec<Block>,
    ) -> Option<Vec<RealPair>> {
        let count = self.zero.len();
        let slowness = |x: &RealPair| norm(&self.rates_of_unsprung(&x.1)) / x.0.abs();
        real.sort_by(|x, y| slowness(y).total_cmp(&slowness(x)));
        let mut chosen: Vec<Vec<f64>> = Vec::new();
        let mut partners: Vec<(Vec<f64>, RealPair)> = Vec::new();
        let mut left: Vec<RealPair> = Vec::new();
        for pair in real {
            let u = self.rates_of_unsprung(&pair.1);
            let remainder = orthogonal_part(&u, &chosen);
            if chosen.len() < count && norm(&remainder) >= 0.1 * norm(&u) && norm(&u) > 0.0 {
                chosen.push(unit_length(&remainder));
                partners.push((unit_length(&u), pair));
            } else {
                left.push(pair);
            }
        }
        // Displacements without a partner complete the basis. If their number is odd, one takes any real
        // eigenvalue.
        let mut spare: Vec<Vec<f64>> = Vec::new();
        while chosen.len() < count {
            let axis = |k: usize| (0..count).map(move |i| f64::from(u8::from(i == k)));
            let axes = (0..count).map(|k| orthogonal_part(&axis(k).collect::<Vec<_>>(), &chosen));
            let next = unit_length(&axes.max_by(|x, y| norm(x).total_cmp(&norm(y)))?);
            chosen.push(next.clone());
            spare.push(next);
        }
        if spare.len() % 2 == 1 {
            partners.push((spare.pop()?, left.pop()?));
        }
        blocks.extend(spare.chunks_exact(2).map(|pair| Block {
            columns: [self.spread(&pair[0]), self.spread(&pair[1])],
            generator: [[0.0; 2]; 2],
            is_rotation: false,
        }));
        blocks.extend((partners.into_iter()).map(|(r, pair)| self.partnered(&r, pair)));
        Some(left)
    }

    /// The block of an unsprung displacement r and of a real eigenvalue.
    fn partnered(&self, r: &[f64], (value, y): RealPair) -> Block {
        let u = self.rates_of_unsprung(&y);
        let beta = dot(r, &u);
        // The second column excludes `r`, so there is no division by a small decay rate.
        let twice = [y.clone(), y];
        let mut second =
            self.lift_with_displacements(&[], twice, [[value, 0.0], [0.0, value]], true);
        let mut second = std::mem::take(&mut second.columns[1]);
        for (k, j) in self.zero.iter().enumerate() {
            let x = u[k] - beta * r[k];
            second[*j] = if x.abs() > ROUND_OFF * norm(&u) { x / value } else { 0.0 };
        }
        let length = norm(&second);
        second.iter_mut().for_each(|v| *v /= length);
        Block {
            columns: [self.spread(r), second],
            generator: [[0.0, beta / length], [0.0, value]],
            is_rotation: false,
        }
    }

    /// The rows of the matrix for the unsprung displacements, times a vector of the inner coordinates.
    fn rates_of_unsprung(&self, y: &[f64]) -> Vec<f64> {
        let rate = |j: &usize| {
            self.rest
                .iter()
                .zip(y)
                .map(|(k, v)| self.a[(*j, *k)] * v)
                .sum()
        };
        self.zero.iter().map(rate).collect()
    }

    /// A full column with given unsprung displacements, and zeros elsewhere.
    fn spread(&self, r: &[f64]) -> Vec<f64> {
        let mut column = vec![0.0; self.a.nrows()];
        (self.zero.iter().zip(r)).for_each(|(j, v)| column[*j] = *v);
        column
    }

    /// Completes two columns `Y` of inner coordinates by the other coordinates `X`.
    ///
    /// These follow from `X B - J X = C Y`, with the known columns `J` and the rows `C` of the matrix for
    /// these coordinates.
    fn lift(&self, y: [Vec<f64>; 2], b: [[f64; 2]; 2], is_rotation: bool) -> Block {
        self.lift_with_displacements(&self.zero, y, b, is_rotation)
    }

    /// As [`Self::lift`], but of the unsprung displacements only `zero` are set. The others stay 0.
    fn lift_with_displacements(
        &self,
        zero: &[usize],
        y: [Vec<f64>; 2],
        b: [[f64; 2]; 2],
        is_rotation: bool,
    ) -> Block {
        let Self { a, rest, free, .. } = self;
        let m = a.nrows() / 2;
        let det = b[0][0] * b[1][1] - b[0][1] * b[1][0];
        let solve = |u: [f64; 2]| {
            [
                (u[0] * b[1][1] - u[1] * b[1][0]) / det,
                (u[1] * b[0][0] - u[0] * b[0][1]) / det,
            ]
        };
        let rate = |j: usize| {
            [0, 1].map(|c: usize| {
                rest.iter()
                    .zip(&y[c])
                    .map(|(k, v)| a[(j, *k)] * v)
                    .sum::<f64>()
            })
        };
        let mut full = [vec![0.0; 2 * m], vec![0.0; 2 * m]];
        let mut set = |j: usize, x: [f64; 2]| [0, 1].map(|c: usize| full[c][j] = x[c]);
        for (i, k) in rest.iter().enumerate() {
            set(*k, [y[0][i], y[1][i]]);
        }
        for j in zero {
            set(*j, solve(rate(*j)));
        }
        for i in free {
            let speed = solve(rate(m + i));
            set(m + i, speed);
            set(*i, solve(speed.map(|v| a[(*i, m + i)] * v)));
        }
        let generator = if is_rotation || rest.len() == 2 * m {
            b
        } else {
            // Orthonormalise the columns with the added coordinates again, and recompute the block.
            full = orthonormal(full);
            project(a, &full)
        };
        Block {
            columns: full,
            generator,
            is_rotation,
        }
    }
}

/// Condition number of the real and the imaginary part of an eigenvector.
fn condition([re, im]: &[Vec<f64>; 2]) -> f64 {
    let (p, q, r) = (dot(re, re), dot(im, im), dot(re, im));
    let spread = ((p - q).powi(2) + 4.0 * r * r).sqrt();
    ((p + q + spread) / (p + q - spread).max(f64::MIN_POSITIVE)).sqrt()
}

/// Pairs of real eigenvalues, one pair per block. Nearly parallel eigenvectors form pairs first. The others
/// form pairs in the order of their eigenvalues.
fn paired(mut left: Vec<RealPair>) -> Vec<[RealPair; 2]> {
    let mut pairs = Vec::new();
    let mut close: Vec<(f64, usize, usize)> = (0..left.len())
        .flat_map(|i| (0..i).map(move |j| (i, j)))
        .map(|(i, j)| (dot(&left[i].1, &left[j].1).abs(), i, j))
        .filter(|c| c.0 > PARALLEL_COSINE)
        .collect();
    close.sort_by(|x, y| y.0.total_cmp(&x.0));
    let mut used: Vec<usize> = Vec::new();
    for (_, i, j) in close {
        if !used.contains(&i) && !used.contains(&j) {
            used.extend([i, j]);
            pairs.push([left[i].clone(), left[j].clone()]);
        }
    }
    used.sort_by_key(|k| Reverse(*k));
    for k in used {
        left.remove(k);
    }
    left.sort_by(|x, y| x.0.total_cmp(&y.0));
    pairs.extend(left.chunks_exact(2).map(|c| [c[0].clone(), c[1].clone()]));
    pairs
}

/// Improves an eigenvector that is inaccurate after back substitution, by inverse iteration. This occurs with
/// repeated complex eigenvalues.
pub(super) fn refine_vector(a: &Mat<f64>, value: c64, vector: &mut Col<c64>) {
    let n = a.nrows();
    let shifted = |shift: c64| {
        Mat::from_fn(n, n, |i, j| {
            c64::from(a[(i, j)]) - if i == j { shift } else { c64::ZERO }
        })
    };
    let residual = |v: &Col<c64>| {
        let row = |i: usize| (0..n).map(|k| v[k] * a[(i, k)]).sum::<c64>() - value * v[i];
        (0..n).map(|i| row(i).norm_sqr()).sum::<f64>().sqrt()
    };
    let size = a.norm_l2();
    if residual(vector) <= POOR_RESIDUAL * size * vector.norm_l2() {
        return;
    }
    // The shift has a distance from the eigenvalue, so that several eigenvectors of it keep their
    // proportions.
    let lu = shifted(value + c64::new(OFFSET * size, 0.0)).partial_piv_lu();
    for _ in 0..3 {
        let next = lu.solve(&*vector);
        *vector = &next * Scale(c64::from(1.0 / next.norm_l2()));
    }
}

/// Orthonormal basis of the invariant plane near two vectors, whose matrix has the given condition number.
/// The trace and the determinant of `a` on the plane are known.
pub(super) fn plane(
    a: &Mat<f64>,
    vectors: [Vec<f64>; 2],
    condition: f64,
    trace: f64,
    det: f64,
) -> Option<[Vec<f64>; 2]> {
    if condition <= PLANE_CONDITION {
        return Some(orthonormal(vectors));
    }
    // The plane is the null space of `A² - trace A + det`, for any Jordan form on it.
    let n = a.nrows();
    let mut quadratic = a * a - a * Scale(trace);
    (0..n).for_each(|i| quadratic[(i, i)] += det);
    let svd = quadratic.thin_svd().ok()?;
    Some([n - 1, n - 2].map(|c| (0..n).map(|i| svd.V()[(i, c)]).collect()))
}

pub(super) fn orthonormal([first, second]: [Vec<f64>; 2]) -> [Vec<f64>; 2] {
    let first = unit_length(&first);
    let second = unit_length(&orthogonal_part(
        &unit_length(&second),
        std::slice::from_ref(&first),
    ));
    [first, second]
}

/// The 2x2 block `Vᵀ A V` on an orthonormal basis `V` of an invariant plane.
pub(super) fn project(a: &Mat<f64>, basis: &[Vec<f64>; 2]) -> [[f64; 2]; 2] {
    let row = |i: usize, x: &[f64]| (0..x.len()).map(|k| a[(i, k)] * x[k]).sum::<f64>();
    let image = basis
        .each_ref()
        .map(|x| (0..x.len()).map(|i| row(i, x)).collect::<Vec<f64>>());
    [0, 1].map(|i: usize| [0, 1].map(|j: usize| dot(&basis[i], &image[j])))
}
