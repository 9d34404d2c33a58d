//! The first moment on a short interval at which a margin becomes negative.
//!
//! A bound C of the margin's second derivative decides cases that values at the ends leave open. A margin of curvature
//! C is not below the parabola through these values that bends as much. The margin is monotone if its chord is steeper
//! than `C h`. If neither decides, the interval is halved, the left half first, so that no event is missed.

use super::lanes::FACTORS;
use crate::propagate::Counters;
use crate::propagate::vectors::{InstructionSet, Vector, for_each_set};

/// Largest depth of the bisection.
const DEEPEST: u32 = 60;

/// Largest number of steps of Halley's method.
const MOST_STEPS: u32 = 60;

/// A margin and its rate at a time from the start of a block.
pub trait Margin {
    /// Margin \[m\], rate \[m/s\] and second derivative \[m/s²\] at a time.
    fn at(&mut self, time: f64) -> [f64; 3];
}

/// An interval of a block.
#[derive(Debug, Clone, Copy)]
pub struct Interval {
    /// Start and end \[s\].
    pub times: [f64; 2],
    /// Margins there \[m\].
    pub margins: [f64; 2],
    /// Estimate of its root \[s\].
    pub guess: Option<f64>,
}

/// Bounds of a margin on a block.
#[derive(Debug, Clone, Copy)]
pub struct MarginBounds {
    /// Bound of the second derivative \[m/s²\].
    pub curvature: f64,
    /// Fastest rate \[1/s\]: `curvature · fastest` bounds the third derivative.
    pub fastest: f64,
    /// Round-off of the margin's values \[m\].
    pub noise: f64,
}

/// Whether a margin stays positive between two values on an interval of some length \[s\]. Tests the lowest point
/// `(a + b)/2 − s − (a − b)²/16 s` of the parabola with the largest curvature through both values; s is its sag
/// `C h²/8`.
#[inline(always)]
pub fn stays(bounds: MarginBounds, [a, b]: [f64; 2], length: f64) -> bool {
    let sag = 0.125 * bounds.curvature * length * length;
    let difference = (a - b).abs();
    let lowest = 0.5 * (a + b) - sag - difference * difference / (16.0 * sag);
    a.min(b) > 0.0 && (difference >= 4.0 * sag || lowest > bounds.noise)
}

/// Whether a margin that starts at zero with a rate \[m/s\] is positive up to its value at the end of an interval. It
/// is not below `t (rate − C t/2)` and not below `t (b/h − C (h − t)/2)`.
#[inline(always)]
pub fn rises(bounds: MarginBounds, rate: f64, end: f64, length: f64) -> bool {
    let bent = 0.5 * bounds.curvature * length;
    rate > bent || (end > 0.0 && (rate - bent) * length + end > 0.0)
}

/// The first root on an interval. The margin is not negative at the start.
pub fn exit<M: Margin>(
    margin: &mut M,
    bounds: MarginBounds,
    interval: Interval,
    depth: u32,
    counters: &mut Counters,
) -> Option<f64> {
    let ([from, to], [a, b]) = (interval.times, interval.margins);
    let length = to - from;
    let bend = bounds.curvature * length * length;
    if stays(bounds, interval.margins, length) || b - a > bend {
        return None;
    }
    if a - b > bend {
        return (b < 0.0).then(|| root(margin, bounds, interval, counters));
    }
    if a.abs().max(b.abs()) + 0.125 * bend <= bounds.noise || depth == DEEPEST {
        counters.grazings += 1;
        return None;
    }
    counters.bisections += 1;
    let [left, right] = halves(margin, interval);
    exit(margin, bounds, left, depth + 1, counters)
        .or_else(|| exit(margin, bounds, right, depth + 1, counters))
}

