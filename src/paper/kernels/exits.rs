//! When does a margin first become negative? A guard gives δ, δ' and δ'' at any time.
//!
//! The margin m of a contact state is positive inside it. On an interval \[a, b\] with known values, slopes and
//! curvatures at both ends, and bounds of |m''| and |m'''|, certificates decide: no exit, or exactly one root. All
//! other intervals are halved, left half first, so that neither of two close roots is skipped. An interval that is
//! undecided within round-off is a tangency.

use crate::propagate::Counters;
use crate::propagate::events::Margin;

/// Largest number of successive halvings of an interval.
const DEEPEST: usize = 52;

/// The deflection at one time.
#[derive(Debug, Clone, Copy)]
pub struct DeflectionAt {
    /// Time since the start of the stretch \[s\].
    pub time: f64,
    /// δ \[m\], δ' \[m/s\] and δ'' \[m/s²\].
    pub deflection: [f64; 3],
}

/// Bounds over a stretch.
#[derive(Debug, Clone, Copy)]
pub struct Bounds {
    /// Bound of |δ''| \[m/s²\].
    pub second: f64,
    /// Bound of |δ'''| \[m/s³\].
    pub third: f64,
    /// Round-off of δ \[m\].
    pub noise: f64,
}

/// A margin at one time.
#[derive(Debug, Clone, Copy)]
pub struct MarginAt {
    /// Time since the start of the stretch \[s\].
    pub time: f64,
    /// Margin \[m\].
    pub value: f64,
    /// Rate of the margin \[m/s\].
    pub slope: f64,
    /// Second derivative of the margin \[m/s²\].
    pub curvature: f64,
}

impl MarginAt {
    /// Margin, slope and curvature at a known deflection.
    pub fn of(margin: &Margin, here: &DeflectionAt) -> Self {
        let [value, slope, curvature] = here.deflection;
        Self {
            time: here.time,
            value: margin.scale * value + margin.shift,
            slope: margin.scale * slope,
            curvature: margin.scale * curvature,
        }
    }
}

/// Result of a certificate on an interval.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The margin stays positive.
    Clear,
    /// The margin becomes negative at the interval's start.
    AtStart,
    /// The margin becomes negative at exactly one time inside the interval.
    Single,
    /// The margin is within round-off of zero on the whole interval: a tangency.
    Tangency,
    /// Undecided: the interval must be halved.
    Split,
}

/// The verdict on the interval between two times; `starts_at_root`: the margin is zero at the first.
pub fn judge(a: &MarginAt, b: &MarginAt, bounds: &Bounds, starts_at_root: bool) -> Verdict {
    let h = b.time - a.time;
    let around = a.curvature.abs().max(b.curvature.abs()) + 0.5 * bounds.third * h;
    let bend = around.min(bounds.second);
    let highest = (a.curvature.max(b.curvature) + 0.5 * bounds.third * h).min(bounds.second);
    let concave = highest < 0.0;
    let sag = 0.125 * bend * h * h;
    let starts_at_root = starts_at_root || a.value.abs() <= bounds.noise;
    if starts_at_root {
        let steepest = 0.5 * (a.slope + b.slope + bend * h);
        if a.slope > 0.0 && (a.slope > 0.5 * bend * h || (concave && b.value > bounds.noise)) {
            return Verdict::Clear;
        }
        if a.slope > 0.0 && concave && b.value < -bounds.noise {
            return Verdict::Single;
        }
        if steepest < 0.0 && b.value < -bounds.noise {
            return Verdict::AtStart;
        }
        if a.slope.abs() * h + 0.5 * bend * h * h <= bounds.noise {
            return Verdict::Tangency;
        }
        return Verdict::Split;
    }
    if a.value < 0.0 {
        return Verdict::AtStart;
    }
    let middle = 0.5 * (a.slope + b.slope);
    let turn = 0.5 * bend * h;
    if b.value >= 0.0 {
        let lowest = a.value.min(b.value);
        if lowest > sag || concave || middle.abs() > turn {
            return Verdict::Clear;
        }
        if a.value.max(b.value) + sag <= bounds.noise {
            return Verdict::Tangency;
        }
    } else if middle + turn < 0.0 || concave {
        return Verdict::Single;
    }
    Verdict::Split
}

