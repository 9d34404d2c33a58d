//! Further meshes of a train that follow from the drawing of their gears: their laws under the mean load of a point.

use super::loaded_mesh::mean_stiffness_of;
use super::mesh_tables::{MeshError, MeshTables};
use crate::manifest::{PointSpec, StructureSource};
use crate::model::Division;
use crate::shaft::{DrawnLaw, MeshLaw, TrainDrive};
use crate::structure::ModalStructure;
use std::borrow::Cow;

/// Part of the rated force below which a mean mesh force is the round-off of none.
const NO_FORCE: f64 = 1e-9;

/// Why a further mesh has no law.
#[derive(Debug, thiserror::Error)]
#[error("the mesh of {} and {} cannot be computed: {error}", gears[0], gears[1])]
pub struct FurtherMeshError {
    /// Its gears.
    pub gears: [String; 2],
    /// Why.
    pub error: MeshError,
}

/// The structure of a point, its further meshes with their laws.
///
/// # Errors
/// [`FurtherMeshError`].
pub(super) fn with_laws<'s>(
    structure: &'s ModalStructure,
    point: &PointSpec,
    meshes: &MeshTables,
) -> Result<Cow<'s, ModalStructure>, FurtherMeshError> {
    each(structure, point, |drawn, force, contact| {
        let mesh = meshes.further(drawn, force, (structure, contact))?;
        Ok(mesh.divisions)
    })
}

/// The same with their mean stiffness. Nothing is kept of the tables, nor do the shafts tilt.
pub(super) fn with_means<'s>(
    structure: &'s ModalStructure,
    point: &PointSpec,
) -> Result<Cow<'s, ModalStructure>, FurtherMeshError> {
    each(structure, point, |drawn, force, _| {
        let mean = mean_stiffness_of(drawn, force)?;
        Ok(vec![Division {
            friction: [0.0; 2],
            ..Division::level(1.0, mean)
        }])
    })
}

fn each<'s>(
    structure: &'s ModalStructure,
    point: &PointSpec,
    divisions: impl Fn(&DrawnLaw, f64, usize) -> Result<Vec<Division>, MeshError>,
) -> Result<Cow<'s, ModalStructure>, FurtherMeshError> {
    let StructureSource::Train(train) = &point.model.source else {
        return Ok(Cow::Borrowed(structure));
    };
    let drawn = train.meshes.iter().enumerate();
    let drawn = drawn.filter_map(|(number, mesh)| match &mesh.law {
        MeshLaw::Drawn(drawn) => Some((number, drawn)),
        MeshLaw::OfFirst { .. } | MeshLaw::Own(_) => None,
    });
    let mut drawn = drawn.peekable();
    if drawn.peek().is_none() {
        return Ok(Cow::Borrowed(structure));
    }
    let forces = train.mean_forces(structure, point.load, point.speed);
    let mut own = structure.clone();
    for (number, drawn) in drawn {
        let force = forces[1 + number];
        let none = force.abs() <= NO_FORCE * structure.rated_force;
        let found = divisions(drawn, if none { 0.0 } else { force }, 2 * number);
        let found = found.map_err(|error| FurtherMeshError {
            gears: names(train, number),
            error,
        })?;
        let laws = (drawn.beside).on_both_flanks(&found, drawn.friction, drawn.symmetry);
        for (contact, law) in own.contacts[2 * number..].iter_mut().zip(laws) {
            contact.law = law;
        }
    }
    Ok(Cow::Owned(own))
}

fn names(train: &TrainDrive, mesh: usize) -> [String; 2] {
    train.meshes[mesh]
        .gears
        .map(|place| train.gear(place).name.clone())
}
