//! How is a state of one model described as a state of another one?
//!
//! Modes, and the blocks of coupled modes, depend on the parameters of a structure. Their order and signs may change,
//! and modes of equal frequency are arbitrary combinations. The displacements of the freedoms do not change so: they
//! are `Φ q` with the shapes Φ. The modal displacements of the reference that are nearest to this motion are
//! `H q = (Φ₀ᵀ W Φ₀)⁻¹ Φ₀ᵀ W Φ q`, with the inertias W of the freedoms. With the transformations T of both bases,
//! states of blocks change by `C = T₀⁻¹ H T`. C depends smoothly on the parameters, and is the identity for equal
//! structures.

use super::basis::Basis;
use super::error::ShapeChange;
use super::{MeshGain, Model};
use crate::numerics::linalg::{inverse, product};
use crate::structure::ModeShapes;
use faer::Mat;

/// Largest product of the norms of H and of its inverse. Modes that are farther apart have nothing in common.
const MOST_DIFFERENT: f64 = 1e6;

/// A linear change of the states of blocks.
#[derive(Debug, Clone, PartialEq)]
pub enum StateChange {
    /// States have the same meaning in both models.
    Same,
    /// C and its inverse, 2N × 2N.
    Linear {
        /// From states of the model to states of the reference.
        forth: Mat<f64>,
        /// The inverse.
        back: Mat<f64>,
        /// Largest entry of `HᵀH − I`: the distance of the modes from rotated modes of the reference.
        distortion: f64,
    },
}

impl StateChange {
    /// A state of the model as a state of the reference.
    pub fn apply(&self, state: &[f64]) -> Vec<f64> {
        match self {
            Self::Same => state.to_vec(),
            Self::Linear { forth, .. } => times(forth, state),
        }
    }

    /// This change, then back by the change `other` of another model to the same reference: from states of this
    /// model to states of the other model.
    #[must_use]
    pub(super) fn then_back(&self, other: &Self) -> Self {
        match (self, other) {
            (Self::Same, Self::Same) => Self::Same,
            (change, Self::Same) => change.clone(),
            (
                Self::Same,
                Self::Linear {
                    forth,
                    back,
                    distortion,
                },
            ) => Self::Linear {
                forth: back.clone(),
                back: forth.clone(),
                distortion: *distortion,
            },
            (
                Self::Linear {
                    forth,
                    back,
                    distortion,
                },
                Self::Linear {
                    forth: other_forth,
                    back: other_back,
                    ..
                },
            ) => Self::Linear {
                forth: product(other_back.as_ref(), forth.as_ref()),
                back: product(back.as_ref(), other_forth.as_ref()),
                distortion: *distortion,
            },
        }
    }

    /// A state of the reference as a state of the model.
    pub fn undo(&self, state: &[f64]) -> Vec<f64> {
        match self {
            Self::Same => state.to_vec(),
            Self::Linear { back, .. } => times(back, state),
        }
    }
}

impl Basis {
    /// The change from states of this basis to states of a reference.
    ///
    /// # Errors
    /// [`ShapeChange`] if the structures have different freedoms, or modes that have nothing in common.
    pub fn change_to(&self, reference: &Self) -> Result<StateChange, ShapeChange> {
        let different = ShapeChange { what: "modes" };
        if self.blocks() != reference.blocks() || self.sliders() != reference.sliders() {
            return Err(different);
        }
        let forth = self.modes_in(reference)?;
        let [own, other] = [self, reference].map(|basis| basis.coupled().map(|c| &c.to_modes));
        if forth.is_none() && own == other {
            return Ok(StateChange::Same);
        }
        let identity = Mat::<f64>::identity(self.blocks(), self.blocks());
        let (forth, back, distortion) = match forth {
            None => (identity.clone(), identity, 0.0),
            Some(forth) => {
                let back = inverse(forth.as_ref());
                let norms = forth.norm_l2() * back.norm_l2();
                if norms.is_nan() || norms > MOST_DIFFERENT {
                    return Err(different);
                }
                let distortion = product(forth.transpose(), forth.as_ref()) - identity;
                (forth, back, distortion.norm_max())
            }
        };
        let [[own_to, own_from], [other_to, other_from]] = [self, reference].map(Self::maps);
        let in_turn = |a: &Mat<f64>, b: &Mat<f64>, c: &Mat<f64>| {
            product(product(a.as_ref(), b.as_ref()).as_ref(), c.as_ref())
        };
        Ok(StateChange::Linear {
            forth: in_turn(&other_from, &twice(&forth), &own_to),
            back: in_turn(&own_from, &twice(&back), &other_to),
            distortion,
        })
    }

    /// T and its inverse, 2N × 2N.
    fn maps(&self) -> [Mat<f64>; 2] {
        let n = 2 * self.blocks();
        match self.coupled() {
            None => [Mat::identity(n, n), Mat::identity(n, n)],
            Some(coupled) => [&coupled.to_modes, &coupled.from_modes]
                .map(|map| Mat::from_fn(n, n, |i, j| map[n * i + j])),
        }
    }

