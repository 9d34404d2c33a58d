//! What cannot be combined with springs of pairs on slices of the face?

use crate::gear::CycleDivision;
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::reader::{Child, Section};
use crate::manifest::spec::{MeshSpec, ModelSpec, StiffnessSpec};

/// Records that springs on several lines cannot share the residual flexibility of omitted modes.
pub(super) fn check_reduction(
    root: &Section,
    issues: &mut Issues,
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
    if let Child::Present(section) = root.child(issues, "model") {
        issues.push(
            Diagnostic::new(
                DiagnosticKind::Unavailable,
                section.span_of("mta"),
                "model.mta",
                "springs of pairs on several slices of the face have different lines of action, so they cannot share \
                 the residual flexibility of the omitted modes"
                    .to_owned(),
            )
            .label("not with mesh.slices of 2 and more")
            .remedy("set mta = false, retain all modes, or set mesh.slices = 1"),
        );
    }
}
