//! Eigenvalues of a real matrix, by the algorithms `orthes` and `hqr` of EISPACK (Smith et al.,
//! *Matrix Eigensystem Routines*, 1976) with the shifts of `dlahqr` of LAPACK.

use super::dot;
use faer::MatRef;
use multiversion::multiversion;
use num_complex::{Complex64, c64};
use std::ops::Range;

/// Largest number of steps for one eigenvalue. With several nearly equal and nearly double eigenvalues, many
/// shifts fail before one succeeds. Many such matrices need more than the 300 steps that LAPACK allows. Each further
/// 180 steps leave a third of them unsolved.
const MOST_STEPS: usize = 3000;

/// Number of steps for one eigenvalue between exceptional shifts. These prevent an endless repetition of
/// steps.
const EXCEPTIONAL: usize = 10;

/// Eigenvalues of a real matrix, in no particular order. `None` if the iteration fails or an
/// entry is not finite.
pub fn eigenvalues(matrix: MatRef<'_, f64>) -> Option<Vec<Complex64>> {
    let n = matrix.nrows();
    let mut h: Vec<f64> = (0..n)
        .flat_map(|j| (0..n).map(move |i| matrix[(i, j)]))
        .collect();
    if !h.iter().all(|x| x.is_finite()) {
        return None;
    }
    hessenberg(&mut h, n);
    shifted_steps(&mut h, n)
}

/// Householder's reduction to Hessenberg form (`orthes`).
#[multiversion(targets("x86_64+avx2", "x86_64+avx512f+avx512dq+avx2"))]
fn hessenberg(h: &mut [f64], n: usize) {
    let (mut u, mut row) = (vec![0.0; n], vec![0.0; n]);
    for m in 1..n.saturating_sub(1) {
        let below = &h[(m - 1) * n + m..m * n];
        let scale: f64 = below.iter().map(|x| x.abs()).sum();
        if scale == 0.0 {
            continue;
        }
        let u = &mut u[..n - m];
        for (u, x) in u.iter_mut().zip(below) {
            *u = x / scale;
        }
        let mut size = dot(u, u);
        let g = if u[0] > 0.0 { -size.sqrt() } else { size.sqrt() };
        size -= u[0] * g;
        u[0] -= g;
        for column in h.chunks_exact_mut(n).skip(m) {
            let column = &mut column[m..];
            let f = dot(u, column) / size;
            for (x, u) in column.iter_mut().zip(&*u) {
                *x -= f * u;
            }
        }
        row.fill(0.0);
        for (column, u) in h.chunks_exact(n).skip(m).zip(&*u) {
            for (sum, x) in row.iter_mut().zip(column) {
                *sum += x * u;
            }
        }
        for sum in &mut row {
            *sum /= size;
        }
        for (column, u) in h.chunks_exact_mut(n).skip(m).zip(&*u) {
            for (x, f) in column.iter_mut().zip(&row) {
                *x -= f * u;
            }
        }
        let column = &mut h[(m - 1) * n + m..m * n];
        column[0] = scale * g;
        column[1..].fill(0.0);
    }
}

/// A Householder reflection of three neighbouring rows or columns, or of two (`c` and `r` zero).
#[derive(Clone, Copy)]
struct Reflection {
    q: f64,
    r: f64,
    a: f64,
    b: f64,
    c: f64,
}

impl Reflection {
    /// Applies it to rows k … k + 2 of columns, and to columns k … k + 2 of rows.
    #[inline(always)]
    fn of_three(
        self,
        h: &mut [f64],
        n: usize,
        k: usize,
        columns: Range<usize>,
        rows: Range<usize>,
    ) {
        let Self { q, r, a, b, c } = self;
        for column in h[columns.start * n..columns.end * n].chunks_exact_mut(n) {
            let x: &mut [f64] = &mut column[k..k + 3];
            let f = x[0] + q * x[1] + r * x[2];
            x[0] -= f * a;
            x[1] -= f * b;
            x[2] -= f * c;
        }
        let (first, rest) = h[k * n..(k + 3) * n].split_at_mut(n);
        let (second, third) = rest.split_at_mut(n);
        let (first, second, third) = (
            &mut first[rows.clone()],
            &mut second[rows.clone()],
            &mut third[rows],
        );
        for ((x, y), z) in first.iter_mut().zip(second).zip(third) {
            let f = a * *x + b * *y + c * *z;
            *x -= f;
            *y -= f * q;
            *z -= f * r;
        }
    }

    /// Applies it to rows k and k + 1, and to columns.
    fn of_two(self, h: &mut [f64], n: usize, k: usize, columns: Range<usize>, rows: Range<usize>) {
        let Self { q, a, b, .. } = self;
        for column in h[columns.start * n..columns.end * n].chunks_exact_mut(n) {
            let x: &mut [f64] = &mut column[k..k + 2];
            let f = x[0] + q * x[1];
            x[0] -= f * a;
            x[1] -= f * b;
        }
        let (first, second) = h[k * n..(k + 2) * n].split_at_mut(n);
        for (x, y) in first[rows.clone()].iter_mut().zip(&mut second[rows]) {
            let f = a * *x + b * *y;
            *x -= f;
            *y -= f * q;
        }
    }
}

