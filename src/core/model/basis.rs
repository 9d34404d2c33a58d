//! In which coordinates is a structure a set of independent blocks?
//!
//! Modal displacements and velocities (q, v) of the structure follow from the blocks' states z by
//! `(q, v) = T z`. With modal damping T only rotates the rigid rotations among themselves, so
//! that at most one of them deflects the mesh, and blocks are modes: `z = (q, v)`. If dampers,
//! drag, gyroscopic terms or cross-coupled springs couple modes, T comes from the eigenvectors of
//! the coupled modes ([`crate::numerics::decoupling`]).

use super::error::ModelError;
use super::{Block, MeshGain};
use crate::numerics::decoupling::decouple;
use crate::structure::{ModalStructure, ModeShapes};
use std::sync::Arc;

/// Generator matrix of each block, row by row.
type Generators = Vec<[[f64; 2]; 2]>;

/// The transformation between modes and blocks.
#[derive(Debug, Clone, PartialEq)]
pub struct Basis {
    /// Indices of the structure's rigid modes.
    rigid: Vec<usize>,
    /// Orthonormal rigid motions, one per row, in terms of the structure's rigid modes. The first rows deflect no
    /// contact, the next ones deflect further contacts, and the last one deflects the mesh if any motion does.
    turned: Vec<Vec<f64>>,
    /// Number of these rows that deflect no contact.
    contact_free: usize,
    /// The coupling of the modes, after this rotation.
    coupled: Option<Coupled>,
    /// Number of modes of the structure.
    modes: usize,
    /// Number of blocks of dry sliders after those of the modes. They count as modes of the model; the
    /// structure does not have them.
    sliders: usize,
    /// Shapes of the structure's modes; `None` if they are unknown.
    shapes: Option<Arc<ModeShapes>>,
}

/// Coupled modes, in the rotated rigid motions and the elastic modes.
#[derive(Debug, Clone, PartialEq)]
pub struct Coupled {
    /// Maps states of the blocks to rotated modal displacements and velocities; 2N × 2N, row by row.
    pub to_modes: Vec<f64>,
    /// Its inverse.
    pub from_modes: Vec<f64>,
    /// Frequencies of the uncoupled modes \[rad/s\]; 0 for rigid ones.
    pub frequency: Vec<f64>,
    /// Whether there are gyroscopic terms, which depend on the speed.
    pub turns: bool,
    /// All damping and gyroscopic terms \[1/s\], N × N row by row.
    pub damping: Vec<f64>,
    /// All stiffness, `ω²` on the diagonal included \[1/s²\], N × N row by row.
    pub stiffness: Vec<f64>,
}

impl Basis {
    /// The basis of a structure that runs at a pinion speed \[rad/s\], with the generators of its
    /// blocks.
    ///
    /// # Errors
    /// [`ModelError::Coupling`] if modes cannot be separated.
    pub(super) fn new(
        structure: &ModalStructure,
        speed: f64,
    ) -> Result<(Self, Generators), ModelError> {
        let n = structure.modes();
        let rigid: Vec<usize> = (0..n).filter(|&i| structure.frequency[i] == 0.0).collect();
        let (turned, contact_free) = turned_basis(&rigid, structure.contact_rotations());
        let mut basis = Self {
            rigid,
            turned,
            contact_free,
            coupled: None,
            modes: n,
            sliders: 0,
            shapes: structure.shapes.clone(),
        };
        let damped = structure.frequency.iter().zip(&structure.damping);
        let modes = damped.map(|(&frequency, &ratio)| Block::mode(frequency, ratio, 0.0).generator);
        let Some(coupling) = &structure.coupling else {
            return Ok((basis, modes.collect()));
        };
        let mut damping: Vec<f64> = (coupling.damping.iter().zip(&coupling.gyroscopic))
            .map(|(c, g)| c + speed * g)
            .collect();
        let mut stiffness = coupling.stiffness.clone();
        for (entry, frame) in stiffness.iter_mut().zip(&structure.frame.stiffness) {
            *entry += speed * speed * frame;
        }
        for matrix in [&mut damping, &mut stiffness] {
            basis.turn_matrix(matrix);
        }
        for i in 0..n {
            damping[i * n + i] += 2.0 * structure.damping[i] * structure.frequency[i];
        }
        let decoupled = decouple(&structure.frequency, &damping, &stiffness)?;
        for i in 0..n {
            stiffness[i * n + i] += structure.frequency[i].powi(2);
        }
        basis.coupled = Some(Coupled {
            to_modes: decoupled.to_structure,
            from_modes: decoupled.from_structure,
            frequency: structure.frequency.clone(),
            turns: coupling.gyroscopic.iter().any(|g| *g != 0.0),
            damping,
            stiffness,
        });
        Ok((basis, decoupled.generators))
    }

