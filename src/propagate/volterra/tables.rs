//! Everything a kernel computes once for an operating point.

use super::closure::Closure;
use super::feedback::Feedback;
use super::grid::Grid;
use super::lanes::InstructionSet;
use super::shapes::{BlockChunk, LANES, Lack, Lanes, Layout};
use super::window_table::{BlockExponential, WindowTable};
use crate::model::{Block, MeshGain, Model, Segment};
use crate::numerics::legendre::transforms8;

/// Tables of the structured kernel.
#[derive(Debug)]
pub struct VolterraTables {
    /// Sizes.
    pub layout: Layout,
    /// Where windows start.
    pub grid: Grid,
    /// One table a length of window in the grid and direction of the mesh force.
    pub windows: Vec<WindowTable>,
    /// Gains of the blocks, one list a direction.
    pub blocks: Vec<Vec<BlockChunk>>,
    /// Input of every chunk of blocks, one a torque ripple.
    pub ripple: Vec<Vec<[Lanes; 2]>>,
    /// Window table of every mesh segment.
    window_of_segment: Vec<usize>,
    /// Solution operator of every cell, among those of its window table.
    feedback_of_cell: Vec<usize>,
    /// (cos, sin) of the transmission error's harmonics at the start of every cell.
    pub cell_phases: Vec<f64>,
    /// What loaded flanks lack on every cell \[m\]; empty where they lack nothing anywhere.
    lacks: Vec<Lack>,
}

/// What loaded flanks lack over a window of length `delta` \[s\] that starts at `time` \[s\] in a
/// segment.
fn lack(model: &Model, segment: &Segment, time: f64, delta: f64) -> Lack {
    let place = |time: f64| segment.place(time / model.period());
    let series = segment.error.coefficients();
    transforms8().restrict(series, place(time), place(time + delta))
}

impl VolterraTables {
    /// Tables for a model; see [`super::Volterra::new`] for `tolerance`.
    pub fn new(model: &Model, tolerance: f64, set: InstructionSet) -> Self {
        let (layout, grid) = (Layout::new(model), Grid::new(model, tolerance));
        let mut kinds: Vec<(usize, usize)> = Vec::new();
        let window_of_segment: Vec<_> = (model.cycle.segments.iter())
            .zip(&grid.length_of_segment)
            .map(|(segment, &length)| place(&mut kinds, (length, segment.direction)))
            .collect();
        let mut closures = vec![Vec::new(); kinds.len()];
        let feedback_of_cell = (0..grid.cells())
            .map(|cell| {
                let index = grid.segment_of_cell[cell];
                let segment = &model.cycle.segments[index];
                let closure = Closure::new(model, segment, grid.time[cell], grid.delta(index));
                place(&mut closures[window_of_segment[index]], closure)
            })
            .collect();
        let exponentials: Vec<Vec<_>> = (grid.lengths.iter())
            .map(|&delta| {
                let exponential = |block| BlockExponential::new(block, delta);
                model.blocks.iter().map(exponential).collect()
            })
            .collect();
        let windows = (kinds.iter().zip(&closures))
            .map(|(&(length, direction), closures)| {
                let (delta, exponentials) = (grid.lengths[length], &exponentials[length]);
                WindowTable::new(model, layout, delta, direction, exponentials, closures, set)
            })
            .collect();
        let cell_phases = (grid.time.iter())
            .flat_map(|time| {
                model.transmission_error.iter().flat_map(move |h| {
                    let (sin, cos) = (h.angular_frequency * time).sin_cos();
                    [cos, sin]
                })
            })
            .collect();
        let lacks = match model.cycle.has_error() {
            true => (0..grid.cells())
                .map(|cell| {
                    let index = grid.segment_of_cell[cell];
                    let segment = &model.cycle.segments[index];
                    lack(model, segment, grid.time[cell], grid.delta(index))
                })
                .collect(),
            false => Vec::new(),
        };
        Self {
            lacks,
            layout,
            windows,
            blocks: (model.directions.iter())
                .map(|gains| block_chunks(model, gains))
                .collect(),
            ripple: (model.ripple.iter())
                .map(|ripple| in_chunks(&ripple.input))
                .collect(),
            window_of_segment,
            feedback_of_cell,
            cell_phases,
            grid,
        }
    }

