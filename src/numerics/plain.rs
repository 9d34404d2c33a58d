//! Dense algebra in plain loops, whose sums have one order on every processor: what
//! [`super::linalg`] takes where a process keeps to portable instructions. The library that it
//! takes otherwise chooses vectors, fused multiply-adds and block sizes by the processor.
//!
//! The eigenvalue algorithms are those of EISPACK (Smith et al. 1976) as Bowdler, Martin, Peters,
//! Reinsch and Wilkinson gave them in the Handbook for Automatic Computation: `tred2` and `tql2`,
//! `orthes` and `hqr`.

use faer::{Mat, MatRef};

/// Steps of an iteration for one eigenvalue before it is given up.
const MOST_STEPS: usize = 60;

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

/// A matrix as `P A = L U`, rows swapped so that every pivot is the largest of its column.
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

/// The lower triangle of `A = L Lᵀ`; none where A is not positive definite.
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
                // Written so that NaN fails.
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

/// Eigenvalues, ascending, and orthonormal eigenvectors of a symmetric matrix; none where the
/// iteration fails.
pub fn symmetric_eigen(matrix: &Mat<f64>) -> Option<(Vec<f64>, Mat<f64>)> {
    let n = matrix.nrows();
    let mut v = Mat::from_fn(n, n, |i, j| matrix[(i.max(j), i.min(j))]);
    let (mut d, mut e) = tridiagonal(&mut v);
    diagonal(&mut v, &mut d, &mut e)?;
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| d[a].total_cmp(&d[b]).then(a.cmp(&b)));
    let values = order.iter().map(|&i| d[i]).collect();
    Some((values, Mat::from_fn(n, n, |i, j| v[(i, order[j])])))
}

/// Householder's reduction to a tridiagonal matrix, its diagonal and subdiagonal; `v` becomes
/// the transformation. (`tred2`)
fn tridiagonal(v: &mut Mat<f64>) -> (Vec<f64>, Vec<f64>) {
    let n = v.nrows();
    let (mut d, mut e) = (vec![0.0; n], vec![0.0; n]);
    if n == 0 {
        return (d, e);
    }
    for j in 0..n {
        d[j] = v[(n - 1, j)];
    }
    for i in (1..n).rev() {
        let scale: f64 = d[..i].iter().map(|x| x.abs()).sum();
        let mut h = 0.0;
        if scale == 0.0 {
            e[i] = d[i - 1];
            for j in 0..i {
                d[j] = v[(i - 1, j)];
                v[(i, j)] = 0.0;
                v[(j, i)] = 0.0;
            }
        } else {
            for x in &mut d[..i] {
                *x /= scale;
                h += *x * *x;
            }
            let f = d[i - 1];
            let g = if f > 0.0 { -h.sqrt() } else { h.sqrt() };
            e[i] = scale * g;
            h -= f * g;
            d[i - 1] = f - g;
            e[..i].fill(0.0);
            for j in 0..i {
                let f = d[j];
                v[(j, i)] = f;
                let mut g = e[j] + v[(j, j)] * f;
                for k in j + 1..i {
                    g += v[(k, j)] * d[k];
                    e[k] += v[(k, j)] * f;
                }
                e[j] = g;
            }
            let mut f = 0.0;
            for j in 0..i {
                e[j] /= h;
                f += e[j] * d[j];
            }
            let hh = f / (h + h);
            for j in 0..i {
                e[j] -= hh * d[j];
            }
            for j in 0..i {
                let (f, g) = (d[j], e[j]);
                for k in j..i {
                    v[(k, j)] -= f * e[k] + g * d[k];
                }
                d[j] = v[(i - 1, j)];
                v[(i, j)] = 0.0;
            }
        }
        d[i] = h;
    }
    for i in 0..n - 1 {
        v[(n - 1, i)] = v[(i, i)];
        v[(i, i)] = 1.0;
        let h = d[i + 1];
        if h != 0.0 {
            for k in 0..=i {
                d[k] = v[(k, i + 1)] / h;
            }
            for j in 0..=i {
                let mut g = 0.0;
                for k in 0..=i {
                    g += v[(k, i + 1)] * v[(k, j)];
                }
                for k in 0..=i {
                    v[(k, j)] -= g * d[k];
                }
            }
        }
        for k in 0..=i {
            v[(k, i + 1)] = 0.0;
        }
    }
    for j in 0..n {
        d[j] = v[(n - 1, j)];
        v[(n - 1, j)] = 0.0;
    }
    v[(n - 1, n - 1)] = 1.0;
    e[0] = 0.0;
    (d, e)
}

