//! The substitute for `[mesh]` if a modal file has no mesh: flanks that are out of reach, and a scale of lengths.

use super::Context;
use super::drive_kind::is_kind;
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind};
use crate::manifest::modal_keys;
use crate::manifest::reader::Section;
use crate::manifest::spec::{
    CoastSpec, DampingSpec, FrictionSpec, MeshSpec, ModelSpec, StiffnessSpec, StructureSource,
};
use crate::manifest::tree::{Node, Value};
use crate::model::Release;
use crate::structure::ModalStructure;

/// Whether the modal file of a manifest has no mesh. The file must have been read.
pub(super) fn has_no_mesh(root: &Section, context: &Context) -> bool {
    let model = root
        .entry("model")
        .and_then(|model| model.node.entry("file"));
    let Some(Value::Text(file)) = model.map(|file| &file.node.value) else {
        return false;
    };
    let has_no_mesh = |tree: &Node| tree.entry("mesh").is_none();
    let known = context.modal_files.get(&context.base_dir.join(file));
    let file_tree = known.and_then(Option::as_ref).map(|file| &file.tree);
    is_kind(root, "modal")
        && modal_keys::tree(root.entries())
            .flatten()
            .or(file_tree)
            .is_some_and(has_no_mesh)
}

/// The substitute for an oscillator's mesh; `None` if `[mesh]` is given or nothing determines a length, which is
/// reported.
pub(super) fn mesh(root: &Section, model: Option<&ModelSpec>) -> Option<MeshSpec> {
    if let Some(entry) = root.entry("mesh") {
        let message = "[mesh] describes flanks, but the modal file has no mesh";
        return Diagnostic::new(
            DiagnosticKind::Inconsistent,
            entry.key_span,
            "mesh",
            message,
        )
        .label("no mesh in the modal file")
        .remedy("remove [mesh], or give `mesh` and `torque` in the modal file")
        .fail(root.issues);
    }
    let StructureSource::Modal(structure) = &model?.source else {
        return None;
    };
    let length = match root.child("model").flatten() {
        Some(section) if section.has("length") => section.quantity("length")?,
        _ => typical_length(structure),
    };
    if length == 0.0 {
        let message = "nothing tells how large the motion is: no contact has a gap, and no [[harmonic_load]] acts";
        return Diagnostic::new(
            DiagnosticKind::MissingKey,
            root.entry("model")
                .map_or(root.span, |entry| entry.key_span),
            "model.length",
            message,
        )
        .label("no scale of lengths")
        .remedy("add length, the order of magnitude of the motion, such as length = \"1 mm\"")
        .fail(root.issues);
    }
    let mesh = MeshSpec {
        half_gap: length,
        length: None,
        stiffness: StiffnessSpec::Constant(stiffness(structure)),
        damping: DampingSpec::Coefficient(0.0),
        friction: FrictionSpec::Constant(0.0),
        sliding: None,
        misalignment: 0.0,
        coast: CoastSpec::SameLine,
        release: Release::Deflection,
        teeth: None,
        film: None,
    };
    Some(mesh.measured_by(length))
}

/// The largest of the gaps of contacts and of the static deflections by harmonic loads \[m\]; 0 without both.
fn typical_length(structure: &ModalStructure) -> f64 {
    let gaps = structure
        .contacts
        .iter()
        .map(|contact| contact.law.gap.abs());
    let loads = structure.harmonic_loads.iter().map(|load| {
        let modes = structure
            .mesh
            .iter()
            .zip(&load.force)
            .zip(&structure.frequency);
        let elastic = modes.filter(|(_, omega)| **omega > 0.0);
        elastic
            .map(|((w, force), omega)| (w * force).abs() / (omega * omega))
            .sum::<f64>()
    });
    gaps.chain(loads).fold(0.0, f64::max)
}

/// A stiffness along the displayed displacement, as a scale for distances of states \[N/m\]. It gives the frequency of
/// the lowest elastic mode. If all modes are rigid, it is the stiffness of the first contact that has one, otherwise 1.
fn stiffness(structure: &ModalStructure) -> f64 {
    let square: f64 = structure.mesh.iter().map(|w| w * w).sum();
    let lowest = structure.frequency.iter().find(|omega| **omega > 0.0);
    let mut springs =
        (structure.contacts.iter()).filter(|contact| contact.law.dry_friction.is_none());
    let contact = springs.find_map(|contact| contact.law.stiffness.first());
    match (lowest, contact) {
        (Some(omega), _) => omega * omega / square,
        (None, Some((_, series))) => series[0].abs(),
        (None, None) => 1.0,
    }
}
