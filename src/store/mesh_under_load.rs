//! The columns of `points.parquet` that tell what the mean load makes of a mesh computed from its gears.

use super::PointRow;
use super::table::{Column, columns};
use serde::{Deserialize, Serialize};

/// What the mean load makes of a mesh that is computed from the drawing of its gears.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MeshUnderLoad {
    /// Angle between the flanks in the plane of action, the shafts' tilt included where it is asked for, ε_eff \[rad\].
    pub misalignment: f64,
    /// Mean load centroid z_c: where along the face the mesh force acts, from mid-face \[m\].
    pub load_centre: f64,
    /// Mean stiffness over the mesh cycle \[N/m\].
    pub stiffness: f64,
    /// Mean number of pairs of teeth that bear load.
    pub contact_ratio: f64,
    /// Largest less smallest loaded static transmission error \[m\].
    pub transmission_error: f64,
}

/// The columns, in file order.
pub(super) fn mesh_columns() -> Vec<Column<PointRow>> {
    columns![row: PointRow;
        f64 "misalignment_loaded", "rad", row.mesh?.misalignment,
            "Angle between the flanks in the plane of action under the mean load, the shafts' tilt included where mesh.shaft_tilt asks for it; null, as the next four, where the mesh is not computed from the gears";
        f64 "load_centre", "m", row.mesh?.load_centre,
            "Mean place along the face, from its middle, at which the mesh force acts under the mean load";
        f64 "mesh_stiffness", "N/m", row.mesh?.stiffness,
            "Mean tangent mesh stiffness over the mesh cycle under the mean load";
        f64 "contact_ratio_loaded", "1", row.mesh?.contact_ratio,
            "Mean number of pairs of teeth that bear load over the mesh cycle under the mean load";
        f64 "transmission_error_pp", "m", row.mesh?.transmission_error,
            "Largest minus smallest static transmission error over the mesh cycle under the mean load";
    ]
}
