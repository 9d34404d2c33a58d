//! Exact ratios of speeds.

use crate::numerics::integers::greatest_divisor;
use std::ops::{Add, Div, Mul, Sub};

/// A ratio of whole numbers in lowest terms, the denominator positive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Ratio {
    pub over: i128,
    pub under: i128,
}

impl Ratio {
    pub const ZERO: Self = Self { over: 0, under: 1 };
    pub const ONE: Self = Self { over: 1, under: 1 };

    pub fn new(over: i128, under: i128) -> Self {
        let divisor = greatest_divisor(over.unsigned_abs(), under.unsigned_abs()) as i128;
        let sign = if under < 0 { -1 } else { 1 };
        Self {
            over: sign * over / divisor,
            under: sign * under / divisor,
        }
    }

    pub fn modulus(self) -> Self {
        Self::new(self.over.abs(), self.under)
    }

    pub fn value(self) -> f64 {
        self.over as f64 / self.under as f64
    }
}

impl Add for Ratio {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let over = self.over * other.under + other.over * self.under;
        Self::new(over, self.under * other.under)
    }
}

impl Sub for Ratio {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + other * Self::new(-1, 1)
    }
}

impl Mul for Ratio {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self::new(self.over * other.over, self.under * other.under)
    }
}

impl Div for Ratio {
    type Output = Self;

    /// Of a divisor that is not 0.
    fn div(self, other: Self) -> Self {
        Self::new(self.over * other.under, self.under * other.over)
    }
}
