//! `[model]`: the source of the structure, and the number of its retained modes.

use super::drive_kind::{DriveKind, is_kind};
use super::shafts::{Elastic, ShaftSet};
use super::{
    Context, film, friction, gear, ineffective_keys, mesh, oscillator, shafts, tooth_fault, train,
};
use crate::gear::GearPair;
use crate::manifest::reader::Section;
use crate::manifest::spec::{ModelSpec, StructureSource};
use crate::manifest::{modal_file, modal_keys};
use crate::shaft::{FlexibleDrive, RigidDrive, Tier, TrainDrive};
use std::sync::Arc;

/// Default number of modes of flexible shafts.
const DEFAULT_MODES: usize = 40;

/// Number of rigid rotations of a drive of two shafts: the neutral one and the relative one.
const RIGID_MODES: usize = 2;
/// Degrees of freedom of a node (six), times two shafts.
const FREEDOMS_PER_STATION: usize = 12;

pub(super) fn read(root: &Section, context: &mut Context) -> Option<ModelSpec> {
    let section = root.required_child("model")?;
    let kind = section.choice("kind");
    let mta = section.boolean("mta");
    match kind {
        Some("modal") => modal(root, &section, context, mta),
        Some("train") => of_train(root, &section, context, mta),
        Some(name) => drive(root, &section, context, DriveKind::of(name), mta),
        None if root.has("gear") || root.has("shafts") => {
            drive(root, &section, context, DriveKind::Faulty, mta)
        }
        None => None,
    }
}

fn drive(
    root: &Section,
    section: &Section,
    context: &mut Context,
    kind: DriveKind,
    mta: Option<bool>,
) -> Option<ModelSpec> {
    if let Some(name) = kind.name() {
        section.without_effect(
            &["file", "length"],
            &format!("with kind = \"{name}\""),
            "remove it, or set kind = \"modal\"",
        );
        root.without_effect(
            &["train"],
            &format!("with kind = \"{name}\""),
            "remove it, or set kind = \"train\"",
        );
    }
    ineffective_keys::check_axes(root, kind);
    let default_modes = match kind {
        DriveKind::Rigid(tier) => tier.freedoms(),
        DriveKind::Flexible | DriveKind::Faulty => DEFAULT_MODES,
    };
    let modes = section.integer_or("modes", default_modes);
    let retained = retained(section, modes, RIGID_MODES);
    let damping = damping_of(section, kind, modes);
    let gyroscopic = gyroscopic(section, kind);
    let gears = root
        .required_child("gear")
        .and_then(|section| gear::read(&section));
    let set = root
        .required_child("shafts")
        .and_then(|section| shafts::read(&section, gears.as_ref(), kind));
    if let Some(modes) = modes {
        let elastic = set.as_ref().and_then(|set| set.elastic.as_ref());
        check_freedoms(section, modes, kind, elastic)?;
    }
    let modes = modes?;
    let source = source(kind, gears?, set?, damping?, gyroscopic?)?;
    Some(ModelSpec {
        source: context.shared(source),
        modes,
        retained: retained?,
        mta: mta?,
    })
}

/// The model of a train.
fn of_train(
    root: &Section,
    section: &Section,
    context: &mut Context,
    mta: Option<bool>,
) -> Option<ModelSpec> {
    let why = "with kind = \"train\": [train] describes the drive";
    let keys = ["file", "length"];
    section.without_effect(&keys, why, "remove it, or set kind = \"modal\"");
    let remedy = "remove it, or set kind = \"flexible\"";
    root.without_effect(&["gear", "shafts"], why, remedy);
    let gyroscopic = section.boolean("gyroscopic");
    let train = root
        .required_child("train")
        .and_then(|section| train::read(&section, context));
    let freedoms = train.as_ref().and_then(|train| train.freedoms().ok());
    let rigid = train.as_ref().map_or(1, TrainDrive::rotations);
    let default_modes = freedoms.unwrap_or(DEFAULT_MODES).min(DEFAULT_MODES);
    let modes = section.integer_or("modes", default_modes);
    let retained = retained(section, modes, rigid);
    let damping = damping(section, modes, rigid);
    let (train, modes, damping) = (train?, modes?, damping?);
    if let Some(freedoms) = freedoms.filter(|&freedoms| modes > freedoms) {
        let remedy = "reduce the number of modes, or shorten train.shaft.*.element";
        too_many_modes(section, (modes, freedoms), "train", remedy);
        return None;
    }
    let source = StructureSource::Train(Arc::new(TrainDrive {
        damping: damping.0,
        damping_overrides: damping.1,
        gyroscopic: gyroscopic?,
        ..train
    }));
    Some(ModelSpec {
        source: context.shared(source),
        modes,
        retained: retained?,
        mta: mta?,
    })
}

