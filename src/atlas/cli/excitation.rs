//! The excitation of a drive, for `atlas check`.

use super::gear_mesh::GearMesh;
use super::point::number;
use crate::manifest::{PointSpec, StructureSource};
use crate::model::{DriveShaft, MeshHarmonic};
use crate::structure::{ModalStructure, StructureContact};
use crate::units::plural;
use serde_json::{Value, json};

/// One cause of vibration.
pub struct Cause {
    /// Text for users.
    pub text: String,
    /// Value for programs.
    pub value: Value,
}

/// Excitations of a point, in the order of the manifest's tables. A flank error that the manifest omits with
/// `excitation.table_harmonics = 0` is listed, with a note. Excitations of further contacts are listed only if
/// `structure` is known.
pub fn causes(
    point: &PointSpec,
    mesh: &GearMesh,
    structure: Option<&ModalStructure>,
) -> Vec<Cause> {
    let mut causes = Vec::new();
    if point.mesh.stiffness.varies() {
        causes.push(Cause {
            text: "stiffness variation of the mesh".to_owned(),
            value: json!({ "cause": "stiffness" }),
        });
    }
    causes.extend(flank_error(point, mesh));
    let excitation = &point.excitation;
    let of_drive = Some(&excitation.transmission_error);
    causes.extend(imposed("", "transmission_error", of_drive));
    let (whose, cause) = (" of the coast flanks", "coast_transmission_error");
    let of_coast = excitation.coast_transmission_error.as_ref();
    causes.extend(imposed(whose, cause, of_coast));
    causes.extend((excitation.torque_ripple.iter()).map(|ripple| {
        let (order, amplitude) = (ripple.order, ripple.amplitude);
        let [shaft, on] = named(point, ripple.shaft);
        Cause {
            text: format!("torque ripple on {on} (order {order}, {amplitude} N*m)"),
            value: of_shaft("torque_ripple", &shaft, order, amplitude),
        }
    }));
    causes.extend((excitation.imposed_motion.iter()).map(|motion| {
        let (order, amplitude) = (motion.order, motion.amplitude);
        let [shaft, on] = named(point, motion.shaft);
        Cause {
            text: format!(
                "motion imposed on {on} (order {order}, {} rad)",
                number(amplitude)
            ),
            value: of_shaft("imposed_motion", &shaft, order, amplitude),
        }
    }));
    causes.extend(point.mesh.teeth.iter().map(|teeth| Cause {
        text: plural(teeth.faults.len(), "faulty flank"),
        value: json!({ "cause": "tooth_fault", "count": teeth.faults.len() }),
    }));
    causes.extend(structure.and_then(further_contacts));
    if let StructureSource::Modal(structure) = &point.model.source {
        causes.extend(structure.harmonic_loads.iter().map(|load| Cause {
            text: format!(
                "harmonic load {} ({} turns per mesh cycle)",
                load.name,
                number(load.turns_per_cycle)
            ),
            value: json!({
                "cause": "harmonic_load",
                "name": load.name,
                "turns_per_cycle": load.turns_per_cycle,
            }),
        }));
    }
    causes
}

/// Varying stiffness and errors of all contacts except the flanks of the first mesh; `None` if there are
/// none.
fn further_contacts(structure: &ModalStructure) -> Option<Cause> {
    let excites = |contact: &&StructureContact| {
        let law = &contact.law;
        !law.is_constant() || !law.error.is_empty() || !law.lacking.is_empty()
    };
    let mut names: Vec<&str> = (structure.contacts.iter().filter(excites))
        .map(|contact| contact.name.as_str())
        .collect();
    names.dedup();
    (!names.is_empty()).then(|| Cause {
        text: format!(
            "stiffness or errors of further contacts ({})",
            names.join(", ")
        ),
        value: json!({ "cause": "further_contacts", "names": names }),
    })
}

/// The transmission error of the loaded flanks, computed from the drawing of the gears; `None` if it is zero
/// or if the mesh is not computed from a drawing.
fn flank_error(point: &PointSpec, mesh: &GearMesh) -> Option<Cause> {
    // If the loaded mesh could not be computed, the flank error is unknown.
    let range = (mesh.loaded.as_ref()?.as_ref()).map_or(f64::NAN, |loaded| loaded.flank_error);
    let size = format!("{:.3} µm peak to peak at load {}", 1e6 * range, point.load);
    let harmonics = point.excitation.table_harmonics;
    let text = match harmonics {
        _ if range == 0.0 => return None,
        None => format!("error of the loaded flanks ({size})"),
        Some(0) => format!(
            "without the error of the loaded flanks ({size}), which excitation.table_harmonics = 0 omits"
        ),
        Some(count) => {
            format!("the error of the loaded flanks ({size}), limited to {count} harmonics")
        }
    };
    let value = json!({
        "cause": "flank_error",
        "peak_to_peak": range,
        "load": point.load,
        "table_harmonics": harmonics,
    });
    Some(Cause { text, value })
}

/// Imposed harmonics of the transmission error; `None` if there are none.
fn imposed(whose: &str, cause: &str, errors: Option<&Vec<MeshHarmonic>>) -> Option<Cause> {
    let errors = errors.filter(|errors| !errors.is_empty())?;
    let amplitudes: Vec<f64> = errors.iter().map(|term| term.amplitude).collect();
    let sizes: Vec<String> = (amplitudes.iter())
        .map(|amplitude| format!("{:.3} µm", 1e6 * amplitude))
        .collect();
    Some(Cause {
        text: format!(
            "{} of transmission error{whose} ({})",
            plural(errors.len(), "imposed harmonic"),
            sizes.join(", ")
        ),
        value: json!({ "cause": cause, "amplitudes": amplitudes }),
    })
}

/// The key of a shaft, and its name in texts.
fn named(point: &PointSpec, shaft: DriveShaft) -> [String; 2] {
    let key = match shaft {
        DriveShaft::Pinion => "pinion",
        DriveShaft::Wheel => "wheel",
    };
    let on = match (&point.model.source, shaft) {
        (StructureSource::Train(train), DriveShaft::Pinion) => {
            format!("the driving shaft `{}`", train.shafts[train.driver].name)
        }
        (StructureSource::Train(train), DriveShaft::Wheel) => {
            format!("shaft `{}`", train.shafts[train.gears[1].shaft].name)
        }
        _ => format!("the {key} shaft"),
    };
    [key.to_owned(), on]
}

fn of_shaft(cause: &str, shaft: &str, order: f64, amplitude: f64) -> Value {
    json!({ "cause": cause, "shaft": shaft, "order": order, "amplitude": amplitude })
}
