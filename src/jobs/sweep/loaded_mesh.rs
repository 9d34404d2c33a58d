//! Stiffness, errors and pairs in contact of meshes from the drawing, under the mean load and before the shafts tilt.

use super::first_force::{first_force, friction};
use super::further_meshes::{self, FurtherMeshError};
use super::mesh_divisions::joined_pieces;
use super::mesh_error::MeshError;
use super::mesh_tables::{MeshTables, flank_load};
use crate::gear::{CycleDivision, MeshTableCycle, MeshTableSpec};
use crate::manifest::PointSpec;
use crate::structure::ModalStructure;
use std::sync::Arc;

/// A mesh from the drawing under the mean load, before the shafts tilt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadedMesh {
    /// Mean force on the flanks \[N\].
    pub force: f64,
    /// Peak-to-peak error of the loaded flanks \[m\].
    pub flank_error: f64,
    /// Smallest, mean and largest stiffness over the mesh cycle \[N/m\].
    pub stiffness: [f64; 3],
    /// Mean number of pairs that carry load.
    pub contact_ratio: f64,
    /// Number of joined pieces ([`JoinedPieces`](crate::gear::JoinedPieces)), the error of their stiffness,
    /// and the error of their friction and load centroid. `None` if the mesh has springs, or segments with means
    /// of the tangent stiffness.
    pub course: Option<(usize, [f64; 2])>,
}

impl LoadedMesh {
    fn of(spec: &MeshTableSpec, friction: f64, cycle: &MeshTableCycle) -> Self {
        let [least, most] = cycle.extremes(&cycle.stiffness);
        Self {
            force: cycle.force,
            flank_error: if cycle.has_error() { cycle.range(&cycle.tangent_error()) } else { 0.0 },
            stiffness: [least, cycle.mean_stiffness(), most],
            contact_ratio: cycle.mean_loaded_pairs(),
            course: match spec.division {
                CycleDivision::Pairs { .. } => None,
                CycleDivision::Segments(_) if spec.stiffness.is_tangent() => None,
                _ => {
                    let joined_pieces = joined_pieces(friction, spec, cycle);
                    Some((
                        joined_pieces.pieces.len(),
                        [joined_pieces.stiffness_error, joined_pieces.turning_error],
                    ))
                }
            },
        }
    }
}

/// The first mesh of a point whose stiffness comes from the table of `spec`. The structure of a train
/// determines which part of load and drag acts on this mesh.
///
/// # Errors
/// The gears do not mesh, or the load cannot be shared.
pub fn loaded_mesh(
    point: &PointSpec,
    spec: &MeshTableSpec,
    structure: Option<&ModalStructure>,
    meshes: &MeshTables,
) -> Result<LoadedMesh, MeshError> {
    let cycle = first_cycle(point, spec, structure, meshes)?;
    let friction = match structure {
        Some(structure) => friction(structure, point)?,
        None => point.mesh.friction.coefficient(cycle.force, point.speed)?,
    };
    Ok(LoadedMesh::of(spec, friction, &cycle))
}

/// The further meshes of a point's train that are computed from the drawing, with the names of their gears.
///
/// # Errors
/// [`FurtherMeshError`].
pub fn loaded_further_meshes(
    point: &PointSpec,
    structure: &ModalStructure,
    meshes: &MeshTables,
) -> Result<Vec<([String; 2], LoadedMesh)>, FurtherMeshError> {
    further_meshes::each(structure, point, |_, drawn, force| {
        let cycle = meshes.before_tilt(drawn, force)?;
        Ok(LoadedMesh::of(&drawn.table, drawn.friction, &cycle))
    })
}

/// The cycle of the first mesh under the mean load, before the shafts tilt.
///
/// # Errors
/// As [`loaded_mesh`].
pub(super) fn first_cycle(
    point: &PointSpec,
    spec: &MeshTableSpec,
    structure: Option<&ModalStructure>,
    meshes: &MeshTables,
) -> Result<Arc<MeshTableCycle>, MeshError> {
    let rated = (point.model.source.rated_force()).unwrap_or(spec.gears.rated_force());
    let force = structure.map_or(point.load * rated, |structure| {
        first_force(structure, point)
    });
    let force = match (spec.division, force == 0.0) {
        // Springs of pairs need no mean load. Without one, use the rated load.
        (CycleDivision::Pairs { .. }, true) => rated,
        _ => flank_load(force)?,
    };
    meshes.scaled(spec, point.mesh.misalignment, force)
}
