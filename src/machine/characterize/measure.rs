//! Measures one item of the plan.

use super::drive::DefaultDrive;
use super::error::MeasurementError;
use super::measured::Measured;
use super::plan::Item;
use super::team::RepetitionTime;
use super::{latency, mountain, solver, streaming};
use crate::topology::Topology;

/// Measures an item once.
pub fn measure(
    topology: &Topology,
    default: &DefaultDrive,
    item: &Item,
    pace: RepetitionTime,
) -> Result<Measured, MeasurementError> {
    match item {
        Item::Arithmetic { set, team } => streaming::arithmetic(topology, team, *set, pace),
        Item::Streams { team, lines, .. } => streaming::streams(topology, team, *lines, pace),
        Item::Nodes {
            team,
            memory,
            lines,
        } => streaming::nodes(topology, team, *memory, *lines, pace),
        Item::Solver { campaign, teams } => {
            solver::measure(topology, default, campaign, teams, pace)
        }
        Item::MemoryMountain {
            thread,
            lines,
            strides,
        } => mountain::measure(topology, *thread, *lines, strides, pace),
        Item::Latency {
            thread,
            memory,
            sizes,
            walk,
        } => latency::measure(topology, *thread, *memory, sizes, *walk, pace),
    }
}
