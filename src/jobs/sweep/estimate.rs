//! How long do all points take, given the times of some?
//!
//! Time per requested work is assumed to be the same for the sample and for all points (a ratio estimate). The
//! interval is Student's at 95 % for a sample from a finite number of points, so few or very different points make it
//! wide. If every point was computed, only their order is uncertain. Samples are drawn over the grid by the golden
//! ratio, which avoids periods of the grid.
//!
//! The time of a point that was only tried out is an estimate with a spread. Points of a job are alike, so a part of
//! their errors is the same for all ([`ALIKE`]) and does not average out.

use crate::numerics::statistics::student;
use serde::Serialize;
use std::collections::HashSet;

/// A number with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Expected value.
    pub expected: f64,
    /// Upper end.
    pub high: f64,
}

/// Correlation of the errors in the times of two points.
const ALIKE: f64 = 0.25;

/// Relative half width of the interval from a single point.
const SINGLE_POINT_HALF_WIDTH: f64 = 2.0;

/// A point that was computed or tried out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PointTime {
    /// Actual or expected time of the point \[s\].
    pub time: f64,
    /// Standard deviation of the expected time \[s\]; 0 if it was computed.
    pub spread: f64,
    /// Work of the point, as [`work`](super::queue::work) counts it.
    pub work: f64,
}

impl PointTime {
    /// Time per work \[s\].
    pub fn ratio(&self) -> f64 {
        self.time / self.work
    }

    /// Smallest plausible time \[s\].
    fn least(&self) -> f64 {
        (self.time - 2.0 * self.spread).max(0.0)
    }
}

/// The points to be computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Workload {
    /// Number of points.
    pub points: usize,
    /// Number of chains.
    pub chains: usize,
    /// Number of points in a whole chain.
    pub length: usize,
    /// Work of all points.
    pub work: f64,
    /// Worker threads.
    pub threads: usize,
    /// Whether threads share a point (its probes).
    pub shared: bool,
}

/// `count` different indices below `of`, in an order in which every prefix is spread evenly.
pub(super) fn drawn(of: usize, count: usize) -> Vec<usize> {
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    let mut taken = HashSet::new();
    let mut indices = Vec::new();
    for k in 0..count.min(of) {
        let start = ((k as f64 + 0.5) * golden).fract() * of as f64;
        // Two draws may coincide; then the next free index is used.
        let index = (0..of)
            .map(|step| (start as usize + step) % of)
            .find(|index| !taken.contains(index));
        indices.extend(index.inspect(|&index| _ = taken.insert(index)));
    }
    indices
}

impl Workload {
    /// Computing time over all points and threads \[s\], estimated from a sample; zero for an empty sample.
    pub fn computing(&self, sample: &[PointTime]) -> Interval {
        let n = sample.len() as f64;
        if sample.is_empty() {
            return Interval {
                low: 0.0,
                expected: 0.0,
                high: 0.0,
            };
        }
        let (time, work) = totals(sample);
        let (rate, mean_work) = (time / work, work / n);
        let rest = |point: &PointTime| (point.time - rate * point.work).powi(2);
        let spread = sample.iter().map(rest).sum::<f64>() / (n - 1.0).max(1.0);
        // Correction for drawing without replacement: a complete sample has no error.
        let left = (1.0 - n / self.points as f64).max(0.0);
        let half = match sample.len() {
            // One point does not show how much others differ.
            1 => SINGLE_POINT_HALF_WIDTH * rate * left.sqrt(),
            many => student(many - 1) * (spread / n * left).sqrt() / mean_work,
        };
        let half = (self.work * half).hypot(2.0 * self.spread(sample));
        let expected = self.work * rate;
        Interval {
            // The run computes the points of the sample again.
            low: (expected - half).max(sample.iter().map(PointTime::least).sum()),
            expected,
            high: expected + half,
        }
    }

    /// Standard deviation of the computing time from the errors of points that were tried out \[s\].
    fn spread(&self, sample: &[PointTime]) -> f64 {
        let scale = self.work / totals(sample).1;
        let each: f64 = sample.iter().map(|point| point.spread.powi(2)).sum();
        let alike: f64 = sample.iter().map(|point| point.spread).sum();
        ((1.0 - ALIKE) * scale * each + ALIKE * (scale * alike).powi(2)).sqrt()
    }

