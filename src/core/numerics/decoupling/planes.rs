//! The invariant planes of a matrix, each by two columns.

use super::clusters::separate;
use super::improvement::{dot, norm, unit_length};
use super::parts::{
    Block, COMPLEX, Direction, OFFSET, PARALLEL_COSINE, PLANE_CONDITION, POOR, ROTATION_CONDITION,
    ROUND_OFF, SPLIT,
};
use faer::{Mat, prelude::*};
use std::cmp::Reverse;

/// Starting values of the blocks, from the eigenvectors of the matrix without its known columns.
pub(super) fn plane_bases(a: &Mat<f64>, kind: &[Direction]) -> Option<Vec<Block>> {
    let (m, size) = (kind.len(), a.nrows());
    let with = |wanted| (0..m).filter(move |i| kind[*i] == wanted);
    let (free, zero): (Vec<usize>, Vec<usize>) = (
        with(Direction::Free).collect(),
        with(Direction::Unsprung).collect(),
    );
    let rest: Vec<usize> = (0..size)
        .filter(|k| match kind[k % m] {
            Direction::General => true,
            Direction::Free => false,
            Direction::Unsprung => *k >= m,
        })
        .collect();
    let unit = |k: usize| {
        (0..size)
            .map(|i| if i == k { 1.0 } else { 0.0 })
            .collect::<Vec<f64>>()
    };
    let mut blocks: Vec<Block> = free
        .iter()
        .map(|i| Block {
            columns: [unit(*i), unit(m + i)],
            generator: [[0.0, a[(*i, m + i)]], [0.0, 0.0]],
            rotation: false,
        })
        .collect();
    let inner = Mat::from_fn(rest.len(), rest.len(), |i, j| a[(rest[i], rest[j])]);
    let eigen = inner.eigen().ok()?;
    let values: Vec<c64> = eigen.S().column_vector().iter().copied().collect();
    let mut vectors = eigen.U().to_owned();
    separate(&inner, &values, &mut vectors, COMPLEX * inner.norm_l2());
    let mut real: Vec<(f64, Vec<f64>)> = Vec::new();
    for k in 0..rest.len() {
        let value = values[k];
        let mut vector = vectors.col(k).to_owned();
        if value.im >= 0.0 {
            refine_vector(&inner, value, &mut vector);
        }
        let parts = [
            vector.iter().map(|v| v.re).collect::<Vec<f64>>(),
            vector.iter().map(|v| v.im).collect(),
        ];
        if value.im == 0.0 {
            let length = norm(&parts[0]);
            real.push((value.re, parts[0].iter().map(|v| v / length).collect()));
        } else if value.im > 0.0 {
            let (p, q, r) = (
                dot(&parts[0], &parts[0]),
                dot(&parts[1], &parts[1]),
                dot(&parts[0], &parts[1]),
            );
            let spread = ((p - q).powi(2) + 4.0 * r * r).sqrt();
            let condition = ((p + q + spread) / (p + q - spread).max(f64::MIN_POSITIVE)).sqrt();
            if value.im <= SPLIT * inner.norm_l2() && condition <= ROTATION_CONDITION {
                // Round-off has split a double real eigenvalue with two eigenvectors.
                real.extend(orthonormal(parts).map(|vector| (value.re, vector)));
            } else if value.im > COMPLEX * inner.norm_l2() && condition <= ROTATION_CONDITION {
                let generator = [[value.re, value.im], [-value.im, value.re]];
                blocks.push(lift(a, &rest, &free, &zero, parts, generator, true));
            } else {
                let plane = plane(
                    &inner,
                    parts,
                    condition,
                    2.0 * value.re,
                    value.re.powi(2) + value.im.powi(2),
                )?;
                let generator = project(&inner, &plane);
                blocks.push(lift(a, &rest, &free, &zero, plane, generator, false));
            }
        }
    }
    // A zero eigenvalue of a rigid displacement shares a block with the slow decay of its speed,
    // whose eigenvector is nearly parallel to the displacement when the drag is light.
    let feed =
        |y: &[f64], j: usize| -> f64 { rest.iter().zip(y).map(|(k, v)| a[(j, *k)] * v).sum() };
    let feeds = |y: &[f64]| zero.iter().map(|j| feed(y, *j)).collect::<Vec<f64>>();
    let slowness = |x: &(f64, Vec<f64>)| norm(&feeds(&x.1)) / x.0.abs();
    real.sort_by(|x, y| slowness(y).total_cmp(&slowness(x)));
    let mut taken: Vec<Vec<f64>> = Vec::new();
    let mut partners: Vec<(Vec<f64>, f64, Vec<f64>)> = Vec::new();
    let mut left: Vec<(f64, Vec<f64>)> = Vec::new();
    for (value, y) in real {
        let u = feeds(&y);
        let remainder = outside(&u, &taken);
        if taken.len() < zero.len() && norm(&remainder) >= 0.1 * norm(&u) && norm(&u) > 0.0 {
            taken.push(unit_length(&remainder));
            partners.push((unit_length(&u), value, y));
        } else {
            left.push((value, y));
        }
    }
    // Displacements without a partner complete the basis; an odd one takes any real eigenvalue.
    let mut spare: Vec<Vec<f64>> = Vec::new();
    while taken.len() < zero.len() {
        let axes = (0..zero.len()).map(|k| {
            outside(
                &(0..zero.len())
                    .map(|i| f64::from(u8::from(i == k)))
                    .collect::<Vec<_>>(),
                &taken,
            )
        });
        let next = unit_length(&axes.max_by(|x, y| norm(x).total_cmp(&norm(y)))?);
        taken.push(next.clone());
        spare.push(next);
    }
    let spread = |r: &[f64]| {
        let mut column = vec![0.0; size];
        zero.iter().zip(r).for_each(|(j, v)| column[*j] = *v);
        column
    };
    if spare.len() % 2 == 1 {
        let (value, y) = left.pop()?;
        partners.push((spare.pop()?, value, y));
    }
    for pair in spare.chunks_exact(2) {
        blocks.push(Block {
            columns: [spread(&pair[0]), spread(&pair[1])],
            generator: [[0.0; 2]; 2],
            rotation: false,
        });
    }
    for (r, value, y) in partners {
        let u = feeds(&y);
        let beta = dot(&r, &u);
        // The second column stays off `r`, so no division by a small decay rate takes place.
        let mut second = lift(
            a,
            &rest,
            &free,
            &[],
            [y.clone(), y],
            [[value, 0.0], [0.0, value]],
            true,
        )
        .columns[1]
            .clone();
        for (k, j) in zero.iter().enumerate() {
            let x = u[k] - beta * r[k];
            second[*j] = if x.abs() > ROUND_OFF * norm(&u) { x / value } else { 0.0 };
        }
        let length = norm(&second);
        second.iter_mut().for_each(|v| *v /= length);
        let generator = [[0.0, beta / length], [0.0, value]];
        blocks.push(Block {
            columns: [spread(&r), second],
            generator,
            rotation: false,
        });
    }
    // Nearly parallel real eigenvectors share a block; the others are paired by their eigenvalues.
    let mut pairs: Vec<[(f64, Vec<f64>); 2]> = Vec::new();
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
    for [(l1, y1), (l2, y2)] in pairs {
        let sine = (1.0 - dot(&y1, &y2).abs()).max(f64::MIN_POSITIVE);
        let plane = plane(&inner, [y1, y2], (2.0 / sine).sqrt(), l1 + l2, l1 * l2)?;
        let generator = project(&inner, &plane);
        blocks.push(lift(a, &rest, &free, &zero, plane, generator, false));
    }
    (blocks.len() == m).then_some(blocks)
}