    /// The basis with blocks of dry sliders added.
    pub(super) fn with_sliders(mut self, sliders: usize) -> Self {
        self.sliders = sliders;
        if let Some(coupled) = self.coupled.as_mut().filter(|_| sliders > 0) {
            let n = coupled.frequency.len();
            for matrix in [&mut coupled.to_modes, &mut coupled.from_modes] {
                *matrix = bordered(matrix, n, sliders, 1.0);
            }
            for matrix in [&mut coupled.damping, &mut coupled.stiffness] {
                *matrix = bordered(matrix, n, sliders, 0.0);
            }
            coupled.frequency.resize(n + sliders, 0.0);
        }
        self
    }

    /// The coupling of the modes; `None` if damping is modal.
    pub fn coupled(&self) -> Option<&Coupled> {
        self.coupled.as_ref()
    }

    /// Number of blocks N: the modes, then dry sliders.
    pub(super) fn blocks(&self) -> usize {
        self.modes + self.sliders
    }

    /// Number of blocks of dry sliders.
    pub(super) fn sliders(&self) -> usize {
        self.sliders
    }

    /// Shapes of the structure's modes; `None` if they are unknown.
    pub(super) fn shapes(&self) -> Option<&Arc<ModeShapes>> {
        self.shapes.as_ref()
    }

    /// Whether this basis and another one have the same rotated modes.
    pub(super) fn has_modes_of(&self, other: &Self) -> bool {
        let same_shapes = match (&self.shapes, &other.shapes) {
            (Some(own), Some(other)) => Arc::ptr_eq(own, other) || own == other,
            (own, other) => own.is_none() && other.is_none(),
        };
        self.turned == other.turned && same_shapes
    }

    /// Indices of the structure's rigid modes.
    pub(super) fn rigid(&self) -> &[usize] {
        &self.rigid
    }

    /// Indices of the rotated rigid modes that deflect no contact.
    pub fn without_contact(&self) -> &[usize] {
        &self.rigid[..self.contact_free]
    }

    /// Converts values per mode of the structure to the rotated modes, with 0 appended for every slider.
    pub(super) fn turn(&self, values: &[f64]) -> Vec<f64> {
        let mut out = values.to_vec();
        out.resize(values.len() + self.sliders, 0.0);
        for (row, &target) in self.turned.iter().zip(&self.rigid) {
            out[target] = row
                .iter()
                .zip(&self.rigid)
                .map(|(b, &i)| b * values[i])
                .sum();
        }
        out
    }

    /// The inverse of [`Self::turn`].
    fn turn_back(&self, values: &[f64]) -> Vec<f64> {
        let mut out = values[..values.len() - self.sliders].to_vec();
        for (j, &target) in self.rigid.iter().enumerate() {
            let rows = self.turned.iter().zip(&self.rigid);
            out[target] = rows.map(|(row, &i)| row[j] * values[i]).sum();
        }
        out
    }

    /// Converts rows and columns of an N × N matrix to the rotated modes.
    fn turn_matrix(&self, matrix: &mut Vec<f64>) {
        let n = (matrix.len() as f64).sqrt() as usize;
        for _ in 0..2 {
            let mut transposed = vec![0.0; n * n];
            for (i, row) in matrix.chunks_exact(n).enumerate() {
                for (j, value) in self.turn(row).into_iter().enumerate() {
                    transposed[j * n + i] = value;
                }
            }
            *matrix = transposed;
        }
    }

