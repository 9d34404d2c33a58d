//! The keys of the table `[continuation]`.

use crate::manifest::schema::key::{
    ANY, Key, Kind, LARGEST_COUNT, bounds, choice, integer, key, quantity, table,
};
use crate::units::Dimension::{ModalDisplacement, ModalVelocity, Ratio};

#[rustfmt::skip]
pub(super) const KEYS: &[Key] = &[
    table("continuation").otherwise("`atlas follow` has nothing to do")
        .about("Periodic orbits, stable or not, that `atlas follow` follows along an axis of the grid and through \
                their bifurcations."),
    key("continuation.over", Kind::Text, ANY, r#""load""#).otherwise("the last axis with several values")
        .about("The axis along which orbits are followed, between its smallest and its largest value: load, speed, or \
                a continuous key. Each combination of values of the other axes has separate branches."),
    key("continuation.second", Kind::Text, ANY, r#""load""#).otherwise("no curves")
        .about("A second axis. Bifurcations found at its values are followed in the plane of both axes."),
    choice("continuation.curves", &["stable", "all"], r#""all""#).or(r#""stable""#)
        .about("Bifurcations to follow in the plane of both axes. `stable`: bifurcations next to a stable part of a \
                branch. They bound the motions on which a drive can settle. `all`: every bifurcation."),
    integer("continuation.starts", 1.0, 10_000.0, "9").or("5")
        .about("Number of values of the axis, evenly spaced between its ends, at which orbits are sought. Each search \
                starts near static equilibrium, from the orbit on which a trajectory settles, and from orbits near \
                the trajectory."),
    integer("continuation.transient", 0.0, LARGEST_COUNT, "1000").or("300")
        .about("Mesh cycles of the trajectory of a start (see `starts`) that are discarded before the search for close \
                returns."),
    integer("continuation.cycles", 1.0, LARGEST_COUNT, "1000").or("300")
        .about("Mesh cycles of this trajectory that are then searched for close returns."),
    integer("continuation.longest_period", 1.0, 64.0, "8").or("4")
        .about("Longest period, in mesh cycles, of the orbits sought and of the branches that start at period \
                doublings."),
    integer("continuation.guesses", 1.0, 1000.0, "4").or("2")
        .about("Number of Newton searches per period, from the closest returns."),
    integer("continuation.orbits", 10.0, 1e6, "10000").or("4000")
        .about("Largest number of orbits of a branch in each direction from its first orbit."),
    integer("continuation.branches", 1.0, 1e5, "1000").or("100")
        .about("Largest number of branches per combination of values of the other axes."),
    quantity("continuation.step", Ratio, bounds(0.0, true, 0.5, false), "0.005").or("0.02")
        .about("Longest step along a branch or a curve, as a fraction of the length of the axis."),
    key("continuation.states", Kind::List("tables"), ANY, "[{ at = 1000, period = 2, displacement = [0, 1e-5], velocity = [0, 0] }]").or("[]")
        .about("States near orbits from which branches start, one table per state."),
    table("continuation.states.*"),
    quantity("continuation.states.*.at", Ratio, ANY, "1000")
        .about("Value of the axis at this state, in its SI unit."),
    integer("continuation.states.*.period", 1.0, 1024.0, "2").or("1")
        .about("Period of the orbit, in mesh cycles."),
    key("continuation.states.*.displacement", Kind::List("numbers in m sqrt(kg), one per retained mode"), ANY, "[0, 1e-5]")
        .about("Modal displacements at the start of a mesh cycle, one per retained mode, in m sqrt(kg)."),
    quantity("continuation.states.*.displacement.*", ModalDisplacement, ANY, "1e-5"),
    key("continuation.states.*.velocity", Kind::List("numbers in m sqrt(kg)/s, one per retained mode"), ANY, "[0, 0]")
        .about("Modal velocities at the start of a mesh cycle, one per retained mode, in m sqrt(kg)/s."),
    quantity("continuation.states.*.velocity.*", ModalVelocity, ANY, "0"),
];
