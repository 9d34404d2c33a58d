//! How long is a window?

use super::shapes::TERMS;
use crate::model::{Block, MeshCycle, MeshGain, Model};
use crate::numerics::exponential::LARGEST_HALF_ARGUMENT;

/// Windows a mesh cycle, not rounded, that are just short enough for the tolerance.
pub fn fewest_windows(model: &Model, tolerance: f64) -> f64 {
    0.5 * fastest_rate(model) * model.period() / largest_half_argument(tolerance)
}

/// Upper bound of the rates \[1/s\] in any contact state and of the excitation.
pub fn fastest_rate(model: &Model) -> f64 {
    let excitation = model
        .transmission_errors()
        .map(|h| h.angular_frequency)
        .chain(model.ripple.iter().map(|r| r.angular_frequency));
    excitation.fold(fastest_own_rate(model), f64::max)
}

/// Upper bound of the rates \[1/s\] of structure and mesh in any contact state, excitation left
/// out: with the spring closed an eigenvalue moves by at most the norm of what is added.
pub fn fastest_own_rate(model: &Model) -> f64 {
    let frequencies = model.blocks.iter().map(Block::fastest);
    let open = frequencies.fold(0.0, f64::max);
    let (mut stiffening, mut damping) = (0.0_f64, 0.0_f64);
    for direction in &model.directions {
        let felt = |row: fn(&MeshGain) -> [f64; 2]| -> f64 {
            (direction.gains.iter())
                .map(|gain| {
                    let ([r1, r2], [g1, g2]) = (row(gain), gain.mesh_input);
                    (r1 * g1 + r2 * g2).abs()
                })
                .sum()
        };
        let by_rate = felt(|gain| gain.rate);
        stiffening = stiffening.max(by_rate);
        damping = damping.max(by_rate + felt(|gain| gain.deflection));
    }
    let cycles = || model.contacts.iter().flat_map(|contact| &contact.cycles);
    let k = cycles()
        .map(MeshCycle::largest_stiffness)
        .fold(0.0, f64::max);
    let segments = cycles().flat_map(|cycle| &cycle.segments);
    let c = segments.map(|s| s.damping).fold(0.0, f64::max);
    (open * open + k * stiffening).sqrt() + c * damping
}

/// Tolerances below mean this one: windows some hundred times shorter than round-off asks
/// for.
const SMALLEST_TOLERANCE: f64 = 1e-64;

/// The half argument κ at which the first coefficient left out, about
/// `(2P+1) κ^P / (2P+1)!!`, reaches the tolerance.
fn largest_half_argument(tolerance: f64) -> f64 {
    let tolerance = tolerance.max(SMALLEST_TOLERANCE);
    let double_factorial: f64 = (1..=TERMS).map(|n| (2 * n + 1) as f64).product();
    let power = tolerance * double_factorial / (2 * TERMS + 1) as f64;
    power.powf(1.0 / TERMS as f64).min(LARGEST_HALF_ARGUMENT)
}
