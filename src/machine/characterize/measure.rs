//! Measures one item of the plan.

use super::drive::DefaultDrive;
use super::error::MeasurementError;
use super::measured::Measured;
use super::plan::{Item, StreamKernel};
use super::tables::BuiltTables;
use super::team::Pace;
use super::{chases, latency, loaded, mountain, operators, solver, streaming, transfer};
use crate::topology::Topology;

/// Measures an item once.
pub fn measure(
    topology: &Topology,
    default: &DefaultDrive,
    built_tables: &mut BuiltTables,
    item: &Item,
    pace: Pace,
) -> Result<Measured, MeasurementError> {
    match item {
        Item::Arithmetic { set, team } => streaming::arithmetic(topology, team, *set, pace),
        Item::Streams { team, lines, .. } => {
            streaming::streams(topology, team, &StreamKernel::available(), *lines, pace)
        }
        Item::Mixes { team, lines } => {
            streaming::streams(topology, team, &StreamKernel::mixes(), *lines, pace)
        }
        Item::Nodes {
            team,
            memory,
            lines,
        } => streaming::nodes(topology, team, *memory, *lines, pace),
        Item::Operators {
            thread,
            dimension,
            counts,
        } => operators::products(topology, *thread, *dimension, counts, pace),
        Item::Points {
            thread,
            mesh,
            counts,
        } => operators::points(topology, default, *thread, *mesh, counts, pace),
        Item::Solver {
            solver,
            sharing,
            modes,
            teams,
        } => solver::measure(
            topology,
            default,
            built_tables,
            *solver,
            *sharing,
            *modes,
            teams,
            pace,
        ),
        Item::Mountain {
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
        Item::Parallel {
            thread,
            sizes,
            walk,
        } => chases::parallel(topology, *thread, sizes, *walk, pace),
        Item::Percentiles {
            thread,
            sizes,
            walk,
        } => chases::percentiles(topology, *thread, sizes, *walk),
        Item::Loaded {
            team,
            lines,
            array,
            walk,
            pauses,
        } => loaded::measure(topology, team, *lines, *array, *walk, pauses, pace),
        Item::Transfer { pair, .. } => transfer::measure(topology, pair, pace),
    }
}
