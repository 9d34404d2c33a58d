//! The tables `ball` and `roller` of a bearing: its catalogue data.

use crate::manifest::diagnostic::DiagnosticKind;
use crate::manifest::reader::{Section, all_of};
use crate::shaft::{RollingBearing, RollingElement};

/// The rolling elements of a bearing, which replace the radial keys `springs`; `Some(None)` without rolling elements.
pub(super) fn read(table: &Section, springs: &[&str]) -> Option<Option<RollingBearing>> {
    let kind = if table.has("ball") { "ball" } else { "roller" };
    let Some(rolling_table) = table.child(kind)? else {
        return Some(None);
    };
    table.given_twice(springs, kind, "give the radial stiffness");
    if kind == "ball" {
        table.given_twice(&["roller"], kind, "describe the rolling elements");
    }
    let bearing = all_of!(RollingBearing {
        count: rolling_table.integer("count"),
        pitch_diameter: rolling_table.quantity("pitch_diameter"),
        contact_angle: rolling_table.quantity("contact_angle"),
        clearance: rolling_table.quantity("clearance"),
        element: if kind == "ball" {
            all_of!(RollingElement::Ball {
                diameter: rolling_table.quantity("diameter"),
                conformity: rolling_table.pair("conformity"),
                young_modulus: rolling_table.quantity("young_modulus"),
                poisson_ratio: rolling_table.quantity("poisson_ratio"),
            })
        } else {
            all_of!(RollingElement::Roller {
                diameter: rolling_table.quantity("diameter"),
                length: rolling_table.quantity("length"),
            })
        },
    })?;
    if let Err(error) = bearing.law() {
        return rolling_table
            .whole_fault(DiagnosticKind::Inconsistent, error.to_string())
            .label("not a bearing")
            .fail(rolling_table.issues);
    }
    Some(Some(bearing))
}
