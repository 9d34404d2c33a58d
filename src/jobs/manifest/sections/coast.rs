//! The coast flanks of `[mesh]`: their line of action, and the phase about which they mirror the drive flanks.

use super::backlash::MeshContext;
use crate::gear::standard_symmetry;
use crate::manifest::diagnostic::DiagnosticKind;
use crate::manifest::reader::Section;
use crate::manifest::spec::{CoastSpec, FrictionSpec, StiffnessSpec, StructureSource};

/// The line of action of the coast flanks; `None` if a key, the structure or the drawing has faults, which are
/// reported. `laws` are those of the drive flanks' stiffness and friction.
pub(super) fn read(
    section: &Section,
    mesh_context: MeshContext<'_>,
    laws: Option<(&StiffnessSpec, &FrictionSpec)>,
) -> Option<CoastSpec> {
    let given = section.if_given("coast_flank", Section::choice)?;
    let unknown = matches!(
        mesh_context.source,
        Some(StructureSource::Modal(structure)) if structure.coast.is_none()
    );
    let same_line = given == Some("same_line") || (given.is_none() && unknown);
    if same_line {
        section.without_effect(
            &["coast_symmetry"],
            "because the coast flanks have the line of action of the drive flanks",
            "remove it, or set coast_flank = \"mirrored\"",
        );
        return Some(CoastSpec::SameLine);
    }
    if unknown {
        let message = "the modal file does not give the deflection of mirrored coast flanks";
        return section
            .inconsistent("coast_flank", message)
            .label("unknown participation")
            .remedy("add mesh_coast to the modal file, or set coast_flank = \"same_line\"")
            .fail(section.issues);
    }
    let symmetry = symmetry(section, mesh_context, laws)?;
    Some(CoastSpec::Mirrored { symmetry })
}

/// The mesh phase of symmetry, in cycles; 0 if nothing depends on it.
fn symmetry(
    section: &Section,
    mesh_context: MeshContext<'_>,
    laws: Option<(&StiffnessSpec, &FrictionSpec)>,
) -> Option<f64> {
    let (stiffness, friction) = laws?;
    if !stiffness.varies() && !friction.acts() {
        section.without_effect(
            &["coast_symmetry"],
            "because the stiffness does not vary and there is no friction",
            "remove it",
        );
        return Some(0.0);
    }
    if section.has("coast_symmetry") {
        return section.quantity("coast_symmetry");
    }
    if let Some(gears) = mesh_context.gears {
        let fault = match gears.symmetry() {
            Ok(symmetry) => return Some(symmetry),
            Err(fault) => fault,
        };
        unknown_symmetry(
            section,
            format!(
                "the drawing does not determine when a tooth is on the line of centres: {fault}"
            ),
        );
        return None;
    }
    if mesh_context.faulty_drawing || mesh_context.source.is_none() {
        return None;
    }
    // Harmonics have given phases, independent of the contact ratio.
    let of_levels = !matches!(stiffness, StiffnessSpec::Fourier(..));
    if of_levels && section.has("contact_ratio") {
        let contact_ratio = section.quantity("contact_ratio")?;
        return Some(standard_symmetry(contact_ratio));
    }
    unknown_symmetry(
        section,
        "`mesh.coast_symmetry` is missing: neither [gear] nor a contact ratio determines when a tooth is on the line of centres".to_owned(),
    );
    None
}

fn unknown_symmetry(section: &Section, message: String) {
    section
        .whole_fault(DiagnosticKind::MissingKey, message)
        .label("mirrored coast flanks need `coast_symmetry`")
        .accepted(section.spec("mesh.coast_symmetry").accepted())
        .remedy("add coast_symmetry, or set coast_flank = \"same_line\"")
        .report(section.issues);
}
