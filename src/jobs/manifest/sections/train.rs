//! `[train]`: joins the parts of a train, which the files in this folder read.

mod housing;
mod hubs;
mod joints;
mod parts;
mod planetary;
mod rolling;
mod shaft;

use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind};
use crate::manifest::reader::Section;
use crate::manifest::sections::Context;
use crate::manifest::slip;
use crate::shaft::{TrainDrive, TrainError, TrainShaft};
use parts::Parts;

/// Tolerance for the sum of the `output` fractions of all shafts, which must be 1 unless all are 0.
const OUTPUT_SUM_TOLERANCE: f64 = 1e-9;

/// Reads the table; `[model]` has the damping of the modes.
pub(super) fn read(section: &Section, context: &mut Context) -> Option<TrainDrive> {
    let rated_torque = section.quantity("rated_torque");
    let young_modulus = section.quantity("young_modulus");
    let shear_modulus = section.quantity("shear_modulus");
    let density = section.quantity("density");
    let shear_coefficient = section.quantity("shear_coefficient");
    if !section.has("shaft") {
        section.missing("shaft");
    }
    let tables = section.tables("shaft")?;
    let (mut shafts, mut drawn) = shaft::read_all(&tables, density?)?;
    let housing = housing::read(section, context, &tables)?;
    let planets = planetary::read(section, density?, (&mut shafts, &mut drawn))?;
    let parts = Parts {
        shafts: &shafts,
        drawn: &drawn,
        planets: &planets,
    };
    let gears = parts.gears(section, "gears");
    let couplings = joints::couplings(section, &parts);
    let stops = joints::stops(section, &parts);
    let driver = if section.has("driver") {
        parts.driver(section)
    } else {
        gears.map(|[first, _]| first.shaft)
    };
    check_outputs(section, &shafts)?;
    let gears = gears?;
    let mut train = TrainDrive {
        gears,
        pair: parts.pair(gears, rated_torque?),
        meshes: Vec::new(),
        couplings: couplings?,
        stops: stops?,
        planetary: planets.iter().map(|planet| planet.set.clone()).collect(),
        housing,
        driver: driver?,
        young_modulus: young_modulus?,
        shear_modulus: shear_modulus?,
        density: density?,
        shear_coefficient: shear_coefficient?,
        damping: 0.0,
        damping_overrides: Vec::new(),
        gyroscopic: false,
        bearing_load: None,
        shafts: shafts.clone(),
    };
    if gears.iter().any(|&gear| train.gear(gear).internal) {
        let remedy = "name the mesh of the sun and a planet here, and the mesh of the ring in [[train.mesh]]";
        return section
            .inconsistent("gears", "the first mesh has an internal gear")
            .label("both gears must be external")
            .remedy(remedy)
            .fail(section.issues);
    }
    train.pair = parts.drawing(section, &train, gears, "gears")?.0;
    train.bearing_load = bearing_load(section, &train)?;
    train.meshes = joints::meshes(section, &parts, &train)?;
    // This checks all parts together and takes little time.
    if let Err(error) = train.check().and_then(|()| train.invert_backward_helices()) {
        let fault = match error {
            TrainError::TooFine { place, .. } => too_fine(&tables, &train, place, &error),
            _ => no_train(section, &error),
        };
        return fault.fail(section.issues);
    }
    Some(train)
}

/// The fault of shafts and gears that do not make a drive.
fn no_train(section: &Section, error: &TrainError) -> Diagnostic {
    let kind = DiagnosticKind::Inconsistent;
    Diagnostic::new(kind, section.span, "train", error.to_string())
        .label("these shafts and gears do not form a train")
}

/// The load at which rolling bearings have their stiffness; `Some(None)` without such bearings.
fn bearing_load(section: &Section, train: &TrainDrive) -> Option<Option<f64>> {
    if train.bearings().any(|bearing| bearing.rolling.is_some()) {
        return section.quantity("bearing_load").map(Some);
    }
    let why = "without a bearing from catalogue data";
    let remedy = "remove it, or give a bearing `ball` or `roller`";
    section.without_effect(&["bearing_load"], why, remedy);
    Some(None)
}

/// The fault of a shaft's section with too many elements, at its likely cause: an unusual length, otherwise a given
/// element length, otherwise the diameter.
fn too_fine(
    tables: &[Section],
    train: &TrainDrive,
    [shaft, section]: [usize; 2],
    error: &TrainError,
) -> Diagnostic {
    let shaft_section = &train.shafts[shaft].sections[section];
    let sections = tables[shaft].tables("sections");
    let long = slip::of_length(shaft_section.length, "length", slip::LENGTHS);
    let thin = slip::of_length(shaft_section.outer, "diameter", slip::DIAMETERS);
    let of_section = sections.as_ref().and_then(|all| all.get(section));
    let (table, key, slip) = match (of_section, train.shafts[shaft].element) {
        (Some(table), _) if long.is_some() => (table, "length", long),
        (Some(table), None) => (table, "outer", thin),
        _ => (&tables[shaft], "element", None),
    };
    let remedy =
        "lengthen the elements of the shaft (train.shaft.*.element), or merge thin sections";
    table
        .fault(DiagnosticKind::OutOfRange, key, error.to_string())
        .label("too many elements")
        .accepted("elements and degrees of freedom of all shafts: at most 4000 each")
        .remedy(slip.map_or(remedy.to_owned(), |slip| format!("{remedy}; {slip}")))
}

fn check_outputs(section: &Section, shafts: &[TrainShaft]) -> Option<()> {
    let sum: f64 = shafts.iter().map(|shaft| shaft.output).sum();
    if sum == 0.0 || (sum - 1.0).abs() < OUTPUT_SUM_TOLERANCE {
        return Some(());
    }
    let message = format!("the `output` fractions of all shafts add up to {sum}");
    section
        .inconsistent("shaft", message)
        .label("must add up to 1, or all be 0")
        .remedy("give output = 1 to the shaft of the driven machine")
        .fail(section.issues)
}
