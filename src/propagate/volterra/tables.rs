//! Everything a kernel computes once for an operating point.

use super::TERMS;
use super::lanes::{BlockChunk, LANES, Lanes, WindowChunk};
use crate::model::{Block, Model};
use crate::numerics::convolution::convolution16;
use crate::numerics::exponential::{
    Complex, LARGEST_HALF_ARGUMENT, RIGID_PHASE, legendre_series, multiply,
};
use crate::numerics::linalg::invert;

/// A series on a window.
pub type Series = [f64; TERMS];

/// Terms of the series of response kernels; the convolution table's first size.
const KERNEL_TERMS: usize = 32;

/// The solution operator of one distinct segment.
#[derive(Debug)]
pub struct Feedback {
    /// Mesh stiffness k \[N/m\].
    pub stiffness: f64,
    /// Contact damping c \[N s/m\].
    pub damping: f64,
    /// Columns of `S = (I + k B + c B')⁻¹`.
    pub solution: [Series; TERMS],
}

/// A harmonic input on full windows that start at its phase 0, as complex amplitudes.
#[derive(Debug)]
pub struct Harmonic {
    /// Angular frequency \[rad/s\].
    pub angular_frequency: f64,
    /// Contribution to δ.
    pub deflection: [Complex; TERMS],
    /// Contribution to δ'.
    pub rate: [Complex; TERMS],
    /// Contribution to the state at the window's end, padded first then second
    /// components; empty for the transmission error.
    pub state: Vec<Complex>,
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
    /// Eigenvalues and gains of the blocks.
    pub blocks: Vec<BlockChunk>,
    /// D and E.
    pub windows: Vec<WindowChunk>,
    /// Rows of R: one series a state component, first components then second.
    pub deflection: Vec<Series>,
    /// Rows of R'.
    pub rate: Vec<Series>,
    /// Columns of B.
    pub response: [Series; TERMS],
    /// δ of the mean torques on a window.
    pub static_deflection: Series,
    /// δ' of the mean torques on a window.
    pub static_rate: Series,
    /// State that the mean torques add over a window, padded.
    pub static_state: Vec<f64>,
    /// One a mesh segment.
    pub feedback: Vec<Feedback>,
    /// Segment of every cell.
    pub segment_of_cell: Vec<usize>,
    /// First cell after each segment.
    pub segment_end_cell: Vec<usize>,
    /// Start of every cell \[s\], and the period.
    pub cell_time: Vec<f64>,
    /// Transmission error: δ and δ' of `−e`, amplitude and phase included.
    pub transmission_error: Vec<Harmonic>,
    /// Torque ripple, phase left out.
    pub ripple: Vec<Harmonic>,
}

impl Tables {
    /// Tables for a model; see [`super::Volterra::new`] for `tolerance`.
    pub fn new(model: &Model, tolerance: f64) -> Self {
        let cycle = &model.cycle;
        let cells = windows_needed(model, tolerance) as usize;
        let delta = cycle.period / cells as f64;
        let cell = |division: usize| division * cells / cycle.divisions;

        let padded = model.modes().div_ceil(LANES) * LANES;
        let mut tables = Self {
            cells,
            delta,
            padded,
            blocks: block_chunks(model, delta),
            windows: Vec::new(),
            deflection: vec![[0.0; TERMS]; 2 * padded],
            rate: vec![[0.0; TERMS]; 2 * padded],
            response: [[0.0; TERMS]; TERMS],
            static_deflection: [0.0; TERMS],
            static_rate: [0.0; TERMS],
            static_state: vec![0.0; 2 * padded],
            feedback: Vec::new(),
            segment_of_cell: vec![0; cells],
            segment_end_cell: Vec::new(),
            cell_time: (0..=cells)
                .map(|c| cycle.period * c as f64 / cells as f64)
                .collect(),
            transmission_error: Vec::new(),
            ripple: Vec::new(),
        };
        for (index, segment) in cycle.segments.iter().enumerate() {
            let (first, end) = (cell(segment.first), cell(segment.first + segment.length));
            tables.segment_of_cell[first..end].fill(index);
            tables.segment_end_cell.push(end);
        }
        tables.fill_linear(model);
        tables.fill_excitation(model);
        tables
    }

