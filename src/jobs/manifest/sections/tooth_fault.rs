//! `[[mesh.tooth_fault]]`: single teeth that differ from the others.

use super::backlash::MeshContext;
use super::friction::shared_as_long;
use crate::gear::{EvenSharing, FaultyTeeth, GearError, GearPair, RootCrack, ToothFault};
use crate::manifest::diagnostic::DiagnosticKind;
use crate::manifest::reader::Section;
use crate::manifest::spec::{CoastSpec, StiffnessSpec, StructureSource};
use crate::structure::MOST_BASE_CYCLES;
use std::sync::Arc;

/// The key in `[mesh]`.
const KEY: &str = "tooth_fault";

/// Reports a fault of the key in `[mesh]`.
fn refuse(mesh: &Section, message: String, remedy: &'static str) {
    let fault = mesh.inconsistent(KEY, message);
    let fault = fault.label("single teeth differ").remedy(remedy);
    fault.report(mesh.issues);
}

/// Whether the drawing is needed.
pub(super) fn wants_gears(mesh: &Section) -> bool {
    mesh.has(KEY)
}

/// The teeth; an inner `None` if all are alike, an outer one if there are faults, which have been reported. They depend
/// on the stiffness and on the line of action of the coast flanks.
pub(super) fn read(
    mesh: &Section,
    mesh_context: MeshContext<'_>,
    (stiffness, coast): (&StiffnessSpec, &CoastSpec),
) -> Option<Option<Arc<FaultyTeeth>>> {
    let tables = mesh.tables(KEY)?;
    if tables.is_empty() {
        return Some(None);
    }
    let Some(gears) = mesh_context.gears else {
        if !mesh_context.faulty_drawing && mesh_context.source.is_some() {
            let message = "faults of teeth need the drawing of a pair on parallel axes";
            let remedy = "describe the gears in [gear], or remove mesh.tooth_fault";
            refuse(mesh, message.to_owned(), remedy);
        }
        return None;
    };
    let read: Vec<_> = (tables.iter()).map(|table| fault(table, gears)).collect();
    if let Some(StructureSource::Train(train)) = mesh_context.source
        && !train.planetary.is_empty()
    {
        let message = "meshes of planets are all alike";
        refuse(mesh, message.to_owned(), "remove mesh.tooth_fault");
        return None;
    }
    let (pairs, symmetry) = match drawn(gears) {
        Ok(drawn) => drawn,
        Err(fault) => {
            let message = format!("the drawing does not determine when pairs touch: {fault}");
            let remedy = "correct [gear], or remove mesh.tooth_fault";
            refuse(mesh, message, remedy);
            return None;
        }
    };
    let straight = gears.helix_angle == 0.0;
    let teeth = FaultyTeeth {
        faults: read.into_iter().collect::<Option<_>>()?,
        teeth: gears.teeth,
        pairs: shared_as_long(mesh, pairs, straight.then_some(stiffness))?,
        symmetry: match coast {
            CoastSpec::Mirrored { symmetry } if stiffness.varies() => *symmetry,
            _ => symmetry,
        },
    };
    let cycles = teeth.base_cycles();
    if cycles > MOST_BASE_CYCLES {
        let message = format!(
            "teeth of both gears differ, so that the mesh repeats after {cycles} cycles; at most {MOST_BASE_CYCLES} are possible"
        );
        let remedy = "give faults of one gear only";
        refuse(mesh, message, remedy);
        return None;
    }
    Some(Some(Arc::new(teeth)))
}

/// The times at which pairs touch, and the phase about which coast flanks are mirror images.
fn drawn(gears: &GearPair) -> Result<(EvenSharing, f64), GearError> {
    Ok((EvenSharing::new(gears)?, gears.symmetry()?))
}

fn fault(table: &Section, gears: &GearPair) -> Option<ToothFault> {
    let gear = table.choice("gear");
    let tooth = table.integer::<u32>("tooth");
    let stiffness = table.quantity("stiffness");
    let crack = table.quantity("crack");
    let loss = table.quantity("loss");
    let flanks = table.choice("flanks");
    let gear = usize::from(gear? == "wheel");
    let number = tooth?;
    if number > gears.teeth[gear] {
        let message = format!("tooth {number} of a gear with {} teeth", gears.teeth[gear]);
        return table
            .fault(DiagnosticKind::OutOfRange, "tooth", message)
            .label("no such tooth")
            .remedy(format!("give a number from 1 to {}", gears.teeth[gear]))
            .fail(table.issues);
    }
    let (stiffness, depth, loss) = (stiffness?, crack?, loss?);
    if loss.abs() > gears.module {
        let message = "a tooth cannot lack or add more than a module";
        return table
            .fault(DiagnosticKind::OutOfRange, "loss", message.to_owned())
            .label("too much")
            .remedy("give the material along the line of action, such as \"20 um\"")
            .fail(table.issues);
    }
    let flanks = flanks?;
    let has_fault = ["drive", "coast"].map(|flank| flanks == flank || flanks == "both");
    let crack = (depth > 0.0).then(|| RootCrack::new(gears, gear, depth));
    let crack = match crack.transpose() {
        Ok(crack) => crack,
        Err(error) => {
            return table
                .fault(DiagnosticKind::Inconsistent, "crack", error.to_string())
                .label("no such crack")
                .remedy("give another depth, or correct [gear]")
                .fail(table.issues);
        }
    };
    Some(ToothFault {
        gear,
        tooth: number - 1,
        stiffness,
        cracks: has_fault.map(|present| crack.filter(|_| present)),
        missing: has_fault.map(|present| if present { loss } else { 0.0 }),
    })
}
