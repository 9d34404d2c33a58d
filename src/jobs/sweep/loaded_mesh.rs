//! What the mean load makes of a mesh that is computed from the drawing, looked at in passing: nothing is kept.

use super::mesh_tables::{MeshError, course, flank_load, inputs, is_scaled};
use crate::gear::{Flanks, MeshTable, MeshTableCycle, StiffnessLaw};
use crate::manifest::{CycleDivision, MeshTableSpec, PointSpec};

/// What the mean load makes of a mesh that is computed from the drawing, before the shafts tilt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadedMesh {
    /// Largest less smallest error of the loaded flanks \[m\].
    pub flank_error: f64,
    /// Smallest, mean and largest stiffness over the mesh cycle \[N/m\].
    pub stiffness: [f64; 3],
    /// Mean number of pairs that bear load.
    pub contact_ratio: f64,
    /// Pieces of the course that the mesh cycle is integrated with, how far their stiffness and how far friction and load
    /// centroid are off ([`MeshCourse`](crate::gear::MeshCourse)); none where the mesh has segments or springs.
    pub course: Option<(usize, [f64; 2])>,
}

/// That of a point that takes its stiffness from the table of `spec`. Nothing is kept.
///
/// # Errors
/// Gears that do not mesh, or a load that cannot be shared.
pub fn loaded_mesh(point: &PointSpec, spec: &MeshTableSpec) -> Result<LoadedMesh, MeshError> {
    let cycle = passing(point, spec)?;
    let [least, most] = cycle.extremes(&cycle.stiffness);
    Ok(LoadedMesh {
        flank_error: if cycle.has_error() { cycle.range(&cycle.tangent_error()) } else { 0.0 },
        stiffness: [least, cycle.mean_stiffness(), most],
        contact_ratio: cycle.mean_loaded_pairs(),
        course: match spec.division {
            CycleDivision::Pairs { .. } => None,
            CycleDivision::Segments(_) if spec.stiffness.is_tangent() => None,
            _ => {
                let course = course(point, spec, &cycle)?;
                Some((
                    course.pieces.len(),
                    [course.stiffness_error, course.turning_error],
                ))
            }
        },
    })
}

/// Mean stiffness over the mesh cycle \[N/m\] of such a point.
///
/// # Errors
/// As there.
pub(super) fn mean_stiffness(point: &PointSpec, spec: &MeshTableSpec) -> Result<f64, MeshError> {
    Ok(passing(point, spec)?.mean_stiffness())
}

/// The cycle of a point that takes its stiffness from the table of `spec`, before the shafts tilt.
fn passing(point: &PointSpec, spec: &MeshTableSpec) -> Result<MeshTableCycle, MeshError> {
    let rated = (point.model.source.rated_force()).unwrap_or(spec.gears.rated_force());
    let force = match (spec.division, point.load == 0.0) {
        // Springs know no load; what is told of them is that of the rated one.
        (CycleDivision::Pairs { .. }, true) => rated,
        _ => flank_load(point.load * rated)?,
    };
    let misalignment = point.mesh.misalignment;
    let flanks = Flanks::new(&spec.gears)?;
    let cycle = |stiffness| -> Result<MeshTableCycle, MeshError> {
        let inputs = inputs(spec, stiffness, misalignment, force);
        Ok(MeshTable::build(&flanks, &inputs, &|_, _| ())?.cycle(0, 0))
    };
    let found = cycle(spec.stiffness)?;
    Ok(if is_scaled(spec, misalignment) {
        found.with_mean_stiffness(cycle(StiffnessLaw::Tangent)?.mean_stiffness())
    } else {
        found
    })
}
