//! Kernels that go round a set of tables, as a mesh cycle goes round its segments or a campaign
//! round its points: what a product costs while the set fits a cache, and when it does not.

use super::drive::{self, DefaultDrive};
use super::error::MeasurementError;
use super::measured::Measured;
use super::plan::Mesh;
use super::team::{self, HardwareThread, Pace, Worked};
use crate::model::{OperatingPoint, TrajectoryState};
use crate::propagate::{Counters, Kernel, Volterra};
use crate::topology::Topology;
use faer::Mat;
use gearatlas_paper::kernels::Operator;
use std::time::Duration;

/// How long a repetition takes, about.
const REPETITION: Duration = Duration::from_micros(500);

/// Mesh cycles at an operating point before the next one: a campaign stays for hundreds.
const STAY: u64 = 16;

/// Modes of the points that rotate.
pub const MODES: usize = 40;

/// A vector that operators are applied to in turn.
struct OperatorRotation {
    operators: Vec<Operator<'static>>,
    x: Vec<f64>,
    y: Vec<f64>,
    at: usize,
    applied: usize,
    /// Products of a repetition, a number a count.
    products: Vec<usize>,
}

impl OperatorRotation {
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
    thread: HardwareThread,
    dimension: usize,
    counts: &[usize],
    pace: Pace,
) -> Result<Measured, MeasurementError> {
    let most = counts.iter().copied().max().unwrap_or(1);
    let worked = team::work(
        topology,
        &[thread],
        counts.len(),
        pace,
        |_| {
            let mut rotation = OperatorRotation::new(dimension, most);
            for &count in counts {
                let products = team::rounds_for(REPETITION, |n| rotation.turn(count, n));
                rotation.products.push(products);
            }
            Ok(rotation)
        },
        // Once round, so that what fits a cache is there.
        |rotation: &mut OperatorRotation, task| rotation.turn(counts[task], counts[task]),
        |rotation: &mut OperatorRotation, task| {
            rotation.turn(counts[task], rotation.products[task])
        },
        |rotation| {
            let bytes = rotation.operators[0].bytes();
            let pieces = rotation.products.iter().map(|&n| n as f64).collect();
            (rotation.right(dimension), (bytes, pieces))
        },
    )?;
    rotated(worked, "dense products")
}

/// Times of a piece, if the results were right: the one member tells the bytes of one table, and
/// the pieces of a repetition for every count.
fn rotated(
    worked: Worked<(bool, (usize, Vec<f64>))>,
    what: &'static str,
) -> Result<Measured, MeasurementError> {
    let mut checked = worked.checked(what)?;
    let (bytes, pieces) = checked.results.pop().unwrap_or_default();
    Ok(Measured {
        bytes,
        ..checked.per_unit(&pieces).into()
    })
}

/// Kernels with tables of their own that are integrated in turn, the same cycles each.
struct PointRotation<'m> {
    kernels: Vec<Volterra<'m>>,
    start: TrajectoryState,
    at: usize,
    /// Stays of a repetition, a number a count.
    stays: Vec<usize>,
    stopped: bool,
}

impl PointRotation<'_> {
    /// Advances so many cycles at the next points, always from the same start; gives the windows
    /// that they took.
    fn advance(&mut self, count: usize, stays: usize, cycles: u64) -> u64 {
        let mut counters = Counters::default();
        let mut workspace = self.kernels[0].workspace();
        let mut trajectory = self.start.clone();
        for _ in 0..stays {
            self.at = if self.at + 1 < count { self.at + 1 } else { 0 };
            trajectory.clone_from(&self.start);
            let kernel = &self.kernels[self.at];
            let ended = kernel.advance(
                cycles,
                &mut trajectory,
                &mut workspace,
                &mut (),
                &mut counters,
            );
            self.stopped |= ended.is_err();
        }
        counters.windows
    }
}

/// Times of a window of the structured kernel over rotating operating points: all with the same
/// numbers, each with memory of its own.
pub fn points(
    topology: &Topology,
    default: &DefaultDrive,
    thread: HardwareThread,
    mesh: Mesh,
    counts: &[usize],
    pace: Pace,
) -> Result<Measured, MeasurementError> {
    let most = counts.iter().copied().max().unwrap_or(1);
    let point = OperatingPoint {
        load: 0.1,
        speed: 1200.0,
    };
    let model = default.model(&default.structure(MODES)?, mesh, point)?;
    let start = drive::settled(&model)?;
    let worked = team::work(
        topology,
        &[thread],
        counts.len(),
        pace,
        |_| {
            let mut rotation = PointRotation {
                kernels: (0..most).map(|_| drive::volterra(&model)).collect(),
                start: start.clone(),
                at: 0,
                stays: Vec::new(),
                stopped: false,
            };
            for &count in counts {
                let stays = team::rounds_for(REPETITION, |stays| {
                    rotation.advance(count, stays, STAY);
                });
                rotation.stays.push(stays);
            }
            Ok(rotation)
        },
        // Once round, so that what fits a cache is there.
        |rotation: &mut PointRotation<'_>, task| {
            rotation.advance(counts[task], counts[task], 1);
        },
        |rotation: &mut PointRotation<'_>, task| {
            rotation.advance(counts[task], rotation.stays[task], STAY);
        },
        |mut rotation| {
            let windows = rotation.advance(1, 1, STAY) as f64;
            let pieces: Vec<f64> = rotation.stays.iter().map(|&n| n as f64 * windows).collect();
            (!rotation.stopped, (rotation.kernels[0].bytes(), pieces))
        },
    )?;
    rotated(worked, "integrating in turn")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rotation_counts_its_products() {
        let mut rotation = OperatorRotation::new(31, 5);
        rotation.turn(5, 7);
        rotation.turn(2, 100);
        assert!(rotation.right(31));
        assert_eq!(rotation.x[0], (107 % 31) as f64);
        rotation.applied += 1;
        assert!(!rotation.right(31));
    }
}
