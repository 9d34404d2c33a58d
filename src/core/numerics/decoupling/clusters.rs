//! Eigenvectors of coinciding eigenvalues, which a structure with equal planets has.
//!
//! Round-off determines the vectors that back substitution gives. They may be nearly parallel although the
//! eigenvalue has enough independent eigenvectors. Inverse iteration of a whole subspace finds orthonormal
//! ones.

use super::parts::{CLUSTER_DISTANCE, CLUSTER_SHIFT, SCALAR_DEVIATION};
use faer::{Mat, prelude::*};

/// Replaces eigenvectors, the columns of `vectors`, by independent ones where several eigenvalues coincide whose
/// imaginary parts exceed `smallest`.
pub(super) fn separate(a: &Mat<f64>, values: &[c64], vectors: &mut Mat<c64>, smallest: f64) {
    let size = a.norm_l2();
    let mut remaining: Vec<usize> = (0..values.len())
        .filter(|k| values[*k].im > smallest)
        .collect();
    while let Some(first) = remaining.first().copied() {
        let in_cluster = |k: &usize| (values[*k] - values[first]).norm() <= CLUSTER_DISTANCE * size;
        let (cluster, others): (Vec<usize>, Vec<usize>) =
            remaining.into_iter().partition(in_cluster);
        remaining = others;
        if cluster.len() > 1 {
            let sum: c64 = cluster.iter().map(|k| values[*k]).sum();
            let separated = eigenvectors(a, sum / cluster.len() as f64, cluster.len(), size);
            for (column, k) in cluster.into_iter().enumerate() {
                for i in 0..a.nrows() {
                    vectors[(i, k)] = separated[(i, column)];
                }
            }
        }
    }
}

/// `count` eigenvectors of coinciding eigenvalues near `value`. If the matrix is a multiple of the identity
/// on their space, they are an arbitrary orthonormal basis of it.
fn eigenvectors(a: &Mat<f64>, value: c64, count: usize, size: f64) -> Mat<c64> {
    let n = a.nrows();
    let complex = Mat::from_fn(n, n, |i, j| c64::from(a[(i, j)]));
    let nearby = Scale(value + c64::new(CLUSTER_SHIFT * size, 0.0));
    let shifted = &complex - Mat::<c64>::identity(n, n) * nearby;
    let lu = shifted.partial_piv_lu();
    let turn = |i: usize, j: usize| c64::cis(((i + 1) * (j + 2)) as f64);
    let mut basis = Mat::from_fn(n, count, turn);
    for _ in 0..4 {
        basis = lu.solve(&basis).qr().compute_thin_Q();
    }
    let restriction = basis.adjoint() * &complex * &basis;
    let deviation = &restriction - Mat::<c64>::identity(count, count) * Scale(value);
    if deviation.norm_l2() <= SCALAR_DEVIATION * size {
        return basis;
    }
    match restriction.eigen() {
        Ok(eigen) => basis * eigen.U(),
        Err(_) => basis,
    }
}
