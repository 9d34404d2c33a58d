//! The tables that depend on the length of a window and on the direction of the mesh force.

use super::block_exponential::{BlockExponential, Kernels, impulse};
use super::contact_tables::{ContactRequest, ContactTables, LineResponse};
use super::lanes::{self, ExponentialChunk, Windows};
use super::shapes::{LANES, Row, TERMS, TableLayout};
use super::window_stiffness::WindowStiffness;
use crate::model::Model;
use crate::numerics::convolution::convolution24;
use crate::numerics::exponential::legendre_series;
use crate::propagate::vectors::InstructionSet;
use num_complex::{Complex64, c64};
use std::sync::{Arc, OnceLock};

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
    pub tails: Arc<Vec<f64>>,
    /// Direction of the mesh force, among the model's.
    pub direction: usize,
    /// Series of every torque ripple's `e^{iωt}` on a full window.
    pub ripple: Vec<[Complex64; TERMS]>,
    /// The data from which the tables of windows in contact are computed.
    request: ContactRequest,
    contact: OnceLock<ContactTables>,
}

impl WindowTable {
    /// Tables for windows of a length \[s\] and a direction, without those of windows in contact. `closures` are the
    /// stiffnesses of contacts on such windows, with a flag for further windows with a varying stiffness. `other_lines`
    /// are the lines with a requested response. `exponentials` are those of the blocks on a window of this length,
    /// `frequencies` those of the transmission errors. `known` are tables that may share arrays with the new one.
    pub fn new(
        (model, layout): (&Model, TableLayout),
        (delta, direction): (f64, usize),
        exponentials: &[BlockExponential],
        (closures, varying): (Vec<WindowStiffness>, bool),
        (other_lines, frequencies): (&[usize], &[[f64; 2]]),
        known: &[Self],
    ) -> Self {
        let same_length = known.iter().rev().find(|table| table.delta == delta);
        let line = |direction: usize| model.directions[direction].line;
        let same_rows = (known.iter().rev())
            .find(|table| table.delta == delta && line(table.direction) == line(direction));
        let series = match same_length {
            Some(table) => Arc::clone(&table.exponentials),
            None => Arc::new(in_chunks(exponentials)),
        };
        let terms: Vec<_> = series.iter().map(|chunk| chunk.terms).collect();
        let along = |line: usize| {
            let seen = model.directions.iter().find(|seen| seen.line == line);
            &seen.unwrap_or(&model.directions[direction]).gains
        };
        let own = &model.directions[direction].gains;
        let request = ContactRequest {
            delta,
            closures,
            varying,
            impulse: impulse(own, own, exponentials),
            other_lines: (other_lines.iter())
                .map(|&line| LineResponse {
                    line,
                    at_once: model.direct_reduction(line, direction),
                    impulse: impulse(along(line), own, exponentials),
                })
                .collect(),
        };
        let mut table = Self {
            delta,
            exponentials: series,
            moves: Windows::new(&terms, layout.acting),
            rows: Arc::default(),
            tails: Arc::default(),
            direction,
            ripple: Vec::new(),
            request,
            contact: OnceLock::new(),
        };
        table.fill_moves(model, exponentials);
        let mut rows = match same_rows {
            Some(_) => Vec::new(),
            None => table.free_rows(model, layout, exponentials),
        };
        table.fill_ripple(model, layout, exponentials, &mut rows);
        match same_rows {
            Some(known) => {
                table.rows = Arc::clone(&known.rows);
                table.tails = Arc::clone(&known.tails);
            }
            None => {
                table.add_transmission_error(model, layout, frequencies, &mut rows);
                table.tails = Arc::new(rows.iter().map(lanes::tail).collect());
                table.rows = Arc::new(rows);
            }
        }
        table
    }

    /// The tables of windows in contact, made at the first call.
    #[inline]
    pub fn contact(&self, set: InstructionSet) -> &ContactTables {
        self.contact.get_or_init(|| self.request.tables(set))
    }

    /// Numbers that a full window in contact reads: R, S̃ and Q̃ with their gap columns, D and E.
    pub fn numbers_read(&self) -> usize {
        self.rows.len() * TERMS + 2 * (TERMS + 1) * TERMS + self.moves.numbers()
    }

    /// Stored numbers after all contacts have closed: those that full windows read, all solution operators, and the
    /// exponentials. A shared array counts in proportion.
    pub fn numbers(&self) -> usize {
        let others = self.request.closures.len().saturating_sub(1) * 2 * (TERMS + 1) * TERMS;
        let exponentials = size_of_val(&**self.exponentials) / size_of::<f64>();
        let rows = self.rows.len() * TERMS;
        (self.numbers_read() - rows)
            + others
            + rows / Arc::strong_count(&self.rows)
            + exponentials / Arc::strong_count(&self.exponentials)
    }

