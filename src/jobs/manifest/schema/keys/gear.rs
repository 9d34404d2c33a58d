//! `[gear]`.

use crate::manifest::schema::key::{
    ANY, Bounds, Key, Kind, NON_NEGATIVE, POSITIVE, bounds, choice, integer, key, quantity, table,
};
use crate::units::Dimension::{Angle, Length, Pressure, Ratio, Torque};
use std::f64::consts::FRAC_PI_4;

/// Poisson's ratio of a common isotropic material.
const POISSON: Bounds = bounds(0.0, false, 0.5, true);

const BOTH: &str = "pinion, wheel";

const COURSES: &[&str] = &["linear", "parabolic"];

/// Of the keys `course` of reliefs.
const COURSE: &str = "How the relief rises: in proportion to the way, or with its square.";

const GEARS: &[&str] = &["pinion", "wheel"];

const BETWEEN: &[&str] = &["linear", "monotone"];

/// Of the keys `between` of courses through points.
const BETWEEN_POINTS: &str = "What lies between the points: straight lines, or cubics with one slope on both sides of a \
                              point that rise and fall where the points do.";

#[rustfmt::skip]
pub(super) const KEYS: &[Key] = &[
    table("gear").otherwise("an error, except with kind = \"modal\"")
        .about("The pair of gears, spur or helical, as its drawing gives it. Beside a modal file it stands only where the \
                mesh is computed from it, or friction acts."),
    key("gear.teeth", Kind::List("2 integers: pinion, wheel"), ANY, "[20, 30]").of_length(2)
        .about("Numbers of teeth."),
    integer("gear.teeth.*", 5.0, 1000.0, "20"),
    quantity("gear.module", Length, POSITIVE, r#""4 mm""#)
        .about("Module, that of the normal section: of spur gears the pitch diameter by the number of teeth."),
    quantity("gear.pressure_angle", Angle, bounds(0.0, true, FRAC_PI_4, true), r#""25 deg""#).or(r#""20 deg""#)
        .about("Pressure angle of the basic rack, in the normal section."),
    quantity("gear.helix_angle", Angle, bounds(-FRAC_PI_4, true, FRAC_PI_4, true), r#""20 deg""#).or("0")
        .about("Helix angle of the pinion at its reference cylinder, positive where it is right-handed; the wheel \
                has the opposite one. 0 of spur gears."),
    quantity("gear.face_width", Length, POSITIVE, r#""20 mm""#).or_pair(BOTH)
        .about("Width of the toothed face. Flanks touch where both faces are; what a wider face stiffens beyond the other's ends \
                is not counted."),
    quantity("gear.face_offset", Length, ANY, r#""1 mm""#).or_pair(BOTH).or("0")
        .about("Where the middle of the face lies along the shaft, from the middle of the gear's body (`shafts.gear_position`), \
                positive towards the second bearing. A mesh off the middle of the bodies tilts them."),
    key("gear.body_length", Kind::List("2 lengths: pinion, wheel"), ANY, r#"["70 mm", "40 mm"]"#).of_length(2)
        .about("Axial length of the gear bodies, which may be longer than the face. It sets their mass and \
                moments of inertia and has no effect on the flanks."),
    quantity("gear.body_length.*", Length, POSITIVE, r#""70 mm""#),
    quantity("gear.hub_diameter", Length, POSITIVE, r#""40 mm""#).or_pair(BOTH)
        .otherwise("none: the shaft bends and twists as if no gear sat on it")
        .about("Diameter of the hub, the part of a gear body that bends and twists with its shaft: over the hub's \
                length the shaft is as thick as the hub. Gears that are cut into their shaft have their root circle \
                there, gears shrunk or keyed on it the diameter of their hub. Published models of this class leave it \
                out, which makes shafts too soft. Felt by kind = \"flexible\"; in the rigid tiers it is mass."),
    quantity("gear.hub_length", Length, POSITIVE, r#""50 mm""#).or_pair(BOTH).otherwise("`gear.body_length`")
        .about("Length of the hub along the shaft, in the middle of the body. It must fit between the bearings."),
    quantity("gear.web_thickness", Length, POSITIVE, r#""12 mm""#).or_pair(BOTH)
        .otherwise("a solid body, as thick as it is long")
        .about("Thickness of the web between hub (or shaft) and rim, for mass and moments of inertia. Needs `rim_diameter`."),
    quantity("gear.rim_diameter", Length, POSITIVE, r#""60 mm""#).or_pair(BOTH)
        .otherwise("none; required with `web_thickness`")
        .about("Inner diameter of the rim, which is as long as the body. Needs `web_thickness`."),
    quantity("gear.rated_torque", Torque, POSITIVE, r#""50 N*m""#)
        .about("Rated torque on the pinion; load 1 of the grid. Divided by the base radius it is the rated \
                mesh force."),
    key("gear.profile_shift", Kind::List("2 coefficients: pinion, wheel"), ANY, "[0.3, -0.1]").of_length(2).or("[0, 0]")
        .about("Profile shift coefficients in modules, positive away from the axis."),
    quantity("gear.profile_shift.*", Ratio, bounds(-5.0, false, 5.0, false), "0.3"),
    quantity("gear.thinning", Length, NON_NEGATIVE, r#""30 um""#).or_pair(BOTH).or("0")
        .about("How much thinner each tooth is along its reference circle than the profile shift makes it. \
                With it the drawing states the backlash."),
    quantity("gear.centre_distance", Length, POSITIVE, r#""100.5 mm""#)
        .otherwise("the one without backlash for the profile shifts")
        .about("Distance of the two axes. With it the drawing states the backlash and the operating pressure \
                angle."),
    key("gear.tip_diameter", Kind::List("2 lengths: pinion, wheel"), ANY, r#"["88 mm", "128 mm"]"#).of_length(2)
        .otherwise("from the rack, with its tip clearance (ISO 21771)")
        .about("Tip diameters. They end the path of contact and so set the contact ratio of a computed mesh."),
    quantity("gear.tip_diameter.*", Length, POSITIVE, r#""88 mm""#),
    quantity("gear.bore", Length, POSITIVE, r#""35 mm""#).or_pair(BOTH)
        .otherwise("the diameter of the shaft")
        .about("Diameter below which a gear body is rigid. It sets the compliance of the bodies in a computed \
                mesh, not their mass."),
    quantity("gear.young_modulus", Pressure, POSITIVE, r#""170 GPa""#).or_pair(BOTH).or(r#""206 GPa""#)
        .about("Young's modulus of the gears, for the compliance of teeth, contact and bodies in a computed mesh."),
    quantity("gear.poisson_ratio", Ratio, POISSON, "0.28").or_pair(BOTH).or("0.3")
        .about("Poisson's ratio of the gears, used like their Young's modulus."),
    table("gear.rack").otherwise("ISO 53, profile C")
        .about("Basic rack that cuts both gears, in modules."),
    quantity("gear.rack.addendum", Ratio, POSITIVE, "0.9").or("1")
        .about("Addendum of the rack, in modules."),
    quantity("gear.rack.dedendum", Ratio, POSITIVE, "1.4").or("1.25")
        .about("Dedendum of the rack, in modules: the addendum of the tool."),
    quantity("gear.rack.tip_radius", Ratio, NON_NEGATIVE, "0.25").or("0.38")
        .about("Radius of the root, in modules: that of the tool's tip. It shapes the fillet."),
    choice("gear.plane", &["stress", "strain"], r#""strain""#)
        .otherwise("\"strain\" where the face is more than five times as wide as a tooth is thick on its reference circle, else \"stress\"")
        .about("The plane state of teeth and gear bodies where the mesh is computed: free to widen across the face, or \
                held. Where they touch, flanks are in plane strain in either case."),
    table("gear.tip_relief").otherwise("no relief")
        .about("Relief that takes material off the flanks towards the tip. It needs a computed mesh to be felt, as all \
                modifications of flanks do."),
    quantity("gear.tip_relief.amount", Length, NON_NEGATIVE, r#""10 um""#).or_pair(BOTH)
        .about("Material taken off at the tip circle, normal to the flank."),
    quantity("gear.tip_relief.length", Length, POSITIVE, r#""3 mm""#).or_pair(BOTH)
        .about("Length over which the relief falls to 0, along the line of action (base radius times roll angle)."),
    choice("gear.tip_relief.course", COURSES, r#""parabolic""#).or(r#""linear""#)
        .about(COURSE),
    table("gear.root_relief").otherwise("no relief")
        .about("Relief that takes material off the flanks towards the root."),
    quantity("gear.root_relief.amount", Length, NON_NEGATIVE, r#""10 um""#).or_pair(BOTH)
        .about("Material taken off where the active profile starts, normal to the flank."),
    quantity("gear.root_relief.length", Length, POSITIVE, r#""3 mm""#).or_pair(BOTH)
        .about("Length over which the relief falls to 0, along the line of action."),
    choice("gear.root_relief.course", COURSES, r#""parabolic""#).or(r#""linear""#)
        .about(COURSE),
    table("gear.end_relief").otherwise("no relief")
        .about("Relief that takes material off the flanks towards both ends of the face."),
    quantity("gear.end_relief.amount", Length, NON_NEGATIVE, r#""10 um""#).or_pair(BOTH)
        .about("Material taken off at the ends of the face, normal to the flank."),
    quantity("gear.end_relief.length", Length, POSITIVE, r#""3 mm""#).or_pair(BOTH)
        .about("Length along the face over which the relief falls to 0."),
    choice("gear.end_relief.course", COURSES, r#""parabolic""#).or(r#""linear""#)
        .about(COURSE),
    quantity("gear.profile_crowning", Length, ANY, r#""4 um""#).or("0").or_pair(BOTH)
        .about("Crowning of the profile: material missing at the tip and where the active profile starts, with the \
                square of the distance from the middle between them."),
    quantity("gear.profile_slope", Length, ANY, r#""-3 um""#).or("0").or_pair(BOTH)
        .about("Slope of the profile, modification or deviation: how much more material is missing at the tip than \
                where the active profile starts."),
    quantity("gear.lead_crowning", Length, ANY, r#""5 um""#).or("0").or_pair(BOTH)
        .about("Crowning of the lead: material missing at both ends of the face, with the square of the distance from \
                its middle."),
    quantity("gear.lead_slope", Length, ANY, r#""6 um""#).or("0").or_pair(BOTH)
        .about("Slope of the lead, modification or deviation: how much more material is missing at the end of the face \
                on the side of positive tilt than at the other. Misalignment that belongs to the gears."),
    key("gear.profile_points", Kind::List("tables"), ANY,
        r#"[{ gear = "pinion", roll_length = ["14 mm", "18 mm", "20 mm"], missing = [0, 0, "8 um"] }]"#).or("[]")
        .about("The profile of a gear's flanks through points, drawn or measured, on top of reliefs, crowning and slope. \
                Before the first point and behind the last it stays what it is there. Every point is a kink of the mesh, \
                which costs segments: a measured course of hundreds of points is best thinned out to a few dozen."),
    table("gear.profile_points.*"),
    choice("gear.profile_points.*.gear", GEARS, r#""wheel""#)
        .about("Whose flanks they are."),
    key("gear.profile_points.*.roll_length", Kind::List("lengths"), ANY, r#"["14 mm", "18 mm", "20 mm"]"#)
        .otherwise("required without `diameter`")
        .about("Places of the points, increasing: roll lengths from the base circle, base radius times roll angle."),
    quantity("gear.profile_points.*.roll_length.*", Length, NON_NEGATIVE, r#""18 mm""#),
    key("gear.profile_points.*.diameter", Kind::List("lengths"), ANY, r#"["79 mm", "85 mm", "88 mm"]"#)
        .otherwise("required without `roll_length`")
        .about("The same places as diameters, increasing."),
    quantity("gear.profile_points.*.diameter.*", Length, POSITIVE, r#""85 mm""#),
    key("gear.profile_points.*.missing", Kind::List("lengths"), ANY, r#"[0, 0, "8 um"]"#)
        .about("Material missing at each of the points, normal to the flank; negative where there is too much."),
    quantity("gear.profile_points.*.missing.*", Length, ANY, r#""8 um""#),
    choice("gear.profile_points.*.between", BETWEEN, r#""monotone""#).or(r#""linear""#)
        .about(BETWEEN_POINTS),
    key("gear.lead_points", Kind::List("tables"), ANY,
        r#"[{ gear = "wheel", place = ["-10 mm", "6 mm", "10 mm"], missing = [0, 0, "5 um"] }]"#).or("[]")
        .about("The lead of a gear's flanks through points, on top of end relief, crowning and slope. The face is computed \
                in slices, on each of which the lead is a straight line."),
    table("gear.lead_points.*"),
    choice("gear.lead_points.*.gear", GEARS, r#""wheel""#)
        .about("Whose flanks they are."),
    key("gear.lead_points.*.place", Kind::List("lengths"), ANY, r#"["-10 mm", "6 mm", "10 mm"]"#)
        .about("Places of the points along the face, from its middle, increasing."),
    quantity("gear.lead_points.*.place.*", Length, ANY, r#""6 mm""#),
    key("gear.lead_points.*.missing", Kind::List("lengths"), ANY, r#"[0, 0, "5 um"]"#)
        .about("Material missing at each of the points, normal to the flank; negative where there is too much."),
    quantity("gear.lead_points.*.missing.*", Length, ANY, r#""5 um""#),
    choice("gear.lead_points.*.between", BETWEEN, r#""monotone""#).or(r#""linear""#)
        .about(BETWEEN_POINTS),
];
