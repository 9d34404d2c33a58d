//! Exact ratios of speeds.

use crate::numerics::integers::greatest_divisor;
use std::ops::{Add, Div, Mul, Sub};

/// A ratio of integers in lowest terms with a positive denominator. [`Ratio::TOO_LARGE`] if these exceed their type,
/// and for all results of calculations with it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Ratio {
    pub over: i128,
    pub under: i128,
}

impl Ratio {
    pub const ZERO: Self = Self { over: 0, under: 1 };
    pub const ONE: Self = Self { over: 1, under: 1 };

    pub const TOO_LARGE: Self = Self { over: 0, under: 0 };

    pub fn new(over: i128, under: i128) -> Self {
        if under == 0 {
            return Self::TOO_LARGE;
        }
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

    /// The product of two ratios in lowest terms: only opposite terms can have common divisors.
    fn product(one: Self, two: Self) -> Option<Self> {
        let [a, b] = [
            Self::new(one.over, two.under),
            Self::new(two.over, one.under),
        ];
        Some(Self {
            over: a.over.checked_mul(b.over)?,
            under: a.under.checked_mul(b.under)?,
        })
    }

    fn sum(one: Self, two: Self) -> Option<Self> {
        let common = greatest_divisor(one.under.unsigned_abs(), two.under.unsigned_abs()) as i128;
        let [a, b] = [one, two].map(|ratio| ratio.under.checked_div(common));
        let over = one.over.checked_mul(b?)?;
        let over = over.checked_add(two.over.checked_mul(a?)?)?;
        Some(Self::new(over, a?.checked_mul(two.under)?))
    }

    pub fn value(self) -> f64 {
        self.over as f64 / self.under as f64
    }
}

impl Add for Ratio {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self::sum(self, other).unwrap_or(Self::TOO_LARGE)
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
        Self::product(self, other).unwrap_or(Self::TOO_LARGE)
    }
}

impl Div for Ratio {
    type Output = Self;

    /// The divisor must not be 0.
    fn div(self, other: Self) -> Self {
        let sign = other.over.signum();
        let turned = Self {
            over: sign * other.under,
            under: sign * other.over,
        };
        self * turned
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_large_stays_so() {
        let large = Ratio::new(i128::MAX, 3);
        assert_eq!(large + large - large, Ratio::TOO_LARGE);
        assert_eq!(
            large * Ratio::new(3, 2) / Ratio::new(i128::MAX, 2),
            Ratio::ONE
        );
        assert_eq!(large / Ratio::new(-1, 3), Ratio::new(-i128::MAX, 1));
        let above = large * Ratio::new(2, 1);
        for made in [
            above + Ratio::ONE,
            Ratio::ZERO * above,
            Ratio::ONE / above,
            above.modulus(),
        ] {
            assert_eq!(made, Ratio::TOO_LARGE);
        }
        let fine = Ratio::new(1, i128::MAX);
        assert_eq!(fine + fine - fine, fine);
    }
}