/// Implicit QL on a tridiagonal matrix: `d` becomes the eigenvalues, `v` their vectors. (`tql2`)
fn diagonal(v: &mut Mat<f64>, d: &mut [f64], e: &mut [f64]) -> Option<()> {
    let n = d.len();
    for i in 1..n {
        e[i - 1] = e[i];
    }
    if let Some(last) = e.last_mut() {
        *last = 0.0;
    }
    let (mut shift, mut size) = (0.0, 0.0_f64);
    for l in 0..n {
        size = size.max(d[l].abs() + e[l].abs());
        let small = |e: f64| e.abs() <= f64::EPSILON * size;
        // The last one is zero.
        let m = (l..n).find(|&m| small(e[m]))?;
        let mut steps = 0;
        while m > l && !small(e[l]) {
            steps += 1;
            if steps > MOST_STEPS {
                return None;
            }
            let g = d[l];
            let p = (d[l + 1] - g) / (2.0 * e[l]);
            let r = if p < 0.0 { -p.hypot(1.0) } else { p.hypot(1.0) };
            d[l] = e[l] / (p + r);
            d[l + 1] = e[l] * (p + r);
            let next = d[l + 1];
            let h = g - d[l];
            for x in &mut d[l + 2..] {
                *x -= h;
            }
            shift += h;
            let mut p = d[m];
            let (mut c, mut c2, mut c3) = (1.0, 1.0, 1.0);
            let (mut s, mut s2) = (0.0, 0.0);
            let after = e[l + 1];
            for i in (l..m).rev() {
                c3 = c2;
                c2 = c;
                s2 = s;
                let g = c * e[i];
                let h = c * p;
                let r = p.hypot(e[i]);
                e[i + 1] = s * r;
                s = e[i] / r;
                c = p / r;
                p = c * d[i] - s * g;
                d[i + 1] = h + s * (c * g + s * d[i]);
                for k in 0..n {
                    let h = v[(k, i + 1)];
                    v[(k, i + 1)] = s * v[(k, i)] + c * h;
                    v[(k, i)] = c * v[(k, i)] - s * h;
                }
            }
            p = -s * s2 * c3 * after * e[l] / next;
            e[l] = s * p;
            d[l] = c * p;
        }
        d[l] += shift;
        e[l] = 0.0;
    }
    Some(())
}

/// Eigenvalues (re, im) of a real matrix, in no order; none where the iteration fails or an
/// entry is not finite.
pub fn eigenvalues(matrix: MatRef<'_, f64>) -> Option<Vec<(f64, f64)>> {
    let n = matrix.nrows();
    let mut h = matrix.to_owned();
    for j in 0..n {
        for i in 0..n {
            if !h[(i, j)].is_finite() {
                return None;
            }
        }
    }
    hessenberg(&mut h);
    shifted_steps(h)
}