/// Eigenvalues of a 2 × 2 matrix with the diagonal entries y and x, x the last one, and the product w of the
/// off-diagonal entries. Of two real eigenvalues, the one nearer to x is last.
fn of_two(x: f64, y: f64, w: f64) -> [Complex64; 2] {
    let p = 0.5 * (y - x);
    let q = p * p + w;
    let z = q.abs().sqrt();
    if q < 0.0 {
        return [c64(x + p, z), c64(x + p, -z)];
    }
    let z = if p >= 0.0 { p + z } else { p - z };
    let nearer = if z == 0.0 { x } else { x - w / z };
    [(x + z).into(), nearer.into()]
}

/// Eigenvalues of a Hessenberg matrix by Francis' double QR steps (`hqr`).
#[multiversion(targets("x86_64+avx2", "x86_64+avx512f+avx512dq+avx2"))]
fn shifted_steps(h: &mut [f64], size: usize) -> Option<Vec<Complex64>> {
    let at = |i: usize, j: usize| j * size + i;
    let mut values = vec![Complex64::ZERO; size];
    let mut norm = 0.0;
    for i in 0..size {
        for j in i.saturating_sub(1)..size {
            norm += h[at(i, j)].abs();
        }
    }
    // The eigenvalues with indices below `end` are not yet known.
    let (mut end, mut steps) = (size, 0);
    while end > 0 {
        let n = end - 1;
        let mut l = n;
        while l > 0 {
            let near = h[at(l - 1, l - 1)].abs() + h[at(l, l)].abs();
            let near = if near == 0.0 { norm } else { near };
            if h[at(l, l - 1)].abs() <= f64::EPSILON * near {
                break;
            }
            l -= 1;
        }
        if l == n {
            values[n] = h[at(n, n)].into();
            end -= 1;
            steps = 0;
            continue;
        }
        let (mut x, mut y) = (h[at(n, n)], h[at(n - 1, n - 1)]);
        let mut w = h[at(n, n - 1)] * h[at(n - 1, n)];
        let pair = of_two(x, y, w);
        if l + 1 == n {
            [values[n - 1], values[n]] = pair;
            end -= 2;
            steps = 0;
            continue;
        }
        steps += 1;
        if steps > MOST_STEPS {
            return None;
        }
        // The shifts are the roots of (x - s) (y - s) = w.
        if steps % EXCEPTIONAL == 0 {
            // Use the lower and the upper end of the active block alternately.
            let (at_end, next_to_end) = match steps % (2 * EXCEPTIONAL) {
                0 => (x, [at(n, n - 1), at(n - 1, n - 2)]),
                _ => (h[at(l, l)], [at(l + 1, l), at(l + 2, l + 1)]),
            };
            let s: f64 = next_to_end.map(|place| h[place].abs()).iter().sum();
            x = at_end + 0.75 * s;
            (y, w) = (x, -0.4375 * s * s);
        } else if pair[1].im == 0.0 {
            // If both shifts are real, use the one nearer to the last diagonal entry twice: two different shifts
            // would prevent nearly double eigenvalues from separating.
            let nearer = pair[1].re;
            (x, y, w) = (nearer, nearer, 0.0);
        }
        let mut m = n - 2;
        let (mut p, mut q, mut r);
        loop {
            let z = h[at(m, m)];
            let (a, b) = (x - z, y - z);
            p = (a * b - w) / h[at(m + 1, m)] + h[at(m, m + 1)];
            q = h[at(m + 1, m + 1)] - z - a - b;
            r = h[at(m + 2, m + 1)];
            let s = p.abs() + q.abs() + r.abs();
            (p, q, r) = (p / s, q / s, r / s);
            if m == l {
                break;
            }
            let about = h[at(m - 1, m - 1)].abs() + z.abs() + h[at(m + 1, m + 1)].abs();
            let left = h[at(m, m - 1)].abs() * (q.abs() + r.abs());
            if left < f64::EPSILON * p.abs() * about {
                break;
            }
            m -= 1;
        }
        for i in m + 2..=n {
            h[at(i, i - 2)] = 0.0;
            if i > m + 2 {
                h[at(i, i - 3)] = 0.0;
            }
        }
        for k in m..n {
            let last = k + 1 == n;
            if k > m {
                p = h[at(k, k - 1)];
                q = h[at(k + 1, k - 1)];
                r = if last { 0.0 } else { h[at(k + 2, k - 1)] };
                x = p.abs() + q.abs() + r.abs();
                if x == 0.0 {
                    continue;
                }
                (p, q, r) = (p / x, q / x, r / x);
            }
            let s = (p * p + q * q + r * r).sqrt();
            let s = if p < 0.0 { -s } else { s };
            if s == 0.0 {
                continue;
            }
            if k > m {
                h[at(k, k - 1)] = -s * x;
            } else if l != m {
                h[at(k, k - 1)] = -h[at(k, k - 1)];
            }
            p += s;
            let (a, b, c) = (p / s, q / s, r / s);
            (q, r) = (q / p, r / p);
            let reflection = Reflection { q, r, a, b, c };
            let (columns, rows) = (k..n + 1, l..n.min(k + 3) + 1);
            if last {
                reflection.of_two(h, size, k, columns, rows)
            } else {
                reflection.of_three(h, size, k, columns, rows)
            }
        }
    }
    Some(values)
}
