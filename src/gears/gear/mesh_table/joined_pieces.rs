//! Joins neighbouring pieces of a mesh table into fewer and longer ones, within an accuracy.
//!
//! Propagation starts a new window at the end of every piece, so pieces cost time. Two become one if a polynomial
//! follows the stiffness and the tangent error of both, and if means suffice for load centroid and friction.
//! The error measure is a relative error times the length of the piece in cycles.

use super::NODES;
use super::cycle::{MeshTableCycle, MeshTablePiece};
use super::pieces::{EXTRAPOLATED_AT, EXTRAPOLATION_LIMITS};
use crate::numerics::legendre::{evaluate, transforms8};

/// Phases per piece of the table at which joined pieces are compared with it, ends included.
const CHECKS: usize = 9;

/// Upper limit of the length of windows of propagation \[cycles\].
const LONGEST_WINDOW: f64 = 0.25;

/// Required accuracy of joined pieces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JoiningAccuracy {
    /// Largest error of stiffness (relative to it) and of tangent error (relative to the deflection F/k),
    /// times the length of a piece \[cycles\].
    pub stiffness: f64,
    /// Largest deviation from the means of a piece, times its length \[cycles\]. The weight of the friction
    /// direction is `friction`, that of its lever `friction / base_radius`, that of the load centroid
    /// `1 / face_width`.
    pub turning: f64,
    /// Pieces up to this length \[cycles\] are accepted with any deviation from the means.
    pub shortest: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// Base radius of the pinion \[m\].
    pub base_radius: f64,
    /// Face width \[m\].
    pub face_width: f64,
}

/// The mesh table over a cycle in few pieces, each joined from neighbours.
#[derive(Debug, Clone, PartialEq)]
pub struct JoinedPieces {
    /// The pieces, in order.
    pub pieces: Vec<MeshTablePiece>,
    /// Largest error of stiffness and tangent error, as in [`JoiningAccuracy::stiffness`].
    pub stiffness_error: f64,
    /// Largest deviation from the means, as in [`JoiningAccuracy::turning`].
    pub turning_error: f64,
}

/// A piece with its errors, as in [`JoinedPieces`].
struct FittedPiece {
    piece: MeshTablePiece,
    errors: [f64; 2],
}

/// Values of the table at a phase: stiffness, tangent error, load centroid, friction direction and lever.
struct Sample {
    phase: f64,
    values: [f64; 5],
}

/// Polynomials of the table over all its pieces.
struct TablePolynomials<'a> {
    cycle: &'a MeshTableCycle,
    accuracy: JoiningAccuracy,
    /// The series of the values of a [`Sample`], piece by piece.
    series: Vec<[[f64; NODES]; 5]>,
}

impl MeshTableCycle {
    /// From phase 0 on, joins each piece with the following ones as long as the result meets the accuracy.
    pub fn joined_pieces(&self, accuracy: JoiningAccuracy) -> JoinedPieces {
        let polynomials = TablePolynomials::new(self, accuracy);
        let ends = polynomials.ends();
        let mut joined_pieces = JoinedPieces {
            pieces: Vec::new(),
            stiffness_error: 0.0,
            turning_error: 0.0,
        };
        let mut first = 0;
        while first + 1 < ends.len() {
            let mut last = first + 1;
            let mut fitted_piece = polynomials.part([ends[first], ends[last]]);
            while let Some(&end) = ends.get(last + 1) {
                let Some(longer) = polynomials.joined_piece([ends[first], end]) else {
                    break;
                };
                (fitted_piece, last) = (longer, last + 1);
            }
            joined_pieces.stiffness_error =
                joined_pieces.stiffness_error.max(fitted_piece.errors[0]);
            joined_pieces.turning_error = joined_pieces.turning_error.max(fitted_piece.errors[1]);
            joined_pieces.pieces.push(fitted_piece.piece);
            first = last;
        }
        joined_pieces
    }
}

impl<'a> TablePolynomials<'a> {
    fn new(cycle: &'a MeshTableCycle, accuracy: JoiningAccuracy) -> Self {
        let error = cycle.tangent_error();
        let series = (0..cycle.stiffness.len())
            .map(|piece| {
                let quantities = [
                    &cycle.stiffness,
                    &error,
                    &cycle.centre,
                    &cycle.friction,
                    &cycle.friction_lever,
                ];
                quantities.map(|values| transforms8().interpolate(&values[piece]))
            })
            .collect();
        Self {
            cycle,
            accuracy,
            series,
        }
    }

    /// Ends of the table's pieces and of their equal parts, none longer than [`JoiningAccuracy::shortest`].
    fn ends(&self) -> Vec<f64> {
        let mut ends = vec![0.0];
        for piece in self.cycle.breaks.windows(2) {
            let length = piece[1] - piece[0];
            let parts = (length / self.accuracy.shortest - 1e-9).ceil().max(1.0);
            for part in 1..parts as usize {
                ends.push(piece[0] + length * part as f64 / parts);
            }
            ends.push(piece[1]);
        }
        ends
    }

    /// A part of one piece of the table, with the same polynomials.
    fn part(&self, ends: [f64; 2]) -> FittedPiece {
        let samples = self.samples(ends);
        let [stiffness, tangent_error] = [0, 1].map(|quantity| self.through(ends, quantity));
        self.fitted_piece(ends, &samples, [stiffness, tangent_error], 0.0)
    }

