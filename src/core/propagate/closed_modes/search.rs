//! The first moment on a short interval at which a margin becomes negative.
//!
//! The values at both ends and a bound C of the margin's second derivative decide most intervals. The margin
//! is not below the parabola with the curvature C through the end values. On an interval of length h, the
//! margin rises if its chord is steeper than `C h`. The rates at the start and at a root may prove that the
//! root is the first. If none of these decides, the interval is halved. The left half comes first, so that no
//! event is missed.

use crate::propagate::Counters;
use crate::propagate::vectors::{Lanes, Vector};

/// Largest depth of the bisection.
const DEEPEST: u32 = 60;

/// Largest number of steps of Halley's method.
const MOST_STEPS: u32 = 60;

/// A margin as a function of the time \[s\] from the start of a block.
pub trait Margin {
    /// Margin \[m\], rate \[m/s\] and second derivative \[m/s²\] at a time.
    fn at(&mut self, time: f64) -> [f64; 3];

    /// The same margin as an object that selects the instruction set at every call. Its callers are compiled once for
    /// all processors.
    fn with_run_time_dispatch(&mut self) -> &mut dyn Margin;
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

/// The first time on an interval at which a margin becomes negative; `None` if it stays positive or only touches zero.
/// At the start the margin is not negative beyond round-off.
#[inline(always)]
pub fn exit<M: Margin + ?Sized>(
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
    if a <= 0.0 && b - a < -bend {
        return Some(from);
    }
    if let Some(first) = first_by_rates(margin, bounds, interval, a / length, counters) {
        return Some(first);
    }
    if a.abs().max(b.abs()) + 0.125 * bend <= bounds.noise || depth == DEEPEST {
        counters.grazings += 1;
        return None;
    }
    exit_of_halves(
        margin.with_run_time_dispatch(),
        bounds,
        None,
        interval,
        depth + 1,
        counters,
    )
}

/// As [`exit`], for a margin that starts at zero with a nonnegative rate \[m/s\]. The root at the start does not count.
#[inline(always)]
pub fn exit_behind<M: Margin + ?Sized>(
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
    if let Some(first) = first_by_rates(margin, bounds, interval, rate, counters) {
        return Some(first);
    }
    let reach = (rate.abs() + 0.5 * bounds.curvature * length) * length;
    if reach <= bounds.noise || depth == DEEPEST {
        counters.grazings += 1;
        return None;
    }
    exit_of_halves(
        margin.with_run_time_dispatch(),
        bounds,
        Some(rate),
        interval,
        depth + 1,
        counters,
    )
}

/// The first root on the halves of an interval. `rate` is the rate at the start if the margin is zero there,
/// else `None`.
#[cold]
fn exit_of_halves(
    margin: &mut dyn Margin,
    bounds: MarginBounds,
    rate: Option<f64>,
    interval: Interval,
    depth: u32,
    counters: &mut Counters,
) -> Option<f64> {
    counters.bisections += 1;
    let [left, right] = halves(margin, interval);
    let first = match rate {
        Some(rate) => exit_behind(margin, bounds, rate, left, depth, counters),
        None => exit(margin, bounds, left, depth, counters),
    };
    first.or_else(|| exit(margin, bounds, right, depth, counters))
}

/// A root of a margin that is negative at the end of an interval, if the rates prove that no earlier one exists.
///
/// At a distance s from the start the margin is positive if `rise > C s/2`. The rise is the rate of a margin that starts at
/// zero, which is not below `rise s − C s²/2`. Otherwise it is the start's value divided by the length of the interval: the
/// margin is not below the chord to the root, less the sag. At a distance t from a root at which the margin falls with the
/// rate r, it is not below `r t − C t²/2`. Both ranges meet if `rise + r ≥ C (s + t)/2`.
#[inline(always)]
fn first_by_rates<M: Margin + ?Sized>(
    margin: &mut M,
    bounds: MarginBounds,
    interval: Interval,
    rise: f64,
    counters: &mut Counters,
) -> Option<f64> {
    let [from, _] = interval.times;
    let [a, b] = interval.margins;
    if b >= 0.0 || (a <= 0.0 && interval.guess.is_none()) {
        return None;
    }
    let (time, rate) = root(margin, bounds, interval, counters);
    let proved = rise - rate >= 0.5 * bounds.curvature * (time - from);
    if time > from && rate < 0.0 && proved { Some(time) } else { None }
}

fn halves(margin: &mut dyn Margin, interval: Interval) -> [Interval; 2] {
    let ([from, to], [a, b]) = (interval.times, interval.margins);
    let middle = 0.5 * (from + to);
    let [value, ..] = margin.at(middle);
    let guess = interval.guess;
    [([from, middle], [a, value]), ([middle, to], [value, b])].map(|(times, margins)| Interval {
        times,
        margins,
        guess: guess.filter(|guess| times[0] < *guess && *guess < times[1]),
    })
}

/// A root of a margin that decreases through zero on an interval, and the margin's rate there, by Halley's method within
/// a bracket. C and D are the bounds of the second and third derivative. A step s from a point with the rate r leaves an
/// error of at most `|s|³ (D / 3 |r| + (C / r)²)` if `C |s| < |r| / 2`.
#[inline(always)]
fn root<M: Margin + ?Sized>(
    margin: &mut M,
    bounds: MarginBounds,
    interval: Interval,
    counters: &mut Counters,
) -> (f64, f64) {
    let ([mut low, mut high], [a, b]) = (interval.times, interval.margins);
    let fine = f64::EPSILON * high;
    let mut time = match interval.guess {
        Some(guess) => guess,
        None => low + (high - low) * a / (a - b),
    };
    let mut last = 0.0;
    for _ in 0..MOST_STEPS {
        let [value, rate, bend] = margin.at(time);
        counters.newton_steps += 1;
        if value > 0.0 {
            low = time
        } else {
            high = time
        }
        let step = -value * rate / (rate * rate - 0.5 * value * bend);
        let next = time + step;
        let (size, slope, curvature) = (step.abs(), rate.abs(), bounds.curvature);
        let error = size * size * size * curvature * (slope * bounds.fastest / 3.0 + curvature);
        last = rate + bend * step;
        if curvature * size < 0.5 * slope && error <= fine * slope * slope {
            return (next.max(interval.times[0]).min(interval.times[1]), last);
        }
        time = if next > low && next < high { next } else { 0.5 * (low + high) };
        if high - low <= fine {
            break;
        }
    }
    (time, last)
}

/// Number of points of the interpolating polynomial.
pub const POINTS: usize = 9;

/// Number of equal parts of an interval. The polynomial is computed at the start of every part.
const PARTS: usize = 8;

/// Contribution of each value to the polynomial at the start of every part of every interval.
static AT_PARTS: [[Lanes; POINTS]; POINTS - 1] = {
    let mut all = [[Lanes::ZERO; POINTS]; POINTS - 1];
    let mut index = 0;
    while index < (POINTS - 1) * POINTS * PARTS {
        let (from, node, part) = (
            index / PARTS / POINTS,
            index / PARTS % POINTS,
            index % PARTS,
        );
        let x = from as f64 + part as f64 / PARTS as f64;
        let (mut product, mut other) = (1.0, 0);
        while other < POINTS {
            if other != node {
                product *= (x - other as f64) / (node as f64 - other as f64);
            }
            other += 1;
        }
        all[from][node].0[part] = product;
        index += 1;
    }
    all
};

/// Estimates the first change of sign, from positive to negative, of the polynomial through margins at 0, 1,
/// … between `from` and the next point, where it is negative. A root at `from` does not count. `None` if the
/// polynomial is not positive at the start of the part with the root.
#[inline(always)]
pub fn near_root<V: Vector>(values: &[f64; POINTS], from: usize) -> Option<f64> {
    let mut sums = [V::zero(); 2];
    for (node, shares) in AT_PARTS[from].iter().enumerate() {
        sums[node % 2] = V::read(&shares.0).multiply_add(V::splat(values[node]), sums[node % 2]);
    }
    let parts = sums[0].plus(sums[1]);
    let mut y = [0.0; PARTS + 1];
    parts.write(&mut y);
    (y[0], y[PARTS]) = (values[from], values[from + 1]);
    let negative = (parts.at_most(V::zero()) & !1) | 1 << PARTS;
    let end = negative.trailing_zeros() as usize;
    if y[end - 1] <= 0.0 {
        return None;
    }
    // The root of the cubic through four values, by one step of Halley's method from the chord.
    let first = (end.max(2) - 2).min(PARTS - 3);
    let [a, b, c, d] = [y[first], y[first + 1], y[first + 2], y[first + 3]];
    let [second, third] = [0.5 * (c - 2.0 * b + a), (d - a - 3.0 * (c - b)) / 6.0];
    let x = (end - 1 - first) as f64 + y[end - 1] / (y[end - 1] - y[end]);
    let value = a + x * (b - a + (x - 1.0) * (second + (x - 2.0) * third));
    let slope = b - a + (2.0 * x - 1.0) * second + (3.0 * x * x - 6.0 * x + 2.0) * third;
    let bend = 2.0 * second + 6.0 * (x - 1.0) * third;
    let root = x - value * slope / (slope * slope - 0.5 * value * bend);
    Some(from as f64 + (first as f64 + root) / PARTS as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::propagate::vectors::Packed;

    struct Function<F>(F);

    impl<F: Fn(f64) -> [f64; 3]> Margin for Function<F> {
        fn at(&mut self, time: f64) -> [f64; 3] {
            (self.0)(time)
        }

        fn with_run_time_dispatch(&mut self) -> &mut dyn Margin {
            self
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

    /// The dip `(t − a)(t − b)` is positive at both ends and negative between its roots. It is found for any
    /// distance of the roots.
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

    /// The search finds the first of three roots, although the values at the ends suggest only one.
    #[test]
    fn the_first_of_three_roots_is_taken() {
        let f = |t: f64| {
            let [x, y, z] = [0.2 - t, 0.5 - t, 0.9 - t];
            [x * y * z, -(x * y + y * z + z * x), 2.0 * (x + y + z)]
        };
        let (first, _) = found(f, 3.3);
        assert!((first.unwrap() - 0.2).abs() < 1e-15);
    }

    proptest::proptest! {
        /// The search finds the first root of a cubic on an interval for any guess, and no root if there is
        /// none.
        #[test]
        fn no_root_of_a_cubic_is_missed(
            roots in proptest::array::uniform3(-1.0..2.0_f64),
            slack in 1.0..3.0_f64,
            guess in proptest::option::of(0.0..1.0_f64),
        ) {
            let mut sorted = roots;
            sorted.sort_by(f64::total_cmp);
            let apart = |a: f64, b: f64| (a - b).abs() > 1e-4;
            let [x, y, z] = sorted;
            let clear = [x, y, z].iter().all(|root| apart(*root, 0.0) && apart(*root, 1.0));
            proptest::prop_assume!(clear && apart(x, y) && apart(y, z));
            let sign = -(x * y * z).signum();
            let f = |t: f64| {
                let [a, b, c] = [t - x, t - y, t - z];
                [a * b * c, a * b + b * c + c * a, 2.0 * (a + b + c)].map(|value| sign * value)
            };
            let curvature = slack * f(0.0)[2].abs().max(f(1.0)[2].abs());
            let own = Interval {
                times: [0.0, 1.0],
                margins: [f(0.0)[0], f(1.0)[0]],
                guess: guess.filter(|_| f(1.0)[0] < 0.0),
            };
            let bounds = MarginBounds { curvature, fastest: 6.0 / curvature, noise: 1e-15 };
            let first = exit(&mut Function(f), bounds, own, 0, &mut Counters::default());
            let expected = sorted.into_iter().find(|root| (0.0..1.0).contains(root));
            proptest::prop_assert_eq!(first.is_some(), expected.is_some());
            proptest::prop_assert!(first.zip(expected).is_none_or(|(a, b)| (a - b).abs() < 1e-9));
        }
    }

    /// The estimate of a root is near the root of a polynomial of fifth degree, for any interval.
    #[test]
    fn the_estimate_of_a_root_is_near_it() {
        for from in 0..POINTS - 1 {
            let at = from as f64 + 0.3;
            let f = |x: f64| (at - x) * (1.0 + 0.02 * x.powi(2) + 0.001 * x.powi(4));
            let values = std::array::from_fn(|i| f(i as f64));
            let x = near_root::<Packed>(&values, from).unwrap();
            assert!((x - at).abs() < 1e-4, "{from}: {x}");
        }
    }

    /// The root at the start of the block is no event; the next root is one.
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
