//! The force law of a one-sided contact in a modal file or in `[train]`.

use super::excitation::{harmonics, stiffness_harmonics};
use crate::manifest::diagnostic::DiagnosticKind;
use crate::manifest::reader::Section;
use crate::model::{Division, StiffnessHarmonic};
use crate::structure::ContactLaw;

/// A contact with constant stiffness and damping, and with a gap.
pub(super) fn constant(table: &Section) -> Option<ContactLaw> {
    let gap = table.quantity("gap");
    let stiffness = table.quantity("stiffness");
    let damping = table.quantity("damping");
    Some(ContactLaw {
        gap: gap?,
        damping: damping?,
        ..Division::law(&Division::levels(&[stiffness?], &[]), 0.0)
    })
}

/// A contact whose stiffness and error vary over a cycle, which may differ from the mesh cycle.
pub(in crate::manifest) fn cyclic(table: &Section, gap: Option<f64>) -> Option<ContactLaw> {
    let divisions = stiffness(table);
    let law = properties_except_stiffness(table, gap);
    let stiffness = Division::law(&divisions?, 0.0).stiffness;
    Some(ContactLaw { stiffness, ..law? })
}

/// A rigid stop: its law without a stiffness, and its coefficient of restitution.
pub(in crate::manifest) fn rigid(table: &Section, gap: Option<f64>) -> Option<(ContactLaw, f64)> {
    let others = ["stiffness", "levels", "stiffness_harmonics", "damping"];
    let what = "say how the contact returns a motion";
    table.given_twice(&others, "restitution", what);
    let law = properties_except_stiffness(table, gap);
    let restitution = table.quantity("restitution");
    Some((law?, restitution?))
}

/// The law of a contact without its stiffness: `gap`, damping, phase and error.
pub(super) fn properties_except_stiffness(table: &Section, gap: Option<f64>) -> Option<ContactLaw> {
    let damping = table.quantity("damping");
    let phase = if table.has("phase") { table.quantity("phase") } else { Some(0.0) };
    let error = harmonics(table, "transmission_error");
    Some(ContactLaw {
        gap: gap?,
        damping: damping?,
        // Whole cycles have no effect, but cost digits and time.
        phase: phase?.rem_euclid(1.0),
        error: error?,
        ..ContactLaw::default()
    })
}

/// The stiffness of a contact: one value, one value per equal part of its cycle, or a mean with harmonics.
/// With harmonics, the stiffness must stay positive.
pub(super) fn stiffness(table: &Section) -> Option<Vec<Division>> {
    if table.has("levels") {
        let others = ["stiffness", "stiffness_harmonics"];
        table.given_twice(&others, "levels", "give the stiffness over the cycle");
        let levels = table.quantities("levels", None)?;
        return if levels.is_empty() {
            let path = table.path_of("levels");
            let message = format!("`{path}` is empty, so the contact has no stiffness");
            table
                .fault(DiagnosticKind::Empty, "levels", message)
                .label("empty")
                .accepted(table.spec(&path).accepted())
                .fail(table.issues)
        } else {
            Some(Division::levels(&levels, &[]))
        };
    }
    let (_, _, divisions) = fourier(table, "stiffness")?;
    Some(divisions)
}

/// A mean stiffness, its harmonics, and the divisions of their sum, which must stay above 0. Without harmonics the
/// mean may be negative.
pub(super) fn fourier(
    table: &Section,
    mean: &str,
) -> Option<(f64, Vec<StiffnessHarmonic>, Vec<Division>)> {
    let mean = table.quantity(mean);
    let harmonics = stiffness_harmonics(table);
    let (mean, harmonics) = (mean?, harmonics?);
    let divisions = Division::fourier(mean, &harmonics);
    let smallest = (divisions.iter())
        .map(|division| division.stiffness.smallest())
        .fold(f64::INFINITY, f64::min);
    if smallest > 0.0 || (smallest < 0.0 && harmonics.is_empty()) {
        return Some((mean, harmonics, divisions));
    }
    let message = format!("the stiffness falls to {smallest:.3e} N/m");
    let remedy = "reduce the amplitudes: the stiffness must stay above 0; without harmonics it may be below 0, and softens \
             other contacts";
    table
        .inconsistent("stiffness_harmonics", message)
        .label(format!("about a mean of {mean:.3e} N/m"))
        .remedy(remedy)
        .fail(table.issues)
}
