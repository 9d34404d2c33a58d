//! Modal files: a structure from any finite-element code. A column is a list with one entry per mode. Diagnostics are
//! those of the manifest, with places in the modal file.

mod coast;
mod contacts;
mod coupling;
mod loads;
mod oscillator;

use super::diagnostic::{DiagnosticKind, Issues, Span};
use super::modal_keys;
use super::modal_tree::ModalFile;
use super::reader::{Section, all_of};
use super::schema::{self, MODAL_FILE};
use super::sections::Context;
use super::tree::entries;
use super::tree::{self, Node, Value};
use super::{text, unknown};
use crate::structure::{BearingGain, ModalStructure, OmittedModeForces, TurningFrame};
use std::collections::HashSet;
use std::path::PathBuf;
use std::sync::Arc;

/// Largest number of modes; the kernels are meant for tens.
const MAX_MODES: usize = 1000;

/// Reads the modal file named in the manifest at `span`, once per job.
pub(super) fn load(
    issues: &Issues,
    context: &mut Context,
    file: &str,
    span: Span,
) -> Option<Arc<ModalFile>> {
    let path: PathBuf = context.base_dir.join(file);
    if let Some(known) = context.modal_files.get(&path) {
        return known.clone();
    }
    let source = text::read_named(issues, &path, "the modal file", ("model.file", span));
    let file = source.and_then(|source| parse(issues, source).map(Arc::new));
    context.modal_files.insert(path, file.clone());
    file
}

/// Adds the tree of the modal file that a manifest names to the tree of the manifest, so that its values can be
/// changed. A node that is not a table represents a file with faults.
pub(super) fn attach(tree: &mut Node, issues: &Issues, context: &mut Context) {
    let text = |path: &str| tree.at(path).map(|node| (&node.value, node.span));
    let (Some((Value::Text(kind), _)), Some((Value::Text(file), span))) =
        (text("model.kind"), text("model.file"))
    else {
        return;
    };
    if kind != "modal" {
        return;
    }
    let file = load(issues, context, file, span);
    let faulty = || Node {
        span,
        value: Value::Boolean(false),
    };
    modal_keys::attach(tree, file.map_or_else(faulty, |file| file.tree.clone()));
}

/// The structure from the tree of a modal file, whose values may differ from those in the text.
pub(super) fn of_tree(tree: &Node, issues: &Issues) -> Option<Arc<ModalStructure>> {
    read(&Section::root(tree, issues, MODAL_FILE)).map(Arc::new)
}

fn parse(issues: &Issues, source: usize) -> Option<ModalFile> {
    let before = issues.count();
    let tree = tree::parse(source, issues);
    if issues.count() > before {
        return None;
    }
    unknown::check(issues, &tree, MODAL_FILE);
    let structure = of_tree(&tree, issues)?;
    Some(ModalFile { tree, structure })
}

