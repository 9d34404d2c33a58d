//! The tables that depend on the length of a window and on the direction of the mesh force.

use super::feedback::Feedback;
use super::lanes::{self, ExponentialChunk, Windows};
use super::shapes::{LANES, Layout, Row, TERMS};
use super::varying::{Factors, Nodal};
use super::window_stiffness::WindowStiffness;
use crate::model::{Block, MeshGain, Model};
use crate::numerics::convolution::{convolution24, significant};
use crate::numerics::exponential::legendre_series;
use crate::propagate::vectors::InstructionSet;
use num_complex::{Complex64, c64};
use std::sync::Arc;

/// Terms of the series of response kernels; the convolution table's first size.
const KERNEL_TERMS: usize = 32;

/// Tables of the windows of one length and one direction of the mesh force.
#[derive(Debug)]
pub struct WindowTable {
    /// Window length Δ \[s\].
    pub delta: f64,
    /// Exponential series of the blocks on a full window.
    pub exponentials: Arc<Vec<ExponentialChunk>>,
    /// D and E, and the inputs' responses.
    pub moves: Windows,
    /// Rows of R: one series per entry of the extended state (first components, second components, inputs).
    pub rows: Arc<Vec<Row>>,
    /// Bounds of the terms of every row beyond the first lane group.
    pub tails: Vec<f64>,
    /// Solution operators: one per distinct (k, c), or one per cell with a varying stiffness.
    pub feedback: Vec<Feedback>,
    /// Matrices for windows with a varying stiffness, if there are any.
    pub nodal: Option<Box<Nodal>>,
    /// Direction of the mesh force, among the model's.
    pub direction: usize,
    /// Series of every torque ripple's `e^{iωt}` on a full window.
    pub ripple: Vec<[Complex64; TERMS]>,
    /// Responses of other lines to the force.
    responses: Vec<Response>,
}

/// Response of the deflection along a line to a force: columns of B and B', series to series.
#[derive(Debug)]
pub struct Response {
    line: usize,
    /// Response of the deflection.
    pub deflection: [Row; TERMS],
    /// Bounds of its terms beyond the first lane group, one per column.
    pub tails: Row,
    /// Response of its rate.
    pub rate: [Row; TERMS],
}

impl WindowTable {
    /// Tables for windows of a length \[s\] and a direction. `closures` are the stiffnesses of contacts on such
    /// windows, with a flag for further windows with a varying stiffness. `response_lines` are the other lines that the
    /// force deflects. `exponentials` are those of the blocks on a window of this length, `frequencies` those of the
    /// transmission errors.
    pub fn new(
        model: &Model,
        layout: Layout,
        (delta, direction): (f64, usize),
        exponentials: &[BlockExponential],
        closures: (&[WindowStiffness], bool),
        (response_lines, frequencies): (&[usize], &[[f64; 2]]),
        set: InstructionSet,
    ) -> Self {
        let terms: Vec<_> = (exponentials.chunks(LANES))
            .map(|blocks| {
                blocks
                    .iter()
                    .map(BlockExponential::terms)
                    .max()
                    .unwrap_or(2)
            })
            .collect();
        let chunk = |&terms: &usize| ExponentialChunk {
            terms,
            ..ExponentialChunk::ZERO
        };
        let mut table = Self {
            delta,
            exponentials: Arc::new(terms.iter().map(chunk).collect()),
            moves: Windows::new(&terms, layout.acting),
            rows: Arc::new(vec![Row::ZERO; 2 * layout.padded + layout.inputs]),
            tails: Vec::new(),
            feedback: Vec::new(),
            nodal: None,
            direction,
            ripple: Vec::new(),
            responses: Vec::new(),
        };
        table.fill_structure(model, layout, exponentials);
        table.fill_feedback(model, layout, closures, exponentials, set);
        table.fill_ripple(model, layout, exponentials);
        table.fill_transmission_error(model, layout, frequencies);
        table.tails = table.rows.iter().map(lanes::tail).collect();
        table.responses = (response_lines.iter())
            .map(|&line| table.response(model, line, exponentials))
            .collect();
        table
    }

    /// Takes the tables that do not depend on the direction of the force from a table of the same windows:
    /// exponentials, and the rows of R if the line is the same.
    pub fn share(&mut self, model: &Model, known: &Self) {
        if known.delta == self.delta {
            self.exponentials = Arc::clone(&known.exponentials);
            let line = |table: &Self| model.directions[table.direction].line;
            if line(known) == line(self) {
                self.rows = Arc::clone(&known.rows);
            }
        }
    }

