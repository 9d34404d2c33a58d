//! How do states and deflections respond to an impulse of a force?

use crate::model::{Block, Direction};
use num_complex::Complex64;

/// Terms of the Legendre series of a block's exponential on a window, and of the response to an impulse.
pub(super) const IMPULSE_RESPONSE_TERMS: usize = 32;

/// Adds `kick g` to a state of `n` blocks.
pub(super) fn push(direction: &Direction, kick: f64, n: usize, state: &mut [f64]) {
    for (i, gain) in direction.gains.iter().enumerate() {
        state[i] += kick * gain.mesh_input[0];
        state[n + i] += kick * gain.mesh_input[1];
    }
}

/// Response of the deflection along the first direction to an impulse of the force along the second one, as a series.
/// `exponentials` has the series of every block's exponential.
pub(super) fn impulse_response(
    blocks: &[Block],
    [observed, pushed]: [&Direction; 2],
    exponentials: &[[Complex64; IMPULSE_RESPONSE_TERMS]],
) -> [f64; IMPULSE_RESPONSE_TERMS] {
    let mut out = [0.0; IMPULSE_RESPONSE_TERMS];
    let gains = observed.gains.iter().zip(&pushed.gains);
    for ((block, exponential), (observed, pushed)) in blocks.iter().zip(exponentials).zip(gains) {
        let (w, g, m) = (observed.deflection, pushed.mesh_input, block.traceless());
        let cosine = w[0] * g[0] + w[1] * g[1];
        let sine =
            w[0] * (m[0][0] * g[0] + m[0][1] * g[1]) + w[1] * (m[1][0] * g[0] + m[1][1] * g[1]);
        for (value, e) in out.iter_mut().zip(exponential) {
            *value += e.re * cosine + e.im * sine;
        }
    }
    out
}
