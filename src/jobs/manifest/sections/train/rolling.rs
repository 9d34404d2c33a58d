//! The tables `ball` and `roller` of a bearing: its catalogue data.

use crate::manifest::diagnostic::DiagnosticKind;
use crate::manifest::reader::{Section, all_of};
use crate::shaft::{RollingBearing, RollingElement};

/// The rolling elements of a bearing, which replace the radial keys `springs`; `Some(None)` without rolling elements.
pub(super) fn read(table: &Section, springs: &[&str]) -> Option<Option<RollingBearing>> {
    let kind = if table.has("ball") { "ball" } else { "roller" };
    let Some(own) = table.child(kind)? else {
        return Some(None);
    };
    table.given_twice(springs, kind, "give the radial stiffness");
    if kind == "ball" {
        table.given_twice(&["roller"], kind, "describe the rolling elements");
    }
    let bearing = all_of!(RollingBearing {
        count: own.integer("count"),
        pitch_diameter: own.quantity("pitch_diameter"),
        contact_angle: own.quantity("contact_angle"),
        clearance: own.quantity("clearance"),
        element: if kind == "ball" {
            all_of!(RollingElement::Ball {
                diameter: own.quantity("diameter"),
                conformity: own.pair("conformity"),
                young_modulus: own.quantity("young_modulus"),
                poisson_ratio: own.quantity("poisson_ratio"),
            })
        } else {
            all_of!(RollingElement::Roller {
                diameter: own.quantity("diameter"),
                length: own.quantity("length"),
            })
        },
    })?;
    if let Err(error) = bearing.law() {
        return own
            .whole_fault(DiagnosticKind::Inconsistent, error.to_string())
            .label("not a bearing")
            .fail(own.issues);
    }
    Some(Some(bearing))
}
