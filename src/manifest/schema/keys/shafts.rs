//! `[shafts]`. What both shafts share may stand in the table of either one too.

use super::INSIDE_ONE;
use crate::manifest::schema::key::{
    ANY, Key, Kind, NON_NEGATIVE, POSITIVE, bounds, integer, key, quantity, table,
};
use crate::units::Dimension::{
    Density, Inertia, Length, Mass, Pressure, Ratio, Stiffness, TiltStiffness,
};

const BOTH: &str = "first bearing, second bearing";

/// Rigid kinds have no use for it, and none for its default.
const ELASTIC: &str = "none; required with kind = \"flexible\"";

#[rustfmt::skip]
pub(super) const KEYS: &[Key] = &[
    table("shafts").otherwise("an error, except with kind = \"modal\"")
        .about("Material, stations, bearings and pedestals of the shafts. What stands here holds for both \
                shafts; `[shafts.pinion]` and `[shafts.wheel]` override it key by key. A kind of model \
                reads what it needs and checks the rest."),
    quantity("shafts.young_modulus", Pressure, POSITIVE, r#""206 GPa""#).otherwise(ELASTIC)
        .about("Young's modulus of the shafts."),
    quantity("shafts.shear_modulus", Pressure, POSITIVE, r#""79 GPa""#).otherwise(ELASTIC)
        .about("Shear modulus of the shafts. With Young's modulus it must give a Poisson's ratio of at most 0.5."),
    quantity("shafts.density", Density, POSITIVE, r#""7850 kg/m^3""#)
        .about("Density of shafts and gear bodies."),
    quantity("shafts.shear_coefficient", Ratio, bounds(0.0, true, 1.0, false), "0.886").or("0.9")
        .about("Timoshenko's shear coefficient of the shafts' section; 0.9 is usual in rotordynamics for a \
                solid circle."),
    key("shafts.elements", Kind::List("3 integers: overhang, first bearing to gear, gear to second bearing"), ANY, "[3, 5, 7]")
        .of_length(3).otherwise(ELASTIC)
        .about("Beam elements of each stretch of a shaft. More of them make the highest modes more accurate."),
    integer("shafts.elements.*", 1.0, 100.0, "5"),
    quantity("shafts.span", Length, POSITIVE, r#""120 mm""#).on_either_shaft()
        .about("Distance between the two bearings."),
    quantity("shafts.overhang", Length, POSITIVE, r#""40 mm""#).on_either_shaft()
        .about("Length of the free end before the first bearing, which carries the end inertia."),
    quantity("shafts.gear_position", Ratio, INSIDE_ONE, "0.45").on_either_shaft()
        .otherwise("none; required with kinds that tilt or bend")
        .about("Where the gear sits, as a fraction of the span from the first bearing. Off the middle, tilt and \
                radial motion couple."),
    table("shafts.bearings").on_either_shaft().otherwise("an error, except with kind = \"torsional\"")
        .about("Linear springs of each bearing. One value holds for both bearings, a pair \
                `[first, second]` sets them apart."),
    quantity("shafts.bearings.x", Stiffness, POSITIVE, r#""1.25e8 N/m""#).or_pair(BOTH).on_either_shaft()
        .about("Radial stiffness along x, the line of centres from pinion to wheel."),
    quantity("shafts.bearings.y", Stiffness, POSITIVE, r#""1e8 N/m""#).or_pair(BOTH).on_either_shaft()
        .about("Radial stiffness along y, across the line of centres."),
    quantity("shafts.bearings.tilt", TiltStiffness, NON_NEGATIVE, r#""2e4 N*m/rad""#).or_pair(BOTH).on_either_shaft()
        .otherwise("none; required with kinds that tilt or bend")
        .about("Stiffness against tilting of the shaft in the bearing, about x and y alike."),
    key("shafts.bearings.axial", Kind::List("2 stiffnesses: first bearing, second bearing"), ANY, r#"["1e8 N/m", 0]"#)
        .of_length(2).on_either_shaft().otherwise("none; required with kinds that tilt or bend")
        .about("Stiffness along z, the axis of the shaft. At least one bearing must locate the shaft."),
    quantity("shafts.bearings.axial.*", Stiffness, NON_NEGATIVE, r#""1e8 N/m""#).on_either_shaft(),
    table("shafts.pedestals").on_either_shaft().otherwise("an error with kind = \"pedestal\"")
        .about("What each bearing stands on: a mass on springs to the ground. Only with kind = \"pedestal\"."),
    quantity("shafts.pedestals.x", Stiffness, POSITIVE, r#""4e8 N/m""#).or_pair(BOTH).on_either_shaft()
        .about("Stiffness of the pedestal along x, the line of centres."),
    quantity("shafts.pedestals.y", Stiffness, POSITIVE, r#""3e8 N/m""#).or_pair(BOTH).on_either_shaft()
        .about("Stiffness of the pedestal along y, across the line of centres."),
    quantity("shafts.pedestals.mass", Mass, POSITIVE, r#""3 kg""#).or_pair(BOTH).on_either_shaft()
        .about("Mass of the pedestal."),
    table("shafts.<shaft>")
        .about("What belongs to one shaft: `[shafts.pinion]` drives, `[shafts.wheel]` is driven. Keys of \
                `[shafts]` that both shafts share (span, overhang, gear_position, bearings, pedestals) may \
                stand here too and override what stands there."),
    quantity("shafts.<shaft>.diameter", Length, POSITIVE, r#""22 mm""#)
        .about("Diameter of the shaft, less than the pitch diameter of its gear."),
    quantity("shafts.<shaft>.end_inertia", Inertia, NON_NEGATIVE, r#""2e-3 kg*m^2""#)
        .about("Polar moment of inertia at the free end of the overhang: motor or driven machine."),
];
