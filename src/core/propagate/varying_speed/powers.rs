//! Power series on a window, in `u = t/h ∈ [0, 1]`, and polynomials of time on a speed interval.

use crate::numerics::legendre::polynomials;
use crate::numerics::quadrature::GaussLegendre;
use crate::propagate::vectors::{Row, TERMS};
use std::sync::OnceLock;

/// Coefficients by powers of u.
pub type Powers = [f64; TERMS];

/// Number of coefficients of a course.
pub const COURSE_TERMS: usize = 5;

/// A polynomial of time over a [`SpeedInterval`](super::SpeedInterval), a stretch of time: coefficients by powers of the
/// time \[s\] since the start of the stretch.
pub type Course = [f64; COURSE_TERMS];

/// A compensated sum: it also stores its rounding error.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sum {
    /// Its value.
    pub value: f64,
    rest: f64,
}

impl Sum {
    /// Starts with a number.
    pub fn of(value: f64) -> Self {
        Self { value, rest: 0.0 }
    }

    /// Adds a number of the same or a smaller size.
    pub fn add(&mut self, term: f64) {
        let term = term + self.rest;
        let sum = self.value + term;
        self.rest = term - (sum - self.value);
        self.value = sum;
    }
}

/// The value at a position.
pub fn value(series: &[f64], place: f64) -> f64 {
    series.iter().rev().fold(0.0, |sum, a| sum * place + a)
}

/// Value and derivative at a position.
pub fn value_and_slope(series: &[f64], place: f64) -> [f64; 2] {
    let [mut sum, mut slope] = [0.0; 2];
    for a in series.iter().rev() {
        slope = slope * place + sum;
        sum = sum * place + a;
    }
    [sum, slope]
}

/// A course by powers of u on a window that starts at `start` \[s\] of the speed interval and is `length`
/// \[s\] long.
pub fn on_window(course: &Course, start: f64, length: f64) -> Course {
    let mut shifted = *course;
    // Repeated Horner schemes give the coefficients about `start`.
    for first in 0..COURSE_TERMS - 1 {
        for k in (first..COURSE_TERMS - 1).rev() {
            shifted[k] += start * shifted[k + 1];
        }
    }
    let mut scale = 1.0;
    for a in &mut shifted {
        *a *= scale;
        scale *= length;
    }
    shifted
}

/// The derivative of a course.
pub fn rate(course: &Course) -> Course {
    std::array::from_fn(|k| {
        let next = course.get(k + 1).copied().unwrap_or(0.0);
        (k + 1) as f64 * next
    })
}

/// The square of a course, truncated after the highest power of u in a course.
pub fn square(a: &Course) -> Course {
    std::array::from_fn(|k| (0..=k).map(|m| a[m] * a[k - m]).sum())
}

/// `−f''/r²` of a series f of u. Its last two terms are zero, because the series has no terms for them.
/// `cos(r u)` remains itself.
pub fn second_derivative(series: &Powers, r: f64) -> Powers {
    std::array::from_fn(|k| {
        let next = series.get(k + 2).copied().unwrap_or(0.0);
        -(((k + 1) * (k + 2)) as f64) * next / (r * r)
    })
}

/// The position where an increasing course that starts at 0 reaches the value `reached`. Newton's method
/// starts from the position for the mean rate on \[0, 1\].
pub fn place_of(course: &Course, reached: f64) -> f64 {
    let mut place = reached / value(course, 1.0);
    for _ in 0..20 {
        let [found, slope] = value_and_slope(course, place);
        let correction = (reached - found) / slope;
        place += correction;
        if correction.abs() <= f64::EPSILON * place {
            break;
        }
    }
    place.max(0.0)
}

/// The power series in u of a Legendre series whose argument is the polynomial `place` of u. Clenshaw's
/// recurrence is applied to series in place of numbers.
pub fn composed(legendre: &[f64], place: &Course, out: &mut Powers) {
    let (mut next, mut after) = ([0.0; TERMS], [0.0; TERMS]);
    for (n, a) in legendre.iter().enumerate().rev() {
        let k = n as f64;
        let [up, down] = [(2.0 * k + 1.0) / (k + 1.0), (k + 1.0) / (k + 2.0)];
        let mut now = [0.0; TERMS];
        for (m, p) in place.iter().enumerate() {
            for j in m..TERMS {
                now[j] += up * p * next[j - m];
            }
        }
        for (now, after) in now.iter_mut().zip(&after) {
            *now -= down * after;
        }
        now[0] += a;
        (after, next) = (next, now);
    }
    *out = next;
}