fn read(root: &Section) -> Option<ModalStructure> {
    let is_oscillator = oscillator::has_no_mesh(root);
    let given = |name: &str| !is_oscillator || root.has(name);
    let teeth = if given("teeth") { root.integer("teeth") } else { Some(1) };
    let wheel_teeth = root.if_given("teeth_wheel", Section::integer);
    let rated_force = if given("rated_force") { root.quantity("rated_force") } else { Some(1.0) };
    let frequency = (root.quantities("frequency", None)).map(without_round_off);
    let modes = frequency.as_ref().map(Vec::len);
    let damping = column(root, "damping", modes);
    let contacts = contacts::read(root, modes);
    let [mesh, torque] = if is_oscillator {
        let lines = oscillator::lines(root, modes, contacts.as_deref());
        lines.map_or([None, None], |lines| lines.map(Some))
    } else {
        let why = "with `mesh`: results show the deflection of the mesh";
        root.without_effect(&["displacement"], why, "remove it");
        ["mesh", "torque"]
            .map(|name| column(root, name, modes).filter(|values| acts(root, name, values)))
    };
    let mesh_tilt = optional(root, "mesh_tilt", modes);
    let friction = optional(root, "friction", modes);
    let friction_lever = optional(root, "friction_lever", modes);
    let pinion_torque = optional(root, "torque_pinion", modes);
    let wheel_torque = optional(root, "torque_wheel", modes);
    let bearings = bearings(root, modes);
    let coupling = coupling::read(root, frequency.as_deref());
    let coast = coast::read(root, mesh.as_deref(), frequency.as_deref());
    let constant_load = if_acting(root, "constant_load", modes);
    let load_by_speed = if_acting(root, "load_by_speed", modes);
    let harmonic_loads = loads::read(root, modes, teeth);
    let frequency = frequency?;
    check_frequencies(root, &frequency)?;
    check_rigid(root, &frequency)?;
    let zeros = vec![0.0; frequency.len()];
    Some(ModalStructure {
        teeth: teeth?,
        wheel_teeth: wheel_teeth?,
        frame: TurningFrame::default(),
        rated_force: rated_force?,
        frequency,
        damping: damping?,
        mesh: mesh?,
        mesh_tilt: mesh_tilt?.unwrap_or_else(|| zeros.clone()),
        torque: torque?,
        pinion_torque: pinion_torque?,
        wheel_torque: wheel_torque?,
        friction: friction?.unwrap_or_else(|| zeros.clone()),
        friction_lever: friction_lever?.unwrap_or(zeros),
        residual_flexibility: 0.0,
        tilt_residuals: Vec::new(),
        mesh_mass: None,
        coast: coast?,
        contacts: contacts?,
        bearings: bearings?,
        torques: Vec::new(),
        motions: Vec::new(),
        coupling: coupling?,
        constant_load: constant_load?,
        load_by_speed: load_by_speed?,
        harmonic_loads: harmonic_loads?,
        meshes: Vec::new(),
        shafts: Vec::new(),
        shapes: None,
    })
}

/// The tables `[[bearing]]`; empty if there are none.
fn bearings(root: &Section, modes: Option<usize>) -> Option<Vec<BearingGain>> {
    let remedy = "give every [[bearing]] a different name, such as \"pinion 1 x\"";
    report_repeated_names(&root.tables("bearing")?, "bearing forces", remedy);
    root.each("bearing", |table| {
        all_of!(BearingGain {
            name: table.text("name").map(str::to_owned),
            gain: column(table, "gain", modes),
            rate_gain: if_acting(table, "rate_gain", modes),
            left_out: Some(OmittedModeForces::default()),
        })
    })
}

/// Reports tables with the name of an earlier one: results and keys refer to tables by their names.
fn report_repeated_names(tables: &[Section], what: &str, remedy: &str) {
    let mut known = HashSet::new();
    for table in tables {
        let Some(Value::Text(name)) = table.entry("name").map(|entry| &entry.node.value) else {
            continue;
        };
        if !known.insert(name) {
            table
                .inconsistent("name", format!("two {what} have the name `{name}`"))
                .label("second time")
                .remedy(remedy)
                .report(table.issues);
        }
    }
}

/// A column with one entry per mode.
fn column(root: &Section, name: &str, modes: Option<usize>) -> Option<Vec<f64>> {
    let values = root.quantities(name, None)?;
    let modes = modes?;
    if values.len() == modes {
        return Some(values);
    }
    let message = format!(
        "`{name}` has {}, but `frequency` has {}",
        entries(values.len()),
        entries(modes)
    );
    root.inconsistent(name, message)
        .label(format!("{modes} are needed, one per mode"))
        .remedy("give every list one entry per mode, in the order of `frequency`")
        .fail(root.issues)
}

/// A column that may be absent: `Some(None)` if it is, `None` if it is faulty.
fn optional(root: &Section, name: &str, modes: Option<usize>) -> Option<Option<Vec<f64>>> {
    root.if_given(name, |root, name| column(root, name, modes))
}

/// A column; empty if it is absent or all its entries are 0.
fn if_acting(root: &Section, name: &str, modes: Option<usize>) -> Option<Vec<f64>> {
    let column = optional(root, name, modes)?;
    Some(column.filter(|values| acting(values)).unwrap_or_default())
}

