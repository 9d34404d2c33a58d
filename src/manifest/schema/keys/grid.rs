//! `[grid]`, its axes of model keys left out.

use crate::manifest::schema::key::{ANY, Key, Kind, POSITIVE, choice, key, table};
use crate::units::Dimension::{AngularSpeed, Ratio};

#[rustfmt::skip]
pub(super) const KEYS: &[Key] = &[
    table("grid")
        .about("The operating points: every combination of the values of its axes. Besides load and speed, a \
                quoted key of model, gear, shafts, mesh, excitation or run that takes a number can be an axis."),
    key("grid.load", Kind::Axis(Ratio), ANY, "{ from = 0.05, to = 0.30, count = 8 }")
        .about("Mean load as a fraction of the rated torque."),
    key("grid.speed", Kind::Axis(AngularSpeed), POSITIVE, r#"{ values = ["600 rad/s", "700 rad/s"] }"#)
        .about("Speed of the pinion."),
    choice("grid.order", &["independent", "sweep-up", "sweep-down", "both"], r#""both""#).or(r#""independent""#)
        .about("Whether each point starts from `run.initial`, or from the state that the point before it along one \
                axis has reached, upwards, downwards or both. Where up and down differ, two motions coexist."),
    key("grid.along", Kind::Text, ANY, r#""speed""#).otherwise("the last axis with several values")
        .about("The axis along which the state is carried: load, speed, or a key of mesh or excitation."),
];
