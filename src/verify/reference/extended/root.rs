//! Where is the first zero of a power series on a step? The signs of its Bernstein coefficients prove it.
//!
//! A polynomial has at most as many zeros in (0, 1) as its Bernstein coefficients have sign changes. Both numbers are
//! equal modulo two (Descartes' rule; Farouki 2012, section 3.3). No sign change proves that there is no zero. One sign
//! change proves exactly one zero, which Newton's method finds. With more, de Casteljau's algorithm halves the
//! interval.

use super::DoubleDouble;

/// Number of halvings after which an interval counts as undecided. The interval is then 2⁻⁵⁴ wide. A touch in it is
/// closer than 2⁻¹⁰⁸ of the step's scale, which is below the resolution of the numbers.
const DEPTH: u32 = 54;

/// A touch within the round-off of the numbers: a zero can be neither proved nor excluded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct UndecidedTouch;

/// First zero in [0, 1] of the polynomial with the given monomial coefficients. The polynomial should be
/// positive at 0. If it is not, the zero is 0.
pub(super) fn first_zero(power: &[DoubleDouble]) -> Result<Option<DoubleDouble>, UndecidedTouch> {
    let bernstein = bernstein(power);
    isolate(power, &bernstein, 0.0, 1.0, DEPTH)
}

/// Bernstein coefficients on [0, 1]: `b_i = Σ_{j ≤ i} C(i, j)/C(n, j) a_j`.
fn bernstein(power: &[DoubleDouble]) -> Vec<DoubleDouble> {
    let n = power.len() - 1;
    (0..=n)
        .map(|i| {
            // Compute C(i, j)/C(n, j) from its value at j − 1. It is at most 1, and decreases.
            let mut weight = DoubleDouble::ONE;
            let mut sum = power[0];
            for j in 1..=i {
                weight = weight * (i + 1 - j) as f64 / DoubleDouble::exact((n + 1 - j) as f64);
                sum += weight * power[j];
            }
            sum
        })
        .collect()
}

/// First zero on [left, left + width], given the Bernstein coefficients on this interval.
fn isolate(
    power: &[DoubleDouble],
    coefficients: &[DoubleDouble],
    left: f64,
    width: f64,
    depth: u32,
) -> Result<Option<DoubleDouble>, UndecidedTouch> {
    let zero = DoubleDouble::ZERO;
    let (first, last) = (coefficients[0], coefficients[coefficients.len() - 1]);
    if first <= zero {
        return Ok(Some(DoubleDouble::exact(left)));
    }
    match changes(coefficients) {
        0 if last > zero => return Ok(None),
        0 => return Ok(Some(DoubleDouble::exact(left + width))),
        1 => return Ok(Some(polish(power, left, left + width))),
        _ => {}
    }
    if depth == 0 {
        return Err(UndecidedTouch);
    }
    // The coefficients on both halves are the edges of de Casteljau's triangle.
    let mut row = coefficients.to_vec();
    let (mut before, mut after) = (vec![first], vec![last]);
    while row.len() > 1 {
        row = row.windows(2).map(|p| (p[0] + p[1]) * 0.5).collect();
        before.push(row[0]);
        after.push(row[row.len() - 1]);
    }
    after.reverse();
    let half = 0.5 * width;
    match isolate(power, &before, left, half, depth - 1)? {
        Some(zero) => Ok(Some(zero)),
        None => isolate(power, &after, left + half, half, depth - 1),
    }
}

/// Number of sign changes. Zeros are skipped.
fn changes(coefficients: &[DoubleDouble]) -> usize {
    let signs = coefficients.iter().map(|c| c.value().signum());
    let signs: Vec<f64> = signs
        .zip(coefficients)
        .filter(|(_, c)| c.value() != 0.0)
        .map(|(sign, _)| sign)
        .collect();
    signs.windows(2).filter(|p| p[0] != p[1]).count()
}

/// The only zero between two positions, with positive values before it, by Newton's method within the
/// bracket.
fn polish(power: &[DoubleDouble], left: f64, right: f64) -> DoubleDouble {
    let (mut left, mut right) = (DoubleDouble::exact(left), DoubleDouble::exact(right));
    let mut place = (left + right) * 0.5;
    // Bisection alone would need 106 steps; Newton's method doubles the digits.
    for _ in 0..120 {
        let (value, slope) = evaluate(power, place);
        if value > DoubleDouble::ZERO {
            left = place;
        } else {
            right = place;
        }
        let newton = place - value / slope;
        let next = if newton > left && newton < right {
            newton
        } else if (newton - place).abs().value() <= 1e-32 {
            break;
        } else {
            (left + right) * 0.5
        };
        let moved = (next - place).abs().value();
        place = next;
        if moved <= 1e-33 {
            break;
        }
    }
    place
}

/// Value and slope of a power series.
pub(super) fn evaluate(power: &[DoubleDouble], at: DoubleDouble) -> (DoubleDouble, DoubleDouble) {
    let (mut value, mut slope) = (DoubleDouble::ZERO, DoubleDouble::ZERO);
    for &a in power.iter().rev() {
        slope = slope * at + value;
        value = value * at + a;
    }
    (value, slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The polynomial with given zeros, positive before the first one.
    fn with_zeros(zeros: &[f64]) -> Vec<DoubleDouble> {
        let mut power = vec![DoubleDouble::ONE];
        for &zero in zeros {
            let mut next = vec![DoubleDouble::ZERO; power.len() + 1];
            for (j, &a) in power.iter().enumerate() {
                next[j] += a * zero;
                next[j + 1] += -a;
            }
            power = next;
        }
        power
    }

    #[test]
    fn first_of_several_zeros_is_found() {
        for zeros in [
            vec![0.3],
            vec![0.7, 0.3, 0.9],
            vec![0.3, 0.3 + 1e-9, 0.8],
            vec![0.5, 0.75],
            vec![0.25, 1.5, -0.5],
            vec![1.0],
        ] {
            let first = zeros
                .iter()
                .copied()
                .filter(|z| *z > 0.0)
                .fold(f64::INFINITY, f64::min);
            let sign = if zeros.iter().any(|z| *z < 0.0) { -1.0 } else { 1.0 };
            let power: Vec<_> = with_zeros(&zeros).iter().map(|&a| a * sign).collect();
            let found = first_zero(&power).unwrap().unwrap();
            let error = (found - DoubleDouble::exact(first)).abs().value();
            // The closer two zeros are, the less accurately they are determined.
            assert!(error < 1e-21, "{zeros:?}: {error:e}");
        }
    }

    #[test]
    fn near_miss_is_no_zero_and_a_touch_is_undecided() {
        let touch = with_zeros(&[0.3, 0.3]);
        let mut above = touch.clone();
        above[0] += DoubleDouble::exact(1e-28);
        assert_eq!(first_zero(&above), Ok(None));
        let mut below = touch.clone();
        below[0] += DoubleDouble::exact(-1e-28);
        let found = first_zero(&below).unwrap().unwrap();
        assert!((found.value() - (0.3 - 1e-14)).abs() < 1e-15);
        let mut exact = vec![DoubleDouble::exact(0.0625), DoubleDouble::exact(-0.5)];
        exact.push(DoubleDouble::ONE);
        // The double zero is at 1/4, a boundary between halves. It is found there.
        assert_eq!(
            first_zero(&exact).map(|z| z.map(DoubleDouble::value)),
            Ok(Some(0.25))
        );
        assert_eq!(first_zero(&with_zeros(&[1.5, 2.0])), Ok(None));
    }
}
