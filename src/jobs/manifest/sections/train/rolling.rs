//! The tables `ball` and `roller` of a bearing: its catalogue data.

use crate::manifest::diagnostic::DiagnosticKind;
use crate::manifest::reader::Section;
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
    let count = own.integer("count");
    let diameter = own.quantity("diameter");
    let pitch_diameter = own.quantity("pitch_diameter");
    let contact_angle = own.quantity("contact_angle");
    let clearance = own.quantity("clearance");
    let element = if kind == "ball" {
        let conformity = own.pair("conformity");
        let young_modulus = own.quantity("young_modulus");
        let poisson_ratio = own.quantity("poisson_ratio");
        RollingElement::Ball {
            diameter: diameter?,
            conformity: conformity?,
            young_modulus: young_modulus?,
            poisson_ratio: poisson_ratio?,
        }
    } else {
        RollingElement::Roller {
            diameter: diameter?,
            length: own.quantity("length")?,
        }
    };
    let bearing = RollingBearing {
        // The schema bounds the number far below the range of u32.
        count: count?,
        pitch_diameter: pitch_diameter?,
        contact_angle: contact_angle?,
        clearance: clearance?,
        element,
    };
    if let Err(error) = bearing.law() {
        return own
            .whole_fault(DiagnosticKind::Inconsistent, error.to_string())
            .label("not a bearing")
            .fail(own.issues);
    }
    Some(Some(bearing))
}
