//! One mode as a real 2 × 2 block, and its gains for contacts.

use crate::numerics::exponential::{self, RIGID_PHASE};
use num_complex::{Complex64, c64};

/// A block drifts if it turns by less than this angle \[rad\] in a mesh cycle. Its rest position is so far
/// away that the difference from it would lose digits.
pub const DRIFT: f64 = 0.1;

/// A real 2 × 2 block `x' = A x − g F + s`, which contributes `w·x` to the deflection of a contact with the
/// force F; w and g are its [`MeshGain`].
///
/// If modes are coupled, the blocks are those of [`super::Basis`]. A mode with modal damping is the companion
/// block `A = [0 1; −ω² −2ζω]`, `x = (q, q')`, `g = (0, gᵢ)`, `w = (wᵢ, 0)`. Kernels use the block form only.
/// They therefore also accept blocks from non-proportional damping or gyroscopic terms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block {
    /// Generator A \[1/s\], row by row.
    pub generator: [[f64; 2]; 2],
    /// Constant input s of the mean torques.
    pub static_input: [f64; 2],
}

impl Block {
    /// The companion block of a mode with natural frequency ω \[rad/s\] and damping ratio ζ.
    pub fn mode(frequency: f64, damping: f64, load: f64) -> Self {
        Self {
            generator: [
                [0.0, 1.0],
                [-frequency * frequency, -2.0 * damping * frequency],
            ],
            static_input: [0.0, load],
        }
    }

    /// Half the trace of A: minus the decay rate \[1/s\].
    pub fn growth(&self) -> f64 {
        0.5 * (self.generator[0][0] + self.generator[1][1])
    }

    /// Damped frequency ν ≥ 0 \[rad/s\] with `(A − growth I)² = −ν² I`; `None` if the
    /// block is overdamped (real, distinct eigenvalues).
    pub fn damped_frequency(&self) -> Option<f64> {
        let [a, b] = self.generator;
        let half = 0.5 * (a[0] - b[1]);
        let square = -(half * half + a[1] * b[0]);
        (square >= 0.0).then(|| square.sqrt())
    }

    /// Rate σ > 0 \[1/s\] with `(A − growth I)² = σ² I` of an overdamped block, whose eigenvalues are `growth
    /// ± σ`; `None` for other blocks.
    pub fn spread(&self) -> Option<f64> {
        let m = self.traceless();
        let square = m[0][0] * m[0][0] + m[0][1] * m[1][0];
        (square > 0.0).then(|| square.sqrt())
    }

    /// The largest modulus of an eigenvalue \[1/s\].
    pub fn fastest(&self) -> f64 {
        match self.spread() {
            Some(spread) => self.growth().abs() + spread,
            None => self.natural_frequency(),
        }
    }

    /// Writes the Legendre coefficients of C and S on \[0, τ\] to `out`, as real and imaginary parts. Here
    /// `exp(A t) = C(t) I + S(t) M` with the traceless part M. Returns C(τ) and S(τ).
    pub fn exponential(&self, tau: f64, out: &mut [Complex64]) -> [f64; 2] {
        if let Some(spread) = self.spread() {
            return exponential::real_pair_series(self.growth(), spread, tau, out);
        }
        let rate = self.oscillation(tau);
        let end = exponential::legendre_series(rate, tau, out);
        by_frequency(rate.im, end, out)
    }

    /// As [`Self::exponential`], for many blocks: one series and one pair of values per block.
    pub fn exponentials<const N: usize>(
        blocks: &[Self],
        tau: f64,
        out: &mut [[Complex64; N]],
    ) -> Vec<[f64; 2]> {
        let mut ends = Vec::with_capacity(blocks.len());
        for (group, out) in blocks.chunks(TOGETHER).zip(out.chunks_mut(TOGETHER)) {
            let oscillate = group.iter().all(|block| block.spread().is_none());
            match <&mut [_; TOGETHER]>::try_from(&mut *out) {
                Ok(all) if oscillate => {
                    let rates = std::array::from_fn(|l| group[l].oscillation(tau));
                    let series = all.each_mut().map(|series| &mut series[..]);
                    let values = exponential::legendre_series_of::<TOGETHER>(rates, tau, series);
                    let each = rates.iter().zip(values).zip(all);
                    ends.extend(
                        each.map(|((rate, end), series)| by_frequency(rate.im, end, series)),
                    );
                }
                _ => ends.extend(
                    (group.iter().zip(out)).map(|(block, out)| block.exponential(tau, out)),
                ),
            }
        }
        ends
    }

