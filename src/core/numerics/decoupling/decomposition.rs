//! How is one component of coupled modes decomposed into blocks?

use super::components::named;
use super::improvement::{columns, compensated, improve, standardise};
use super::parts::{ACCURACY, Block, CONDITION_BOUND, DecouplingError, Direction};
use super::planes::plane_bases;
use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, Side};

/// Frequencies \[rad/s\] by which displacements are multiplied, one per mode of the component.
///
/// With the natural frequencies, the squared length of the scaled state is twice the energy. A conservative
/// structure, gyroscopic or not, then has orthogonal eigenvectors. A rigid mode has the rate of its drag as
/// its scale. Cross stiffness raises the scale of a mode that it stiffens.
pub(super) fn scales(part: &[usize], frequency: &[f64], coupling: &[Mat<f64>; 2]) -> Vec<f64> {
    let frequency_of = |i: usize| frequency[i].max(coupling[1][(i, i)].abs().sqrt());
    let largest = |i: usize, only_rigid: bool| {
        let others = part.iter().filter(|j| !only_rigid || frequency[**j] == 0.0);
        others
            .map(|j| coupling[0][(i, *j)].abs().max(coupling[0][(*j, i)].abs()))
            .fold(0.0, f64::max)
    };
    let scale = |i: usize| {
        let cross = part.iter().filter(|j| **j != i).map(|j| {
            let s = coupling[1][(i, *j)].abs().max(coupling[1][(*j, i)].abs());
            if frequency_of(*j) > 0.0 {
                s.sqrt().min(s / frequency_of(*j))
            } else {
                s.sqrt()
            }
        });
        let scale = cross.fold(frequency_of(i), f64::max);
        if frequency[i] > 0.0 {
            return scale;
        }
        let drag = largest(i, true);
        scale.max(if drag > 0.0 { drag } else { largest(i, false) })
    };
    // The scale of a rigid mode without any restraint is arbitrary.
    part.iter()
        .map(|i| Some(scale(*i)).filter(|s| *s > 0.0).unwrap_or(1.0))
        .collect()
}

pub(super) type Decomposition = (Vec<Block>, Mat<f64>, (f64, f64));

/// The blocks of one component in the scaled state, the inverse of the matrix of their columns (two rows per
/// block), and the largest and the smallest singular value of this matrix.
pub(super) fn decompose(
    part: &[usize],
    frequency: &[f64],
    coupling: &[Mat<f64>; 2],
    kind: &[Direction],
    scale: &[f64],
) -> Result<Decomposition, DecouplingError> {
    let m = part.len();
    let a = Mat::from_fn(2 * m, 2 * m, |row, column| match (row < m, column < m) {
        (true, true) => 0.0,
        (true, false) => {
            if column == m + row {
                scale[row]
            } else {
                0.0
            }
        }
        (false, false) => 0.0 - coupling[0][(part[row - m], part[column - m])],
        (false, true) => {
            let (i, j) = (row - m, column);
            let elastic =
                if i == j { frequency[part[i]] * (frequency[part[i]] / scale[i]) } else { 0.0 };
            0.0 - (elastic + coupling[1][(part[i], part[j])] / scale[j])
        }
    });
    let failed = || DecouplingError::NoConvergence(named(part));
    let mut blocks =
        plane_bases(&a, &part.iter().map(|i| kind[*i]).collect::<Vec<_>>()).ok_or_else(failed)?;
    let residual = improve(&a, &mut blocks);
    for block in &mut blocks {
        standardise(block);
    }
    let key = |b: &Block| {
        (b.generator[0][0] * b.generator[1][1] - b.generator[0][1] * b.generator[1][0]).abs()
    };
    blocks.sort_by(|x, y| key(x).total_cmp(&key(y)));
    let t = columns(&blocks);
    if !t.norm_max().is_finite() {
        return Err(DecouplingError::NearlyDefective {
            modes: named(part),
            condition: f64::INFINITY,
        });
    }
    // Singular values are the square roots of the eigenvalues of TᵀT. They are accurate to a thousandth at
    // the largest accepted ratio. A singular value decomposition of T does not always converge with equal
    // planets.
    let square = t.transpose() * &t;
    let eigen = square
        .self_adjoint_eigen(Side::Lower)
        .map_err(|_| failed())?;
    let singular = |k: usize| eigen.S().column_vector()[k].max(0.0).sqrt();
    let (largest, smallest) = (singular(2 * m - 1), singular(0));
    // This form of the condition also rejects a NaN.
    let sound = smallest * CONDITION_BOUND > largest;
    if !sound {
        // The first eigenvector gives the linear combination of columns that is nearly zero.
        let weight = |i: usize| -> f64 {
            let share =
                |c: usize| eigen.U()[(c, 0)].powi(2) * (t[(i, c)].powi(2) + t[(m + i, c)].powi(2));
            (0..2 * m).map(share).sum()
        };
        let mut order: Vec<(f64, usize)> = (0..m).map(|i| (weight(i), part[i] + 1)).collect();
        order.sort_by(|x, y| y.0.total_cmp(&x.0));
        let modes = order
            .iter()
            .filter(|o| o.0 >= 0.05 * order[0].0)
            .map(|o| o.1)
            .collect();
        return Err(DecouplingError::NearlyDefective {
            modes,
            condition: largest / smallest,
        });
    }
    if residual > ACCURACY * a.norm_l2() {
        return Err(failed());
    }
    let mut inverse = t.partial_piv_lu().inverse();
    // One step of Newton's method with a compensated residual recovers the last digits.
    let rows: Vec<Vec<f64>> = (0..2 * m)
        .map(|k| (0..2 * m).map(|j| t[(k, j)]).collect())
        .collect();
    let defect = compensated(2 * m, |i, sums| {
        for (k, row) in rows.iter().enumerate() {
            sums.add_multiple(-inverse[(i, k)], row);
        }
        let mut own = vec![0.0; 2 * m];
        own[i] = 1.0;
        sums.add_multiple(1.0, &own);
    });
    inverse = &inverse + &defect * &inverse;
    Ok((blocks, inverse, (largest, smallest)))
}
