//! The augmented linear system of one segment in one contact state.
//!
//! ```text
//! z = (x, f, s b, cos θ₁, sin θ₁, …),   z' = L z
//! ```
//!
//! x contains the blocks of the model (first components, then second components), f is the load in units of the rated
//! load, s the side of the contact (+1 drive, −1 coast), b the half gap. One (cos, sin) pair per harmonic of torque
//! ripple and transmission error contains its phase. With f and s b as coordinates, one operator serves both flanks,
//! every load and every gap. The entries after x are the carried entries. Tangent vectors are states whose carried
//! entries are zero.

use super::matrix::{add_scaled, blocks_and_inputs, dot, padded};
use crate::model::{MeshGain, Model, Segment};
use faer::Mat;

/// Indices of the entries of an augmented state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    /// Modes N; x is of length 2N.
    pub modes: usize,
    /// Number of harmonics of torque ripple; their pairs come first.
    pub ripples: usize,
    /// Number of harmonics of transmission error.
    pub errors: usize,
}

impl Layout {
    /// The layout of a model.
    pub fn new(model: &Model) -> Self {
        Self {
            modes: model.modes(),
            ripples: model.ripple.len(),
            errors: model.lines[0].transmission_error.len(),
        }
    }

    /// Number of harmonics of torque ripple and transmission error.
    pub fn harmonics(&self) -> usize {
        self.ripples + self.errors
    }

    /// Index of the load f; s b follows it.
    pub fn constant(&self) -> usize {
        2 * self.modes
    }

    /// Index of s b.
    pub fn side(&self) -> usize {
        2 * self.modes + 1
    }

    /// Index of the first (cos, sin) pair.
    pub fn pairs(&self) -> usize {
        2 * self.modes + 2
    }

    /// Number of entries of an augmented state.
    pub fn dimension(&self) -> usize {
        self.pairs() + 2 * self.harmonics()
    }

    /// Number of doubles of an augmented state in whole lane groups.
    pub fn padded(&self) -> usize {
        padded(self.dimension())
    }
}

/// The structure of the generator L: 2 × 2 blocks and a mesh force of rank one.
#[derive(Debug, Clone)]
pub struct Generator {
    layout: Layout,
    /// Entries 11, 12, 21, 22 of all blocks.
    blocks: [Vec<f64>; 4],
    /// Input of the rated load, length 2N.
    constant: Vec<f64>,
    /// Input of the cosine of every ripple, length 2N each.
    ripples: Vec<Vec<f64>>,
    /// Angular frequency of every pair \[rad/s\].
    pub frequencies: Vec<f64>,
    /// Mesh force \[N\] as a row; `None` in free flight.
    force: Option<Vec<f64>>,
    /// Input g of the mesh force, length 2N.
    mesh_input: Vec<f64>,
    /// Deflection δ \[m\] as a row.
    pub deflection: Vec<f64>,
    /// Rate δ' of the deflection \[m/s\] as a row.
    pub rate: Vec<f64>,
    /// Absolute values of the entries of `deflection`.
    pub magnitude: Vec<f64>,
}

impl Generator {
    /// The generator of a model on a segment, in contact or in free flight.
    pub fn new(model: &Model, segment: &Segment, touching: bool) -> Self {
        let layout = Layout::new(model);
        let n = layout.modes;
        let gains = model.gains(segment);
        let split = |entry: &dyn Fn(usize) -> [f64; 2]| -> Vec<f64> {
            let first = (0..n).map(|i| entry(i)[0]);
            first.chain((0..n).map(|i| entry(i)[1])).collect()
        };
        let row = |entry: fn(&MeshGain) -> [f64; 2]| {
            let mut row = split(&|i| entry(&gains[i]));
            row.resize(layout.padded(), 0.0);
            row
        };
        let (mut deflection, mut rate) = (row(|gain| gain.deflection), row(|gain| gain.rate));
        for (index, h) in model.lines[0].transmission_error.iter().enumerate() {
            // −e and −e' of amplitude cos(θ + phase).
            let at = layout.pairs() + 2 * (layout.ripples + index);
            let (sin, cos) = h.phase.sin_cos();
            let (place, speed) = (h.amplitude, h.amplitude * h.angular_frequency);
            deflection[at..at + 2].copy_from_slice(&[-place * cos, place * sin]);
            rate[at..at + 2].copy_from_slice(&[speed * sin, speed * cos]);
        }
        let force = touching.then(|| {
            let (k, c) = (segment.stiffness.mean(), segment.damping);
            let both = deflection.iter().zip(&rate);
            let mut row: Vec<f64> = both.map(|(d, r)| k * d + c * r).collect();
            row[layout.side()] = -k;
            row
        });
        let errors = model.lines[0].transmission_error.iter();
        Self {
            layout,
            blocks: std::array::from_fn(|entry| {
                let entries = model
                    .blocks
                    .iter()
                    .map(|b| b.generator[entry / 2][entry % 2]);
                entries.collect()
            }),
            constant: split(&|i| model.rated_input[i]),
            ripples: (model.ripple.iter())
                .map(|ripple| split(&|i| ripple.input[i]))
                .collect(),
            frequencies: (model.ripple.iter().map(|r| r.angular_frequency))
                .chain(errors.map(|h| h.angular_frequency))
                .collect(),
            force,
            mesh_input: split(&|i| gains[i].mesh_input),
            magnitude: deflection.iter().map(|w| w.abs()).collect(),
            deflection,
            rate,
        }
    }

