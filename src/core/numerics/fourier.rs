//! Fourier integrals of a Legendre series on a window, at the multiples of one frequency.
//!
//! With `κ = ω τ/2` and θ the phase `ω t` at the middle of the window,
//!
//! ```text
//! ∫ Σ a_n P_n e^{−imωt} dt = τ e^{−imθ} Σ (−i)ⁿ a_n j_n(m κ)       (A&S 10.1.14)
//! ```
//!
//! The work per multiple is independent of its frequency.

use super::bessel::{LANES, Lanes, ORDERS, spherical_bessel};
use num_complex::{Complex64, c64};
use std::f64::consts::TAU;

/// Number of groups of sixteen multiples after which sines and cosines are computed directly again, because
/// the errors of the multiplications accumulate.
const MOST_TURNED: usize = 8;

/// Length of a window, and phases of the lowest frequency on it.
#[derive(Debug, Clone, Copy)]
pub struct ScaledWindow {
    /// Length τ \[s\].
    pub duration: f64,
    /// κ, half the phase change over the window, at most π \[rad\].
    pub half_turn: f64,
    /// θ, the phase at its middle \[rad\].
    pub phase: f64,
}

/// Adds to every `sums[s][m − 1]` the integral of `series[s]` at m times the lowest frequency. The result is
/// the same with every instruction set, because no operations are fused.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
pub fn add_lines(stretch: ScaledWindow, series: &[[f64; ORDERS]], sums: &mut [Vec<Complex64>]) {
    let count = sums.iter().map(Vec::len).max().unwrap_or(0);
    let mut halves = AngleMultiples::new(stretch.half_turn);
    let mut places = AngleMultiples::new(stretch.phase);
    let mut bessel = [[0.0; LANES]; ORDERS];
    for first in (0..count).step_by(LANES) {
        let mut x = [0.0; LANES];
        for (i, x) in x.iter_mut().enumerate() {
            *x = stretch.half_turn * (first + i + 1) as f64;
        }
        let [cos, sin] = halves.next();
        spherical_bessel(&x, &sin, &cos, &mut bessel);
        let [cos, sin] = places.next();
        for (a, sums) in series.iter().zip(&mut *sums) {
            let [re, im] = about_the_middle(a, &bessel);
            for (i, sum) in sums.iter_mut().skip(first).take(LANES).enumerate() {
                sum.re += stretch.duration * (re[i] * cos[i] + im[i] * sin[i]);
                sum.im += stretch.duration * (im[i] * cos[i] - re[i] * sin[i]);
            }
        }
    }
}

/// `Σ (−i)ⁿ a_n j_n`, real and imaginary parts.
#[inline(always)]
fn about_the_middle(a: &[f64; ORDERS], bessel: &[Lanes; ORDERS]) -> [Lanes; 2] {
    let (mut re, mut im) = ([0.0; LANES], [0.0; LANES]);
    for n in (0..ORDERS).step_by(4) {
        for i in 0..LANES {
            re[i] += a[n] * bessel[n][i] - a[n + 2] * bessel[n + 2][i];
            im[i] += a[n + 3] * bessel[n + 3][i] - a[n + 1] * bessel[n + 1][i];
        }
    }
    [re, im]
}

/// Cosines and sines of the multiples of an angle, in groups of sixteen.
struct AngleMultiples {
    angle: f64,
    /// Cosines and sines of the multiples 1 … 16.
    low: [Lanes; 2],
    /// Number of groups already returned.
    given: usize,
    now: [Lanes; 2],
}

impl AngleMultiples {
    #[inline(always)]
    fn new(angle: f64) -> Self {
        let mut low = [[0.0; LANES]; 2];
        for i in 0..LANES {
            (low[1][i], low[0][i]) = (angle * (i + 1) as f64).sin_cos();
        }
        Self {
            angle,
            low,
            given: 0,
            now: low,
        }
    }

    #[inline(always)]
    fn next(&mut self) -> [Lanes; 2] {
        if self.given > 0 {
            let ([re, im], turn) = match self.given % MOST_TURNED {
                0 => {
                    let angle = self.angle * (self.given * LANES) as f64;
                    (self.low, Complex64::cis(angle))
                }
                _ => (
                    self.now,
                    c64(self.low[0][LANES - 1], self.low[1][LANES - 1]),
                ),
            };
            for i in 0..LANES {
                self.now[0][i] = re[i] * turn.re - im[i] * turn.im;
                self.now[1][i] = re[i] * turn.im + im[i] * turn.re;
            }
        }
        self.given += 1;
        self.now
    }
}

/// The weights of Hann's window at `places` positions. Their mean is ½.
pub fn hann(places: usize) -> Vec<f64> {
    let weight = |i: usize| 0.5 - 0.5 * (TAU * i as f64 / places as f64).cos();
    (0..places).map(weight).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::legendre::evaluate;
    use crate::numerics::quadrature::GaussLegendre;

    /// Multiples up to a thousand, for phase changes over the window from nearly zero to a whole cycle. They
    /// are compared with a Gauss rule that has enough nodes for the highest frequency.
    #[test]
    fn all_multiples_agree_with_quadrature() {
        let series: [[f64; ORDERS]; 2] = [0.5_f64, 0.9]
            .map(|ratio| std::array::from_fn(|n| ratio.powi(n as i32) * (1.3 * n as f64).cos()));
        for half_turn in [1e-6, 4e-3, 0.05, 0.4, 1.1, std::f64::consts::PI] {
            let stretch = ScaledWindow {
                duration: 0.7,
                half_turn,
                phase: 2.0 + half_turn,
            };
            let starts = [(c64(1.0, 2.0), 1000), (Complex64::ZERO, 1001)];
            let mut sums = starts.map(|(start, count)| vec![start; count]);
            add_lines(stretch, &series, &mut sums);
            for m in (1..=1000).step_by(173).chain([2, 3, 8, 9, 128, 129, 1000]) {
                let rule = GaussLegendre::new(60 + (m as f64 * half_turn) as usize);
                for (s, (series, (mut exact, _))) in series.iter().zip(starts).enumerate() {
                    for (x, w) in rule.nodes.iter().zip(&rule.weights) {
                        let turn = m as f64 * (stretch.phase + half_turn * x);
                        let value = 0.5 * stretch.duration * w * evaluate(series, *x);
                        exact += value * Complex64::cis(-turn);
                    }
                    let error = (sums[s][m - 1] - exact).norm();
                    // The uncertainty of a phase is proportional to its size.
                    let unsure = 8e-16 * m as f64 * stretch.phase / (1.0 + m as f64 * half_turn);
                    let bound = 2e-14 + unsure;
                    assert!(
                        error < bound,
                        "{half_turn} × {m}: {error:e} above {bound:e}"
                    );
                }
            }
        }
    }
}