    /// Numbers that a full window in contact reads: R, S̃ and Q̃ with their gap columns, D and E.
    pub fn numbers_read(&self) -> usize {
        self.rows.len() * TERMS + 2 * (TERMS + 1) * TERMS + self.moves.numbers()
    }

    /// Stored numbers: those that full windows read, all solution operators, and the exponentials. A shared array
    /// counts in proportion.
    pub fn numbers(&self) -> usize {
        let others = self.feedback.len().saturating_sub(1) * 2 * (TERMS + 1) * TERMS;
        let exponentials = size_of_val(&**self.exponentials) / size_of::<f64>();
        let rows = self.rows.len() * TERMS;
        (self.numbers_read() - rows)
            + others
            + rows / Arc::strong_count(&self.rows)
            + exponentials / Arc::strong_count(&self.exponentials)
    }

    /// R, D, E and the mean torques' effect on the state.
    fn fill_structure(&mut self, model: &Model, layout: Layout, exponentials: &[BlockExponential]) {
        let delta = self.delta;
        let gains = &model.directions[self.direction].gains;
        let rows = Arc::make_mut(&mut self.rows);
        let series = Arc::make_mut(&mut self.exponentials);
        for (i, (block, exponential)) in model.blocks.iter().zip(exponentials).enumerate() {
            let (chunk, lane) = (i / LANES, i % LANES);
            let MeshGain {
                deflection: w,
                mesh_input,
                ..
            } = gains[i];
            let m = &exponential.traceless;
            let turned = [0, 1].map(|j| w[0] * m[0][j] + w[1] * m[1][j]);
            for n in 0..TERMS {
                for j in 0..2 {
                    rows[j * layout.padded + i].0[n] =
                        exponential.cosine[n] * w[j] + exponential.sine[n] * turned[j];
                }
                let g = exponential.response(n, mesh_input);
                let moment = -moment(n, delta);
                self.moves
                    .set_response(i, n, [moment * g[0], moment * g[1]]);
                let target = &mut series[chunk].series[n];
                target[0].0[lane] = exponential.cosine[n];
                target[1].0[lane] = exponential.sine[n];
            }
            self.moves.set_propagator(i, exponential.end());
            let s = exponential.response(0, block.static_input);
            self.moves.set_input(i, 0, [delta * s[0], delta * s[1]]);
        }
    }

    /// S̃ and Q̃ of every stiffness, and the mean torques' effect on δ.
    fn fill_feedback(
        &mut self,
        model: &Model,
        layout: Layout,
        (closures, varying): (&[WindowStiffness], bool),
        exponentials: &[BlockExponential],
        set: InstructionSet,
    ) {
        let gains = &model.directions[self.direction].gains;
        let mut impulse = Kernels::default();
        let mut torque = Kernels::default();
        for ((block, gain), exponential) in model.blocks.iter().zip(gains).zip(exponentials) {
            impulse.add(gain, exponential, gain.mesh_input);
            torque.add(gain, exponential, block.static_input);
        }
        let convolution = convolution24();
        let response = convolution.operator(&impulse.deflection, self.delta);
        let response_rate = convolution.operator(&impulse.rate, self.delta);
        Arc::make_mut(&mut self.rows)[2 * layout.padded].0 =
            convolution.step(&torque.deflection, self.delta);
        let line = model.directions[self.direction].line;
        let constant: Vec<[f64; 2]> = model
            .blocks
            .iter()
            .map(|block| block.static_input)
            .collect();
        Arc::make_mut(&mut self.rows)[2 * layout.padded].0[0] +=
            model.direct_increase(line, &constant);
        if varying || closures.iter().any(|closure| closure.varies()) {
            self.nodal = Some(Nodal::new(&response, &response_rate, self.delta));
        }
        let mut factors = Factors::NONE;
        self.feedback = (closures.iter())
            .map(|closure| match &self.nodal {
                Some(nodal) if closure.varies() => closure.feedback(set, nodal, &mut factors),
                _ => {
                    let pair = (closure.stiffness.mean(), closure.damping);
                    Feedback::new(pair, &response, &response_rate, self.delta)
                }
            })
            .collect();
    }