    /// Series of the block exponentials and all that follows from them: R, R', D, E, B, S and
    /// the mean torques.
    fn fill_linear(&mut self, model: &Model) {
        let delta = self.delta;
        let zero = [0.0; LANES];
        self.windows = vec![
            WindowChunk {
                propagator: [zero; 4],
                response: [[zero; 2]; TERMS],
            };
            self.padded / LANES
        ];
        let mut impulse = Kernels::default();
        let mut torque = Kernels::default();
        for (i, block) in model.blocks.iter().enumerate() {
            let exponential = BlockExponential::new(block, delta);
            let (chunk, lane) = (i / LANES, i % LANES);
            let rate = block.rate();
            for n in 0..TERMS {
                let e = exponential.matrix(n);
                for j in 0..2 {
                    let row = j * self.padded + i;
                    self.deflection[row][n] =
                        block.deflection[0] * e[0][j] + block.deflection[1] * e[1][j];
                    self.rate[row][n] = rate[0] * e[0][j] + rate[1] * e[1][j];
                }
                let moment = moment(n, delta);
                let g = apply(e, block.mesh_input);
                self.windows[chunk].response[n][0][lane] = -moment * g[0];
                self.windows[chunk].response[n][1][lane] = -moment * g[1];
            }
            let d = exponential.end();
            for (k, value) in [d[0][0], d[0][1], d[1][0], d[1][1]].into_iter().enumerate() {
                self.windows[chunk].propagator[k][lane] = value;
            }
            let s = apply(exponential.matrix(0), block.static_input);
            self.static_state[i] = delta * s[0];
            self.static_state[self.padded + i] = delta * s[1];
            impulse.add(block, &exponential, block.mesh_input);
            torque.add(block, &exponential, block.static_input);
        }
        let convolution = convolution16();
        self.response = convolution.operator(&impulse.deflection, delta);
        let response_rate = convolution.operator(&impulse.rate, delta);
        self.static_deflection = convolution.operator(&torque.deflection, delta)[0];
        self.static_rate = convolution.operator(&torque.rate, delta)[0];
        self.feedback = model
            .cycle
            .segments
            .iter()
            .map(|segment| {
                let (k, c) = (segment.stiffness, segment.damping);
                let columns = std::array::from_fn(|j| {
                    std::array::from_fn(|i| {
                        f64::from(u8::from(i == j))
                            + k * self.response[j][i]
                            + c * response_rate[j][i]
                    })
                });
                Feedback {
                    stiffness: k,
                    damping: c,
                    solution: invert(&columns),
                }
            })
            .collect();
    }

    /// Transmission error and torque ripple on full windows.
    fn fill_excitation(&mut self, model: &Model) {
        let delta = self.delta;
        for h in &model.transmission_error {
            let mut series = [(0.0, 0.0); TERMS];
            legendre_series((0.0, h.angular_frequency), delta, &mut series);
            let amplitude = (-h.amplitude * h.phase.cos(), -h.amplitude * h.phase.sin());
            let deflection = series.map(|u| multiply(amplitude, u));
            self.transmission_error.push(Harmonic {
                angular_frequency: h.angular_frequency,
                deflection,
                rate: deflection.map(|u| multiply((0.0, h.angular_frequency), u)),
                state: Vec::new(),
            });
        }
        for ripple in &model.ripple {
            let mut series = [(0.0, 0.0); TERMS];
            legendre_series((0.0, ripple.angular_frequency), delta, &mut series);
            let mut kernels = Kernels::default();
            let mut state = vec![(0.0, 0.0); 2 * self.padded];
            for (i, (block, input)) in model.blocks.iter().zip(&ripple.input).enumerate() {
                let exponential = BlockExponential::new(block, delta);
                kernels.add(block, &exponential, *input);
                for (n, u) in series.iter().enumerate() {
                    let e = apply(exponential.matrix(n), *input);
                    let moment = moment(n, delta);
                    for (j, e) in e.into_iter().enumerate() {
                        let target = &mut state[j * self.padded + i];
                        target.0 += moment * e * u.0;
                        target.1 += moment * e * u.1;
                    }
                }
            }
            let combine = |kernel: &[f64; KERNEL_TERMS]| {
                let columns = convolution16().operator(kernel, delta);
                let mut out = [(0.0, 0.0); TERMS];
                for (column, u) in columns.iter().zip(&series) {
                    for (o, c) in out.iter_mut().zip(column) {
                        o.0 += c * u.0;
                        o.1 += c * u.1;
                    }
                }
                out
            };
            self.ripple.push(Harmonic {
                angular_frequency: ripple.angular_frequency,
                deflection: combine(&kernels.deflection),
                rate: combine(&kernels.rate),
                state,
            });
        }
    }
}

