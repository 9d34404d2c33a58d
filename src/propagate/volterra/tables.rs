//! Everything a kernel computes once for an operating point.

use super::TERMS;
use super::feedback::Feedback;
use super::grid::Grid;
use super::lanes::{LANES, Lanes};
use super::window_table::WindowTable;
use crate::model::Model;

/// A series on a window.
pub type Series = [f64; TERMS];

/// A series of a table, on cache lines of its own.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub struct Row(pub Series);

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

/// Sizes that all tables of a model share.
#[derive(Debug, Clone, Copy)]
pub struct Layout {
    /// Blocks rounded up to whole chunks.
    pub padded: usize,
    /// Inputs that act on the blocks, the first of all inputs: the constant 1 and (cos, sin)
    /// of every ripple.
    pub acting: usize,
    /// All inputs: those that act, then (cos, sin) of every harmonic of the transmission
    /// error; rounded up to a multiple of 4.
    pub inputs: usize,
}

impl Layout {
    fn new(model: &Model) -> Self {
        let acting = 1 + 2 * model.ripple.len();
        Self {
            padded: model.modes().next_multiple_of(LANES),
            acting,
            inputs: (acting + 2 * model.transmission_error.len()).next_multiple_of(4),
        }
    }
}

/// Tables of the structured kernel.
#[derive(Debug)]
pub struct Tables {
    /// Sizes.
    pub layout: Layout,
    /// Where windows start.
    pub grid: Grid,
    /// One table a length of window in the grid.
    pub windows: Vec<WindowTable>,
    /// Gains of the blocks.
    pub blocks: Vec<BlockChunk>,
    /// Input of every chunk of blocks, one a torque ripple.
    pub ripple: Vec<Vec<[Lanes; 2]>>,
    /// Solution operator of every mesh segment, among those of its window table.
    feedback_of_segment: Vec<usize>,
    /// (cos, sin) of the transmission error's harmonics at the start of every cell.
    pub cell_phases: Vec<f64>,
}

impl Tables {
    /// Tables for a model; see [`super::Volterra::new`] for `tolerance`.
    pub fn new(model: &Model, tolerance: f64) -> Self {
        let (layout, grid) = (Layout::new(model), Grid::new(model, tolerance));
        let mut pairs = vec![Vec::new(); grid.lengths.len()];
        let feedback_of_segment = (model.cycle.segments.iter())
            .zip(&grid.length_of_segment)
            .map(|(segment, &length)| {
                let pair = (segment.stiffness, segment.damping);
                let known = pairs[length].iter().position(|p| *p == pair);
                known.unwrap_or_else(|| {
                    pairs[length].push(pair);
                    pairs[length].len() - 1
                })
            })
            .collect();
        let windows = (grid.lengths.iter().zip(&pairs))
            .map(|(&delta, pairs)| WindowTable::new(model, layout, delta, pairs))
            .collect();
        let cell_phases = (grid.time.iter())
            .flat_map(|time| {
                model.transmission_error.iter().flat_map(move |h| {
                    let (sin, cos) = (h.angular_frequency * time).sin_cos();
                    [cos, sin]
                })
            })
            .collect();
        Self {
            layout,
            windows,
            blocks: block_chunks(model),
            ripple: (model.ripple.iter())
                .map(|ripple| in_chunks(&ripple.input))
                .collect(),
            feedback_of_segment,
            cell_phases,
            grid,
        }
    }

    /// The tables of windows that start in a mesh segment.
    pub fn window(&self, segment: usize) -> &WindowTable {
        &self.windows[self.grid.length_of_segment[segment]]
    }

    /// The solution operator of a mesh segment.
    pub fn feedback(&self, segment: usize) -> &Feedback {
        &self.window(segment).feedback[self.feedback_of_segment[segment]]
    }
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
