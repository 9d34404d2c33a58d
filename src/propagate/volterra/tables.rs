//! Everything a kernel computes once for an operating point.

use super::TERMS;
use super::feedback::Feedback;

use super::lanes::{ExponentialChunk, LANES, Lanes, Windows};
use super::length::windows_needed;
use crate::model::{Block, Model};
use crate::numerics::convolution::convolution24;
use crate::numerics::exponential::{Complex, RIGID_PHASE, legendre_series, multiply};

/// A series on a window.
pub type Series = [f64; TERMS];

/// A series of a table, on cache lines of its own.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub struct Row(pub Series);

/// Terms of the series of response kernels; the convolution table's first size.
const KERNEL_TERMS: usize = 32;

/// What a chunk of blocks is made of.
#[derive(Debug, Clone, Copy)]
pub struct BlockChunk {
    /// Traceless part M, row by row.
    pub traceless: [Lanes; 4],
    /// Gain −g of the mesh force.
    pub mesh_pull: [Lanes; 2],
    /// Constant input of the mean torques.
    pub static_input: [Lanes; 2],
}

/// A torque ripple.
#[derive(Debug)]
pub struct RippleTable {
    /// Input of every chunk of blocks.
    pub input: Vec<[Lanes; 2]>,
    /// Series of `e^{iωt}` on a full window.
    pub series: [Complex; TERMS],
}

/// Tables of the structured kernel.
#[derive(Debug)]
pub struct Tables {
    /// Windows a mesh cycle.
    pub cells: usize,
    /// Window length Δ \[s\].
    pub delta: f64,
    /// Blocks rounded up to whole chunks.
    pub padded: usize,
    /// Gains of the blocks.
    pub blocks: Vec<BlockChunk>,
    /// Exponential series of the blocks on a full window.
    pub exponentials: Vec<ExponentialChunk>,
    /// D and E, and the inputs' responses.
    pub windows: Windows,
    /// Rows of R: one series an entry of the extended state (first components, second
    /// components, inputs).
    pub rows: Vec<Row>,
    /// Inputs: the constant 1, (cos, sin) of every ripple, then of every harmonic of the
    /// transmission error; rounded up to a multiple of 4.
    pub inputs: usize,
    /// Solution operators, one a distinct (k, c).
    pub feedback: Vec<Feedback>,
    /// Operator of every mesh segment.
    pub feedback_of_segment: Vec<usize>,
    /// Segment of every cell.
    pub segment_of_cell: Vec<usize>,
    /// First cell after each segment.
    pub segment_end_cell: Vec<usize>,
    /// Start of every cell \[s\], and the period.
    pub cell_time: Vec<f64>,
    /// (cos, sin) of the transmission error's harmonics at the start of every cell.
    pub cell_phases: Vec<f64>,
    /// Torque ripples.
    pub ripple: Vec<RippleTable>,
}

impl Tables {
    /// Tables for a model; see [`super::Volterra::new`] for `tolerance`.
    pub fn new(model: &Model, tolerance: f64) -> Self {
        let cycle = &model.cycle;
        let cells = windows_needed(model, tolerance) as usize;
        let delta = cycle.period / cells as f64;
        let cell = |division: usize| division * cells / cycle.divisions;

        let chunks = model.modes().div_ceil(LANES);
        let padded = chunks * LANES;
        let acting = 1 + 2 * model.ripple.len();
        let inputs = (acting + 2 * model.transmission_error.len()).next_multiple_of(4);
        let mut tables = Self {
            cells,
            delta,
            padded,
            blocks: block_chunks(model),
            exponentials: vec![ExponentialChunk::ZERO; chunks],
            windows: Windows::new(chunks, acting),
            rows: vec![Row([0.0; TERMS]); 2 * padded + inputs],
            inputs,
            feedback: Vec::new(),
            feedback_of_segment: Vec::new(),
            segment_of_cell: vec![0; cells],
            segment_end_cell: Vec::new(),
            cell_time: (0..=cells)
                .map(|c| cycle.period * c as f64 / cells as f64)
                .collect(),
            cell_phases: Vec::new(),
            ripple: Vec::new(),
        };
        for (index, segment) in cycle.segments.iter().enumerate() {
            let (first, end) = (cell(segment.first), cell(segment.first + segment.length));
            tables.segment_of_cell[first..end].fill(index);
            tables.segment_end_cell.push(end);
        }
        let exponentials: Vec<_> = model
            .blocks
            .iter()
            .map(|block| BlockExponential::new(block, delta))
            .collect();
        tables.fill_structure(model, &exponentials);
        tables.fill_feedback(model, &exponentials);
        tables.fill_ripple(model, &exponentials);
        tables.fill_transmission_error(model);
        tables
    }