/// The earliest time at which the margin becomes negative between two times; `None` if it does not. `guard` returns δ,
/// δ', δ'' at any time in between; `starts_at_root`: the margin is zero at the first.
pub fn earliest_exit(
    margin: &Margin,
    [first, last]: [&DeflectionAt; 2],
    bounds: &Bounds,
    mut starts_at_root: bool,
    guard: &mut impl FnMut(f64) -> [f64; 3],
    counters: &mut Counters,
) -> Option<f64> {
    let mut left = MarginAt::of(margin, first);
    let mut pending = [left; DEEPEST];
    pending[0] = MarginAt::of(margin, last);
    let mut depth = 1;
    while depth > 0 {
        let right = pending[depth - 1];
        let middle = 0.5 * (left.time + right.time);
        match judge(&left, &right, bounds, starts_at_root) {
            Verdict::AtStart => return Some(left.time),
            Verdict::Single => {
                return Some(refine(margin, &left, &right, bounds, guard, counters));
            }
            Verdict::Split if depth < DEEPEST && left.time < middle && middle < right.time => {
                counters.bisections += 1;
                let here = DeflectionAt {
                    time: middle,
                    deflection: guard(middle),
                };
                pending[depth] = MarginAt::of(margin, &here);
                depth += 1;
                continue;
            }
            Verdict::Clear => {}
            Verdict::Tangency | Verdict::Split => counters.grazings += 1,
        }
        (left, starts_at_root) = (right, false);
        depth -= 1;
    }
    None
}

/// Largest number of steps of the iteration, enough for bisection alone.
const MOST_STEPS: usize = 60;

/// A step this small, relative to the interval and to slope over curvature, ends the iteration: the error is of the
/// order of its cube.
const LAST_STEP: f64 = 1e-6;

/// The one root between two times, the margin positive just after the first and negative at the second: Halley's
/// iteration within the bracket.
fn refine(
    margin: &Margin,
    left: &MarginAt,
    right: &MarginAt,
    bounds: &Bounds,
    guard: &mut impl FnMut(f64) -> [f64; 3],
    counters: &mut Counters,
) -> f64 {
    let (mut low, mut high) = (left.time, right.time);
    let mut time = hermite_root(left, right);
    for _ in 0..MOST_STEPS {
        counters.newton_steps += 1;
        let place = MarginAt::of(
            margin,
            &DeflectionAt {
                time,
                deflection: guard(time),
            },
        );
        if place.value > 0.0 {
            low = time;
        } else {
            high = time;
        }
        let (m, s, c) = (place.value, place.slope, place.curvature);
        let step = 2.0 * m * s / (2.0 * s * s - m * c);
        let next = time - step;
        if !(low <= next && next <= high) {
            if high - low <= f64::EPSILON * high || m.abs() <= f64::EPSILON * bounds.noise {
                return time;
            }
            time = 0.5 * (low + high);
            continue;
        }
        let short = LAST_STEP * (right.time - left.time).min(s.abs() / c.abs());
        if step.abs() <= short || next == time {
            return next;
        }
        time = next;
    }
    time
}

