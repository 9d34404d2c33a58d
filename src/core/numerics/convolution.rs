//! Convolution of Legendre series on a window.
//!
//! For kernel and input given as series on \[0, Δ\],
//!
//! ```text
//! ∫₀ᵗ P_k(ξ(t−s)) P_m(ξ(s)) ds = Δ Σ_n C[k][m][n] P_n(ξ(t)),      ξ(t) = 2t/Δ − 1
//! ```
//!
//! The numbers C do not depend on the drive. They are computed once, by Gauss rules that are exact for these
//! polynomials (degree k+m+1 in t). The Volterra operator of a drive is then a linear combination of P × P
//! matrices.

use super::legendre::polynomials;
use super::quadrature::GaussLegendre;
use multiversion::multiversion;
use std::sync::OnceLock;

/// `C[k][m][n]` for k < `K` and m, n < `P`: kernel term k acting on input term m, projected on
/// output term n.
pub struct Convolution<const K: usize, const P: usize> {
    table: Vec<[[f64; P]; P]>,
}

impl<const K: usize, const P: usize> Convolution<K, P> {
    fn new() -> Self {
        // Degree of the inner integrand: k + m ≤ K + P − 2; of the outer one: k + m + 1 + n ≤ K + 2P − 2.
        let inner = GaussLegendre::new((K + P).div_ceil(2));
        let outer = GaussLegendre::new((K + 2 * P).div_ceil(2));
        let mut table = vec![[[0.0; P]; P]; K];
        let mut projections = [0.0; P];
        let (mut kernel, mut input) = ([0.0; K], [0.0; P]);
        for (x, w) in outer.nodes.iter().zip(&outer.weights) {
            polynomials(*x, &mut projections);
            for (n, p) in projections.iter_mut().enumerate() {
                *p *= w * (n as f64 + 0.5);
            }
            // Inner integral over s ∈ [0, t], t = (x + 1)/2 on the unit window.
            let t = 0.5 * (x + 1.0);
            let mut values = vec![[0.0; P]; K];
            for (y, v) in inner.nodes.iter().zip(&inner.weights) {
                let s = 0.5 * t * (y + 1.0);
                polynomials(2.0 * (t - s) - 1.0, &mut kernel);
                polynomials(2.0 * s - 1.0, &mut input);
                for k in 0..K {
                    let scaled = 0.5 * t * v * kernel[k];
                    for m in 0..P {
                        values[k][m] += scaled * input[m];
                    }
                }
            }
            for k in 0..K {
                for m in 0..P {
                    for n in Self::orders(k, m) {
                        table[k][m][n] += projections[n] * values[k][m];
                    }
                }
            }
        }
        Self { table }
    }

    /// The output terms that can be nonzero for kernel term k and input term m.
    fn orders(k: usize, m: usize) -> std::ops::Range<usize> {
        let last = P.min(k + m + 2);
        k.abs_diff(m).saturating_sub(1).min(last)..last
    }

    /// Columns of the Volterra operator with kernel `Σ kernel[k] P_k` on a window of length
    /// Δ: `out[m][n]` is output coefficient n of input term m.
    pub fn operator(&self, kernel: &[f64; K], delta: f64) -> [[f64; P]; P] {
        let scales = kernel.map(|h| h * delta);
        combined(&scales[..significant(&scales)], &self.table)
    }

    /// Output coefficients of the constant input 1: the first column of the operator.
    pub fn step(&self, kernel: &[f64; K], delta: f64) -> [f64; P] {
        let mut out = [0.0; P];
        for (h, plane) in kernel.iter().zip(&self.table) {
            for (o, c) in out.iter_mut().zip(&plane[0]) {
                *o += h * delta * c;
            }
        }
        out
    }

    /// For an input series, the output coefficients of each of the first `terms` kernel terms on a window
    /// of length Δ: `[k][n]`.
    pub fn responses(&self, input: &[f64], delta: f64, terms: usize) -> Vec<[f64; P]> {
        let mut scales = [0.0; P];
        for (scale, f) in scales.iter_mut().zip(input) {
            *scale = f * delta;
        }
        let mut out = vec![[0.0; P]; terms.min(K)];
        respond(&scales[..input.len().min(P)], &self.table, &mut out);
        out
    }
}

/// Coefficients below this fraction of the largest one are negligible: a sixteenth of round-off.
const NEGLIGIBLE: f64 = f64::EPSILON / 16.0;

/// Number of terms of a series up to the last that is not negligible.
pub fn significant(series: &[f64]) -> usize {
    let largest = series.iter().fold(0.0_f64, |most, a| most.max(a.abs()));
    let matters = |a: &f64| a.abs() > NEGLIGIBLE * largest;
    series.iter().rposition(matters).map_or(0, |last| last + 1)
}

