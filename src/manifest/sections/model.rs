//! `[model]`: where the structure comes from, and how many of its modes are kept.

use super::{Context, gear, mesh, shafts};
use crate::gear::GearPair;
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::modal_file;
use crate::manifest::reader::{Child, Section};
use crate::manifest::spec::{ModelSpec, StructureSource};
use crate::manifest::tree::Value;
use crate::shaft::FlexibleDrive;
use std::sync::Arc;

/// Model kinds of the file format that this version does not have.
const LATER_KINDS: [(&str, &str); 4] = [
    ("torsional", LATER),
    ("translational", LATER),
    ("tilting", LATER),
    ("pedestal", LATER),
];
const LATER: &str =
    "kind = \"flexible\", or kind = \"modal\" with the modes of that model in a file";

const DEFAULT_MODES: usize = 40;
const DEFAULT_DAMPING: f64 = 0.01;

/// Every drive has two rigid rotations: the neutral one and the relative one.
const RIGID_MODES: usize = 2;
/// Degrees of freedom of a node, times two shafts.
const FREEDOMS_PER_STATION: usize = 12;

pub(super) fn read(
    root: &Section,
    issues: &mut Issues,
    context: &mut Context,
) -> Option<ModelSpec> {
    let section = root.required_child(issues, "model")?;
    let kind = section.choice(issues, "kind", None, &LATER_KINDS);
    let mta = section.boolean_or(issues, "mta", false);
    match kind {
        Some("modal") => modal(root, &section, issues, context, mta),
        // With a faulty kind the drive is read all the same: its own faults show at once.
        Some(_) => flexible(root, &section, issues, context, mta),
        None => {
            if root.has("gear") || root.has("shafts") {
                flexible(root, &section, issues, context, mta);
            }
            None
        }
    }
}

fn flexible(
    root: &Section,
    section: &Section,
    issues: &mut Issues,
    context: &mut Context,
    mta: Option<bool>,
) -> Option<ModelSpec> {
    section.without_effect(
        issues,
        &["file"],
        "with kind = \"flexible\"",
        "remove it, or set kind = \"modal\"",
    );
    let modes = section.count_or(issues, "modes", DEFAULT_MODES);
    let retained = retained(section, issues, modes, RIGID_MODES);
    let damping = section.quantity_or(issues, "damping", DEFAULT_DAMPING);
    let overrides = damping_overrides(section, issues, modes);
    let gears = root
        .required_child(issues, "gear")
        .and_then(|section| gear::read(&section, issues));
    let set = root
        .required_child(issues, "shafts")
        .and_then(|section| shafts::read(&section, issues, gears.as_ref()));
    let (gears, set, modes) = (gears?, set?, modes?);
    check_freedoms(section, issues, modes, set.elements)?;
    let drive = FlexibleDrive {
        gears,
        shafts: set.shafts,
        young_modulus: set.young_modulus,
        shear_modulus: set.shear_modulus,
        density: set.density,
        shear_coefficient: set.shear_coefficient,
        elements: set.elements,
        damping: damping?,
        damping_overrides: overrides?,
    };
    let drive = match &context.last_drive {
        Some(last) if **last == drive => Arc::clone(last),
        _ => Arc::new(drive),
    };
    context.last_drive = Some(Arc::clone(&drive));
    Some(ModelSpec {
        source: StructureSource::Flexible(drive),
        modes,
        retained: retained?,
        mta: mta?,
    })
}

fn modal(
    root: &Section,
    section: &Section,
    issues: &mut Issues,
    context: &mut Context,
    mta: Option<bool>,
) -> Option<ModelSpec> {
    let why = "with kind = \"modal\": the modal file describes the structure";
    let remedy = "remove it, or set kind = \"flexible\"";
    section.without_effect(
        issues,
        &["modes", "damping", "damping_overrides"],
        why,
        remedy,
    );
    root.without_effect(issues, &["shafts"], why, remedy);
    if !mesh_wants_gears(root, issues) {
        root.without_effect(issues, &["gear"], why, remedy);
    }
    let structure = section
        .text(issues, "file")
        .and_then(|file| modal_file::load(issues, context, file, section.span_of("file")));
    let modes = structure.as_ref().map(|structure| structure.modes());
    let retained = retained(section, issues, modes, 1);
    Some(ModelSpec {
        source: StructureSource::Modal(structure?),
        modes: modes?,
        retained: retained?,
        mta: mta?,
    })
}

