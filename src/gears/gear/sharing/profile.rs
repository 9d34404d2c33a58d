//! How deep do pairs press at every position of a face? The gaps are linear on each slice; waves of displacement
//! reduce the depth.
//!
//! Positions are `t = z/b + ½`. The depth of a pair at t is `x − g(t) − Σ d_n φ_n(t)`. The pair is in contact
//! where the depth is positive.

use std::f64::consts::{PI, SQRT_2};

/// Cells of the face per half of the shortest wavelength. With four, few depths have more than one extreme in a cell.
const CELLS_PER_WAVE: usize = 4;

/// Largest number of steps of the search for a border of contact.
const MOST_STEPS: usize = 60;

/// A part of the face, within 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Interval {
    from: f64,
    to: f64,
}

impl Interval {
    pub const WHOLE: Self = Self { from: 0.0, to: 1.0 };

    pub fn length(&self) -> f64 {
        self.to - self.from
    }
}

/// The gaps of pairs along a face.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct GapProfile {
    /// Number of cells per slice.
    cells: usize,
    waves: usize,
    borders: Vec<FacePoint>,
    /// Gaps at the borders of cells, pair by pair \[m\].
    gaps: Vec<Vec<f64>>,
}

/// A position with `cos nπt` and `sin nπt` there.
#[derive(Debug, Clone, PartialEq)]
struct FacePoint {
    at: f64,
    cosines: Vec<f64>,
    sines: Vec<f64>,
}

impl FacePoint {
    fn new(at: f64, waves: usize) -> Self {
        let (cosines, sines) = waves_at(at, waves);
        Self { at, cosines, sines }
    }
}

/// Depth of a pair without its gap: `x − Σ a_n cos nπt`, with the slope `Σ nπ a_n sin nπt`.
#[derive(Debug, Clone)]
pub(super) struct Approach {
    approach: f64,
    cosines: Vec<f64>,
    sines: Vec<f64>,
}

impl Approach {
    /// From an approach \[m\] and waves d_n of displacement \[m\].
    pub fn new(approach: f64, waves: &[f64]) -> Self {
        let amplitude = |n: usize| if n == 0 { waves[0] } else { SQRT_2 * waves[n] };
        Self {
            approach,
            cosines: (0..waves.len()).map(amplitude).collect(),
            sines: (0..waves.len())
                .map(|n| n as f64 * PI * amplitude(n))
                .collect(),
        }
    }

    fn value(&self, cosines: &[f64]) -> f64 {
        let waves = self.cosines.iter().zip(cosines);
        self.approach - waves.map(|(a, cosine)| a * cosine).sum::<f64>()
    }

    fn slope(&self, sines: &[f64]) -> f64 {
        let waves = self.sines.iter().zip(sines);
        waves.map(|(a, sine)| a * sine).sum()
    }

    fn wave_sum(&self, cosines: &[f64]) -> f64 {
        let waves = self.sines.iter().zip(cosines).enumerate();
        waves
            .map(|(n, (a, cosine))| n as f64 * PI * a * cosine)
            .sum()
    }
}

/// `cos nπt` and `sin nπt` for n below `count`.
fn waves_at(place: f64, count: usize) -> (Vec<f64>, Vec<f64>) {
    let (sin, cos) = (PI * place).sin_cos();
    let (mut cosines, mut sines) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let [mut c, mut s] = [1.0, 0.0];
    for _ in 0..count {
        cosines.push(c);
        sines.push(s);
        (c, s) = (c * cos - s * sin, s * cos + c * sin);
    }
    (cosines, sines)
}

/// `∫ cos pπt dt` over intervals, for p below `count`.
pub(super) fn integrals(intervals: &[Interval], count: usize) -> Vec<f64> {
    let mut sums = vec![0.0; count];
    for interval in intervals {
        sums[0] += interval.length();
        for (place, sign) in [(interval.to, 1.0), (interval.from, -1.0)] {
            let (_, sines) = waves_at(place, count);
            for (p, (sum, sine)) in sums.iter_mut().zip(&sines).enumerate().skip(1) {
                *sum += sign * sine / (p as f64 * PI);
            }
        }
    }
    sums
}

impl GapProfile {
    /// Gaps \[m\] at the borders of equal slices, pair by pair, with `waves` waves.
    pub fn new(gaps: Vec<Vec<f64>>, waves: usize) -> Self {
        let slices = gaps[0].len() - 1;
        let cells = (CELLS_PER_WAVE * waves).div_ceil(slices);
        let count = slices * cells;
        let borders = (0..=count)
            .map(|index| FacePoint::new(index as f64 / count as f64, waves))
            .collect();
        let refined = |gap: Vec<f64>| -> Vec<f64> {
            let at = |index: usize| {
                let (slice, cell) = (index / cells, index % cells);
                let part = cell as f64 / cells as f64;
                match cell {
                    0 => gap[slice],
                    _ => gap[slice] + part * (gap[slice + 1] - gap[slice]),
                }
            };
            (0..=count).map(at).collect()
        };
        Self {
            cells,
            waves,
            borders,
            gaps: gaps.into_iter().map(refined).collect(),
        }
    }

