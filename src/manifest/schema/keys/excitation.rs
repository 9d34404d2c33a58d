//! `[excitation]`.

use crate::manifest::schema::key::{
    ANY, Key, Kind, NON_NEGATIVE, POSITIVE, choice, integer, key, quantity, table,
};
use crate::units::Dimension::{Angle, Length, Ratio, Torque};

#[rustfmt::skip]
pub(super) const KEYS: &[Key] = &[
    table("excitation").otherwise("nothing but the mesh excites the drive")
        .about("What excites the drive besides the changing stiffness of the mesh."),
    key("excitation.transmission_error", Kind::List("tables"), ANY, r#"[{ harmonic = 1, amplitude = "5 um" }]"#).or("[]")
        .about("Static transmission error, a table for each harmonic of the mesh frequency: \
                e = sum of amplitude cos(2 pi harmonic t/T + phase), T the mesh period."),
    table("excitation.transmission_error.*"),
    integer("excitation.transmission_error.*.harmonic", 1.0, 1000.0, "2")
        .about("Multiple of the mesh frequency."),
    quantity("excitation.transmission_error.*.amplitude", Length, NON_NEGATIVE, r#""5 um""#)
        .about("Amplitude along the line of action."),
    quantity("excitation.transmission_error.*.phase", Angle, ANY, r#""90 deg""#).or("0")
        .about("Phase of the cosine at mesh phase 0."),
    key("excitation.coast_transmission_error", Kind::List("tables"), ANY, r#"[{ harmonic = 1, amplitude = "3 um" }]"#)
        .otherwise("`excitation.transmission_error`: an error of position moves both flanks")
        .about("Static transmission error of the coast flanks, of the sign of that of the drive flanks. Only with \
                mesh.coast_flank = \"mirrored\"."),
    table("excitation.coast_transmission_error.*"),
    integer("excitation.coast_transmission_error.*.harmonic", 1.0, 1000.0, "2")
        .about("Multiple of the mesh frequency."),
    quantity("excitation.coast_transmission_error.*.amplitude", Length, NON_NEGATIVE, r#""3 um""#)
        .about("Amplitude along the line of action."),
    quantity("excitation.coast_transmission_error.*.phase", Angle, ANY, r#""90 deg""#).or("0")
        .about("Phase of the cosine at mesh phase 0."),
    integer("excitation.table_harmonics", 0.0, 100.0, "10")
        .otherwise("the error as it is, in the law of the mesh")
        .about("How many harmonics stand for the error of the loaded flanks that a computed mesh finds; 0 leaves \
                the error out. Kernels of tables need it."),
    key("excitation.torque_ripple", Kind::List("tables"), ANY, r#"[{ shaft = "pinion", order = 2, amplitude = "3 N*m" }]"#).or("[]")
        .about("Fluctuating torque on a shaft, a table for each order: \
                T = sum of amplitude cos(order speed t + phase), with the speed of that shaft."),
    table("excitation.torque_ripple.*"),
    choice("excitation.torque_ripple.*.shaft", &["pinion", "wheel"], r#""pinion""#)
        .about("The shaft that the torque acts on, at the end of its overhang."),
    quantity("excitation.torque_ripple.*.order", Ratio, POSITIVE, "2")
        .about("Multiple of the speed of that shaft; it need not be a whole number."),
    quantity("excitation.torque_ripple.*.amplitude", Torque, NON_NEGATIVE, r#""3 N*m""#)
        .about("Amplitude of the torque."),
    quantity("excitation.torque_ripple.*.phase", Angle, ANY, r#""90 deg""#).or("0")
        .about("Phase of the cosine at time 0."),
];
