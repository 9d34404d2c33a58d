//! The tables `[[contact]]` of a modal file: contacts beside the two flanks.

use super::{column, optional};
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::reader::Section;
use crate::manifest::sections;
use crate::model::{Division, MOST_CONTACTS};
use crate::shaft::StructureContact;

/// Contacts that may stand beside the two flanks.
const MOST: usize = MOST_CONTACTS - 2;

/// The contacts; none where there are none.
pub(super) fn read(
    root: &Section,
    issues: &mut Issues,
    modes: Option<usize>,
) -> Option<Vec<StructureContact>> {
    let tables = root.tables(issues, "contact")?;
    if tables.len() > MOST {
        issues.push(
            Diagnostic::new(
                DiagnosticKind::OutOfRange,
                root.span_of("contact"),
                "contact",
                format!("the file has {} contacts beside the flanks", tables.len()),
            )
            .label(format!("at most {MOST} are accepted"))
            .remedy("join contacts that act as one, or leave some out"),
        );
        return None;
    }
    let all: Vec<Option<StructureContact>> = tables
        .iter()
        .map(|table| contact(table, issues, modes))
        .collect();
    all.into_iter().collect()
}

fn contact(table: &Section, issues: &mut Issues, modes: Option<usize>) -> Option<StructureContact> {
    let name = table.text(issues, "name");
    let participation = column(table, issues, "participation", modes);
    let force = optional(table, issues, "force", modes);
    let gap = table.quantity(issues, "gap");
    let stiffness = stiffness(table, issues);
    let damping = table.quantity_or_default(issues, "damping");
    let cycles = match table.has("cycles") {
        true => table.integers::<2>(issues, "cycles"),
        false => Some([1, 1]),
    };
    let phase = table.quantity_or_default(issues, "phase");
    let error = sections::harmonics(table, issues, "transmission_error");
    let participation = participation?;
    Some(StructureContact {
        name: name?.to_owned(),
        force: force?.unwrap_or_else(|| participation.clone()),
        participation,
        gap: gap?,
        stiffness: (stiffness?.iter())
            .map(|division| (division.end, *division.stiffness.coefficients()))
            .collect(),
        damping: damping?,
        // The schema bounds them far below the range of u32.
        cycles: cycles?.map(|count| count as u32),
        phase: phase?,
        error: (error?.iter())
            .map(|h| (h.harmonic, h.amplitude, h.phase))
            .collect(),
    })
}

/// One stiffness, one a part of the contact's cycle, or a mean with harmonics.
fn stiffness(table: &Section, issues: &mut Issues) -> Option<Vec<Division>> {
    if table.has("levels") {
        table.without_effect(
            issues,
            &["stiffness", "stiffness_harmonics"],
            "beside `levels`, which gives every part of the cycle",
            "remove it, or remove `levels`",
        );
        let levels = table.quantities(issues, "levels", None)?;
        return match levels.is_empty() {
            true => {
                table.missing(issues, "levels");
                None
            }
            false => Some(Division::levels(&levels, &[])),
        };
    }
    let mean = table.quantity(issues, "stiffness");
    let harmonics = sections::stiffness_harmonics(table, issues);
    let (mean, harmonics) = (mean?, harmonics?);
    Some(Division::fourier(mean, &harmonics))
}
