//! Legendre series on a window: evaluation, derivative, restriction, bounds, division.
//!
//! A series `Σ a[n] P_n(x)` lives on x ∈ \[−1, 1\]; a window of length Δ has `x = 2t/Δ − 1`.
//! `|P_n| ≤ 1` makes `Σ|a[n]|` a bound, which is what event certificates are made of.

use super::quadrature::GaussLegendre;
use std::sync::OnceLock;

/// Value of the series at x, by Clenshaw's recurrence.
pub fn evaluate(series: &[f64], x: f64) -> f64 {
    let (mut b1, mut b2) = (0.0, 0.0);
    for n in (0..series.len()).rev() {
        let k = n as f64;
        let b0 = series[n] + (2.0 * k + 1.0) / (k + 1.0) * x * b1 - (k + 1.0) / (k + 2.0) * b2;
        b2 = b1;
        b1 = b0;
    }
    b1
}

/// Writes `P_0(x) … P_{n−1}(x)` to `out`.
pub fn polynomials(x: f64, out: &mut [f64]) {
    for n in 0..out.len() {
        out[n] = match n {
            0 => 1.0,
            1 => x,
            _ => {
                let k = n as f64;
                ((2.0 * k - 1.0) * x * out[n - 1] - (k - 1.0) * out[n - 2]) / k
            }
        };
    }
}

/// Coefficients of the derivative by x: `d[n] = (2n+1) Σ a[j]` over j = n+1, n+3, ….
pub fn derivative<const P: usize>(series: &[f64; P]) -> [f64; P] {
    let mut out = [0.0; P];
    let (mut even, mut odd) = (0.0, 0.0);
    for n in (0..P - 1).rev() {
        let sum = if n % 2 == 0 { &mut odd } else { &mut even };
        *sum += series[n + 1];
        out[n] = (2.0 * n as f64 + 1.0) * *sum;
    }
    out
}

/// Value at x = −1.
pub fn at_start(series: &[f64]) -> f64 {
    let sign = |n: usize| if n.is_multiple_of(2) { 1.0 } else { -1.0 };
    series.iter().enumerate().map(|(n, a)| sign(n) * a).sum()
}

/// Value at x = +1.
pub fn at_end(series: &[f64]) -> f64 {
    series.iter().sum()
}

/// `Σ_{n≥1} |a[n]|`: the most by which the series can leave `a[0]`.
pub fn variation(series: &[f64]) -> f64 {
    series[1..].iter().map(|a| a.abs()).sum()
}

/// The quotient `q` of `series / (1 + x)`, the value at x = −1 being taken as zero.
///
/// Used to remove a root known to lie at a window's start. Backward recurrence of
/// `(1 + x) q = g` with `x P_n = ((n+1) P_{n+1} + n P_{n−1})/(2n+1)`.
pub fn divide_out_start<const P: usize>(series: &[f64; P]) -> [f64; P] {
    let mut q = [0.0; P];
    for n in (1..P).rev() {
        let k = n as f64;
        let next = if n + 1 < P { q[n + 1] } else { 0.0 };
        q[n - 1] = (2.0 * k - 1.0) / k * (series[n] - q[n] - (k + 1.0) / (2.0 * k + 3.0) * next);
    }
    q
}

/// Constant transforms of series with P coefficients.
#[derive(Debug)]
pub struct Transforms<const P: usize> {
    /// Gauss nodes with P points.
    nodes: [f64; P],
    /// `to_series[j][n]`: contribution of the value at node j to coefficient n.
    to_series: [[f64; P]; P],
    /// `halves[side][n][m]`: contribution of coefficient n to coefficient m on the left or
    /// right half of the interval.
    halves: [Box<[[f64; P]; P]>; 2],
}

impl<const P: usize> Transforms<P> {
    fn new() -> Self {
        let rule = GaussLegendre::new(P);
        let mut nodes = [0.0; P];
        nodes.copy_from_slice(&rule.nodes);
        let mut to_series = [[0.0; P]; P];
        for (j, row) in to_series.iter_mut().enumerate() {
            polynomials(nodes[j], row);
            for (n, value) in row.iter_mut().enumerate() {
                *value *= rule.weights[j] * (n as f64 + 0.5);
            }
        }
        let mut transforms = Self {
            nodes,
            to_series,
            halves: [Box::new([[0.0; P]; P]), Box::new([[0.0; P]; P])],
        };
        for (side, (lo, hi)) in [(-1.0, 0.0), (0.0, 1.0)].into_iter().enumerate() {
            for n in 0..P {
                let mut unit = [0.0; P];
                unit[n] = 1.0;
                transforms.halves[side][n] = transforms.restrict(&unit, lo, hi);
                // Triangular by construction: what quadrature leaves above is round-off.
                transforms.halves[side][n][n + 1..].fill(0.0);
            }
        }
        transforms
    }

