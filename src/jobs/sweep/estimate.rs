//! The time of all points from the time of some.
//!
//! The time of a sample over the work that the manifest asks of it is what all work takes (a ratio
//! estimate); the interval is Student's at 95 % for a sample from so many points, so few points or very
//! different ones make it wide. Where every point was computed nothing is open but their order. Samples are drawn over the grid by the golden ratio, which meets
//! no period of the grid.
//!
//! Of a point that was only tried out the time is itself expected, with a spread. Points of a job are alike, so
//! that a part of what is not known of them is the same for all ([`ALIKE`]) and does not average out.

use crate::numerics::statistics::student;
use serde::Serialize;
use std::collections::HashSet;

/// A number with the interval that it lies in at 95 %.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// The number.
    pub expected: f64,
    /// Upper end.
    pub high: f64,
}

/// Correlation of what is not known of the times of two points.
const ALIKE: f64 = 0.25;

/// Half width of the interval of the time that a single point tells, over that time.
const LONE: f64 = 2.0;

/// A point that was computed or tried out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sampled {
    /// What it took, or is expected to take \[s\].
    pub time: f64,
    /// Standard deviation of what it is expected to take \[s\]; 0 where it was computed.
    pub spread: f64,
    /// Its work, in cycles times modes.
    pub work: f64,
}

impl Sampled {
    /// Time per work \[s\].
    pub fn ratio(&self) -> f64 {
        self.time / self.work
    }

    /// What it takes at least \[s\].
    fn least(&self) -> f64 {
        (self.time - 2.0 * self.spread).max(0.0)
    }
}

/// What is to be computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Load {
    /// Points.
    pub points: usize,
    /// Chains that they are of.
    pub chains: usize,
    /// Points of a whole chain.
    pub length: usize,
    /// Work of all points, in cycles times modes.
    pub work: f64,
    /// Worker threads.
    pub threads: usize,
    /// Whether threads share a point (its probes).
    pub shared: bool,
}

/// `count` different places among `of`, in an order in which any beginning is spread evenly.
pub(super) fn drawn(of: usize, count: usize) -> Vec<usize> {
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    let mut taken = HashSet::new();
    let mut places = Vec::new();
    for k in 0..count.min(of) {
        let start = ((k as f64 + 0.5) * golden).fract() * of as f64;
        // Two draws may fall on one place; then the next free one is taken.
        let place = (0..of)
            .map(|step| (start as usize + step) % of)
            .find(|place| !taken.contains(place));
        places.extend(place.inspect(|&place| _ = taken.insert(place)));
    }
    places
}

impl Load {
    /// Computing time over all points and threads \[s\], from some of them; zero from none.
    pub fn computing(&self, sample: &[Sampled]) -> Interval {
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
        let rest = |point: &Sampled| (point.time - rate * point.work).powi(2);
        let spread = sample.iter().map(rest).sum::<f64>() / (n - 1.0).max(1.0);
        // Of points drawn without putting them back, the last ones leave nothing open.
        let left = (1.0 - n / self.points as f64).max(0.0);
        let half = match sample.len() {
            // One point says nothing of how much others differ.
            1 => LONE * rate * left.sqrt(),
            many => student(many - 1) * (spread / n * left).sqrt() / mean_work,
        };
        let half = (self.work * half).hypot(2.0 * self.spread(sample));
        let expected = self.work * rate;
        Interval {
            // What was computed takes its time again.
            low: (expected - half).max(sample.iter().map(Sampled::least).sum()),
            expected,
            high: expected + half,
        }
    }

    /// Standard deviation of the computing time, by what is not known of points that were tried out \[s\].
    fn spread(&self, sample: &[Sampled]) -> f64 {
        let scale = self.work / totals(sample).1;
        let each: f64 = sample.iter().map(|point| point.spread.powi(2)).sum();
        let alike: f64 = sample.iter().map(|point| point.spread).sum();
        ((1.0 - ALIKE) * scale * each + ALIKE * (scale * alike).powi(2)).sqrt()
    }

    /// Wall time on all threads \[s\]. At best the work is evenly shared; at worst the longest
    /// chain is begun last. Chains that do not divide by the threads leave some without work at
    /// the end.
    pub fn wall_time(&self, sample: &[Sampled]) -> Interval {
        let computing = self.computing(sample);
        let threads = self.threads as f64;
        if self.shared {
            return computing.over(threads);
        }
        if self.length == 1 && sample.len() == self.points {
            let longest = sample.iter().map(|point| point.time).fold(0.0, f64::max);
            let least = sample.iter().map(Sampled::least).fold(0.0, f64::max);
            return Interval {
                low: (computing.low / threads).max(least),
                expected: schedule(sample, self.threads),
                // Graham's bound, in whatever order points are begun.
                high: computing.high / threads + longest * (1.0 - 1.0 / threads),
            };
        }
        let chains = self.chains.max(1) as f64;
        let uneven = (chains / threads).ceil() * threads / chains;
        let longest = sample.iter().map(Sampled::ratio).fold(0.0, f64::max) * self.work;
        // A long chain has long points and short ones.
        let beyond = (longest - computing.expected).max(0.0) / chains / (self.length as f64).sqrt();
        let tail = beyond * (1.0 - 1.0 / threads);
        Interval {
            low: computing.low / threads,
            expected: computing.expected / threads * uneven + 0.5 * tail,
            high: computing.high / threads * uneven + tail,
        }
    }
}