/// The product `a b` of two matrices that are stored by columns.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx2", "x86_64+avx2"))]
pub fn product<const P: usize>(a: &[[f64; P]; P], b: &[[f64; P]; P]) -> [[f64; P]; P] {
    let mut out = [[0.0; P]; P];
    for (out, weights) in out.iter_mut().zip(b) {
        for (column, weight) in a.iter().zip(weights) {
            for (sum, c) in out.iter_mut().zip(column) {
                *sum += weight * c;
            }
        }
    }
    out
}

/// Adds the response of a kernel to an input whose [`Convolution::responses`] are known.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx2", "x86_64+avx2"))]
pub fn add_response<const P: usize>(kernel: &[f64], responses: &[[f64; P]], out: &mut [f64; P]) {
    for (scale, response) in kernel.iter().zip(responses) {
        for (sum, r) in out.iter_mut().zip(response) {
            *sum += scale * r;
        }
    }
}

/// Adds to each row of `out` the columns of one plane, each times its scale.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx2", "x86_64+avx2"))]
fn respond<const P: usize>(scales: &[f64], planes: &[[[f64; P]; P]], out: &mut [[f64; P]]) {
    for (row, plane) in out.iter_mut().zip(planes) {
        for (scale, column) in scales.iter().zip(plane) {
            for (sum, c) in row.iter_mut().zip(column) {
                *sum += scale * c;
            }
        }
    }
}

/// The sum of planes, each times its scale. Zeros of the planes are added too, because whole columns are
/// faster.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx2", "x86_64+avx2"))]
fn combined<const P: usize>(scales: &[f64], planes: &[[[f64; P]; P]]) -> [[f64; P]; P] {
    let mut out = [[0.0; P]; P];
    for (m, column) in out.iter_mut().enumerate() {
        for (scale, plane) in scales.iter().zip(planes) {
            for (sum, c) in column.iter_mut().zip(&plane[m]) {
                *sum += scale * c;
            }
        }
    }
    out
}

/// The convolution of 24-term inputs with 32-term kernels.
pub fn convolution24() -> &'static Convolution<32, 24> {
    static TABLE: OnceLock<Convolution<32, 24>> = OnceLock::new();
    TABLE.get_or_init(Convolution::new)
}

#[cfg(test)]
mod tests {
    use super::super::legendre::evaluate;
    use super::*;

    #[test]
    fn convolving_with_one_integrates() {
        // Kernel 1, input P_0 + P_1 on a window of length 3: ∫₀ᵗ (1 + ξ) ds = t + t²/3 − t.
        let mut kernel = [0.0; 32];
        kernel[0] = 1.0;
        let columns = convolution24().operator(&kernel, 3.0);
        for t in [0.0, 0.7, 2.0, 3.0] {
            let x = 2.0 * t / 3.0 - 1.0;
            let sum = evaluate(&columns[0], x) + evaluate(&columns[1], x);
            assert!((sum - t * t / 3.0).abs() < 4e-15, "{t} {sum}");
        }
    }

    #[test]
    fn convolution_of_sine_with_cosine_is_half_t_sine() {
        // ∫₀ᵗ sin(t−s) cos s ds = t sin t / 2.
        let rule = GaussLegendre::new(40);
        let series = |f: fn(f64) -> f64, out: &mut [f64]| {
            let mut p = vec![0.0; out.len()];
            out.fill(0.0);
            for (x, w) in rule.nodes.iter().zip(&rule.weights) {
                polynomials(*x, &mut p);
                for n in 0..out.len() {
                    out[n] += w * (n as f64 + 0.5) * p[n] * f(0.5 * 2.0 * (x + 1.0));
                }
            }
        };
        let (mut kernel, mut input) = ([0.0; 32], [0.0; 24]);
        series(f64::sin, &mut kernel);
        series(f64::cos, &mut input);
        let parts = convolution24().responses(&input, 2.0, 32);
        let columns = convolution24().operator(&kernel, 2.0);
        for t in [0.1, 0.9, 1.7, 2.0] {
            let exact = 0.5 * t * f64::sin(t);
            let by_operator: f64 = (0..24)
                .map(|m| input[m] * evaluate(&columns[m], t - 1.0))
                .sum();
            let by_parts: f64 = (0..32)
                .map(|k| kernel[k] * evaluate(&parts[k], t - 1.0))
                .sum();
            assert!((by_operator - exact).abs() < 1e-14, "{t}");
            assert!((by_parts - exact).abs() < 1e-14, "{t}");
        }
    }
}