/// Number of terms up to the last one that is not zero, at least one.
pub fn length(series: &Powers) -> usize {
    series.iter().rposition(|a| *a != 0.0).map_or(1, |n| n + 1)
}

/// A power series as a Legendre series on the window.
pub fn to_legendre(series: &Powers) -> Powers {
    let rows = legendre_of_powers();
    let mut out = [0.0; TERMS];
    for (a, row) in series.iter().zip(rows) {
        for (sum, p) in out.iter_mut().zip(&row.0) {
            *sum += a * p;
        }
    }
    out
}

/// Legendre series of every power of u, one row per power.
fn legendre_of_powers() -> &'static [Row; TERMS] {
    static ROWS: OnceLock<[Row; TERMS]> = OnceLock::new();
    ROWS.get_or_init(|| {
        let rule = GaussLegendre::new(TERMS);
        let mut rows = [Row::ZERO; TERMS];
        let mut p = [0.0; TERMS];
        for (x, weight) in rule.nodes.iter().zip(&rule.weights) {
            polynomials(*x, &mut p);
            let mut power = *weight;
            for row in &mut rows {
                for (n, (sum, p)) in row.0.iter_mut().zip(&p).enumerate() {
                    *sum += (n as f64 + 0.5) * power * p;
                }
                power *= 0.5 * (x + 1.0);
            }
        }
        rows
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::legendre;

    /// Ten thousand terms of 1e-4 add up to exactly 1.
    #[test]
    fn sums_of_many_terms_are_exact() {
        let mut sum = Sum::of(0.0);
        for _ in 0..10_000 {
            sum.add(1e-4);
        }
        assert_eq!(sum.value, 1.0);
    }

    #[test]
    fn courses_move_with_the_window() {
        let course = [2.0, -1.0, 3.0, 0.5, -0.25];
        let own = on_window(&course, 0.7, 0.2);
        for u in [0.0, 0.3, 1.0] {
            let exact = value(&course, 0.7 + 0.2 * u);
            assert!((value(&own, u) - exact).abs() < 1e-15 * 8.0, "{u}");
        }
        let [value, slope] = value_and_slope(&course, 0.4);
        let step = 1e-6;
        let difference =
            (super::value(&course, 0.4 + step) - super::value(&course, 0.4 - step)) / (2.0 * step);
        assert!((slope - difference).abs() < 1e-8 && value == super::value(&course, 0.4));
        assert!((super::value(&rate(&course), 0.4) - slope).abs() < 1e-14);
        assert_eq!(
            square(&[3.0, 2.0, 1.0, 0.0, 0.0]),
            [9.0, 12.0, 10.0, 4.0, 1.0]
        );
        let growing = [0.0, 0.8, 0.3, 0.02, 0.0];
        for u in [0.0, 0.4, 1.0] {
            let found = place_of(&growing, super::value(&growing, u));
            assert!((found - u).abs() < 1e-15, "{u}: {found}");
        }
    }

    #[test]
    fn series_are_what_they_were_in_another_variable() {
        let legendre = [0.3, -0.2, 0.5, 0.1, 0.0, 0.7, 0.0, -0.4];
        let place = [-0.9, 0.6, 0.03, 0.005, 0.0];
        let mut powers = [0.0; TERMS];
        composed(&legendre, &place, &mut powers);
        let back = to_legendre(&powers);
        for u in [0.0, 0.2, 0.9] {
            let exact = legendre::evaluate(&legendre, value(&place, u));
            assert!((value(&powers, u) - exact).abs() < 1e-14, "{u}");
            assert!(
                (legendre::evaluate(&back, 2.0 * u - 1.0) - exact).abs() < 1e-13,
                "{u}"
            );
        }
        assert_eq!((length(&[0.0; TERMS]), length(&powers) > 8), (1, true));
    }
}
