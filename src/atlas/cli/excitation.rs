//! What excites the drive of a manifest, for `atlas check`.

use super::gear_mesh::GearMesh;
use super::point::number;
use crate::manifest::{PointSpec, StructureSource};
use crate::model::DriveShaft;
use serde_json::{Value, json};

/// One cause of vibration.
pub struct Cause {
    /// For people.
    pub text: String,
    /// For programs.
    pub value: Value,
}

/// What excites a point, in the order of the manifest's tables. What was left out on purpose is
/// among it, and says so.
pub fn causes(point: &PointSpec, mesh: &GearMesh) -> Vec<Cause> {
    let mut causes: Vec<Cause> = Vec::new();
    let mut push = |text: String, value: Value| causes.push(Cause { text, value });
    if point.mesh.stiffness.varies() {
        push(
            "stiffness variation of the mesh".to_owned(),
            json!({ "cause": "stiffness" }),
        );
    }
    if let Some(loaded) = &mesh.loaded {
        // Gears without a table are reported when they are asked for; here there is no figure.
        let range = loaded
            .as_ref()
            .map_or(f64::NAN, |loaded| loaded.flank_error);
        let size = format!("{:.3} µm peak to peak at load {}", 1e6 * range, point.load);
        let harmonics = point.excitation.table_harmonics;
        let value = json!({
            "cause": "flank_error",
            "peak_to_peak": range,
            "load": point.load,
            "table_harmonics": harmonics,
        });
        match harmonics {
            _ if range == 0.0 => {}
            None => push(format!("error of the loaded flanks ({size})"), value),
            Some(0) => push(
                format!(
                    "without the error of the loaded flanks ({size}), which excitation.table_harmonics = 0 omits"
                ),
                value,
            ),
            Some(count) => push(
                format!("the error of the loaded flanks ({size}), limited to {count} harmonics"),
                value,
            ),
        }
    }
    let imposed = [
        ("", Some(&point.excitation.transmission_error)),
        (
            " of the coast flanks",
            point.excitation.coast_transmission_error.as_ref(),
        ),
    ];
    for (whose, errors) in imposed {
        let Some(errors) = errors.filter(|errors| !errors.is_empty()) else {
            continue;
        };
        let amplitudes: Vec<f64> = errors.iter().map(|term| term.amplitude).collect();
        let sizes: Vec<String> = (amplitudes.iter())
            .map(|amplitude| format!("{:.3} µm", 1e6 * amplitude))
            .collect();
        let cause = match whose {
            "" => "transmission_error",
            _ => "coast_transmission_error",
        };
        push(
            format!(
                "{} imposed harmonic{} of transmission error{whose} ({})",
                errors.len(),
                if errors.len() == 1 { "" } else { "s" },
                sizes.join(", ")
            ),
            json!({ "cause": cause, "amplitudes": amplitudes }),
        );
    }
    for ripple in &point.excitation.torque_ripple {
        let shaft = match ripple.shaft {
            DriveShaft::Pinion => "pinion",
            DriveShaft::Wheel => "wheel",
        };
        let on = match (&point.model.source, ripple.shaft) {
            (StructureSource::Train(train), DriveShaft::Pinion) => {
                format!("the driving shaft `{}`", train.shafts[train.driver].name)
            }
            (StructureSource::Train(train), DriveShaft::Wheel) => {
                format!("shaft `{}`", train.shafts[train.gears[1].shaft].name)
            }
            _ => format!("the {shaft} shaft"),
        };
        push(
            format!(
                "torque ripple on {on} (order {}, {} N*m)",
                ripple.order, ripple.amplitude
            ),
            json!({
                "cause": "torque_ripple",
                "shaft": shaft,
                "order": ripple.order,
                "amplitude": ripple.amplitude,
            }),
        );
    }
    if let StructureSource::Modal(structure) = &point.model.source {
        for load in &structure.harmonic_loads {
            push(
                format!(
                    "harmonic load {} ({} turns per mesh cycle)",
                    load.name,
                    number(load.turns_per_cycle)
                ),
                json!({
                    "cause": "harmonic_load",
                    "name": load.name,
                    "turns_per_cycle": load.turns_per_cycle,
                }),
            );
        }
    }
    causes
}