/// The drive that the tables describe; `None` for a faulty kind.
fn source(
    kind: DriveKind,
    gears: GearPair,
    set: ShaftSet,
    (damping, damping_overrides): (f64, Vec<(usize, f64)>),
    gyroscopic: bool,
) -> Option<StructureSource> {
    match kind {
        DriveKind::Faulty => None,
        DriveKind::Rigid(tier) => Some(StructureSource::Rigid(Arc::new(RigidDrive {
            tier,
            gears,
            shafts: set.shafts,
            pedestals: set.pedestals,
            density: set.density,
            damping,
            damping_overrides,
            gyroscopic,
        }))),
        DriveKind::Flexible => {
            let elastic = set.elastic?;
            Some(StructureSource::Flexible(Arc::new(FlexibleDrive {
                gears,
                shafts: set.shafts,
                young_modulus: elastic.young_modulus,
                shear_modulus: elastic.shear_modulus,
                density: set.density,
                shear_coefficient: elastic.shear_coefficient,
                elements: elastic.elements,
                damping,
                damping_overrides,
                gyroscopic,
            })))
        }
    }
}

fn modal(
    root: &Section,
    section: &Section,
    context: &mut Context,
    mta: Option<bool>,
) -> Option<ModelSpec> {
    let why = "with kind = \"modal\": the modal file describes the structure";
    let remedy = "remove it, or set kind = \"flexible\"";
    section.without_effect(
        &["modes", "damping", "damping_overrides", "gyroscopic"],
        why,
        remedy,
    );
    root.without_effect(&["shafts", "train"], why, remedy);
    if !mesh_wants_gears(root) {
        root.without_effect(&["gear"], why, remedy);
    }
    let structure = match modal_keys::tree(root.entries()) {
        Some(changed) => changed.and_then(|tree| modal_file::of_tree(tree, root.issues)),
        None => (section.text("file"))
            .and_then(|file| modal_file::load(root.issues, context, file, section.span_of("file")))
            .map(|file| file.structure.clone()),
    };
    if structure.is_some() && !oscillator::has_no_mesh(root, context) {
        let why = "with a mesh: tolerances are in half gaps";
        section.without_effect(&["length"], why, "remove it");
    }
    let modes = structure.as_ref().map(|structure| structure.modes());
    let rigid = structure
        .as_ref()
        .map_or(1, |structure| structure.rigid_modes().max(1));
    let retained = retained(section, modes, rigid);
    Some(ModelSpec {
        source: context.shared(StructureSource::Modal(structure?)),
        modes: modes?,
        retained: retained?,
        mta: mta?,
    })
}

/// Whether `[mesh]` needs the drawing of the gears for its stiffness, friction, film of oil or tooth faults.
fn mesh_wants_gears(root: &Section) -> bool {
    let mesh = root.child("mesh").flatten();
    mesh.is_some_and(|mesh| mesh::wants_gears(&mesh) || needs_drawing(&mesh))
}

/// Whether friction, a film of oil or a tooth fault needs the drawing.
fn needs_drawing(mesh: &Section) -> bool {
    friction::wants_gears(mesh) || film::wants_gears(mesh) || tooth_fault::wants_gears(mesh)
}

/// The drawing for a mesh table, friction, a film of oil or tooth faults if the structure comes from a modal file.
pub(super) fn gears_for_modal_file(root: &Section, mesh: &Section) -> Option<GearPair> {
    // The readers of friction, film and tooth faults report a missing drawing.
    let needed = mesh::wants_gears(mesh) || needs_drawing(mesh) && root.has("gear");
    if !(is_kind(root, "modal") && needed) {
        return None;
    }
    root.required_child("gear")
        .and_then(|section| gear::read(&section))
}

/// Whether the manifest describes gears for the mesh. If no gears result, the description has faults, which have been
/// reported. `sound` means that the model has no fault. A sound train without a drawing has bevel gears.
pub(super) fn is_drawn(root: &Section, mesh: &Section, sound: bool) -> bool {
    let in_train = root.has("train") && !sound;
    if is_kind(root, "train") {
        return in_train;
    }
    let looked_at = !is_kind(root, "modal") || mesh::wants_gears(mesh) || needs_drawing(mesh);
    root.has("gear") && looked_at || in_train
}