    /// Wall time on all threads \[s\]. At best the work is evenly shared; at worst the longest chain starts last. If
    /// the number of chains is not a multiple of the threads, some threads idle at the end.
    pub fn wall_time(&self, sample: &[PointTime]) -> Interval {
        let computing = self.computing(sample);
        let threads = self.threads as f64;
        if self.shared {
            return computing.over(threads);
        }
        if self.length == 1 && sample.len() == self.points {
            let longest = sample.iter().map(|point| point.time).fold(0.0, f64::max);
            let least = sample.iter().map(PointTime::least).fold(0.0, f64::max);
            return Interval {
                low: (computing.low / threads).max(least),
                expected: schedule(sample, self.threads),
                // Graham's bound, for any order of points.
                high: computing.high / threads + longest * (1.0 - 1.0 / threads),
            };
        }
        let chains = self.chains.max(1) as f64;
        let uneven = (chains / threads).ceil() * threads / chains;
        let longest = sample.iter().map(PointTime::ratio).fold(0.0, f64::max) * self.work;
        // The times of the points of a chain partly average out.
        let beyond = (longest - computing.expected).max(0.0) / chains / (self.length as f64).sqrt();
        let tail = beyond * (1.0 - 1.0 / threads);
        Interval {
            low: computing.low / threads,
            expected: computing.expected / threads * uneven + 0.5 * tail,
            high: computing.high / threads * uneven + tail,
        }
    }
}

/// Total time and work of a sample.
fn totals(sample: &[PointTime]) -> (f64, f64) {
    sample.iter().fold((0.0, 0.0), |(time, work), point| {
        (time + point.time, work + point.work)
    })
}

/// Time at which the last thread ends \[s\]. Points with more work start first, and points of equal work in
/// order, as in a queue without known times.
fn schedule(points: &[PointTime], threads: usize) -> f64 {
    let mut order = points.to_vec();
    order.sort_by(|a, b| b.work.total_cmp(&a.work));
    let mut free = vec![0.0; threads.max(1)];
    for point in order {
        free.sort_by(f64::total_cmp);
        free[0] += point.time;
    }
    free.into_iter().fold(0.0, f64::max)
}

impl Interval {
    /// This interval, if `threads` threads share the time evenly.
    fn over(self, threads: f64) -> Self {
        Self {
            low: self.low / threads,
            expected: self.expected / threads,
            high: self.high / threads,
        }
    }

