//! `[train]`: shafts anywhere in space, their gears and connections.

use crate::manifest::schema::key::{
    ANY, Key, Kind, NON_NEGATIVE, POSITIVE, bounds, choice, integer, key, quantity, table,
};
use crate::units::Dimension::{
    Angle, Damping, Density, Drag, Inertia, Length, Mass, Pressure, Ratio, Stiffness,
    TiltStiffness, Torque,
};

use std::f64::consts::FRAC_PI_4;

const SIDES: [&str; 3] = ["both", "forward", "backward"];

const MOTIONS: [&str; 4] = ["all", "rotation", "lateral", "none"];

/// Names of the two gears of a mesh, in the order of the key `gears`.
pub(in crate::manifest) const OF_MESH: [&str; 2] = ["driving", "driven"];

#[rustfmt::skip]
pub(super) const KEYS: &[Key] = &[
    table("train").otherwise("an error with kind = \"train\"")
        .about("Shafts with any number of gears, discs and bearings, joined by meshes and couplings. Only with kind = \
                \"train\", instead of [gear] and [shafts]. Positions on a shaft are distances from its origin along \
                its axis."),
    key("train.gears", Kind::List("2 names of gears: driving, driven"), ANY, r#"["z20", "z30"]"#).of_length(2)
        .about("The pair of gears of the first mesh, which [mesh] and [excitation] describe. Mesh cycles are its \
                cycles. The speed of a point is the speed of its first gear. It must be the mesh nearest to the \
                motor. In a train with planets it is the mesh of the sun and a planet, and the speed of a point is that of \
                the driver. The first gear rolls in the positive direction about its axis."),
    key("train.gears.*", Kind::Text, ANY, r#""z20""#),
    quantity("train.rated_torque", Torque, POSITIVE, r#""50 N*m""#)
        .about("Torque of the motor at load 1."),
    key("train.driver", Kind::Text, ANY, r#""engine""#).otherwise("the shaft of the first gear of `train.gears`")
        .about("The shaft that the motor drives. It turns with the first gear; in a train with planets it is any shaft \
                that is not held, such as that of the carrier. Ripple on the `pinion` acts on it."),
    quantity("train.bearing_load", Ratio, NON_NEGATIVE, "0.5").or("1")
        .about("Load under which bearings from catalogue data (`ball`, `roller`) have their stiffness, as a fraction of \
                `rated_torque`. The program finds the static equilibrium of the train at this load. Motions about it feel \
                the stiffness there at every load of the grid. `atlas check` lists load, displacement and stiffness of \
                each bearing. For impacts within the clearance at light load, add a [[train.stop]]."),
    quantity("train.young_modulus", Pressure, POSITIVE, r#""210 GPa""#).or(r#""206 GPa""#)
        .about("Young's modulus of the shafts."),
    quantity("train.shear_modulus", Pressure, POSITIVE, r#""80 GPa""#).or(r#""79 GPa""#)
        .about("Shear modulus of the shafts."),
    quantity("train.density", Density, POSITIVE, r#""7800 kg/m^3""#).or(r#""7850 kg/m^3""#)
        .about("Density of shafts and gear bodies."),
    quantity("train.shear_coefficient", Ratio, bounds(0.0, true, 1.0, false), "0.886").or("0.9")
        .about("Timoshenko's shear coefficient of the shafts' sections."),

    key("train.shaft", Kind::List("tables"), ANY, r#"[{ name = "input", gears = [{ name = "z20", at = 0, teeth = 20, module = "3 mm", width = "20 mm" }], motion = "rotation" }]"#)
        .about("The shafts, one table `[[train.shaft]]` each."),
    table("train.shaft.*"),
    key("train.shaft.*.name", Kind::Text, ANY, r#""counter""#)
        .about("Name of the shaft."),
    key("train.shaft.*.origin", Kind::List("3 lengths"), ANY, r#"["100 mm", 0, 0]"#).of_length(3).or("[0, 0, 0]")
        .about("Position in space where the first section begins."),
    quantity("train.shaft.*.origin.*", Length, ANY, r#""100 mm""#),
    key("train.shaft.*.direction", Kind::List("3 numbers"), ANY, "[1, 0, 0]").of_length(3).or("[0, 0, 1]")
        .about("Direction of the axis, of any length. Spur gears run on parallel axes, bevel gears on axes that \
                intersect. The x and y axes of the shaft are the axes of space, turned by the smallest rotation that \
                brings z into this direction."),
    quantity("train.shaft.*.direction.*", Ratio, ANY, "1"),
    choice("train.shaft.*.motion", &MOTIONS, r#""rotation""#).or(r#""all""#)
        .about("Free motions of the shaft. `all`: all motions; bearings must hold all of them except the rotation. \
                `rotation`: only the rotation, on rigid mounts. `lateral`: all motions except the rotation, which is \
                held at `torque_at`; the shaft bends but does not turn. `none`: no motion. Loose gears on a shaft \
                with `rotation` or `none` can only turn."),
    key("train.shaft.*.sections", Kind::List("tables"), ANY, r#"[{ length = "120 mm", outer = "30 mm" }]"#).or("[]")
        .about("Sections of the shaft in order. Without sections the shaft is a rigid body with the inertia of its \
                discs and gears."),
    table("train.shaft.*.sections.*"),
    quantity("train.shaft.*.sections.*.length", Length, POSITIVE, r#""120 mm""#)
        .about("Length of the section."),
    quantity("train.shaft.*.sections.*.outer", Length, POSITIVE, r#""30 mm""#)
        .about("Outer diameter."),
    quantity("train.shaft.*.sections.*.inner", Length, NON_NEGATIVE, r#""10 mm""#).or("0")
        .about("Inner diameter."),
    quantity("train.shaft.*.element", Length, POSITIVE, r#""15 mm""#).otherwise("the outer diameter of each section")
        .about("Longest beam element. Shorter elements make the highest modes more accurate."),
    quantity("train.shaft.*.torque_at", Length, ANY, r#""40 mm""#).or("0")
        .about("Position where the torque of the motor or of the driven machine, and drag, act."),
    quantity("train.shaft.*.output", Ratio, bounds(0.0, false, 1.0, false), "1").or("0")
        .about("Fraction of the motor's power that leaves the train at this shaft. A mesh or a coupling must turn the \
                shaft. The fractions of all shafts add up to 1. If all are 0, only drag loads the train and `load` \
                has no effect."),
    quantity("train.shaft.*.drag", Drag, NON_NEGATIVE, r#""2e-3 N*m*s/rad""#).or("0")
        .about("Viscous drag on the rotation, per the speed of this shaft. The motor supplies its mean through the meshes."),
    quantity("train.shaft.*.drag_torque", Torque, NON_NEGATIVE, r#""0.4 N*m""#).or("0")
        .about("Constant torque against the rotation."),

    key("train.shaft.*.discs", Kind::List("tables"), ANY, r#"[{ at = 0, polar_inertia = "0.2 kg*m^2" }]"#).or("[]")
        .about("Rigid bodies on the shaft: flywheels, hubs, a motor."),
    table("train.shaft.*.discs.*"),
    quantity("train.shaft.*.discs.*.at", Length, ANY, r#""40 mm""#)
        .about("Position of the disc."),
    quantity("train.shaft.*.discs.*.polar_inertia", Inertia, NON_NEGATIVE, r#""0.2 kg*m^2""#)
        .about("Moment of inertia about the axis."),
    quantity("train.shaft.*.discs.*.transverse_inertia", Inertia, NON_NEGATIVE, r#""0.1 kg*m^2""#).or("0")
        .about("Moment of inertia about a diameter. A disc without this inertia and without mass represents a body \
                behind a coupling: it does not tilt and has no gyroscopic moment."),
    quantity("train.shaft.*.discs.*.mass", Mass, NON_NEGATIVE, r#""12 kg""#).or("0")
        .about("Mass of the disc."),

    key("train.shaft.*.bearings", Kind::List("tables"), ANY, r#"[{ at = "10 mm", x = "1e8 N/m", y = "1e8 N/m", axial = "1e8 N/m" }]"#).or("[]")
        .about("Bearings between the shaft and the ground, or the housing."),
    table("train.shaft.*.bearings.*"),
    quantity("train.shaft.*.bearings.*.at", Length, ANY, r#""10 mm""#)
        .about("Position of the bearing."),
    key("train.shaft.*.bearings.*.housing", Kind::Text, ANY, r#""left""#).otherwise("none: the bearing stands on the ground")
        .about("Node of the housing on which the bearing stands. Its springs and dampers then act between shaft and node."),
    quantity("train.shaft.*.bearings.*.x", Stiffness, NON_NEGATIVE, r#""1e8 N/m""#).otherwise("none; required without `ball` or `roller`")
        .about("Radial stiffness along the shaft's x axis."),
    quantity("train.shaft.*.bearings.*.y", Stiffness, NON_NEGATIVE, r#""1e8 N/m""#).otherwise("none; required without `ball` or `roller`")
        .about("Radial stiffness along the shaft's y axis."),
    quantity("train.shaft.*.bearings.*.axial", Stiffness, NON_NEGATIVE, r#""1e8 N/m""#).or("0")
        .about("Stiffness along the axis."),
    quantity("train.shaft.*.bearings.*.tilt", TiltStiffness, NON_NEGATIVE, r#""2e4 N*m/rad""#).or("0")
        .about("Stiffness against tilting."),
    quantity("train.shaft.*.bearings.*.damping_x", Damping, NON_NEGATIVE, r#""400 N*s/m""#).or("0")
        .about("Damper along x."),
    quantity("train.shaft.*.bearings.*.damping_y", Damping, NON_NEGATIVE, r#""400 N*s/m""#).or("0")
        .about("Damper along y."),
    quantity("train.shaft.*.bearings.*.damping_xy", Damping, ANY, r#""-20 N*s/m""#).or("0")
        .about("Cross-coupled damping: opposing force along x per velocity along y."),
    quantity("train.shaft.*.bearings.*.damping_yx", Damping, ANY, r#""-20 N*s/m""#).or("0")
        .about("Cross-coupled damping: opposing force along y per velocity along x."),
    quantity("train.shaft.*.bearings.*.cross_xy", Stiffness, ANY, r#""2e6 N/m""#).or("0")
        .about("Cross-coupled stiffness: opposing force along x per displacement along y."),
    quantity("train.shaft.*.bearings.*.cross_yx", Stiffness, ANY, r#""-2e6 N/m""#).or("0")
        .about("Cross-coupled stiffness: opposing force along y per displacement along x."),

    key("train.shaft.*.gears", Kind::List("tables"), ANY, r#"[{ name = "z20", at = "60 mm", teeth = 20, module = "3 mm", width = "20 mm" }]"#).or("[]")
        .about("The gears on the shaft. A gear also takes these keys of [gear], each with one value: `rack`, \
                `tip_relief`, `root_relief`, `end_relief`, `profile_crowning`, `profile_slope`, `lead_crowning`, \
                `lead_slope`, `profile_points`, `lead_points` (without `gear`), `bore`, `hub_diameter`, `hub_length`, \
                `web_thickness`, `rim_diameter`, `young_modulus`, `poisson_ratio`."),
    table("train.shaft.*.gears.*"),
    key("train.shaft.*.gears.*.name", Kind::Text, ANY, r#""z20""#)
        .about("Name of the gear, different from all others."),
    quantity("train.shaft.*.gears.*.at", Length, ANY, r#""60 mm""#)
        .about("Position of the middle of its face."),
    integer("train.shaft.*.gears.*.teeth", 4.0, 1000.0, "20")
        .about("Number of teeth."),
    quantity("train.shaft.*.gears.*.module", Length, POSITIVE, r#""3 mm""#)
        .about("Module in the normal section. For a bevel gear, the module in the middle of its face."),
    quantity("train.shaft.*.gears.*.width", Length, POSITIVE, r#""20 mm""#)
        .about("Face width, which is also the length of the body."),
    key("train.shaft.*.gears.*.internal", Kind::Boolean, ANY, "true").or("false")
        .about("Whether the teeth point inwards: the gear is a ring. A ring runs with planets."),
    quantity("train.shaft.*.gears.*.outer", Length, POSITIVE, r#""300 mm""#).otherwise("the pitch diameter plus 8 modules")
        .about("Outer diameter of a ring's body. A mesh from the drawing takes the ring as held all round there."),
    quantity("train.shaft.*.gears.*.pressure_angle", Angle, bounds(0.0, true, FRAC_PI_4, true), r#""25 deg""#).or(r#""20 deg""#)
        .about("Pressure angle of the basic rack."),
    quantity("train.shaft.*.gears.*.helix_angle", Angle, bounds(-FRAC_PI_4, true, FRAC_PI_4, true), r#""-20 deg""#).or("0")
        .about("Helix angle at the reference cylinder, positive if right-handed. Gears that mesh have opposite angles, a \
                planet and its ring equal ones."),
    quantity("train.shaft.*.gears.*.tip_diameter", Length, POSITIVE, r#""66 mm""#)
        .otherwise("from the rack, with its tip clearance in each mesh (ISO 21771)")
        .about("Tip diameter; of a ring its inner diameter."),
    quantity("train.shaft.*.gears.*.profile_shift", Ratio, bounds(-1.0, false, 2.0, false), "0.3").or("0")
        .about("Profile shift coefficient, in modules. A positive shift makes the teeth thicker: it is away from the axis \
                for external gears, towards it for a ring (ISO 21771)."),
    quantity("train.shaft.*.gears.*.thinning", Length, NON_NEGATIVE, r#""40 um""#).or("0")
        .about("Reduction of tooth thickness along the reference circle, relative to the thickness that the profile shift gives."),
    key("train.shaft.*.gears.*.body", Kind::Table, ANY, r#"{ polar_inertia = "1e-3 kg*m^2" }"#)
        .otherwise("a homogeneous annulus between the shaft's outer diameter and the pitch circle")
        .about("Inertia of the gear, if it is known; of what is outside of its hub, if it has one."),
    quantity("train.shaft.*.gears.*.body.polar_inertia", Inertia, POSITIVE, r#""1e-3 kg*m^2""#)
        .about("Moment of inertia about the axis."),
    quantity("train.shaft.*.gears.*.body.transverse_inertia", Inertia, NON_NEGATIVE, r#""6e-4 kg*m^2""#).or("0")
        .about("Moment of inertia about a diameter."),
    quantity("train.shaft.*.gears.*.body.mass", Mass, NON_NEGATIVE, r#""2 kg""#).or("0")
        .about("Mass."),
    key("train.shaft.*.gears.*.loose", Kind::Table, ANY, r#"{ x = "2e8 N/m", y = "2e8 N/m", axial = "1e8 N/m", tilt = "1e4 N*m/rad", drag = "1e-4 N*m*s/rad" }"#)
        .otherwise("the gear is fixed to its shaft")
        .about("Makes the gear loose. It runs in a bearing on its shaft, like a gear of a manual gearbox that is not \
                engaged."),
    quantity("train.shaft.*.gears.*.loose.x", Stiffness, NON_NEGATIVE, r#""2e8 N/m""#).or("0")
        .about("Radial stiffness of its bearing along the shaft's x axis."),
    quantity("train.shaft.*.gears.*.loose.y", Stiffness, NON_NEGATIVE, r#""2e8 N/m""#).or("0")
        .about("Radial stiffness of its bearing along the shaft's y axis."),
    quantity("train.shaft.*.gears.*.loose.axial", Stiffness, NON_NEGATIVE, r#""1e8 N/m""#).or("0")
        .about("Stiffness along the axis."),
    quantity("train.shaft.*.gears.*.loose.tilt", TiltStiffness, NON_NEGATIVE, r#""1e4 N*m/rad""#).or("0")
        .about("Stiffness against tilting on the shaft."),
    quantity("train.shaft.*.gears.*.loose.drag", Drag, NON_NEGATIVE, r#""1e-4 N*m*s/rad""#).or("0")
        .about("Viscous drag of the gear against its shaft."),
    quantity("train.shaft.*.gears.*.loose.drag_torque", Torque, NON_NEGATIVE, r#""0.05 N*m""#).or("0")
        .about("Constant torque of the shaft against the gear's rotation on it."),

    key("train.planetary", Kind::List("tables"), ANY, r#"[{ carrier = "carrier", count = 3, teeth = 35, module = "2 mm", width = "20 mm", bearing = { radial = "1e8 N/m" } }]"#).or("[]")
        .about("Planetary sets, one table `[[train.planetary]]` each: planets on pins of a carrier, between sun and ring on \
                its axis. `train.gears` and `train.mesh.*.gears` name the planets of a set by their common name, and one \
                table describes the meshes of all of them: planets differ by their phase, which follows from their angles. \
                The speeds of all shafts must follow from that of the driver. In a single set, the shaft of the sun, \
                the ring or the carrier must be held: it has motion = \"lateral\" or \"none\", or a coupling joins it to \
                such a shaft. If the carrier turns, the model of the set turns with it. Bearings of the set must then \
                have equal properties in all directions. Other gears, and members of another set, must be on separate \
                shafts. Couplings join these shafts to the set in `twist` and `axial` only."),
    table("train.planetary.*"),
    key("train.planetary.*.carrier", Kind::Text, ANY, r#""carrier""#)
        .about("The shaft that has the pins."),
    quantity("train.planetary.*.at", Length, ANY, r#""40 mm""#).or("0")
        .about("Position of the middle of the planets on the carrier."),
    quantity("train.planetary.*.radius", Length, POSITIVE, r#""90 mm""#).otherwise("the distance at which sun and planet have no backlash but that of thinning")
        .about("Distance of the pins from the axis."),
    integer("train.planetary.*.count", 1.0, 16.0, "3").otherwise("none; required without `angles`")
        .about("Number of planets, equally spaced."),
    key("train.planetary.*.angles", Kind::List("angles, one per planet"), ANY, r#"[0, "120 deg", "240 deg"]"#).otherwise("equal angles")
        .about("Angle of each planet about the axis, from the first planet. Planets fit where the angle times the sum \
                of the teeth of sun and ring is a whole number of turns."),
    quantity("train.planetary.*.angles.*", Angle, ANY, r#""120 deg""#),
    key("train.planetary.*.name", Kind::Text, ANY, r#""idler""#).or(r#""planet""#)
        .about("Common name of the planets, another one in each set. Their bodies and gears have this name and their number."),
    integer("train.planetary.*.teeth", 4.0, 1000.0, "35")
        .about("Number of teeth of a planet."),
    quantity("train.planetary.*.module", Length, POSITIVE, r#""2 mm""#)
        .about("Module, equal to that of sun and ring."),
    quantity("train.planetary.*.width", Length, POSITIVE, r#""20 mm""#)
        .about("Face width of a planet, which is also the length of its body."),
    quantity("train.planetary.*.pressure_angle", Angle, bounds(0.0, true, FRAC_PI_4, true), r#""25 deg""#).or(r#""20 deg""#)
        .about("Pressure angle of the basic rack."),
    quantity("train.planetary.*.helix_angle", Angle, bounds(-FRAC_PI_4, true, FRAC_PI_4, true), r#""-20 deg""#).or("0")
        .about("Helix angle of a planet at its reference cylinder, positive if right-handed."),
    quantity("train.planetary.*.tip_diameter", Length, POSITIVE, r#""74 mm""#)
        .otherwise("from the rack, with its tip clearance at the sun (ISO 21771)")
        .about("Tip diameter of a planet."),
    quantity("train.planetary.*.profile_shift", Ratio, bounds(-1.0, false, 2.0, false), "0.3").or("0")
        .about("Profile shift coefficient of a planet."),
    quantity("train.planetary.*.thinning", Length, NON_NEGATIVE, r#""40 um""#).or("0")
        .about("Reduction of tooth thickness of a planet along the reference circle."),
    quantity("train.planetary.*.bore", Length, NON_NEGATIVE, r#""30 mm""#).or("0")
        .about("Bore of a planet."),
    key("train.planetary.*.body", Kind::Table, ANY, r#"{ polar_inertia = "1e-3 kg*m^2", mass = "0.6 kg" }"#)
        .otherwise("a homogeneous annulus between the bore and the pitch circle")
        .about("Inertia of a planet, if it is known."),
    quantity("train.planetary.*.body.polar_inertia", Inertia, POSITIVE, r#""1e-3 kg*m^2""#)
        .about("Moment of inertia about the axis."),
    quantity("train.planetary.*.body.transverse_inertia", Inertia, NON_NEGATIVE, r#""6e-4 kg*m^2""#).or("0")
        .about("Moment of inertia about a diameter."),
    quantity("train.planetary.*.body.mass", Mass, NON_NEGATIVE, r#""0.6 kg""#).or("0")
        .about("Mass."),
    table("train.planetary.*.bearing")
        .about("Bearing of a planet on its pin."),
    quantity("train.planetary.*.bearing.radial", Stiffness, POSITIVE, r#""1e8 N/m""#).otherwise("none; required without `ball` or `roller`")
        .about("Radial stiffness."),
    quantity("train.planetary.*.bearing.axial", Stiffness, NON_NEGATIVE, r#""1e8 N/m""#).otherwise("the radial stiffness; 0 with `ball` or `roller`")
        .about("Stiffness along the axis."),
    quantity("train.planetary.*.bearing.tilt", TiltStiffness, NON_NEGATIVE, r#""2e4 N*m/rad""#).otherwise("the radial stiffness times the square of the width / 12; 0 with `ball` or `roller`")
        .about("Stiffness against tilting."),
    key("train.planetary.*.pin_errors", Kind::List("lengths, one per planet"), ANY, r#"["30 um", 0, 0]"#).otherwise("0 for every planet")
        .about("Distance of each pin from its nominal position along the circle, positive in the direction in which \
                the carrier turns."),
    quantity("train.planetary.*.pin_errors.*", Length, ANY, r#""30 um""#),

    key("train.housing", Kind::Table, ANY, r#"{ file = "housing-box.toml" }"#).otherwise("bearings stand on the ground")
        .about("A housing from a finite-element program, as reduced matrices over named nodes. Bearings that name a node \
                with `housing` stand on it. Its freedoms join those of the train before the modes are computed. Shafts \
                that turn with the carrier of planets cannot stand on it."),
    key("train.housing.file", Kind::Text, ANY, r#""housing-box.toml""#)
        .about("Path of the housing file, relative to the folder of the manifest."),

    key("train.mesh", Kind::List("tables"), ANY, r#"[{ gears = ["z18", "z27"], half_gap = "40 um", stiffness = "3e8 N/m" }]"#).or("[]")
        .about("Further meshes, one table `[[train.mesh]]` each; the first mesh is [mesh]. Each is two contacts: \
                drive flanks, and coast flanks mirrored about the plane of the axes. Its cycle follows from the \
                numbers of teeth."),
    table("train.mesh.*"),
    key("train.mesh.*.gears", Kind::List("2 names of gears: driving, driven"), ANY, r#"["z18", "z27"]"#).of_length(2)
        .about("The two gears of the mesh."),
    key("train.mesh.*.gears.*", Kind::Text, ANY, r#""z18""#),
    quantity("train.mesh.*.half_gap", Length, POSITIVE, r#""40 um""#).otherwise("the half gap that the distance of the axes and the tooth thickness give")
        .about("Half of the backlash along the line of action."),
    choice("train.mesh.*.law", &["given", "table", "continuous"], r#""continuous""#).or(r#""given""#)
        .about("Source of the stiffness. `given`: `stiffness` or `levels`. `table`, `continuous`: computed from the \
                drawing of both gears under the mean load of this mesh, as with mesh.stiffness. The keys \
                `misalignment`, `shaft_tilt`, `contact`, `face`, `resolution` and `segments` of [mesh] then also \
                hold for this mesh, if they stand in its table."),
    quantity("train.mesh.*.stiffness", Stiffness, POSITIVE, r#""3e8 N/m""#).otherwise("none; required with law = \"given\", without `levels`")
        .about("Mesh stiffness, or its mean if it has harmonics."),
    key("train.mesh.*.levels", Kind::List("stiffnesses, one per part of the mesh's cycle"), ANY, r#"["3.4e8 N/m", "2.6e8 N/m"]"#)
        .otherwise("none: `stiffness` holds")
        .about("Stiffness of each of several equal parts of the cycle of this mesh, instead of `stiffness`."),
    quantity("train.mesh.*.levels.*", Stiffness, POSITIVE, r#""3e8 N/m""#),
    key("train.mesh.*.stiffness_harmonics", Kind::List("tables"), ANY, r#"[{ harmonic = 1, amplitude = "5e7 N/m" }]"#).or("[]")
        .about("Harmonics of the stiffness over the cycle of this mesh."),
    table("train.mesh.*.stiffness_harmonics.*"),
    integer("train.mesh.*.stiffness_harmonics.*.harmonic", 1.0, 100.0, "1")
        .about("Multiple of the frequency of the mesh."),
    quantity("train.mesh.*.stiffness_harmonics.*.amplitude", Stiffness, NON_NEGATIVE, r#""5e7 N/m""#)
        .about("Amplitude of the harmonic."),
    quantity("train.mesh.*.stiffness_harmonics.*.phase", Angle, ANY, r#""90 deg""#).or("0")
        .about("Phase of the cosine at phase 0 of the mesh's cycle."),
    quantity("train.mesh.*.coast_symmetry", Ratio, bounds(0.0, false, 1.0, true), "0.3")
        .otherwise("from the drawing of both gears")
        .about("Phase of the mesh's cycle about which the stiffness of the drive flanks is mirrored to give the \
                stiffness of the coast flanks."),
    quantity("train.mesh.*.damping", Damping, NON_NEGATIVE, r#""900 N*s/m""#).or("0")
        .about("Damping of the closed contact."),
    quantity("train.mesh.*.friction", Ratio, NON_NEGATIVE, "0.05").or("0")
        .about("Coulomb friction coefficient. The friction force reverses at the pitch point, which the drawing of \
                the gears gives. Pairs in contact share the load evenly. Bevel gears have no friction."),
    quantity("train.mesh.*.phase", Ratio, ANY, "0.25").otherwise("0; for planets that drive a ring, from the drawing")
        .about("Phase of the mesh's cycle at time 0, in cycles of this mesh. For planets, that of the first planet."),
    key("train.mesh.*.transmission_error", Kind::List("tables"), ANY, r#"[{ harmonic = 1, amplitude = "3 um" }]"#).or("[]")
        .about("Transmission error of this mesh, the same on both flanks."),
    table("train.mesh.*.transmission_error.*"),
    integer("train.mesh.*.transmission_error.*.harmonic", 1.0, 1000.0, "1")
        .about("Multiple of the frequency of the mesh."),
    quantity("train.mesh.*.transmission_error.*.amplitude", Length, NON_NEGATIVE, r#""3 um""#)
        .about("Amplitude."),
    quantity("train.mesh.*.transmission_error.*.phase", Angle, ANY, r#""90 deg""#).or("0")
        .about("Phase of the cosine at phase 0 of the mesh's cycle."),

    key("train.mesh.*.gear_error", Kind::List("tables"), ANY, r#"[{ gear = "driven", order = 1, amplitude = "10 um" }]"#).or("[]")
        .about("Transmission error of this mesh at an order of one of its gears, one table per order, as \
                excitation.gear_error for the first mesh. Not for meshes of planets."),
    table("train.mesh.*.gear_error.*"),
    choice("train.mesh.*.gear_error.*.gear", &OF_MESH, r#""driving""#)
        .about("The gear that has the error, by its place in `gears`."),
    integer("train.mesh.*.gear_error.*.order", 1.0, 1000.0, "1")
        .about("Multiple of the speed of that gear."),
    quantity("train.mesh.*.gear_error.*.amplitude", Length, NON_NEGATIVE, r#""10 um""#)
        .about("Amplitude along the line of action."),
    quantity("train.mesh.*.gear_error.*.phase", Angle, ANY, r#""90 deg""#).or("0")
        .about("Phase of the cosine at time 0."),
    table("train.mesh.*.pitch_deviation").otherwise("none")
        .about("Cumulative pitch deviations of the gears of this mesh, as excitation.pitch_deviation for the first mesh. \
                Not for meshes of planets."),
    key("train.mesh.*.pitch_deviation.driving", Kind::List("lengths, one per tooth"), ANY, r#"["0 um", "2 um", "-1 um"]"#)
        .otherwise("none")
        .about("Deviations of the driving gear, in the order in which its teeth engage. The first tooth engages at the \
                start of the cycle of this mesh that runs at time 0."),
    quantity("train.mesh.*.pitch_deviation.driving.*", Length, ANY, r#""2 um""#),
    key("train.mesh.*.pitch_deviation.driven", Kind::List("lengths, one per tooth"), ANY, r#"["0 um", "2 um", "-1 um"]"#)
        .otherwise("none")
        .about("Deviations of the driven gear, in the same way."),
    quantity("train.mesh.*.pitch_deviation.driven.*", Length, ANY, r#""2 um""#),

    key("train.coupling", Kind::List("tables"), ANY, r#"[{ shafts = ["engine", "input"], twist = "800 N*m/rad" }]"#).or("[]")
        .about("Springs and dampers between two shafts on one axis, one table `[[train.coupling]]` each. Use them for \
                couplings and, with stages, for the springs of a clutch."),
    table("train.coupling.*"),
    key("train.coupling.*.shafts", Kind::List("2 names of shafts"), ANY, r#"["engine", "input"]"#).of_length(2)
        .about("The shafts that the coupling joins. They must turn at the same speed."),
    key("train.coupling.*.shafts.*", Kind::Text, ANY, r#""input""#),
    key("train.coupling.*.at", Kind::List("2 lengths"), ANY, r#"["80 mm", 0]"#).of_length(2)
        .otherwise("the end of the first shaft and the beginning of the second")
        .about("Positions where the coupling is fixed to the shafts."),
    quantity("train.coupling.*.at.*", Length, ANY, r#""80 mm""#),
    quantity("train.coupling.*.twist", TiltStiffness, NON_NEGATIVE, r#""800 N*m/rad""#).or("0")
        .about("Stiffness against twist."),
    quantity("train.coupling.*.damping", Drag, NON_NEGATIVE, r#""0.3 N*m*s/rad""#).or("0")
        .about("Damper against twist."),
    quantity("train.coupling.*.radial", Stiffness, NON_NEGATIVE, r#""1e7 N/m""#).or("0")
        .about("Stiffness across the axis. Both positions must coincide in space, because its force would create an \
                unbalanced moment across a gap."),
    quantity("train.coupling.*.axial", Stiffness, NON_NEGATIVE, r#""1e6 N/m""#).or("0")
        .about("Stiffness along the axis."),
    quantity("train.coupling.*.tilt", TiltStiffness, NON_NEGATIVE, r#""500 N*m/rad""#).or("0")
        .about("Stiffness against bending."),
    key("train.coupling.*.stages", Kind::List("tables"), ANY, r#"[{ gap = "4 deg", stiffness = "1500 N*m/rad" }]"#).or("[]")
        .about("Further springs against twist behind gaps, such as the main stage of a clutch damper, or its stop. A spring \
                that acts to both sides is two contacts."),
    table("train.coupling.*.stages.*"),
    choice("train.coupling.*.stages.*.side", &SIDES, r#""forward""#).or(r#""both""#)
        .about("Side of the twist at which the stage acts. `forward`: the first shaft is ahead of the second, as when the \
                motor drives. `backward`: it is behind. `both`: either side, behind equal gaps."),
    quantity("train.coupling.*.stages.*.gap", Angle, NON_NEGATIVE, r#""4 deg""#)
        .about("Twist at which the stage engages."),
    quantity("train.coupling.*.stages.*.stiffness", TiltStiffness, POSITIVE, r#""1500 N*m/rad""#)
        .about("Stiffness that the stage adds."),
    quantity("train.coupling.*.stages.*.damping", Drag, NON_NEGATIVE, r#""0.2 N*m*s/rad""#).or("0")
        .about("Damping that the stage adds."),

    key("train.coupling.*.hysteresis", Kind::List("tables"), ANY, r#"[{ stiffness = "400 N*m/rad", limit = "6 N*m" }]"#).or("[]")
        .about("Dry hysteresis against twist, one table per element: a spring in series with a dry slider. The element starts \
                without torque. Several elements make an Iwan set. Each counts as three contacts: slip forwards, slip \
                backwards, stick. The kernel `volterra` is necessary."),
    table("train.coupling.*.hysteresis.*"),
    quantity("train.coupling.*.hysteresis.*.stiffness", TiltStiffness, POSITIVE, r#""400 N*m/rad""#)
        .about("Stiffness of the spring while the slider sticks."),
    quantity("train.coupling.*.hysteresis.*.limit", Torque, POSITIVE, r#""6 N*m""#)
        .about("Friction torque at which the slider slips."),

    key("train.stop", Kind::List("tables"), ANY, r#"[{ shaft = "output", at = 0, direction = [0, 0, 1], gap = "50 um", stiffness = "1e8 N/m" }]"#).or("[]")
        .about("One-sided springs between a shaft and the ground, one table `[[train.stop]]` each, such as an axial \
                stop or a bearing with clearance."),
    table("train.stop.*"),
    key("train.stop.*.shaft", Kind::Text, ANY, r#""output""#)
        .about("The shaft that touches the stop."),
    quantity("train.stop.*.at", Length, ANY, r#""40 mm""#)
        .about("Position of the stop."),
    key("train.stop.*.direction", Kind::List("3 numbers"), ANY, "[0, 0, 1]").of_length(3)
        .about("Direction from the shaft to the stop, in the shaft's axes with z along the shaft. The vector may have any length."),
    quantity("train.stop.*.direction.*", Ratio, ANY, "1"),
    quantity("train.stop.*.gap", Length, ANY, r#""50 um""#)
        .about("Distance to the stop. It is negative if the stop is preloaded."),
    quantity("train.stop.*.stiffness", Stiffness, POSITIVE, r#""1e8 N/m""#)
        .about("Stiffness of the stop."),
    quantity("train.stop.*.damping", Damping, NON_NEGATIVE, r#""300 N*s/m""#).or("0")
        .about("Damping of the stop."),
];
