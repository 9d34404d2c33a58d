//! What the mean load makes of a mesh that is computed from the drawing, looked at in passing: nothing is kept.

use super::first_force::first_force;
use super::mesh_tables::{MeshError, course, flank_load, inputs, is_scaled};
use crate::gear::{CycleDivision, Flanks, MeshTable, MeshTableCycle, MeshTableSpec, StiffnessLaw};
use crate::manifest::PointSpec;
use crate::shaft::DrawnLaw;
use crate::structure::ModalStructure;

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

/// That of a point that takes its stiffness from the table of `spec`. Nothing is kept. Of a train the structure says how
/// load and drag come to its first mesh.
///
/// # Errors
/// Gears that do not mesh, or a load that cannot be shared.
pub fn loaded_mesh(
    point: &PointSpec,
    spec: &MeshTableSpec,
    structure: Option<&ModalStructure>,
) -> Result<LoadedMesh, MeshError> {
    let cycle = passing(point, spec, structure)?;
    let [least, most] = cycle.extremes(&cycle.stiffness);
    Ok(LoadedMesh {
        flank_error: if cycle.has_error() { cycle.range(&cycle.tangent_error()) } else { 0.0 },
        stiffness: [least, cycle.mean_stiffness(), most],
        contact_ratio: cycle.mean_loaded_pairs(),
        course: match spec.division {
            CycleDivision::Pairs { .. } => None,
            CycleDivision::Segments(_) if spec.stiffness.is_tangent() => None,
            _ => {
                let friction = point.mesh.friction.coefficient(cycle.force, point.speed)?;
                let course = course(friction, spec, &cycle);
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
pub(super) fn mean_stiffness(
    point: &PointSpec,
    spec: &MeshTableSpec,
    structure: &ModalStructure,
) -> Result<f64, MeshError> {
    Ok(passing(point, spec, Some(structure))?.mean_stiffness())
}

/// That of a further mesh of a train under a mean force \[N\].
///
/// # Errors
/// As there.
pub(super) fn mean_stiffness_of(drawn: &DrawnLaw, force: f64) -> Result<f64, MeshError> {
    let cycle = cycle(&drawn.table, drawn.misalignment, flank_load(force)?)?;
    Ok(cycle.mean_stiffness())
}

/// The cycle of a point that takes its stiffness from the table of `spec`, before the shafts tilt.
fn passing(
    point: &PointSpec,
    spec: &MeshTableSpec,
    structure: Option<&ModalStructure>,
) -> Result<MeshTableCycle, MeshError> {
    let rated = (point.model.source.rated_force()).unwrap_or(spec.gears.rated_force());
    let force = structure.map_or(point.load * rated, |own| first_force(own, point));
    let force = match (spec.division, force == 0.0) {
        // Springs know no load; what is told of them is that of the rated one.
        (CycleDivision::Pairs { .. }, true) => rated,
        _ => flank_load(force)?,
    };
    cycle(spec, point.mesh.misalignment, force)
}

/// The cycle under a load \[N\] on the flanks.
fn cycle(spec: &MeshTableSpec, misalignment: f64, force: f64) -> Result<MeshTableCycle, MeshError> {
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
