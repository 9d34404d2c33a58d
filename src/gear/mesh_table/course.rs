//! What a run has of a mesh table: few pieces, as close to the table as asked for.
//!
//! A window of propagation ends with a piece, so that pieces cost time. Neighbours become one where a polynomial
//! follows the stiffness and the error of both, and where means stand for load centroid and friction. An error counts
//! by how long it lasts: relative to what the mesh force or its direction are, times the length of the piece in cycles.

use super::cycle::{MeshTableCycle, MeshTablePiece};
use super::pieces::{BEHIND, CARRIED_ON};
use super::NODES;
use crate::numerics::legendre::{evaluate, transforms8};

/// Places of every piece of the table at which a course is held against it, ends included.
const CHECKS: usize = 9;

/// No window of propagation is longer \[cycles\].
const LONGEST_WINDOW: f64 = 0.25;

/// How close a course is to be to its table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CourseAccuracy {
    /// Largest error of stiffness (relative) and of tangent error (in deflections) times the length of a piece.
    pub stiffness: f64,
    /// Largest departure from the means of a piece, times its length: of friction direction times `friction`, of its
    /// lever times that and in base radii, of the load centroid in face widths.
    pub turning: f64,
    /// Pieces of at most this length \[cycles\] have means whatever they depart by.
    pub shortest: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// Base radius of the pinion \[m\].
    pub base_radius: f64,
    /// Face width \[m\].
    pub face_width: f64,
}

/// A course of few pieces.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshCourse {
    /// The pieces, in order.
    pub pieces: Vec<MeshTablePiece>,
    /// Largest error of stiffness and tangent error, as in [`CourseAccuracy::stiffness`].
    pub stiffness_error: f64,
    /// Largest departure from the means, as in [`CourseAccuracy::turning`].
    pub turning_error: f64,
}

/// A piece with how far it is off, as in [`MeshCourse`].
struct Fitted {
    piece: MeshTablePiece,
    errors: [f64; 2],
}

/// Values of the table at a place: stiffness, tangent error, load centroid, friction direction and lever.
struct Sample {
    phase: f64,
    values: [f64; 5],
}

/// The table's polynomials.
struct Exact<'a> {
    cycle: &'a MeshTableCycle,
    accuracy: CourseAccuracy,
    /// Piece by piece the series of what a [`Sample`] has.
    series: Vec<[[f64; NODES]; 5]>,
}

impl MeshTableCycle {
    /// The course of fewest pieces that joining neighbours from phase 0 on leads to.
    pub fn course(&self, accuracy: CourseAccuracy) -> MeshCourse {
        let exact = Exact::new(self, accuracy);
        let ends = exact.ends();
        let mut course = MeshCourse {
            pieces: Vec::new(),
            stiffness_error: 0.0,
            turning_error: 0.0,
        };
        let mut first = 0;
        while first + 1 < ends.len() {
            let mut last = first + 1;
            let mut own = exact.part([ends[first], ends[last]]);
            while let Some(&end) = ends.get(last + 1) {
                let Some(longer) = exact.joined([ends[first], end]) else {
                    break;
                };
                (own, last) = (longer, last + 1);
            }
            course.stiffness_error = course.stiffness_error.max(own.errors[0]);
            course.turning_error = course.turning_error.max(own.errors[1]);
            course.pieces.push(own.piece);
            first = last;
        }
        course
    }
}

impl<'a> Exact<'a> {
    fn new(cycle: &'a MeshTableCycle, accuracy: CourseAccuracy) -> Self {
        let error = cycle.tangent_error();
        let series = (0..cycle.stiffness.len())
            .map(|piece| {
                let courses = [
                    &cycle.stiffness,
                    &error,
                    &cycle.centre,
                    &cycle.friction,
                    &cycle.friction_lever,
                ];
                courses.map(|values| transforms8().interpolate(&values[piece]))
            })
            .collect();
        Self {
            cycle,
            accuracy,
            series,
        }
    }

    /// Ends of the table's pieces and of equal parts of theirs, none longer than the shortest that a course is cut to.
    fn ends(&self) -> Vec<f64> {
        let mut ends = vec![0.0];
        for own in self.cycle.breaks.windows(2) {
            let length = own[1] - own[0];
            let parts = (length / self.accuracy.shortest - 1e-9).ceil().max(1.0);
            for part in 1..parts as usize {
                ends.push(own[0] + length * part as f64 / parts);
            }
            ends.push(own[1]);
        }
        ends
    }

    /// A part of one piece of the table, the same polynomials.
    fn part(&self, ends: [f64; 2]) -> Fitted {
        let samples = self.samples(ends);
        let [stiffness, tangent_error] = [0, 1].map(|quantity| self.through(ends, quantity));
        self.fitted(ends, &samples, [stiffness, tangent_error], 0.0)
    }