/// Windows a mesh cycle: the fewest that fit the segments and are short enough for the
/// tolerance.
pub fn windows_needed(model: &Model, tolerance: f64) -> f64 {
    let cycle = &model.cycle;
    let grid = cycle
        .segments
        .iter()
        .fold(cycle.divisions, |g, s| gcd(g, s.length));
    let base = (cycle.divisions / grid) as f64;
    let half_argument = 0.5 * fastest_rate(model) * cycle.period;
    base * (half_argument / (base * largest_half_argument(tolerance)))
        .ceil()
        .max(1.0)
}

/// `∫₀^τ P_n(2s/τ − 1) e^{A(τ−s)} ds` is this factor times coefficient n of `e^{At}`.
pub fn moment(n: usize, tau: f64) -> f64 {
    let sign = if n.is_multiple_of(2) { 1.0 } else { -1.0 };
    sign * tau / (2 * n + 1) as f64
}

/// Upper bound of the rates \[1/s\] in any contact state and of the excitation: with the
/// spring closed an eigenvalue moves by at most the norm of what is added.
pub fn fastest_rate(model: &Model) -> f64 {
    let mut open: f64 = 0.0;
    let (mut stiffening, mut damping) = (0.0, 0.0);
    for block in &model.blocks {
        open = open.max(block.natural_frequency());
        let [w1, w2] = block.deflection;
        let [r1, r2] = block.rate();
        let [g1, g2] = block.mesh_input;
        stiffening += (r1 * g1 + r2 * g2).abs();
        damping += (r1 * g1 + r2 * g2).abs() + (w1 * g1 + w2 * g2).abs();
    }
    let k = model.cycle.largest_stiffness();
    let c = model
        .cycle
        .segments
        .iter()
        .map(|s| s.damping)
        .fold(0.0, f64::max);
    let closed = (open * open + k * stiffening).sqrt() + c * damping;
    let excitation = model
        .transmission_error
        .iter()
        .map(|h| h.angular_frequency)
        .chain(model.ripple.iter().map(|r| r.angular_frequency));
    excitation.fold(closed, f64::max)
}

/// Tolerances below mean this one: windows thirty times shorter than round-off asks for.
const SMALLEST_TOLERANCE: f64 = 1e-40;

/// The half argument κ at which the first coefficient left out, about
/// `(2P+1) κ^P / (2P+1)!!`, reaches the tolerance.
fn largest_half_argument(tolerance: f64) -> f64 {
    let tolerance = tolerance.max(SMALLEST_TOLERANCE);
    let double_factorial: f64 = (1..=TERMS).map(|n| (2 * n + 1) as f64).product();
    let power = tolerance * double_factorial / (2 * TERMS + 1) as f64;
    power.powf(1.0 / TERMS as f64).min(LARGEST_HALF_ARGUMENT)
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// μ, ν of a block; a rigid rotation gets the ν of [`RIGID_PHASE`].
fn eigenvalue(block: &Block, delta: f64) -> (f64, f64) {
    let nu = block.damped_frequency().unwrap_or(0.0);
    (block.growth(), nu.max(RIGID_PHASE / delta))
}

fn block_chunks(model: &Model, delta: f64) -> Vec<BlockChunk> {
    let zero: Lanes = [0.0; LANES];
    model
        .blocks
        .chunks(LANES)
        .map(|group| {
            let mut chunk = BlockChunk {
                growth: zero,
                // Padding lanes: any harmless frequency.
                frequency: [RIGID_PHASE / delta; LANES],
                inverse_frequency: zero,
                traceless: [zero; 4],
                mesh_input: [zero; 2],
                static_input: [zero; 2],
            };
            for (l, block) in group.iter().enumerate() {
                let (mu, nu) = eigenvalue(block, delta);
                chunk.growth[l] = mu;
                chunk.frequency[l] = nu;
                chunk.inverse_frequency[l] = 1.0 / nu;
                let m = block.traceless();
                for (k, value) in [m[0][0], m[0][1], m[1][0], m[1][1]].into_iter().enumerate() {
                    chunk.traceless[k][l] = value;
                }
                for j in 0..2 {
                    chunk.mesh_input[j][l] = block.mesh_input[j];
                    chunk.static_input[j][l] = block.static_input[j];
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
