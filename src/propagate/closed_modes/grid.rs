//! How far apart are the nodes at which deflections are looked at?

use super::bases::Bases;
use super::excitation::Frequencies;
use super::lanes::SHORT;
use super::sets::Sets;
use crate::model::Model;
use crate::propagate::vectors::LANES;

/// Nodes of a block, the last at its end: one a lane.
pub const NODES: usize = LANES;

/// Fewest blocks a mesh cycle: the certificate of a longer one would seldom hold.
const FEWEST: f64 = 3.0;

/// Distance of nodes \[s\] at which the fastest wave of any system turns little, a whole number of blocks a mesh cycle; and
/// that number.
pub fn step(
    model: &Model,
    sets: &Sets,
    bases: &Bases<'_>,
    frequencies: &Frequencies,
) -> (f64, f64) {
    let mut fastest = frequencies
        .all
        .iter()
        .fold(0.0_f64, |most, f| most.max(f[0]));
    for set in 0..sets.count() {
        let basis = bases.of(set);
        for i in 0..model.modes() {
            let block = basis.block(i);
            let turns = block.damped_frequency().or(block.spread()).unwrap_or(0.0);
            fastest = fastest.max(block.growth().abs() + turns);
        }
    }
    let blocks = (model.period() * fastest / (2.0 * SHORT * NODES as f64))
        .ceil()
        .max(FEWEST);
    (model.period() / (blocks * NODES as f64), blocks)
}