    /// Torque ripples: their effect on state and δ, without phase.
    fn fill_ripple(&mut self, model: &Model, layout: Layout, exponentials: &[BlockExponential]) {
        let delta = self.delta;
        let gains = &model.directions[self.direction].gains;
        for (index, ripple) in model.ripple.iter().enumerate() {
            let column = 1 + 2 * index;
            let mut series = [Complex64::ZERO; TERMS];
            legendre_series(c64(0.0, ripple.angular_frequency), delta, &mut series);
            let mut kernels = Kernels::default();
            let blocks = gains.iter().zip(exponentials).zip(&ripple.input);
            for (i, ((mesh, exponential), gain)) in blocks.enumerate() {
                kernels.add(mesh, exponential, *gain);
                let mut state = [Complex64::ZERO; 2];
                for (n, u) in series.iter().enumerate() {
                    let e = exponential.response(n, *gain);
                    let moment = moment(n, delta);
                    for (target, e) in state.iter_mut().zip(e) {
                        *target += moment * e * u;
                    }
                }
                self.moves.set_input(i, column, state.map(|s| s.re));
                self.moves.set_input(i, column + 1, state.map(|s| -s.im));
            }
            let columns = convolution24().operator(&kernels.deflection, delta);
            let rows = &mut Arc::make_mut(&mut self.rows)[2 * layout.padded + 1 + 2 * index..][..2];
            for (column, u) in columns.iter().zip(&series) {
                for n in 0..TERMS {
                    rows[0].0[n] += column[n] * u.re;
                    rows[1].0[n] -= column[n] * u.im;
                }
            }
            let line = model.directions[self.direction].line;
            let at_once = model.direct_increase(line, &ripple.input);
            for (n, u) in series.iter().enumerate() {
                rows[0].0[n] += at_once * u.re;
                rows[1].0[n] -= at_once * u.im;
            }
            self.ripple.push(series);
        }
    }

    /// The transmission error's effect on δ, `−e`, with amplitude and phase.
    fn fill_transmission_error(&mut self, model: &Model, layout: Layout, frequencies: &[[f64; 2]]) {
        let first = 2 * layout.padded + layout.acting;
        let rows = Arc::make_mut(&mut self.rows);
        let line = &model.lines[model.directions[self.direction].line];
        for (index, &[angular_frequency, turns_per_cycle]) in frequencies.iter().enumerate() {
            let mut series = [Complex64::ZERO; TERMS];
            legendre_series(c64(0.0, angular_frequency), self.delta, &mut series);
            let harmonics = (line.transmission_error.iter()).filter(|h| {
                [h.angular_frequency, h.turns_per_cycle] == [angular_frequency, turns_per_cycle]
            });
            for h in harmonics {
                let amplitude = -h.amplitude * Complex64::cis(h.phase);
                for (n, u) in series.iter().enumerate() {
                    let value = amplitude * u;
                    rows[first + 2 * index].0[n] += value.re;
                    rows[first + 2 * index + 1].0[n] -= value.im;
                }
            }
        }
    }

    /// Response of the deflection along a line to the force.
    pub fn response_on(&self, line: usize) -> Option<&Response> {
        self.responses.iter().find(|response| response.line == line)
    }

    fn response(&self, model: &Model, line: usize, exponentials: &[BlockExponential]) -> Response {
        let force = &model.directions[self.direction].gains;
        let along = model
            .directions
            .iter()
            .find(|direction| direction.line == line);
        let mut impulse = Kernels::default();
        for ((observed, gain), exponential) in along
            .map_or(force, |d| &d.gains)
            .iter()
            .zip(force)
            .zip(exponentials)
        {
            impulse.add(observed, exponential, gain.mesh_input);
        }
        let convolution = convolution24();
        let columns = |kernel| convolution.operator(kernel, self.delta).map(Row);
        let mut deflection = columns(&impulse.deflection);
        let at_once = model.direct_reduction(line, self.direction);
        for (n, column) in deflection.iter_mut().enumerate() {
            column.0[n] += at_once;
        }
        Response {
            line,
            tails: Row(deflection.each_ref().map(lanes::tail)),
            deflection,
            rate: columns(&impulse.rate),
        }
    }
}

/// `∫₀^Δ P_n(2s/Δ − 1) e^{A(Δ−s)} ds` is this factor times coefficient n of `e^{At}`.
fn moment(n: usize, delta: f64) -> f64 {
    let sign = if n.is_multiple_of(2) { 1.0 } else { -1.0 };
    sign * delta / (2 * n + 1) as f64
}

/// Legendre series of one block's `e^{At}` on a window.
pub struct BlockExponential {
    cosine: [f64; KERNEL_TERMS],
    sine: [f64; KERNEL_TERMS],
    end: [f64; 2],
    traceless: [[f64; 2]; 2],
}

