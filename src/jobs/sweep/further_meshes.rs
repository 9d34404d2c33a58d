//! Force laws of the further meshes of a train, computed from the drawing of their gears under the mean load
//! of a point.

use super::mesh_error::MeshError;
use super::mesh_tables::MeshTables;
use crate::manifest::{PointSpec, StructureSource};
use crate::model::Division;
use crate::shaft::{DrawnLaw, MeshLaw, TrainDrive, mean_forces};
use crate::structure::ModalStructure;
use std::borrow::Cow;

/// A mean mesh force below this fraction of the rated force is round-off.
const NO_FORCE: f64 = 1e-9;

/// Why the force law of a further mesh cannot be computed.
#[derive(Debug, thiserror::Error)]
#[error("the mesh of {} and {} cannot be computed: {error}", gears[0], gears[1])]
pub struct FurtherMeshError {
    /// Names of the two gears.
    pub gears: [String; 2],
    /// Reason.
    pub error: MeshError,
}

/// The structure of a point, with the force laws of its further meshes.
///
/// # Errors
/// [`FurtherMeshError`].
pub(super) fn with_laws<'s>(
    structure: &'s ModalStructure,
    point: &PointSpec,
    meshes: &MeshTables,
) -> Result<Cow<'s, ModalStructure>, FurtherMeshError> {
    with_divisions(structure, point, |contact, drawn, force| {
        let mesh = meshes.further(drawn, force, (structure, contact))?;
        Ok(mesh.divisions)
    })
}

/// The structure of a point, with the mean stiffness of its further meshes. The shafts do not tilt.
pub(super) fn with_means<'s>(
    structure: &'s ModalStructure,
    point: &PointSpec,
    meshes: &MeshTables,
) -> Result<Cow<'s, ModalStructure>, FurtherMeshError> {
    with_divisions(structure, point, |_, drawn, force| {
        let cycle = meshes.before_tilt(drawn, force)?;
        Ok(vec![Division {
            friction: [0.0; 2],
            ..Division::level(1.0, cycle.mean_stiffness())
        }])
    })
}

fn with_divisions<'s>(
    structure: &'s ModalStructure,
    point: &PointSpec,
    divisions: impl Fn(usize, &DrawnLaw, f64) -> Result<Vec<Division>, MeshError>,
) -> Result<Cow<'s, ModalStructure>, FurtherMeshError> {
    let laws = each(structure, point, |contact, drawn, force| {
        let mesh_divisions = divisions(contact, drawn, force)?;
        let laws = (drawn.undrawn_properties).on_both_flanks(
            &mesh_divisions,
            drawn.friction,
            drawn.symmetry,
        );
        Ok((contact, laws))
    })?;
    if laws.is_empty() {
        return Ok(Cow::Borrowed(structure));
    }
    let mut changed = structure.clone();
    for (_, (contact, laws)) in laws {
        for (flank, law) in changed.contacts[contact..].iter_mut().zip(laws) {
            flank.law = law;
        }
    }
    Ok(Cow::Owned(changed))
}

/// Calls `of` for every further mesh from a drawing, with the index of its first contact, its drawing and its
/// mean force \[N\]. Returns the results with the names of the gears.
pub(super) fn each<T>(
    structure: &ModalStructure,
    point: &PointSpec,
    of: impl Fn(usize, &DrawnLaw, f64) -> Result<T, MeshError>,
) -> Result<Vec<([String; 2], T)>, FurtherMeshError> {
    let StructureSource::Train(train) = &point.model.source else {
        return Ok(Vec::new());
    };
    let drawn = train.meshes.iter().enumerate();
    let drawn = drawn.filter_map(|(number, mesh)| match &mesh.law {
        MeshLaw::Drawn(drawn) => Some((number, drawn)),
        MeshLaw::OfFirst { .. } | MeshLaw::Own(_) => None,
    });
    let mut drawn = drawn.peekable();
    if drawn.peek().is_none() {
        return Ok(Vec::new());
    }
    let forces = mean_forces(structure, point.load, point.speed);
    let all = drawn.map(|(number, drawn)| {
        let force = forces[1 + number];
        let none = force.abs() <= NO_FORCE * structure.rated_force;
        let gears = names(train, number);
        match of(2 * number, drawn, if none { 0.0 } else { force }) {
            Ok(found) => Ok((gears, found)),
            Err(error) => Err(FurtherMeshError { gears, error }),
        }
    });
    all.collect()
}

fn names(train: &TrainDrive, mesh: usize) -> [String; 2] {
    train.meshes[mesh]
        .gears
        .map(|place| train.gear(place).name.clone())
}
