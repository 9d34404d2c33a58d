//! The error of loaded flanks over a segment.

use super::{STIFFNESS_TERMS, stiffness};
use crate::numerics::legendre;

/// Error e of the loaded flanks \[m\] over a segment: relief, misalignment and deviations under the mean
/// load, as a Legendre series in x ∈ \[−1, 1\] from the start to the end of the segment. A positive error is
/// missing material, and adds to the half gap on either side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlankError {
    series: [f64; STIFFNESS_TERMS],
}

impl FlankError {
    /// No error.
    pub const NONE: Self = Self {
        series: [0.0; STIFFNESS_TERMS],
    };

    /// The error with these Legendre coefficients \[m\].
    pub const fn series(series: [f64; STIFFNESS_TERMS]) -> Self {
        Self { series }
    }

    /// Its Legendre coefficients \[m\].
    pub fn coefficients(&self) -> &[f64; STIFFNESS_TERMS] {
        &self.series
    }

    /// Its Legendre coefficients \[m\], mutable.
    pub(super) fn coefficients_mut(&mut self) -> &mut [f64; STIFFNESS_TERMS] {
        &mut self.series
    }

    /// The mirror image of the error over the segment: its value at −x.
    pub fn reversed(&self) -> Self {
        Self {
            series: stiffness::reversed(&self.series),
        }
    }

    /// The part of the error between two positions x of the segment, as a series over this part.
    pub fn part(&self, from: f64, to: f64) -> Self {
        if self.is_none() {
            *self
        } else {
            Self {
                series: stiffness::part(&self.series, from, to),
            }
        }
    }

    /// Whether it is zero.
    pub fn is_none(&self) -> bool {
        *self == Self::NONE
    }

    /// Its value \[m\] at x ∈ \[−1, 1\].
    pub fn at(&self, x: f64) -> f64 {
        legendre::evaluate(&self.series, x)
    }

    /// The series of its derivative with respect to x \[m\].
    pub fn slope(&self) -> [f64; STIFFNESS_TERMS] {
        legendre::derivative(&self.series)
    }
}