    /// Eigenvalue `growth + iν` of a block that is not overdamped. A rigid rotation gets a very small ν
    /// instead of 0.
    fn oscillation(&self, tau: f64) -> Complex64 {
        let nu = self.damped_frequency().unwrap_or(0.0);
        c64(self.growth(), nu.max(RIGID_PHASE / tau))
    }

    /// The traceless part `M = A − growth I`, so that
    /// `exp(A t) = e^{growth t} (cos νt I + sin νt / ν M)`.
    pub fn traceless(&self) -> [[f64; 2]; 2] {
        let mu = self.growth();
        let [a, b] = self.generator;
        [[a[0] - mu, a[1]], [b[0], b[1] - mu]]
    }

    /// Undamped frequency `√det A` \[rad/s\].
    pub fn natural_frequency(&self) -> f64 {
        let [a, b] = self.generator;
        (a[0] * b[1] - a[1] * b[0]).max(0.0).sqrt()
    }
}

/// Gains between a contact and a block while the line of action and the direction of friction are constant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshGain {
    /// Gain w of the deflection.
    pub deflection: [f64; 2],
    /// Gain of the deflection rate, `w A`.
    pub rate: [f64; 2],
    /// Gain g of the contact force; `−g F` is the input of the block.
    pub mesh_input: [f64; 2],
}

impl MeshGain {
    /// The gain of a block with deflection gain w and force gain g.
    pub fn new(block: &Block, deflection: [f64; 2], mesh_input: [f64; 2]) -> Self {
        let [a, b] = block.generator;
        let [w1, w2] = deflection;
        Self {
            deflection,
            rate: [w1 * a[0] + w2 * b[0], w1 * a[1] + w2 * b[1]],
            mesh_input,
        }
    }

    /// The gain of a companion block, from the participations in deflection and force.
    pub fn mode(block: &Block, deflection: f64, force: f64) -> Self {
        Self::new(block, [deflection, 0.0], [0.0, force])
    }
}

/// Number of blocks whose exponentials are computed at once.
const TOGETHER: usize = 8;

/// Divides the imaginary parts of a series and of its end by ν.
fn by_frequency(nu: f64, end: Complex64, series: &mut [Complex64]) -> [f64; 2] {
    for term in series {
        term.im /= nu;
    }
    [end.re, end.im / nu]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mode_has_the_damped_frequency_of_the_textbook() {
        let block = Block::mode(10.0, 0.3, 0.0);
        assert!((block.growth() + 3.0).abs() < 1e-15);
        let nu = block.damped_frequency().unwrap();
        assert!((nu - 10.0 * (1.0f64 - 0.09).sqrt()).abs() < 1e-14);
        let m = block.traceless();
        let square = m[0][0] * m[0][0] + m[0][1] * m[1][0];
        assert!((square + nu * nu).abs() < 1e-12);
        assert_eq!(MeshGain::mode(&block, 1.0, 1.0).rate, [0.0, 1.0]);
    }

    /// Nineteen blocks: groups with and without a block that cannot oscillate, and a part of a group.
    #[test]
    fn many_exponentials_are_those_of_each_block() {
        let mut blocks: Vec<Block> = (0..19)
            .map(|i| Block::mode(f64::from(i), 0.05, 0.0))
            .collect();
        blocks[10] = Block::mode(2.0, 1.5, 0.0);
        let mut series = [[Complex64::ZERO; 24]; 19];
        let ends = Block::exponentials(&blocks, 0.4, &mut series);
        for (i, block) in blocks.iter().enumerate() {
            let mut alone = [Complex64::ZERO; 24];
            assert_eq!(block.exponential(0.4, &mut alone), ends[i], "{i}");
            assert_eq!(alone, series[i], "{i}");
        }
        assert_eq!(ends.len(), 19);
    }

    #[test]
    fn rigid_rotation_has_frequency_zero_and_overdamped_has_none() {
        assert_eq!(Block::mode(0.0, 0.0, 0.0).damped_frequency(), Some(0.0));
        assert_eq!(Block::mode(1.0, 1.5, 0.0).damped_frequency(), None);
    }
}