/// As [`exit`], for a margin that starts at zero with a nonnegative rate \[m/s\]. The root at the start does not count.
pub fn exit_behind<M: Margin>(
    margin: &mut M,
    bounds: MarginBounds,
    rate: f64,
    interval: Interval,
    depth: u32,
    counters: &mut Counters,
) -> Option<f64> {
    let length = interval.times[1] - interval.times[0];
    if rises(bounds, rate, interval.margins[1], length) {
        return None;
    }
    let reach = (rate.abs() + 0.5 * bounds.curvature * length) * length;
    if reach <= bounds.noise || depth == DEEPEST {
        counters.grazings += 1;
        return None;
    }
    counters.bisections += 1;
    let [left, right] = halves(margin, interval);
    exit_behind(margin, bounds, rate, left, depth + 1, counters)
        .or_else(|| exit(margin, bounds, right, depth + 1, counters))
}

fn halves<M: Margin>(margin: &mut M, interval: Interval) -> [Interval; 2] {
    let ([from, to], [a, b]) = (interval.times, interval.margins);
    let middle = 0.5 * (from + to);
    let [value, ..] = margin.at(middle);
    [
        Interval {
            times: [from, middle],
            margins: [a, value],
            guess: None,
        },
        Interval {
            times: [middle, to],
            margins: [value, b],
            guess: None,
        },
    ]
}

/// The only root of a margin that decreases through zero on an interval, by Halley's method within a bracket. C and D
/// are the bounds of the second and third derivative. A step s from a point with the rate r leaves an error of at most
/// `|s|³ (D / 3 |r| + (C / r)²)` if `C |s| < |r| / 2`.
fn root<M: Margin>(
    margin: &mut M,
    bounds: MarginBounds,
    interval: Interval,
    counters: &mut Counters,
) -> f64 {
    let ([mut low, mut high], [a, b]) = (interval.times, interval.margins);
    if a <= 0.0 {
        return low;
    }
    let fine = f64::EPSILON * high;
    let mut time = match interval.guess {
        Some(guess) if guess > low && guess < high => guess,
        _ => low + (high - low) * a / (a - b),
    };
    for _ in 0..MOST_STEPS {
        let [value, rate, bend] = margin.at(time);
        counters.newton_steps += 1;
        if value > 0.0 {
            low = time
        } else {
            high = time
        }
        let newton = -value / rate;
        let step = -value / (rate + 0.5 * bend * newton);
        let next = time + step;
        let (size, turn) = (step.abs(), bounds.curvature / rate.abs());
        let error = size * size * size * turn * (bounds.fastest / 3.0 + turn);
        if turn * size < 0.5 && error <= fine {
            return next.clamp(interval.times[0], interval.times[1]);
        }
        time = if next > low && next < high { next } else { 0.5 * (low + high) };
        if high - low <= fine {
            break;
        }
    }
    time
}

/// Number of points of the interpolating polynomial.
pub const POINTS: usize = 9;

for_each_set! {
    /// Estimates the zero of the polynomial through margins at 0, 1, … between `from` and the next point.
    fn near_root(values: &[f64; POINTS], from: usize) -> f64 = near_root_body
}