/// Whether a column has an entry that is not 0.
fn acting(column: &[f64]) -> bool {
    column.iter().any(|&value| value != 0.0)
}

/// Whether a column has an entry that is not 0. Reports a column of zeros.
fn acts(root: &Section, name: &str, values: &[f64]) -> bool {
    if acting(values) {
        return true;
    }
    let what = match name {
        "mesh" => "the mesh force would act on no mode",
        "displacement" => "results would show no motion",
        _ => "the load would act on no mode",
    };
    root.inconsistent(name, format!("`{name}` is zero for every mode: {what}"))
        .label("all zero")
        .remedy(format!(
            "check the export: `{name}` needs at least one entry other than 0"
        ))
        .report(root.issues);
    false
}

/// Fraction of the highest frequency. A frequency below it is the round-off of a rigid rotation. A solver with
/// stiffnesses exact to 1e-16 has frequencies exact to 1e-8 of its highest one. This fraction is larger, because the
/// file may omit the solver's highest modes.
const ROUND_OFF: f64 = 1e-5;

/// Fraction of the highest frequency. A frequency below it can only be round-off: the error of a squared
/// frequency is at least 1e-16 of the highest square.
const UNRESOLVED: f64 = 1e-8;

/// Frequencies, with those below [`UNRESOLVED`] set to 0.
fn without_round_off(mut frequency: Vec<f64>) -> Vec<f64> {
    let least = UNRESOLVED * frequency.iter().copied().fold(0.0, f64::max);
    for omega in frequency.iter_mut().filter(|omega| omega.abs() < least) {
        *omega = 0.0;
    }
    frequency
}

/// Refuses rigid rotations whose frequency is the round-off of an eigenvalue solver. A quarter of their
/// period takes thousands of cycles, so that no motion would be seen to repeat.
fn check_rigid(root: &Section, frequency: &[f64]) -> Option<()> {
    let highest = frequency.last().copied().unwrap_or(0.0);
    let rigid = |omega: f64| omega > 0.0 && omega < ROUND_OFF * highest;
    let Some(first) = frequency.iter().position(|omega| rigid(*omega)) else {
        return Some(());
    };
    let count = frequency.iter().filter(|omega| rigid(**omega)).count();
    let (which, are) = match count {
        1 => (format!("mode {}", first + 1), "is a rigid rotation"),
        _ => (
            format!("modes {} to {}", first + 1, first + count),
            "are rigid rotations",
        ),
    };
    let message = format!(
        "{which} ({} rad/s, {:.0e} of the highest) {are} with round-off of an eigenvalue solver",
        schema::number(frequency[first]),
        frequency[first] / highest
    );
    let remedy = "give 0 for rigid rotations; a frequency below 1e-5 of the highest cannot come from a spring";
    root.inconsistent("frequency", message)
        .label("nearly 0".to_owned())
        .remedy(remedy)
        .fail(root.issues)
}

fn check_frequencies(root: &Section, frequency: &[f64]) -> Option<()> {
    let descent = frequency.windows(2).position(|pair| pair[1] < pair[0]);
    let (kind, message, label) = if frequency.is_empty() || frequency.len() > MAX_MODES {
        (
            DiagnosticKind::OutOfRange,
            format!("the file has {} modes", frequency.len()),
            format!("1 to {MAX_MODES} are accepted"),
        )
    } else if let Some(i) = descent {
        (
            DiagnosticKind::Inconsistent,
            format!(
                "frequencies must ascend, but mode {} ({}) lies below mode {} ({})",
                i + 2,
                schema::number(frequency[i + 1]),
                i + 1,
                schema::number(frequency[i])
            ),
            "not ascending".to_owned(),
        )
    } else {
        return Some(());
    };
    root.fault(kind, "frequency", message)
        .label(label)
        .remedy("sort all lists by frequency; truncation keeps the first modes")
        .fail(root.issues)
}
