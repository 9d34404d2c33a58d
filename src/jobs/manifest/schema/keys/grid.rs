//! `[grid]`, its axes of model keys left out.

use crate::manifest::schema::key::{
    ANY, Key, Kind, POSITIVE, bounds, choice, integer, key, quantity, table,
};
use crate::units::Dimension::{AngularSpeed, Ratio, Torque};

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
        .about("The operating points: every combination of the values of its axes. Besides load (or torque) and speed, a \
                quoted key of model, gear, shafts, train, mesh, excitation or run that takes a number can be an axis. An \
                axis is one value, `{ values = [...] }`, or `{ from, to, count }`: so many values from end to end, evenly \
                spaced, or with spacing = \"log\" by equal ratios, which takes both ends above 0. Axes of `tied` and columns of \
                `points` advance in step."),
    key("grid.load", Kind::Axis(Ratio), ANY, "{ from = 0.05, to = 0.30, count = 8 }").otherwise("none; load, torque or a column of either is required")
        .about("Mean load as a fraction of the rated torque. Below 0 the drive coasts: the wheel drives the pinion, on the \
                coast flanks."),
    key("grid.torque", Kind::Axis(Torque), ANY, r#"{ values = ["-8 N m", "2 N m", "15 N m"] }"#).otherwise("from `load`")
        .about("Mean torque on the pinion, instead of `load`: below 0 the drive coasts on its coast flanks, at 0 nothing \
                presses the flanks together (a mesh computed from [gear] then needs resolution = \"pairs\"). Needs a rated \
                torque, which a modal file does not have."),
    key("grid.speed", Kind::Axis(AngularSpeed), POSITIVE, r#"{ values = ["600 rad/s", "700 rad/s"] }"#).otherwise("none; required here or as a column of `points`")
        .about("Speed of the pinion."),
    key("grid.tied", Kind::List("lists of the names of axes"), ANY, r#"[["load", "speed"]]"#).or("[]")
        .about("Axes that advance in step instead of being combined: each list names axes with equally many values, the \
                first values of all make one point, the second ones the next. Lists and ranges may be tied; values may come again."),
    key("grid.tied.*", Kind::List("names of axes"), ANY, r#"["load", "speed"]"#),
    key("grid.tied.*.*", Kind::Text, ANY, r#""load""#),
    key("grid.points", Kind::Points, ANY, r#""points.csv""#).otherwise("no list: the points are those of the axes")
        .about("Operating points one by one: a list of tables with the same keys, [{ torque = \"5 N m\", speed = \"1000 rpm\" }, ...], \
                or the path of a text file, relative to the manifest, as a spreadsheet writes it: a head line with the names and units, \
                speed [rpm],torque [N m],mesh.half_gap [um], then a line of numbers for each point. Numbers without a unit are in SI; \
                columns are parted by commas, semicolons or tabs; lines that begin with # are remarks. Any axis can be a column; further \
                axes of [grid] are combined with the list. Each row is a point of its own, an equal one too."),
    choice("grid.order", &["independent", "sweep-up", "sweep-down", "both"], r#""both""#).or(r#""independent""#)
        .about("Whether each point starts from `run.initial`, or from the state that the point before it along one \
                axis has reached, upwards, downwards or both. Where up and down differ, two motions coexist."),
    key("grid.along", Kind::Text, ANY, r#""speed""#).otherwise("the last axis with several values")
        .about("The axis along which the state is carried: load, torque, speed, or a key of mesh or excitation. Tied axes go with it."),
    quantity("grid.displacement", Ratio, bounds(0.0, false, 1.0, false), "1e-4").or("1e-6")
        .about("Distance, in half gaps, by which the state that a point takes over from the point before it is displaced, \
                in a random direction that seed and point decide. A sweep so leaves an orbit that has become unstable. \
                0 takes over the state as it is. Only where `grid.order` carries the state."),
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