/// Time and work of a sample.
fn totals(sample: &[Sampled]) -> (f64, f64) {
    sample.iter().fold((0.0, 0.0), |(time, work), point| {
        (time + point.time, work + point.work)
    })
}

/// When the last thread is done \[s\], if the points with the most work are begun first and those of
/// equal work in their order, as a queue does that knows no times yet.
fn schedule(points: &[Sampled], threads: usize) -> f64 {
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
    /// The same, evenly shared by so many threads.
    fn over(self, threads: f64) -> Self {
        Self {
            low: self.low / threads,
            expected: self.expected / threads,
            high: self.high / threads,
        }
    }

    /// The same, so much later.
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

    fn load(points: usize, length: usize, work: f64, threads: usize) -> Load {
        Load {
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
        // Of 8 rows of 10, no column and no row is left out by much.
        let places = drawn(80, 20);
        for (group, groups) in [(10, 8), (1, 10)] {
            let mut met = vec![0; groups];
            places
                .iter()
                .for_each(|place| met[place / group % groups] += 1);
            assert!(met.iter().all(|n| (1..=4).contains(n)), "{met:?}");
        }
    }

    /// Points of work 1 that took so long.
    fn took(times: &[f64]) -> Vec<Sampled> {
        let of = |&time: &f64| Sampled {
            time,
            spread: 0.0,
            work: 1.0,
        };
        times.iter().map(of).collect()
    }

    #[test]
    fn a_whole_sample_leaves_nothing_open() {
        // The time goes with the work for one point and not for the other.
        let sample = [
            Sampled {
                time: 1.0,
                spread: 0.0,
                work: 1.0,
            },
            Sampled {
                time: 7.0,
                spread: 0.0,
                work: 3.0,
            },
        ];
        assert_eq!(ends(load(2, 1, 4.0, 1).computing(&sample)), [8.0; 3]);
        // The longer one is begun first; at worst behind the other one.
        let found = load(2, 1, 4.0, 2).wall_time(&sample);
        assert_eq!(ends(found), [7.0, 7.0, 7.5]);
        assert_eq!(ends(found.after(0.5)), [7.5, 7.5, 8.0]);
        // Nobody knows that the last of three is long: it waits for the first two.
        let found = load(3, 1, 3.0, 2).wall_time(&took(&[1.0, 1.0, 4.0]));
        assert_eq!(ends(found), [4.0, 5.0, 5.0]);
        // Three chains on two threads take as long as four would.
        assert_eq!(load(3, 1, 3.0, 2).wall_time(&took(&[1.0; 3])).expected, 2.0);
        assert_eq!(
            load(12, 6, 12.0, 2).wall_time(&took(&[1.0; 12])).expected,
            6.0
        );
        // Of two chains of eighty a resumed run has half left: as many as there are threads.
        let resumed = Load {
            chains: 2,
            ..load(42, 80, 42.0, 2)
        };
        assert_eq!(resumed.wall_time(&took(&[1.0; 10])).expected, 21.0);
        // Threads that share a point have no one to wait for.
        let shared = Load {
            shared: true,
            ..load(3, 1, 3.0, 2)
        };
        assert_eq!(shared.wall_time(&took(&[1.0; 3])).expected, 1.5);
        assert_eq!(ends(load(9, 1, 1.0, 2).wall_time(&[])), [0.0; 3]);
    }

    /// Where points take their work's time, some of them tell of all, whatever their work.
    #[test]
    fn time_that_goes_with_work_is_known_from_any_points() {
        let sample: Vec<Sampled> = (1..=4)
            .map(|k| Sampled {
                time: 0.5 * f64::from(k),
                spread: 0.0,
                work: f64::from(k),
            })
            .collect();
        let found = load(40, 1, 1000.0, 1).computing(&sample);
        assert_eq!(ends(found), [500.0; 3]);
    }

    /// The 95 % interval holds the sum in about 95 % of draws from a known set.
    #[test]
    fn the_interval_covers() {
        let costs: Vec<f64> = (0..400u32)
            .map(|i| 1.0 + f64::from(i.wrapping_mul(2_654_435_761) >> 16) / 65_536.0)
            .collect();
        let truth: f64 = costs.iter().sum();
        let mut covered = 0;
        for first in 0..200 {
            // Strides prime to 400: a sample without repetition.
            let sample: Vec<f64> = (0..12).map(|k| costs[(first * 7 + k * 33) % 400]).collect();
            let found = load(400, 1, 400.0, 1).computing(&took(&sample));
            covered += usize::from(found.low <= truth && truth <= found.high);
        }
        assert!((180..=200).contains(&covered), "{covered} of 200");
    }

    /// Of four points, two of them tried out, what is not known of them is partly the same.
    #[test]
    fn what_is_not_known_of_points_widens_the_interval() {
        let mut sample = took(&[1.0, 1.0, 4.0, 4.0]);
        sample[2].spread = 1.0;
        sample[3].spread = 1.0;
        // A variance of 0.75 * 2 + 0.25 * 2^2.
        let half = 2.0 * 2.5f64.sqrt();
        let found = load(4, 1, 4.0, 1).computing(&sample);
        assert_eq!(ends(found), [10.0 - half, 10.0, 10.0 + half]);
        // Twice as many points: 0.75 * 2 * 2 + 0.25 * 4^2, and the sample's own error comes on top.
        let found = load(8, 1, 8.0, 1).computing(&sample);
        assert!(found.high - found.expected > 2.0 * 7f64.sqrt());
        assert!(found.low >= 1.0 + 1.0 + 2.0 + 2.0);
    }
}
