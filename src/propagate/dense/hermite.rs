//! Certificates from rows, a cubic Hermite guess, and few products.
//!
//! Rows give δ, δ' and δ'' at eight nodes of a cell from the state at its start, without
//! propagating it: with a bound of δ'' they certify most cells, which are then crossed by one
//! product. Where they do not, the state is taken to the node before the exit by a second
//! product, the guard becomes a polynomial there, and its root is refined from the cubic through
//! values and slopes at the nodes.

use super::DenseError;
use super::course::Course;
use super::exits::{Sight, Verdict};
use super::exponential;
use super::generator::Generator;
use super::kernel::{Dense, Stock};
use super::march::{Exit, Method, Piece};
use super::matrix::{Operator, dot, padded};
use super::series::{BoundRows, Series, TERMS, judge_all, locate};
use super::show::Taylor;
use crate::model::Model;
use crate::propagate::Counters;
use faer::Mat;

/// Parts of a cell.
const NODES: usize = 8;

/// Rows of guards: three at each node.
const ROWS: usize = 3 * NODES;

/// The kernel of certificates and Hermite guesses for one model.
pub type Hermite<'m> = Dense<'m, Tables>;

/// Its tables.
#[derive(Debug)]
pub struct Tables(Stock<Table>);

/// Operators of one class in one state.
#[derive(Debug)]
pub struct Table {
    /// `e^{LΔj/8}`, j = 1 … 8.
    nodes: Vec<Operator<'static>>,
    /// δ, δ', δ'' at the nodes.
    guards: Operator<'static>,
    bounds: BoundRows,
    curvature: Vec<f64>,
    duration: f64,
}

/// Scratch memory.
#[derive(Debug)]
pub struct Scratch {
    next: Vec<f64>,
    guards: Vec<f64>,
    taylor: Taylor,
}

impl Table {
    fn new(generator: &Generator, rate: f64, duration: f64) -> Self {
        // Of e^{LΔj/8} − I: see `exponential`.
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

    /// The last node not after a time, and the rest.
    fn split(&self, time: f64) -> (usize, f64) {
        let part = self.duration / NODES as f64;
        let node = ((time / part) as usize).min(NODES);
        (node, time - node as f64 * part)
    }
}

impl<'m> Hermite<'m> {
    /// Builds the kernel's tables for a model.
    ///
    /// * `cells`: fewest unit steps a mesh cycle; more where a cell would be too long.
    /// * `event_limit`: most events in a mesh cycle before marching stops.
    ///
    /// # Errors
    /// Stiffness that varies within a segment, or a speed too slow for tables.
    pub fn new(model: &'m Model, cells: u32, event_limit: u32) -> Result<Self, DenseError> {
        let course = Course::new(model, cells, Tables::REACH, event_limit, None)?;
        let tables = Stock::new(&course, |generator, class, _| {
            let duration = course.grid.classes[class].duration;
            Ok(Table::new(generator, course.grid.rate, duration))
        })?;
        let tables = Tables(tables);
        Ok(Self { course, tables })
    }
}

impl Method for Tables {
    type Scratch = Scratch;
    const REACH: f64 = 2.0;
    const FLIES: bool = false;

    fn operators(&self) -> impl Iterator<Item = &Operator<'_>> {
        (self.0.all()).flat_map(|table| table.nodes.iter().chain([&table.guards]))
    }

    fn scratch(&self, course: &Course<'_>) -> Scratch {
        let state = course.layout.padded();
        Scratch {
            next: vec![0.0; state],
            guards: vec![0.0; padded(ROWS)],
            taylor: Taylor::new(state),
        }
    }

    fn pass(
        &self,
        course: &Course<'_>,
        piece: &Piece,
        z: &mut [f64],
        scratch: &mut Scratch,
        counters: &mut Counters,
    ) -> Option<Exit> {
        let (table, _) = self.0.of(course, piece);
        let generator = course.generator(piece.cell, piece.contact);
        let half_gap = course.model.half_gap;
        let bounds = table.bounds.at(z, piece.noise);
        table.guards.apply(z, &mut scratch.guards);
        counters.guard_evaluations += NODES as u64;
        let part = table.duration / NODES as f64;
        let mut left = Sight {
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
            if left.time >= piece.duration {
                break;
            }
            let right = Sight {
                time: (node + 1) as f64 * part,
                deflection,
            };
            if judge_all(piece, half_gap, [&left, &right], &bounds, node == 0) != Verdict::Clear {
                searched = true;
                // The state at the node before: the polynomial starts from there.
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
                let length = part.min(piece.duration - left.time);
                let sight = |time: f64| Sight {
                    time,
                    deflection: series.at(time),
                };
                let ends = [&sight(0.0), &sight(length)];
                let found = locate(
                    piece,
                    half_gap,
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
        self.follow(course, piece, piece.duration, z, scratch, counters);
        None
    }

    fn follow(
        &self,
        course: &Course<'_>,
        piece: &Piece,
        time: f64,
        x: &mut [f64],
        scratch: &mut Scratch,
        counters: &mut Counters,
    ) {
        let (table, _) = self.0.of(course, piece);
        let (node, rest) = match piece.whole && time == piece.duration {
            true => (NODES, 0.0),
            false => table.split(time),
        };
        if node > 0 {
            table.nodes[node - 1].apply(x, &mut scratch.next);
            x.copy_from_slice(&scratch.next);
            counters.matvecs += 1;
        }
        if rest > 0.0 {
            let generator = course.generator(piece.cell, piece.contact);
            scratch.taylor.step(generator, rest, TERMS, x);
        }
    }
}
