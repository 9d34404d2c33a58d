//! `[gear]`: the pair according to its drawing.

use super::flank_points;
use crate::gear::{
    BasicRack, BodyShape, FaceOverhang, FlankCourse, Flanks, GearError, GearPair, Hub, Material,
    Modification, Plane, Relief, Tooth, ToothForm, Undercut, Web,
};
use crate::manifest::diagnostic::DiagnosticKind;
use crate::manifest::reader::{Section, all_of};
use std::f64::consts::FRAC_PI_2;

/// Ratio of face width to tooth thickness on the reference circle above which a face cannot widen: a usual bound of
/// cantilever plates.
const WIDE: f64 = 5.0;

pub(super) fn read(section: &Section) -> Option<GearPair> {
    let teeth = section.integers::<2>("teeth");
    let module = section.quantity("module");
    let pressure_angle = section.quantity("pressure_angle");
    let helix_angle = section.quantity("helix_angle");
    let face = face(section);
    let face_width = face.map(|face| face.width);
    let body_length = section.pair("body_length");
    let rated_torque = section.quantity("rated_torque");
    let form = form(section, body_length);
    let plane_state = plane(section, module.zip(face_width));
    let drawn = || {
        // The schema bounds the teeth far below the range of u32.
        let [pinion, wheel] = teeth?.map(u32::try_from);
        Some(GearPair {
            teeth: [pinion.ok()?, wheel.ok()?],
            module: module?,
            pressure_angle: pressure_angle?,
            helix_angle: helix_angle?,
            face_width: face_width?,
            body_length: body_length?,
            rated_torque: rated_torque?,
            form: ToothForm {
                plane: plane_state?,
                overhang: face?.overhang,
                face_middle: face?.middle,
                ..form?
            },
        })
    };
    let pair = drawn();
    let profile_points = flank_points::profiles(section, pair.as_ref());
    let lead_points = flank_points::leads(section);
    let mut pair = pair?;
    pair.form.profile_points = profile_points?;
    pair.form.lead_points = lead_points?;
    check(section, &pair)?;
    Some(pair)
}

/// The tooth form that the optional keys give; without any, it is the default form.
fn form(section: &Section, body_length: Option<[f64; 2]>) -> Option<ToothForm> {
    let profile_shift = section.pair("profile_shift");
    let thinning = section.one_or_pair("thinning");
    let centre_distance = section.if_given("centre_distance", Section::quantity);
    let tip_diameter = section.if_given("tip_diameter", Section::pair);
    warn_of_hub_length(section);
    let shape = shape(section, body_length);
    Some(ToothForm {
        profile_shift: profile_shift?,
        thinning: thinning?,
        centre_distance: centre_distance?,
        tip_diameter: tip_diameter?.map_or([None; 2], |pair| pair.map(Some)),
        ..shape?
    })
}

/// The tooth form of one gear of a train, repeated for both gears of a pair. `pair` has two such gears.
pub(super) fn of_one(
    section: &Section,
    width: Option<f64>,
    pair: Option<&GearPair>,
) -> Option<ToothForm> {
    let profile_shift = section.quantity("profile_shift");
    let thinning = section.quantity("thinning");
    let tip_diameter = section.if_given("tip_diameter", Section::quantity);
    let shape = shape(section, width.map(|width| [width; 2]));
    let profile_points = flank_points::profiles(section, pair);
    let lead_points = flank_points::leads(section);
    Some(ToothForm {
        profile_shift: [profile_shift?; 2],
        thinning: [thinning?; 2],
        tip_diameter: [tip_diameter?; 2],
        profile_points: profile_points?,
        lead_points: lead_points?,
        ..shape?
    })
}

/// The keys that `[gear]` shares with the gears of a train.
fn shape(section: &Section, body_length: Option<[f64; 2]>) -> Option<ToothForm> {
    let rack = rack(section);
    let reliefs = ["tip_relief", "root_relief", "end_relief"].map(|name| relief(section, name));
    let profile = modification(section, ["profile_crowning", "profile_slope"]);
    let lead = modification(section, ["lead_crowning", "lead_slope"]);
    let bore = section.if_given("bore", Section::one_or_pair);
    let body = bodies(section, body_length);
    let young_modulus = section.one_or_pair("young_modulus");
    let poisson_ratio = section.one_or_pair("poisson_ratio");
    let [tip_relief, root_relief, end_relief] = reliefs;
    let (young_modulus, poisson_ratio) = (young_modulus?, poisson_ratio?);
    Some(ToothForm {
        rack: rack?,
        tip_relief: tip_relief?,
        root_relief: root_relief?,
        end_relief: end_relief?,
        profile: profile?,
        lead: lead?,
        bore: bore?.map_or([None; 2], |pair| {
            pair.map(|bore| Some(bore).filter(|bore| *bore > 0.0))
        }),
        material: [0, 1].map(|gear| Material {
            young_modulus: young_modulus[gear],
            poisson_ratio: poisson_ratio[gear],
        }),
        body: body?,
        ..ToothForm::default()
    })
}

