//! What a run-up is, and what of it is recorded.

use crate::analysis::Signals;
use crate::analysis::run_up::LoadLaw;
use crate::numerics::point_course::PointCourse;

/// What `[runup]` asks for.
#[derive(Debug, Clone, PartialEq)]
pub struct RunUpSpec {
    /// Speed of the pinion \[rad/s\] over the time since the start \[s\].
    pub speed: PointCourse,
    /// The load; none for that of the operating point.
    pub load: Option<RunUpLoad>,
    /// Time at the first speed before \[s\].
    pub settle: f64,
    /// Samples a second.
    pub sample_rate: u32,
    /// Revolutions of the pinion over which orders and levels are taken.
    pub revolutions: u32,
    /// Orders of the pinion's rotation; none for the first of the mesh.
    pub orders: Option<Vec<f64>>,
    /// Distance of lines of the spectrogram \[Hz\].
    pub frequency_step: u32,
    /// What is recorded.
    pub signals: Signals,
}

/// The load of a run-up.
#[derive(Debug, Clone, PartialEq)]
pub struct RunUpLoad {
    /// Its values.
    pub law: LoadLaw,
    /// Whether they are torques of the pinion \[N m\] in place of fractions of the rated one.
    pub is_torque: bool,
}