/// Whether `[mesh]` takes its stiffness from the drawing of the gears.
fn mesh_wants_gears(root: &Section, issues: &mut Issues) -> bool {
    match root.child(issues, "mesh") {
        Child::Present(section) => mesh::wants_gears(&section),
        _ => false,
    }
}

/// The drawing that a mesh table needs where the structure comes from a modal file.
pub(super) fn gears_beside_modes(
    root: &Section,
    mesh: &Section,
    issues: &mut Issues,
) -> Option<GearPair> {
    let Child::Present(model) = root.child(issues, "model") else {
        return None;
    };
    let kind = model.entry("kind").map(|entry| &entry.node.value);
    let modal = matches!(kind, Some(Value::Text(kind)) if kind == "modal");
    if !(modal && mesh::wants_gears(mesh)) {
        return None;
    }
    root.required_child(issues, "gear")
        .and_then(|section| gear::read(&section, issues))
}

/// Modes kept: all of them by default, never more.
fn retained(
    section: &Section,
    issues: &mut Issues,
    modes: Option<usize>,
    least: usize,
) -> Option<usize> {
    let retained = section.count_or(issues, "retained", modes.unwrap_or(usize::MAX))?;
    let modes = modes?;
    let (message, label) = if retained > modes {
        (
            format!("`model.retained` = {retained} is more than the {modes} modes of the model"),
            format!("at most {modes}"),
        )
    } else if retained < least {
        (
            format!("`model.retained` = {retained} drops a rigid rotation of the drive"),
            format!("at least {least}"),
        )
    } else {
        return Some(retained);
    };
    issues.push(
        Diagnostic::new(
            DiagnosticKind::Inconsistent,
            section.span_of("retained"),
            "model.retained",
            message,
        )
        .label(label)
        .accepted(format!("a whole number from {least} to {modes}")),
    );
    None
}

fn damping_overrides(
    section: &Section,
    issues: &mut Issues,
    modes: Option<usize>,
) -> Option<Vec<(usize, f64)>> {
    let tables = section.tables(issues, "damping_overrides")?;
    let mut overrides: Vec<(usize, f64)> = Vec::new();
    let mut complete = true;
    for table in &tables {
        let mode = table.count(issues, "mode");
        let ratio = table.quantity(issues, "ratio");
        let (Some(mode), Some(ratio), Some(modes)) = (mode, ratio, modes) else {
            complete = false;
            continue;
        };
        let fault = if mode > modes {
            Some(format!("there is no mode {mode}: the model has {modes}"))
        } else if mode <= RIGID_MODES {
            Some(format!(
                "mode {mode} is a rigid rotation and stays undamped"
            ))
        } else if overrides.iter().any(|&(earlier, _)| earlier == mode) {
            Some(format!("mode {mode} is overridden twice"))
        } else {
            None
        };
        match fault {
            Some(message) => {
                issues.push(
                    Diagnostic::new(
                        DiagnosticKind::Inconsistent,
                        table.span_of("mode"),
                        &table.path_of("mode"),
                        message,
                    )
                    .label("no mode to override")
                    .accepted(format!(
                        "modes {} to {modes}, each once, counted from 1 in ascending frequency",
                        RIGID_MODES + 1
                    )),
                );
                complete = false;
            }
            None => overrides.push((mode, ratio)),
        }
    }
    overrides.sort_by_key(|&(mode, _)| mode);
    complete.then_some(overrides)
}

/// The beam model must have at least as many freedoms as modes are asked of it.
fn check_freedoms(
    section: &Section,
    issues: &mut Issues,
    modes: usize,
    elements: [usize; 3],
) -> Option<()> {
    let freedoms = FREEDOMS_PER_STATION * (elements.iter().sum::<usize>() + 1);
    if modes <= freedoms {
        return Some(());
    }
    issues.push(
        Diagnostic::new(
            DiagnosticKind::Inconsistent,
            section.span_of("modes"),
            "model.modes",
            format!("`model.modes` = {modes} is more than the {freedoms} degrees of freedom of the beam model"),
        )
        .label(format!("at most {freedoms}"))
        .remedy("ask for fewer modes, or raise shafts.elements"),
    );
    None
}
