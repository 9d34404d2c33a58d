//! Functions through given points: piecewise linear, or piecewise cubic without overshoot.

use strum::EnumString;

/// A function of one variable through given points. Outside the range of the points it has the value of the
/// nearer end. Without points it is 0.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct PointCourse {
    /// Positions, increasing, each with its value.
    pub points: Vec<[f64; 2]>,
    /// Interpolation between them.
    pub between: BetweenPoints,
}

/// Interpolation of a course between its points.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, EnumString)]
#[strum(serialize_all = "snake_case")]
pub enum BetweenPoints {
    /// Straight lines.
    #[default]
    Linear,
    /// Cubics with a continuous slope. They are monotone where the points are (Fritsch & Butland 1984).
    Monotone,
}

impl PointCourse {
    /// A constant.
    pub fn constant(value: f64) -> Self {
        Self {
            points: vec![[0.0, value]],
            between: BetweenPoints::Linear,
        }
    }

    /// A straight line from one point to another.
    pub fn line(from: [f64; 2], to: [f64; 2]) -> Self {
        Self {
            points: vec![from, to],
            between: BetweenPoints::Linear,
        }
    }

    /// The value at a position.
    pub fn at(&self, place: f64) -> f64 {
        self.cubic(place)[0]
    }

    /// Coefficients of the function from a position to the next point, in powers of the distance from the
    /// position. At a point they belong to the piece after it.
    pub fn cubic(&self, place: f64) -> [f64; 4] {
        let after = self.points.partition_point(|point| point[0] <= place);
        let (Some(before), Some(&[to, end])) = (after.checked_sub(1), self.points.get(after))
        else {
            let nearest = if after == 0 { self.points.first() } else { self.points.last() };
            return [nearest.map_or(0.0, |point| point[1]), 0.0, 0.0, 0.0];
        };
        let [from, start] = self.points[before];
        let (length, part) = (to - from, (place - from) / (to - from));
        let rise = (end - start) / length;
        let line = start + part * (end - start);
        match self.between {
            BetweenPoints::Linear => [line, rise, 0.0, 0.0],
            BetweenPoints::Monotone => {
                // Hermite's cubic is the sum of the line and `length part rest (one rest − two part)`. The
                // latter is the contribution of the slopes at both ends.
                let [one, two] = [before, after].map(|point| self.slope(point) - rise);
                let rest = 1.0 - part;
                [
                    line + length * part * rest * (one * rest - two * part),
                    rise + one * rest * (rest - 2.0 * part) - two * part * (2.0 * rest - part),
                    ((3.0 * part - 2.0) * one + (3.0 * part - 1.0) * two) / length,
                    (one + two) / (length * length),
                ]
            }
        }
    }

    /// The positions of all points: only there the function may have a kink in its value or in its slope.
    pub fn kinks(&self) -> impl Iterator<Item = f64> {
        self.points.iter().map(|point| point[0])
    }

    /// Index of the first point that is not finite, or whose position is not larger than that of the previous
    /// point.
    pub fn first_out_of_order(&self) -> Option<usize> {
        let finite = |point: &[f64; 2]| point.iter().all(|value| value.is_finite());
        (0..self.points.len()).find(|&i| {
            let point = &self.points[i];
            !finite(point) || (i > 0 && point[0] <= self.points[i - 1][0])
        })
    }

