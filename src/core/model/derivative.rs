//! How does a model change with a parameter?
//!
//! Every number of a model is differentiated at fixed mesh phase, by a difference quotient of whole models.
//! This works for any origin of the numbers. The effect of their derivatives on a trajectory is then computed
//! without differences ([`crate::analysis::sensitivity`]).

use super::error::ShapeChange;
use super::state_change::{StateChange, times};
use super::{Basis, Model, Segment};
use faer::Mat;

/// Largest distortion of the modes of neighbouring models. A larger one shows that a mode exchanges places with an
/// omitted one, so that no derivative exists.
const MOST_DISTORTED: f64 = 0.1;

/// The derivative of a model with respect to a parameter, in the states of the model.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelDerivative {
    /// Derivatives in place of the differentiated numbers. The other numbers, such as those of rigid stops and dry
    /// friction, are copies.
    pub numbers: Model,
    /// Derivative of the entries of the generator that couple different blocks, 2N × 2N; `None` if states keep their
    /// meaning.
    pub between_blocks: Option<Mat<f64>>,
    /// Derivative C_p of the matrix C that maps states at a neighbouring value of the parameter to states of this
    /// model, 2N × 2N; `None` if states keep their meaning.
    pub change: Option<Mat<f64>>,
}

impl ModelDerivative {
    /// Entries `(row, column, value)` of the derivative of the generator between different blocks.
    pub fn entries_between_blocks(&self) -> Vec<(usize, usize, f64)> {
        let Some(matrix) = &self.between_blocks else {
            return Vec::new();
        };
        let column = |j: usize| (0..matrix.nrows()).map(move |i| (i, j, matrix[(i, j)]));
        let all = (0..matrix.ncols()).flat_map(column);
        all.filter(|(.., value)| *value != 0.0).collect()
    }

    /// `C_p x`: the derivative, with respect to the parameter, of a state x whose numbers stay the same.
    pub fn turned(&self, x: &[f64]) -> Vec<f64> {
        match &self.change {
            None => vec![0.0; x.len()],
            Some(change) => times(change, x),
        }
    }
}

impl Model {
    /// The weighted sum of models near the first one, `Σ weight · model`, in the states of the first model. States of
    /// the others become states of `through`, then of the first model. It is a derivative if the weights are those of a
    /// difference quotient. Frequencies of harmonics are those of the first model, because they have no effect at fixed
    /// mesh phase.
    ///
    /// # Errors
    /// [`ShapeChange`] if they do not have the same modes, segments, directions, contacts and harmonics.
    pub fn combined(
        models: &[(f64, &Self)],
        through: &Basis,
    ) -> Result<ModelDerivative, ShapeChange> {
        let first = models[0].1;
        let own_change = first.basis.change_to(through)?;
        let ModelDerivative {
            numbers: mut sum,
            mut between_blocks,
            mut change,
        } = first.unchanged();
        let mut same_weight = 0.0;
        for &(weight, model) in models {
            let mut near = model.basis.change_to(&first.basis)?;
            if let StateChange::Linear { distortion, .. } = near {
                if distortion > MOST_DISTORTED {
                    return Err(ShapeChange { what: "modes" });
                }
                near = model.basis.change_to(through)?.then_back(&own_change);
            }
            let mut model = match near {
                StateChange::Same => {
                    same_weight += weight;
                    model.clone()
                }
                StateChange::Linear { forth, back, .. } => {
                    *change.get_or_insert_with(|| Mat::zeros(forth.nrows(), forth.nrows())) +=
                        faer::Scale(weight) * &forth;
                    let (model, between) = model.changed(&forth, &back);
                    let sum = between_blocks
                        .get_or_insert_with(|| Mat::zeros(between.nrows(), between.nrows()));
                    *sum += faer::Scale(weight) * &between;
                    model
                }
            };
            same_shape(&sum, &model)?;
            let mut numbers = Vec::new();
            model.each_number(&mut |number| numbers.push(*number));
            let mut numbers = numbers.into_iter();
            sum.each_number(&mut |number| *number += weight * numbers.next().unwrap_or(0.0));
        }
        if let Some(change) = &mut change {
            (0..change.nrows()).for_each(|i| change[(i, i)] += same_weight);
        }
        Ok(ModelDerivative {
            numbers: sum,
            between_blocks,
            change,
        })
    }

