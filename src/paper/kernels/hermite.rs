//! Certificates from rows, a cubic Hermite guess, and few products.
//!
//! Rows give δ, δ' and δ'' at eight nodes of a cell from the state at its start, without propagating it. With bounds
//! of δ'' and δ''' they certify most cells, which one product then crosses. Otherwise a second product moves the state
//! to the node before the interval without a certificate, and δ becomes a polynomial there. Its root is refined from
//! the cubic through the values and slopes at both ends of the interval.

use super::DenseError;
use super::cell_model::CellModel;
use super::cycle::Method;
use super::exits::{DeflectionAt, Verdict};
use super::exponential;
use super::generator::Generator;
use super::kernel::{ClassTables, Dense};
use super::matrix::{Operator, dot, padded};
use super::series::{BoundRows, Series, TERMS, judge_all, locate};
use super::show::Taylor;
use super::state_part::{Exit, StatePart};
use crate::model::Model;
use crate::propagate::Counters;
use faer::Mat;

/// Intervals of a cell.
const NODES: usize = 8;

/// Rows of guards: three at each node.
const ROWS: usize = 3 * NODES;

/// The kernel of certificates and Hermite guesses for one model.
pub type Hermite<'m> = Dense<'m, HermiteTables>;

/// Tables of this kernel.
#[derive(Debug)]
pub struct HermiteTables(ClassTables<HermiteTable>);

/// Operators of one class in one state.
#[derive(Debug)]
pub struct HermiteTable {
    /// `e^{LΔj/8}`, j = 1 … 8.
    nodes: Vec<Operator>,
    /// δ, δ', δ'' at the nodes.
    guards: Operator,
    bounds: BoundRows,
    curvature: Vec<f64>,
    duration: f64,
}

/// Scratch memory.
#[derive(Debug)]
pub struct HermiteScratch {
    next: Vec<f64>,
    guards: Vec<f64>,
    taylor: Taylor,
}

impl HermiteTable {
    fn new(generator: &Generator, rate: f64, duration: f64) -> Self {
        // Compute e^{LΔj/8} − I first, for its relative accuracy: see `exponential`.
        let part = exponential::increment(generator, rate, duration / NODES as f64);
        let d = part.nrows();
        let curvature = generator.curvature();
        let rows = [&generator.deflection, &generator.rate, &curvature];
        let rows = Mat::from_fn(3, d, |i, j| rows[i][j]);
        let mut guards = Mat::zeros(ROWS, d);
        let mut power = part.clone();
        let mut nodes = Vec::with_capacity(NODES);
        for node in 0..NODES {
            if node > 0 {
                power = exponential::after(&part, &power);
            }
            let node_map = exponential::plus_one(power.clone());
            guards
                .as_mut()
                .subrows_mut(3 * node, 3)
                .copy_from(&rows * &node_map);
            nodes.push(Operator::new(node_map.as_ref()));
        }
        Self {
            nodes,
            guards: Operator::new(guards.as_ref()),
            bounds: BoundRows::new(generator, rate, duration),
            curvature,
            duration,
        }
    }

    /// The last node not after a time, and the remaining time.
    fn split(&self, time: f64) -> (usize, f64) {
        let part = self.duration / NODES as f64;
        let node = ((time / part) as usize).min(NODES);
        (node, time - node as f64 * part)
    }
}

impl<'m> Hermite<'m> {
    /// Builds the kernel's tables for a model.
    ///
    /// * `cells`: smallest number of unit steps per mesh cycle; there are more if a cell would be too long.
    /// * `event_limit`: largest number of events in a mesh cycle; integration stops at more.
    ///
    /// # Errors
    /// [`DenseError`] if tables cannot represent the model, or the speed is too slow for them.
    pub fn new(model: &'m Model, cells: u32, event_limit: u32) -> Result<Self, DenseError> {
        let cell_model = CellModel::new(model, cells, HermiteTables::REACH, event_limit, None)?;
        let tables = ClassTables::new(&cell_model, |generator, class, _| {
            let duration = cell_model.grid.classes[class].duration;
            Ok(HermiteTable::new(generator, cell_model.grid.rate, duration))
        })?;
        let tables = HermiteTables(tables);
        Ok(Self { cell_model, tables })
    }
}