    /// This interval, shifted by `time` \[s\].
    pub fn after(self, time: f64) -> Self {
        Self {
            low: time + self.low,
            expected: time + self.expected,
            high: time + self.high,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn workload(points: usize, length: usize, work: f64, threads: usize) -> Workload {
        Workload {
            points,
            chains: points / length,
            length,
            work,
            threads,
            shared: false,
        }
    }

    fn ends(found: Interval) -> [f64; 3] {
        [found.low, found.expected, found.high]
    }

    #[test]
    fn any_beginning_of_a_draw_is_spread_evenly() {
        for of in [1, 2, 7, 80, 1000] {
            let mut all = drawn(of, of);
            all.sort_unstable();
            assert_eq!(all, (0..of).collect::<Vec<_>>(), "each once");
        }
        // Coverage of 8 rows of 10 is even, both by column and by row.
        let places = drawn(80, 20);
        for (group, groups) in [(10, 8), (1, 10)] {
            let mut hits = vec![0; groups];
            places
                .iter()
                .for_each(|place| hits[place / group % groups] += 1);
            assert!(hits.iter().all(|n| (1..=4).contains(n)), "{hits:?}");
        }
    }

    /// Points of work 1 with these times.
    fn took(times: &[f64]) -> Vec<PointTime> {
        let of = |&time: &f64| PointTime {
            time,
            spread: 0.0,
            work: 1.0,
        };
        times.iter().map(of).collect()
    }

    #[test]
    fn a_whole_sample_leaves_nothing_open() {
        // The times of the two points are not proportional to their work.
        let sample = [
            PointTime {
                time: 1.0,
                spread: 0.0,
                work: 1.0,
            },
            PointTime {
                time: 7.0,
                spread: 0.0,
                work: 3.0,
            },
        ];
        assert_eq!(ends(workload(2, 1, 4.0, 1).computing(&sample)), [8.0; 3]);
        // The longer point starts first, or after the other one at worst.
        let found = workload(2, 1, 4.0, 2).wall_time(&sample);
        assert_eq!(ends(found), [7.0, 7.0, 7.5]);
        assert_eq!(ends(found.after(0.5)), [7.5, 7.5, 8.0]);
        // The queue does not know that the last of three is long, so it waits for the first two.
        let found = workload(3, 1, 3.0, 2).wall_time(&took(&[1.0, 1.0, 4.0]));
        assert_eq!(ends(found), [4.0, 5.0, 5.0]);
        // Three chains on two threads take as long as four would.
        assert_eq!(
            workload(3, 1, 3.0, 2).wall_time(&took(&[1.0; 3])).expected,
            2.0
        );
        assert_eq!(
            workload(12, 6, 12.0, 2)
                .wall_time(&took(&[1.0; 12]))
                .expected,
            6.0
        );
        // A resumed run has half of two chains of eighty points left, and as many chains as threads.
        let resumed = Workload {
            chains: 2,
            ..workload(42, 80, 42.0, 2)
        };
        assert_eq!(resumed.wall_time(&took(&[1.0; 10])).expected, 21.0);
        // Threads that share a point never wait.
        let shared = Workload {
            shared: true,
            ..workload(3, 1, 3.0, 2)
        };
        assert_eq!(shared.wall_time(&took(&[1.0; 3])).expected, 1.5);
        assert_eq!(ends(workload(9, 1, 1.0, 2).wall_time(&[])), [0.0; 3]);
    }

    /// If time is proportional to work, any sample predicts the total exactly.
    #[test]
    fn time_that_goes_with_work_is_known_from_any_points() {
        let sample: Vec<PointTime> = (1..=4)
            .map(|k| PointTime {
                time: 0.5 * f64::from(k),
                spread: 0.0,
                work: f64::from(k),
            })
            .collect();
        let found = workload(40, 1, 1000.0, 1).computing(&sample);
        assert_eq!(ends(found), [500.0; 3]);
    }

    /// The 95 % interval contains the sum in about 95 % of draws from a known set.
    #[test]
    fn the_interval_covers() {
        let costs: Vec<f64> = (0..400u32)
            .map(|i| 1.0 + f64::from(i.wrapping_mul(2_654_435_761) >> 16) / 65_536.0)
            .collect();
        let truth: f64 = costs.iter().sum();
        let mut covered = 0;
        for first in 0..200 {
            // The stride and 400 are coprime, so the sample has no repetition.
            let sample: Vec<f64> = (0..12).map(|k| costs[(first * 7 + k * 33) % 400]).collect();
            let found = workload(400, 1, 400.0, 1).computing(&took(&sample));
            covered += usize::from(found.low <= truth && truth <= found.high);
        }
        assert!((180..=200).contains(&covered), "{covered} of 200");
    }

    /// Two of four points are tried out, and a part of their errors is the same.
    #[test]
    fn what_is_not_known_of_points_widens_the_interval() {
        let mut sample = took(&[1.0, 1.0, 4.0, 4.0]);
        sample[2].spread = 1.0;
        sample[3].spread = 1.0;
        // A variance of 0.75 * 2 + 0.25 * 2^2.
        let half = 2.0 * 2.5f64.sqrt();
        let found = workload(4, 1, 4.0, 1).computing(&sample);
        assert_eq!(ends(found), [10.0 - half, 10.0, 10.0 + half]);
        // Twice as many points: 0.75 * 2 * 2 + 0.25 * 4^2, and additionally the error of the sample.
        let found = workload(8, 1, 8.0, 1).computing(&sample);
        assert!(found.high - found.expected > 2.0 * 7f64.sqrt());
        assert!(found.low >= 1.0 + 1.0 + 2.0 + 2.0);
    }
}
