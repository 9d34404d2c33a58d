//! Which data does a summary have of a point of a results folder, on which axes is it, and how many are alike?

use serde::Serialize;
use std::ops::Deref;
use std::sync::Arc;

/// A grid axis with its values in the file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Axis {
    /// Column name.
    pub name: String,
    /// SI unit, `1` when dimensionless.
    pub unit: String,
    /// Values in the file, ascending.
    pub values: Vec<f64>,
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
    /// Points.
    pub points: usize,
}

/// The data of a point in a summary.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct PointSummary {
    /// Row-major index into the grid.
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
    /// Exponent from the twin trajectory \[1/cycle\].
    pub twin: Option<f64>,
    /// Life of its chaos; absent if no trajectory was chaotic.
    pub chaos: Option<Box<ChaosLife>>,
}

impl Deref for PointSummary {
    type Target = Verdict;

    fn deref(&self) -> &Verdict {
        &self.verdict
    }
}

/// The textual data of a point. Most points share them with many others, so that a million points need little memory.
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
    /// Whether standard errors were read after enough cycles for verified coverage; absent if the motion settles.
    pub errors_verified: Option<bool>,
}

impl PointSummary {
    /// Whether neighbouring trajectories separate exponentially, at least for a time.
    pub fn is_chaos(&self) -> bool {
        matches!(self.class.as_deref(), Some(CHAOTIC | TRANSIENT_CHAOS))
    }
}

/// The class of chaos that no trajectory left.
pub(super) const CHAOTIC: &str = "chaotic";
/// The class of chaos that some trajectories left.
pub(super) const TRANSIENT_CHAOS: &str = "transient_chaos";

/// The life of a point's chaos, in mesh cycles.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct ChaosLife {
    /// Mean life; absent if no trajectory left chaos.
    pub mean: Option<f64>,
    /// Lower end of its 95 % interval; if no trajectory left chaos, a lower bound at 95 %.
    pub low: f64,
    /// Upper end of the interval; absent if no trajectory left chaos.
    pub high: Option<f64>,
    /// Trajectories that left chaos.
    pub exits: u64,
    /// Measured trajectories.
    pub trajectories: Option<u64>,
    /// The motion after the chaos, of the trajectories that left it.
    pub ended_on: Option<String>,
}
