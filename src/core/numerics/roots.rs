//! Where does a Legendre series first become negative, and where does it change its sign? A margin is a
//! series that is positive as long as a contact keeps its state.
//!
//! Sufficient conditions, called certificates, make the search safe. If `|a[0]| > Σ_{n≥1}|a[n]|` there is no
//! root. If the series of the derivative satisfies this condition, there is at most one root. Otherwise the
//! interval is halved, and the left half is searched first, so that neither of two close roots is skipped. If
//! all values on an undecided part are round-off, the part counts as a tangency.

use super::arithmetic::{Arithmetic, Bounds, Portable};
use super::legendre::{self, SAMPLES, Transforms, sample_place};

/// Result of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Search {
    /// Position in \[−1, limit\] where the margin becomes negative; `None` if it does not.
    pub exit: Option<f64>,
    /// Number of tangencies before the exit.
    pub grazings: u32,
    /// Whether the first check decided that there is no exit.
    pub certified: bool,
    /// Number of bisections.
    pub bisections: u32,
    /// Number of steps of Halley's iteration.
    pub newton_steps: u32,
}

/// Largest number of successive halvings: a sub-interval of 2⁻⁵⁰ windows is below the resolution of time.
const DEEPEST: u32 = 50;

impl Search {
    /// Nothing found, no work.
    const NONE: Self = Self {
        exit: None,
        grazings: 0,
        certified: false,
        bisections: 0,
        newton_steps: 0,
    };
}

/// Finds the earliest x in \[−1, `limit`\] at which `margin` changes from non-negative to negative. Values
/// within `noise` of zero are round-off.
///
/// If the margin is already negative at its start, the exit is at x = −1. This requires a value below
/// `−noise`, or a falling margin and a value from `−noise` to 0.
#[inline(always)]
pub fn earliest_exit<const P: usize, A: Arithmetic<P>>(
    transforms: &Transforms<P>,
    margin: &[f64; P],
    limit: f64,
    noise: f64,
) -> Search {
    let mut search = Search::NONE;
    let bounds = A::bounds(margin);
    if margin[0] > bounds.variation + noise {
        search.certified = true;
        return search;
    }
    if bounds.start < -noise {
        search.exit = Some(-1.0);
        return search;
    }
    match decide::<P, A>(transforms, margin, bounds, noise, 0, &mut search) {
        Verdict::Clear => {}
        Verdict::Exit(x) => search.exit = Some(x),
        Verdict::Undecided => {
            let whole = Interval {
                start: -1.0,
                length: 2.0,
                depth: 0,
            };
            search.bisections += 1;
            for side in 0..2 {
                let part = whole.half(side);
                let series = A::half(transforms, margin, side);
                search.exit = match examine::<P, A>(transforms, &series, noise, 1, &mut search) {
                    Verdict::Clear => None,
                    Verdict::Exit(x) => Some(part.place(x)),
                    Verdict::Undecided => {
                        halve(transforms, &series, part, limit, noise, &mut search)
                    }
                };
                if search.exit.is_some() {
                    break;
                }
            }
        }
    }
    search.exit = search.exit.filter(|x| *x <= limit);
    search
}

/// As [`earliest_exit`], for a margin that falls everywhere and whose start is not negative beyond noise.
#[inline(always)]
pub fn exit_of_falling<const P: usize, A: Arithmetic<P>>(
    transforms: &Transforms<P>,
    margin: &[f64; P],
    limit: f64,
) -> Search {
    let mut search = Search::NONE;
    let bounds = A::bounds(margin);
    if bounds.end < 0.0 {
        let root = bracketed_root::<P, A>(transforms, margin, bounds, &mut search.newton_steps);
        search.exit = Some(root).filter(|x| *x <= limit);
    } else {
        search.certified = true;
    }
    search
}

/// A part of \[−1, 1\].
#[derive(Debug, Clone, Copy)]
struct Interval {
    start: f64,
    length: f64,
    depth: u32,
}

