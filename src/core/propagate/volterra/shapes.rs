//! In what shapes do the numbers of tables and windows lie?

use crate::model::{Model, STIFFNESS_TERMS};
pub use crate::propagate::vectors::{LANES, Lanes, Row, Series, TERMS, interpolation};

/// What a chunk of blocks is made of.
#[derive(Debug, Clone, Copy)]
pub struct BlockChunk {
    /// Traceless part M, row by row.
    pub traceless: [Lanes; 4],
    /// Gain w of the deflection.
    pub deflection: [Lanes; 2],
    /// Gain −g of the mesh force.
    pub mesh_pull: [Lanes; 2],
    /// Constant input of the mean torques, where the blocks drift.
    pub static_input: [Lanes; 2],
    /// Where the mean torques alone hold the blocks, `−A⁻¹ s`; zero where they drift.
    pub rest: [Lanes; 2],
    /// Whether some of the blocks have no rest, or one too far away.
    pub drifts: bool,
}

/// Gap error of loaded flanks over a window \[m\]: the first terms of its series, all others being
/// zero.
pub type GapError = [f64; STIFFNESS_TERMS];

/// Sizes that all tables of a model share.
#[derive(Debug, Clone, Copy)]
pub struct Layout {
    /// Blocks rounded up to whole chunks.
    pub padded: usize,
    /// Inputs that act on the blocks, the first of all inputs: the constant 1 and (cos, sin)
    /// of every ripple.
    pub acting: usize,
    /// All inputs: those that act, then (cos, sin) of every frequency of the transmission
    /// errors; rounded up to a multiple of 4.
    pub inputs: usize,
}

impl Layout {
    /// Those of the tables of a model with so many frequencies of transmission errors.
    pub fn new(model: &Model, frequencies: usize) -> Self {
        let acting = 1 + 2 * model.ripple.len();
        Self {
            padded: model.modes().next_multiple_of(LANES),
            acting,
            inputs: (acting + 2 * frequencies).next_multiple_of(4),
        }
    }
}
