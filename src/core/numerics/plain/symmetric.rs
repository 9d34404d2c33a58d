//! Eigenvalues and eigenvectors of a symmetric matrix, by the algorithms `tred2` and `tql2` of
//! EISPACK (Smith et al., *Matrix Eigensystem Routines*, 1976).

use faer::Mat;

/// Largest number of steps for one eigenvalue.
const MOST_STEPS: usize = 60;

/// Eigenvalues, ascending, and orthonormal eigenvectors of a symmetric matrix. `None` if the
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

/// Householder's reduction to a tridiagonal matrix (`tred2`). Returns its diagonal and its subdiagonal. `v`
/// becomes the transformation.
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

/// Implicit QL steps on a tridiagonal matrix (`tql2`): `d` becomes the eigenvalues, `v` their eigenvectors.
/// `None` if the iteration fails.
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
        // The last subdiagonal entry is zero.
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