/// Inverse iteration for an eigenvector that back substitution left inaccurate, which happens among
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
    if residual(vector) <= POOR * size * vector.norm_l2() {
        return;
    }
    // The shift lies off the eigenvalue, so that its own eigenvectors keep their proportions.
    let lu = shifted(value + c64::new(OFFSET * size, 0.0)).partial_piv_lu();
    for _ in 0..3 {
        let next = lu.solve(&*vector);
        *vector = &next * Scale(c64::from(1.0 / next.norm_l2()));
    }
}

/// Completes two columns `Y` of the inner matrix by the coordinates whose columns are known.
///
/// With `J` the known columns and `C` the rows of the matrix there, `X B - J X = C Y`.
pub(super) fn lift(
    a: &Mat<f64>,
    rest: &[usize],
    free: &[usize],
    zero: &[usize],
    y: [Vec<f64>; 2],
    b: [[f64; 2]; 2],
    rotation: bool,
) -> Block {
    let m = a.nrows() / 2;
    let det = b[0][0] * b[1][1] - b[0][1] * b[1][0];
    let solve = |u: [f64; 2]| {
        [
            (u[0] * b[1][1] - u[1] * b[1][0]) / det,
            (u[1] * b[0][0] - u[0] * b[0][1]) / det,
        ]
    };
    let feed = |j: usize| {
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
        set(*j, solve(feed(*j)));
    }
    for i in free {
        let speed = solve(feed(m + i));
        set(m + i, speed);
        set(*i, solve(speed.map(|v| a[(*i, m + i)] * v)));
    }
    let generator = if rotation || rest.len() == 2 * m {
        b
    } else {
        // The longer columns are made orthonormal again, and the block follows them.
        full = orthonormal(full);
        project(a, &full)
    };
    Block {
        columns: full,
        generator,
        rotation,
    }
}

/// Orthonormal basis of the invariant plane near two vectors with the given condition number, where
/// the trace and determinant on the plane are known.
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
    // The plane is the null space of `A² - trace A + det`, whatever the Jordan form on it.
    let n = a.nrows();
    let mut quadratic = a * a - a * Scale(trace);
    (0..n).for_each(|i| quadratic[(i, i)] += det);
    let svd = quadratic.thin_svd().ok()?;
    Some([n - 1, n - 2].map(|c| (0..n).map(|i| svd.V()[(i, c)]).collect()))
}

pub(super) fn orthonormal([first, second]: [Vec<f64>; 2]) -> [Vec<f64>; 2] {
    let first = unit_length(&first);
    let second = unit_length(&outside(
        &unit_length(&second),
        std::slice::from_ref(&first),
    ));
    [first, second]
}

/// What is left of a vector outside the span of orthonormal ones, by two passes of Gram and Schmidt.
pub(super) fn outside(vector: &[f64], basis: &[Vec<f64>]) -> Vec<f64> {
    let mut left = vector.to_vec();
    for b in basis.iter().chain(basis) {
        let along = dot(b, &left);
        left.iter_mut().zip(b).for_each(|(v, w)| *v -= along * w);
    }
    left
}

/// The 2x2 block `Vᵀ A V` on an orthonormal basis `V` of an invariant plane.
pub(super) fn project(a: &Mat<f64>, basis: &[Vec<f64>; 2]) -> [[f64; 2]; 2] {
    let row = |i: usize, x: &[f64]| (0..x.len()).map(|k| a[(i, k)] * x[k]).sum::<f64>();
    let image = basis
        .each_ref()
        .map(|x| (0..x.len()).map(|i| row(i, x)).collect::<Vec<f64>>());
    [0, 1].map(|i: usize| [0, 1].map(|j: usize| dot(&basis[i], &image[j])))
}
