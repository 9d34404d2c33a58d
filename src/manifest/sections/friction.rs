//! The friction of `[mesh]`: one coefficient, or a law of load, speed, oil and roughness.

use super::backlash::Surroundings;
use crate::gear::MeanFriction;
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::reader::Section;
use crate::manifest::spec::{FrictionSpec, StructureSource};
use crate::manifest::tree::Value;
use std::sync::Arc;

/// Keys of the law.
const OF_LAW: [&str; 3] = ["roughness", "oil_viscosity", "oil_factor"];

/// Whether the friction follows from the drawing of the gears.
pub(super) fn wants_gears(section: &Section) -> bool {
    let law = section.entry("friction_law").map(|entry| &entry.node.value);
    matches!(law, Some(Value::Text(law)) if law == "schlenk")
}

/// The friction; none where something of it has faults, or the drawing has, which have been reported.
pub(super) fn read(
    section: &Section,
    issues: &mut Issues,
    drive: Surroundings<'_>,
) -> Option<FrictionSpec> {
    if section.choice_or_default(issues, "friction_law")? == "constant" {
        section.without_effect(
            issues,
            &OF_LAW,
            "with a constant coefficient of friction",
            "remove it, or set friction_law = \"schlenk\"",
        );
        let value = section.quantity_or_default(issues, "friction");
        return value.map(FrictionSpec::Constant);
    }
    section.given_twice(
        issues,
        &["friction"],
        "friction_law",
        "give the coefficient of friction",
    );
    let roughness = section.quantity(issues, "roughness");
    let viscosity = section.quantity(issues, "oil_viscosity");
    let oil_factor = section.quantity_or_default(issues, "oil_factor");
    let Some(gears) = drive.gears else {
        if !drive.faulty_drawing {
            let remedy = match drive.source {
                Some(StructureSource::Train(_)) => "give mesh.friction",
                _ => "describe the gears in [gear], or give mesh.friction",
            };
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::Inconsistent,
                    section.span_of("friction_law"),
                    "mesh.friction_law",
                    "the law of friction needs the drawing of a pair on parallel axes".to_owned(),
                )
                .label("no drawing")
                .remedy(remedy),
            );
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