/// Number of retained modes: all by default, and at least the `least` modes that are rigid rotations.
fn retained(section: &Section, modes: Option<usize>, least: usize) -> Option<usize> {
    let retained = section.integer_or("retained", modes.unwrap_or(usize::MAX))?;
    let modes = modes?;
    let (message, label) = if retained > modes {
        (
            format!("`model.retained` = {retained} is more than the {modes} modes of the model"),
            format!("at most {modes}"),
        )
    } else if retained < least {
        (
            format!("`model.retained` = {retained} would drop a rigid rotation of the drive"),
            format!("at least {least}"),
        )
    } else {
        return Some(retained);
    };
    section
        .inconsistent("retained", message)
        .label(label)
        .accepted(format!("a whole number from {least} to {modes}"))
        .fail(section.issues)
}

/// Damping of the modes of a drive of two shafts.
fn damping_of(
    section: &Section,
    kind: DriveKind,
    modes: Option<usize>,
) -> Option<(f64, Vec<(usize, f64)>)> {
    if kind == DriveKind::Rigid(Tier::Torsional) {
        section.without_effect(
            &["damping", "damping_overrides"],
            "with kind = \"torsional\": both of its modes are rigid rotations and undamped",
            "remove it, or set a kind with more free motions",
        );
        let damping = section.bare().quantity("damping");
        return Some((damping?, Vec::new()));
    }
    damping(section, modes, RIGID_MODES)
}

/// Damping ratio of the elastic modes, and overrides by mode.
fn damping(
    section: &Section,
    modes: Option<usize>,
    rigid: usize,
) -> Option<(f64, Vec<(usize, f64)>)> {
    let damping = section.quantity("damping");
    let overrides = damping_overrides(section, modes, rigid);
    Some((damping?, overrides?))
}

/// Whether gyroscopic moments act, on shafts that tilt.
fn gyroscopic(section: &Section, kind: DriveKind) -> Option<bool> {
    if let DriveKind::Rigid(tier @ (Tier::Torsional | Tier::Translational)) = kind {
        section.without_effect(
            &["gyroscopic"],
            &format!("with kind = \"{}\": its shafts do not tilt", tier.name()),
            "remove it, or set a kind with more free motions",
        );
        return section.bare().boolean("gyroscopic");
    }
    section.boolean("gyroscopic")
}

fn damping_overrides(
    section: &Section,
    modes: Option<usize>,
    rigid: usize,
) -> Option<Vec<(usize, f64)>> {
    let tables = section.tables("damping_overrides")?;
    let mut overrides: Vec<(usize, f64)> = Vec::new();
    let mut complete = true;
    for table in &tables {
        let mode = table.integer("mode");
        let ratio = table.quantity("ratio");
        let (Some(mode), Some(ratio), Some(modes)) = (mode, ratio, modes) else {
            complete = false;
            continue;
        };
        let fault = if mode > modes {
            Some(format!(
                "there is no mode {mode}: the model has {modes} modes"
            ))
        } else if mode <= rigid {
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
                table
                    .inconsistent("mode", message)
                    .label("no mode to override")
                    .accepted(if modes > rigid {
                        format!(
                            "modes {} to {modes}, each once, counted from 1 in ascending frequency",
                            rigid + 1
                        )
                    } else {
                        "none: all modes are rigid rotations".to_owned()
                    })
                    .report(table.issues);
                complete = false;
            }
            None => overrides.push((mode, ratio)),
        }
    }
    overrides.sort_by_key(|&(mode, _)| mode);
    complete.then_some(overrides)
}

/// Checks that a model has at least as many freedoms as requested modes.
fn check_freedoms(
    section: &Section,
    modes: usize,
    kind: DriveKind,
    elastic: Option<&Elastic>,
) -> Option<()> {
    let (freedoms, model, remedy) = match (kind, elastic) {
        (DriveKind::Rigid(tier), _) => (
            tier.freedoms(),
            tier.name(),
            "reduce the number of modes, or remove model.modes to compute all of them",
        ),
        (DriveKind::Flexible, Some(elastic)) => (
            FREEDOMS_PER_STATION * (elastic.elements.iter().sum::<usize>() + 1),
            "beam",
            "reduce the number of modes, or raise shafts.elements",
        ),
        _ => return Some(()),
    };
    if modes <= freedoms {
        return Some(());
    }
    too_many_modes(section, (modes, freedoms), model, remedy);
    None
}

fn too_many_modes(section: &Section, (modes, freedoms): (usize, usize), model: &str, remedy: &str) {
    let message = format!(
        "`model.modes` = {modes} is more than the {freedoms} degrees of freedom of the {model} model"
    );
    section
        .inconsistent("modes", message)
        .label(format!("at most {freedoms}"))
        .remedy(remedy)
        .report(section.issues);
}