/// Householder's reduction to Hessenberg form. (`orthes`)
fn hessenberg(h: &mut Mat<f64>) {
    let n = h.nrows();
    for m in 1..n.saturating_sub(1) {
        let scale: f64 = (m..n).map(|i| h[(i, m - 1)].abs()).sum();
        if scale == 0.0 {
            continue;
        }
        let mut u = vec![0.0; n];
        let mut size = 0.0;
        for i in (m..n).rev() {
            u[i] = h[(i, m - 1)] / scale;
            size += u[i] * u[i];
        }
        let g = if u[m] > 0.0 {
            -size.sqrt()
        } else {
            size.sqrt()
        };
        size -= u[m] * g;
        u[m] -= g;
        for j in m..n {
            let mut f = 0.0;
            for i in (m..n).rev() {
                f += u[i] * h[(i, j)];
            }
            f /= size;
            for i in m..n {
                h[(i, j)] -= f * u[i];
            }
        }
        for i in 0..n {
            let mut f = 0.0;
            for j in (m..n).rev() {
                f += u[j] * h[(i, j)];
            }
            f /= size;
            for j in m..n {
                h[(i, j)] -= f * u[j];
            }
        }
        h[(m, m - 1)] = scale * g;
        for i in m + 1..n {
            h[(i, m - 1)] = 0.0;
        }
    }
}

/// Francis' double QR steps on a Hessenberg matrix. (`hqr`)
fn shifted_steps(mut h: Mat<f64>) -> Option<Vec<(f64, f64)>> {
    let size = h.nrows();
    let mut values = vec![(0.0, 0.0); size];
    let mut norm = 0.0;
    for i in 0..size {
        for j in i.saturating_sub(1)..size {
            norm += h[(i, j)].abs();
        }
    }
    // Eigenvalues below `end` are still sought; what exceptional shifts took away is in `moved`.
    let (mut end, mut moved, mut steps) = (size, 0.0, 0);
    while end > 0 {
        let n = end - 1;
        let mut l = n;
        while l > 0 {
            let near = h[(l - 1, l - 1)].abs() + h[(l, l)].abs();
            let near = if near == 0.0 { norm } else { near };
            if h[(l, l - 1)].abs() <= f64::EPSILON * near {
                break;
            }
            l -= 1;
        }
        if l == n {
            values[n] = (h[(n, n)] + moved, 0.0);
            end -= 1;
            steps = 0;
            continue;
        }
        let (mut x, mut y) = (h[(n, n)], h[(n - 1, n - 1)]);
        let mut w = h[(n, n - 1)] * h[(n - 1, n)];
        if l + 1 == n {
            let p = 0.5 * (y - x);
            let q = p * p + w;
            let z = q.abs().sqrt();
            let at = x + moved;
            if q >= 0.0 {
                let z = if p >= 0.0 { p + z } else { p - z };
                values[n - 1] = (at + z, 0.0);
                values[n] = (if z == 0.0 { at + z } else { at - w / z }, 0.0);
            } else {
                values[n - 1] = (at + p, z);
                values[n] = (at + p, -z);
            }
            end -= 2;
            steps = 0;
            continue;
        }
        steps += 1;
        if steps > MOST_STEPS {
            return None;
        }
        if steps % 10 == 0 {
            moved += x;
            for i in 0..=n {
                h[(i, i)] -= x;
            }
            let s = h[(n, n - 1)].abs() + h[(n - 1, n - 2)].abs();
            (x, y, w) = (0.75 * s, 0.75 * s, -0.4375 * s * s);
        }
        let mut m = n - 2;
        let (mut p, mut q, mut r);
        loop {
            let z = h[(m, m)];
            let (a, b) = (x - z, y - z);
            p = (a * b - w) / h[(m + 1, m)] + h[(m, m + 1)];
            q = h[(m + 1, m + 1)] - z - a - b;
            r = h[(m + 2, m + 1)];
            let s = p.abs() + q.abs() + r.abs();
            (p, q, r) = (p / s, q / s, r / s);
            if m == l {
                break;
            }
            let about = h[(m - 1, m - 1)].abs() + z.abs() + h[(m + 1, m + 1)].abs();
            let left = h[(m, m - 1)].abs() * (q.abs() + r.abs());
            if left < f64::EPSILON * p.abs() * about {
                break;
            }
            m -= 1;
        }
        for i in m + 2..=n {
            h[(i, i - 2)] = 0.0;
            if i > m + 2 {
                h[(i, i - 3)] = 0.0;
            }
        }
        for k in m..n {
            let last = k + 1 == n;
            if k > m {
                p = h[(k, k - 1)];
                q = h[(k + 1, k - 1)];
                r = if last { 0.0 } else { h[(k + 2, k - 1)] };
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
                h[(k, k - 1)] = -s * x;
            } else if l != m {
                h[(k, k - 1)] = -h[(k, k - 1)];
            }
            p += s;
            let (a, b, c) = (p / s, q / s, r / s);
            (q, r) = (q / p, r / p);
            for j in k..=n {
                let mut f = h[(k, j)] + q * h[(k + 1, j)];
                if !last {
                    f += r * h[(k + 2, j)];
                    h[(k + 2, j)] -= f * c;
                }
                h[(k, j)] -= f * a;
                h[(k + 1, j)] -= f * b;
            }
            for i in l..=n.min(k + 3) {
                let mut f = a * h[(i, k)] + b * h[(i, k + 1)];
                if !last {
                    f += c * h[(i, k + 2)];
                    h[(i, k + 2)] -= f * r;
                }
                h[(i, k)] -= f;
                h[(i, k + 1)] -= f * q;
            }
        }
    }
    Some(values)
}

