//! The matrices of a modal file that couple its modes: each is a list of rows, one row per mode.

use crate::manifest::reader::Section;
use crate::manifest::schema;
use crate::manifest::tree::entries;
use crate::structure::Coupling;
use crate::units::plural;

/// Largest sum of two entries across the diagonal of a skew-symmetric matrix, as a fraction of its largest
/// entry: the error of a file with six digits.
const SKEW_BOUND: f64 = 1e-5;

/// Fraction of the highest frequency. A smaller entry of the damping matrix for a rigid motion is the
/// round-off of a projection and counts as 0. Such damping takes years to have an effect. A load that is
/// round-off, divided by such damping, gives an arbitrarily high speed.
const NO_DAMPING: f64 = 1e-12;

/// The coupling. The outer `None` is a fault. Matrices that are 0 everywhere couple nothing.
pub(super) fn read(root: &Section, frequency: Option<&[f64]>) -> Option<Option<Coupling>> {
    let modes = frequency.map(<[f64]>::len);
    let damping = matrix(root, "damping_matrix", modes)
        .and_then(|matrix| Some(without_round_off(matrix, frequency?)));
    let gyroscopic =
        matrix(root, "gyroscopic_matrix", modes).and_then(|matrix| skew(root, matrix, modes?));
    let stiffness = matrix(root, "stiffness_matrix", modes);
    let coupling = Coupling {
        damping: damping?,
        gyroscopic: gyroscopic?,
        stiffness: stiffness?,
    };
    let all = [&coupling.damping, &coupling.gyroscopic, &coupling.stiffness];
    let is_nonzero = all.into_iter().flatten().any(|&entry| entry != 0.0);
    Some(is_nonzero.then_some(coupling))
}

/// A square matrix with one row per mode, row by row; zeros if it is absent.
fn matrix(root: &Section, name: &str, modes: Option<usize>) -> Option<Vec<f64>> {
    if !root.has(name) {
        return modes.map(|modes| vec![0.0; modes * modes]);
    }
    let rows = root.rows(name)?;
    let modes = modes?;
    let fault = if rows.len() != modes {
        format!("`{name}` has {}", plural(rows.len(), "row"))
    } else if let Some(row) = rows.iter().position(|row| row.len() != modes) {
        let count = entries(rows[row].len());
        format!("row {} of `{name}` has {count}", row + 1)
    } else {
        return Some(rows.concat());
    };
    root.inconsistent(
        name,
        format!("{fault}, but `frequency` has {}", entries(modes)),
    )
    .label(format!("{modes} rows of {modes} are needed"))
    .remedy("give one row per mode with one entry per mode, in the order of `frequency`")
    .fail(root.issues)
}

/// A damping matrix, with entries of rigid motions below [`NO_DAMPING`] set to 0.
fn without_round_off(mut matrix: Vec<f64>, frequency: &[f64]) -> Vec<f64> {
    let least = NO_DAMPING * frequency.iter().copied().fold(0.0, f64::max);
    let modes = frequency.len();
    for (place, entry) in matrix.iter_mut().enumerate() {
        let rigid = [place / modes, place % modes].map(|mode| frequency[mode] == 0.0);
        if rigid.contains(&true) && entry.abs() < least {
            *entry = 0.0;
        }
    }
    matrix
}

/// The gyroscopic matrix, made exactly skew-symmetric.
fn skew(root: &Section, matrix: Vec<f64>, modes: usize) -> Option<Vec<f64>> {
    let largest = matrix.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let places = (0..modes).flat_map(|i| (0..=i).map(move |j| (i, j)));
    let pair = |(i, j): (usize, usize)| [matrix[i * modes + j], matrix[j * modes + i]];
    let sum = |place| pair(place).iter().sum::<f64>().abs();
    if let Some((i, j)) = places
        .clone()
        .find(|&place| sum(place) > SKEW_BOUND * largest)
    {
        let [below, above] = pair((i, j));
        let message = format!(
            "row {}, column {} of `gyroscopic_matrix` is {}, but its mirror image is {}; gyroscopic moments \
                     do no work, so the matrix must be skew-symmetric",
            i + 1,
            j + 1,
            schema::number(below),
            schema::number(above)
        );
        let remedy = "give every pair across the diagonal opposite signs, and the diagonal 0; damping belongs in \
                 `damping_matrix`";
        return root
            .inconsistent("gyroscopic_matrix", message)
            .label("not skew-symmetric")
            .remedy(remedy)
            .fail(root.issues);
    }
    let mut exact = vec![0.0; modes * modes];
    for (i, j) in places.filter(|(i, j)| i != j) {
        let [below, above] = pair((i, j));
        exact[i * modes + j] = 0.5 * (below - above);
        exact[j * modes + i] = -exact[i * modes + j];
    }
    Some(exact)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_off_damps_no_rigid_motion() {
        // Mode 1 is rigid, mode 2 elastic. Entries below 1e-12 of 4000 rad/s are set to 0 only in row or column 1.
        let given = vec![1e-24, -3.9e-9, 3.9e-9, 1e-10];
        let read = without_round_off(given, &[0.0, 4000.0]);
        assert_eq!(read, [0.0, 0.0, 0.0, 1e-10]);
        let drag = vec![1e-8, 4.1e-9, -4.1e-9, 0.0];
        assert_eq!(without_round_off(drag.clone(), &[0.0, 4000.0]), drag);
        // Without an elastic mode there is no scale, so every damping is kept.
        assert_eq!(without_round_off(vec![1e-24], &[0.0]), [1e-24]);
    }
}
