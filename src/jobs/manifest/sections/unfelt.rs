//! What of `[shafts]` a model kind does not feel: such keys may be left out, and an axis of the
//! grid that varies one would make the same point again and again.

use super::drive_kind::DriveKind;
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::reader::Section;
use crate::manifest::tree::Value;
use crate::shaft::Tier;

/// Keys of `[shafts]`, or of one shaft, that a kind does not feel; a table stands for all of
/// its keys.
fn unfelt(kind: DriveKind) -> &'static [&'static str] {
    match kind {
        // Of a faulty kind nothing is asked that any kind can do without.
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

/// Whether a kind feels a key of `[shafts]` or of one shaft.
pub(super) fn feels(kind: DriveKind, key: &str) -> bool {
    !unfelt(kind).iter().any(|table| {
        let rest = key.strip_prefix(table);
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    })
}

/// Records axes without effect.
pub(super) fn check_axes(root: &Section, issues: &mut Issues, kind: DriveKind) {
    let axes = root.entry("grid").map(|grid| &grid.node.value);
    let (Some(Value::Table(axes)), Some(name)) = (axes, kind.name()) else {
        return;
    };
    for axis in axes {
        let Some(key) = axis.key.strip_prefix("shafts.") else {
            continue;
        };
        let of_one = ["pinion.", "wheel."];
        let own = of_one.iter().find_map(|shaft| key.strip_prefix(shaft));
        if feels(kind, own.unwrap_or(key)) {
            continue;
        }
        let path = format!("grid.\"{}\"", axis.key);
        let message = format!(
            "the axis `{}` has no effect with kind = \"{name}\"",
            axis.key
        );
        issues.push(
            Diagnostic::new(DiagnosticKind::NoEffect, axis.key_span, &path, message)
                .label("no effect with this kind")
                .remedy("remove the axis, or choose a kind with more free motions"),
        );
    }
}
