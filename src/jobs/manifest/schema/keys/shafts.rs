//! `[shafts]`. The table of either shaft may also have the keys that both share.

use super::INSIDE_ONE;
use crate::manifest::schema::key::{
    ANY, Key, Kind, NON_NEGATIVE, POSITIVE, bounds, integer, key, quantity, table,
};
use crate::units::Dimension::{
    Damping, Density, Drag, Inertia, Length, Mass, Pressure, Ratio, Stiffness, TiltStiffness,
    Torque,
};

const BOTH: &str = "first bearing, second bearing";

/// Default of the keys that only flexible shafts need.
const ELASTIC: &str = "none; required with kind = \"flexible\"";

#[rustfmt::skip]
pub(super) const KEYS: &[Key] = &[
    table("shafts").otherwise("an error, except with kind = \"modal\"")
        .about("Material, stations, bearings and pedestals of the shafts. Keys here apply to both shafts; \
                `[shafts.pinion]` and `[shafts.wheel]` override them one by one. Each kind of model uses only the \
                keys that it needs, but all keys are checked."),
    quantity("shafts.young_modulus", Pressure, POSITIVE, r#""206 GPa""#).otherwise(ELASTIC)
        .about("Young's modulus of the shafts."),
    quantity("shafts.shear_modulus", Pressure, POSITIVE, r#""79 GPa""#).otherwise(ELASTIC)
        .about("Shear modulus of the shafts. With Young's modulus it must give a Poisson's ratio of at most 0.5."),
    quantity("shafts.density", Density, POSITIVE, r#""7850 kg/m^3""#)
        .about("Density of shafts and gear bodies."),
    quantity("shafts.shear_coefficient", Ratio, bounds(0.0, true, 1.0, false), "0.886").or("0.9")
        .about("Timoshenko's shear coefficient of the shaft section. 0.9 is usual in rotordynamics for a solid \
                circle."),
    key("shafts.elements", Kind::List("3 integers: overhang, first bearing to gear, gear to second bearing"), ANY, "[3, 5, 7]")
        .of_length(3).otherwise(ELASTIC)
        .about("Number of beam elements in each part of a shaft. More elements make the highest modes more accurate."),
    integer("shafts.elements.*", 1.0, 100.0, "5"),
    quantity("shafts.span", Length, POSITIVE, r#""120 mm""#).on_either_shaft()
        .about("Distance between the two bearings."),
    quantity("shafts.overhang", Length, POSITIVE, r#""40 mm""#).on_either_shaft()
        .about("Length of the free end before the first bearing. It carries the end inertia."),
    quantity("shafts.gear_position", Ratio, INSIDE_ONE, "0.45").on_either_shaft()
        .otherwise("none; required with kinds that tilt or bend")
        .about("Position of the gear, as a fraction of the span from the first bearing. If the gear is not in the \
                middle, tilt and radial motion are coupled."),
    table("shafts.bearings").on_either_shaft().otherwise("an error, except with kind = \"torsional\"")
        .about("Linear springs of each bearing. One value applies to both bearings; a pair `[first, second]` gives \
                different values."),
    quantity("shafts.bearings.x", Stiffness, POSITIVE, r#""1.25e8 N/m""#).or_pair(BOTH).on_either_shaft()
        .about("Radial stiffness along x, the line of centres from pinion to wheel."),
    quantity("shafts.bearings.y", Stiffness, POSITIVE, r#""1e8 N/m""#).or_pair(BOTH).on_either_shaft()
        .about("Radial stiffness along y, across the line of centres."),
    quantity("shafts.bearings.tilt", TiltStiffness, NON_NEGATIVE, r#""2e4 N*m/rad""#).or_pair(BOTH).on_either_shaft()
        .otherwise("none; required with kinds that tilt or bend")
        .about("Stiffness against tilting of the shaft in the bearing, the same about x and y."),
    key("shafts.bearings.axial", Kind::List("2 stiffnesses: first bearing, second bearing"), ANY, r#"["1e8 N/m", 0]"#)
        .of_length(2).on_either_shaft().otherwise("none; required with kinds that tilt or bend")
        .about("Stiffness along z, the axis of the shaft. At least one bearing must locate the shaft."),
    quantity("shafts.bearings.axial.*", Stiffness, NON_NEGATIVE, r#""1e8 N/m""#).on_either_shaft(),
    quantity("shafts.bearings.damping_x", Damping, NON_NEGATIVE, r#""400 N*s/m""#).or_pair(BOTH).on_either_shaft().or("0")
        .about("Damper of the bearing along x, parallel to its spring. It adds to the modal damping ratios, which \
                represent the material. Bearing forces in the results are the sum of springs and dampers."),
    quantity("shafts.bearings.damping_y", Damping, NON_NEGATIVE, r#""300 N*s/m""#).or_pair(BOTH).on_either_shaft().or("0")
        .about("Damper of the bearing along y."),
    quantity("shafts.bearings.damping_xy", Damping, ANY, r#""-20 N*s/m""#).or_pair(BOTH).on_either_shaft().or("0")
        .about("Cross-coupled damping: opposing force along x per velocity along y."),
    quantity("shafts.bearings.damping_yx", Damping, ANY, r#""-20 N*s/m""#).or_pair(BOTH).on_either_shaft().or("0")
        .about("Cross-coupled damping: opposing force along y per velocity along x."),
    quantity("shafts.bearings.cross_xy", Stiffness, ANY, r#""2e6 N/m""#).or_pair(BOTH).on_either_shaft().or("0")
        .about("Cross-coupled stiffness of a fluid film: opposing force along x per displacement along y. The pinion \
                turns from x to y and the wheel from y to x. With `cross_xy` = -`cross_yx`, a positive value on the \
                pinion's shaft drives forward whirl. On the wheel's shaft, a negative value drives it."),
    quantity("shafts.bearings.cross_yx", Stiffness, ANY, r#""-2e6 N/m""#).or_pair(BOTH).on_either_shaft().or("0")
        .about("Cross-coupled stiffness: opposing force along y per displacement along x."),
    table("shafts.pedestals").on_either_shaft().otherwise("an error with kind = \"pedestal\"")
        .about("Support of each bearing: a mass on springs to the ground. Only with kind = \"pedestal\"."),
    quantity("shafts.pedestals.x", Stiffness, POSITIVE, r#""4e8 N/m""#).or_pair(BOTH).on_either_shaft()
        .about("Stiffness of the pedestal along x, the line of centres."),
    quantity("shafts.pedestals.y", Stiffness, POSITIVE, r#""3e8 N/m""#).or_pair(BOTH).on_either_shaft()
        .about("Stiffness of the pedestal along y, across the line of centres."),
    quantity("shafts.pedestals.mass", Mass, POSITIVE, r#""3 kg""#).or_pair(BOTH).on_either_shaft()
        .about("Mass of the pedestal."),
    table("shafts.<shaft>")
        .about("Keys of one shaft: `[shafts.pinion]` is driving, `[shafts.wheel]` driven. Keys that `[shafts]` shares \
                (span, overhang, gear_position, bearings, pedestals) may also be given here and override those of \
                `[shafts]`."),
    quantity("shafts.<shaft>.diameter", Length, POSITIVE, r#""22 mm""#)
        .about("Diameter of the shaft, less than the pitch diameter of its gear."),
    quantity("shafts.<shaft>.inner_diameter", Length, NON_NEGATIVE, r#""10 mm""#).or("0")
        .about("Inner diameter of a hollow shaft, along its whole length."),
    quantity("shafts.<shaft>.end_inertia", Inertia, NON_NEGATIVE, r#""2e-3 kg*m^2""#)
        .about("Polar moment of inertia at the free end of the overhang: motor or driven machine."),
    quantity("shafts.<shaft>.drag", Drag, NON_NEGATIVE, r#""2e-3 N*m*s/rad""#).or("0")
        .about("Viscous drag on the rotation of this shaft, per unit of its speed, at the free end of the overhang. \
                It damps the rotation. Its mean loads the mesh like `drag_torque`."),
    quantity("shafts.<shaft>.drag_torque", Torque, NON_NEGATIVE, r#""0.4 N*m""#).or("0")
        .about("Constant torque against the rotation of this shaft, at the free end of the overhang. The motor keeps \
                the speed. Drag on the wheel's shaft adds to the motor's torque, and, divided by the base radius, to \
                the mesh force. Drag on the pinion's shaft adds to the motor's torque and loads no tooth."),
];
