//! A modal file without a mesh (an oscillator): the displacement that results show, and the load.

use super::{acting, acts, column, optional};
use crate::manifest::reader::Section;
use crate::structure::StructureContact;

/// Keys of the mesh, without an effect if there is no `mesh`.
const OF_MESH: [&str; 4] = ["mesh_tilt", "friction", "friction_lever", "mesh_coast"];

/// Whether the file has no mesh.
pub(super) fn has_no_mesh(root: &Section) -> bool {
    !root.has("mesh")
}

/// Participation of the displacement that results show, and modal force of the load. By default, the displacement is
/// that of the first contact that a mode deflects, otherwise that of mode 1, and the load is 0.
pub(super) fn lines(
    root: &Section,
    modes: Option<usize>,
    contacts: Option<&[StructureContact]>,
) -> Option<[Vec<f64>; 2]> {
    root.without_effect(&OF_MESH, "without `mesh`", "remove it, or add mesh");
    let load = optional(root, "torque", modes);
    let shown = if root.has("displacement") {
        let displacement = column(root, "displacement", modes);
        displacement.filter(|displacement| acts(root, "displacement", displacement))?
    } else {
        let deflected = contacts?
            .iter()
            .find(|contact| acting(&contact.participation));
        let mut first = vec![0.0; modes?];
        first.first_mut().map(|first| *first = 1.0)?;
        deflected.map_or(first, |contact| contact.participation.clone())
    };
    let load = load?.unwrap_or_else(|| vec![0.0; shown.len()]);
    Some([shown, load])
}
