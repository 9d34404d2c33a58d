//! From matrices over the freedoms to matrices over the modes: `Φᵀ C Φ`, `Φᵀ G Φ`, `Φᵀ K_c Φ`.

use super::assembly::CouplingMatrices;
use super::modal::Coupling;
use super::modes::Modes;
use crate::numerics::linalg::product;
use faer::Mat;

/// Part of a rigid rotation's largest entry below which another one is the round-off of zero: a
/// shaft that turns in its bearings neither moves sideways nor tilts.
const ROTATION_NOISE: f64 = 1e-8;

/// Part of a matrix's largest entry below which another one is the round-off of zero; so small
/// a coupling changes no rate by more.
const COUPLING_NOISE: f64 = 1e-13;

/// The coupling of the modes of a solution, of which the first `rigid` are rotations about the
/// axes; `settle` is what turns a participation as the solution has it, one entry a mode, into
/// that of the structure. None where no mode feels anything of it.
pub(super) fn coupling(
    matrices: &CouplingMatrices,
    solution: &Modes,
    rigid: usize,
    settle: impl Fn(&mut [f64]),
) -> Option<Coupling> {
    let shape = settled_shape(solution, rigid, settle);
    let project = |matrix: &Mat<f64>| {
        let image = product(matrix.as_ref(), shape.as_ref());
        product(shape.transpose(), image.as_ref())
    };
    let gyroscopic = project(&matrices.gyroscopic);
    let modes = gyroscopic.nrows();
    // Skew in every bit.
    let gyroscopic = Mat::from_fn(modes, modes, |i, j| {
        0.5 * (gyroscopic[(i, j)] - gyroscopic[(j, i)])
    });
    let coupling = Coupling {
        damping: rows(&project(&matrices.damping)),
        gyroscopic: rows(&gyroscopic),
        stiffness: rows(&project(&matrices.cross_stiffness)),
    };
    let felt = [&coupling.damping, &coupling.gyroscopic, &coupling.stiffness]
        .into_iter()
        .flatten()
        .any(|&entry| entry != 0.0);
    felt.then_some(coupling)
}

/// The shapes of the structure's modes, freedoms × modes.
fn settled_shape(solution: &Modes, rigid: usize, settle: impl Fn(&mut [f64])) -> Mat<f64> {
    let mut shape = solution.shape.clone();
    for row in 0..shape.nrows() {
        let mut values: Vec<f64> = shape.row(row).iter().copied().collect();
        settle(&mut values);
        for (mode, value) in values.into_iter().enumerate() {
            shape[(row, mode)] = value;
        }
    }
    for mode in 0..rigid {
        let column = shape.col(mode);
        let largest = column.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        for row in 0..shape.nrows() {
            if shape[(row, mode)].abs() <= ROTATION_NOISE * largest {
                shape[(row, mode)] = 0.0;
            }
        }
    }
    shape
}

/// The entries row by row, those that are round-off of zero set to it.
fn rows(matrix: &Mat<f64>) -> Vec<f64> {
    let noise = COUPLING_NOISE * matrix.norm_max();
    (0..matrix.nrows())
        .flat_map(|i| (0..matrix.ncols()).map(move |j| matrix[(i, j)]))
        .map(|entry| if entry.abs() <= noise { 0.0 } else { entry })
        .collect()
}
