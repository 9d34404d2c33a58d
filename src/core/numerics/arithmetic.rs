//! The operations on series that searches for roots need, as a trait. Kernels implement it with the machine's
//! vector instructions.

use super::legendre::{self, SAMPLES, Transforms};

/// Bounds of a series on \[−1, 1\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Value at −1.
    pub start: f64,
    /// Value at +1.
    pub end: f64,
    /// `Σ_{n≥1} |a[n]|`: upper bound of the distance of the series from `a[0]`.
    pub variation: f64,
}

/// Operations on series of P terms.
pub trait Arithmetic<const P: usize> {
    /// Values at both ends, and the variation.
    fn bounds(series: &[f64; P]) -> Bounds;

    /// The derivative with respect to x.
    fn derivative(transforms: &Transforms<P>, series: &[f64; P]) -> [f64; P];

    /// The quotient by 1 + x, with the value at x = −1 taken as zero.
    fn quotient(transforms: &Transforms<P>, series: &[f64; P]) -> [f64; P];

    /// The series on the left (`side = 0`) or right (1) half of the interval.
    fn half(transforms: &Transforms<P>, series: &[f64; P], side: usize) -> [f64; P];

    /// `factor · series`, with `constant` added.
    fn scaled(series: &[f64; P], factor: f64, constant: f64) -> [f64; P];

    /// Values at all positions [`legendre::sample_place`].
    fn samples(transforms: &Transforms<P>, series: &[f64; P]) -> [f64; SAMPLES];

    /// Value at x and its first two derivatives with respect to x.
    fn derivatives_at(series: &[f64; P], x: f64) -> [f64; 3];
}

/// Implementation for any machine.
#[derive(Debug)]
pub struct Portable;

impl<const P: usize> Arithmetic<P> for Portable {
    #[inline(always)]
    fn bounds(series: &[f64; P]) -> Bounds {
        Bounds {
            start: legendre::at_start(series),
            end: legendre::at_end(series),
            variation: legendre::variation(series),
        }
    }

    #[inline(always)]
    fn derivative(_: &Transforms<P>, series: &[f64; P]) -> [f64; P] {
        legendre::derivative(series)
    }

    #[inline(always)]
    fn quotient(_: &Transforms<P>, series: &[f64; P]) -> [f64; P] {
        legendre::divide_out_start(series)
    }

    #[inline(always)]
    fn half(transforms: &Transforms<P>, series: &[f64; P], side: usize) -> [f64; P] {
        transforms.half(series, side)
    }

    #[inline(always)]
    fn scaled(series: &[f64; P], factor: f64, constant: f64) -> [f64; P] {
        let mut out = series.map(|a| factor * a);
        out[0] += constant;
        out
    }

    #[inline(always)]
    fn samples(transforms: &Transforms<P>, series: &[f64; P]) -> [f64; SAMPLES] {
        let mut out = [0.0; SAMPLES];
        for (a, values) in series.iter().zip(&transforms.to_samples().0) {
            for (out, value) in out.iter_mut().zip(values) {
                *out += a * value;
            }
        }
        out
    }

    #[inline(always)]
    fn derivatives_at(series: &[f64; P], x: f64) -> [f64; 3] {
        legendre::evaluate_with_derivatives::<P, false>(series, x)
    }
}
