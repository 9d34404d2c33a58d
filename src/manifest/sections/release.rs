//! When contacts let go, of `[mesh]`.

use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::reader::{Child, Section};
use crate::manifest::spec::{MeshSpec, RunSpec};
use crate::model::Release;

/// When contacts let go.
pub(super) fn read(section: &Section, issues: &mut Issues) -> Option<Release> {
    if !section.has("release") {
        return Some(Release::default());
    }
    Some(match section.choice(issues, "release")? {
        "force" => Release::Force,
        _ => Release::Deflection,
    })
}

/// Kernels of dense tables watch deflections only.
pub(super) fn check_kernel(
    root: &Section,
    issues: &mut Issues,
    mesh: Option<&MeshSpec>,
    run: Option<&RunSpec>,
) {
    let (Some(mesh), Some(run)) = (mesh, run) else {
        return;
    };
    if mesh.release == Release::Deflection || run.kernel.cells().is_none() {
        return;
    }
    let Child::Present(section) = root.child(issues, "run") else {
        return;
    };
    issues.push(
        Diagnostic::new(
            DiagnosticKind::Unavailable,
            section.span_of("kernel"),
            "run.kernel",
            format!(
                "the tables of kernel = \"{}\" do not know contacts that let go where their force vanishes",
                run.kernel.name()
            ),
        )
        .label("not with mesh.release = \"force\"")
        .remedy("set mesh.release = \"deflection\", or kernel = \"volterra\" or \"stepping\""),
    );
}
