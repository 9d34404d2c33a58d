//! A run-up, and the quantities that it records.

use crate::analysis::Signals;
use crate::analysis::run_up::LoadLaw;
use crate::numerics::point_course::PointCourse;

/// The contents of `[runup]`.
#[derive(Debug, Clone, PartialEq)]
pub struct RunUpSpec {
    /// Speed of the pinion \[rad/s\] over the time since the start \[s\].
    pub speed: PointCourse,
    /// The load; `None` for that of the operating point.
    pub load: Option<RunUpLoad>,
    /// Time at the first speed before the run-up \[s\].
    pub settle: f64,
    /// Samples per second.
    pub sample_rate: u32,
    /// Revolutions of the pinion for each value of orders and levels.
    pub revolutions: u32,
    /// Orders of the pinion's rotation; `None` for the first orders of the mesh.
    pub orders: Option<Vec<f64>>,
    /// Distance between lines of the spectrogram \[Hz\].
    pub frequency_step: u32,
    /// The recorded signals.
    pub signals: Signals,
}

/// The load of a run-up.
#[derive(Debug, Clone, PartialEq)]
pub struct RunUpLoad {
    /// The values over time or speed.
    pub law: LoadLaw,
    /// Whether the values are torques on the pinion \[N m\] instead of fractions of the rated load.
    pub is_torque: bool,
}
