//! What is slow among the motions of a structure and its mesh.

use crate::model::{Block, Model};
use crate::propagate::Volterra;

/// Eigenvalues below this over a mesh period are slow: splitting the constant input off a wave
/// of rate λ loses a factor (λT)⁻² of accuracy.
pub const SLOW: f64 = 0.5;

/// What is slow where nothing is nearly so, in units of the fastest rate: [`SLOW`] over mesh
/// periods of 2048 of its units, longer than drives have in practice ...
const SLOWEST: f64 = SLOW / 2048.0;

/// ... and so many times slower wherever a period is longer still.
const SLOWER: f64 = 64.0;

/// Waves so many times slower than [`SLOW`] a mesh period are borne: excitation is not split off them.
const BORNE: f64 = 8.0;

/// Rates that a basis is formed by, of a structure and its mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rates {
    /// Upper bound of all \[rad/s\].
    pub fastest: f64,
    /// Below this an eigenvalue is slow \[rad/s\].
    pub slow: f64,
}

impl Rates {
    /// The rates of a model. They depend on its speed only where one mesh cycle is thousands of
    /// times longer than its fastest motion, or where a mode is so slow that as a wave it would lose
    /// accuracy.
    pub fn new(model: &Model) -> Self {
        let fastest = Volterra::fastest_own_rate(model);
        let limit = SLOW / model.period();
        let mut slow = SLOWEST * fastest;
        while slow > limit {
            slow /= SLOWER;
        }
        let mut modes = model.blocks.iter().flat_map(eigenvalues);
        if modes.any(|rate| (slow..limit / BORNE).contains(&rate)) {
            slow = limit;
        }
        Self { fastest, slow }
    }
}

/// Sizes of the eigenvalues of a block \[rad/s\].
fn eigenvalues(block: &Block) -> [f64; 2] {
    match block.spread() {
        Some(spread) => [-1.0, 1.0].map(|sign| (block.growth() + sign * spread).abs()),
        None => [block.natural_frequency(); 2],
    }
}
