//! Mean force and friction on the flanks of the first mesh.

use crate::gear::GearError;
use crate::manifest::{PointSpec, StructureSource};
use crate::structure::ModalStructure;

/// Mean force on the flanks of the first mesh \[N\].
pub(super) fn first_force(structure: &ModalStructure, point: &PointSpec) -> f64 {
    match &point.model.source {
        StructureSource::Train(train) => train.mean_forces(structure, point.load, point.speed)[0],
        _ => point.load * structure.rated_force,
    }
}

/// Coefficient of friction of the first mesh, at its mean force and rolling speed.
///
/// # Errors
/// Errors of the law of friction.
pub(super) fn friction(structure: &ModalStructure, point: &PointSpec) -> Result<f64, GearError> {
    let rolling = point.speed * structure.frame.rolling.abs();
    let force = first_force(structure, point);
    point.mesh.friction.coefficient(force, rolling)
}