    /// The derivative with respect to a parameter that has no effect: all differentiated numbers are zero.
    pub fn unchanged(&self) -> ModelDerivative {
        let mut numbers = self.clone();
        numbers.each_number(&mut |number| *number = 0.0);
        ModelDerivative {
            numbers,
            between_blocks: None,
            change: None,
        }
    }

    /// Visits every differentiated number, always in the same order. Numbers of rigid stops, dry sliders and dry
    /// friction, bands of film layers and losses are not differentiated.
    fn each_number(&mut self, visit: &mut impl FnMut(&mut f64)) {
        for block in &mut self.blocks {
            all(block.generator.as_flattened_mut(), visit);
            all(&mut block.static_input, visit);
        }
        for share in self.directions.iter_mut().flat_map(|d| &mut d.on_bearings) {
            visit(share);
        }
        for gain in self.directions.iter_mut().flat_map(|d| &mut d.gains) {
            for pair in [&mut gain.deflection, &mut gain.rate, &mut gain.mesh_input] {
                all(pair, visit);
            }
        }
        for harmonic in self
            .lines
            .iter_mut()
            .flat_map(|line| &mut line.transmission_error)
        {
            visit(&mut harmonic.amplitude);
            visit(&mut harmonic.phase);
        }
        for contact in &mut self.contacts {
            visit(&mut contact.half_gap);
            for cycle in &mut contact.cycles {
                visit(&mut cycle.period);
                for segment in &mut cycle.segments {
                    visit(&mut segment.start);
                    visit(&mut segment.end);
                    all(segment.stiffness.coefficients_mut(), visit);
                    all(segment.error.coefficients_mut(), visit);
                    visit(&mut segment.damping);
                }
            }
        }
        for ripple in &mut self.ripple {
            visit(&mut ripple.phase);
            all(ripple.input.as_flattened_mut(), visit);
        }
        for bearing in &mut self.bearings {
            all(bearing.gain.as_flattened_mut(), visit);
            visit(&mut bearing.constant);
            all(&mut bearing.by_ripple, visit);
        }
        for output in &mut self.outputs {
            all(output.gain.as_flattened_mut(), visit);
        }
        visit(&mut self.half_gap);
        visit(&mut self.effective_mass);
    }
}

/// Visits several numbers.
fn all(numbers: &mut [f64], visit: &mut impl FnMut(&mut f64)) {
    numbers.iter_mut().for_each(visit);
}

fn same_shape(a: &Model, b: &Model) -> Result<(), ShapeChange> {
    let differ = |what| Err(ShapeChange { what });
    if a.blocks.len() != b.blocks.len() || a.neutral != b.neutral {
        return differ("modes");
    }
    let lines = |model: &Model| model.directions.iter().map(|d| d.line).collect::<Vec<_>>();
    if lines(a) != lines(b) {
        return differ("lines of action");
    }
    let turns = |model: &Model| -> Vec<f64> {
        let errors = model.transmission_errors().map(|h| h.turns_per_cycle);
        errors
            .chain(model.ripple.iter().map(|r| r.turns_per_cycle))
            .collect()
    };
    if turns(a) != turns(b) {
        return differ("orders of the excitation");
    }
    let directions = |segments: &[Segment]| -> Vec<usize> {
        segments.iter().map(|segment| segment.direction).collect()
    };
    let cycles = |model: &Model| -> Vec<Vec<usize>> {
        let all = model.contacts.iter().flat_map(|contact| &contact.cycles);
        all.map(|cycle| directions(&cycle.segments)).collect()
    };
    let laws = |model: &Model| -> Vec<_> {
        let contacts = model.contacts.iter();
        contacts
            .map(|c| (c.side.to_bits(), c.release, c.cycles.len()))
            .collect()
    };
    if laws(a) != laws(b) {
        return differ("contacts");
    }
    if cycles(a) != cycles(b) {
        return differ("segments of the mesh cycle");
    }
    Ok(())
}

