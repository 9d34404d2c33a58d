//! The keys of the table `[excitation]`.

use crate::manifest::schema::key::{
    ANY, Key, Kind, NON_NEGATIVE, POSITIVE, choice, integer, key, quantity, table,
};
use crate::units::Dimension::{Angle, Length, Ratio, Torque};

#[rustfmt::skip]
pub(super) const KEYS: &[Key] = &[
    table("excitation").otherwise("only the mesh excites the drive")
        .about("Excitation of the drive, in addition to the varying stiffness of the mesh."),
    key("excitation.transmission_error", Kind::List("tables"), ANY, r#"[{ harmonic = 1, amplitude = "5 um" }]"#).or("[]")
        .about("Static transmission error, one table per harmonic of the mesh frequency: e = sum of amplitude cos(2 \
                pi harmonic t/T + phase), where T is the mesh period."),
    table("excitation.transmission_error.*"),
    integer("excitation.transmission_error.*.harmonic", 1.0, 1000.0, "2")
        .about("Multiple of the mesh frequency."),
    quantity("excitation.transmission_error.*.amplitude", Length, NON_NEGATIVE, r#""5 um""#)
        .about("Amplitude along the line of action."),
    quantity("excitation.transmission_error.*.phase", Angle, ANY, r#""90 deg""#).or("0")
        .about("Phase of the cosine at mesh phase 0."),
    key("excitation.coast_transmission_error", Kind::List("tables"), ANY, r#"[{ harmonic = 1, amplitude = "3 um" }]"#)
        .otherwise("`excitation.transmission_error`: an error of position moves both flanks")
        .about("Static transmission error of the coast flanks, with the same sign convention as on the drive flanks. \
                Only with mesh.coast_flank = \"mirrored\"."),
    table("excitation.coast_transmission_error.*"),
    integer("excitation.coast_transmission_error.*.harmonic", 1.0, 1000.0, "2")
        .about("Multiple of the mesh frequency."),
    quantity("excitation.coast_transmission_error.*.amplitude", Length, NON_NEGATIVE, r#""3 um""#)
        .about("Amplitude along the line of action."),
    quantity("excitation.coast_transmission_error.*.phase", Angle, ANY, r#""90 deg""#).or("0")
        .about("Phase of the cosine at mesh phase 0."),
    key("excitation.gear_error", Kind::List("tables"), ANY, r#"[{ shaft = "pinion", order = 1, amplitude = "10 um" }]"#).or("[]")
        .about("Transmission error at an order of a shaft, one table per order: e = sum of amplitude cos(order speed \
                t + phase), with the speed of that shaft. Order 1 is run-out, and its amplitude along the line of \
                action is the eccentricity. It adds to the other errors on both flanks."),
    table("excitation.gear_error.*"),
    choice("excitation.gear_error.*.shaft", &["pinion", "wheel"], r#""wheel""#)
        .about("The gear that has the error."),
    integer("excitation.gear_error.*.order", 1.0, 1000.0, "1")
        .about("Multiple of the speed of that shaft."),
    quantity("excitation.gear_error.*.amplitude", Length, NON_NEGATIVE, r#""10 um""#)
        .about("Amplitude along the line of action."),
    quantity("excitation.gear_error.*.phase", Angle, ANY, r#""90 deg""#).or("0")
        .about("Phase of the cosine at time 0."),
    table("excitation.pitch_deviation").otherwise("none")
        .about("Cumulative pitch deviations of the gears: the delay of each tooth, as a distance along the line of \
                action. Between teeth the error is the trigonometric polynomial through these values, without their \
                mean."),
    key("excitation.pitch_deviation.pinion", Kind::List("lengths, one per tooth"), ANY, r#"["0 um", "2 um", "-1 um"]"#)
        .otherwise("none")
        .about("Deviations of the pinion, in the order in which its teeth engage. The first tooth engages at mesh cycle 0."),
    quantity("excitation.pitch_deviation.pinion.*", Length, ANY, r#""2 um""#),
    key("excitation.pitch_deviation.wheel", Kind::List("lengths, one per tooth"), ANY, r#"["0 um", "2 um", "-1 um"]"#)
        .otherwise("none")
        .about("Deviations of the wheel, in the order in which its teeth engage. The first tooth engages at mesh cycle 0."),
    quantity("excitation.pitch_deviation.wheel.*", Length, ANY, r#""2 um""#),
    integer("excitation.table_harmonics", 0.0, 100.0, "10")
        .otherwise("none: the law of the mesh contains the exact error")
        .about("Number of harmonics that represent the transmission error of the loaded flanks in a computed mesh. 0 \
                omits the error. run.kernel = \"closed_modes\" needs it."),
    key("excitation.torque_ripple", Kind::List("tables"), ANY, r#"[{ shaft = "pinion", order = 2, amplitude = "3 N*m" }]"#).or("[]")
        .about("Fluctuating torque on a shaft, one table per order: T = sum of amplitude cos(order speed t + phase), \
                with the speed of that shaft."),
    table("excitation.torque_ripple.*"),
    choice("excitation.torque_ripple.*.shaft", &["pinion", "wheel"], r#""pinion""#)
        .about("Shaft on which the torque acts, at the end of its overhang. In a train, `pinion` is the driving shaft \
                and `wheel` the shaft of the second gear. The second gear must not be loose on that shaft."),
    quantity("excitation.torque_ripple.*.order", Ratio, POSITIVE, "2")
        .about("Multiple of the speed of that shaft. It need not be a whole number."),
    quantity("excitation.torque_ripple.*.amplitude", Torque, NON_NEGATIVE, r#""3 N*m""#)
        .about("Amplitude of the torque."),
    quantity("excitation.torque_ripple.*.phase", Angle, ANY, r#""90 deg""#).or("0")
        .about("Phase of the cosine at time 0."),
    key("excitation.imposed_motion", Kind::List("tables"), ANY, r#"[{ shaft = "pinion", order = 2, amplitude = "0.5 deg" }]"#).or("[]")
        .about("Uneven rotation that is imposed at a shaft, one table per order: the angle sum of amplitude cos(order angle + \
                phase) of that shaft, beside its mean rotation. The torque on the shaft moves the whole drive like a rigid body. A shaft of large \
                inertia, such as a flywheel, follows the angle itself. For the motion of a shaft end without reaction, give the end an \
                inertia of 1e6 kg*m^2."),
    table("excitation.imposed_motion.*"),
    choice("excitation.imposed_motion.*.shaft", &["pinion", "wheel"], r#""pinion""#)
        .about("Shaft on which the torque acts, as for `torque_ripple`."),
    quantity("excitation.imposed_motion.*.order", Ratio, POSITIVE, "2")
        .about("Multiple of the speed of that shaft. It need not be a whole number."),
    quantity("excitation.imposed_motion.*.amplitude", Angle, NON_NEGATIVE, r#""0.5 deg""#)
        .about("Amplitude of the angle."),
    quantity("excitation.imposed_motion.*.phase", Angle, ANY, r#""90 deg""#).or("0")
        .about("Phase of the cosine at time 0."),
    table("excitation.torque_curve").otherwise("none")
        .about("Torque of an engine over the angle of its shaft. Its harmonics act on the shaft like `torque_ripple`. Its \
                mean does not: the load gives the mean torque."),
    choice("excitation.torque_curve.shaft", &["pinion", "wheel"], r#""wheel""#).or(r#""pinion""#)
        .about("Shaft of the engine."),
    key("excitation.torque_curve.points", Kind::Points, ANY, r#""engine.csv""#)
        .about("The curve: a list of tables or the path of a text file, as for `grid.points`, with the columns `angle` and \
                `torque`. Straight lines connect the points, also the last with the first. Angle 0 is the position of the \
                shaft at time 0."),
    integer("excitation.torque_curve.revolutions", 1.0, 1000.0, "1").or("2")
        .about("Revolutions of the shaft after which the torque repeats. A four-stroke engine has 2, a two-stroke engine \
                1."),
    integer("excitation.torque_curve.harmonics", 1.0, 200.0, "40").or("20")
        .about("Number of harmonics. The first has the order 1 / `revolutions`."),
];
