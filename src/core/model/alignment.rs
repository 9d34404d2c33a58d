//! How are the blocks of a model described in the coordinates of another model's blocks?
//!
//! The decoupling of coupled modes leaves a linear change of coordinates of every block free, and the order of
//! the blocks. Models at neighbouring values of a parameter can be compared after both are fixed. Let `S` be the
//! rows of T⁻¹ of a block of the reference, and `C` the columns of T of the matching block of the other model.
//! The new state of that block is `M z` with `M = S C`, so that its new columns `C M⁻¹` fulfil `S C M⁻¹ = I`. These
//! columns depend smoothly on the parameter, because the invariant plane that they span does.

use super::basis::Coupled;
use super::{MeshGain, Model};

/// Smallest overlap of matching blocks, 1 for equal planes. An overlap above 0.5 is possible with one block only.
const LEAST_OVERLAP: f64 = 0.5;

type Matrix = [[f64; 2]; 2];

/// The source of a block, and the change of its coordinates.
struct BlockChange {
    /// Index of the block in the old model.
    from: usize,
    /// M.
    matrix: Matrix,
    /// M⁻¹.
    inverse: Matrix,
}

impl BlockChange {
    /// A state, or an input, in the new coordinates.
    fn column(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        self.matrix.map(|[a, b]| a * x + b * y)
    }

    /// A sum over the components of the state in the new coordinates.
    fn row(&self, [a, b]: [f64; 2]) -> [f64; 2] {
        let [first, second] = self.inverse;
        [0, 1].map(|j| a * first[j] + b * second[j])
    }
}

impl Model {
    /// This model, with its blocks in the order and in the coordinates of the blocks of `reference`. `None` if a
    /// block has no match there.
    pub(super) fn aligned_to(&self, reference: &Self) -> Option<Self> {
        let changes = match (self.basis.coupled(), reference.basis.coupled()) {
            (None, None) => return Some(self.clone()),
            (Some(own), Some(other)) if own.to_modes == other.to_modes => {
                return Some(self.clone());
            }
            (Some(own), Some(other)) => block_changes(own, other)?,
            _ => return None,
        };
        let mut aligned = self.clone();
        aligned.change_blocks(&changes);
        Some(aligned)
    }

    fn change_blocks(&mut self, changes: &[BlockChange]) {
        let columns = |values: &mut Vec<[f64; 2]>| {
            *values = changes.iter().map(|c| c.column(values[c.from])).collect();
        };
        let rows = |values: &mut Vec<[f64; 2]>| {
            if !values.is_empty() {
                *values = changes.iter().map(|c| c.row(values[c.from])).collect();
            }
        };
        self.blocks = (changes.iter())
            .map(|change| {
                let mut block = self.blocks[change.from];
                let turned = block.generator.map(|row| change.row(row));
                let [first, second] = [0, 1].map(|j| change.column([turned[0][j], turned[1][j]]));
                block.generator = [[first[0], second[0]], [first[1], second[1]]];
                block.static_input = change.column(block.static_input);
                block
            })
            .collect();
        columns(&mut self.rated_input);
        for direction in &mut self.directions {
            let moved = |change: &BlockChange| {
                let gain = direction.gains[change.from];
                MeshGain {
                    deflection: change.row(gain.deflection),
                    rate: change.row(gain.rate),
                    mesh_input: change.column(gain.mesh_input),
                }
            };
            direction.gains = changes.iter().map(moved).collect();
        }
        self.lines
            .iter_mut()
            .for_each(|line| rows(&mut line.direct));
        self.ripple.iter_mut().for_each(|r| columns(&mut r.input));
        self.bearings.iter_mut().for_each(|b| rows(&mut b.gain));
        self.outputs.iter_mut().for_each(|o| rows(&mut o.gain));
        let n = changes.len();
        if let Some(coupled) = self.basis.coupled_mut() {
            let entry = |matrix: &[f64], i: usize, j: usize| matrix[2 * n * i + j];
            let (old, old_inverse) = (coupled.to_modes.clone(), coupled.from_modes.clone());
            for (k, change) in changes.iter().enumerate() {
                let places = [change.from, n + change.from];
                for m in 0..2 * n {
                    let to = change.row(places.map(|p| entry(&old, m, p)));
                    let from = change.column(places.map(|p| entry(&old_inverse, p, m)));
                    for half in [0, 1] {
                        coupled.to_modes[2 * n * m + half * n + k] = to[half];
                        coupled.from_modes[2 * n * (half * n + k) + m] = from[half];
                    }
                }
            }
        }
    }
}

/// The matching block of `own`, with its change of coordinates, for every block of `reference`.
fn block_changes(own: &Coupled, reference: &Coupled) -> Option<Vec<BlockChange>> {
    let n = own.frequency.len();
    if reference.frequency.len() != n {
        return None;
    }
    let forth = product(&reference.from_modes, &own.to_modes, n);
    let back = product(&own.from_modes, &reference.to_modes, n);
    let changes: Vec<BlockChange> = (0..n)
        .map(|k| {
            let overlap = |from: usize| {
                (determinant(&part(&forth, n, k, from)) * determinant(&part(&back, n, from, k)))
                    .abs()
            };
            let from = (0..n).max_by(|&a, &b| overlap(a).total_cmp(&overlap(b)))?;
            (overlap(from) > LEAST_OVERLAP).then_some(())?;
            let matrix = part(&forth, n, k, from);
            let scale = 1.0 / determinant(&matrix);
            let [[a, b], [c, d]] = matrix;
            let inverse = [[d * scale, -b * scale], [-c * scale, a * scale]];
            Some(BlockChange {
                from,
                matrix,
                inverse,
            })
        })
        .collect::<Option<_>>()?;
    let mut taken = vec![false; n];
    let is_new = |change: &BlockChange| !std::mem::replace(&mut taken[change.from], true);
    changes.iter().all(is_new).then_some(changes)
}

/// Product of two square matrices of order 2N, row by row.
fn product(a: &[f64], b: &[f64], n: usize) -> Vec<f64> {
    let mut out = vec![0.0; 4 * n * n];
    for (row, values) in a.chunks_exact(2 * n).enumerate() {
        let out = &mut out[2 * n * row..][..2 * n];
        for (factor, other) in values.iter().zip(b.chunks_exact(2 * n)) {
            for (sum, value) in out.iter_mut().zip(other) {
                *sum += factor * value;
            }
        }
    }
    out
}

/// Entries of a matrix of order 2N between block `row` and block `column`.
fn part(matrix: &[f64], n: usize, row: usize, column: usize) -> Matrix {
    [row, n + row].map(|i| [column, n + column].map(|j| matrix[2 * n * i + j]))
}

fn determinant([[a, b], [c, d]]: &Matrix) -> f64 {
    a * d - b * c
}
