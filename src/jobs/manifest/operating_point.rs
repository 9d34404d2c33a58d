//! Are the loads and torques of the grid possible for its drives?

use super::axis::AxisKey;
use super::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use super::grid::GridAxis;
use super::spec::{StiffnessSpec, Variant};
use crate::gear::CycleDivision;

/// Reports a torque on a drive without a rated torque, and a load or torque of 0 on a mesh whose stiffness is
/// computed at the mean load.
pub(super) fn check(axes: &[GridAxis], variants: &[Variant], issues: &Issues) {
    let load = |axis: &&GridAxis| matches!(axis.axis.key, AxisKey::Load | AxisKey::Torque);
    let Some(axis) = axes.iter().find(load) else {
        return;
    };
    let name = axis.axis.name();
    let path = format!("grid.{name}");
    let has_no_rated_torque = |variant: &Variant| variant.model.source.rated_torque().is_none();
    if axis.axis.key == AxisKey::Torque && variants.iter().any(has_no_rated_torque) {
        let message = "a torque needs a rated torque, but a modal file has none";
        Diagnostic::new(DiagnosticKind::Inconsistent, axis.key_span, &path, message)
            .label("no rated torque")
            .remedy("give load, the fraction of rated_force that the mesh bears")
            .report(issues);
    }
    let tangent = |variant: &Variant| match &variant.mesh.stiffness {
        StiffnessSpec::Table(table) => !matches!(table.division, CycleDivision::Pairs { .. }),
        _ => false,
    };
    let zero = axis.axis.values.iter().position(|value| value == 0.0);
    if let Some(place) = zero.filter(|_| variants.iter().any(tangent)) {
        let message = format!(
            "`{name}` is 0, but the mesh computed from [gear] needs a mean load that presses the flanks together"
        );
        let remedy = "set mesh.resolution = \"pairs\" for a separate spring per pair of teeth, choose another \
                 mesh.stiffness, or give a small load";
        Diagnostic::new(
            DiagnosticKind::Inconsistent,
            axis.node(place).span,
            &path,
            message,
        )
        .label("no mean load")
        .remedy(remedy)
        .report(issues);
    }
}
