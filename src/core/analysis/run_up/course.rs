//! Speed and load over the time of a run-up, and the stretches on which both are polynomials.

use super::RunUpConfig;
use crate::numerics::point_course::PointCourse;
use crate::propagate::varying_speed::{COURSE_TERMS, Course, SpeedInterval};

/// Smallest number of stretches of a run-up. The run-up can be interrupted between stretches.
pub(super) const PARTS: u32 = 200;

/// The load of a run-up, as a fraction of the rated one.
#[derive(Debug, Clone, PartialEq)]
pub enum LoadLaw {
    /// Over the time since the start \[s\].
    OverTime(PointCourse),
    /// Over the speed of the pinion \[rad/s\].
    OverSpeed(PointCourse),
}

impl LoadLaw {
    /// A law with all loads multiplied by a factor.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let mut scaled = self.clone();
        let (Self::OverTime(course) | Self::OverSpeed(course)) = &mut scaled;
        course
            .points
            .iter_mut()
            .for_each(|point| point[1] *= factor);
        scaled
    }
}

impl RunUpConfig {
    /// Time from start to end \[s\].
    pub fn duration(&self) -> f64 {
        self.speed.points.last().map_or(0.0, |point| point[0])
    }

    /// Mean speed \[rad/s\] at a time since the start \[s\].
    pub fn speed_at(&self, time: f64) -> f64 {
        self.speed.at(time)
    }

    /// Load at a time since the start \[s\].
    pub fn load_at(&self, time: f64) -> f64 {
        match &self.load {
            LoadLaw::OverTime(course) => course.at(time),
            LoadLaw::OverSpeed(course) => course.at(self.speed_at(time)),
        }
    }

    /// The stretches from start to end. The speed is exact. A load over a curved speed is expanded up to the
    /// fourth power of time.
    pub(super) fn stretches(&self) -> Vec<SpeedInterval> {
        let ends = self.ends();
        let pieces = ends.windows(2).map(|pair| {
            let length = pair[1] - pair[0];
            // The middle lies within a single piece of a course.
            let middle = pair[0] + 0.5 * length;
            let mut since_middle = Course::default();
            (since_middle[0], since_middle[1]) = (-0.5 * length, 1.0);
            let speed = composed(self.speed.cubic(middle), &since_middle);
            let mut stretch = SpeedInterval::steady(length, 0.0, 0.0);
            for (k, a) in speed.iter().enumerate().take(COURSE_TERMS - 1) {
                stretch.rotation[k + 1] = a / (k + 1) as f64;
            }
            stretch.load = match &self.load {
                LoadLaw::OverTime(course) => composed(course.cubic(middle), &since_middle),
                LoadLaw::OverSpeed(course) => {
                    let there = self.speed_at(middle);
                    let mut speed_difference = speed;
                    speed_difference[0] -= there;
                    composed(course.cubic(there), &speed_difference)
                }
            };
            stretch
        });
        pieces.collect()
    }

    /// Ends of stretches \[s\]. They are evenly spaced, with additional ends where the speed or the load
    /// enters another piece of its course.
    fn ends(&self) -> Vec<f64> {
        let duration = self.duration();
        let even = (0..=PARTS).map(|part| duration * f64::from(part) / f64::from(PARTS));
        let mut ends: Vec<f64> = even.chain(self.speed.kinks()).collect();
        match &self.load {
            LoadLaw::OverTime(course) => ends.extend(course.kinks()),
            LoadLaw::OverSpeed(course) => {
                ends.extend(course.kinks().flat_map(|speed| self.times_at(speed)));
            }
        }
        ends.retain(|time| (0.0..=duration).contains(time));
        ends.sort_by(f64::total_cmp);
        ends.dedup_by(|next, last| *next - *last <= 1e-9 * duration);
        ends
    }

    /// Times at which the speed passes a value. The speed is monotonic between two points of its course.
    fn times_at(&self, speed: f64) -> impl Iterator<Item = f64> {
        let pairs = self.speed.points.windows(2);
        pairs.filter_map(move |pair| {
            let [[mut below, first], [mut above, last]] = [pair[0], pair[1]];
            ((first < speed) != (last < speed)).then(|| {
                for _ in 0..f64::MANTISSA_DIGITS {
                    let middle = 0.5 * (below + above);
                    let crossing_is_before = (self.speed_at(middle) < speed) != (first < speed);
                    *(if crossing_is_before { &mut above } else { &mut below }) = middle;
                }
                above
            })
        })
    }
}

