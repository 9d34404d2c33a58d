//! From matrices over the freedoms to matrices over the modes: `Φᵀ C Φ`, `Φᵀ G Φ`, `Φᵀ K_c Φ`.

use super::assembly::{AssembledMatrices, CouplingMatrices};
use super::modes::Modes;
use crate::numerics::linalg::product;
use crate::structure::Coupling;
use faer::Mat;

/// An entry of a shape below this part of the largest, each times the square root of its freedom's inertia,
/// is round-off of zero: a mode of torsion, or of bending in one plane, moves
/// nothing else. On the default drive couplings are above 1e-7 of the largest at up to 150
/// modes, and removed entries are below 1e-9.
const SHAPE_NOISE: f64 = 1e-8;

/// An entry of a matrix below this part of the largest is round-off of zero.
const COUPLING_NOISE: f64 = 1e-13;

/// The coupling of the modes of a solution, `None` if there is none. Also the contribution of a rotating frame to their
/// stiffness, empty without such a frame. `to_structure_modes` converts a participation in the modes of the solution to
/// the modes of the structure.
pub(super) fn coupling(
    matrices: &AssembledMatrices,
    solution: &Modes,
    to_structure_modes: impl Fn(&mut [f64]),
) -> (Option<Coupling>, Vec<f64>) {
    let Some(coupling) = matrices.coupling.as_ref() else {
        return (None, Vec::new());
    };
    let CouplingMatrices {
        damping,
        gyroscopic,
        cross_stiffness,
        frame_stiffness,
    } = coupling;
    let shape = structure_shapes(&matrices.mass, solution, to_structure_modes);
    let project = |matrix: &Mat<f64>| {
        let image = product(matrix.as_ref(), shape.as_ref());
        product(shape.transpose(), image.as_ref())
    };
    // The projection of a matrix, made exactly symmetric (sign 1) or exactly skew (sign −1).
    let parted = |matrix: &Mat<f64>, sign: f64| {
        let projected = project(matrix);
        let part = |i: usize, j: usize| 0.5 * (projected[(i, j)] + sign * projected[(j, i)]);
        rows(&Mat::from_fn(projected.nrows(), projected.ncols(), part))
    };
    let coupling = Coupling {
        damping: rows(&project(damping)),
        gyroscopic: parted(gyroscopic, -1.0),
        stiffness: rows(&project(cross_stiffness)),
    };
    let projected = [&coupling.damping, &coupling.gyroscopic, &coupling.stiffness]
        .into_iter()
        .flatten()
        .any(|&entry| entry != 0.0);
    let of_frame = if frame_stiffness.norm_max() == 0.0 {
        Vec::new()
    } else {
        parted(frame_stiffness, 1.0)
    };
    (projected.then_some(coupling), of_frame)
}

/// The shapes of the structure's modes, freedoms × modes, with round-off of zeros removed.
fn structure_shapes(
    mass: &Mat<f64>,
    solution: &Modes,
    to_structure_modes: impl Fn(&mut [f64]),
) -> Mat<f64> {
    let mut shape = solution.shape.clone();
    for row in 0..shape.nrows() {
        let mut values: Vec<f64> = shape.row(row).iter().copied().collect();
        to_structure_modes(&mut values);
        for (mode, value) in values.into_iter().enumerate() {
            shape[(row, mode)] = value;
        }
    }
    let weight: Vec<f64> = (0..shape.nrows()).map(|i| mass[(i, i)].sqrt()).collect();
    for mode in 0..shape.ncols() {
        let weighted = |row: usize| weight[row] * shape[(row, mode)].abs();
        let largest = (0..weight.len()).map(weighted).fold(0.0, f64::max);
        let noise = SHAPE_NOISE * largest;
        for row in 0..weight.len() {
            if weight[row] * shape[(row, mode)].abs() <= noise {
                shape[(row, mode)] = 0.0;
            }
        }
    }
    shape
}

/// The entries row by row, with round-off of zero set to 0.
fn rows(matrix: &Mat<f64>) -> Vec<f64> {
    let noise = COUPLING_NOISE * matrix.norm_max();
    (0..matrix.nrows())
        .flat_map(|i| (0..matrix.ncols()).map(move |j| matrix[(i, j)]))
        .map(|entry| if entry.abs() <= noise { 0.0 } else { entry })
        .collect()
}
