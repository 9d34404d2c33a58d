//! Mean force and friction on the flanks of the first mesh.

use crate::gear::GearError;
use crate::manifest::{PointSpec, StructureSource};
use crate::shaft::mean_forces;
use crate::structure::ModalStructure;

/// Mean force on the flanks of the first mesh \[N\]; for a modal file that of the load alone.
pub(super) fn first_force(structure: &ModalStructure, point: &PointSpec) -> f64 {
    let no_drag = structure.constant_load.is_empty() && structure.load_by_speed.is_empty();
    let load_alone = match &point.model.source {
        StructureSource::Modal(_) => true,
        StructureSource::Rigid(_) | StructureSource::Flexible(_) => no_drag,
        StructureSource::Train(_) => false,
    };
    if load_alone {
        point.load * structure.rated_force
    } else {
        mean_forces(structure, point.load, point.speed)[0]
    }
}

/// Coefficient of friction of the first mesh, at its mean force and rolling speed.
///
/// # Errors
/// Errors of the law of friction.
pub(super) fn friction(structure: &ModalStructure, point: &PointSpec) -> Result<f64, GearError> {
    let rolling = point.speed * structure.frame.rolling.abs();
    let force = first_force(structure, point);
    point.mesh.friction.coefficient(force, rolling)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::manifest;
    use crate::sweep::build;
    use std::path::Path;

    /// Two rigid shafts with the gears of `manifests/tiers/torsional.toml`.
    const TRAIN: &str = r#"
[job]
name = "pair"

[model]
kind = "train"

[train]
gears = ["z20", "z30"]
rated_torque = "50 N*m"

[[train.shaft]]
name = "pinion"
motion = "rotation"
discs = [{ at = 0, polar_inertia = "2e-3 kg*m^2" }]
gears = [{ name = "z20", at = 0, teeth = 20, module = "4 mm", width = "20 mm" }]

[[train.shaft]]
name = "wheel"
motion = "rotation"
origin = ["100 mm", 0, 0]
discs = [{ at = 0, polar_inertia = "5e-3 kg*m^2" }]
gears = [{ name = "z30", at = 0, teeth = 30, module = "4 mm", width = "20 mm" }]
output = 1
DRAG
[mesh]
half_gap = "10 um"
stiffness = "constant"
mean_stiffness = "4e8 N/m"
contact_damping = "1483 N*s/m"

[grid]
load = { values = [0.05, 0.30] }
speed = { values = ["1200 rad/s", "1400 rad/s"] }
"#;

    /// Mean forces of all points, with load and speed.
    fn forces(text: &str) -> Vec<[f64; 3]> {
        let job = manifest::parse(text, "m.toml", Path::new("")).unwrap();
        let points = (0..job.points.len()).map(|id| job.points.at(id));
        points
            .map(|point| {
                let structure = build::structure(&point.model).unwrap();
                [first_force(&structure, &point), point.load, point.speed]
            })
            .collect()
    }

    /// Drag T_d of the wheel adds `T_d/r_b2` to the force, as in a train of the same gears. Without drag the force is
    /// exactly that of the load.
    #[test]
    fn drag_of_the_wheel_adds_to_the_mean_force() {
        let [base_1, base_2] = [0.04, 0.06].map(|radius| radius * 20f64.to_radians().cos());
        for text in [
            include_str!("../../../manifests/tiers/torsional.toml"),
            include_str!("../../../manifests/tiers/flexible.toml"),
        ] {
            let dragged =
                |drag: &str| text.replace("[shafts.wheel]", &format!("[shafts.wheel]\n{drag}"));
            for [force, load, _] in forces(text) {
                assert!((force * base_1 / (50.0 * load) - 1.0).abs() < 1e-14);
            }
            for (drag, constant, viscous) in [
                ("drag_torque = \"0.7 N*m\"", 0.7, 0.0),
                ("drag = \"3e-3 N*m*s/rad\"", 0.0, 3e-3),
            ] {
                let found = forces(&dragged(drag));
                let train = forces(&TRAIN.replace("DRAG", drag));
                assert!(found.len() == 4 && train.len() == 4);
                for ([force, load, speed], of_train) in found.iter().zip(train) {
                    let torque = constant + viscous * speed * 20.0 / 30.0;
                    let exact = 50.0 * load / base_1 + torque / base_2;
                    assert!(
                        (force / exact - 1.0).abs() < 1e-10,
                        "{drag}: {force} {exact}"
                    );
                    assert_eq!([*load, *speed], of_train[1..]);
                    assert!((force / of_train[0] - 1.0).abs() < 1e-10, "{drag}");
                }
            }
        }
    }
}
