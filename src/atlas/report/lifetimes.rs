//! Lifetimes of chaos at the points of a results folder.

use serde::Serialize;

use super::point::{CHAOTIC, PointSummary, TRANSIENT_CHAOS};

/// Lifetimes of chaos, in mesh cycles. Points are grouped by how many of their trajectories left chaos: none,
/// some or all.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Lifetimes {
    /// Points at which no trajectory left chaos, and the range of the lower 95 % bounds of their mean lives.
    pub lasting: LifetimeRange,
    /// Number of points at which some trajectories left chaos.
    pub transient_points: usize,
    /// The first of them, the shortest mean life first.
    pub transient: Vec<PointSummary>,
    /// Points at which all trajectories left chaos, and the range of their mean lives. Their class is that of
    /// the motion after the chaos.
    pub left: LifetimeRange,
}

/// A number of points, and the range of a time.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct LifetimeRange {
    /// Number of points.
    pub points: usize,
    /// The shortest and the longest time \[mesh cycles\].
    pub range: Option<[f64; 2]>,
}

impl LifetimeRange {
    fn add(&mut self, time: f64) {
        self.points += 1;
        let [least, most] = self.range.unwrap_or([time; 2]);
        self.range = Some([least.min(time), most.max(time)]);
    }
}

impl Lifetimes {
    /// Counts a point. Returns true for a point of transient chaos, which the caller must list.
    pub(super) fn count(&mut self, point: &PointSummary) -> bool {
        let Some(chaos) = &point.chaos else {
            return false;
        };
        match (point.class.as_deref(), chaos.mean) {
            (Some(CHAOTIC), _) => self.lasting.add(chaos.low),
            (Some(TRANSIENT_CHAOS), _) => return true,
            (_, Some(mean)) => self.left.add(mean),
            (_, None) => {}
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::point::{ChaosLife, Verdict};
    use std::sync::Arc;

    #[test]
    fn points_are_counted_by_how_many_trajectories_left_chaos() {
        let point = |class: &str, mean: Option<f64>, low: f64| PointSummary {
            verdict: Arc::new(Verdict {
                class: Some(class.into()),
                ..Verdict::default()
            }),
            chaos: Some(Box::new(ChaosLife {
                mean,
                low,
                ..ChaosLife::default()
            })),
            ..PointSummary::default()
        };
        let mut found = Lifetimes::default();
        for (point, listed) in [
            (point("chaotic", None, 6700.0), false),
            (point("chaotic", None, 13300.0), false),
            (point("transient_chaos", Some(2000.0), 900.0), true),
            (point("periodic", Some(800.0), 400.0), false),
            // No trajectory left chaos, but the verdict is missing.
            (point("not_converged", None, 100.0), false),
            (PointSummary::default(), false),
        ] {
            assert_eq!(found.count(&point), listed, "{point:?}");
        }
        let wanted = LifetimeRange {
            points: 2,
            range: Some([6700.0, 13300.0]),
        };
        assert_eq!(found.lasting, wanted);
        assert_eq!((found.left.points, found.left.range), (1, Some([800.0; 2])));
    }
}
