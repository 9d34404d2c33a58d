//! The keys of the table `[gear]`.

use crate::manifest::schema::key::{
    ANY, Bounds, Key, Kind, NON_NEGATIVE, POSITIVE, bounds, choice, integer, key, quantity, table,
};
use crate::units::Dimension::{Angle, Length, Pressure, Ratio, Torque};
use std::f64::consts::FRAC_PI_4;

/// Poisson's ratio of a common isotropic material.
const POISSON: Bounds = bounds(0.0, false, 0.5, true);

const BOTH: &str = "pinion, wheel";

const COURSES: &[&str] = &["linear", "parabolic"];

/// Description of the keys `course` of reliefs.
const COURSE: &str = "Shape of the relief: in proportion to the distance, or to its square.";

const GEARS: &[&str] = &["pinion", "wheel"];

const BETWEEN: &[&str] = &["linear", "monotone"];

/// Description of the keys `between` of courses through points.
const BETWEEN_POINTS: &str = "Curve between the points: straight lines, or monotone cubics. The cubics have a \
                              continuous slope and no extremes between the points.";

#[rustfmt::skip]
pub(super) const KEYS: &[Key] = &[
    table("gear").otherwise("an error, except with kind = \"modal\"")
        .about("The pair of gears, spur or helical, as its drawing gives it. With a modal file it is needed only if \
                the mesh is computed from it or friction acts."),
    key("gear.teeth", Kind::List("2 integers: pinion, wheel"), ANY, "[20, 30]").of_length(2)
        .about("Numbers of teeth."),
    integer("gear.teeth.*", 5.0, 1000.0, "20"),
    quantity("gear.module", Length, POSITIVE, r#""4 mm""#)
        .about("Module in the normal section. For spur gears it is the pitch diameter divided by the number of teeth."),
    quantity("gear.pressure_angle", Angle, bounds(0.0, true, FRAC_PI_4, true), r#""25 deg""#).or(r#""20 deg""#)
        .about("Pressure angle of the basic rack, in the normal section."),
    quantity("gear.helix_angle", Angle, bounds(-FRAC_PI_4, true, FRAC_PI_4, true), r#""20 deg""#).or("0")
        .about("Helix angle of the pinion at its reference cylinder, positive if right-handed. The wheel has the \
                opposite angle. Spur gears have 0."),
    quantity("gear.face_width", Length, POSITIVE, r#""20 mm""#).or_pair(BOTH)
        .about("Width of the toothed face. Flanks touch where both faces overlap. The stiffening by the wider face \
                beyond the overlap is neglected."),
    quantity("gear.face_offset", Length, ANY, r#""1 mm""#).or_pair(BOTH).or("0")
        .about("Position of the middle of the face along the shaft, from the middle of the gear body \
                (`shafts.gear_position`). It is positive towards the second bearing. A mesh off the middle tilts the \
                bodies."),
    key("gear.body_length", Kind::List("2 lengths: pinion, wheel"), ANY, r#"["70 mm", "40 mm"]"#).of_length(2)
        .about("Axial length of the gear bodies, which may exceed the face width. It determines their mass and \
                moments of inertia. It does not affect the flanks."),
    quantity("gear.body_length.*", Length, POSITIVE, r#""70 mm""#),
    quantity("gear.hub_diameter", Length, POSITIVE, r#""40 mm""#).on_one_gear().or_pair(BOTH)
        .otherwise("none: the gear does not stiffen the shaft")
        .about("Diameter of the hub. The hub is the part of a gear body that bends and twists with the shaft. Over \
                the length of the hub, the shaft has this diameter. For a gear cut into its shaft, give the diameter \
                of the root circle. For a gear shrunk or keyed on, give the diameter of its hub. Published models of \
                this kind omit the hub, so their shafts are too soft. With kind = \"flexible\", the hub stiffens the \
                shaft; with rigid kinds, it only adds mass. In a train, the hub stiffens the sections of the shaft; \
                planets, rings, loose gears and shafts without sections have none."),
    quantity("gear.hub_length", Length, POSITIVE, r#""50 mm""#).on_one_gear().or_pair(BOTH)
        .otherwise("`gear.body_length`; in a train the gear's `width`")
        .about("Length of the hub along the shaft, centred on the body. It must fit between the bearings; in a train, on the sections \
                of its shaft."),
    quantity("gear.web_thickness", Length, POSITIVE, r#""12 mm""#).on_one_gear().or_pair(BOTH)
        .otherwise("a solid body as thick as it is long")
        .about("Thickness of the web between hub (or shaft) and rim, for mass and moments of inertia. Needs `rim_diameter`."),
    quantity("gear.rim_diameter", Length, POSITIVE, r#""60 mm""#).on_one_gear().or_pair(BOTH)
        .otherwise("none; required with `web_thickness`")
        .about("Inner diameter of the rim. The rim is as long as the body. Needs `web_thickness`."),
    quantity("gear.rated_torque", Torque, POSITIVE, r#""50 N*m""#)
        .about("Rated torque on the pinion, which is load 1 of the grid. Divided by the base radius, it gives the \
                rated mesh force."),
    key("gear.profile_shift", Kind::List("2 coefficients: pinion, wheel"), ANY, "[0.3, -0.1]").of_length(2).or("[0, 0]")
        .about("Profile shift coefficients, in modules. A positive shift makes the teeth thicker: it is away from the axis \
                for external gears, towards it for a ring (ISO 21771)."),
    quantity("gear.profile_shift.*", Ratio, bounds(-5.0, false, 5.0, false), "0.3"),
    quantity("gear.thinning", Length, NON_NEGATIVE, r#""30 um""#).or_pair(BOTH).or("0")
        .about("Reduction of tooth thickness along the reference circle, relative to the thickness that the profile \
                shift gives. With it, the drawing determines the backlash."),
    quantity("gear.centre_distance", Length, POSITIVE, r#""100.5 mm""#)
        .otherwise("the distance without backlash for the profile shifts")
        .about("Distance between the two axes. With it, the drawing determines the backlash and the operating \
                pressure angle."),
    key("gear.tip_diameter", Kind::List("2 lengths: pinion, wheel"), ANY, r#"["88 mm", "128 mm"]"#).of_length(2)
        .otherwise("from the rack, with its tip clearance (ISO 21771)")
        .about("Tip diameters. They limit the path of contact and thus determine the contact ratio of a computed mesh."),
    quantity("gear.tip_diameter.*", Length, POSITIVE, r#""88 mm""#),
    quantity("gear.bore", Length, POSITIVE, r#""35 mm""#).on_one_gear().or_pair(BOTH)
        .otherwise("the diameter of the shaft")
        .about("Diameter below which a gear body is rigid. It sets the compliance of the bodies in a computed mesh, \
                not their mass."),
    quantity("gear.young_modulus", Pressure, POSITIVE, r#""170 GPa""#).on_one_gear().or_pair(BOTH).or(r#""206 GPa""#)
        .about("Young's modulus of the gears, for the compliance of teeth, contact and bodies in a computed mesh."),
    quantity("gear.poisson_ratio", Ratio, POISSON, "0.28").on_one_gear().or_pair(BOTH).or("0.3")
        .about("Poisson's ratio of the gears, for the compliance of teeth, contact and bodies in a computed mesh."),
    table("gear.rack").on_one_gear().otherwise("ISO 53, profile A")
        .about("Basic rack that cuts both gears, in modules."),
    quantity("gear.rack.addendum", Ratio, POSITIVE, "0.9").on_one_gear().or("1")
        .about("Addendum of the rack, in modules."),
    quantity("gear.rack.dedendum", Ratio, POSITIVE, "1.4").on_one_gear().or("1.25")
        .about("Dedendum of the rack, in modules. It equals the addendum of the tool."),
    quantity("gear.rack.tip_radius", Ratio, NON_NEGATIVE, "0.25").on_one_gear().or("0.38")
        .about("Radius of the rack's fillet, in modules. It equals the tip radius of the tool and shapes the tooth fillet."),
    choice("gear.plane", &["stress", "strain"], r#""strain""#)
        .otherwise("\"strain\" if the face is wider than five tooth thicknesses on the reference circle, otherwise \"stress\"")
        .about("Plane state of teeth and gear bodies in a computed mesh: plane stress (free to widen across the face) \
                or plane strain. The contact between flanks is always in plane strain."),
    table("gear.tip_relief").on_one_gear().otherwise("no relief")
        .about("Relief that removes material from the flanks towards the tip. Like all flank modifications, it only \
                affects a mesh computed from [gear]."),
    quantity("gear.tip_relief.amount", Length, NON_NEGATIVE, r#""10 um""#).on_one_gear().or_pair(BOTH)
        .about("Material removed at the tip circle, normal to the flank."),
    quantity("gear.tip_relief.length", Length, POSITIVE, r#""3 mm""#).on_one_gear().or_pair(BOTH)
        .about("Length over which the relief falls to 0, along the line of action (base radius times roll angle)."),
    choice("gear.tip_relief.course", COURSES, r#""parabolic""#).on_one_gear().or(r#""linear""#)
        .about(COURSE),
    table("gear.root_relief").on_one_gear().otherwise("no relief")
        .about("Relief that removes material from the flanks towards the root."),
    quantity("gear.root_relief.amount", Length, NON_NEGATIVE, r#""10 um""#).on_one_gear().or_pair(BOTH)
        .about("Material removed at the start of the active profile, normal to the flank."),
    quantity("gear.root_relief.length", Length, POSITIVE, r#""3 mm""#).on_one_gear().or_pair(BOTH)
        .about("Length over which the relief falls to 0, along the line of action."),
    choice("gear.root_relief.course", COURSES, r#""parabolic""#).on_one_gear().or(r#""linear""#)
        .about(COURSE),
    table("gear.end_relief").on_one_gear().otherwise("no relief")
        .about("Relief that removes material from the flanks towards both ends of the face."),
    quantity("gear.end_relief.amount", Length, NON_NEGATIVE, r#""10 um""#).on_one_gear().or_pair(BOTH)
        .about("Material removed at the ends of the face, normal to the flank."),
    quantity("gear.end_relief.length", Length, POSITIVE, r#""3 mm""#).on_one_gear().or_pair(BOTH)
        .about("Length along the face over which the relief falls to 0."),
    choice("gear.end_relief.course", COURSES, r#""parabolic""#).on_one_gear().or(r#""linear""#)
        .about(COURSE),
    quantity("gear.profile_crowning", Length, ANY, r#""4 um""#).on_one_gear().or("0").or_pair(BOTH)
        .about("Crowning of the profile: material removed at the tip and at the start of the active profile. It grows \
                with the square of the distance from the middle between them."),
    quantity("gear.profile_slope", Length, ANY, r#""-3 um""#).on_one_gear().or("0").or_pair(BOTH)
        .about("Slope of the profile, as modification or deviation: material removed at the tip minus material \
                removed at the start of the active profile."),
    quantity("gear.lead_crowning", Length, ANY, r#""5 um""#).on_one_gear().or("0").or_pair(BOTH)
        .about("Crowning of the lead: material removed at both ends of the face. It grows with the square of the \
                distance from the middle of the face."),
    quantity("gear.lead_slope", Length, ANY, r#""6 um""#).on_one_gear().or("0").or_pair(BOTH)
        .about("Slope of the lead, as modification or deviation: material removed at the end on the side of positive \
                tilt minus material removed at the other end. It describes a misalignment of the teeth on their \
                gears."),
    key("gear.profile_points", Kind::List("tables"), ANY,
        r#"[{ gear = "pinion", roll_length = ["14 mm", "18 mm", "20 mm"], missing = [0, 0, "8 um"] }]"#).on_one_gear().or("[]")
        .about("Flank profile of a gear through points, drawn or measured, in addition to reliefs, crowning and \
                slope. Before the first and after the last point the value stays constant. Every point adds a kink, \
                and every kink adds segments to the mesh. Reduce a measured profile of hundreds of points to a few \
                dozen."),
    table("gear.profile_points.*").on_one_gear(),
    choice("gear.profile_points.*.gear", GEARS, r#""wheel""#)
        .about("The gear that has this profile."),
    key("gear.profile_points.*.roll_length", Kind::List("lengths"), ANY, r#"["14 mm", "18 mm", "20 mm"]"#).on_one_gear()
        .otherwise("none; required without `diameter`")
        .about("Positions of the points, increasing, as roll lengths from the base circle (base radius times roll angle)."),
    quantity("gear.profile_points.*.roll_length.*", Length, NON_NEGATIVE, r#""18 mm""#).on_one_gear(),
    key("gear.profile_points.*.diameter", Kind::List("lengths"), ANY, r#"["79 mm", "85 mm", "88 mm"]"#).on_one_gear()
        .otherwise("none; required without `roll_length`")
        .about("Positions of the points as diameters, increasing. Instead of `roll_length`."),
    quantity("gear.profile_points.*.diameter.*", Length, POSITIVE, r#""85 mm""#).on_one_gear(),
    key("gear.profile_points.*.missing", Kind::List("lengths"), ANY, r#"[0, 0, "8 um"]"#).on_one_gear()
        .about("Material removed at each point, normal to the flank. Negative values mean excess material."),
    quantity("gear.profile_points.*.missing.*", Length, ANY, r#""8 um""#).on_one_gear(),
    choice("gear.profile_points.*.between", BETWEEN, r#""monotone""#).on_one_gear().or(r#""linear""#)
        .about(BETWEEN_POINTS),
    key("gear.lead_points", Kind::List("tables"), ANY,
        r#"[{ gear = "wheel", place = ["-10 mm", "6 mm", "10 mm"], missing = [0, 0, "5 um"] }]"#).on_one_gear().or("[]")
        .about("Lead of a gear's flanks through points, in addition to end relief, crowning and slope. The face is \
                computed in slices, and the lead is a straight line on each."),
    table("gear.lead_points.*").on_one_gear(),
    choice("gear.lead_points.*.gear", GEARS, r#""wheel""#)
        .about("The gear that has this lead."),
    key("gear.lead_points.*.place", Kind::List("lengths"), ANY, r#"["-10 mm", "6 mm", "10 mm"]"#).on_one_gear()
        .about("Positions of the points along the face, from its middle, increasing."),
    quantity("gear.lead_points.*.place.*", Length, ANY, r#""6 mm""#).on_one_gear(),
    key("gear.lead_points.*.missing", Kind::List("lengths"), ANY, r#"[0, 0, "5 um"]"#).on_one_gear()
        .about("Material removed at each point, normal to the flank. Negative values mean excess material."),
    quantity("gear.lead_points.*.missing.*", Length, ANY, r#""5 um""#).on_one_gear(),
    choice("gear.lead_points.*.between", BETWEEN, r#""monotone""#).on_one_gear().or(r#""linear""#)
        .about(BETWEEN_POINTS),
];
