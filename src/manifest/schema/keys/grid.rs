//! `[grid]`, its axes of model keys left out.

use crate::manifest::schema::key::{
    ANY, Key, Kind, POSITIVE, bounds, choice, integer, key, quantity, table,
};
use crate::units::Dimension::{AngularSpeed, Ratio};

/// What a grid can be refined by: the names of [`Criterion`](crate::manifest::Criterion).
pub(in crate::manifest) const CRITERIA: [&str; 9] = [
    "class",
    "period",
    "lambda_max",
    "events_per_cycle",
    "deflection_mean",
    "deflection_rms",
    "force_std",
    "impact_rate",
    "impact_velocity",
];

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
    table("grid.refine").otherwise("the grid is computed as it is")
        .about("Points between those of the grid, only where they are needed: a cell whose corners differ is divided \
                into four, and these again. Two axes with several values, each `{ from, to, count }`; all points start \
                from `run.initial`."),
    integer("grid.refine.levels", 1.0, 20.0, "7")
        .about("How often the intervals of both axes may be halved."),
    key("grid.refine.by", Kind::List("words"), ANY, r#"["class", "lambda_max"]"#).or(r#"["class", "period"]"#)
        .about("What is compared: kind of motion, its period, or columns of points.parquet."),
    choice("grid.refine.by.*", &CRITERIA, r#""class""#),
    quantity("grid.refine.tolerance", Ratio, bounds(0.0, true, 1.0, false), "0.05").or("0.1")
        .about("How far a column may differ between corners, beyond five standard errors, as a part of what it \
                spans over the points of the undivided grid. Only where `by` names a column."),
    integer("grid.refine.longest_period", 1.0, 1e6, "16").or("64")
        .about("Longest period in mesh cycles that is told from others; longer ones count as quasi-periodic. Only where \
                `by` names class or period."),
];
