//! Exponentials as Legendre series.
//!
//! On a window of length τ, with `x = 2t/τ − 1` and `z = λτ/2`,
//!
//! ```text
//! e^{λt} = e^z Σ (2n+1) i_n(z) P_n(x)         (Abramowitz & Stegun 10.2.36)
//! ```
//!
//! with `i_n` the modified spherical Bessel functions of the first kind. They are computed
//! as `i_n = zⁿ/(2n+1)!! c_n`: the two highest `c_n` by their power series, the rest by the
//! backward recurrence `c_{n−1} = c_n + z² c_{n+1}/((2n+1)(2n+3))`, which needs no division,
//! cannot overflow and is exact at z = 0.
//!
//! A rigid rotation (λ = 0) needs 1 and t. It is represented by `λ = iν` with a ν so small that
//! cos νt = 1 and sin νt/ν = t to round-off: [`RIGID_PHASE`].

use super::legendre;
use super::quadrature::GaussLegendre;
use multiversion::multiversion;
use num_complex::Complex64;
use std::sync::LazyLock;

/// Product of the ν of a rigid rotation and the window's length. Its square is below round-off.
pub const RIGID_PHASE: f64 = 1e-9;

/// Largest |λ| τ/2 for which the series below are converged to round-off.
pub const LARGEST_HALF_ARGUMENT: f64 = 5.0;

/// Largest number of terms of a series.
pub const MOST_TERMS: usize = 32;

/// Legendre coefficients of `e^{λt}` on \[0, τ\], written to `out`; returns `e^{λτ}`.
///
/// `|λ| τ/2` must not exceed [`LARGEST_HALF_ARGUMENT`] and `out` must hold 2 to [`MOST_TERMS`] entries.
pub fn legendre_series(lambda: Complex64, tau: f64, out: &mut [Complex64]) -> Complex64 {
    let [end] = legendre_series_of([lambda], tau, [out]);
    end
}

/// As [`legendre_series`], for several exponentials at once. The terms of one exponential are computed one
/// after the other, so that several exponentials take little longer than one.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx2", "x86_64+avx2"))]
pub fn legendre_series_of<const L: usize>(
    lambdas: [Complex64; L],
    tau: f64,
    out: [&mut [Complex64]; L],
) -> [Complex64; L] {
    let n = out[0].len();
    let half = lambdas.map(|lambda| 0.5 * lambda * tau);
    let z = Several::of(half);
    let square = z.times(z);
    // c_n by the backward recurrence.
    let mut above = scaled_bessel(n, square);
    let mut current = scaled_bessel(n - 1, square);
    let mut terms = [current; MOST_TERMS];
    for k in (1..n).rev() {
        let factor = 1.0 / ((2 * k + 1) * (2 * k + 3)) as f64;
        let next = square.times(above).scaled_onto(factor, current);
        (above, current) = (current, next);
        terms[k - 1] = current;
    }
    // Multiply by e^z zⁿ / (2n−1)!!, in ascending order of n.
    let mut power = Several::of(half.map(Complex64::exp));
    for (k, term) in terms[..n].iter_mut().enumerate() {
        *term = term.times(power);
        power = power.times(z).scaled(1.0 / (2 * k + 1) as f64);
    }
    for (l, out) in out.into_iter().enumerate() {
        for (value, term) in out.iter_mut().zip(&terms) {
            *value = Complex64::new(term.re[l], term.im[l]);
        }
    }
    half.map(|z| (2.0 * z).exp())
}
/// Several complex numbers.
#[derive(Clone, Copy)]
struct Several<const L: usize> {
    re: [f64; L],
    im: [f64; L],
}

impl<const L: usize> Several<L> {
    #[inline(always)]
    fn of(numbers: [Complex64; L]) -> Self {
        Self {
            re: numbers.map(|z| z.re),
            im: numbers.map(|z| z.im),
        }
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        let mut out = self;
        for l in 0..L {
            out.re[l] = self.re[l] * other.re[l] - self.im[l] * other.im[l];
            out.im[l] = self.re[l] * other.im[l] + self.im[l] * other.re[l];
        }
        out
    }

    #[inline(always)]
    fn scaled(mut self, factor: f64) -> Self {
        for l in 0..L {
            self.re[l] *= factor;
            self.im[l] *= factor;
        }
        self
    }

    /// `sum + factor self`.
    #[inline(always)]
    fn scaled_onto(self, factor: f64, mut sum: Self) -> Self {
        for l in 0..L {
            sum.re[l] += factor * self.re[l];
            sum.im[l] += factor * self.im[l];
        }
        sum
    }
}

/// Number of Gauss nodes in [`real_pair_series`].
const NODES: usize = 64;

/// Legendre coefficients on \[0, τ\] of `e^{μt} cosh σt` and `e^{μt} sinh(σt)/σ`, the real and
/// imaginary parts of `out`; returns their values at τ. `(|μ| + σ) τ/2` must not exceed
/// [`LARGEST_HALF_ARGUMENT`].
///
/// If σ is small, a difference of the series of two exponentials would be inaccurate. The coefficients are
/// therefore computed from values of the functions, by a Gauss rule with many nodes.
pub fn real_pair_series(mu: f64, sigma: f64, tau: f64, out: &mut [Complex64]) -> [f64; 2] {
    static RULE: LazyLock<GaussLegendre> = LazyLock::new(|| GaussLegendre::new(NODES));
    let values = |t: f64| {
        let grown = (mu * t).exp();
        let (fast, slow) = (((mu + sigma) * t).exp(), ((mu - sigma) * t).exp());
        let odd = if sigma * t < 0.5 {
            grown * t * sinh_ratio(sigma * t)
        } else {
            (fast - slow) / (2.0 * sigma)
        };
        [0.5 * (fast + slow), odd]
    };
    out.fill(Complex64::ZERO);
    let mut polynomials = vec![0.0; out.len()];
    for (x, weight) in RULE.nodes.iter().zip(&RULE.weights) {
        let [even, odd] = values(0.5 * tau * (x + 1.0));
        legendre::polynomials(*x, &mut polynomials);
        for (n, (term, p)) in out.iter_mut().zip(&polynomials).enumerate() {
            let scale = 0.5 * (2 * n + 1) as f64 * weight * p;
            *term += Complex64::new(scale * even, scale * odd);
        }
    }
    values(tau)
}

