//! `[grid]`, without its axes of model keys.

use crate::manifest::schema::key::{
    ANY, Key, Kind, POSITIVE, bounds, choice, integer, key, quantity, table,
};
use crate::units::Dimension::{AngularSpeed, Ratio, Torque};

/// Criteria for the refinement of a grid: the names of [`Criterion`](crate::manifest::Criterion).
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
        .about("The operating points: every combination of the values of the axes. Load (or torque) and speed are \
                always axes (load is 0 where a modal file without a mesh has none). A quoted numeric key of model, gear, \
                shafts, train, mesh, excitation, run or analyses, or a number of the modal file, can be another axis. A \
                text such as \"0.01 * speed^2\" computes an axis from others. An axis is one value, `{ values = [...] }`, or `{ from, to, count }`. A range is \
                evenly spaced. With spacing = \"log\" its ratios are equal. Both ends must then be above 0. Axes in \
                `tied` and columns of `points` advance together. An axis can also be a distribution, of which the \
                grid has `samples`: `{ normal = [mean, standard deviation] }`, `{ lognormal = [median, standard \
                deviation of the natural logarithm] }`, `{ uniform = [low, high] }`, or `{ empirical = [values] }` \
                with equally likely values, which may also be the path of a text file, relative to the manifest, \
                with a column of the name of the axis. `truncate = [low, high]` limits any of them. All \
                distributions advance together, and are combined with the other axes."),
    key("grid.load", Kind::Axis(Ratio), ANY, "{ from = 0.05, to = 0.30, count = 8 }").otherwise("none; required unless `torque` or a column of `points` gives it; 0 without a mesh")
        .about("Mean load as a fraction of the rated torque. Below 0 the drive coasts: the wheel drives the pinion on \
                the coast flanks."),
    key("grid.torque", Kind::Axis(Torque), ANY, r#"{ values = ["-8 N m", "2 N m", "15 N m"] }"#).otherwise("from `load`")
        .about("Mean torque on the pinion, instead of `load`. In a train: on the driving shaft. Below 0 the drive coasts on \
                its coast flanks. At 0 nothing presses the flanks together; a mesh computed from [gear] then needs \
                resolution = \"pairs\". Needs a rated torque, so it cannot be used with a modal file."),
    key("grid.speed", Kind::Axis(AngularSpeed), POSITIVE, r#"{ values = ["600 rad/s", "700 rad/s"] }"#).otherwise("none; required here or as a column of `points`")
        .about("Speed of the pinion. In a train: speed of the driving shaft, `train.driver`."),
    key("grid.tied", Kind::List("lists of the names of axes"), ANY, r#"[["load", "speed"]]"#).or("[]")
        .about("Axes that advance together instead of being combined. Each list names axes with the same number of \
                values: the first values of all make one point, the second values the next. Lists and ranges can be \
                tied, and values may repeat."),
    key("grid.tied.*", Kind::List("names of axes"), ANY, r#"["load", "speed"]"#),
    key("grid.tied.*.*", Kind::Text, ANY, r#""load""#),
    key("grid.points", Kind::Points, ANY, r#""points.csv""#).otherwise("none: the axes give the points")
        .about("Operating points one by one, instead of axes. Give a list of tables with the same keys, [{ torque = \
                \"5 N m\", speed = \"1000 rpm\" }, ...], or the path of a text file, relative to the manifest. The \
                header line of the file has names and units, such as speed [rpm],torque [N m],mesh.half_gap [um]. \
                Each further line is one point. Numbers without a unit are in SI. Commas, semicolons or tabs separate \
                columns, and lines that begin with # are comments. Any axis can be a column. Further axes of [grid] \
                are combined with the list. Each row is a separate point, even if two rows are equal."),
    integer("grid.samples", 1.0, 65536.0, "1000").otherwise("none; required if an axis is a distribution")
        .about("Number of samples of the distributions: points of a Sobol' sequence with an Owen scramble that depends \
                on `job.seed`. More samples keep those before them. A power of 2 is best."),
    choice("grid.design", &["sobol", "saltelli"], r#""saltelli""#).or(r#""sobol""#)
        .about("Rows of the distributions. `sobol`: one per sample. `saltelli`: for d distributions d + 2 per sample, \
                from which Sobol' indices of sensitivity follow, in the order of SALib (A, AB_1 ... AB_d, B). Only if an \
                axis is a distribution."),
    choice("grid.order", &["independent", "sweep-up", "sweep-down", "both"], r#""both""#).or(r#""independent""#)
        .about("Initial state of each point. `independent`: `run.initial`. `sweep-up`, `sweep-down`, `both`: the \
                final state of the previous point along one axis, upwards, downwards or both. Two motions coexist \
                where up and down differ."),
    key("grid.along", Kind::Text, ANY, r#""speed""#).otherwise("the last axis with several values")
        .about("The axis along which the state is carried: load, torque, speed, or a key of mesh, excitation or a modal file. Axes tied to it advance with it."),
    quantity("grid.displacement", Ratio, bounds(0.0, false, 1.0, false), "1e-4").or("1e-6")
        .about("Distance, in half gaps, by which the state carried from the previous point is displaced. Seed and \
                point determine its random direction. The displacement lets a sweep leave an orbit that has become \
                unstable. 0 carries the state unchanged. Only if `grid.order` carries the state."),
    table("grid.refine").otherwise("the grid is computed as given")
        .about("Adds points to the grid where results change. A cell is halved along an axis if points on its edges \
                along this axis differ. The same rule holds for its parts. Needs two axes with several values, each \
                `{ from, to, count }`. All points start from `run.initial`."),
    integer("grid.refine.levels", 1.0, 20.0, "7")
        .about("Largest number of halvings of the intervals of both axes."),
    key("grid.refine.by", Kind::List("words"), ANY, r#"["class", "lambda_max"]"#).or(r#"["class", "period"]"#)
        .about("Quantities to compare: class of motion, its period, or columns of points.parquet. A class that does not \
                hold (`not_converged`, `transient_chaos`) is not compared."),
    choice("grid.refine.by.*", &CRITERIA, r#""class""#),
    quantity("grid.refine.tolerance", Ratio, bounds(0.0, true, 1.0, false), "0.05").or("0.1")
        .about("Largest difference of a column on an edge, beyond five standard errors, as a fraction of the \
                column's range over the undivided grid. Only if `by` names a column."),
    integer("grid.refine.longest_period", 1.0, 1e6, "16").or("64")
        .about("Longest period, in mesh cycles, that is distinguished from others. Longer ones count as \
                quasi-periodic. Only if `by` names class or period."),
];