    /// Inputs of the blocks under a force on the rotated modes.
    pub(super) fn input(&self, force: &[f64]) -> Vec<[f64; 2]> {
        let n = force.len();
        let Some(coupled) = &self.coupled else {
            return force.iter().map(|f| [0.0, *f]).collect();
        };
        let of = |row: usize| -> f64 {
            let row = &coupled.from_modes[2 * n * row + n..][..n];
            row.iter().zip(force).map(|(t, f)| t * f).sum()
        };
        (0..n).map(|i| [of(i), of(n + i)]).collect()
    }

    /// The force on the rotated modes that gives the blocks these inputs.
    pub fn force(&self, inputs: &[[f64; 2]]) -> Vec<f64> {
        let n = inputs.len();
        let components = |part: usize| inputs.iter().map(move |input| input[part]);
        let state: Vec<f64> = components(0).chain(components(1)).collect();
        self.turned_modes(&state).split_off(n)
    }

    /// Converts a sum over the blocks' states to participations of the rotated modal displacements. The sum
    /// must not depend on modal velocities.
    pub fn displacement_gains(&self, rows: &[[f64; 2]]) -> Vec<f64> {
        let n = rows.len();
        let Some(coupled) = &self.coupled else {
            return rows.iter().map(|row| row[0]).collect();
        };
        let of = |mode: usize| -> f64 {
            let entry = |k: usize| coupled.from_modes[2 * n * k + mode];
            let of_block = |(k, row): (usize, &[f64; 2])| row[0] * entry(k) + row[1] * entry(n + k);
            rows.iter().enumerate().map(of_block).sum()
        };
        (0..n).map(of).collect()
    }

    /// Converts the sum `Σ values · q` of rotated modal displacements, and its rate, to sums over the blocks'
    /// states.
    pub(super) fn output(&self, values: &[f64]) -> [Vec<[f64; 2]>; 2] {
        let n = values.len();
        let Some(coupled) = &self.coupled else {
            return [
                values.iter().map(|w| [*w, 0.0]).collect(),
                values.iter().map(|w| [0.0, *w]).collect(),
            ];
        };
        [0, n].map(|first| {
            let of = |column: usize| -> f64 {
                let entry = |k: usize| coupled.to_modes[2 * n * (first + k) + column];
                (0..n).map(|k| values[k] * entry(k)).sum()
            };
            (0..n).map(|i| [of(i), of(n + i)]).collect()
        })
    }

    /// Converts the sum `Σ gain·q + Σ rate_gain·q'` over the modes of the structure to a sum over the blocks' states.
    /// `rate_gain` may be empty.
    pub(super) fn output_of(&self, gain: &[f64], rate_gain: &[f64]) -> Vec<[f64; 2]> {
        let [mut out, _] = self.output(&self.turn(gain));
        if !rate_gain.is_empty() {
            let [_, by_velocity] = self.output(&self.turn(rate_gain));
            for (out, rate) in out.iter_mut().zip(by_velocity) {
                *out = [out[0] + rate[0], out[1] + rate[1]];
            }
        }
        out
    }

    /// Gains of a contact for the blocks, from its rotated participations in deflection and force.
    pub(super) fn gains(&self, blocks: &[Block], w: &[f64], g: &[f64]) -> Vec<MeshGain> {
        if self.coupled.is_none() {
            let modes = blocks.iter().zip(w.iter().zip(g));
            return modes
                .map(|(block, (w, g))| MeshGain::mode(block, *w, *g))
                .collect();
        }
        let [deflection, rate] = self.output(w);
        let inputs = self.input(g);
        (deflection.into_iter().zip(rate).zip(inputs))
            .map(|((deflection, rate), mesh_input)| MeshGain {
                deflection,
                rate,
                mesh_input,
            })
            .collect()
    }

    /// The blocks' state (length 2N: first components, then second) of modal displacements
    /// \[m √kg\] and velocities \[m √kg/s\] of the structure.
    pub fn state(&self, displacement: &[f64], velocity: &[f64]) -> Vec<f64> {
        let mut turned = self.turn(displacement);
        turned.extend(self.turn(velocity));
        self.state_of_turned(&turned)
    }