/// The common face of both gears.
#[derive(Debug, Clone, Copy)]
struct CommonFace {
    width: f64,
    /// Position from the middle of the bodies.
    middle: f64,
    overhang: [FaceOverhang; 2],
}

/// The common part of both faces.
fn face(section: &Section) -> Option<CommonFace> {
    let widths = section.one_or_pair("face_width");
    let offsets = section.one_or_pair("face_offset");
    let (widths, offsets) = (widths?, offsets?);
    let ends: [[f64; 2]; 2] =
        [0, 1].map(|gear| [-0.5, 0.5].map(|side| offsets[gear] + side * widths[gear]));
    let (from, to) = (ends[0][0].max(ends[1][0]), ends[0][1].min(ends[1][1]));
    if to <= from {
        let message = format!(
            "the faces do not overlap: the pinion's is from {} to {} mm, the wheel's from {} to {} mm",
            1e3 * ends[0][0],
            1e3 * ends[0][1],
            1e3 * ends[1][0],
            1e3 * ends[1][1]
        );
        let remedy = "give offsets from the middle of the bodies that differ by less than half the sum of the widths";
        return section
            .inconsistent("face_offset", message)
            .remedy(remedy)
            .fail(section.issues);
    }
    Some(CommonFace {
        width: to - from,
        middle: 0.5 * (from + to),
        overhang: ends.map(|[first, last]| FaceOverhang {
            before: from - first,
            behind: last - to,
        }),
    })
}

/// Plane stress or plane strain. The default depends on the face width: narrow teeth are free to widen.
fn plane(section: &Section, size: Option<(f64, f64)>) -> Option<Plane> {
    if section.has("plane") {
        return section.variant("plane");
    }
    let (module, width) = size?;
    Some(plane_of(module, width))
}

/// Plane strain for teeth that are wide compared with their module, otherwise plane stress. Lengths are in m.
pub(super) fn plane_of(module: f64, width: f64) -> Plane {
    if width > WIDE * FRAC_PI_2 * module { Plane::Strain } else { Plane::Stress }
}

/// Warns of `hub_length` without `hub_diameter`.
pub(super) fn warn_of_hub_length(section: &Section) {
    if !section.has("hub_diameter") {
        section.without_effect(
            &["hub_length"],
            "without hub_diameter",
            "remove it, or add hub_diameter",
        );
    }
}

/// Hubs and webs; `None` if a key has faults.
fn bodies(section: &Section, body_length: Option<[f64; 2]>) -> Option<[BodyShape; 2]> {
    let optional = |section: &Section, key: &str| section.if_given(key, Section::one_or_pair);
    let diameter = optional(section, "hub_diameter");
    let length = if section.has("hub_diameter") {
        optional(section, "hub_length")
    } else {
        Some(None)
    };
    let thickness = optional(section, "web_thickness");
    let rim = optional(section, "rim_diameter");
    for (one, other) in [
        ("web_thickness", "rim_diameter"),
        ("rim_diameter", "web_thickness"),
    ] {
        if section.has(one) && !section.has(other) {
            section.missing(other);
        }
    }
    let (diameter, length, thickness, rim) = (diameter?, length?, thickness?, rim?);
    let webs = thickness.zip(body_length);
    let too_thick = webs.and_then(|(web, body)| {
        (0..2)
            .find(|&gear| web[gear] > body[gear])
            .map(|gear| [web[gear], body[gear]])
    });
    if let Some(lengths) = too_thick {
        let [web, body] = lengths.map(|length| 1e3 * length);
        let what = format!("a web of {web:.3} mm is thicker than its gear body of {body:.3} mm");
        return section
            .inconsistent("web_thickness", what)
            .label("too thick")
            .remedy("make the web thinner, or remove it")
            .fail(section.issues);
    }
    let length = length.or(body_length)?;
    Some([0, 1].map(|gear| BodyShape {
        hub: diameter.map(|diameter| Hub {
            diameter: diameter[gear],
            length: length[gear],
        }),
        web: thickness.zip(rim).map(|(thickness, rim)| Web {
            thickness: thickness[gear],
            rim_diameter: rim[gear],
        }),
    }))
}