/// Composes a cubic with a course, in powers of time. Powers beyond the terms of a course are dropped.
fn composed(cubic: [f64; 4], inner: &Course) -> Course {
    let mut sum = Course::default();
    for a in cubic.into_iter().rev() {
        let mut next = Course::default();
        for (m, coefficient) in inner.iter().enumerate() {
            for (k, other) in sum.iter().enumerate().take(COURSE_TERMS - m) {
                next[m + k] += coefficient * other;
            }
        }
        next[0] += a;
        sum = next;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::config::Signals;
    use crate::numerics::point_course::BetweenPoints;

    fn config(speed: PointCourse, load: LoadLaw) -> RunUpConfig {
        RunUpConfig {
            speed,
            load,
            settle: 0.0,
            sample_rate: 1e3,
            revolutions: 1,
            orders: Vec::new(),
            frequency_step: 10.0,
            signals: Signals::NONE,
        }
    }

    fn monotone(points: &[[f64; 2]]) -> PointCourse {
        PointCourse {
            points: points.to_vec(),
            between: BetweenPoints::Monotone,
        }
    }

    /// The speed rises, stays constant, and falls. Stretches end, among other times, where the speed or the load enters
    /// another piece of its course.
    #[test]
    fn stretches_end_where_courses_change() {
        let speed = monotone(&[[0.0, 100.0], [1.003, 300.0], [1.5, 300.0], [4.0, 120.0]]);
        let over_speed = PointCourse {
            points: vec![[100.0, 0.1], [211.0, 0.4], [300.0, 0.2]],
            between: BetweenPoints::Linear,
        };
        let own = config(speed, LoadLaw::OverSpeed(over_speed));
        let ends = own.ends();
        let near = |time: f64| ends.iter().any(|end| (end - time).abs() < 1e-8);
        assert!(near(1.003) && near(1.5) && near(0.0) && near(4.0));
        let passes: Vec<f64> = own.times_at(211.0).collect();
        assert_eq!(passes.len(), 2);
        for time in passes {
            assert!((own.speed_at(time) - 211.0).abs() < 1e-10 && near(time));
        }
        assert!(ends.windows(2).all(|pair| pair[0] < pair[1]));
    }

    /// On every stretch, rotation and load agree with the courses. The error of a load over a curved speed
    /// decreases with the fifth power of the length.
    #[test]
    fn stretches_are_the_courses() {
        let speed = monotone(&[[0.0, 100.0], [1.0, 300.0], [4.0, 400.0], [6.0, 120.0]]);
        let laws = [
            LoadLaw::OverTime(monotone(&[[0.0, 0.1], [2.0, 0.3], [6.0, 0.2]])),
            LoadLaw::OverSpeed(monotone(&[[0.0, 0.0], [200.0, 0.2], [500.0, 0.7]])),
        ];
        for load in laws {
            let own = config(speed.clone(), load);
            let (mut time, mut rotation) = (0.0, 0.0);
            for stretch in own.stretches() {
                for part in [0.0, 0.3, 0.7, 1.0] {
                    let since = part * stretch.duration;
                    let sum = |a: &Course| a.iter().rev().fold(0.0, |sum, a| sum * since + a);
                    let rate = std::array::from_fn(|k| match stretch.rotation.get(k + 1) {
                        Some(a) => (k + 1) as f64 * a,
                        None => 0.0,
                    });
                    let at = time + since;
                    assert!((sum(&rate) - own.speed_at(at)).abs() < 1e-9);
                    let off = (sum(&stretch.load) - own.load_at(at)).abs();
                    assert!(off < 1e-7, "{at} {off}");
                }
                let series = stretch.rotation.iter().rev();
                rotation += series.fold(0.0, |sum, a| sum * stretch.duration + a);
                time += stretch.duration;
            }
            assert!((time - 6.0).abs() < 1e-12);
            // Simpson's rule on each piece is exact for cubics.
            let exact: f64 = (own.speed.points.windows(2))
                .map(|pair| {
                    let [from, to] = [pair[0][0], pair[1][0]];
                    let middle = own.speed_at(0.5 * (from + to));
                    (to - from) / 6.0 * (pair[0][1] + 4.0 * middle + pair[1][1])
                })
                .sum();
            assert!((rotation - exact).abs() < 1e-9, "{rotation} {exact}");
        }
    }
}
