//! The tables `[[contact]]`, `[[slider]]` and `[[dry_friction]]` of a modal file: contacts besides the two flanks.

use super::{column, optional, report_repeated_names};
use crate::manifest::diagnostic::DiagnosticKind;
use crate::manifest::reader::{Section, all_or_none};
use crate::manifest::sections::contact_law;
use crate::model::MOST_CONTACTS;
use crate::structure::{FrictionLaw, SliderPart, StructureContact};

/// Largest number of contacts besides the two flanks.
const MOST_FURTHER_CONTACTS: usize = MOST_CONTACTS - 2;

/// The contacts; empty if there are none.
pub(super) fn read(root: &Section, modes: Option<usize>) -> Option<Vec<StructureContact>> {
    let tables = root.tables("contact");
    let sliders = root.tables("slider");
    let frictions = root.tables("dry_friction");
    let (tables, sliders, frictions) = (tables?, sliders?, frictions?);
    let stops = tables.iter().filter(|table| table.has("restitution"));
    let elements = sliders.len() + frictions.len();
    let count = tables.len() + stops.count() + SliderPart::ALL.len() * elements;
    if count > MOST_FURTHER_CONTACTS {
        let message = format!("the file has {count} contacts in addition to the flanks");
        let label = format!(
            "at most {MOST_FURTHER_CONTACTS} are accepted, and a [[slider]] or [[dry_friction]] is three of them, a [[contact]] with a restitution two"
        );
        return root
            .fault(DiagnosticKind::OutOfRange, "contact", message)
            .label(label)
            .remedy("combine contacts that act as one, or remove some")
            .fail(root.issues);
    }
    let mut all: Vec<Option<StructureContact>> = Vec::new();
    for (tables, what, key) in [
        (&tables, "contacts", "contact.NAME.gap"),
        (&sliders, "sliders", "slider.NAME.limit"),
        (
            &frictions,
            "elements of dry friction",
            "dry_friction.NAME.force",
        ),
    ] {
        let remedy = format!("give each table its own name: keys such as {key} refer to it");
        report_repeated_names(tables, what, &remedy);
    }
    for table in &tables {
        match contact(table, modes) {
            Some((spring, Some(restitution))) => all.extend(spring.rigid(restitution).map(Some)),
            found => all.push(found.map(|(spring, _)| spring)),
        }
    }
    let sliders = sliders.iter().map(|table| slider(table, modes));
    let frictions = frictions.iter().map(|table| dry_friction(table, modes));
    for parts in sliders.chain(frictions) {
        match parts {
            Some(parts) => all.extend(parts.map(Some)),
            None => all.push(None),
        }
    }
    all_or_none(all.into_iter())
}

fn slider(table: &Section, modes: Option<usize>) -> Option<[StructureContact; 3]> {
    let name = table.text("name");
    let participation = column(table, "participation", modes);
    let stiffness = table.quantity("stiffness");
    let limit = table.quantity("limit");
    Some(StructureContact::slider(
        name?,
        &participation?,
        stiffness?,
        limit?,
    ))
}

fn dry_friction(table: &Section, modes: Option<usize>) -> Option<[StructureContact; 3]> {
    let name = table.text("name");
    let participation = column(table, "participation", modes);
    let force = table.quantity("force");
    let static_force =
        if table.has("static_force") { table.quantity("static_force") } else { force };
    let belt_speed = table.quantity("belt_speed");
    let law = FrictionLaw {
        force: force?,
        static_force: static_force?,
        belt_speed: belt_speed?,
    };
    if law.static_force < law.force {
        let key = "static_force";
        let message = format!(
            "`{}` is below the force of sliding friction",
            table.path_of(key)
        );
        return table
            .fault(DiagnosticKind::OutOfRange, key, message)
            .label(format!("at least {} N", law.force))
            .remedy("raise static_force, or remove it: it is then equal to force")
            .fail(table.issues);
    }
    let parts = StructureContact::dry_friction(name?, &participation?, law);
    Some(parts)
}

/// A contact, with the coefficient of restitution if it is a rigid stop.
fn contact(table: &Section, modes: Option<usize>) -> Option<(StructureContact, Option<f64>)> {
    let name = table.text("name");
    let participation = column(table, "participation", modes);
    let force = optional(table, "force", modes);
    let gap = table.quantity("gap");
    let law = if table.has("restitution") {
        contact_law::rigid(table, gap).map(|(law, restitution)| (law, Some(restitution)))
    } else {
        contact_law::cyclic(table, gap).map(|law| (law, None))
    };
    let cycles = table.integers::<2>("cycles");
    let (participation, (law, restitution)) = (participation?, law?);
    let structure_contact = StructureContact {
        name: name?.to_owned(),
        force: force?.unwrap_or_else(|| participation.clone()),
        tilt: Vec::new(),
        rubbing: Default::default(),
        sliding: 0.0,
        participation,
        // The schema bounds the counts far below the range of u32.
        cycles: cycles?.map(|count| count as u32),
        law,
        copies: None,
    };
    Some((structure_contact, restitution))
}
