//! The tables `ball` and `roller` of every bearing of `[train]`.

use crate::manifest::schema::key::{
    ANY, Bounds, Key, Kind, POSITIVE, bounds, integer, key, quantity,
};
use crate::units::Dimension::{Angle, Length, Pressure, Ratio};
use std::f64::consts::FRAC_PI_2;

const ANGLES: Bounds = bounds(-FRAC_PI_2, false, FRAC_PI_2, false);
const GROOVES: Bounds = bounds(0.5, true, 1.0, false);
const POISSON: Bounds = bounds(0.0, false, 0.5, false);
const CONTACT_ANGLE: &str = "Nominal contact angle. A bearing with an angle bears thrust of the shaft in one direction: along \
                             +z if it is positive, along -z if it is negative.";
const CLEARANCE: &str =
    "Radial clearance in operation, measured across the diameter. It is negative for a preload.";

/// The keys of both tables for a bearing; they replace the keys `$instead`.
#[rustfmt::skip]
macro_rules! of_bearing {
    ($at:literal, $instead:literal) => {
        &[
            key(concat!($at, ".ball"), Kind::Table, ANY, r#"{ count = 9, diameter = "11.1 mm", pitch_diameter = "43.5 mm" }"#)
                .otherwise("no balls")
                .about(concat!("Catalogue data of a ball bearing, instead of ", $instead, ". Its stiffness is that of its \
                        Hertz contacts under the mean load, `train.bearing_load`. All freedoms are coupled. The keys \
                        `axial` and `tilt` add springs beside the balls.")),
            integer(concat!($at, ".ball.count"), 1.0, 1000.0, "9")
                .about("Number of balls. The first one is on the shaft's x axis."),
            quantity(concat!($at, ".ball.diameter"), Length, POSITIVE, r#""11.1 mm""#)
                .about("Diameter of the balls."),
            quantity(concat!($at, ".ball.pitch_diameter"), Length, POSITIVE, r#""43.5 mm""#)
                .about("Diameter of the circle of the balls' centres."),
            key(concat!($at, ".ball.conformity"), Kind::List("2 numbers: inner ring, outer ring"), ANY, "[0.515, 0.525]").of_length(2).or("[0.52, 0.53]")
                .about("Radius of the groove over the diameter of the balls."),
            quantity(concat!($at, ".ball.conformity.*"), Ratio, GROOVES, "0.52"),
            quantity(concat!($at, ".ball.contact_angle"), Angle, ANGLES, r#""25 deg""#).or("0")
                .about(CONTACT_ANGLE),
            quantity(concat!($at, ".ball.clearance"), Length, ANY, r#""10 um""#).or("0")
                .about(CLEARANCE),
            quantity(concat!($at, ".ball.young_modulus"), Pressure, POSITIVE, r#""310 GPa""#).or(r#""207 GPa""#)
                .about("Young's modulus of balls and rings. The default is that of bearing steel."),
            quantity(concat!($at, ".ball.poisson_ratio"), Ratio, POISSON, "0.28").or("0.3")
                .about("Poisson's ratio of balls and rings."),
            key(concat!($at, ".roller"), Kind::Table, ANY, r#"{ count = 14, diameter = "9 mm", length = "10 mm", pitch_diameter = "54 mm" }"#)
                .otherwise("no rollers")
                .about(concat!("Catalogue data of a bearing with straight rollers of steel, instead of ", $instead, ". Its \
                        stiffness is that of its line contacts under the mean load, `train.bearing_load`. The keys `axial` \
                        and `tilt` add springs beside the rollers, such as lips that hold the shaft axially.")),
            integer(concat!($at, ".roller.count"), 1.0, 1000.0, "14")
                .about("Number of rollers. The first one is on the shaft's x axis."),
            quantity(concat!($at, ".roller.diameter"), Length, POSITIVE, r#""9 mm""#)
                .about("Diameter of the rollers. It must fit the pitch diameter. The stiffness of a line contact does not depend on it."),
            quantity(concat!($at, ".roller.length"), Length, POSITIVE, r#""10 mm""#)
                .about("Effective length of the rollers."),
            quantity(concat!($at, ".roller.pitch_diameter"), Length, POSITIVE, r#""54 mm""#)
                .about("Diameter of the circle of the rollers' centres."),
            quantity(concat!($at, ".roller.contact_angle"), Angle, ANGLES, r#""12 deg""#).or("0")
                .about(CONTACT_ANGLE),
            quantity(concat!($at, ".roller.clearance"), Length, ANY, r#""10 um""#).or("0")
                .about(CLEARANCE),
        ]
    };
}

/// The keys for a bearing of a shaft.
pub(super) const OF_SHAFT: &[Key] = of_bearing!("train.shaft.*.bearings.*", "`x` and `y`");

/// The keys for the bearing of a loose gear.
pub(super) const OF_LOOSE: &[Key] = of_bearing!("train.shaft.*.gears.*.loose", "`x` and `y`");

/// The keys for the bearing of a planet.
pub(super) const OF_PLANET: &[Key] = of_bearing!("train.planetary.*.bearing", "`radial`");