    /// The blocks' state for rotated modal displacements and velocities, one after the other.
    pub fn state_of_turned(&self, turned: &[f64]) -> Vec<f64> {
        match &self.coupled {
            None => turned.to_vec(),
            Some(coupled) => times(&coupled.from_modes, turned),
        }
    }

    /// Rotated modal displacements and velocities of a state, one after the other.
    pub fn turned_modes(&self, state: &[f64]) -> Vec<f64> {
        match &self.coupled {
            None => state.to_vec(),
            Some(coupled) => times(&coupled.to_modes, state),
        }
    }

    /// Modal displacements \[m √kg\] and velocities \[m √kg/s\] of the structure in a state.
    pub fn modes(&self, state: &[f64]) -> [Vec<f64>; 2] {
        let turned = self.turned_modes(state);
        let (displacement, velocity) = turned.split_at(turned.len() / 2);
        [self.turn_back(displacement), self.turn_back(velocity)]
    }
}

/// Extends a square matrix of order `modes`, or of order `2 modes` in two halves, by `added` rows and columns
/// per half. The added part is `diagonal` times the identity.
fn bordered(matrix: &[f64], modes: usize, added: usize, diagonal: f64) -> Vec<f64> {
    let order = matrix.len().isqrt();
    let halves = order / modes;
    let wide = order + halves * added;
    let place = |i: usize| i + i / modes * added;
    let mut out = vec![0.0; wide * wide];
    for (i, row) in matrix.chunks_exact(order).enumerate() {
        for (j, value) in row.iter().enumerate() {
            out[place(i) * wide + place(j)] = *value;
        }
    }
    for half in 0..halves {
        for i in (0..added).map(|offset| place(half * modes) + modes + offset) {
            out[i * wide + i] = diagonal;
        }
    }
    out
}

/// A square matrix, row by row, times a vector.
fn times(matrix: &[f64], vector: &[f64]) -> Vec<f64> {
    let row = |row: &[f64]| row.iter().zip(vector).map(|(a, x)| a * x).sum();
    matrix.chunks_exact(vector.len()).map(row).collect()
}

/// Orthonormal rows that span the rigid modes, ordered from the end: the last row is along the first of the
/// `rotations` that deflect contacts, the row before it is in the plane of the first two, and so on. Also
/// returns the number of rows that are orthogonal to all `rotations`.
fn turned_basis(rigid: &[usize], rotations: Vec<Vec<f64>>) -> (Vec<Vec<f64>>, usize) {
    let n = rigid.len();
    let identity = |i: usize| (0..n).map(|j| f64::from(u8::from(i == j))).collect();
    let mut rows: Vec<Vec<f64>> = (0..n).map(identity).collect();
    let mut contact_free = n;
    for direction in rotations {
        let last = contact_free - 1;
        let w: Vec<f64> = (rows[..contact_free].iter())
            .map(|row| row.iter().zip(&direction).map(|(r, d)| r * d).sum())
            .collect();
        let norm = w.iter().map(|v| v * v).sum::<f64>().sqrt();
        // Householder reflection that maps w/|w| to the last remaining axis.
        let side = if w[last] > 0.0 { 1.0 } else { -1.0 };
        let mut v: Vec<f64> = w.iter().map(|x| x / norm).collect();
        v[last] += side;
        let square: f64 = v.iter().map(|x| x * x).sum();
        let reflected = (0..contact_free)
            .map(|i| {
                let flip = if i == last { -side } else { 1.0 };
                let factor =
                    |j: usize| flip * (f64::from(u8::from(i == j)) - 2.0 * v[i] * v[j] / square);
                let entry = |k: usize| (0..contact_free).map(|j| factor(j) * rows[j][k]).sum();
                (0..n).map(entry).collect()
            })
            .collect::<Vec<_>>();
        rows.splice(..contact_free, reflected);
        contact_free = last;
    }
    (rows, contact_free)
}
