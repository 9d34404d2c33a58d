//! `[shafts]`: material, stations, bearings and end inertias. What both shafts share
//! stands in `[shafts]`; `[shafts.pinion]` and `[shafts.wheel]` override it.

use crate::gear::GearPair;
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::reader::{Child, Section};
use crate::shaft::{Bearing, Shaft};

/// Shafts and their material.
pub(super) struct ShaftSet {
    pub shafts: [Shaft; 2],
    pub young_modulus: f64,
    pub shear_modulus: f64,
    pub density: f64,
    pub shear_coefficient: f64,
    pub elements: [usize; 3],
}

/// Timoshenko's coefficient of a solid circular section, rounded as usual in rotordynamics.
const DEFAULT_SHEAR_COEFFICIENT: f64 = 0.9;

pub(super) fn read(
    section: &Section,
    issues: &mut Issues,
    gears: Option<&GearPair>,
) -> Option<ShaftSet> {
    let young_modulus = section.quantity(issues, "young_modulus");
    let shear_modulus = section.quantity(issues, "shear_modulus");
    let density = section.quantity(issues, "density");
    let shear_coefficient =
        section.quantity_or(issues, "shear_coefficient", DEFAULT_SHEAR_COEFFICIENT);
    let elements = section.integers::<3>(issues, "elements");
    let pinion = shaft(section, issues, "pinion", gears.map(|g| g.pitch_radii()[0]));
    let wheel = shaft(section, issues, "wheel", gears.map(|g| g.pitch_radii()[1]));
    check_moduli(section, issues, young_modulus?, shear_modulus?)?;
    let [overhang, first, second] = elements?.map(usize::try_from);
    Some(ShaftSet {
        shafts: [pinion?, wheel?],
        young_modulus: young_modulus?,
        shear_modulus: shear_modulus?,
        density: density?,
        shear_coefficient: shear_coefficient?,
        elements: [overhang.ok()?, first.ok()?, second.ok()?],
    })
}

/// `ν = E/2G − 1` must lie in (−1, 1/2], else one of the two has a slip in it.
fn check_moduli(section: &Section, issues: &mut Issues, young: f64, shear: f64) -> Option<()> {
    let poisson = young / (2.0 * shear) - 1.0;
    if poisson <= 0.5 {
        return Some(());
    }
    issues.push(
        Diagnostic::new(
            DiagnosticKind::Inconsistent,
            section.span_of("shear_modulus"),
            "shafts.shear_modulus",
            format!(
                "E and G give Poisson's ratio E/(2G) - 1 = {poisson:.3}; no material exceeds 0.5"
            ),
        )
        .label("does not fit young_modulus")
        .remedy("check both units; steel has 206 GPa and 79 GPa"),
    );
    None
}

fn shaft(
    shared: &Section,
    issues: &mut Issues,
    name: &'static str,
    pitch_radius: Option<f64>,
) -> Option<Shaft> {
    let own = shared.required_child(issues, name)?;
    let diameter = own.quantity(issues, "diameter");
    let end_inertia = own.quantity(issues, "end_inertia");
    let mut either = |key: &str| {
        let section = if own.has(key) { &own } else { shared };
        section.quantity(issues, key)
    };
    let (span, overhang, gear_position) =
        (either("span"), either("overhang"), either("gear_position"));
    let bearings = bearings(shared, &own, issues);
    let diameter = diameter?;
    if pitch_radius.is_some_and(|radius| diameter >= 2.0 * radius) {
        issues.push(
            Diagnostic::new(
                DiagnosticKind::Inconsistent,
                own.span_of("diameter"),
                &own.path_of("diameter"),
                format!(
                    "the {name} shaft is as thick as its gear: the pitch diameter is {} m",
                    2.0 * pitch_radius?
                ),
            )
            .label("does not fit into the gear")
            .remedy("check the shaft's diameter, gear.module and gear.teeth"),
        );
        return None;
    }
    Some(Shaft {
        diameter,
        span: span?,
        overhang: overhang?,
        gear_position: gear_position?,
        end_inertia: end_inertia?,
        bearings: bearings?,
    })
}

fn bearings(shared: &Section, own: &Section, issues: &mut Issues) -> Option<[Bearing; 2]> {
    let common = shared.child(issues, "bearings");
    let special = own.child(issues, "bearings");
    let (common, special) = match (common, special) {
        (Child::Invalid, _) | (_, Child::Invalid) => return None,
        (Child::Absent, Child::Absent) => {
            shared.missing(issues, "bearings");
            return None;
        }
        (Child::Present(common), Child::Present(special)) => (common, Some(special)),
        (Child::Present(only), Child::Absent) | (Child::Absent, Child::Present(only)) => {
            (only, None)
        }
    };
    let pick = |key: &str| match &special {
        Some(special) if special.has(key) => special,
        _ => &common,
    };
    let line_of_centres = pick("line_of_centres").one_or_pair(issues, "line_of_centres");
    let across = pick("across").one_or_pair(issues, "across");
    let tilt = pick("tilt").one_or_pair(issues, "tilt");
    let axial = pick("axial").pair(issues, "axial");
    if axial == Some([0.0; 2]) {
        let section = pick("axial");
        issues.push(
            Diagnostic::new(
                DiagnosticKind::Inconsistent,
                section.span_of("axial"),
                &section.path_of("axial"),
                "no bearing holds the shaft in its axial direction".to_owned(),
            )
            .label("at least one must be greater than 0")
            .remedy("give the locating bearing its axial stiffness, for example [\"1e8 N/m\", 0]"),
        );
        return None;
    }
    let (line_of_centres, across, tilt, axial) = (line_of_centres?, across?, tilt?, axial?);
    Some([0, 1].map(|i| Bearing {
        line_of_centres: line_of_centres[i],
        across: across[i],
        axial: axial[i],
        tilt: tilt[i],
    }))
}
