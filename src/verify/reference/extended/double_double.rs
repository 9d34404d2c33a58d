//! Numbers of about 31 digits: the unevaluated sum of two doubles.
//!
//! Sums use Knuth's two-sum. Products use Veltkamp's splitting and Dekker's product (Dekker 1971; Hida, Li &
//! Bailey 2001). Relative errors are a few units of 2⁻¹⁰⁴. The splitting overflows beyond 2⁹⁹⁶, far above any
//! quantity of a gear drive.

use std::cmp::Ordering;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// The number `high + low`, with `|low|` at most half a unit in the last place of `high`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DoubleDouble {
    high: f64,
    low: f64,
}

/// 2²⁷ + 1.
const SPLITTER: f64 = 134_217_729.0;

impl DoubleDouble {
    /// Zero.
    pub const ZERO: Self = Self::exact(0.0);
    /// One.
    pub const ONE: Self = Self::exact(1.0);
    /// π/2: the double nearest to it, and the double nearest to the remainder.
    pub const HALF_PI: Self = Self {
        high: std::f64::consts::FRAC_PI_2,
        low: 6.123_233_995_736_766e-17,
    };

    /// A double, taken as exact.
    pub const fn exact(value: f64) -> Self {
        Self {
            high: value,
            low: 0.0,
        }
    }

    /// The double nearest to the number.
    pub fn value(self) -> f64 {
        self.high
    }

    /// The remainder beyond the nearest double.
    pub fn rest(self) -> f64 {
        self.low
    }

    /// The exact product of two doubles.
    pub fn product(a: f64, b: f64) -> Self {
        let high = a * b;
        let ([a1, a2], [b1, b2]) = (split(a), split(b));
        let low = ((a1 * b1 - high) + a1 * b2 + a2 * b1) + a2 * b2;
        Self { high, low }
    }

    /// Absolute value.
    pub fn abs(self) -> Self {
        if self.high < 0.0 { -self } else { self }
    }

    /// The largest whole number not above this one.
    pub fn floor(self) -> Self {
        let high = self.high.floor();
        if high == self.high {
            quick_two_sum(high, self.low.floor())
        } else {
            Self::exact(high)
        }
    }

    /// `(sin, cos)`, to some 30 digits for arguments up to about a hundred.
    pub fn sin_cos(self) -> (Self, Self) {
        let quarter_turns = (self.high / Self::HALF_PI.high).round();
        let r = self - Self::HALF_PI * quarter_turns;
        // |r| ≤ π/4. The terms of both series are those of the exponential series, with alternating signs.
        let (mut sin, mut cos) = (Self::ZERO, Self::ZERO);
        let mut term = Self::ONE;
        let mut n = 0u32;
        while n < 4 || term.high.abs() > 1e-36 {
            match n % 4 {
                0 => cos += term,
                1 => sin += term,
                2 => cos += -term,
                _ => sin += -term,
            }
            n += 1;
            term = term * r / Self::exact(f64::from(n));
        }
        match quarter_turns.rem_euclid(4.0) as u32 {
            0 => (sin, cos),
            1 => (cos, -sin),
            2 => (-sin, -cos),
            _ => (-cos, sin),
        }
    }
}

/// A double as the exact sum of two of 26 bits.
fn split(a: f64) -> [f64; 2] {
    let t = SPLITTER * a;
    let high = t - (t - a);
    [high, a - high]
}

/// `a + b` and its round-off.
fn two_sum(a: f64, b: f64) -> DoubleDouble {
    let high = a + b;
    let back = high - a;
    DoubleDouble {
        high,
        low: (a - (high - back)) + (b - back),
    }
}

/// As [`two_sum`], for `|a| ≥ |b|`.
fn quick_two_sum(a: f64, b: f64) -> DoubleDouble {
    let high = a + b;
    DoubleDouble {
        high,
        low: b - (high - a),
    }
}

impl Add for DoubleDouble {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        // Both halves are summed exactly, so that nothing is lost if the high ones cancel.
        let s = two_sum(self.high, other.high);
        let t = two_sum(self.low, other.low);
        let s = quick_two_sum(s.high, s.low + t.high);
        quick_two_sum(s.high, s.low + t.low)
    }
}

impl AddAssign for DoubleDouble {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Neg for DoubleDouble {
    type Output = Self;

