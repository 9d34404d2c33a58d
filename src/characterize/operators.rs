//! Kernels that go round a set of tables, as a mesh cycle goes round its segments or a campaign
//! round its points: what a product costs while the set fits a cache, and when it does not.

use super::drive::{self, DefaultDrive};
use super::plan::{Mesh, Seat};
use super::streaming::checked;
use super::team::{self, Pace, Worked};
use super::trouble::Trouble;
use crate::model::{OperatingPoint, TrajectoryState};
use crate::propagate::{Counters, Kernel, Operator, Tangents, Volterra};
use crate::topology::Topology;
use faer::Mat;
use std::time::Duration;

/// How long a repetition takes, about.
const REPETITION: Duration = Duration::from_micros(500);

/// Mesh cycles at an operating point before the next one: a campaign stays for hundreds.
const STAY: usize = 16;

/// Modes of the points that rotate.
pub const MODES: usize = 40;

/// Times of what was repeated, over the pieces of a repetition.
#[derive(Debug)]
pub struct Rotated {
    /// Times of a piece, for every count \[s\].
    pub worked: Worked<()>,
    /// Bytes of one table.
    pub bytes: usize,
}

/// A vector that operators are applied to in turn.
struct OperatorCycle {
    operators: Vec<Operator<'static>>,
    x: Vec<f64>,
    y: Vec<f64>,
    at: usize,
    applied: usize,
    /// Products of a repetition, a number a count.
    products: Vec<usize>,
}

impl OperatorCycle {
    /// So many cyclic shifts of a vector 0, 1, 2 …: products are exact, and their number can be
    /// read off the vector.
    fn new(dimension: usize, count: usize) -> Self {
        let shift = Mat::from_fn(dimension, dimension, |i, j| {
            f64::from(u8::from(j == (i + 1) % dimension))
        });
        let operators = (0..count).map(|_| Operator::new(shift.as_ref())).collect();
        // Rows are padded to lane groups of eight.
        let padded = dimension.next_multiple_of(8);
        Self {
            operators,
            x: (0..padded).map(|i| i as f64).collect(),
            y: vec![0.0; padded],
            at: 0,
            applied: 0,
            products: Vec::new(),
        }
    }

    fn turn(&mut self, count: usize, products: usize) {
        for _ in 0..products {
            self.at = if self.at + 1 < count { self.at + 1 } else { 0 };
            self.operators[self.at].apply(&self.x, &mut self.y);
            std::mem::swap(&mut self.x, &mut self.y);
        }
        self.applied += products;
    }

    fn right(&self, dimension: usize) -> bool {
        let shown = self.x[..dimension].iter().enumerate();
        shown.fold(true, |right, (i, &x)| {
            right && x == ((i + self.applied) % dimension) as f64
        })
    }
}

/// Times of a dense product over rotating operators.
pub fn products(
    topology: &Topology,
    seat: Seat,
    dimension: usize,
    counts: &[usize],
    pace: Pace,
) -> Result<Rotated, Trouble> {
    let most = counts.iter().copied().max().unwrap_or(1);
    let worked = team::work(
        topology,
        &[seat],
        counts.len(),
        pace,
        |_| {
            let mut wheel = OperatorCycle::new(dimension, most);
            for &count in counts {
                let products = team::rounds_for(REPETITION, |n| wheel.turn(count, n));
                wheel.products.push(products);
            }
            Ok(wheel)
        },
        // Once round, so that what fits a cache is there.
        |wheel: &mut OperatorCycle, task| wheel.turn(counts[task], counts[task]),
        |wheel: &mut OperatorCycle, task| wheel.turn(counts[task], wheel.products[task]),
        |wheel| {
            let bytes = wheel.operators[0].bytes();
            let pieces = wheel.products.iter().map(|&n| n as f64).collect();
            (wheel.right(dimension), bytes, pieces)
        },
    )?;
    rotated(worked, "dense products")
}

