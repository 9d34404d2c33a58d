//! The data of a point in a summary, the axes of the grid, and counts of points by kind of motion.

use serde::Serialize;
use std::ops::Deref;
use std::sync::Arc;

/// An axis of the grid, with the values that occur in the file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Axis {
    /// Column name.
    pub name: String,
    /// SI unit, `1` when dimensionless.
    pub unit: String,
    /// Distinct values in the file, ascending.
    pub values: Vec<f64>,
}

impl Axis {
    /// The index of a value that occurs in the file.
    pub(super) fn place(&self, value: f64) -> usize {
        self.values.partition_point(|&known| known < value)
    }
}

/// Indices of the axes with several values, on which points differ.
pub(super) fn varied(axes: &[Axis]) -> impl Iterator<Item = usize> {
    let several = |(_, axis): &(usize, &Axis)| axis.values.len() > 1;
    axes.iter()
        .enumerate()
        .filter(several)
        .map(|(index, _)| index)
}

/// Number of points with one kind of motion.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ClassCount {
    /// `steady_contact`, `periodic`, …; `none` for points without a class.
    pub class: String,
    /// Period of periodic motion.
    pub period: Option<u64>,
    /// Number of points.
    pub points: usize,
}

/// The data of a point in a summary.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct PointSummary {
    /// Number of the point, as in all tables.
    pub point_id: u64,
    /// Value of each axis.
    pub axis_values: Vec<f64>,
    /// Status and kind of motion.
    #[serde(flatten)]
    pub verdict: Arc<Verdict>,
    /// Largest exponent \[1/cycle\].
    pub lambda: Option<f64>,
    /// Standard error of the exponent \[1/cycle\].
    pub stderr: Option<f64>,
    /// Largest exponent from the separation of a twin trajectory \[1/cycle\].
    pub twin: Option<f64>,
    /// Lifetime of its chaos; absent if no trajectory was chaotic.
    pub chaos: Option<Box<ChaosLife>>,
}

impl Deref for PointSummary {
    type Target = Verdict;

    fn deref(&self) -> &Verdict {
        &self.verdict
    }
}

/// Status and class of a point. Many points have equal ones and share one copy, so that a million points need
/// little memory.
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash, Serialize)]
pub struct Verdict {
    /// Direction of its sweep, `up` or `down`; absent if points are independent.
    pub direction: Option<String>,
    /// Status of the point.
    pub status: String,
    /// Reason for the status.
    pub reason: String,
    /// Kind of motion.
    pub class: Option<String>,
    /// Period of the motion, if it has one.
    pub period: Option<u64>,
    /// Whether the exponents of the point and of its twin agree.
    pub twin_agrees: Option<bool>,
    /// Whether the averages have enough cycles for standard errors of verified coverage; absent if the motion
    /// settles.
    pub errors_verified: Option<bool>,
}

impl PointSummary {
    /// Whether neighbouring trajectories separate exponentially, at least for a time.
    pub fn is_chaos(&self) -> bool {
        matches!(self.class.as_deref(), Some(CHAOTIC | TRANSIENT_CHAOS))
    }
}

/// The class of a point at which no trajectory left chaos.
pub(super) const CHAOTIC: &str = "chaotic";
/// The class of a point at which some trajectories left chaos.
pub(super) const TRANSIENT_CHAOS: &str = "transient_chaos";

/// The lifetime of a point's chaos, in mesh cycles.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct ChaosLife {
    /// Mean lifetime; absent if no trajectory left chaos.
    pub mean: Option<f64>,
    /// Lower end of its 95 % interval; if no trajectory left chaos, a lower bound at 95 %.
    pub low: f64,
    /// Upper end of the interval; absent if no trajectory left chaos.
    pub high: Option<f64>,
    /// Number of trajectories that left chaos.
    pub exits: u64,
    /// Number of measured trajectories.
    pub trajectories: Option<u64>,
    /// The motions on which these trajectories ended, with their numbers: `periodic 3 (2), quasi_periodic
    /// (1)`.
    pub ended_on: Option<String>,
}