/// A root of the cubic through values and slopes at two times, between them.
pub fn hermite_root(a: &MarginAt, b: &MarginAt) -> f64 {
    let h = b.time - a.time;
    let (p, q) = (h * a.slope, h * b.slope);
    let rise = b.value - a.value;
    let cubic = |x: f64| {
        let (c2, c3) = (3.0 * rise - 2.0 * p - q, p + q - 2.0 * rise);
        (
            a.value + x * (p + x * (c2 + x * c3)),
            p + x * (2.0 * c2 + x * 3.0 * c3),
        )
    };
    let (mut low, mut high) = (0.0, 1.0);
    let mut x = if rise < 0.0 && a.value > 0.0 {
        (-a.value / rise).clamp(0.0, 1.0)
    } else {
        0.5
    };
    for _ in 0..8 {
        let (value, slope) = cubic(x);
        if value > 0.0 {
            low = x;
        } else {
            high = x;
        }
        let next = x - value / slope;
        x = if next >= low && next <= high { next } else { 0.5 * (low + high) };
    }
    a.time + h * x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::COAST_FLANK;
    use crate::numerics::random::Stream;

    fn exit(f: impl Fn(f64) -> [f64; 3], bounds: [f64; 3], root: bool) -> (Option<f64>, Counters) {
        let mut counters = Counters::default();
        let here = |time| DeflectionAt {
            time,
            deflection: f(time),
        };
        let [second, third, noise] = bounds;
        let bounds = Bounds {
            second,
            third,
            noise,
        };
        let margin = Margin {
            contact: COAST_FLANK,
            closed: true,
            scale: 1.0,
            shift: 0.0,
        };
        let ends = [&here(0.0), &here(1.0)];
        let found = earliest_exit(&margin, ends, &bounds, root, &mut |t| f(t), &mut counters);
        (found, counters)
    }

    fn wave(w: f64, level: f64) -> impl Fn(f64) -> [f64; 3] {
        move |t: f64| {
            let (s, c) = (w * t + 0.3).sin_cos();
            [level + c, -w * s, -w * w * c]
        }
    }

    #[test]
    fn the_first_of_many_roots_is_found() {
        for w in [0.5, 3.0, 40.0, 400.0] {
            for level in [0.0, 0.5, 0.9, 0.999999] {
                let f = wave(w, level);
                let (found, _) = exit(&f, [w * w, w * w * w, 1e-15], false);
                let exact = ((-level).acos() - 0.3) / w;
                match found {
                    Some(t) => assert!(
                        (t - exact).abs() < 1e-12 * w.recip().max(1.0),
                        "{w} {level} {t}"
                    ),
                    None => assert!(exact > 1.0),
                }
            }
        }
    }

    /// Two roots 10⁻⁷ apart between ends where the margin is large.
    #[test]
    fn a_short_excursion_is_not_skipped() {
        let f = |t: f64| [(t - 0.4) * (t - 0.4 - 1e-7), 2.0 * (t - 0.4) - 1e-7, 2.0];
        let (found, _) = exit(f, [2.0, 0.0, 1e-18], false);
        assert!((found.unwrap() - 0.4).abs() < 1e-10);
        let g = |t: f64| [(t - 0.4) * (t - 0.4), 2.0 * (t - 0.4), 2.0];
        let (found, counters) = exit(g, [2.0, 0.0, 1e-14], false);
        assert!(found.is_none() && counters.grazings > 0);
    }

    /// The root at the start is not found again. The next root is found at any distance.
    #[test]
    fn the_root_at_the_start_is_left_behind() {
        for gap in [1e-6, 1e-3, 0.3] {
            let f = |t: f64| [t * (gap - t), gap - 2.0 * t, -2.0];
            let (found, _) = exit(f, [2.0, 0.0, 1e-16], true);
            assert!(
                (found.unwrap() - gap).abs() < 1e-12 * gap.max(1e-3),
                "{found:?}"
            );
        }
        let f = |t: f64| [t * (t + 0.1), 2.0 * t + 0.1, 2.0];
        assert_eq!(exit(f, [2.0, 0.0, 1e-16], true).0, None);
        let f = |t: f64| [-t, -1.0, 0.0];
        assert_eq!(exit(f, [0.0, 0.0, 1e-16], true).0, Some(0.0));
    }

    /// A cubic margin with its bounds on \[0, 1\].
    fn cubic([value, slope, bend, jerk]: [f64; 4]) -> (impl Fn(f64) -> MarginAt, Bounds) {
        let at = move |t: f64| MarginAt {
            time: t,
            value: value + t * (slope + t * (bend / 2.0 + t * jerk / 6.0)),
            slope: slope + t * (bend + t * jerk / 2.0),
            curvature: bend + t * jerk,
        };
        let bounds = Bounds {
            second: bend.abs().max((bend + jerk).abs()),
            third: jerk.abs(),
            noise: 1e-12,
        };
        (at, bounds)
    }

    /// Verdicts on cubics, which can be checked exactly, are true.
    #[test]
    fn verdicts_on_cubics_are_true() {
        let mut stream = Stream::new(3, 0, 0);
        let mut verdicts = [0; 5];
        for turn in 0..6000 {
            let root = turn % 3 == 0;
            let mut margin = [0; 4].map(|_| stream.normal());
            margin[0] = if root { 0.0 } else { margin[0] + 1.0 };
            // Some margins are nearly straight, some nearly parabolas.
            margin[2] *= [4.0, 1.0, 0.1][turn / 3 % 3];
            margin[3] *= [4.0, 0.1][turn / 9 % 2];
            let (at, bounds) = cubic(margin);
            let verdict = judge(&at(0.0), &at(1.0), &bounds, root);
            // After a root the slope decides what comes first.
            let first = if root { margin[1] } else { margin[0] };
            let later = (1..=500).map(|i| at(f64::from(i) / 500.0).value);
            let course: Vec<f64> = std::iter::once(first).chain(later).collect();
            let exits = (course.windows(2))
                .filter(|w| w[0] > 0.0 && w[1] < 0.0)
                .count();
            let entries = (course.windows(2))
                .filter(|w| w[0] < 0.0 && w[1] > 0.0)
                .count();
            match verdict {
                Verdict::Clear => assert!(course.iter().all(|m| *m > -1e-9), "{margin:?}"),
                Verdict::AtStart => {
                    let falls = course.iter().all(|m| *m < 0.0);
                    assert!(margin[0] < 0.0 || (root && falls), "{margin:?}");
                }
                Verdict::Single => {
                    assert_eq!((exits, entries), (1, 0), "{margin:?}");
                    assert!(margin[0] > 0.0 || root && margin[1] > 0.0, "{margin:?}");
                }
                Verdict::Tangency => assert!(course.iter().all(|m| m.abs() < 1e-11), "{margin:?}"),
                Verdict::Split => {}
            }
            verdicts[verdict as usize] += 1;
        }
        // Most margins are decided without halving.
        assert!(verdicts[Verdict::Split as usize] < 3000, "{verdicts:?}");
    }

    /// Straight lines and simple parabolas need no halving.
    #[test]
    fn plain_courses_are_decided_at_once() {
        for (margin, root, expected) in [
            ([0.5, 1.0, 0.0, 0.0], false, Verdict::Clear),
            ([0.5, -0.4, 0.0, 0.0], false, Verdict::Clear),
            ([0.5, -1.0, 0.0, 0.0], false, Verdict::Single),
            ([-0.5, 1.0, 0.0, 0.0], false, Verdict::AtStart),
            ([0.0, 1.0, 0.0, 0.0], true, Verdict::Clear),
            ([0.0, -1.0, 0.0, 0.0], true, Verdict::AtStart),
            // A value within round-off of zero counts as a root.
            ([1e-13, 1.0, 0.0, 0.0], false, Verdict::Clear),
            // Arches that stay above zero or return through zero; then the same from a root; then one that falls.
            ([1.0, 2.0, -4.0, 0.0], false, Verdict::Clear),
            ([1.0, 2.0, -8.0, 0.0], false, Verdict::Single),
            ([0.0, 2.0, -3.0, 0.0], true, Verdict::Clear),
            ([0.0, 2.0, -8.0, 0.0], true, Verdict::Single),
            ([0.0, 0.1, -0.3, 0.0], true, Verdict::Single),
            ([0.0, -1.0, -2.0, 0.0], true, Verdict::AtStart),
            // Valleys: with a minimum above zero, falling throughout, undecided.
            ([2.0, -2.0, 4.0, 0.0], false, Verdict::Clear),
            ([1.0, -6.0, 4.0, 0.0], false, Verdict::Single),
            ([0.2, -2.0, 4.0, 0.0], false, Verdict::Split),
            ([0.0, -2.0, 4.0, 0.0], true, Verdict::Split),
            ([0.0, 1e-15, 1e-14, 0.0], true, Verdict::Tangency),
            ([1e-13, 0.0, 0.0, 0.0], false, Verdict::Tangency),
        ] {
            let (at, bounds) = cubic(margin);
            let found = judge(&at(0.0), &at(1.0), &bounds, root);
            assert_eq!(found, expected, "{margin:?}");
        }
    }
}
