//! Measures one item of the plan.

use super::drive::DefaultDrive;
use super::plan::Item;
use super::solver::{self, Work};
use super::tables::BuiltTables;
use super::team::{Pace, Worked};
use super::trouble::Trouble;
use super::{latency, mountain, operators, streaming};
use crate::topology::Topology;

/// What one measurement of an item gave.
#[derive(Debug, Default)]
pub struct Measured {
    /// Times of a unit of work, for every figure of the item \[s\].
    pub times: Vec<Vec<f64>>,
    /// Bytes of one table, where it has tables.
    pub bytes: usize,
    /// Work of a mesh cycle, where kernels integrate.
    pub work: Work,
    /// Why threads could not be bound, where they could not.
    pub unbound: Option<String>,
}

/// Measures an item once.
pub fn measure(
    topology: &Topology,
    default: &DefaultDrive,
    built_tables: &mut BuiltTables,
    item: &Item,
    pace: Pace,
) -> Result<Measured, Trouble> {
    let plain = |worked: Worked<()>| Measured {
        times: worked.times,
        unbound: worked.unbound,
        ..Measured::default()
    };
    let over = |mut measured: Measured, units: &[f64]| {
        for (times, units) in measured.times.iter_mut().zip(units) {
            times.iter_mut().for_each(|time| *time /= units);
        }
        measured
    };
    let rotated = |rotated: operators::Rotated| Measured {
        bytes: rotated.bytes,
        ..plain(rotated.worked)
    };
    Ok(match item {
        Item::Arithmetic { set, team } => {
            let (worked, operations) = streaming::arithmetic(topology, team, *set, pace)?;
            over(plain(worked), &[operations as f64])
        }
        Item::Streams { team, lines, .. } => {
            plain(streaming::streams(topology, team, *lines, pace)?)
        }
        Item::Nodes {
            team,
            memory,
            lines,
        } => plain(streaming::nodes(topology, team, *memory, *lines, pace)?),
        Item::Operators {
            seat,
            dimension,
            counts,
        } => rotated(operators::products(
            topology, *seat, *dimension, counts, pace,
        )?),
        Item::Points { seat, mesh, counts } => rotated(operators::points(
            topology, default, *seat, *mesh, counts, pace,
        )?),
        Item::Solver {
            solver,
            sharing,
            modes,
            teams,
        } => {
            let integrated = solver::measure(
                topology,
                default,
                built_tables,
                *solver,
                *sharing,
                *modes,
                teams,
                pace,
            )?;
            Measured {
                times: integrated.times,
                bytes: integrated.bytes,
                work: integrated.work,
                unbound: integrated.unbound,
            }
        }
        Item::Mountain {
            seat,
            lines,
            strides,
        } => {
            let (worked, read) = mountain::measure(topology, *seat, *lines, strides, pace)?;
            let units: Vec<f64> = read.iter().map(|&lines| lines as f64).collect();
            over(plain(worked), &units)
        }
        Item::Latency {
            seat,
            memory,
            sizes,
            walk,
        } => {
            let worked = latency::measure(topology, *seat, *memory, sizes, *walk, pace)?;
            over(plain(worked), &vec![latency::LOADS as f64; sizes.len()])
        }
    })
}
