//! Which keys of `[shafts]` have no effect in a model kind? Such keys may be omitted, and a grid axis that varies one
//! would repeat the same point.

use super::drive_kind::DriveKind;
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind};
use crate::manifest::reader::Section;
use crate::manifest::tree::Value;
use crate::shaft::Tier;

/// Keys of `[shafts]`, or of one shaft, that have no effect in a kind; a table means all of its keys.
fn ineffective_keys(kind: DriveKind) -> &'static [&'static str] {
    match kind {
        // For a faulty kind, only keys that every kind needs are required.
        DriveKind::Rigid(Tier::Torsional) | DriveKind::Faulty => &[
            "young_modulus",
            "shear_modulus",
            "shear_coefficient",
            "elements",
            "gear_position",
            "bearings",
        ],
        DriveKind::Rigid(Tier::Translational) => &[
            "young_modulus",
            "shear_modulus",
            "shear_coefficient",
            "elements",
            "gear_position",
            "bearings.axial",
            "bearings.tilt",
        ],
        DriveKind::Rigid(Tier::Tilting | Tier::Pedestal) => &[
            "young_modulus",
            "shear_modulus",
            "shear_coefficient",
            "elements",
        ],
        DriveKind::Flexible => &[],
    }
}

/// Whether a key of `[shafts]` or of one shaft has an effect in a kind.
pub(super) fn has_effect(kind: DriveKind, key: &str) -> bool {
    !ineffective_keys(kind).iter().any(|table| {
        let rest = key.strip_prefix(table);
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    })
}

/// Warns of axes without effect.
pub(super) fn check_axes(root: &Section, kind: DriveKind) {
    let axes = root.entry("grid").map(|grid| &grid.node.value);
    let (Some(Value::Table(axes)), Some(name)) = (axes, kind.name()) else {
        return;
    };
    for axis in axes {
        let Some(key) = axis.key.strip_prefix("shafts.") else {
            continue;
        };
        let of_one = ["pinion.", "wheel."];
        let stripped = of_one.iter().find_map(|shaft| key.strip_prefix(shaft));
        if has_effect(kind, stripped.unwrap_or(key)) {
            continue;
        }
        let path = format!("grid.\"{}\"", axis.key);
        let message = format!(
            "the axis `{}` has no effect with kind = \"{name}\"",
            axis.key
        );
        Diagnostic::new(DiagnosticKind::NoEffect, axis.key_span, &path, message)
            .label("no effect with this kind")
            .remedy("remove the axis, or choose a kind with more free motions")
            .report(root.issues);
    }
}