impl Interval {
    fn half(self, side: usize) -> Self {
        let length = 0.5 * self.length;
        Self {
            start: self.start + side as f64 * length,
            length,
            depth: self.depth + 1,
        }
    }

    /// Position in the whole interval of the position x ∈ \[−1, 1\] of the part.
    fn place(self, x: f64) -> f64 {
        self.start + 0.5 * self.length * (x + 1.0)
    }
}

/// Decision on a series over its interval.
enum Verdict {
    /// No exit.
    Clear,
    /// Exit at this position of the interval.
    Exit(f64),
    /// No certificate decides.
    Undecided,
}

#[inline(always)]
fn examine<const P: usize, A: Arithmetic<P>>(
    transforms: &Transforms<P>,
    series: &[f64; P],
    noise: f64,
    depth: u32,
    search: &mut Search,
) -> Verdict {
    let bounds = A::bounds(series);
    if series[0] > bounds.variation + noise {
        return Verdict::Clear;
    }
    decide::<P, A>(transforms, series, bounds, noise, depth, search)
}

/// Decides by the derivative, the size and the depth of a series whose first certificate does not decide.
#[inline(always)]
fn decide<const P: usize, A: Arithmetic<P>>(
    transforms: &Transforms<P>,
    series: &[f64; P],
    bounds: Bounds,
    noise: f64,
    depth: u32,
    search: &mut Search,
) -> Verdict {
    let slope = A::derivative(transforms, series);
    let slopes = A::bounds(&slope);
    if slope[0].abs() > slopes.variation {
        return if slope[0] < 0.0 && bounds.end < 0.0 {
            let steps = &mut search.newton_steps;
            Verdict::Exit(bracketed_root::<P, A>(transforms, series, bounds, steps))
        } else {
            Verdict::Clear
        };
    }
    if series[0].abs() + bounds.variation <= noise || depth == DEEPEST {
        search.grazings += 1;
        return Verdict::Clear;
    }
    Verdict::Undecided
}

/// Examines the halves of an undecided part, the left half first. It is rarely called, so that the portable
/// arithmetic is fast enough.
#[cold]
fn halve<const P: usize>(
    transforms: &Transforms<P>,
    series: &[f64; P],
    whole: Interval,
    limit: f64,
    noise: f64,
    search: &mut Search,
) -> Option<f64> {
    search.bisections += 1;
    for side in 0..2 {
        let part = whole.half(side);
        if part.start >= limit {
            return None;
        }
        let series = transforms.half(series, side);
        let exit = match examine::<P, Portable>(transforms, &series, noise, part.depth, search) {
            Verdict::Clear => None,
            Verdict::Exit(x) => Some(part.place(x)),
            Verdict::Undecided => halve(transforms, &series, part, limit, noise, search),
        };
        if exit.is_some() {
            return exit;
        }
    }
    None
}

/// Passes every position in \[−1, 1\] where a series changes its sign to `visit`, in ascending order, and
/// whether the series rises there.
///
/// `positive` is the last sign, `None` before the first series. It is kept from one series to the next, so
/// that a change at the joint of two series is found once. Values within `noise` of zero have no sign: a
/// touch without a crossing is no change.
pub fn sign_changes<const P: usize>(
    transforms: &Transforms<P>,
    series: &[f64; P],
    noise: f64,
    positive: &mut Option<bool>,
    mut visit: impl FnMut(f64, bool),
) {
    let mut meet = |value: f64, x: f64| {
        if value.abs() > noise {
            let sign = value > 0.0;
            if positive.replace(sign).is_some_and(|before| before != sign) {
                visit(x, sign);
            }
        }
    };
    let whole = Interval {
        start: -1.0,
        length: 2.0,
        depth: 0,
    };
    meet_signs(transforms, series, whole, noise, &mut meet);
}