    /// One piece between two phases, where it is close enough to the table.
    fn joined(&self, ends: [f64; 2]) -> Option<Fitted> {
        let length = ends[1] - ends[0];
        let samples = self.samples(ends);
        let (mut error, allowed) = (0.0_f64, self.accuracy.stiffness / length);
        let mut series = [[0.0; NODES]; 2];
        for (quantity, series) in series.iter_mut().enumerate() {
            let found = self.follows(ends, &samples, quantity, allowed)?;
            *series = found.0;
            error = error.max(found.1);
        }
        let own = self.fitted(ends, &samples, series, error * length);
        (length <= self.accuracy.shortest || own.errors[1] <= self.accuracy.turning).then_some(own)
    }

    fn fitted(&self, ends: [f64; 2], samples: &[Sample], series: [[f64; NODES]; 2], error: f64) -> Fitted {
        let means = self.cycle.means(ends);
        let of = &self.accuracy;
        let scales = [
            (2, means.centre, 1.0 / of.face_width),
            (3, means.friction, of.friction),
            (4, means.friction_lever, of.friction / of.base_radius),
        ];
        let off = |sample: &Sample| {
            scales.map(|(quantity, mean, scale)| scale * (sample.values[quantity] - mean).abs())
        };
        let departure = samples.iter().flat_map(off).fold(0.0, f64::max);
        Fitted {
            piece: MeshTablePiece {
                start: ends[0],
                end: ends[1],
                stiffness: series[0],
                tangent_error: series[1],
                centre: means.centre,
                friction: means.friction,
                friction_lever: means.friction_lever,
            },
            errors: [error, departure * (ends[1] - ends[0])],
        }
    }