#[inline(always)]
fn near_root_body<V: Vector>(values: &[f64; POINTS], from: usize) -> f64 {
    /// Degree of the polynomial, and the last point.
    const LAST: usize = POINTS - 1;
    // Newton's form from the last point back: differences, each in the last lane, divided by their factorials.
    let mut d = [values[LAST]; POINTS];
    let mut sums = V::read(&values[1..]);
    let mut first = values[0];
    for order in 1..POINTS {
        sums = sums.minus(sums.shifted_in(first));
        first = 0.0;
        d[order] = sums.lanes().0[LAST - 1] * FACTORS[order];
    }
    let before = from as f64 + values[from] / (values[from] - values[from + 1]);
    let mut x = before - LAST as f64;
    // Halley's method.
    for _ in 0..2 {
        let (mut value, mut slope, mut bend) = (0.0, 0.0, 0.0);
        for i in (0..POINTS).rev() {
            let away = x + i as f64;
            bend = V::fma(bend, away, slope);
            slope = V::fma(slope, away, value);
            value = V::fma(value, away, d[i]);
        }
        x -= value * slope / (slope * slope - value * bend);
    }
    x + LAST as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Function<F>(F);

    impl<F: Fn(f64) -> [f64; 3]> Margin for Function<F> {
        fn at(&mut self, time: f64) -> [f64; 3] {
            (self.0)(time)
        }
    }

    fn found(f: impl Fn(f64) -> [f64; 3], curvature: f64) -> (Option<f64>, Counters) {
        let own = Interval {
            times: [0.0, 1.0],
            margins: [f(0.0)[0], f(1.0)[0]],
            guess: None,
        };
        let bounds = MarginBounds {
            curvature,
            fastest: 3.0,
            noise: 1e-15,
        };
        let mut counters = Counters::default();
        let found = exit(&mut Function(f), bounds, own, 0, &mut counters);
        (found, counters)
    }

    /// `(t − a)(t − b)`: positive at both ends, negative between the roots, at any distance of the roots.
    #[test]
    fn a_dip_between_positive_ends_is_found() {
        for apart in [0.3, 1e-3, 1e-6] {
            let (a, b) = (0.4, 0.4 + apart);
            let dip = |t: f64| [(t - a) * (t - b), 2.0 * t - a - b, 2.0];
            let (first, _) = found(dip, 2.0);
            assert!((first.unwrap() - a).abs() < 1e-15 / apart, "{apart}");
        }
        // A touch within round-off is a grazing. A margin that stays positive is proved to do so.
        let (none, counters) = found(|t| [(t - 0.37) * (t - 0.37), 2.0 * (t - 0.37), 2.0], 2.0);
        assert!(none.is_none() && counters.grazings > 0);
        let (none, counters) = found(
            |t| [1e-9 + (t - 0.37) * (t - 0.37), 2.0 * (t - 0.37), 2.0],
            2.0,
        );
        assert!(none.is_none() && counters.grazings == 0);
    }

    /// The first of three roots, though the values at the ends suggest only one.
    #[test]
    fn the_first_of_three_roots_is_taken() {
        let f = |t: f64| {
            let [x, y, z] = [0.2 - t, 0.5 - t, 0.9 - t];
            [x * y * z, -(x * y + y * z + z * x), 2.0 * (x + y + z)]
        };
        let (first, _) = found(f, 3.3);
        assert!((first.unwrap() - 0.2).abs() < 1e-15);
    }

    /// A polynomial of fifth degree has the same root as its interpolation, from any point.
    #[test]
    fn the_polynomial_through_nine_values_has_their_root() {
        for from in 0..POINTS - 1 {
            let at = from as f64 + 0.3;
            let f = |x: f64| (at - x) * (1.0 + 0.02 * x.powi(2) + 0.001 * x.powi(4));
            let values = std::array::from_fn(|i| f(i as f64));
            let x = near_root(InstructionSet::best(), &values, from);
            assert!((x - at).abs() < 1e-12, "{from}: {x}");
        }
    }

    /// The root that the block starts from is no event; the next one is.
    #[test]
    fn the_root_at_the_start_is_left_behind() {
        for next in [0.7, 1e-4] {
            let f = |t: f64| [t * (next - t), next - 2.0 * t, -2.0];
            let own = Interval {
                times: [0.0, 1.0],
                margins: [0.0, f(1.0)[0]],
                guess: None,
            };
            let bounds = MarginBounds {
                curvature: 2.0,
                fastest: 3.0,
                noise: 1e-15,
            };
            let mut counters = Counters::default();
            let found = exit_behind(&mut Function(f), bounds, next, own, 0, &mut counters);
            assert!((found.unwrap() - next).abs() < 1e-13, "{next}");
        }
    }
}