    /// The series on the sub-interval \[lo, hi\] of \[−1, 1\], stretched to \[−1, 1\].
    pub fn restrict(&self, series: &[f64; P], lo: f64, hi: f64) -> [f64; P] {
        let mut x = [0.0; P];
        for j in 0..P {
            x[j] = 0.5 * ((hi - lo) * self.nodes[j] + (hi + lo));
        }
        // Clenshaw at all nodes at once: the nodes are the lanes.
        let (mut b1, mut b2) = ([0.0; P], [0.0; P]);
        for n in (0..P).rev() {
            let k = n as f64;
            let (up, down) = ((2.0 * k + 1.0) / (k + 1.0), (k + 1.0) / (k + 2.0));
            for j in 0..P {
                let b0 = series[n] + up * x[j] * b1[j] - down * b2[j];
                b2[j] = b1[j];
                b1[j] = b0;
            }
        }
        self.interpolate(&b1)
    }

    /// The series of degree P − 1 through values at the P Gauss nodes.
    pub fn interpolate(&self, values: &[f64; P]) -> [f64; P] {
        let mut out = [0.0; P];
        for (value, row) in values.iter().zip(&self.to_series) {
            for (o, r) in out.iter_mut().zip(row) {
                *o += value * r;
            }
        }
        out
    }

    /// The Gauss nodes that [`Self::interpolate`] expects values at.
    pub fn nodes(&self) -> &[f64; P] {
        &self.nodes
    }

    /// The series on the left (`side = 0`) or right (`side = 1`) half.
    pub fn half(&self, series: &[f64; P], side: usize) -> [f64; P] {
        let mut out = [0.0; P];
        for (a, row) in series.iter().zip(self.halves[side].iter()) {
            for (o, r) in out.iter_mut().zip(row) {
                *o += a * r;
            }
        }
        out
    }
}

/// The transforms of 16-term series.
pub fn transforms16() -> &'static Transforms<16> {
    static TABLE: OnceLock<Transforms<16>> = OnceLock::new();
    TABLE.get_or_init(Transforms::new)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> [f64; 16] {
        std::array::from_fn(|n| ((n * n) as f64 * 0.7).sin() / (1.0 + n as f64))
    }

    #[test]
    fn derivative_matches_a_difference() {
        let (a, x, h) = (sample(), 0.3, 1e-6);
        let d = derivative(&a);
        let difference = (evaluate(&a, x + h) - evaluate(&a, x - h)) / (2.0 * h);
        assert!((evaluate(&d, x) - difference).abs() < 1e-7);
    }

    #[test]
    fn ends_and_bound() {
        let a = sample();
        assert!((at_start(&a) - evaluate(&a, -1.0)).abs() < 1e-14);
        assert!((at_end(&a) - evaluate(&a, 1.0)).abs() < 1e-14);
        for i in 0..=100 {
            let x = -1.0 + 0.02 * f64::from(i);
            assert!((evaluate(&a, x) - a[0]).abs() <= variation(&a) * (1.0 + 1e-15));
        }
    }

    #[test]
    fn restriction_is_the_same_polynomial() {
        let (a, t) = (sample(), transforms16());
        let part = t.restrict(&a, -0.4, 0.9);
        for u in [-1.0, -0.3, 0.5, 1.0] {
            let x = 0.5 * (1.3 * u + 0.5);
            assert!((evaluate(&part, u) - evaluate(&a, x)).abs() < 2e-14);
            assert!((evaluate(&t.half(&a, 0), u) - evaluate(&a, 0.5 * (u - 1.0))).abs() < 2e-14);
            assert!((evaluate(&t.half(&a, 1), u) - evaluate(&a, 0.5 * (u + 1.0))).abs() < 2e-14);
        }
    }

    #[test]
    fn division_removes_a_root_at_the_start() {
        let mut a = sample();
        a[0] -= at_start(&a);
        let q = divide_out_start(&a);
        for x in [-0.999, -0.2, 0.7, 1.0] {
            assert!((evaluate(&q, x) * (1.0 + x) - evaluate(&a, x)).abs() < 1e-13);
        }
        let slope = evaluate(&derivative(&a), -1.0);
        assert!((at_start(&q) - slope).abs() < 1e-12 * slope.abs().max(1.0));
    }

    #[test]
    fn polynomials_agree_with_clenshaw() {
        let a = sample();
        let mut p = [f64::NAN; 16];
        polynomials(0.37, &mut p);
        let sum: f64 = a.iter().zip(&p).map(|(a, p)| a * p).sum();
        assert!((sum - evaluate(&a, 0.37)).abs() < 1e-14);
    }
}
