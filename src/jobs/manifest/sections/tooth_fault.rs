//! `[[mesh.tooth_fault]]`: single teeth that differ from the others.

use super::backlash::Surroundings;
use super::friction::shared_as_long;
use crate::gear::{EvenSharing, FaultyTeeth, GearError, GearPair, ToothFault};
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind};
use crate::manifest::reader::Section;
use crate::manifest::spec::{CoastSpec, StiffnessSpec, StructureSource};
use crate::structure::MOST_BASE_CYCLES;
use std::sync::Arc;

/// The key.
const KEY: &str = "tooth_fault";

/// Reports a fault of the key in `[mesh]`.
fn refuse(mesh: &Section, message: String, remedy: &'static str) {
    let (span, path) = (mesh.span_of(KEY), mesh.path_of(KEY));
    let fault = Diagnostic::new(DiagnosticKind::Inconsistent, span, &path, message);
    mesh.issues
        .push(fault.label("single teeth differ").remedy(remedy));
}

/// Whether the drawing is needed.
pub(super) fn wants_gears(mesh: &Section) -> bool {
    mesh.has(KEY)
}

/// The teeth; an inner `None` if all are alike, an outer one if there are faults, which have been reported. They depend
/// on the stiffness and on the line of contact of the coast flanks.
pub(super) fn read(
    mesh: &Section,
    drive: Surroundings<'_>,
    (stiffness, coast): (&StiffnessSpec, &CoastSpec),
) -> Option<Option<Arc<FaultyTeeth>>> {
    let tables = mesh.tables(KEY)?;
    if tables.is_empty() {
        return Some(None);
    }
    let Some(gears) = drive.gears else {
        if !drive.faulty_drawing && drive.source.is_some() {
            let message = "faults of teeth need the drawing of a pair on parallel axes";
            let remedy = "describe the gears in [gear], or remove mesh.tooth_fault";
            refuse(mesh, message.to_owned(), remedy);
        }
        return None;
    };
    let read: Vec<_> = (tables.iter())
        .map(|table| fault(table, gears.teeth))
        .collect();
    if stiffness.is_of_pairs() {
        let message = "pairs of teeth that are springs of their own are all alike";
        let remedy = "remove mesh.resolution, or mesh.tooth_fault";
        refuse(mesh, message.to_owned(), remedy);
        return None;
    }
    if let Some(StructureSource::Train(train)) = drive.source
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

fn fault(table: &Section, teeth: [u32; 2]) -> Option<ToothFault> {
    let gear = table.choice("gear");
    let tooth = table.integer::<u32>("tooth");
    let stiffness = table.quantity_or_default("stiffness");
    let loss = table.quantity_or_default("loss");
    let flanks = table.choice_or_default("flanks");
    let gear = usize::from(gear? == "wheel");
    let number = tooth?;
    if number > teeth[gear] {
        let message = format!("tooth {number} of a gear with {} teeth", teeth[gear]);
        return table
            .fault(DiagnosticKind::OutOfRange, "tooth", message)
            .label("no such tooth")
            .remedy(format!("give a number from 1 to {}", teeth[gear]))
            .fail(table.issues);
    }
    let (stiffness, loss) = (stiffness?, loss?);
    if stiffness == 1.0 && loss == 0.0 {
        let message = "this tooth is like the others";
        let path = table.path_of("tooth");
        return Diagnostic::new(DiagnosticKind::Inconsistent, table.span, &path, message)
            .label("no fault")
            .remedy("give `stiffness` below 1 or a `loss`, or remove the table")
            .fail(table.issues);
    }
    let flanks = flanks?;
    Some(ToothFault {
        gear,
        tooth: number - 1,
        stiffness,
        missing: ["drive", "coast"]
            .map(|own| if flanks == own || flanks == "both" { loss } else { 0.0 }),
    })
}