fn rack(section: &Section) -> Option<BasicRack> {
    let rack = section.child_or_empty("rack")?;
    all_of!(BasicRack {
        addendum: rack.quantity("addendum"),
        dedendum: rack.quantity("dedendum"),
        tip_radius: rack.quantity("tip_radius"),
    })
}

fn relief(section: &Section, name: &str) -> Option<[Relief; 2]> {
    let Some(relief) = section.child(name)? else {
        return Some([Relief::default(); 2]);
    };
    let amount = relief.one_or_pair("amount");
    let length = relief.one_or_pair("length");
    let course = relief.variant("course")?;
    let (amount, length) = (amount?, length?);
    Some([0, 1].map(|gear| Relief {
        amount: amount[gear],
        length: length[gear],
        course,
    }))
}

/// Crowning and slope, under these keys.
fn modification(section: &Section, keys: [&str; 2]) -> Option<[Modification; 2]> {
    let [crowning, slope] = keys.map(|key| section.one_or_pair(key));
    let (crowning, slope) = (crowning?, slope?);
    Some([0, 1].map(|gear| Modification {
        crowning: crowning[gear],
        slope: slope[gear],
    }))
}

/// Checks that a drawing with optional keys is a pair of gears that can run. Warns of undercut teeth in such
/// a pair. Bodies are checked where their compliance is needed.
fn check(section: &Section, pair: &GearPair) -> Option<()> {
    let plain = ToothForm {
        body: pair.form.body,
        plane: pair.form.plane,
        ..ToothForm::default()
    };
    let is_plain = pair.form == plain && pair.helix_angle == 0.0;
    let undercut: Vec<(usize, Tooth, Undercut)> = [0, 1]
        .into_iter()
        .filter_map(|gear| {
            let tooth = Tooth::new(pair, gear).ok()?;
            let undercut = tooth.undercut?;
            Some((gear, tooth, undercut))
        })
        .collect();
    if is_plain && undercut.is_empty() {
        return Some(());
    }
    let error = match Flanks::new(pair) {
        Ok(_) | Err(GearError::NoBore { .. } | GearError::BodyRatio { .. }) => {
            (undercut.iter()).for_each(|(gear, tooth, undercut)| {
                warn_of_undercut(section, *gear, tooth, *undercut);
            });
            return Some(());
        }
        Err(_) if is_plain => return Some(()),
        Err(error) => error,
    };
    let suspects = match error {
        GearError::OnePoint { course, .. }
        | GearError::PointOrder { course, .. }
        | GearError::PointOffFlank { course, .. } => match course {
            FlankCourse::Profile => ["profile_points"].as_slice(),
            FlankCourse::Lead => &["lead_points"],
        },
        GearError::RackTip { .. } => &["rack"],
        GearError::PointedTip { .. }
        | GearError::TipBelowForm { .. }
        | GearError::Interference { .. }
        | GearError::ContactRatio { .. }
        | GearError::TipInRoot { .. } => &["tip_diameter", "profile_shift", "rack", "teeth"],
        GearError::HelixAngle { .. } => &["helix_angle"],
        GearError::Undercut { .. } => &["profile_shift", "rack", "teeth"],
        _ => &["centre_distance", "profile_shift"],
    };
    let key = (suspects.iter().copied())
        .find(|key| section.has(key))
        .unwrap_or("teeth");
    section
        .inconsistent(key, error.to_string())
        .label("contradicts the rest of the drawing")
        .fail(section.issues)
}

/// Warns of undercut below the contact. It does not change the load, but weakens the root.
fn warn_of_undercut(
    section: &Section,
    gear: usize,
    tooth: &Tooth,
    Undercut { shift, limit }: Undercut,
) {
    let key = ["profile_shift", "thinning", "teeth"]
        .into_iter()
        .find(|key| section.has(key))
        .unwrap_or("teeth");
    let message = format!(
        "gear {} is undercut by {:.4} modules, up to a diameter of {:.4} mm, below the contact: its \
                 profile shift, thinning included, is {shift:.4}; at least {limit:.4} avoids undercut",
        gear + 1,
        limit - shift,
        2e3 * tooth.form_radius,
    );
    let remedy =
        "keep it if the drawing shows it; otherwise raise the profile shift or the number of teeth";
    section
        .fault(DiagnosticKind::Unusual, key, message)
        .label("the root of the involute is cut off")
        .remedy(remedy)
        .report(section.issues);
}
