//! What is a point of a results folder, on which axes does it lie, and how many are alike?

use serde::Serialize;
use std::ops::Deref;
use std::sync::Arc;

/// A grid axis with the values met in the file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Axis {
    /// Column name.
    pub name: String,
    /// SI unit, `1` when dimensionless.
    pub unit: String,
    /// Values met, ascending.
    pub values: Vec<f64>,
}

/// Positions of the axes with several values: those that tell points apart.
pub(super) fn varied(axes: &[Axis]) -> impl Iterator<Item = usize> {
    let several = |(_, axis): &(usize, &Axis)| axis.values.len() > 1;
    axes.iter()
        .enumerate()
        .filter(several)
        .map(|(index, _)| index)
}

/// How many points move in one way.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ClassCount {
    /// `steady_contact`, `periodic`, …; `none` for points without a class.
    pub class: String,
    /// Period of periodic motion.
    pub period: Option<u64>,
    /// Points.
    pub points: usize,
}

/// One point, as far as a summary needs it.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct PointSummary {
    /// Row-major index into the grid.
    pub point_id: u64,
    /// Value of each axis.
    pub axis_values: Vec<f64>,
    /// How its work ended, and how it moves.
    #[serde(flatten)]
    pub verdict: Arc<Verdict>,
    /// Largest exponent \[1/cycle\].
    pub lambda: Option<f64>,
    /// Its standard error.
    pub stderr: Option<f64>,
    /// The twin's exponent.
    pub twin: Option<f64>,
    /// How long its chaos lasts; absent where no trajectory was chaotic.
    pub chaos: Option<Box<ChaosLife>>,
}

impl Deref for PointSummary {
    type Target = Verdict;

    fn deref(&self) -> &Verdict {
        &self.verdict
    }
}

/// What a summary says of a point in words. Most points share theirs with many others, which keeps a million of them small.
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash, Serialize)]
pub struct Verdict {
    /// Direction of its sweep, `up` or `down`; absent where points are independent.
    pub direction: Option<String>,
    /// How the work ended.
    pub status: String,
    /// Why.
    pub reason: String,
    /// Kind of motion.
    pub class: Option<String>,
    /// Its period, where it has one.
    pub period: Option<u64>,
    /// Whether the exponents of the point and of its twin agree.
    pub twin_agrees: Option<bool>,
    /// Whether standard errors were read after as many cycles as their coverage was measured at;
    /// absent where the motion settles.
    pub errors_verified: Option<bool>,
}

impl PointSummary {
    /// Whether neighbours part exponentially, for a time at least.
    pub fn is_chaos(&self) -> bool {
        matches!(self.class.as_deref(), Some(CHAOTIC | TRANSIENT_CHAOS))
    }
}

/// The class of chaos that no trajectory left.
pub(super) const CHAOTIC: &str = "chaotic";
/// The class of chaos that some trajectories left.
pub(super) const TRANSIENT_CHAOS: &str = "transient_chaos";

/// How long the chaos of a point lasts, in mesh cycles.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct ChaosLife {
    /// Mean life; absent where no trajectory left chaos.
    pub mean: Option<f64>,
    /// Lower end of its 95 % interval; a lower bound at 95 % where no trajectory left chaos.
    pub low: f64,
    /// Upper end of the interval; absent where no trajectory left chaos.
    pub high: Option<f64>,
    /// Trajectories that left chaos.
    pub exits: u64,
    /// Trajectories that were measured.
    pub trajectories: Option<u64>,
    /// What those that left chaos ended on.
    pub ended_on: Option<String>,
}
