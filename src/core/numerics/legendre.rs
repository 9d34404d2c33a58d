//! Legendre series on a window: evaluation, derivative, restriction, bounds, division.
//!
//! A series `Σ a[n] P_n(x)` is defined on x ∈ \[−1, 1\]; a window of length Δ has `x = 2t/Δ − 1`.
//! `|P_n| ≤ 1`, so that `Σ|a[n]|` is a bound of the series. The proofs that a window has no event use it.

use super::quadrature::GaussLegendre;
use std::sync::OnceLock;

/// Value of the series at x, by Clenshaw's recurrence.
pub fn evaluate(series: &[f64], x: f64) -> f64 {
    /// Number of terms whose factors are computed in advance.
    const KNOWN: usize = 64;
    let known = const { clenshaw::<KNOWN>() };
    let (mut b1, mut b2) = (0.0, 0.0);
    for n in (0..series.len()).rev() {
        let [up, down] = if n < KNOWN { known[n] } else { clenshaw_factors(n) };
        let b0 = series[n] + up * x * b1 - down * b2;
        b2 = b1;
        b1 = b0;
    }
    b1
}

/// Values of L series at x. `series[n]` has the coefficient of `P_n` in each series, n < 64.
pub fn evaluate_each<const L: usize>(series: &[[f64; L]], x: f64) -> [f64; L] {
    let factors = const { clenshaw::<64>() };
    let mut sums = [0.0; L];
    let (mut before, mut polynomial, mut down) = (0.0, 1.0, 0.0);
    for (terms, [up, next_down]) in series.iter().zip(factors) {
        for (sum, term) in sums.iter_mut().zip(terms) {
            *sum += term * polynomial;
        }
        (before, polynomial) = (polynomial, up * x * polynomial - down * before);
        down = next_down;
    }
    sums
}

/// Factors of Clenshaw's recurrence, `(2n+1)/(n+1)` and `(n+1)/(n+2)`, computed in advance because divisions
/// would take longer than the rest of the recurrence.
const fn clenshaw<const P: usize>() -> [[f64; 2]; P] {
    let mut factors = [[0.0; 2]; P];
    let mut n = 0;
    while n < P {
        factors[n] = clenshaw_factors(n);
        n += 1;
    }
    factors
}

const fn clenshaw_factors(n: usize) -> [f64; 2] {
    let k = n as f64;
    [(2.0 * k + 1.0) / (k + 1.0), (k + 1.0) / (k + 2.0)]
}

/// `a b + c`, as one fused operation if `FUSED`, for which the processor must support it.
#[inline(always)]
fn multiply_add<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