impl Segment {
    /// Derivatives, at fixed mesh phase, of the stiffness \[N/m\] and of the error of loaded flanks
    /// \[m\] at a phase within the segment, per unit of the parameter of the derivative `by`.
    pub fn change_at(&self, by: &Self, phase: f64) -> [f64; 2] {
        let x = self.place(phase);
        let length = self.end - self.start;
        // The ends of the segment move. The position x of a fixed phase therefore moves too.
        let moved = -(by.start + by.end + x * (by.end - by.start)) / length;
        let slope = |series: &[f64; super::STIFFNESS_TERMS]| {
            crate::numerics::legendre::evaluate(&crate::numerics::legendre::derivative(series), x)
        };
        [
            by.stiffness.at(x) + slope(self.stiffness.coefficients()) * moved,
            by.error.at(x) + slope(self.error.coefficients()) * moved,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{
        Division, Drive, FlankError, MeshGain, MeshHarmonic, OperatingPoint, Stiffness,
    };
    use crate::model::{fixtures, initial::InitialState};
    use crate::structure::{Coupling, ModalStructure, ModeShapes};
    use std::f64::consts::PI;
    use std::sync::Arc;

    fn drive() -> Drive {
        fixtures::two_level_mesh(1e-5)
    }

    fn build(drive: &Drive, point: OperatingPoint) -> Model {
        let structure = fixtures::structure(&[0.0, 3000.0], 0.01, &[1.0, 0.3], &[1.0, 0.3]);
        Model::new(&structure, drive, point).unwrap()
    }

    /// Every number of a segment changes with the parameter, including its ends.
    fn segment(by: f64) -> Segment {
        Segment {
            start: 0.2 + 0.05 * by,
            end: 0.7 - 0.11 * by,
            stiffness: Stiffness::series([
                4e8 + 1e7 * by,
                5e7 - 3e6 * by,
                2e7,
                -1e7 + 2e6 * by,
                0.0,
                3e6,
                0.0,
                1e6,
            ]),
            error: FlankError::series([
                2e-6 - 4e-7 * by,
                1e-6,
                -5e-7,
                3e-7 * by,
                0.0,
                1e-7,
                0.0,
                0.0,
            ]),
            damping: 1000.0,
            direction: 0,
        }
    }

    #[test]
    fn segments_change_at_fixed_phase() {
        // All numbers are linear in the parameter, so that their difference is the derivative.
        let (zero, one) = (segment(0.0), segment(1.0));
        let mut by = one;
        (by.start, by.end) = (one.start - zero.start, one.end - zero.end);
        for (by, zero) in [
            (
                by.stiffness.coefficients_mut(),
                zero.stiffness.coefficients(),
            ),
            (by.error.coefficients_mut(), zero.error.coefficients()),
        ] {
            by.iter_mut().zip(zero).for_each(|(by, zero)| *by -= zero);
        }
        let h = 1e-5;
        for phase in [0.21, 0.3, 0.45, 0.6, 0.69] {
            let [more, less] = [h, -h].map(|by| {
                let own = segment(by);
                [own.stiffness_at(phase), own.error_at(phase)[0]]
            });
            for (which, found) in zero.change_at(&by, phase).into_iter().enumerate() {
                let quotient = (more[which] - less[which]) / (2.0 * h);
                assert!(
                    (found / quotient - 1.0).abs() < 1e-6,
                    "{phase}: {found} {quotient}"
                );
            }
        }
    }

    /// The whole generator of a derivative.
    fn generator(by: &ModelDerivative) -> Mat<f64> {
        let n = by.numbers.modes();
        let mut generator = by
            .between_blocks
            .clone()
            .unwrap_or_else(|| Mat::zeros(2 * n, 2 * n));
        for (i, block) in by.numbers.blocks.iter().enumerate() {
            for (row, column) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                generator[(row * n + i, column * n + i)] += block.generator[row][column];
            }
        }
        generator
    }

    /// Gyroscopic terms change the coupled modes with the speed. The sum has the states of the first model. The change
    /// of states keeps the effects of a force on the rate of a deflection.
    #[test]
    fn a_sum_of_coupled_modes_has_the_states_of_the_first_model() {
        let at = |speed: f64| {
            let structure = ModalStructure {
                coupling: Some(Coupling {
                    damping: vec![20.0, 5.0, 5.0, 30.0],
                    gyroscopic: vec![0.0, 0.3, -0.3, 0.0],
                    stiffness: vec![0.0; 4],
                }),
                ..fixtures::structure(&[2000.0, 2100.0], 0.01, &[1.0, 0.3], &[1.0, 0.3])
            };
            let point = OperatingPoint {
                speed,
                ..fixtures::strong_rattle()
            };
            Model::new(&structure, &drive(), point).unwrap()
        };
        let (base, other) = (at(100.0), at(110.0));
        let effects = |by: &ModelDerivative| {
            let (n, gains) = (by.numbers.modes(), by.numbers.first_gains());
            let part = |i: usize, of: fn(&MeshGain) -> [f64; 2]| of(&gains[i % n])[i / n];
            let rows = Mat::from_fn(1, 2 * n, |_, i| part(i, |gain| gain.rate));
            let inputs = Mat::from_fn(2 * n, 1, |i, _| part(i, |gain| gain.mesh_input));
            [
                (&rows * &inputs)[(0, 0)],
                (&rows * generator(by) * &inputs)[(0, 0)],
            ]
        };
        let own = effects(&Model::combined(&[(1.0, &other)], &other.basis).unwrap());
        let in_base =
            effects(&Model::combined(&[(0.0, &base), (1.0, &other)], &base.basis).unwrap());
        for (own, in_base) in own.into_iter().zip(in_base) {
            assert!((own / in_base - 1.0).abs() < 1e-9, "{own} {in_base}");
        }
        assert!(
            Model::combined(&[(0.0, &base), (1.0, &other)], &base.basis)
                .unwrap()
                .between_blocks
                .is_some()
        );
    }

    /// Two bodies on springs `k I + p K'` have modes in directions that jump at p = 0, where their frequencies are
    /// equal. The derivative of the generator nevertheless is `−Φᵀ K' Φ`, and a deflection does not change.
    #[test]
    fn a_parameter_has_a_derivative_where_frequencies_cross() {
        let [a, b] = [2e5, 3e5];
        let at = |p: f64| {
            let (change, angle) = if p == 0.0 {
                (0.0, 0.3)
            } else {
                let turn = 0.5 * f64::atan2(b, a);
                (
                    p.abs() * a.hypot(b),
                    if p < 0.0 { turn } else { turn + 0.5 * PI },
                )
            };
            let (sin, cos) = angle.sin_cos();
            let seen = [cos, -sin];
            let frequency = [-change, change].map(|d| (4e6 + d).sqrt());
            let structure = ModalStructure {
                shapes: Some(Arc::new(ModeShapes {
                    inertia: vec![1.0; 2],
                    shapes: vec![vec![cos, -sin], vec![sin, cos]],
                })),
                ..fixtures::structure(&frequency, 0.0, &seen, &seen)
            };
            Model::new(&structure, &drive(), fixtures::strong_rattle()).unwrap()
        };
        let h = 1e-2;
        let by = [(0.0, &at(0.0)), (-0.5 / h, &at(-h)), (0.5 / h, &at(h))];
        let by = Model::combined(&by, &by[0].1.basis).unwrap();
        let found = generator(&by);
        let (sin, cos) = 0.3_f64.sin_cos();
        let shape = [[cos, sin], [-sin, cos]];
        for i in 0..2 {
            for j in 0..2 {
                let ([x, y], [u, v]) = (shape[i], shape[j]);
                let wanted = -(x * (a * u + b * v) + y * (b * u - a * v));
                assert!(
                    (found[(2 + i, j)] - wanted).abs() < 1e-6 * a,
                    "{i} {j} {wanted}"
                );
            }
            let gain = by.numbers.first_gains()[i].deflection;
            assert!(gain.iter().all(|w| w.abs() < 1e-10), "{gain:?}");
        }
    }

    /// A load changes only the inputs of the torques, a gap only gaps, a damper only dampers, an error only harmonics.
    #[test]
    fn a_difference_of_models_is_their_derivative() {
        let point = fixtures::strong_rattle();
        let base = build(&drive(), point);
        let zero_derivative = base.unchanged().numbers;
        let by = |step: f64, other: &Model| {
            Model::combined(&[(-1.0 / step, &base), (1.0 / step, other)], &base.basis)
                .unwrap()
                .numbers
        };
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9 * b.abs().max(1e-3);

        let load = point.load + 0.125;
        let mut found = by(0.125, &build(&drive(), OperatingPoint { load, ..point }));
        for (block, rated) in found.blocks.iter_mut().zip(&base.rated_input) {
            for (input, rated) in block.static_input.iter_mut().zip(rated) {
                assert!(near(*input, *rated), "{input} {rated}");
                *input = 0.0;
            }
        }
        assert_eq!(found, zero_derivative);

        let mut found = by(
            1e-6,
            &build(
                &Drive {
                    half_gap: 11e-6,
                    ..drive()
                },
                point,
            ),
        );
        let gaps = found
            .contacts
            .iter_mut()
            .map(|contact| &mut contact.half_gap);
        for gap in gaps.chain([&mut found.half_gap]) {
            assert!(near(*gap, 1.0), "{gap}");
            *gap = 0.0;
        }
        assert_eq!(found, zero_derivative);

        let damping = drive().damping + 8.0;
        let mut found = by(8.0, &build(&Drive { damping, ..drive() }, point));
        for contact in &mut found.contacts {
            for segment in &mut contact.cycles[0].segments {
                assert!(near(segment.damping, 1.0), "{}", segment.damping);
                segment.damping = 0.0;
            }
        }
        assert_eq!(found, zero_derivative);

        let transmission_error = vec![MeshHarmonic::new(1, 6e-6, 0.5)];
        let mut found = by(
            0.5,
            &build(
                &Drive {
                    transmission_error,
                    ..drive()
                },
                point,
            ),
        );
        let harmonic = &mut found.lines[0].transmission_error[0];
        assert!(near(harmonic.amplitude, 2e-6) && near(harmonic.phase, 1.0));
        (harmonic.amplitude, harmonic.phase) = (0.0, 0.0);
        assert_eq!(found, zero_derivative);
        assert_eq!(zero_derivative.start(&InitialState::Rest).state, [0.0; 4]);
    }

    #[test]
    fn models_of_another_shape_are_told() {
        let point = fixtures::strong_rattle();
        let base = build(&drive(), point);
        let what = |other: &Model| {
            Model::combined(&[(1.0, &base), (1.0, other)], &base.basis)
                .unwrap_err()
                .what
        };
        let rigid = fixtures::structure(&[0.0], 0.0, &[1.0], &[1.0]);
        assert_eq!(what(&Model::new(&rigid, &drive(), point).unwrap()), "modes");
        let transmission_error = vec![MeshHarmonic::new(2, 5e-6, 0.0)];
        let order = Drive {
            transmission_error,
            ..drive()
        };
        assert_eq!(what(&build(&order, point)), "orders of the excitation");
        let mesh = Division::levels(&[4e8, 3e8, 4e8], &[]);
        let segments = Drive { mesh, ..drive() };
        assert_eq!(what(&build(&segments, point)), "segments of the mesh cycle");
        let mut turned = base.clone();
        turned.contacts[0].side = -1.0;
        assert_eq!(what(&turned), "contacts");
        let mut separate = base.clone();
        separate.directions[0].line = 1;
        assert_eq!(what(&separate), "lines of action");
        let mut free = base.clone();
        free.neutral.push(0);
        assert_eq!(what(&free), "modes");
    }
}