/// The discrete Fourier transform of real values, a power of two of them: the terms up to half
/// their number, as (re, im).
pub fn transform(values: &[f64]) -> Vec<(f64, f64)> {
    let n = values.len();
    assert!(n.is_power_of_two(), "{n} values");
    let bits = n.trailing_zeros();
    let place = |i: usize| i.reverse_bits().unbounded_shr(usize::BITS - bits);
    let mut z: Vec<(f64, f64)> = (0..n).map(|i| (values[place(i)], 0.0)).collect();
    let mut half = 1;
    while half < n {
        for k in 0..half {
            let (sin, cos) = (-std::f64::consts::PI * k as f64 / half as f64).sin_cos();
            for i in (k..n).step_by(2 * half) {
                let (a, b) = (z[i], z[i + half]);
                let turned = (b.0 * cos - b.1 * sin, b.0 * sin + b.1 * cos);
                z[i] = (a.0 + turned.0, a.1 + turned.1);
                z[i + half] = (a.0 - turned.0, a.1 - turned.1);
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
    use crate::numerics::linalg;
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
            let mut known = linalg::eigenvalues(a.as_ref()).unwrap();
            let found = eigenvalues(a.as_ref()).unwrap();
            assert_eq!(known.len(), found.len());
            for (re, im) in found {
                let far = |v: &(f64, f64)| (v.0 - re).hypot(v.1 - im);
                let nearest = (0..known.len())
                    .min_by(|&a, &b| far(&known[a]).total_cmp(&far(&known[b])))
                    .unwrap();
                assert!(far(&known.swap_remove(nearest)) < 1e-12, "{re} {im}");
            }
        }
        assert!(eigenvalues(Mat::from_fn(2, 2, |_, _| f64::NAN).as_ref()).is_none());
    }

    #[test]
    fn the_transform_is_its_sum() {
        let values: Vec<f64> = (0..16).map(|i| (0.3 * i as f64).sin() + 0.1).collect();
        for (k, (re, im)) in transform(&values).into_iter().enumerate() {
            let mut sum = (0.0, 0.0);
            for (i, value) in values.iter().enumerate() {
                let (sin, cos) = (-std::f64::consts::TAU * (k * i) as f64 / 16.0).sin_cos();
                sum = (sum.0 + value * cos, sum.1 + value * sin);
            }
            assert!((sum.0 - re).hypot(sum.1 - im) < 1e-13, "{k}");
        }
        assert_eq!(transform(&[2.0]), [(2.0, 0.0)]);
    }
}