impl BlockExponential {
    /// The series on a window of length `delta` \[s\].
    pub fn new(block: &Block, delta: f64) -> Self {
        let mut series = [Complex64::ZERO; KERNEL_TERMS];
        let end = block.exponential(delta, &mut series);
        Self {
            cosine: series.map(|c| c.re),
            sine: series.map(|c| c.im),
            end,
            traceless: block.traceless(),
        }
    }

    /// Number of significant terms, an even number; the others are below round-off.
    fn terms(&self) -> usize {
        let terms = significant(&self.cosine).max(significant(&self.sine));
        terms.clamp(1, TERMS).next_multiple_of(2)
    }

    /// Coefficient n of `e^{At} u`.
    fn response(&self, n: usize, u: [f64; 2]) -> [f64; 2] {
        let turned = apply(&self.traceless, u);
        [0, 1].map(|row| self.cosine[n] * u[row] + self.sine[n] * turned[row])
    }

    /// `e^{AΔ}`.
    fn end(&self) -> [[f64; 2]; 2] {
        let ([cosine, sine], m) = (self.end, &self.traceless);
        [
            [cosine + sine * m[0][0], sine * m[0][1]],
            [sine * m[1][0], cosine + sine * m[1][1]],
        ]
    }
}

fn apply(m: &[[f64; 2]; 2], v: [f64; 2]) -> [f64; 2] {
    m.map(|row| dot(row, v))
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
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
    fn add(&mut self, gain: &MeshGain, exponential: &BlockExponential, input: [f64; 2]) {
        let turned = apply(&exponential.traceless, input);
        for (sums, w) in [
            (&mut self.deflection, gain.deflection),
            (&mut self.rate, gain.rate),
        ] {
            let (even, odd) = (dot(w, input), dot(w, turned));
            let terms = exponential.cosine.iter().zip(&exponential.sine);
            for (sum, (cosine, sine)) in sums.iter_mut().zip(terms) {
                *sum += cosine * even + sine * odd;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::model::{Division, Drive, Model, fixtures};
    use crate::propagate::Volterra;
    use std::sync::Arc;

    /// Friction reverses within the cycle: two directions along one line, on windows of one length.
    fn model() -> Model {
        let mut structure = fixtures::structure(
            &[
                0.0, 0.0, 4288.0, 4864.0, 8171.0, 19757.0, 400.0, 900.0, 7000.0,
            ],
            0.01,
            &[0.61, -0.49, 0.72, 0.64, -0.48, 0.21, 0.1, 0.2, -0.3],
            &[0.61, -0.49, 0.33, -0.21, 0.05, 0.0, 0.1, 0.1, 0.0],
        );
        structure.friction = vec![0.1, 0.2, -0.17, 0.56, 0.3, -0.1, 0.0, 0.2, 0.1];
        let mut drive = Drive {
            friction: 0.1,
            ..fixtures::two_level_mesh(1e-5)
        };
        drive.mesh = Division::levels(&[4e8, 3e8, 3e8, 4e8], &[]);
        for division in &mut drive.mesh[2..] {
            division.friction = [-1.0, 0.0];
        }
        Model::new(&structure, &drive, fixtures::strong_rattle()).unwrap()
    }

    /// Bytes of arrays, each counted once even if shared.
    #[test]
    fn numbers_are_those_of_the_arrays() {
        let model = model();
        let kernel = Volterra::new(&model, f64::EPSILON, 100);
        let windows = &kernel.tables.windows;
        assert_eq!(windows.len(), 2);
        let own = |table: &super::WindowTable| 8 * table.moves.numbers();
        for table in windows {
            assert_eq!(table.feedback.len(), 2);
            let read = size_of_val(&table.rows[..]) + size_of_val(&table.feedback[0]) + own(table);
            assert_eq!(8 * table.numbers_read(), read);
        }
        assert_eq!(kernel.numbers_per_window(), windows[0].numbers_read());
        let [first, second] = [&windows[0], &windows[1]];
        assert!(Arc::ptr_eq(&first.rows, &second.rows));
        assert!(Arc::ptr_eq(&first.exponentials, &second.exponentials));
        let shared = size_of_val(&first.rows[..]) + size_of_val(&first.exponentials[..]);
        let each = |table| own(table) + size_of_val(&table.feedback[..]);
        assert_eq!(kernel.bytes(), shared + each(first) + each(second));
    }
}
