//! Eigenvalues of a real matrix, by the algorithms `orthes` and `hqr` of EISPACK (Smith et al.,
//! *Matrix Eigensystem Routines*, 1976).

use super::MOST_STEPS;
use faer::{Mat, MatRef};
use num_complex::{Complex64, c64};

/// Eigenvalues of a real matrix, in no order; none where the iteration fails or an
/// entry is not finite.
pub fn eigenvalues(matrix: MatRef<'_, f64>) -> Option<Vec<Complex64>> {
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
fn shifted_steps(mut h: Mat<f64>) -> Option<Vec<Complex64>> {
    let size = h.nrows();
    let mut values = vec![Complex64::ZERO; size];
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
            values[n] = (h[(n, n)] + moved).into();
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
                values[n - 1] = (at + z).into();
                values[n] = if z == 0.0 { at + z } else { at - w / z }.into();
            } else {
                values[n - 1] = c64(at + p, z);
                values[n] = c64(at + p, -z);
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
