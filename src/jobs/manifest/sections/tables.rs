//! What of `[mesh]` kernels of dense tables do not know.

use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::reader::{Child, Section};
use crate::manifest::spec::{CoastSpec, MeshSpec, RunSpec};
use crate::manifest::tree::Value;
use crate::model::Release;
use crate::propagate::{KernelChoice, KernelSetting};

/// Whether `[run]` names a kernel of tables.
pub(super) fn are_asked_for(root: &Section) -> bool {
    let kernel = root.entry("run").and_then(|run| run.node.at("kernel"));
    let Some(Value::Text(kernel)) = kernel.map(|node| &node.value) else {
        return false;
    };
    let mut kernels = KernelChoice::SETTINGS.iter();
    kernels.any(|(name, settings)| name == kernel && settings.contains(&"cells"))
}

/// Records what the kernel of `[run]` does not know of the mesh.
pub(super) fn check_kernel(
    root: &Section,
    issues: &mut Issues,
    mesh: Option<&MeshSpec>,
    run: Option<&RunSpec>,
) {
    let (Some(mesh), Some(run)) = (mesh, run) else {
        return;
    };
    let KernelSetting::Named(kernel) = run.kernel else {
        return;
    };
    if kernel.cells().is_none() {
        return;
    }
    let Child::Present(section) = root.child(issues, "run") else {
        return;
    };
    let unknown = [
        (
            mesh.coast != CoastSpec::SameLine,
            "coast flanks with a line of action of their own",
            "not with mirrored coast flanks",
            "mesh.coast_flank = \"same_line\"",
        ),
        (
            mesh.stiffness.is_of_pairs(),
            "pairs of teeth that are springs of their own",
            "not with mesh.resolution = \"pairs\"",
            "mesh.resolution = \"mean_load\"",
        ),
        (
            mesh.stiffness.is_secant(),
            "a stiffness that varies within a segment",
            "not with mesh.resolution = \"secant\"",
            "mesh.resolution = \"mean_load\"",
        ),
        (
            mesh.release != Release::Deflection,
            "contacts that let go where their force vanishes",
            "not with mesh.release = \"force\"",
            "mesh.release = \"deflection\"",
        ),
    ];
    for (_, what, label, key) in unknown.into_iter().filter(|(asked, ..)| *asked) {
        let kernel = kernel.name();
        issues.push(
            Diagnostic::new(
                DiagnosticKind::Unavailable,
                section.span_of("kernel"),
                "run.kernel",
                format!("the tables of kernel = \"{kernel}\" do not know {what}"),
            )
            .label(label)
            .remedy(format!(
                "set {key}, or kernel = \"volterra\" or \"stepping\""
            )),
        );
    }
}