/// Value of the series at x with its first two derivatives with respect to x.
#[inline(always)]
pub fn evaluate_with_derivatives<const P: usize, const FUSED: bool>(
    series: &[f64; P],
    x: f64,
) -> [f64; 3] {
    let factors = const { clenshaw::<P>() };
    let (mut b, mut b_next) = ([0.0; 3], [0.0; 3]);
    for n in (0..P).rev() {
        let [up, down] = factors[n];
        let step = up * x;
        // Terms that are available early are added first, which shortens the chain of dependent operations.
        let early = [
            multiply_add::<FUSED>(-down, b_next[0], series[n]),
            multiply_add::<FUSED>(-down, b_next[1], up * b[0]),
            multiply_add::<FUSED>(-down, b_next[2], (2.0 * up) * b[1]),
        ];
        let new = [
            multiply_add::<FUSED>(step, b[0], early[0]),
            multiply_add::<FUSED>(step, b[1], early[1]),
            multiply_add::<FUSED>(step, b[2], early[2]),
        ];
        b_next = b;
        b = new;
    }
    b
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

/// Coefficients of the derivative with respect to x: `d[n] = (2n+1) Σ a[j]` over j = n+1, n+3, ….
#[inline(always)]
pub fn derivative<const P: usize>(series: &[f64; P]) -> [f64; P] {
    let mut out = [0.0; P];
    // Swap the sums of even and odd terms in every step: selecting one of them would wait for every addition.
    let (mut sum, mut other) = (0.0, 0.0);
    for n in (0..P - 1).rev() {
        sum += series[n + 1];
        out[n] = (2.0 * n as f64 + 1.0) * sum;
        (sum, other) = (other, sum);
    }
    out
}

/// Value at x = −1.
#[inline(always)]
pub fn at_start(series: &[f64]) -> f64 {
    let [even, odd] = parts(series);
    even - odd
}

/// Value at x = +1.
#[inline(always)]
pub fn at_end(series: &[f64]) -> f64 {
    let [even, odd] = parts(series);
    even + odd
}

/// Sums of the even and of the odd coefficients, each computed as two partial sums: a single sum would wait
/// for every addition.
#[inline(always)]
fn parts(series: &[f64]) -> [f64; 2] {
    let mut sums = [0.0; 4];
    for group in series.chunks(4) {
        for (sum, a) in sums.iter_mut().zip(group) {
            *sum += a;
        }
    }
    [sums[0] + sums[2], sums[1] + sums[3]]
}

/// `Σ_{n≥1} |a[n]|`: upper bound of the distance of the series from `a[0]`.
#[inline(always)]
pub fn variation(series: &[f64]) -> f64 {
    // Use four partial sums: a single sum would wait for every addition.
    let mut sums = [0.0; 4];
    for group in series[1..].chunks(4) {
        for (sum, a) in sums.iter_mut().zip(group) {
            *sum += a.abs();
        }
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}

/// The quotient `q` of `series / (1 + x)`, with the value at x = −1 taken as zero.
///
/// It removes a root at a window's start. A backward recurrence solves `(1 + x) q = series` with
/// `x P_n = ((n+1) P_{n+1} + n P_{n−1})/(2n+1)`.
#[inline(always)]
pub fn divide_out_start<const P: usize>(series: &[f64; P]) -> [f64; P] {
    let factors = const { division::<P>() };
    let mut q = [0.0; P];
    let mut next = 0.0;
    for n in (1..P).rev() {
        let [of_series, of_next] = factors[n];
        // Terms that are available early are added first, which shortens the chain of dependent operations.
        let early = of_series * series[n] - of_next * next;
        q[n - 1] = early - of_series * q[n];
        next = q[n];
    }
    q
}

/// Factors of the recurrence in [`divide_out_start`]: `(2n−1)/n`, and this times `(n+1)/(2n+3)`.
const fn division<const P: usize>() -> [[f64; 2]; P] {
    let mut factors = [[0.0; 2]; P];
    let mut n = 1;
    while n < P {
        let k = n as f64;
        let factor = (2.0 * k - 1.0) / k;
        factors[n] = [factor, factor * ((k + 1.0) / (2.0 * k + 3.0))];
        n += 1;
    }
    factors
}

/// Constant matrices for operations on series with P coefficients.
#[derive(Debug)]
pub struct Transforms<const P: usize> {
    /// The nodes and weights of the Gauss rule with P nodes.
    nodes: [f64; P],
    weights: [f64; P],
    /// `to_series[j][n]`: contribution of the value at node j to coefficient n.
    to_series: [[f64; P]; P],
    /// Maps to the series on the left and on the right half of the interval.
    halves: [Box<Columns<P>>; 2],
    /// Map to the derivative with respect to x.
    derivative: Box<Columns<P>>,
    /// Map to the quotient by 1 + x.
    quotient: Box<Columns<P>>,
    /// Map to the values at the samples.
    samples: Box<Columns<P, SAMPLES>>,
    /// Map to the values at the nodes.
    values: Box<Columns<P>>,
}

/// Number of positions at which a series is sampled before a search for a root.
pub const SAMPLES: usize = 24;

/// Position of a sample. The positions are uniform on \[−1, 1\], both ends included.
#[inline(always)]
pub fn sample_place(index: usize) -> f64 {
    2.0 / (SAMPLES - 1) as f64 * index as f64 - 1.0
}

/// A map from a series to a series or to values: `columns[n][m]` is the contribution of coefficient n to
/// coefficient m (zero for m > n), or to the value at position m.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub struct Columns<const P: usize, const M: usize = P>(pub [[f64; M]; P]);

impl<const P: usize> Transforms<P> {
    fn new() -> Self {
        let rule = GaussLegendre::new(P);
        let mut nodes = [0.0; P];
        let mut weights = [0.0; P];
        nodes.copy_from_slice(&rule.nodes);
        weights.copy_from_slice(&rule.weights);
        let mut to_series = [[0.0; P]; P];
        for (j, row) in to_series.iter_mut().enumerate() {
            polynomials(nodes[j], row);
            for (n, value) in row.iter_mut().enumerate() {
                *value *= rule.weights[j] * (n as f64 + 0.5);
            }
        }
        let mut transforms = Self {
            nodes,
            weights,
            to_series,
            halves: [const { Columns([[0.0; P]; P]) }; 2].map(Box::new),
            derivative: Box::new(Columns([[0.0; P]; P])),
            quotient: Box::new(Columns([[0.0; P]; P])),
            samples: Box::new(Columns([[0.0; SAMPLES]; P])),
            values: Box::new(Columns([[0.0; P]; P])),
        };
        for j in 0..P {
            let mut values = [0.0; P];
            polynomials(nodes[j], &mut values);
            for n in 0..P {
                transforms.values.0[n][j] = values[n];
            }
        }
        let mut values = [0.0; P];
        for m in 0..SAMPLES {
            polynomials(sample_place(m), &mut values);
            for n in 0..P {
                transforms.samples.0[n][m] = values[n];
            }
        }
        for (side, (lo, hi)) in [(-1.0, 0.0), (0.0, 1.0)].into_iter().enumerate() {
            for n in 0..P {
                let mut unit = [0.0; P];
                unit[n] = 1.0;
                let restricted = transforms.restrict(&unit, lo, hi);
                let half = &mut transforms.halves[side].0[n];
                *half = restricted;
                // The matrix is triangular. Its other entries are round-off of the quadrature.
                half[n + 1..].fill(0.0);
                transforms.derivative.0[n] = derivative(&unit);
                transforms.quotient.0[n] = divide_out_start(&unit);
            }
        }
        transforms
    }

    /// The series on the sub-interval \[lo, hi\] of \[−1, 1\], rescaled to \[−1, 1\].
    pub fn restrict(&self, series: &[f64; P], lo: f64, hi: f64) -> [f64; P] {
        let mut x = [0.0; P];
        for j in 0..P {
            x[j] = 0.5 * ((hi - lo) * self.nodes[j] + (hi + lo));
        }
        // Clenshaw's recurrence at all nodes at once, in vector instructions.
        let factors = const { clenshaw::<P>() };
        let (mut b1, mut b2) = ([0.0; P], [0.0; P]);
        for n in (0..P).rev() {
            let [up, down] = factors[n];
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

    /// The weights at the Gauss nodes.
    pub fn weights(&self) -> &[f64; P] {
        &self.weights
    }

    /// The map to the left (`side = 0`) or right (`side = 1`) half.
    pub fn to_half(&self, side: usize) -> &Columns<P> {
        &self.halves[side]
    }

    /// The map to the derivative with respect to x.
    pub fn to_derivative(&self) -> &Columns<P> {
        &self.derivative
    }

    /// The map to the quotient by 1 + x.
    pub fn to_quotient(&self) -> &Columns<P> {
        &self.quotient
    }

    /// The map from values at the nodes to the series: `[j]` is the series of the value 1 at node j and 0 at
    /// the others.
    pub fn to_series(&self) -> &[[f64; P]; P] {
        &self.to_series
    }

    /// The map to the values at the nodes.
    pub fn to_nodes(&self) -> &Columns<P> {
        &self.values
    }

    /// The map to the values at the samples.
    pub fn to_samples(&self) -> &Columns<P, SAMPLES> {
        &self.samples
    }

    /// The series on the left (`side = 0`) or right (`side = 1`) half.
    #[inline(always)]
    pub fn half(&self, series: &[f64; P], side: usize) -> [f64; P] {
        let mut out = [0.0; P];
        for (a, row) in series.iter().zip(&self.halves[side].0) {
            for (o, r) in out.iter_mut().zip(row) {
                *o += a * r;
            }
        }
        out
    }
}

/// The transforms of 8-term series.
pub fn transforms8() -> &'static Transforms<8> {
    static TABLE: OnceLock<Transforms<8>> = OnceLock::new();
    TABLE.get_or_init(Transforms::new)
}

/// The transforms of 24-term series.
pub fn transforms24() -> &'static Transforms<24> {
    static TABLE: OnceLock<Transforms<24>> = OnceLock::new();
    TABLE.get_or_init(Transforms::new)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> [f64; 24] {
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
    fn derivatives_are_those_of_the_series() {
        let a = sample();
        let slope = derivative(&a);
        for x in [-1.0, -0.3, 0.6, 1.0] {
            let exact = [
                evaluate(&a, x),
                evaluate(&slope, x),
                evaluate(&derivative(&slope), x),
            ];
            let found = evaluate_with_derivatives::<_, false>(&a, x);
            for (found, exact) in found.into_iter().zip(exact) {
                assert!((found - exact).abs() < 1e-12 * exact.abs().max(1.0));
            }
        }
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
        let (a, t) = (sample(), transforms24());
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
        let mut p = [f64::NAN; 24];
        polynomials(0.37, &mut p);
        let sum: f64 = a.iter().zip(&p).map(|(a, p)| a * p).sum();
        assert!((sum - evaluate(&a, 0.37)).abs() < 1e-14);
        let both = evaluate_each(&a.map(|a| [a, -3.0 * a]), 0.37);
        assert!((both[0] - sum).abs() < 1e-14 && (both[1] + 3.0 * sum).abs() < 1e-14);
    }

    /// Sums of integers are exact for any number of terms.
    #[test]
    fn ends_and_variation_are_sums() {
        for count in 1..=24 {
            let value = |n: usize| [3.0, -5.0, 7.0][n % 3] * (n + 1) as f64;
            let a: Vec<f64> = (0..count).map(value).collect();
            let sizes: f64 = a[1..].iter().map(|a| a.abs()).sum();
            assert_eq!(variation(&a), sizes);
            let turned = |(n, a): (usize, &f64)| if n % 2 == 0 { *a } else { -a };
            let start: f64 = a.iter().enumerate().map(turned).sum();
            assert_eq!([at_start(&a), at_end(&a)], [start, a.iter().sum()]);
        }
    }

    /// The columns of the constant maps are the images of the polynomials.
    #[test]
    fn maps_are_those_of_the_polynomials() {
        let t = transforms8();
        for n in 0..8 {
            let mut unit = [0.0; 8];
            unit[n] = 1.0;
            for m in 0..SAMPLES {
                let place = -1.0 + 2.0 * m as f64 / 23.0;
                assert!((sample_place(m) - place).abs() < 1e-15);
                let value = evaluate(&unit, place);
                assert!((t.to_samples().0[n][m] - value).abs() < 1e-14, "{n} {m}");
            }
            let at = |columns: &Columns<8>, x: f64| evaluate(&columns.0[n], x);
            for x in [-0.7, 0.2, 1.0] {
                let slope = evaluate(&derivative(&unit), x);
                assert!((at(t.to_derivative(), x) - slope).abs() < 1e-13);
                let start = evaluate(&unit, -1.0);
                let rest = (1.0 + x) * at(t.to_quotient(), x) - evaluate(&unit, x) + start;
                assert!(rest.abs() < 1e-13, "{n}: {rest}");
                for (side, half) in [(0, 0.5 * (x - 1.0)), (1, 0.5 * (x + 1.0))] {
                    assert!((at(t.to_half(side), x) - evaluate(&unit, half)).abs() < 1e-14);
                }
            }
            // Interpolation of degree 7 through eight values, and integration by the weights.
            let values = t.nodes().map(|x| evaluate(&unit, x));
            for (found, exact) in t.interpolate(&values).iter().zip(unit) {
                assert!((found - exact).abs() < 1e-14);
            }
            let integral: f64 = t.weights().iter().zip(values).map(|(w, v)| w * v).sum();
            assert!((integral - 2.0 * unit[0]).abs() < 1e-15);
        }
    }
}
