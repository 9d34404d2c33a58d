//! Reports keys that cannot be combined with springs of pairs on slices of the face.

use crate::gear::CycleDivision;
use crate::manifest::diagnostic::DiagnosticKind;
use crate::manifest::reader::Section;
use crate::manifest::spec::{MeshSpec, ModelSpec, StiffnessSpec};

/// Records that springs on several lines cannot share the residual flexibility of omitted modes.
pub(super) fn check_residual_flexibility(
    root: &Section,
    model: Option<&ModelSpec>,
    mesh: Option<&MeshSpec>,
) {
    let (Some(model), Some(mesh)) = (model, mesh) else {
        return;
    };
    let sliced = match &mesh.stiffness {
        StiffnessSpec::Table(spec) => {
            matches!(spec.division, CycleDivision::Pairs { slices } if slices > 1)
        }
        _ => false,
    };
    if !(sliced && model.mta && model.retained < model.modes) {
        return;
    }
    if let Some(section) = root.child("model").flatten() {
        let message = "springs of pairs on several slices of the face have different lines of action, so they cannot share \
                 the residual flexibility of the omitted modes";
        section
            .fault(DiagnosticKind::Unavailable, "mta", message)
            .label("not with mesh.slices of 2 and more")
            .remedy("set mta = false, retain all modes, or set mesh.slices = 1")
            .report(section.issues);
    }
}