    fn neg(self) -> Self {
        Self {
            high: -self.high,
            low: -self.low,
        }
    }
}

impl Sub for DoubleDouble {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for DoubleDouble {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let p = Self::product(self.high, other.high);
        let cross = self.high * other.low + self.low * other.high;
        quick_two_sum(p.high, p.low + cross)
    }
}

impl Mul<f64> for DoubleDouble {
    type Output = Self;

    fn mul(self, other: f64) -> Self {
        let p = Self::product(self.high, other);
        quick_two_sum(p.high, p.low + self.low * other)
    }
}

impl Div for DoubleDouble {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        // Long division: the quotient has three parts, each a double.
        let first = self.high / other.high;
        let rest = self - other * first;
        let second = rest.high / other.high;
        let rest = rest - other * second;
        let third = rest.high / other.high;
        quick_two_sum(first, second) + Self::exact(third)
    }
}

impl PartialOrd for DoubleDouble {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        match self.high.partial_cmp(&other.high) {
            Some(Ordering::Equal) => self.low.partial_cmp(&other.low),
            order => order,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ratio(a: f64, b: f64) -> DoubleDouble {
        DoubleDouble::exact(a) / DoubleDouble::exact(b)
    }

    #[test]
    fn product_of_two_doubles_is_exact() {
        let mut a = 0x1f_1234_5678_9abci64;
        for _ in 0..1000 {
            // Whole numbers of 53 bits; their products have 106.
            let b = a.wrapping_mul(6_364_136_223_846_793_005) >> 11;
            let p = DoubleDouble::product(a as f64, b as f64);
            assert_eq!(
                p.high as i128 + p.low as i128,
                i128::from(a) * i128::from(b)
            );
            a = b;
        }
    }

    #[test]
    fn arithmetic_holds_thirty_one_digits() {
        for n in 1..200 {
            let third = ratio(f64::from(n), 3.0 * f64::from(n) + 1.0);
            let back = third * DoubleDouble::exact(3.0 * f64::from(n) + 1.0);
            let error = back - DoubleDouble::exact(f64::from(n));
            assert!(error.abs().value() < 3e-32 * f64::from(n), "{n}: {error:?}");
        }
        // Cancellation of the high halves leaves the low ones.
        let x = DoubleDouble::ONE + DoubleDouble::exact(2f64.powi(-80));
        assert_eq!((x - DoubleDouble::ONE).value(), 2f64.powi(-80));
        // (1/3 + 1/7) 21 = 10.
        let sum = (ratio(1.0, 3.0) + ratio(1.0, 7.0)) * 21.0;
        assert!((sum - DoubleDouble::exact(10.0)).abs().value() < 1e-30);
    }

    #[test]
    fn floor_looks_at_both_halves() {
        let below = DoubleDouble::exact(3.0) - DoubleDouble::exact(1e-25);
        assert_eq!(below.floor(), DoubleDouble::exact(2.0));
        assert_eq!(ratio(-1.0, 3.0).floor(), DoubleDouble::exact(-1.0));
        assert_eq!(ratio(22.0, 7.0).floor(), DoubleDouble::exact(3.0));
    }

    #[test]
    fn sine_and_cosine_hold_thirty_digits() {
        // sin 1 and cos 1, split into two doubles with Python's decimal module.
        let one = DoubleDouble::ONE.sin_cos();
        let known = [
            (0.841_470_984_807_896_5, 1.776_845_092_935_536e-18),
            (0.540_302_305_868_139_8, -4.760_954_612_604_417e-17),
        ];
        for (found, (high, low)) in [one.0, one.1].into_iter().zip(known) {
            assert_eq!(found.high, high);
            assert!((found.low - low).abs() < 1e-31, "{found:?}");
        }
        // sin² + cos² = 1, and the sine of the sum, across all quadrants.
        let step = ratio(7.0, 11.0);
        let (ss, cs) = step.sin_cos();
        let mut x = DoubleDouble::exact(-12.0);
        while x.value() < 12.0 {
            let (s, c) = x.sin_cos();
            assert!((s * s + c * c - DoubleDouble::ONE).abs().value() < 1e-30);
            let next = (x + step).sin_cos().0;
            assert!((next - (s * cs + c * ss)).abs().value() < 1e-30);
            x += step;
        }
    }
}