    /// The layout of its states.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// Undamped frequency of a block \[rad/s\].
    pub fn frequency(&self, block: usize) -> f64 {
        let [a, b, c, d] = self.blocks.each_ref().map(|entries| entries[block]);
        (a * d - b * c).max(0.0).sqrt()
    }

    /// Writes `L z` to `out`, both in whole lane groups.
    pub fn apply(&self, z: &[f64], out: &mut [f64]) {
        let n = self.layout.modes;
        let force = self.force.as_ref().map_or(0.0, |row| dot(row, z));
        let load = z[self.layout.constant()];
        blocks_and_inputs(
            self.blocks.each_ref().map(Vec::as_slice),
            &z[..2 * n],
            [(-force, &self.mesh_input), (load, &self.constant)],
            &mut out[..2 * n],
        );
        out[2 * n..].fill(0.0);
        for (index, input) in self.ripples.iter().enumerate() {
            let cos = z[self.layout.pairs() + 2 * index];
            add_scaled(cos, input, &mut out[..2 * n]);
        }
        for (index, frequency) in self.frequencies.iter().enumerate() {
            let at = self.layout.pairs() + 2 * index;
            out[at] = -frequency * z[at + 1];
            out[at + 1] = frequency * z[at];
        }
    }

    /// Writes the row `row · L` to `out`.
    pub fn apply_to_row(&self, row: &[f64], out: &mut [f64]) {
        let n = self.layout.modes;
        let dot_row = |input: &[f64]| -> f64 { input.iter().zip(row).map(|(g, r)| g * r).sum() };
        out.fill(0.0);
        let [a, b, c, d] = &self.blocks;
        for i in 0..n {
            out[i] = row[i] * a[i] + row[n + i] * c[i];
            out[n + i] = row[i] * b[i] + row[n + i] * d[i];
        }
        out[self.layout.constant()] = dot_row(&self.constant);
        for (index, frequency) in self.frequencies.iter().enumerate() {
            let at = self.layout.pairs() + 2 * index;
            out[at] = frequency * row[at + 1];
            out[at + 1] = -frequency * row[at];
        }
        for (index, input) in self.ripples.iter().enumerate() {
            out[self.layout.pairs() + 2 * index] += dot_row(input);
        }
        if let Some(force) = &self.force {
            let push = dot_row(&self.mesh_input);
            for (out, force) in out.iter_mut().zip(force) {
                *out -= push * force;
            }
        }
    }

    /// L as a matrix.
    pub fn matrix(&self) -> Mat<f64> {
        let d = self.layout.dimension();
        let mut matrix = Mat::zeros(d, d);
        let padded = self.layout.padded();
        let (mut unit, mut column) = (vec![0.0; padded], vec![0.0; padded]);
        for j in 0..d {
            unit[j] = 1.0;
            self.apply(&unit, &mut column);
            unit[j] = 0.0;
            for i in 0..d {
                matrix[(i, j)] = column[i];
            }
        }
        matrix
    }

    /// δ'' \[m/s²\] as a row.
    pub fn curvature(&self) -> Vec<f64> {
        let mut row = vec![0.0; self.layout.padded()];
        self.apply_to_row(&self.rate, &mut row);
        row
    }
}
