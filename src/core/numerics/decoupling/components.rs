//! Which modes are coupled to each other, and which rigid motions are uncoupled?

use super::parts::{DecouplingError, Direction, SVD_ROUND_OFF};
use faer::Mat;

/// Sets off-diagonal entries up to `floor` to zero. Returns the sets of modes that the remaining entries connect.
pub(super) fn components(coupling: &mut [Mat<f64>; 2], floor: [f64; 2]) -> Vec<Vec<usize>> {
    let n = coupling[0].nrows();
    let mut label: Vec<usize> = (0..n).collect();
    for i in 0..n {
        for j in (0..n).filter(|j| *j != i) {
            for k in 0..2 {
                if coupling[k][(i, j)].abs() <= floor[k] {
                    coupling[k][(i, j)] = 0.0;
                } else if label[i] != label[j] {
                    let (keep, drop) = (label[i].min(label[j]), label[i].max(label[j]));
                    label
                        .iter_mut()
                        .filter(|l| **l == drop)
                        .for_each(|l| *l = keep);
                }
            }
        }
    }
    let members = |l| (0..n).filter(|i| label[*i] == l).collect::<Vec<_>>();
    (0..n)
        .map(members)
        .filter(|part| !part.is_empty())
        .collect()
}

/// Rotates the rigid modes of a component such that directions without coupling are separate coordinates.
///
/// It first separates directions whose rows and columns are zero in both matrices (damping and stiffness), then
/// those whose columns are zero in both, then those whose columns are zero in the stiffness.
pub(super) fn isolate_rigid(
    part: &[usize],
    mut rigid: Vec<usize>,
    floor: [f64; 2],
    coupling: &mut [Mat<f64>; 2],
    rotation: &mut Mat<f64>,
    kind: &mut [Direction],
) -> Result<(), DecouplingError> {
    let stages: [(&[(usize, bool)], Direction); 3] = [
        (
            &[(0, false), (1, false), (0, true), (1, true)],
            Direction::Free,
        ),
        (&[(0, false), (1, false)], Direction::Free),
        (&[(1, false)], Direction::Unsprung),
    ];
    for (sides, found) in stages {
        // Each matrix is in units of its round-off, so that singular values up to 1 are round-off.
        let unit = floor.map(|f| if f > 0.0 { f } else { 1.0 });
        let entry = |c: &[Mat<f64>; 2], row: usize, j: usize| {
            let ((k, by_row), i) = (sides[row / part.len()], part[row % part.len()]);
            (if by_row { c[k][(j, i)] } else { c[k][(i, j)] }) / unit[k]
        };
        let height = sides.len() * part.len();
        // A coordinate that is already separate is not rotated.
        let (mut isolated, rest): (Vec<usize>, Vec<usize>) = rigid
            .iter()
            .partition(|j| (0..height).all(|row| entry(coupling, row, **j).abs() <= 1.0));
        if !rest.is_empty() {
            let stack = Mat::from_fn(height, rest.len(), |row, c| entry(coupling, row, rest[c]));
            let failed = |_| DecouplingError::NoConvergence(named(part));
            let svd = stack.thin_svd().map_err(failed)?;
            let values = svd.S().column_vector();
            // The decomposition loses some units in the last place of its largest value.
            let round_off = (SVD_ROUND_OFF * values[0]).max(1.0);
            let small = (0..rest.len()).filter(|k| values[*k] <= round_off).count();
            if small > 0 {
                let last = rest.len() - 1;
                let q = Mat::from_fn(rest.len(), rest.len(), |i, k| svd.V()[(i, last - k)]);
                for k in 0..2 {
                    turn_columns(&mut coupling[k], &rest, &q);
                    let mut turned = coupling[k].transpose().to_owned();
                    turn_columns(&mut turned, &rest, &q);
                    coupling[k] = turned.transpose().to_owned();
                }
                turn_columns(rotation, &rest, &q);
                isolated.extend(&rest[..small]);
            }
        }
        for j in &isolated {
            kind[*j] = found;
            for (k, by_row) in sides {
                for i in 0..kind.len() {
                    coupling[*k][if *by_row { (*j, i) } else { (i, *j) }] = 0.0;
                }
            }
        }
        rigid.retain(|j| !isolated.contains(j));
    }
    Ok(())
}

pub(super) fn turn_columns(matrix: &mut Mat<f64>, places: &[usize], q: &Mat<f64>) {
    for i in 0..matrix.nrows() {
        let old: Vec<f64> = places.iter().map(|p| matrix[(i, *p)]).collect();
        for (c, p) in places.iter().enumerate() {
            matrix[(i, *p)] = old.iter().enumerate().map(|(k, v)| v * q[(k, c)]).sum();
        }
    }
}

pub(super) fn named(part: &[usize]) -> Vec<usize> {
    part.iter().map(|i| i + 1).collect()
}