    /// Slope of the monotone cubics at a point. Inside it is the weighted harmonic mean of the rises on both
    /// sides, or 0 at an extreme. At an end it is the slope of the parabola through three points, limited
    /// such that it does not overshoot.
    fn slope(&self, point: usize) -> f64 {
        let points = &self.points;
        let rise = |i: usize| {
            let length = points[i + 1][0] - points[i][0];
            [length, (points[i + 1][1] - points[i][1]) / length]
        };
        if points.len() == 2 {
            return rise(0)[1];
        }
        let last = points.len() - 1;
        if point == 0 || point == last {
            let (near, next) = if point == 0 { (0, 1) } else { (last - 1, last - 2) };
            let ([h, d], [h_next, d_next]) = (rise(near), rise(next));
            let slope = ((2.0 * h + h_next) * d - h * d_next) / (h + h_next);
            return match slope * d <= 0.0 {
                true => 0.0,
                false if d * d_next <= 0.0 && slope.abs() > 3.0 * d.abs() => 3.0 * d,
                false => slope,
            };
        }
        let ([h0, d0], [h1, d1]) = (rise(point - 1), rise(point));
        if d0 * d1 <= 0.0 {
            return 0.0;
        }
        let [w0, w1] = [2.0 * h1 + h0, h1 + 2.0 * h0];
        (w0 + w1) / (w0 / d0 + w1 / d1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_course_goes_through_its_points_and_no_further() {
        let points = vec![[1.0, 0.0], [2.0, 0.0], [3.0, 6.0], [5.0, 7.0], [6.0, 2.0]];
        for between in [BetweenPoints::Linear, BetweenPoints::Monotone] {
            let course = PointCourse {
                points: points.clone(),
                between,
            };
            for [place, value] in &points {
                assert!((course.at(*place) - value).abs() < 1e-14);
            }
            assert_eq!([course.at(0.0), course.at(7.0)], [0.0, 2.0]);
            for pair in points.windows(2) {
                let mut before = pair[0][1];
                for step in 1..=50 {
                    let part = f64::from(step) / 50.0;
                    let now = course.at(pair[0][0] + part * (pair[1][0] - pair[0][0]));
                    let way = pair[1][1] - pair[0][1];
                    assert!((now - before) * way >= -1e-13, "{between:?} {pair:?}");
                    before = now;
                }
            }
        }
        assert_eq!(PointCourse::default().at(1.0), 0.0);
    }

    /// Linear interpolation is of second order. Cubics are of at least third order if the function increases
    /// everywhere.
    #[test]
    fn orders_of_the_courses() {
        let exact = |x: f64| (0.8 * x).exp();
        let off = |between, count: u32| {
            let place = |i: u32| f64::from(i) / f64::from(count);
            let course = PointCourse {
                points: (0..=count).map(|i| [place(i), exact(place(i))]).collect(),
                between,
            };
            let places = (0..1000).map(|i| f64::from(i) / 1000.0);
            places
                .map(|x| (course.at(x) - exact(x)).abs())
                .fold(0.0, f64::max)
        };
        for (between, least) in [(BetweenPoints::Linear, 1.9), (BetweenPoints::Monotone, 2.9)] {
            let order = (off(between, 20) / off(between, 80)).log(4.0);
            assert!(order > least, "{between:?}: {order}");
        }
    }

    /// Slopes of the cubics, calculated by hand. At an end it is the slope of the parabola through three
    /// points. It is at most three rises if an extreme is next to the end, and 0 if its sign would be wrong.
    /// Inside it is the weighted harmonic mean.
    #[test]
    fn slopes_of_the_cubics_are_those_of_the_rises() {
        let slopes = |points: &[[f64; 2]]| -> Vec<f64> {
            let course = PointCourse {
                points: points.to_vec(),
                between: BetweenPoints::Monotone,
            };
            (0..points.len()).map(|point| course.slope(point)).collect()
        };
        let rising = slopes(&[[0.0, 0.0], [1.0, 1.0], [3.0, 2.0]]);
        for (found, exact) in rising.iter().zip([3.5 / 3.0, 9.0 / 13.0, 0.5 / 3.0]) {
            assert!((found - exact).abs() < 1e-15, "{rising:?}");
        }
        assert_eq!(
            slopes(&[[0.0, 0.0], [1.0, 1.0], [2.0, -9.0]]),
            [3.0, 0.0, -15.5]
        );
        assert_eq!(
            slopes(&[[0.0, -9.0], [1.0, 1.0], [2.0, 0.0]]),
            [15.5, 0.0, -3.0]
        );
        assert_eq!(slopes(&[[0.0, 0.0], [1.0, 1.0], [2.0, 11.0]])[0], 0.0);
        assert_eq!(slopes(&[[0.0, 1.0], [2.0, 5.0]]), [2.0, 2.0]);
    }

    #[test]
    fn points_out_of_order_are_found() {
        let course = |points: &[[f64; 2]]| PointCourse {
            points: points.to_vec(),
            ..PointCourse::default()
        };
        assert_eq!(course(&[[0.0, 1.0], [1.0, 1.0]]).first_out_of_order(), None);
        assert_eq!(
            course(&[[0.0, 1.0], [0.0, 1.0]]).first_out_of_order(),
            Some(1)
        );
        assert_eq!(course(&[[0.0, f64::NAN]]).first_out_of_order(), Some(0));
    }

    /// The coefficients at any position give the function up to the next point.
    #[test]
    fn pieces_are_the_course() {
        let points = vec![[1.0, 0.0], [2.0, 0.5], [3.0, 6.0], [5.0, 7.0], [6.0, 2.0]];
        for between in [BetweenPoints::Linear, BetweenPoints::Monotone] {
            let course = PointCourse {
                points: points.clone(),
                between,
            };
            for pair in points.windows(2) {
                let length = pair[1][0] - pair[0][0];
                for (from, to) in [(0.0, 0.9), (0.25, 0.75), (0.5, 0.999)] {
                    let [from, to] = [from, to].map(|part| pair[0][0] + part * length);
                    let piece = course.cubic(from);
                    let found = piece.iter().rev().fold(0.0, |sum, a| sum * (to - from) + a);
                    assert!(
                        (found - course.at(to)).abs() < 1e-13,
                        "{between:?} {from} {to}"
                    );
                }
            }
        }
        assert_eq!(PointCourse::constant(3.0).cubic(-1.0), [3.0, 0.0, 0.0, 0.0]);
        let line = PointCourse::line([1.0, 5.0], [3.0, 9.0]);
        assert_eq!(line.cubic(1.5), [6.0, 2.0, 0.0, 0.0]);
        assert_eq!(line.cubic(4.0), [9.0, 0.0, 0.0, 0.0]);
    }
}
