//! By how much pairs press at every place of a face: gaps that are straight lines on each slice, less waves of
//! displacement.
//!
//! Places are `t = z/b + ½`. By how much a pair presses at t is `x − g(t) − Σ d_n φ_n(t)`; where that is
//! positive it is in contact.

use std::f64::consts::{PI, SQRT_2};

/// Cells of the face for each half wave of the shortest: on a cell few waves turn more than once.
const CELLS_PER_WAVE: usize = 4;

/// Most steps to a border of contact.
const STEPS: usize = 60;

/// A part of the face, 0 to 1.
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
pub(super) struct Profile {
    /// Cells of a slice.
    cells: usize,
    waves: usize,
    /// Place of each border of cells, with `c_n cos nπt` and the derivatives of it.
    borders: Vec<Border>,
    /// Gaps at the borders of cells, pair by pair \[m\].
    gaps: Vec<Vec<f64>>,
}

#[derive(Debug, Clone, PartialEq)]
struct Border {
    place: f64,
    values: Vec<f64>,
    slopes: Vec<f64>,
}

/// `cos nπt` and `sin nπt` for n up to a number.
fn turns(place: f64, count: usize) -> (Vec<f64>, Vec<f64>) {
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

/// `∫ cos pπt dt` over intervals, for p up to a number.
pub(super) fn integrals(intervals: &[Interval], count: usize) -> Vec<f64> {
    let mut sums = vec![0.0; count];
    for interval in intervals {
        sums[0] += interval.length();
        for (place, sign) in [(interval.to, 1.0), (interval.from, -1.0)] {
            let (_, sines) = turns(place, count);
            for (p, (sum, sine)) in sums.iter_mut().zip(&sines).enumerate().skip(1) {
                *sum += sign * sine / (p as f64 * PI);
            }
        }
    }
    sums
}

impl Profile {
    /// Gaps \[m\] at the borders of equal slices, pair by pair, under so many waves.
    pub fn new(gaps: Vec<Vec<f64>>, waves: usize) -> Self {
        let slices = gaps[0].len() - 1;
        let cells = (CELLS_PER_WAVE * waves).div_ceil(slices);
        let count = slices * cells;
        let borders = (0..=count)
            .map(|index| {
                let place = index as f64 / count as f64;
                let (cosines, sines) = turns(place, waves);
                let wave = |n: usize| if n == 0 { 1.0 } else { SQRT_2 };
                Border {
                    place,
                    values: (0..waves).map(|n| wave(n) * cosines[n]).collect(),
                    slopes: (0..waves)
                        .map(|n| -wave(n) * n as f64 * PI * sines[n])
                        .collect(),
                }
            })
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

    /// By how much a pair presses at the border of a slice \[m\].
    pub fn at_border(&self, pair: usize, border: usize, approach: f64, waves: &[f64]) -> f64 {
        self.depth_at(pair, border * self.cells, approach, waves)
    }

    /// By how much a pair presses where it presses most \[m\].
    pub fn deepest(&self, pair: usize, approach: f64, waves: &[f64]) -> f64 {
        let mut most = f64::NEG_INFINITY;
        for cell in 0..self.borders.len() - 1 {
            for border in [cell, cell + 1] {
                most = most.max(self.depth_at(pair, border, approach, waves));
            }
            if let Some(turn) = self.turn(pair, cell, waves) {
                most = most.max(self.depth(pair, cell, turn, approach, waves));
            }
        }
        most
    }

    /// Where a pair is in contact.
    pub fn touching(&self, pair: usize, approach: f64, waves: &[f64]) -> Vec<Interval> {
        let mut found: Vec<Interval> = Vec::new();
        let mut add = |from: f64, to: f64| match found.last_mut() {
            Some(last) if last.to == from => last.to = to,
            _ => found.push(Interval { from, to }),
        };
        for cell in 0..self.borders.len() - 1 {
            let ends = [cell, cell + 1].map(|border| {
                let depth = self.depth_at(pair, border, approach, waves);
                (self.borders[border].place, depth)
            });
            let turn = self.turn(pair, cell, waves).map(|place| {
                let depth = self.depth(pair, cell, place, approach, waves);
                (place, depth)
            });
            let stretches = match turn {
                None => vec![ends],
                Some(turn) => vec![[ends[0], turn], [turn, ends[1]]],
            };
            for [(from, at_from), (to, at_to)] in stretches {
                match (at_from > 0.0, at_to > 0.0) {
                    (true, true) => add(from, to),
                    (false, false) => {}
                    (into, _) => {
                        let depth = |t: f64| {
                            let slope = self.slope(pair, cell, t, waves);
                            [self.depth(pair, cell, t, approach, waves), slope]
                        };
                        let border = root([from, to], at_from, &depth);
                        match into {
                            true => add(from, border),
                            false => add(border, to),
                        }
                    }
                }
            }
        }
        found.retain(|interval| interval.to > interval.from);
        found
    }

    /// `∫ g cos nπt dt` over intervals, by parts.
    pub fn gap_waves(&self, pair: usize, intervals: &[Interval]) -> Vec<f64> {
        let mut sums = vec![0.0; self.waves];
        for interval in intervals {
            for (from, to, cell) in self.parts(interval) {
                let [from_gap, to_gap] = [from, to].map(|place| self.gap(pair, cell, place));
                sums[0] += 0.5 * (from_gap + to_gap) * (to - from);
                let slope = self.rise(pair, cell);
                for (place, gap, sign) in [(to, to_gap, 1.0), (from, from_gap, -1.0)] {
                    let (cosines, sines) = turns(place, self.waves);
                    for (n, sum) in sums.iter_mut().enumerate().skip(1) {
                        let number = n as f64 * PI;
                        *sum += sign * (gap * sines[n] + slope * cosines[n] / number) / number;
                    }
                }
            }
        }
        sums
    }

    /// `∫ p dt` and `∫ (t − ½) p dt` on a slice, p by how much a pair presses where it is in contact \[m\].
    pub fn on_slice(
        &self,
        pair: usize,
        slice: usize,
        touching: &[Interval],
        approach: f64,
        waves: &[f64],
    ) -> [f64; 2] {
        let (first, last) = (slice * self.cells, (slice + 1) * self.cells);
        let [start, end] = [first, last].map(|border| self.borders[border].place);
        let mut sums = [0.0; 2];
        for interval in touching {
            let (from, to) = (interval.from.max(start), interval.to.min(end));
            if from >= to {
                continue;
            }
            let middle = 0.5 * (from + to);
            // What does not vary in waves is a straight line, times t − ½ a parabola: Simpson's rule.
            let straight = |t: f64| approach - waves[0] - self.gap(pair, first, t);
            let places = [from, middle, to].map(|t| [straight(t), (t - 0.5) * straight(t)]);
            for (order, sum) in sums.iter_mut().enumerate() {
                let [a, b, c] = places.map(|place| place[order]);
                *sum += (to - from) / 6.0 * (a + 4.0 * b + c);
            }
            for (place, sign) in [(to, 1.0), (from, -1.0)] {
                let (cosines, sines) = turns(place, self.waves);
                for (n, wave) in waves.iter().enumerate().skip(1) {
                    let number = n as f64 * PI;
                    let amplitude = sign * SQRT_2 * wave / number;
                    sums[0] -= amplitude * sines[n];
                    sums[1] -= amplitude * ((place - 0.5) * sines[n] + cosines[n] / number);
                }
            }
        }
        sums
    }

    /// The parts of an interval on slices, each with a cell of it.
    fn parts(&self, interval: &Interval) -> Vec<(f64, f64, usize)> {
        let slices = (self.borders.len() - 1) / self.cells;
        (0..slices)
            .filter_map(|slice| {
                let from = self.borders[slice * self.cells].place.max(interval.from);
                let to = self.borders[(slice + 1) * self.cells]
                    .place
                    .min(interval.to);
                (from < to).then_some((from, to, slice * self.cells))
            })
            .collect()
    }

    /// Derivative of a gap on a cell \[m\].
    fn rise(&self, pair: usize, cell: usize) -> f64 {
        let [low, high] = [cell, cell + 1].map(|border| self.gaps[pair][border]);
        (high - low) / (self.borders[cell + 1].place - self.borders[cell].place)
    }

    /// The gap of the line that it is on a cell.
    fn gap(&self, pair: usize, cell: usize, place: f64) -> f64 {
        self.gaps[pair][cell] + self.rise(pair, cell) * (place - self.borders[cell].place)
    }

    fn depth_at(&self, pair: usize, border: usize, approach: f64, waves: &[f64]) -> f64 {
        let moved: f64 = (self.borders[border].values.iter().zip(waves))
            .map(|(value, wave)| value * wave)
            .sum();
        approach - self.gaps[pair][border] - moved
    }

    fn depth(&self, pair: usize, cell: usize, place: f64, approach: f64, waves: &[f64]) -> f64 {
        let (cosines, _) = turns(place, self.waves);
        let others: f64 = (cosines.iter().zip(waves).skip(1))
            .map(|(cosine, wave)| SQRT_2 * cosine * wave)
            .sum();
        approach - self.gap(pair, cell, place) - waves[0] - others
    }

    fn slope(&self, pair: usize, cell: usize, place: f64, waves: &[f64]) -> f64 {
        let (_, sines) = turns(place, self.waves);
        let others: f64 = (sines.iter().zip(waves).enumerate().skip(1))
            .map(|(n, (sine, wave))| SQRT_2 * n as f64 * PI * sine * wave)
            .sum();
        others - self.rise(pair, cell)
    }

    /// Where by how much a pair presses turns from growing to falling, or back, inside a cell.
    fn turn(&self, pair: usize, cell: usize, waves: &[f64]) -> Option<f64> {
        let rise = self.rise(pair, cell);
        let [from, to] = [cell, cell + 1].map(|border| {
            let moved: f64 = (self.borders[border].slopes.iter().zip(waves))
                .map(|(slope, wave)| slope * wave)
                .sum();
            -rise - moved
        });
        if (from > 0.0) == (to > 0.0) {
            return None;
        }
        let ends = [cell, cell + 1].map(|border| self.borders[border].place);
        let bend = |t: f64| {
            let (cosines, _) = turns(t, self.waves);
            let others: f64 = (cosines.iter().zip(waves).enumerate())
                .map(|(n, (cosine, wave))| SQRT_2 * (n as f64 * PI).powi(2) * cosine * wave)
                .sum();
            [self.slope(pair, cell, t, waves), others]
        };
        Some(root(ends, from, &bend))
    }
}

/// The zero of a function, given with its derivative, between two places where its signs differ: Newton's
/// method, and the middle where that leaves them.
fn root(ends: [f64; 2], at_low: f64, function: &dyn Fn(f64) -> [f64; 2]) -> f64 {
    let [mut low, mut high] = ends;
    let mut place = 0.5 * (low + high);
    for _ in 0..STEPS {
        let [value, slope] = function(place);
        if (value > 0.0) == (at_low > 0.0) {
            low = place;
        } else {
            high = place;
        }
        let next = place - value / slope;
        let next = match next > low && next < high {
            true => next,
            false => 0.5 * (low + high),
        };
        if (next - place).abs() <= f64::EPSILON {
            return next;
        }
        place = next;
    }
    place
}
