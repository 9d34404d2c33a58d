//! The columns of `points.parquet` about a computed mesh under the mean load.

use super::PointRow;
use super::table::{Column, columns};

/// The columns, in file order.
pub(super) fn mesh_columns() -> Vec<Column<PointRow>> {
    columns![row: PointRow;
        f64 "misalignment_loaded", "rad", row.mesh?.misalignment,
            "Angle between the flanks in the plane of action under the mean load, including the tilt of the \
             shafts with mesh.shaft_tilt. This and the next four columns are null if the mesh is not \
             computed from the gears";
        f64 "load_centre", "m", row.mesh?.load_centre,
            "Mean position along the face, from its middle, of the mesh force under the mean load";
        f64 "mesh_stiffness", "N/m", row.mesh?.stiffness,
            "Mean tangent mesh stiffness over the mesh cycle under the mean load";
        f64 "contact_ratio_loaded", "1", row.mesh?.contact_ratio,
            "Mean number of pairs of teeth that bear load over the mesh cycle under the mean load";
        f64 "transmission_error_pp", "m", row.mesh?.transmission_error,
            "Largest minus smallest static transmission error over the mesh cycle under the mean load";
    ]
}
