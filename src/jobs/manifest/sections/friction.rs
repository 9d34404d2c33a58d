//! The friction of `[mesh]`: one coefficient, or a law of load, speed, oil and roughness.

use super::backlash::MeshContext;
use crate::gear::{EvenSharing, MeanFriction};
use crate::manifest::reader::Section;
use crate::manifest::spec::{FrictionSpec, StiffnessSpec, StructureSource};
use crate::manifest::tree::Value;
use std::sync::Arc;

/// Keys of the law.
const OF_LAW: [&str; 3] = ["roughness", "oil_viscosity", "oil_factor"];

/// Whether there may be friction, which needs the drawing of the gears for its direction and law.
pub(super) fn wants_gears(section: &Section) -> bool {
    let law = section.entry("friction_law").map(|entry| &entry.node.value);
    section.has("friction") || matches!(law, Some(Value::Text(law)) if law == "schlenk")
}

/// Sliding of pairs over the mesh cycle, for friction without a mesh table. An inner `None` if nothing depends on it.
/// An outer one if the drawing has faults or does not determine the sliding, which has been reported.
pub(super) fn sliding(
    section: &Section,
    mesh_context: MeshContext<'_>,
    friction: &FrictionSpec,
    stiffness: &StiffnessSpec,
) -> Option<Option<EvenSharing>> {
    if !friction.acts() || matches!(stiffness, StiffnessSpec::Table(_)) {
        return Some(None);
    }
    let Some(gears) = mesh_context.gears else {
        if !mesh_context.faulty_drawing && mesh_context.source.is_some() {
            let remedy = match mesh_context.source {
                Some(StructureSource::Train(_)) => {
                    "set mesh.friction = 0: bevel gears have no friction"
                }
                _ => "describe the gears in [gear], or set mesh.friction = 0",
            };
            let message = "friction reverses at the pitch point, which only the drawing of a pair on parallel axes \
                           determines";
            unknown(section, message.to_owned(), remedy);
        }
        return None;
    };
    let drawn = match EvenSharing::new(gears) {
        Ok(drawn) => drawn,
        Err(fault) => {
            let message =
                format!("the drawing does not determine the direction of sliding: {fault}");
            unknown(section, message, "correct [gear], or set mesh.friction = 0");
            return None;
        }
    };
    let by_law = gears.helix_angle == 0.0;
    shared_as_long(section, drawn, by_law.then_some(stiffness)).map(Some)
}

/// The load sharing `drawn`, with the contact ratio of the two-level law if the stiffness follows this law.
pub(super) fn shared_as_long(
    section: &Section,
    drawn: EvenSharing,
    stiffness: Option<&StiffnessSpec>,
) -> Option<EvenSharing> {
    let levels = matches!(
        stiffness,
        Some(StiffnessSpec::Piecewise(_) | StiffnessSpec::Continuous(_))
    );
    let contact_ratio = if levels && !section.has("values") {
        section.quantity("contact_ratio")?
    } else {
        drawn.contact_ratio
    };
    Some(EvenSharing {
        contact_ratio,
        ..drawn
    })
}

/// Reports friction of unknown direction.
fn unknown(section: &Section, message: String, remedy: &'static str) {
    let key = if section.has("friction") { "friction" } else { "friction_law" };
    section
        .inconsistent(key, message)
        .label("unknown direction")
        .remedy(remedy)
        .report(section.issues);
}

/// The friction; `None` if it or the drawing has faults, which have been reported.
pub(super) fn read(section: &Section, mesh_context: MeshContext<'_>) -> Option<FrictionSpec> {
    if section.choice("friction_law")? == "constant" {
        section.without_effect(
            &OF_LAW,
            "with a constant coefficient of friction",
            "remove it, or set friction_law = \"schlenk\"",
        );
        let value = section.quantity("friction");
        return value.map(FrictionSpec::Constant);
    }
    section.given_twice(
        &["friction"],
        "friction_law",
        "give the coefficient of friction",
    );
    let roughness = section.quantity("roughness");
    let viscosity = section.quantity("oil_viscosity");
    let oil_factor = section.quantity("oil_factor");
    let Some(gears) = mesh_context.gears else {
        if !mesh_context.faulty_drawing {
            let remedy = match mesh_context.source {
                Some(StructureSource::Train(_)) => "give mesh.friction",
                _ => "describe the gears in [gear], or give mesh.friction",
            };
            let message = "the law of friction needs the drawing of a gear pair on parallel axes";
            section
                .inconsistent("friction_law", message)
                .label("no drawing")
                .remedy(remedy)
                .report(section.issues);
        }
        return None;
    };
    Some(FrictionSpec::Mean {
        law: MeanFriction {
            roughness: roughness?,
            viscosity: viscosity?,
            oil_factor: oil_factor?,
        },
        gears: Arc::new(gears.clone()),
    })
}
