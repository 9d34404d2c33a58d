//! How do the blocks move on a window, and what do they contribute to a deflection?

use super::shapes::TERMS;
use crate::model::{Block, MeshGain};
use crate::numerics::convolution::significant;
use multiversion::multiversion;
use num_complex::Complex64;

/// Number of terms of the series of response kernels, as in the convolution table.
const KERNEL_TERMS: usize = 32;

/// Legendre series of one block's `e^{At}` on a window.
pub struct BlockExponential {
    pub cosine: [f64; KERNEL_TERMS],
    pub sine: [f64; KERNEL_TERMS],
    end: [f64; 2],
    pub traceless: [[f64; 2]; 2],
}

impl BlockExponential {
    /// The series of all blocks on a window of length `delta` \[s\].
    pub fn all(blocks: &[Block], delta: f64) -> Vec<Self> {
        let mut series = vec![[Complex64::ZERO; KERNEL_TERMS]; blocks.len()];
        let ends = Block::exponentials(blocks, delta, &mut series);
        (blocks.iter().zip(series).zip(ends))
            .map(|((block, series), end)| Self {
                cosine: series.map(|c| c.re),
                sine: series.map(|c| c.im),
                end,
                traceless: block.traceless(),
            })
            .collect()
    }

    /// Number of significant terms, an even number; the others are below round-off.
    pub fn terms(&self) -> usize {
        let terms = significant(&self.cosine).max(significant(&self.sine));
        terms.clamp(1, TERMS).next_multiple_of(2)
    }

    /// Coefficient n of `e^{At} u`.
    pub fn response(&self, n: usize, u: [f64; 2]) -> [f64; 2] {
        let turned = apply(&self.traceless, u);
        [0, 1].map(|row| self.cosine[n] * u[row] + self.sine[n] * turned[row])
    }

    /// `e^{AΔ}`.
    pub fn end(&self) -> [[f64; 2]; 2] {
        let ([cosine, sine], m) = (self.end, &self.traceless);
        [
            [cosine + sine * m[0][0], sine * m[0][1]],
            [sine * m[1][0], cosine + sine * m[1][1]],
        ]
    }
}

fn apply(m: &[[f64; 2]; 2], v: [f64; 2]) -> [f64; 2] {
    m.map(|row| dot(row, v))
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Series of the responses of δ and δ' to an impulse of an input.
#[derive(Debug, Default)]
pub struct Kernels {
    pub deflection: [f64; KERNEL_TERMS],
    pub rate: [f64; KERNEL_TERMS],
}

impl Kernels {
    #[inline(always)]
    pub fn add(&mut self, gain: &MeshGain, exponential: &BlockExponential, input: [f64; 2]) {
        let turned = apply(&exponential.traceless, input);
        for (sums, w) in [
            (&mut self.deflection, gain.deflection),
            (&mut self.rate, gain.rate),
        ] {
            let (even, odd) = (dot(w, input), dot(w, turned));
            let terms = exponential.cosine.iter().zip(&exponential.sine);
            for (sum, (cosine, sine)) in sums.iter_mut().zip(terms) {
                *sum += cosine * even + sine * odd;
            }
        }
    }
}

/// Responses of the deflection with the gains `seen` to an impulse of the force with the gains `force`.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx2", "x86_64+avx2"))]
pub fn impulse(
    seen: &[MeshGain],
    force: &[MeshGain],
    exponentials: &[BlockExponential],
) -> Kernels {
    let mut kernels = Kernels::default();
    for ((seen, own), exponential) in seen.iter().zip(force).zip(exponentials) {
        kernels.add(seen, exponential, own.mesh_input);
    }
    kernels
}