/// Passes values of a series with reliable signs to `meet`, from left to right over a part, each with its
/// position.
fn meet_signs<const P: usize>(
    transforms: &Transforms<P>,
    series: &[f64; P],
    part: Interval,
    noise: f64,
    meet: &mut impl FnMut(f64, f64),
) {
    let variation = legendre::variation(series);
    if series[0].abs() > variation + noise {
        meet(series[0], part.start);
        return;
    }
    let slope = legendre::derivative(series);
    if slope[0].abs() > legendre::variation(&slope) {
        let (start, end) = (legendre::at_start(series), legendre::at_end(series));
        meet(start, part.start);
        let x = if start * end < 0.0 {
            let falling = if slope[0] < 0.0 { 1.0 } else { -1.0 };
            let series = series.map(|a| falling * a);
            bracketed_root::<P, Portable>(transforms, &series, Portable::bounds(&series), &mut 0)
        } else {
            -1.0
        };
        meet(end, part.place(x));
        return;
    }
    if series[0].abs() + variation <= noise || part.depth == DEEPEST {
        return;
    }
    for side in 0..2 {
        let half = transforms.half(series, side);
        meet_signs(transforms, &half, part.half(side), noise, meet);
    }
}

/// The root of a falling series whose value at its end is not positive; −1 if its start is not positive.
///
/// The method is Halley's iteration within a bracket. After a small step with little curvature the error is
/// far below round-off, so that no further step is needed to confirm convergence.
#[inline(always)]
fn bracketed_root<const P: usize, A: Arithmetic<P>>(
    transforms: &Transforms<P>,
    series: &[f64; P],
    bounds: Bounds,
    steps: &mut u32,
) -> f64 {
    if bounds.start <= 0.0 {
        return -1.0;
    }
    let [mut x, mut lo, mut hi] = place_of_zero::<P, A>(transforms, series);
    for _ in 0..60 {
        *steps += 1;
        let [value, slope, curvature] = A::derivatives_at(series, x);
        if value > 0.0 {
            lo = x;
        } else {
            hi = x;
        }
        // Halley's step with one division. Newton's step is value / slope; bend / slope² is the relative
        // effect of curvature on it.
        let (bend, square) = (0.5 * value * curvature, slope * slope);
        let mut next = x - value * slope / (square - bend);
        let small = value.abs() < SMALL_STEP * slope.abs() && bend.abs() < SMALL_STEP * square;
        if !(next >= lo && next <= hi) {
            next = 0.5 * (lo + hi);
        } else if small {
            return next;
        }
        if (next - x).abs() <= f64::EPSILON {
            return next;
        }
        x = next;
    }
    x
}

/// An estimate of the root of a falling series, and the positions of the two samples around it. The estimate
/// is from the cubic through four samples, which gives the position as a function of the value.
#[inline(always)]
fn place_of_zero<const P: usize, A: Arithmetic<P>>(
    transforms: &Transforms<P>,
    series: &[f64; P],
) -> [f64; 3] {
    let values = A::samples(transforms, series);
    let positive: usize = values.iter().map(|v| usize::from(*v > 0.0)).sum();
    // By round-off the signs of the ends may differ from those of the samples there.
    let after = positive.clamp(1, SAMPLES - 1);
    let (lo, hi) = (sample_place(after - 1), sample_place(after));
    let first = after.saturating_sub(2).min(SAMPLES - 4);
    let y: [f64; 4] = std::array::from_fn(|i| values[first + i]);
    let others = |i: usize, of: &dyn Fn(usize) -> f64| -> f64 {
        (0..4).filter(|j| *j != i).map(of).product()
    };
    // Lagrange interpolation at the value zero, in steps between samples.
    let steps: f64 = (1..4)
        .map(|i| i as f64 * others(i, &|j| y[j]) / others(i, &|j| y[j] - y[i]))
        .sum();
    let step = sample_place(1) - sample_place(0);
    let x = sample_place(first) + step * steps;
    let inside = x > lo && x < hi;
    [if inside { x } else { 0.5 * (lo + hi) }, lo, hi]
}

/// The error of Halley's iteration is of third order. After a step in x below this, with a relative effect of
/// curvature below this, the error is a fraction of round-off.
const SMALL_STEP: f64 = 4e-6;

#[cfg(test)]
mod tests;
