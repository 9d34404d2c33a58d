//! What is taken off the involute flanks, along the profile and along the lead (ISO 21771, clause 9), or lacks by
//! error of manufacture. All of it is material that is missing, normal to the flank.

/// Relief of a flank, from nothing at its start to all at the end of the flank.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize)]
pub struct Relief {
    /// Most material taken off, normal to the flank \[m\]; 0: no relief.
    pub amount: f64,
    /// Length over which it falls to 0 \[m\]: along the line of action (base radius times roll angle), or along the
    /// face.
    pub length: f64,
    /// How it rises.
    pub course: ReliefCourse,
}

/// How relief rises over its length.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub enum ReliefCourse {
    /// In proportion to the way.
    #[default]
    Linear,
    /// With its square, without a kink where it begins.
    Parabolic,
}

impl Relief {
    /// Material missing at a distance from the end of the flank \[m\].
    pub fn at(&self, from_end: f64) -> f64 {
        if self.amount == 0.0 {
            return 0.0;
        }
        let part = (1.0 - from_end / self.length).clamp(0.0, 1.0);
        match self.course {
            ReliefCourse::Linear => self.amount * part,
            ReliefCourse::Parabolic => self.amount * part * part,
        }
    }
}

/// Modification of the whole flank of a gear, in one direction of it.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize)]
pub struct Modification {
    /// Crowning: missing at both ends, with the square of the distance from the middle \[m\].
    pub crowning: f64,
    /// Slope: how much more is missing at one end than at the other \[m\]: at the tip than at the root, at the face end
    /// of positive z than at that of negative z.
    pub slope: f64,
}

impl Modification {
    /// Material missing at a place from −1 to 1 across the flank \[m\]; a slope is counted from the middle.
    pub fn at(&self, place: f64) -> f64 {
        self.crowning * place * place + 0.5 * self.slope * place
    }
}

/// A course through points, drawn or measured; without points nothing is missing. Outside of them it stays what
/// it is at the nearer end.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct PointCourse {
    /// Places along the flank \[m\], increasing, and what is missing there \[m\], normal to the flank.
    pub points: Vec<[f64; 2]>,
    /// What lies between them.
    pub between: BetweenPoints,
}

/// What a course does between its points.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub enum BetweenPoints {
    /// Straight lines.
    #[default]
    Linear,
    /// Cubics with one slope on both sides of a point, that rise and fall where the points do (Fritsch & Butland
    /// 1984).
    Monotone,
}

impl PointCourse {
    /// Material missing at a place \[m\].
    pub fn at(&self, place: f64) -> f64 {
        let after = self.points.partition_point(|point| point[0] <= place);
        let (Some(before), Some(&[to, end])) = (after.checked_sub(1), self.points.get(after))
        else {
            let nearest = if after == 0 { self.points.first() } else { self.points.last() };
            return nearest.map_or(0.0, |point| point[1]);
        };
        let [from, start] = self.points[before];
        let part = (place - from) / (to - from);
        let line = start + part * (end - start);
        match self.between {
            BetweenPoints::Linear => line,
            BetweenPoints::Monotone => {
                // Hermite's cubic: the line and what the slopes at its ends add.
                let rise = (end - start) / (to - from);
                let [one, two] = [before, after].map(|point| self.slope(point) - rise);
                let rest = 1.0 - part;
                line + (to - from) * part * rest * (one * rest - two * part)
            }
        }
    }

    /// Places where the course has a kink, or a bend of its slope \[m\].
    pub fn kinks(&self) -> impl Iterator<Item = f64> {
        self.points.iter().map(|point| point[0])
    }

    /// The first point that does not lie behind the one before, and every number that is none.
    pub fn first_out_of_order(&self) -> Option<usize> {
        let finite = |point: &[f64; 2]| point.iter().all(|value| value.is_finite());
        (0..self.points.len()).find(|&i| {
            let point = &self.points[i];
            !finite(point) || (i > 0 && point[0] <= self.points[i - 1][0])
        })
    }

    /// Slope of the monotone course at a point: 0 where it turns and at its ends where the neighbour's rise would
    /// overshoot, else the weighted harmonic mean of the rises on both sides.
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
            for [place, missing] in &points {
                assert!((course.at(*place) - missing).abs() < 1e-14);
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

    /// Straight lines are of second order, the cubics of at least third where the course rises throughout.
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

    /// Slopes of the cubics at their points, by hand: the parabola through three points at an end, no more than three
    /// rises where the course turns behind it, none where that would run the other way, and the weighted harmonic mean inside.
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

    #[test]
    fn relief_rises_to_its_amount_at_the_end() {
        let linear = Relief {
            amount: 8e-6,
            length: 2e-3,
            course: ReliefCourse::Linear,
        };
        let parabolic = Relief {
            course: ReliefCourse::Parabolic,
            ..linear
        };
        for (from_end, one, other) in [
            (0.0, 8e-6, 8e-6),
            (1e-3, 4e-6, 2e-6),
            (2e-3, 0.0, 0.0),
            (5e-3, 0.0, 0.0),
        ] {
            assert!((linear.at(from_end) - one).abs() < 1e-18);
            assert!((parabolic.at(from_end) - other).abs() < 1e-18);
        }
    }

    #[test]
    fn crowning_is_missing_at_both_ends_and_a_slope_between_them() {
        let both = Modification {
            crowning: 5e-6,
            slope: 4e-6,
        };
        for (place, missing) in [(-1.0, 3e-6), (0.0, 0.0), (1.0, 7e-6)] {
            assert!((both.at(place) - missing).abs() < 1e-18);
        }
    }
}
