//! `[continuation]`.

use crate::manifest::schema::key::{
    ANY, Key, Kind, MANY, bounds, choice, integer, key, quantity, table,
};
use crate::units::Dimension::{ModalDisplacement, ModalVelocity, Ratio};

#[rustfmt::skip]
pub(super) const KEYS: &[Key] = &[
    table("continuation").otherwise("`atlas follow` has nothing to do")
        .about("What `atlas follow` follows: periodic orbits, stable or not, over an axis of the grid, through their \
                bifurcations."),
    key("continuation.over", Kind::Text, ANY, r#""load""#).otherwise("the last axis with several values")
        .about("The axis that orbits are followed over, between its smallest and its largest value: load, speed, or a \
                continuous key. For every combination of values of the other axes there are branches of their own."),
    key("continuation.second", Kind::Text, ANY, r#""load""#).otherwise("no curves")
        .about("A second axis. Bifurcations found at its values are followed in the plane of both axes."),
    choice("continuation.curves", &["stable", "all"], r#""all""#).or(r#""stable""#)
        .about("Which bifurcations are followed over both axes: those next to which the branch is stable, which bound \
                the motions that a drive can settle on, or all."),
    integer("continuation.starts", 1.0, 10_000.0, "9").or("5")
        .about("Values of the axis, evenly between its ends, at which orbits are sought: the one next to static \
                equilibrium, and those that a trajectory settles on or comes near."),
    integer("continuation.transient", 0.0, MANY, "1000").or("300")
        .about("Mesh cycles of that trajectory before its returns are looked at."),
    integer("continuation.cycles", 1.0, MANY, "1000").or("300")
        .about("Mesh cycles among which near returns are looked for."),
    integer("continuation.longest_period", 1.0, 64.0, "8").or("4")
        .about("Longest period of the orbits sought and of the branches that begin where periods double, in mesh \
                cycles."),
    integer("continuation.guesses", 1.0, 1000.0, "4").or("2")
        .about("Newton searches for each period from the nearest returns."),
    integer("continuation.orbits", 10.0, 1e6, "10000").or("4000")
        .about("Most orbits of a branch, either way from its first."),
    integer("continuation.branches", 1.0, 1e5, "1000").or("100")
        .about("Most branches for each combination of values of the other axes."),
    quantity("continuation.step", Ratio, bounds(0.0, true, 0.5, false), "0.005").or("0.02")
        .about("Longest step along a branch or a curve, as a part of the axis's length."),
    key("continuation.states", Kind::List("tables"), ANY, "[{ at = 1000, period = 2, displacement = [0, 1e-5], velocity = [0, 0] }]").or("[]")
        .about("States next to orbits to begin with, a table for each."),
    table("continuation.states.*"),
    quantity("continuation.states.*.at", Ratio, ANY, "1000")
        .about("Value of the axis there, in its SI unit."),
    integer("continuation.states.*.period", 1.0, 1024.0, "2").or("1")
        .about("Period of the orbit, in mesh cycles."),
    key("continuation.states.*.displacement", Kind::List("numbers in m sqrt(kg), one a retained mode"), ANY, "[0, 1e-5]")
        .about("Modal displacements at the start of a mesh cycle, one for each retained mode, in m sqrt(kg)."),
    quantity("continuation.states.*.displacement.*", ModalDisplacement, ANY, "1e-5"),
    key("continuation.states.*.velocity", Kind::List("numbers in m sqrt(kg)/s, one a retained mode"), ANY, "[0, 0]")
        .about("Modal velocities there, in m sqrt(kg)/s."),
    quantity("continuation.states.*.velocity.*", ModalVelocity, ANY, "0"),
];
