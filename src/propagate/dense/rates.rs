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

/// The relative rotation on the closed mesh, whose rate is known but roughly, counts as slow from
/// below so many times the limit.
const ROUGHLY: f64 = 2.0;

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
    /// times longer than its fastest motion, or where a mode is so slow that whether it is a wave
    /// depends on the speed: a wave far below [`SLOW`] a mesh period would lose accuracy, a slow
    /// coordinate far above it leaves the reach of its polynomial.
    pub fn new(model: &Model) -> Self {
        let fastest = Volterra::fastest_own_rate(model);
        let limit = SLOW / model.period();
        let mut slow = SLOWEST * fastest;
        while slow > limit {
            slow /= SLOWER;
        }
        let between = |rate: f64, limit: f64| (slow..limit).contains(&rate);
        let modes = model.blocks.iter().flat_map(eigenvalues);
        if modes.into_iter().any(|rate| between(rate, limit))
            || between(rotation_on_mesh(model, slow), ROUGHLY * limit)
        {
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

/// Natural frequency \[rad/s\] of the rotations, modes slower than `slow`, on the softest contact
/// that is closed, as if all else were rigid: the least that the mesh makes of a slow mode.
fn rotation_on_mesh(model: &Model, slow: f64) -> f64 {
    let segments = (model.contacts.iter())
        .flat_map(|contact| &contact.cycles)
        .flat_map(|cycle| &cycle.segments);
    let softest = segments
        .map(|segment| segment.stiffness.mean())
        .filter(|&stiffness| stiffness > 0.0)
        .fold(f64::INFINITY, f64::min);
    let own = model.blocks.iter().zip(model.first_gains());
    let mobility: f64 = own
        .filter(|(block, _)| eigenvalues(block)[1] < slow)
        .map(|(_, gain)| {
            let ([w, _], [_, g]) = (gain.deflection, gain.mesh_input);
            w * g
        })
        .sum();
    match softest.is_finite() {
        true => (softest * mobility.max(0.0)).sqrt(),
        false => 0.0,
    }
}