/// `sinh x / x` for small x, by its power series.
fn sinh_ratio(x: f64) -> f64 {
    let square = x * x;
    (1..=8).rev().fold(1.0, |sum, k| {
        1.0 + sum * square / f64::from((2 * k) * (2 * k + 1))
    })
}

/// Number of terms that the power series of `c_n` needs for |z| ≤ 5: fewer for higher n.
fn bessel_terms(n: usize) -> usize {
    match n {
        0..=11 => 20,
        12..=22 => 14,
        _ => 12,
    }
}

/// `c_n = Σ (z²/2)^k / (k! (2n+3)(2n+5)…(2n+2k+1))` (A&S 10.2.5), given z².
#[inline(always)]
fn scaled_bessel<const L: usize>(n: usize, square: Several<L>) -> Several<L> {
    let one = Several::of([Complex64::ONE; L]);
    (1..=bessel_terms(n)).rev().fold(one, |sum, k| {
        let factor = 0.5 / (k * (2 * n + 2 * k + 1)) as f64;
        square.times(sum).scaled_onto(factor, one)
    })
}

#[cfg(test)]
mod tests {
    use super::super::legendre;
    use super::*;
    use num_complex::c64;

    fn check(lambda: Complex64, tau: f64) {
        let mut out = [c64(f64::NAN, f64::NAN); 32];
        let end = legendre_series(lambda, tau, &mut out);
        let re: Vec<f64> = out.iter().map(|c| c.re).collect();
        let im: Vec<f64> = out.iter().map(|c| c.im).collect();
        for x in [-1.0, -0.5, 0.1, 0.8, 1.0] {
            let t = 0.5 * tau * (x + 1.0);
            let exact = (lambda * t).exp();
            assert!((legendre::evaluate(&re, x) - exact.re).abs() < 2e-15 * 4.0);
            assert!((legendre::evaluate(&im, x) - exact.im).abs() < 2e-15 * 4.0);
        }
        let exact = (lambda * tau).exp();
        assert!((end.re - exact.re).abs() < 1e-15);
        assert!((end.im - exact.im).abs() < 1e-15);
    }

    #[test]
    fn series_are_the_exponential() {
        for (re, im) in [
            (0.0, 4.0),
            (-0.3, 3.9),
            (-4.0, 0.1),
            (-0.01, 1.0),
            (-0.1, 9.9),
            (-9.9, 0.5),
            (0.0, 0.0),
        ] {
            check(c64(re, im), 1.0);
            check(c64(re * 1e5, im * 1e5), 1e-5);
        }
    }

    /// The two exponentials may be close or distant.
    #[test]
    fn a_real_pair_is_hyperbolic() {
        for (mu, sigma, tau) in [
            (-1.5, 1.2, 2.0),
            (-3.0, 2.9, 1.0),
            (0.2, 0.3, 1.0),
            (-0.7, 0.0, 1.5),
        ] {
            let mut out = [c64(f64::NAN, f64::NAN); 32];
            let end = real_pair_series(mu, sigma, tau, &mut out);
            let parts = [0, 1].map(|part| {
                let own = |c: &Complex64| if part == 0 { c.re } else { c.im };
                out.iter().map(own).collect::<Vec<f64>>()
            });
            for x in [-1.0, -0.9, -0.3, 0.1, 0.8, 1.0] {
                let t = 0.5 * tau * (x + 1.0);
                let grown = f64::exp(mu * t);
                let odd = if sigma == 0.0 { t } else { (sigma * t).sinh() / sigma };
                let exact = [grown * (sigma * t).cosh(), grown * odd];
                for (part, exact) in parts.iter().zip(exact) {
                    assert!(
                        (legendre::evaluate(part, x) - exact).abs() < 3e-14,
                        "{mu} {sigma} {x}"
                    );
                }
                if x == 1.0 {
                    assert!(
                        end.iter().zip(exact).all(|(a, b)| (a - b).abs() < 1e-15),
                        "{end:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_rigid_rotation_gives_one_and_t() {
        let (tau, mut out) = (3.0, [Complex64::ZERO; 16]);
        let nu = RIGID_PHASE / tau;
        let end = legendre_series(c64(0.0, nu), tau, &mut out);
        assert_eq!((out[0].re, end.re), (1.0, 1.0));
        assert!((out[0].im / nu - 1.5).abs() < 1e-15);
        assert!((out[1].im / nu - 1.5).abs() < 1e-15);
        assert!((end.im / nu - 3.0).abs() < 1e-15);
        for value in &out[2..] {
            assert!((value.im / nu).abs() < 1e-17);
        }
    }

    #[test]
    fn tiny_windows_neither_overflow_nor_vanish() {
        let mut out = [Complex64::ZERO; 16];
        let end = legendre_series(c64(-1.0, 1e5), 1e-300, &mut out);
        assert_eq!(end.re, 1.0);
        assert!((out[0].im / 1e5 - 0.5e-300).abs() < 1e-315);
        assert!(out.iter().all(|c| c.is_finite()));
    }
}