    /// Depth of a pair at the border of a slice \[m\].
    pub fn at_border(&self, pair: usize, border: usize, press: &Approach) -> f64 {
        let index = border * self.cells;
        press.value(&self.borders[index].cosines) - self.gaps[pair][index]
    }

    /// Largest depth of a pair \[m\].
    pub fn largest_depth(&self, pair: usize, press: &Approach) -> f64 {
        let mut most = f64::NEG_INFINITY;
        self.walk(pair, press, |_, [from, to]| {
            most = most.max(from.1).max(to.1);
        });
        most
    }

    /// The intervals in which a pair is in contact.
    pub fn touching(&self, pair: usize, press: &Approach) -> Vec<Interval> {
        let mut intervals: Vec<Interval> = Vec::new();
        let mut add = |from: f64, to: f64| match intervals.last_mut() {
            Some(last) if last.to == from => last.to = to,
            _ => intervals.push(Interval { from, to }),
        };
        self.walk(pair, press, |cell, [(from, at_from), (to, at_to)]| {
            let into = at_from > 0.0;
            if into && at_to > 0.0 {
                add(from, to);
            } else if into || at_to > 0.0 {
                let depth = |t: f64| {
                    let (cosines, sines) = waves_at(t, self.waves);
                    let depth = press.value(&cosines) - self.gap(pair, cell, t);
                    [depth, press.slope(&sines) - self.gap_slope(pair, cell)]
                };
                let border = root([from, to], at_from, &depth);
                if into {
                    add(from, border);
                } else {
                    add(border, to);
                }
            }
        });
        intervals.retain(|interval| interval.to > interval.from);
        intervals
    }

    /// Calls `stretch` for every part of the face with a monotone depth, with its cell and
    /// the positions and depths of its ends.
    fn walk(&self, pair: usize, press: &Approach, mut stretch: impl FnMut(usize, [(f64, f64); 2])) {
        let gaps = &self.gaps[pair];
        let at = |border: usize| {
            let place = &self.borders[border];
            let depth = press.value(&place.cosines) - gaps[border];
            ((place.at, depth), press.slope(&place.sines))
        };
        let (mut from, mut slope) = at(0);
        for cell in 0..self.borders.len() - 1 {
            let (to, next) = at(cell + 1);
            let rise = self.gap_slope(pair, cell);
            if (slope > rise) == (next > rise) {
                stretch(cell, [from, to]);
            } else {
                let turning = |t: f64| {
                    let (cosines, sines) = waves_at(t, self.waves);
                    [press.slope(&sines) - rise, press.wave_sum(&cosines)]
                };
                let place = root([from.0, to.0], slope - rise, &turning);
                let (cosines, _) = waves_at(place, self.waves);
                let turn = (place, press.value(&cosines) - self.gap(pair, cell, place));
                stretch(cell, [from, turn]);
                stretch(cell, [turn, to]);
            }
            (from, slope) = (to, next);
        }
    }

    /// `∫ g cos nπt dt` over intervals, by parts: on every slice the gap has a constant slope.
    pub fn gap_waves(&self, pair: usize, intervals: &[Interval]) -> Vec<f64> {
        let mut sums = vec![0.0; self.waves];
        for interval in intervals {
            self.on_slices(interval, |slice, from, to| {
                let cell = slice * self.cells;
                let [low, high] = [from, to].map(|place| self.gap(pair, cell, place.at));
                let rise = self.gap_slope(pair, cell);
                sums[0] += 0.5 * (low + high) * (to.at - from.at);
                for (n, sum) in sums.iter_mut().enumerate().skip(1) {
                    let number = n as f64 * PI;
                    let ends = high * to.sines[n] - low * from.sines[n];
                    *sum += (ends + rise * (to.cosines[n] - from.cosines[n]) / number) / number;
                }
            });
        }
        sums
    }