    /// The polynomial of most terms about a quantity between two phases that stays within an error and can be
    /// carried on behind its end as far as windows run, with its error.
    fn follows(
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
            // At its ends it is the table, so that nothing steps where pieces meet.
            let [before, behind] = [(first, -1.0), (last, 1.0)]
                .map(|(sample, x)| sample.values[quantity] - evaluate(&series, x));
            series[0] += 0.5 * (before + behind);
            series[1] += 0.5 * (behind - before);
            let off = |sample: &Sample| {
                let x = (2.0 * sample.phase - ends[0] - ends[1]) / (ends[1] - ends[0]);
                let scale = match quantity {
                    0 => sample.values[0],
                    _ => self.cycle.force / sample.values[0],
                };
                ((evaluate(&series, x) - sample.values[quantity]) / scale).abs()
            };
            let error = samples.iter().map(off).fold(0.0, f64::max);
            let end = evaluate(&series, 1.0);
            let [least, most] = CARRIED_ON.map(|part| part * end);
            let behind = BEHIND.map(|x| evaluate(&series, 1.0 + (x - 1.0) * reach));
            let carries = quantity > 0 || behind.iter().all(|k| (least..=most).contains(k));
            (carries && error <= allowed).then_some((series, error))
        })
    }

    /// The series through the values at the nodes between two phases.
    fn through(&self, [from, to]: [f64; 2], quantity: usize) -> [f64; NODES] {
        let values = (transforms8().nodes()).map(|x| {
            let phase = 0.5 * ((to - from) * x + (from + to));
            let after = self.cycle.breaks.partition_point(|end| *end <= phase);
            self.value(after.clamp(1, self.series.len()) - 1, phase, quantity)
        });
        transforms8().interpolate(&values)
    }

    /// The table at places between two phases, those of each of its pieces by its own polynomials.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gear::{
        Contact, Flanks, MeshTable, MeshTableInputs, Modification, ToothForm, fixtures,
    };

    /// A cycle of the 20/30 pair under a torque \[N m\], the pinion's lead crowned \[m\].
    fn cycle(crowning: f64, misalignment: f64) -> (MeshTableCycle, CourseAccuracy) {
        let crowned = Modification {
            crowning,
            ..Modification::default()
        };
        let form = ToothForm {
            bore: [Some(48e-3), Some(76e-3)],
            lead: [crowned, Modification::default()],
            ..ToothForm::default()
        };
        let pair = fixtures::pair([20, 30], form);
        let inputs = MeshTableInputs {
            misalignment: vec![misalignment],
            longest_piece: 0.25,
            tolerance: 1e-6,
            slices: 16,
            contact: Contact::Secant,
            ..MeshTableInputs::of_gears(&pair)
        };
        let table = MeshTable::build(&Flanks::new(&pair).unwrap(), &inputs, &|_, _| ()).unwrap();
        let accuracy = CourseAccuracy {
            stiffness: 1e-5,
            turning: 2.5e-4,
            shortest: 1.0 / 96.0,
            friction: 0.05,
            base_radius: inputs.base_radius,
            face_width: inputs.face_width,
        };
        (table.cycle(0, 0), accuracy)
    }

    /// Largest error of stiffness and departure from the means, each times the length of its piece, at places of which
    /// none is one that the course was held to.
    fn off(cycle: &MeshTableCycle, course: &MeshCourse, of: &CourseAccuracy) -> [f64; 2] {
        let mut worst = [0.0_f64; 2];
        for step in 0..5003 {
            let phase = (f64::from(step) + 0.37) / 5003.0;
            let piece = &course.pieces[course.pieces.partition_point(|own| own.end <= phase)];
            let length = piece.end - piece.start;
            let x = (2.0 * phase - piece.start - piece.end) / length;
            let k = cycle.value(&cycle.stiffness, phase);
            let stiffness = (evaluate(&piece.stiffness, x) / k - 1.0).abs();
            worst[0] = worst[0].max(stiffness * length);
            let turning = [
                (cycle.value(&cycle.centre, phase) - piece.centre) / of.face_width,
                of.friction * (cycle.value(&cycle.friction, phase) - piece.friction),
                of.friction * (cycle.value(&cycle.friction_lever, phase) - piece.friction_lever)
                    / of.base_radius,
            ];
            for departure in turning {
                worst[1] = worst[1].max(departure.abs() * length);
            }
        }
        worst
    }

    /// The course says how far it is off, keeps to what is asked for, and has fewer pieces than the table.
    #[test]
    fn a_course_is_as_far_off_as_it_says() {
        for (crowning, misalignment) in [(0.0, 0.0), (5e-6, 2e-4)] {
            let (cycle, accuracy) = cycle(crowning, misalignment);
            let course = cycle.course(accuracy);
            let found = off(&cycle, &course, &accuracy);
            let told = [course.stiffness_error, course.turning_error];
            for (found, told) in found.into_iter().zip(told) {
                assert!(found <= 1.2 * told + 1e-12, "{found:e} {told:e}");
                assert!(found >= 0.5 * told - 1e-12, "{found:e} {told:e}");
            }
            assert!(told[0] <= accuracy.stiffness, "{told:?}");
            let frictionless = cycle.course(CourseAccuracy {
                friction: 0.0,
                turning: f64::INFINITY,
                ..accuracy
            });
            let counts = [&frictionless.pieces, &course.pieces].map(Vec::len);
            assert!(counts[0] < cycle.stiffness.len() && counts[0] <= counts[1], "{counts:?}");
            // The impulse of friction and load is that of the table, however long the pieces are.
            let mean = |of: fn(&MeshTablePiece) -> f64| -> f64 {
                course.pieces.iter().map(|own| (own.end - own.start) * of(own)).sum()
            };
            assert!((mean(|own| own.friction) - cycle.mean(&cycle.friction)).abs() < 1e-12);
            assert!((mean(|own| own.centre) - cycle.mean_centre()).abs() < 1e-14);
        }
    }

    /// Friction of aligned gears turns smoothly: a piece of half the length departs from its mean by half as much, so that
    /// the error falls with the square of the number of pieces.
    #[test]
    fn friction_is_met_with_second_order() {
        let (cycle, accuracy) = cycle(0.0, 0.0);
        let [rough, fine] = [4e-4, 2.5e-5].map(|turning| {
            let course = cycle.course(CourseAccuracy {
                turning,
                shortest: 1e-3,
                ..accuracy
            });
            let double = course.pieces.iter().filter(|own| own.end < 0.6);
            (off(&cycle, &course, &accuracy)[1], double.count() as f64)
        });
        let order = (rough.0 / fine.0).ln() / (fine.1 / rough.1).ln();
        assert!((1.6..2.4).contains(&order), "{order} {rough:?} {fine:?}");
    }

    /// A window may start anywhere in a piece and run on by a quarter of the cycle, or the length of the piece.
    #[test]
    fn pieces_can_be_carried_on() {
        let (cycle, accuracy) = cycle(0.0, 0.0);
        for piece in cycle.course(CourseAccuracy { friction: 0.0, ..accuracy }).pieces {
            let length = piece.end - piece.start;
            let end = evaluate(&piece.stiffness, 1.0);
            for step in 0..=10 {
                let behind = 0.1 * f64::from(step) * length.min(LONGEST_WINDOW);
                let k = evaluate(&piece.stiffness, 1.0 + 2.0 * behind / length);
                assert!((0.1..10.0).contains(&(k / end)), "{} {k:e}", piece.end);
            }
        }
    }
}
