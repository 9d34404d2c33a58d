//! `[gear]`: the pair as its drawing gives it.

use crate::gear::GearPair;
use crate::manifest::diagnostic::Issues;
use crate::manifest::reader::Section;

const DEFAULT_PRESSURE_ANGLE_DEGREES: f64 = 20.0;

pub(super) fn read(section: &Section, issues: &mut Issues) -> Option<GearPair> {
    let teeth = section.integers::<2>(issues, "teeth");
    let module = section.quantity(issues, "module");
    let pressure_angle = section.quantity_or(
        issues,
        "pressure_angle",
        DEFAULT_PRESSURE_ANGLE_DEGREES.to_radians(),
    );
    let face_width = section.quantity(issues, "face_width");
    let body_length = section.pair(issues, "body_length");
    let rated_torque = section.quantity(issues, "rated_torque");
    // The schema bounds the teeth far below the range of u32.
    let [pinion, wheel] = teeth?.map(u32::try_from);
    Some(GearPair {
        teeth: [pinion.ok()?, wheel.ok()?],
        module: module?,
        pressure_angle: pressure_angle?,
        face_width: face_width?,
        body_length: body_length?,
        rated_torque: rated_torque?,
    })
}
