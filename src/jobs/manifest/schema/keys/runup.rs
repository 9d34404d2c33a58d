//! The keys of the table `[runup]`.

use super::analyses::SIGNALS;
use crate::manifest::schema::key::{
    ANY, Key, Kind, NON_NEGATIVE, POSITIVE, bounds, choice, integer, key, quantity, table,
};
use crate::units::Dimension::{AngularSpeed, Ratio, Time};

#[rustfmt::skip]
pub(super) const KEYS: &[Key] = &[
    table("runup").otherwise("`atlas runup` has nothing to do")
        .about("A run-up or run-down that `atlas runup` computes: the speed of the pinion changes. The operating point \
                gives the drive and the load; its speed is not used. The torque that accelerates all inertia acts on the \
                pinion's shaft."),
    table("runup.speed").otherwise("none; required unless `points` is given")
        .about("A speed of the pinion that changes at a constant rate."),
    quantity("runup.speed.from", AngularSpeed, POSITIVE, r#""600 rpm""#)
        .about("First speed."),
    quantity("runup.speed.to", AngularSpeed, POSITIVE, r#""6000 rpm""#)
        .about("Last speed; a smaller one makes a run-down."),
    quantity("runup.speed.in", Time, bounds(0.0, true, 1e5, false), r#""10 s""#)
        .about("Time between them."),
    key("runup.points", Kind::Points, ANY, r#""test.csv""#).otherwise("none: `speed` gives the course")
        .about("The speed of the pinion over time, as a test bench records it, instead of `speed`. Give a list of tables \
                or the path of a text file, as for `grid.points`. Columns: `time`, `speed`, and `load` or `torque` where \
                the load changes, too. `torque` is that of the pinion without the torque that accelerates the drive. \
                The first time is the start. Monotone cubics through the points give the course between them, so that the \
                acceleration has no jumps."),
    quantity("runup.load", Ratio, ANY, "0.3").otherwise("the load of the operating point")
        .or_pair("start and end")
        .about("Load, as a fraction of the rated one, that changes at a constant rate."),
    key("runup.load_points", Kind::Points, ANY, r#"[{ speed = "600 rpm", load = 0.1 }, { speed = "6000 rpm", load = 0.3 }]"#)
        .otherwise("none: `load` gives the course")
        .about("Load over the speed or the time, instead of `load`: a list of tables or the path of a text file with the \
                columns `speed` or `time`, and `load` or `torque`. Monotone cubics connect the points. Beyond the first and \
                last point the load stays constant."),
    quantity("runup.settle", Time, NON_NEGATIVE, r#""1 s""#).or(r#""0.5 s""#)
        .about("Time at the first speed before the run-up. It is not recorded."),
    integer("runup.sample_rate", 100.0, 1e6, "25600").or("48000")
        .about("Samples per second of recorded signals."),
    integer("runup.revolutions", 1.0, 10_000.0, "8").or("4")
        .about("Revolutions of the pinion over which orders and levels are computed. These stretches overlap by half. \
                Orders have a Hann window."),
    key("runup.orders", Kind::List("orders"), ANY, "[1, 20, 40]").otherwise("mesh orders 1 to 5")
        .about("Orders of the pinion's rotation for order tracks; the number of its teeth is mesh order 1."),
    quantity("runup.orders.*", Ratio, bounds(0.0, false, 1e4, false), "20"),
    integer("runup.frequency_step", 1.0, 1000.0, "5").or("10")
        .about("Distance between lines of the spectrogram, in Hz."),
    key("runup.signals", Kind::List("signals"), ANY, r#"["force", "accelerations"]"#).or(r#"["force", "bearings"]"#)
        .about("Recorded signals. The same signals as for spectra are available."),
    choice("runup.signals.*", SIGNALS, r#""force""#),
];