impl Method for HermiteTables {
    type Scratch = HermiteScratch;
    const REACH: f64 = 2.0;
    const FLIES: bool = false;

    fn operators(&self) -> impl Iterator<Item = &Operator> {
        (self.0.all()).flat_map(|table| table.nodes.iter().chain([&table.guards]))
    }

    fn scratch(&self, cell_model: &CellModel<'_>) -> HermiteScratch {
        let state = cell_model.layout.padded();
        HermiteScratch {
            next: vec![0.0; state],
            guards: vec![0.0; padded(ROWS)],
            taylor: Taylor::new(state),
        }
    }

    fn pass(
        &self,
        cell_model: &CellModel<'_>,
        stretch: &StatePart,
        z: &mut [f64],
        scratch: &mut HermiteScratch,
        counters: &mut Counters,
    ) -> Option<Exit> {
        let (table, _) = self.0.of(cell_model, stretch);
        let generator = cell_model.generator(stretch.cell, stretch.contact);
        let contacts = &cell_model.model.contacts;
        let bounds = table.bounds.at(z, stretch.noise);
        table.guards.apply(z, &mut scratch.guards);
        counters.guard_evaluations += NODES as u64;
        let part = table.duration / NODES as f64;
        let mut left = DeflectionAt {
            time: 0.0,
            deflection: [
                dot(&generator.deflection, z),
                dot(&generator.rate, z),
                dot(&table.curvature, z),
            ],
        };
        let (guards, _) = scratch.guards.as_chunks::<3>();
        let mut searched = false;
        for (node, &deflection) in guards[..NODES].iter().enumerate() {
            if left.time >= stretch.duration {
                break;
            }
            let right = DeflectionAt {
                time: (node + 1) as f64 * part,
                deflection,
            };
            if judge_all(stretch, contacts, [&left, &right], &bounds, node == 0) != Verdict::Clear {
                searched = true;
                // The polynomial starts from the state at the node before.
                let start = match node {
                    0 => &*z,
                    _ => {
                        table.nodes[node - 1].apply(z, &mut scratch.next);
                        counters.matvecs += 1;
                        &scratch.next
                    }
                };
                let series = Series::new(generator, start, TERMS, &mut scratch.taylor);
                let mut evaluations = 0;
                let mut guard = |time: f64| {
                    evaluations += 1;
                    series.at(time)
                };
                let length = part.min(stretch.duration - left.time);
                let here = |time: f64| DeflectionAt {
                    time,
                    deflection: series.at(time),
                };
                let ends = [&here(0.0), &here(length)];
                let found = locate(
                    stretch,
                    contacts,
                    ends,
                    &bounds,
                    node == 0,
                    &mut guard,
                    counters,
                );
                counters.guard_evaluations += evaluations;
                if let Some(exit) = found {
                    if node > 0 {
                        z.copy_from_slice(&scratch.next);
                    }
                    scratch.taylor.step(generator, exit.time, TERMS, z);
                    return Some(Exit {
                        time: left.time + exit.time,
                        ..exit
                    });
                }
            }
            left = right;
        }
        counters.certified += u64::from(!searched);
        self.follow(cell_model, stretch, stretch.duration, z, scratch, counters);
        None
    }

    fn follow(
        &self,
        cell_model: &CellModel<'_>,
        stretch: &StatePart,
        time: f64,
        x: &mut [f64],
        scratch: &mut HermiteScratch,
        counters: &mut Counters,
    ) {
        let (table, _) = self.0.of(cell_model, stretch);
        let (node, rest) = if stretch.whole && time == stretch.duration {
            (NODES, 0.0)
        } else {
            table.split(time)
        };
        if node > 0 {
            table.nodes[node - 1].apply(x, &mut scratch.next);
            x.copy_from_slice(&scratch.next);
            counters.matvecs += 1;
        }
        if rest > 0.0 {
            let generator = cell_model.generator(stretch.cell, stretch.contact);
            scratch.taylor.step(generator, rest, TERMS, x);
        }
    }
}