    /// D, E and the mean torques' effect on the state.
    fn fill_moves(&mut self, model: &Model, exponentials: &[BlockExponential]) {
        let delta = self.delta;
        let gains = &model.directions[self.direction].gains;
        for (i, (block, exponential)) in model.blocks.iter().zip(exponentials).enumerate() {
            for n in 0..TERMS {
                let g = exponential.response(n, gains[i].mesh_input);
                let moment = -moment(n, delta);
                self.moves
                    .set_response(i, n, [moment * g[0], moment * g[1]]);
            }
            self.moves.set_propagator(i, exponential.end());
            let s = exponential.response(0, block.static_input);
            self.moves.set_input(i, 0, [delta * s[0], delta * s[1]]);
        }
    }

    /// R of the blocks and the mean torques' effect on δ.
    fn free_rows(
        &self,
        model: &Model,
        layout: TableLayout,
        exponentials: &[BlockExponential],
    ) -> Vec<Row> {
        let direction = &model.directions[self.direction];
        let mut rows = vec![Row::ZERO; 2 * layout.padded + layout.inputs];
        let mut torque = Kernels::default();
        let blocks = model.blocks.iter().zip(&direction.gains).zip(exponentials);
        for (i, ((block, gain), exponential)) in blocks.enumerate() {
            let (w, m) = (gain.deflection, &exponential.traceless);
            let turned = [0, 1].map(|j| w[0] * m[0][j] + w[1] * m[1][j]);
            for n in 0..TERMS {
                for j in 0..2 {
                    rows[j * layout.padded + i].0[n] =
                        exponential.cosine[n] * w[j] + exponential.sine[n] * turned[j];
                }
            }
            torque.add(gain, exponential, block.static_input);
        }
        let constant = &mut rows[2 * layout.padded].0;
        *constant = convolution24().step(&torque.deflection, self.delta);
        let inputs: Vec<[f64; 2]> = model
            .blocks
            .iter()
            .map(|block| block.static_input)
            .collect();
        constant[0] += model.direct_increase(direction.line, &inputs);
        rows
    }

    /// Effect of the torque ripples on state and δ. The inputs include the phases of the ripples. `all` are the rows
    /// of R, or empty if another table has them.
    fn fill_ripple(
        &mut self,
        model: &Model,
        layout: TableLayout,
        exponentials: &[BlockExponential],
        all: &mut [Row],
    ) {
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
            self.ripple.push(series);
            if all.is_empty() {
                continue;
            }
            let columns = convolution24().operator(&kernels.deflection, delta);
            let rows = &mut all[2 * layout.padded + 1 + 2 * index..][..2];
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
        }
    }

    /// The transmission error's effect on δ, `−e`, with amplitude and phase.
    fn add_transmission_error(
        &self,
        model: &Model,
        layout: TableLayout,
        frequencies: &[[f64; 2]],
        rows: &mut [Row],
    ) {
        let first = 2 * layout.padded + layout.acting;
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
}

/// Series of the blocks' exponentials, by chunks of blocks.
fn in_chunks(exponentials: &[BlockExponential]) -> Vec<ExponentialChunk> {
    (exponentials.chunks(LANES))
        .map(|blocks| {
            let terms = blocks.iter().map(BlockExponential::terms).max();
            let mut chunk = ExponentialChunk {
                terms: terms.unwrap_or(2),
                ..ExponentialChunk::ZERO
            };
            for (lane, own) in blocks.iter().enumerate() {
                for (n, target) in chunk.series.iter_mut().enumerate() {
                    target[0].0[lane] = own.cosine[n];
                    target[1].0[lane] = own.sine[n];
                }
            }
            chunk
        })
        .collect()
}

/// `∫₀^Δ P_n(2s/Δ − 1) e^{A(Δ−s)} ds` is this factor times coefficient n of `e^{At}`.
fn moment(n: usize, delta: f64) -> f64 {
    let sign = if n.is_multiple_of(2) { 1.0 } else { -1.0 };
    sign * delta / (2 * n + 1) as f64
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
            let feedback = &table.contact(kernel.instructions).feedback;
            assert_eq!(feedback.len(), 2);
            let read = size_of_val(&table.rows[..]) + size_of_val(&feedback[0]) + own(table);
            assert_eq!(8 * table.numbers_read(), read);
        }
        assert_eq!(kernel.numbers_per_window(), windows[0].numbers_read());
        let [first, second] = [&windows[0], &windows[1]];
        assert!(Arc::ptr_eq(&first.rows, &second.rows));
        assert!(Arc::ptr_eq(&first.exponentials, &second.exponentials));
        let shared = size_of_val(&first.rows[..]) + size_of_val(&first.exponentials[..]);
        let each = |table: &super::WindowTable| {
            own(table) + size_of_val(&table.contact(kernel.instructions).feedback[..])
        };
        assert_eq!(kernel.bytes(), shared + each(first) + each(second));
    }
}
