//! What the flanks of the first mesh bear on average.

use crate::manifest::{PointSpec, StructureSource};
use crate::structure::ModalStructure;

/// Mean force on the flanks of the first mesh \[N\].
pub(super) fn first_force(structure: &ModalStructure, point: &PointSpec) -> f64 {
    match &point.model.source {
        StructureSource::Train(train) => train.mean_forces(structure, point.load, point.speed)[0],
        _ => point.load * structure.rated_force,
    }
}