    /// One piece between two phases; `None` if it deviates too much from the table.
    fn joined_piece(&self, ends: [f64; 2]) -> Option<FittedPiece> {
        let length = ends[1] - ends[0];
        let samples = self.samples(ends);
        let (mut error, allowed) = (0.0_f64, self.accuracy.stiffness / length);
        let mut series = [[0.0; NODES]; 2];
        for (quantity, series) in series.iter_mut().enumerate() {
            let (polynomial, fit_error) =
                self.fitted_polynomial(ends, &samples, quantity, allowed)?;
            *series = polynomial;
            error = error.max(fit_error);
        }
        let fitted_piece = self.fitted_piece(ends, &samples, series, error * length);
        (length <= self.accuracy.shortest || fitted_piece.errors[1] <= self.accuracy.turning)
            .then_some(fitted_piece)
    }

    fn fitted_piece(
        &self,
        ends: [f64; 2],
        samples: &[Sample],
        series: [[f64; NODES]; 2],
        error: f64,
    ) -> FittedPiece {
        let means = self.cycle.means(ends);
        let accuracy = &self.accuracy;
        let scales = [
            (2, means.centre, 1.0 / accuracy.face_width),
            (3, means.friction, accuracy.friction),
            (
                4,
                means.friction_lever,
                accuracy.friction / accuracy.base_radius,
            ),
        ];
        let deviations = |sample: &Sample| {
            scales.map(|(quantity, mean, scale)| scale * (sample.values[quantity] - mean).abs())
        };
        let deviation = samples.iter().flat_map(deviations).fold(0.0, f64::max);
        FittedPiece {
            piece: MeshTablePiece {
                start: ends[0],
                end: ends[1],
                stiffness: series[0],
                tangent_error: series[1],
                centre: means.centre,
                friction: means.friction,
                friction_lever: means.friction_lever,
            },
            errors: [error, deviation * (ends[1] - ends[0])],
        }
    }

    /// The polynomial of the highest degree within the accuracy for a quantity between two phases, and its error.
    /// A stiffness must also stay physical as far as windows extend beyond the end. `None` if there is none.
    fn fitted_polynomial(
        &self,
        ends: [f64; 2],
        samples: &[Sample],
        quantity: usize,
        allowed: f64,
    ) -> Option<([f64; NODES], f64)> {
        let full = self.through(ends, quantity);
        let [Some(first), Some(last)] = [samples.first(), samples.last()] else {
            return None;
        };
        let reach = (LONGEST_WINDOW / (ends[1] - ends[0])).min(1.0);
        (2..=NODES).rev().find_map(|terms| {
            let mut series = [0.0; NODES];
            series[..terms].copy_from_slice(&full[..terms]);
            // At its ends the polynomial equals the table, so that there are no steps between pieces.
            let [before, behind] = [(first, -1.0), (last, 1.0)]
                .map(|(sample, x)| sample.values[quantity] - evaluate(&series, x));
            series[0] += 0.5 * (before + behind);
            series[1] += 0.5 * (behind - before);
            let relative_error = |sample: &Sample| {
                let x = (2.0 * sample.phase - ends[0] - ends[1]) / (ends[1] - ends[0]);
                let scale = match quantity {
                    0 => sample.values[0],
                    _ => self.cycle.force / sample.values[0],
                };
                ((evaluate(&series, x) - sample.values[quantity]) / scale).abs()
            };
            let error = samples.iter().map(relative_error).fold(0.0, f64::max);
            let end = evaluate(&series, 1.0);
            let [least, most] = EXTRAPOLATION_LIMITS.map(|part| part * end);
            let extrapolations =
                EXTRAPOLATED_AT.map(|x| evaluate(&series, 1.0 + (x - 1.0) * reach));
            let can_be_extrapolated =
                quantity > 0 || extrapolations.iter().all(|k| (least..=most).contains(k));
            (can_be_extrapolated && error <= allowed).then_some((series, error))
        })
    }

    /// The series through the values of the table at the Gauss nodes of the interval between two phases.
    fn through(&self, [from, to]: [f64; 2], quantity: usize) -> [f64; NODES] {
        let values = (transforms8().nodes()).map(|x| {
            let phase = 0.5 * ((to - from) * x + (from + to));
            let after = self.cycle.breaks.partition_point(|end| *end <= phase);
            self.value(after.clamp(1, self.series.len()) - 1, phase, quantity)
        });
        transforms8().interpolate(&values)
    }

    /// The table at phases between two others, each from the polynomials of its piece.
    fn samples(&self, [from, to]: [f64; 2]) -> Vec<Sample> {
        let breaks = &self.cycle.breaks;
        let first = breaks.partition_point(|end| *end <= from).max(1) - 1;
        (first..self.series.len())
            .take_while(|piece| breaks[*piece] < to)
            .flat_map(|piece| {
                let (low, high) = (breaks[piece].max(from), breaks[piece + 1].min(to));
                (0..CHECKS).map(move |place| {
                    let phase = low + (high - low) * place as f64 / (CHECKS - 1) as f64;
                    Sample {
                        phase,
                        values: [0, 1, 2, 3, 4].map(|quantity| self.value(piece, phase, quantity)),
                    }
                })
            })
            .collect()
    }

    fn value(&self, piece: usize, phase: f64, quantity: usize) -> f64 {
        let (start, end) = (self.cycle.breaks[piece], self.cycle.breaks[piece + 1]);
        let x = (2.0 * phase - start - end) / (end - start);
        evaluate(&self.series[piece][quantity], x)
    }
}