    /// The tables of windows that start in a mesh segment.
    pub fn window(&self, segment: usize) -> &WindowTable {
        &self.windows[self.window_of_segment[segment]]
    }

    /// What loaded flanks lack on the window that starts at a time \[s\] in a segment, the start
    /// of a cell where one is given; none where they lack nothing in the whole cycle.
    #[inline]
    pub fn lack(
        &self,
        model: &Model,
        segment: usize,
        time: f64,
        cell: Option<usize>,
    ) -> Option<Lack> {
        if self.lacks.is_empty() {
            return None;
        }
        Some(match cell {
            Some(cell) => self.lacks[cell],
            None => {
                let delta = self.window(segment).delta;
                lack(model, &model.cycle.segments[segment], time, delta)
            }
        })
    }

    /// The solution operator of the window that is a cell.
    pub fn feedback(&self, cell: usize) -> &Feedback {
        let table = self.window(self.grid.segment_of_cell[cell]);
        &table.feedback[self.feedback_of_cell[cell]]
    }
}

/// Place of a value in a list, appended where it is new.
fn place<T: PartialEq>(known: &mut Vec<T>, value: T) -> usize {
    known.iter().position(|k| *k == value).unwrap_or_else(|| {
        known.push(value);
        known.len() - 1
    })
}

/// Pairs of numbers, one a block, by chunks.
fn in_chunks(pairs: &[[f64; 2]]) -> Vec<[Lanes; 2]> {
    let chunk = |group: &[[f64; 2]]| {
        let mut lanes = [Lanes::ZERO; 2];
        for (l, pair) in group.iter().enumerate() {
            for j in 0..2 {
                lanes[j].0[l] = pair[j];
            }
        }
        lanes
    };
    pairs.chunks(LANES).map(chunk).collect()
}

/// Mesh radians that a block turns in a cycle, below which it drifts: its rest is so far from
/// where it is that the distance would cost digits.
const DRIFT: f64 = 0.1;

/// `−A⁻¹ s`: with `A = μ I + M` and `M² = −ν² I`, `A⁻¹ = (μ I − M) / (μ² + ν²)`.
fn rest(block: &Block) -> [f64; 2] {
    let (mu, m, s) = (block.growth(), block.traceless(), block.static_input);
    let square = block.natural_frequency().powi(2);
    [0, 1].map(|i| (m[i][0] * s[0] + m[i][1] * s[1] - mu * s[i]) / square)
}

fn block_chunks(model: &Model, gains: &[MeshGain]) -> Vec<BlockChunk> {
    let slowest = DRIFT / model.period();
    (model.blocks.chunks(LANES).zip(gains.chunks(LANES)))
        .map(|(group, gains)| {
            let mut chunk = BlockChunk {
                traceless: [Lanes::ZERO; 4],
                deflection: [Lanes::ZERO; 2],
                mesh_pull: [Lanes::ZERO; 2],
                static_input: [Lanes::ZERO; 2],
                rest: [Lanes::ZERO; 2],
                drifts: group.iter().any(|b| b.natural_frequency() < slowest),
            };
            for (l, (block, gain)) in group.iter().zip(gains).enumerate() {
                for (k, value) in block.traceless().as_flattened().iter().enumerate() {
                    chunk.traceless[k].0[l] = *value;
                }
                for j in 0..2 {
                    chunk.deflection[j].0[l] = gain.deflection[j];
                    chunk.mesh_pull[j].0[l] = -gain.mesh_input[j];
                    match chunk.drifts {
                        true => chunk.static_input[j].0[l] = block.static_input[j],
                        false => chunk.rest[j].0[l] = rest(block)[j],
                    }
                }
            }
            chunk
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn at_rest_nothing_moves() {
        let block = Block {
            static_input: [0.3, -2.0],
            ..Block::mode(7.0, 0.2, 0.0)
        };
        let (r, m) = (rest(&block), block.traceless());
        for i in 0..2 {
            let rate = block.growth() * r[i] + m[i][0] * r[0] + m[i][1] * r[1];
            assert!((rate + block.static_input[i]).abs() < 1e-15);
        }
    }
}