    /// `∫ p dt` on each slice and `∫ (t − ½) p dt` on the face, with the depth p of a pair in
    /// contact \[m\].
    pub fn sums(&self, pair: usize, intervals: &[Interval], press: &Approach) -> (Vec<f64>, f64) {
        let mut slices = vec![0.0; (self.borders.len() - 1) / self.cells];
        let mut first = 0.0;
        for interval in intervals {
            self.on_slices(interval, |slice, from, to| {
                // Without the waves p is linear, and a parabola times t − ½: Simpson's rule is exact.
                let linear_depth = |t: f64| {
                    press.approach - press.cosines[0] - self.gap(pair, slice * self.cells, t)
                };
                let [a, b, c] = [from.at, 0.5 * (from.at + to.at), to.at]
                    .map(|t| [linear_depth(t), (t - 0.5) * linear_depth(t)]);
                let simpson =
                    |order: usize| (to.at - from.at) / 6.0 * (a[order] + 4.0 * b[order] + c[order]);
                slices[slice] += simpson(0);
                first += simpson(1);
                for (n, wave) in press.cosines.iter().enumerate().skip(1) {
                    let number = n as f64 * PI;
                    let wave = wave / number;
                    slices[slice] -= wave * (to.sines[n] - from.sines[n]);
                    let levers = (to.at - 0.5) * to.sines[n] - (from.at - 0.5) * from.sines[n];
                    first -= wave * (levers + (to.cosines[n] - from.cosines[n]) / number);
                }
            });
        }
        (slices, first)
    }

    /// Calls `part` for the parts of an interval on slices, with their ends.
    fn on_slices(&self, interval: &Interval, mut part: impl FnMut(usize, &FacePoint, &FacePoint)) {
        let slices = (self.borders.len() - 1) / self.cells;
        let ends = [interval.from, interval.to].map(|end| FacePoint::new(end, self.waves));
        let first = ((interval.from * slices as f64) as usize).saturating_sub(1);
        for slice in first..slices {
            let [start, end] = [slice, slice + 1].map(|border| &self.borders[border * self.cells]);
            if start.at >= interval.to {
                break;
            }
            let from = if start.at >= interval.from { start } else { &ends[0] };
            let to = if end.at <= interval.to { end } else { &ends[1] };
            if from.at < to.at {
                part(slice, from, to);
            }
        }
    }

    /// Derivative of a gap on a cell \[m\].
    fn gap_slope(&self, pair: usize, cell: usize) -> f64 {
        let [low, high] = [cell, cell + 1].map(|border| self.gaps[pair][border]);
        (high - low) * (self.borders.len() - 1) as f64
    }

    /// The gap, extrapolated linearly from a cell.
    fn gap(&self, pair: usize, cell: usize, place: f64) -> f64 {
        self.gaps[pair][cell] + self.gap_slope(pair, cell) * (place - self.borders[cell].at)
    }
}

/// The zero of a function, given with its derivative, between two positions with opposite signs: Newton's
/// method, with bisection if a step leaves the bracket.
fn root(ends: [f64; 2], at_low: f64, function: &dyn Fn(f64) -> [f64; 2]) -> f64 {
    let [mut low, mut high] = ends;
    let mut place = 0.5 * (low + high);
    for _ in 0..MOST_STEPS {
        let [value, slope] = function(place);
        if (value > 0.0) == (at_low > 0.0) {
            low = place;
        } else {
            high = place;
        }
        let next = place - value / slope;
        let next = if next > low && next < high { next } else { 0.5 * (low + high) };
        if (next - place).abs() <= f64::EPSILON {
            return next;
        }
        place = next;
    }
    place
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest depth may be inside a cell, with contact only around it. Compares with fine sampling.
    #[test]
    fn what_presses_most_lies_inside_a_cell_as_well() {
        let profile = GapProfile::new(vec![vec![0.0, 0.4e-6, 0.1e-6]], 3);
        for (first, second) in [(0.3e-6, -0.2e-6), (-0.5e-6, 0.1e-6), (0.05e-6, 0.4e-6)] {
            let depth = |approach: f64, t: f64| {
                let gap = if t < 0.5 { 0.8e-6 * t } else { 0.4e-6 - 0.6e-6 * (t - 0.5) };
                let waves = first * (PI * t).cos() + second * (2.0 * PI * t).cos();
                approach - gap - SQRT_2 * waves
            };
            let places = (0..=200_000).map(|i| f64::from(i) / 2e5);
            let most = places
                .map(|t| depth(0.0, t))
                .fold(f64::NEG_INFINITY, f64::max);
            let press = |approach| Approach::new(approach, &[0.0, first, second]);
            let found = profile.largest_depth(0, &press(0.0));
            assert!((found - most).abs() < 1e-15, "{found:e} {most:e}");
            // A depth of a thousandth of a micrometre gives contact only around that position.
            let touching = profile.touching(0, &press(1e-9 - most));
            let length: f64 = touching.iter().map(Interval::length).sum();
            let places = (0..200_000).map(|i| (f64::from(i) + 0.5) / 2e5);
            let exact = places.filter(|t| depth(1e-9 - most, *t) > 0.0).count() as f64 / 2e5;
            assert!(
                exact > 0.0 && (length - exact).abs() < 2e-5,
                "{length} {exact}"
            );
        }
    }
}