    /// H for the rotated modes, N × N; `None` if both structures have the same modes, or modes without shapes. Rigid
    /// motions without contact stay separate from the other modes, which they do not affect.
    fn modes_in(&self, reference: &Self) -> Result<Option<Mat<f64>>, ShapeChange> {
        if self.has_modes_of(reference) {
            return Ok(None);
        }
        let (own, other) = match (self.shapes(), reference.shapes()) {
            (Some(own), Some(other)) => (own, other),
            (None, None) => return Ok(None),
            _ => return Err(ShapeChange { what: "modes" }),
        };
        let different = ShapeChange { what: "modes" };
        let free = self.without_contact();
        if own.shapes.len() != other.shapes.len() || free != reference.without_contact() {
            return Err(different);
        }
        let turned = |basis: &Self, shapes: &ModeShapes| {
            let rows: Vec<Vec<f64>> = (shapes.shapes.iter().zip(&other.inertia))
                .map(|(row, inertia)| {
                    let mut row = basis.turn(row);
                    row.iter_mut().for_each(|x| *x *= inertia.sqrt());
                    row
                })
                .collect();
            Mat::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
        };
        let [own, other] = [turned(self, own), turned(reference, other)];
        let n = self.blocks();
        let mut gram = product(other.transpose(), other.as_ref());
        let mut cross = product(other.transpose(), own.as_ref());
        // Dry sliders have no shapes.
        for i in n - self.sliders()..n {
            (gram[(i, i)], cross[(i, i)]) = (1.0, 1.0);
        }
        let modes = product(inverse(gram.as_ref()).as_ref(), cross.as_ref());
        let separate = |i: usize, j: usize| free.contains(&i) != free.contains(&j);
        Ok(Some(Mat::from_fn(n, n, |i, j| {
            if separate(i, j) { 0.0 } else { modes[(i, j)] }
        })))
    }
}

impl Model {
    /// This model in new states, and the entries of its generator that couple different blocks. `forth` maps the old
    /// states to the new ones, `back` the new ones to the old ones.
    pub(super) fn changed(&self, forth: &Mat<f64>, back: &Mat<f64>) -> (Self, Mat<f64>) {
        let n = self.modes();
        let columns = |values: &mut Vec<[f64; 2]>| *values = pairs(&times(forth, &flat(values)));
        let rows = |values: &mut Vec<[f64; 2]>| {
            if !values.is_empty() {
                let row = flat(values);
                let sum = |j: usize| back.col(j).iter().zip(&row).map(|(a, b)| a * b).sum();
                *values = pairs(&(0..2 * n).map(sum).collect::<Vec<f64>>());
            }
        };
        let mut changed = self.clone();
        let mut generator = product(
            product(forth.as_ref(), self.generator().as_ref()).as_ref(),
            back.as_ref(),
        );
        let mut inputs: Vec<[f64; 2]> = self.blocks.iter().map(|b| b.static_input).collect();
        columns(&mut inputs);
        for (i, (block, input)) in changed.blocks.iter_mut().zip(inputs).enumerate() {
            block.static_input = input;
            for (row, entries) in [i, n + i].into_iter().zip(&mut block.generator) {
                for (column, entry) in [i, n + i].into_iter().zip(entries) {
                    *entry = std::mem::take(&mut generator[(row, column)]);
                }
            }
        }
        columns(&mut changed.rated_input);
        for direction in &mut changed.directions {
            let part = |of: fn(&MeshGain) -> [f64; 2]| direction.gains.iter().map(of).collect();
            let mut parts: [Vec<[f64; 2]>; 3] = [
                part(|g| g.deflection),
                part(|g| g.rate),
                part(|g| g.mesh_input),
            ];
            let [deflection, rate, mesh_input] = &mut parts;
            rows(deflection);
            rows(rate);
            columns(mesh_input);
            for (i, gain) in direction.gains.iter_mut().enumerate() {
                let [deflection, rate, mesh_input] = parts.each_ref().map(|part| part[i]);
                *gain = MeshGain {
                    deflection,
                    rate,
                    mesh_input,
                };
            }
        }
        changed
            .lines
            .iter_mut()
            .for_each(|line| rows(&mut line.direct));
        changed
            .ripple
            .iter_mut()
            .for_each(|r| columns(&mut r.input));
        changed.bearings.iter_mut().for_each(|b| rows(&mut b.gain));
        changed.outputs.iter_mut().for_each(|o| rows(&mut o.gain));
        (changed, generator)
    }

    /// The generators of all blocks as one matrix, 2N × 2N.
    fn generator(&self) -> Mat<f64> {
        let n = self.modes();
        Mat::from_fn(2 * n, 2 * n, |i, j| {
            if i % n == j % n { self.blocks[i % n].generator[i / n][j / n] } else { 0.0 }
        })
    }
}

/// The same matrix for displacements and for velocities.
fn twice(matrix: &Mat<f64>) -> Mat<f64> {
    let n = matrix.nrows();
    Mat::from_fn(2 * n, 2 * n, |i, j| {
        if i / n == j / n { matrix[(i % n, j % n)] } else { 0.0 }
    })
}

/// A matrix times a vector.
pub(super) fn times(matrix: &Mat<f64>, vector: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; matrix.nrows()];
    for (column, value) in matrix.col_iter().zip(vector) {
        for (out, entry) in out.iter_mut().zip(column.iter()) {
            *out += entry * value;
        }
    }
    out
}

/// First components of all blocks, then second ones.
fn flat(values: &[[f64; 2]]) -> Vec<f64> {
    [0, 1]
        .into_iter()
        .flat_map(|half| values.iter().map(move |value| value[half]))
        .collect()
}

/// The inverse of [`flat`].
fn pairs(values: &[f64]) -> Vec<[f64; 2]> {
    let (first, second) = values.split_at(values.len() / 2);
    first.iter().zip(second).map(|(a, b)| [*a, *b]).collect()
}
