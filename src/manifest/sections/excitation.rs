//! `[excitation]`: harmonics of the transmission error, torque ripple on either shaft.

use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::reader::Section;
use crate::manifest::spec::{CoastSpec, ExcitationSpec, MeshSpec, StiffnessSpec, StructureSource};
use crate::model::{DriveShaft, MeshHarmonic, StiffnessHarmonic, TorqueRipple};

pub(super) fn read(
    section: &Section,
    issues: &mut Issues,
    source: Option<&StructureSource>,
    mesh: Option<&MeshSpec>,
) -> Option<ExcitationSpec> {
    let errors = harmonics(section, issues, "transmission_error");
    const OF_COAST: &str = "coast_transmission_error";
    if mesh.is_some_and(|mesh| mesh.coast == CoastSpec::SameLine) {
        section.without_effect(
            issues,
            &[OF_COAST],
            "with mesh.coast_flank = \"same_line\"",
            "remove it, or set mesh.coast_flank = \"mirrored\"",
        );
    }
    let of_coast = match section.has(OF_COAST) {
        true => harmonics(section, issues, OF_COAST).map(Some),
        false => Some(None),
    };
    let ripples = section.tables(issues, "torque_ripple").map(|tables| {
        let read: Vec<_> = tables
            .iter()
            .map(|table| ripple(table, issues, source))
            .collect();
        read.into_iter().collect::<Option<Vec<_>>>()
    });
    if mesh.is_some_and(|mesh| !matches!(mesh.stiffness, StiffnessSpec::Table(_))) {
        section.without_effect(
            issues,
            &["table_harmonics"],
            "without a mesh table",
            "remove it, or set mesh.stiffness = \"table\"",
        );
    }
    let table_harmonics = match section.has("table_harmonics") {
        // The schema bounds it far below the range of u32.
        true => u32::try_from(section.integer(issues, "table_harmonics")?)
            .ok()
            .map(Some),
        false => Some(None),
    };
    Some(ExcitationSpec {
        table_harmonics: table_harmonics?,
        transmission_error: errors?,
        coast_transmission_error: of_coast?,
        torque_ripple: ripples??,
    })
}

/// The harmonics of a stiffness, a list of tables; none where it is absent.
pub(super) fn stiffness_harmonics(
    section: &Section,
    issues: &mut Issues,
) -> Option<Vec<StiffnessHarmonic>> {
    let tables = section.tables(issues, "stiffness_harmonics")?;
    let read: Vec<_> = (tables.iter())
        .map(|table| {
            let harmonic = table.integer(issues, "harmonic");
            let amplitude = table.quantity(issues, "amplitude");
            let phase = table.quantity_or_default(issues, "phase");
            Some(StiffnessHarmonic {
                harmonic: u32::try_from(harmonic?).ok()?,
                amplitude: amplitude?,
                phase: phase?,
            })
        })
        .collect();
    read.into_iter().collect()
}

/// The harmonics of a transmission error, a list of tables; none where it is absent.
pub(super) fn harmonics(
    section: &Section,
    issues: &mut Issues,
    name: &str,
) -> Option<Vec<MeshHarmonic>> {
    let tables = section.tables(issues, name)?;
    // Every table is read before any failure counts, so that all faults are found.
    let read: Vec<_> = tables.iter().map(|table| harmonic(table, issues)).collect();
    read.into_iter().collect()
}

fn harmonic(table: &Section, issues: &mut Issues) -> Option<MeshHarmonic> {
    let harmonic = table.integer(issues, "harmonic");
    let amplitude = table.quantity(issues, "amplitude");
    let phase = table.quantity_or_default(issues, "phase");
    Some(MeshHarmonic {
        harmonic: u32::try_from(harmonic?).ok()?,
        amplitude: amplitude?,
        phase: phase?,
    })
}

fn ripple(
    table: &Section,
    issues: &mut Issues,
    source: Option<&StructureSource>,
) -> Option<TorqueRipple> {
    let shaft = match table.choice(issues, "shaft") {
        Some("wheel") => Some(DriveShaft::Wheel),
        Some(_) => Some(DriveShaft::Pinion),
        None => None,
    };
    let order = table.quantity(issues, "order");
    let amplitude = table.quantity(issues, "amplitude");
    let phase = table.quantity_or_default(issues, "phase");
    let ripple = TorqueRipple {
        shaft: shaft?,
        order: order?,
        amplitude: amplitude?,
        phase: phase?,
    };
    if let Some(StructureSource::Modal(structure)) = source {
        let (name, columns) = match ripple.shaft {
            DriveShaft::Pinion if structure.pinion_torque.is_none() => ("pinion", "torque_pinion"),
            DriveShaft::Wheel
                if structure.wheel_torque.is_none() || structure.wheel_teeth.is_none() =>
            {
                ("wheel", "torque_wheel and teeth_wheel")
            }
            _ => return Some(ripple),
        };
        issues.push(
            Diagnostic::new(
                DiagnosticKind::Inconsistent,
                table.span_of("shaft"),
                &table.path_of("shaft"),
                format!("the modal file does not say how a torque on the {name} shaft acts"),
            )
            .label("unknown participation")
            .remedy(format!(
                "add {columns} to the modal file, or remove the ripple"
            )),
        );
        return None;
    }
    Some(ripple)
}
