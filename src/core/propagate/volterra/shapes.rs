//! Data layouts of tables and windows.

use crate::model::{Model, STIFFNESS_TERMS};
pub use crate::propagate::vectors::{LANES, Lanes, Row, Series, TERMS, interpolation};

/// Constants of a chunk: [`LANES`] blocks (modal oscillators) that vector instructions treat together.
#[derive(Debug, Clone, Copy)]
pub struct BlockChunk {
    /// Traceless part M of the matrix of each block \[1/s\] ([`crate::model::Block::traceless`]), row by row.
    pub traceless: [Lanes; 4],
    /// Gain w of the deflection.
    pub deflection: [Lanes; 2],
    /// Gain −g of the mesh force.
    pub mesh_pull: [Lanes; 2],
    /// Constant input of the mean torques if the blocks drift.
    pub static_input: [Lanes; 2],
    /// Rest position of the blocks under the mean torques alone, `−A⁻¹ s`; zero if they drift.
    pub rest: [Lanes; 2],
    /// Whether some of the blocks have no rest position, or one too far away.
    pub drifts: bool,
}

/// Gap error of loaded flanks over a window \[m\]: the first terms of its series. All others are zero.
pub type GapError = [f64; STIFFNESS_TERMS];

/// Sizes that all tables of a model share.
#[derive(Debug, Clone, Copy)]
pub struct TableLayout {
    /// Blocks rounded up to whole chunks.
    pub padded: usize,
    /// Inputs that act on the blocks, which come first: the constant 1 and (cos, sin) of every ripple.
    pub acting: usize,
    /// All inputs: the acting ones, then (cos, sin) of every frequency of the transmission errors; rounded up to a
    /// multiple of 4.
    pub inputs: usize,
}

impl TableLayout {
    /// The layout for a model with this number of frequencies of transmission errors.
    pub fn new(model: &Model, frequencies: usize) -> Self {
        let acting = 1 + 2 * model.ripple.len();
        Self {
            padded: model.modes().next_multiple_of(LANES),
            acting,
            inputs: (acting + 2 * frequencies).next_multiple_of(4),
        }
    }
}