    /// Inputs that act on the blocks, the first of all inputs.
    pub fn acting_inputs(&self) -> usize {
        1 + 2 * self.ripple.len()
    }

    /// R, D, E and the mean torques' effect on the state.
    fn fill_structure(&mut self, model: &Model, exponentials: &[BlockExponential]) {
        let delta = self.delta;
        for (i, (block, exponential)) in model.blocks.iter().zip(exponentials).enumerate() {
            let (chunk, lane) = (i / LANES, i % LANES);
            for n in 0..TERMS {
                let e = exponential.matrix(n);
                for j in 0..2 {
                    self.rows[j * self.padded + i].0[n] =
                        block.deflection[0] * e[0][j] + block.deflection[1] * e[1][j];
                }
                let g = apply(e, block.mesh_input);
                let moment = -moment(n, delta);
                self.windows
                    .set_response(i, n, [moment * g[0], moment * g[1]]);
                let target = &mut self.exponentials[chunk].0[n];
                target[0].0[lane] = exponential.cosine[n];
                target[1].0[lane] = exponential.sine[n];
            }
            self.windows.set_propagator(i, exponential.end());
            let s = apply(exponential.matrix(0), block.static_input);
            self.windows
                .set_response(i, TERMS, [delta * s[0], delta * s[1]]);
        }
    }

    /// S̃ and Q̃ of every distinct (k, c), and the mean torques' effect on δ.
    fn fill_feedback(&mut self, model: &Model, exponentials: &[BlockExponential]) {
        let mut impulse = Kernels::default();
        let mut torque = Kernels::default();
        for (block, exponential) in model.blocks.iter().zip(exponentials) {
            impulse.add(block, exponential, block.mesh_input);
            torque.add(block, exponential, block.static_input);
        }
        let convolution = convolution24();
        let response = convolution.operator(&impulse.deflection, self.delta);
        let response_rate = convolution.operator(&impulse.rate, self.delta);
        self.rows[2 * self.padded].0 = convolution.step(&torque.deflection, self.delta);
        for segment in &model.cycle.segments {
            let pair = (segment.stiffness, segment.damping);
            let known = self
                .feedback
                .iter()
                .position(|f| (f.stiffness, f.damping) == pair);
            let index = known.unwrap_or(self.feedback.len());
            if index == self.feedback.len() {
                let feedback = Feedback::new(pair, &response, &response_rate, self.delta);
                self.feedback.push(feedback);
            }
            self.feedback_of_segment.push(index);
        }
    }

    /// Torque ripples: their effect on state and δ, phase left out.
    fn fill_ripple(&mut self, model: &Model, exponentials: &[BlockExponential]) {
        let delta = self.delta;
        for (index, ripple) in model.ripple.iter().enumerate() {
            let column = TERMS + 1 + 2 * index;
            let mut series = [(0.0, 0.0); TERMS];
            legendre_series((0.0, ripple.angular_frequency), delta, &mut series);
            let mut kernels = Kernels::default();
            let mut input = vec![[Lanes::ZERO; 2]; self.blocks.len()];
            let blocks = model.blocks.iter().zip(exponentials).zip(&ripple.input);
            for (i, ((block, exponential), gain)) in blocks.enumerate() {
                kernels.add(block, exponential, *gain);
                let mut state = [(0.0, 0.0); 2];
                for (n, u) in series.iter().enumerate() {
                    let e = apply(exponential.matrix(n), *gain);
                    let moment = moment(n, delta);
                    for (target, e) in state.iter_mut().zip(e) {
                        target.0 += moment * e * u.0;
                        target.1 += moment * e * u.1;
                    }
                }
                self.windows.set_response(i, column, state.map(|s| s.0));
                self.windows
                    .set_response(i, column + 1, state.map(|s| -s.1));
                for j in 0..2 {
                    input[i / LANES][j].0[i % LANES] = gain[j];
                }
            }
            let columns = convolution24().operator(&kernels.deflection, delta);
            let rows = &mut self.rows[2 * self.padded + 1 + 2 * index..][..2];
            for (column, u) in columns.iter().zip(&series) {
                for n in 0..TERMS {
                    rows[0].0[n] += column[n] * u.0;
                    rows[1].0[n] -= column[n] * u.1;
                }
            }
            self.ripple.push(RippleTable { input, series });
        }
    }

