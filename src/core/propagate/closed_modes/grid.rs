//! How far apart are the nodes at which deflections are looked at?

use super::bases::Bases;
use super::excitation::Frequencies;
use super::lanes::SHORT;
use crate::model::Model;
use crate::propagate::vectors::LANES;

/// Nodes of a block, the last at its end: one a lane.
pub const NODES: usize = LANES;

/// Fewest blocks a mesh cycle: the certificate of a longer one would seldom hold.
const FEWEST: f64 = 3.0;

/// Distance of nodes \[s\] at which the fastest wave of any system turns little, a whole number of blocks a mesh cycle; and
/// that number.
pub fn step(model: &Model, bases: &Bases<'_>, frequencies: &Frequencies) -> (f64, f64) {
    let driven = frequencies.all.iter().map(|frequency| frequency[0]);
    let fastest = driven.fold(bases.fastest(), f64::max);
    let blocks = (model.period() * fastest / (2.0 * SHORT * NODES as f64))
        .ceil()
        .max(FEWEST);
    (model.period() / (blocks * NODES as f64), blocks)
}
