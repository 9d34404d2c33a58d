//! How far apart are the nodes at which deflections are computed?

use super::bases::Bases;
use super::excitation::Frequencies;
use super::lanes::SHORT;
use crate::model::Model;
use crate::propagate::vectors::LANES;

/// Nodes of a block, one per lane; the last is at the end of the block.
pub const NODES: usize = LANES;

/// Smallest number of blocks per mesh cycle: longer blocks could seldom be proved free of events.
const FEWEST_BLOCKS: f64 = 3.0;

/// Distance between nodes \[s\] and blocks per mesh cycle, a whole number. The fastest wave of any system turns little
/// between two nodes.
pub fn step(model: &Model, bases: &Bases<'_>, frequencies: &Frequencies) -> (f64, f64) {
    let driven = frequencies.all.iter().map(|frequency| frequency[0]);
    let fastest = driven.fold(bases.fastest(), f64::max);
    let blocks = (model.period() * fastest / (2.0 * SHORT * NODES as f64))
        .ceil()
        .max(FEWEST_BLOCKS);
    (model.period() / (blocks * NODES as f64), blocks)
}