    /// The transmission error's effect on δ, `−e`, amplitude and phase included.
    fn fill_transmission_error(&mut self, model: &Model) {
        for time in &self.cell_time {
            for h in &model.transmission_error {
                let (sin, cos) = (h.angular_frequency * time).sin_cos();
                self.cell_phases.extend([cos, sin]);
            }
        }
        let first = 2 * self.padded + self.acting_inputs();
        for (index, h) in model.transmission_error.iter().enumerate() {
            let mut series = [(0.0, 0.0); TERMS];
            legendre_series((0.0, h.angular_frequency), self.delta, &mut series);
            let amplitude = (-h.amplitude * h.phase.cos(), -h.amplitude * h.phase.sin());
            for (n, u) in series.iter().enumerate() {
                let value = multiply(amplitude, *u);
                self.rows[first + 2 * index].0[n] = value.0;
                self.rows[first + 2 * index + 1].0[n] = -value.1;
            }
        }
    }
}

/// `∫₀^Δ P_n(2s/Δ − 1) e^{A(Δ−s)} ds` is this factor times coefficient n of `e^{At}`.
fn moment(n: usize, delta: f64) -> f64 {
    let sign = if n.is_multiple_of(2) { 1.0 } else { -1.0 };
    sign * delta / (2 * n + 1) as f64
}

/// μ, ν of a block; a rigid rotation gets the ν of [`RIGID_PHASE`].
fn eigenvalue(block: &Block, delta: f64) -> (f64, f64) {
    let nu = block.damped_frequency().unwrap_or(0.0);
    (block.growth(), nu.max(RIGID_PHASE / delta))
}

fn block_chunks(model: &Model) -> Vec<BlockChunk> {
    model
        .blocks
        .chunks(LANES)
        .map(|group| {
            let mut chunk = BlockChunk {
                traceless: [Lanes::ZERO; 4],
                mesh_pull: [Lanes::ZERO; 2],
                static_input: [Lanes::ZERO; 2],
            };
            for (l, block) in group.iter().enumerate() {
                for (k, value) in block.traceless().as_flattened().iter().enumerate() {
                    chunk.traceless[k].0[l] = *value;
                }
                for j in 0..2 {
                    chunk.mesh_pull[j].0[l] = -block.mesh_input[j];
                    chunk.static_input[j].0[l] = block.static_input[j];
                }
            }
            chunk
        })
        .collect()
}

/// Legendre series of one block's `e^{At}` on a window.
struct BlockExponential {
    cosine: [f64; KERNEL_TERMS],
    sine: [f64; KERNEL_TERMS],
    end: [f64; 2],
    traceless: [[f64; 2]; 2],
}

impl BlockExponential {
    fn new(block: &Block, delta: f64) -> Self {
        let (mu, nu) = eigenvalue(block, delta);
        let mut series = [(0.0, 0.0); KERNEL_TERMS];
        let end = legendre_series((mu, nu), delta, &mut series);
        Self {
            cosine: series.map(|c| c.0),
            sine: series.map(|c| c.1 / nu),
            end: [end.0, end.1 / nu],
            traceless: block.traceless(),
        }
    }

    fn combine(&self, cosine: f64, sine: f64) -> [[f64; 2]; 2] {
        let m = &self.traceless;
        [
            [cosine + sine * m[0][0], sine * m[0][1]],
            [sine * m[1][0], cosine + sine * m[1][1]],
        ]
    }

    /// Coefficient n.
    fn matrix(&self, n: usize) -> [[f64; 2]; 2] {
        self.combine(self.cosine[n], self.sine[n])
    }

    /// `e^{AΔ}`.
    fn end(&self) -> [[f64; 2]; 2] {
        self.combine(self.end[0], self.end[1])
    }
}

fn apply(m: [[f64; 2]; 2], v: [f64; 2]) -> [f64; 2] {
    m.map(|row| row[0] * v[0] + row[1] * v[1])
}

/// Series of the scalar responses of δ and δ' to an impulse of some input.
struct Kernels {
    deflection: [f64; KERNEL_TERMS],
    rate: [f64; KERNEL_TERMS],
}

impl Default for Kernels {
    fn default() -> Self {
        Self {
            deflection: [0.0; KERNEL_TERMS],
            rate: [0.0; KERNEL_TERMS],
        }
    }
}

impl Kernels {
    fn add(&mut self, block: &Block, exponential: &BlockExponential, input: [f64; 2]) {
        let (w, r) = (block.deflection, block.rate());
        for n in 0..KERNEL_TERMS {
            let x = apply(exponential.matrix(n), input);
            self.deflection[n] += w[0] * x[0] + w[1] * x[1];
            self.rate[n] += r[0] * x[0] + r[1] * x[1];
        }
    }
}