/// What a member found: whether its results were right, bytes of one table, pieces of a
/// repetition for every count.
type Found = (bool, usize, Vec<f64>);

/// Times over the pieces of a repetition, if the results were right.
fn rotated(worked: Worked<Found>, what: &'static str) -> Result<Rotated, Trouble> {
    let first = worked.results.first();
    let (bytes, pieces) = first.map_or((0, Vec::new()), |(_, bytes, pieces)| {
        (*bytes, pieces.clone())
    });
    let right = Worked {
        results: worked.results.iter().map(|(right, ..)| *right).collect(),
        times: worked.times,
        unbound: worked.unbound,
    };
    let mut worked = checked(right, what)?;
    for (times, pieces) in worked.times.iter_mut().zip(pieces) {
        times.iter_mut().for_each(|time| *time /= pieces);
    }
    Ok(Rotated { worked, bytes })
}

/// Kernels with tables of their own that are integrated in turn, the same cycles each.
struct Round<'m> {
    kernels: Vec<Volterra<'m>>,
    start: TrajectoryState,
    at: usize,
    /// Stays of a repetition, a number a count.
    stays: Vec<usize>,
    stopped: bool,
}

impl Round<'_> {
    /// Advances so many cycles at the next points, always from the same start; gives the windows
    /// that they took.
    fn advance(&mut self, count: usize, stays: usize, cycles: usize) -> u64 {
        let mut counters = Counters::default();
        let mut workspace = self.kernels[0].workspace();
        let mut trajectory = self.start.clone();
        for _ in 0..stays {
            self.at = if self.at + 1 < count { self.at + 1 } else { 0 };
            trajectory.clone_from(&self.start);
            for _ in 0..cycles {
                let ended = self.kernels[self.at].advance_cycle(
                    &mut trajectory,
                    &mut Tangents::none(),
                    &mut workspace,
                    &mut (),
                    &mut counters,
                );
                self.stopped |= ended.is_err();
            }
        }
        counters.windows
    }
}

/// Times of a window of the structured kernel over rotating operating points: all with the same
/// numbers, each with memory of its own.
pub fn points(
    topology: &Topology,
    default: &DefaultDrive,
    seat: Seat,
    mesh: Mesh,
    counts: &[usize],
    pace: Pace,
) -> Result<Rotated, Trouble> {
    let most = counts.iter().copied().max().unwrap_or(1);
    let point = OperatingPoint {
        load: 0.1,
        speed: 1200.0,
    };
    let model = default.model(&default.structure(MODES)?, mesh, point)?;
    let start = drive::settled(&model)?;
    let worked = team::work(
        topology,
        &[seat],
        counts.len(),
        pace,
        |_| {
            let mut round = Round {
                kernels: (0..most).map(|_| drive::volterra(&model)).collect(),
                start: start.clone(),
                at: 0,
                stays: Vec::new(),
                stopped: false,
            };
            for &count in counts {
                let stays = team::rounds_for(REPETITION, |stays| {
                    round.advance(count, stays, STAY);
                });
                round.stays.push(stays);
            }
            Ok(round)
        },
        // Once round, so that what fits a cache is there.
        |round: &mut Round<'_>, task| {
            round.advance(counts[task], counts[task], 1);
        },
        |round: &mut Round<'_>, task| {
            round.advance(counts[task], round.stays[task], STAY);
        },
        |mut round| {
            let windows = round.advance(1, 1, STAY) as f64;
            let pieces: Vec<f64> = round.stays.iter().map(|&n| n as f64 * windows).collect();
            (!round.stopped, round.kernels[0].bytes(), pieces)
        },
    )?;
    rotated(worked, "integrating in turn")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wheel_counts_its_products() {
        let mut wheel = OperatorCycle::new(31, 5);
        wheel.turn(5, 7);
        wheel.turn(2, 100);
        assert!(wheel.right(31));
        assert_eq!(wheel.x[0], (107 % 31) as f64);
        wheel.applied += 1;
        assert!(!wheel.right(31));
    }
}
