//! The run-up of one operating point.

use super::build::BuildError;
use super::parts::Prepared;
use crate::analysis::Interrupted;
use crate::analysis::run_up::{LoadLaw, RunUp, RunUpConfig, record};
use crate::manifest::{PointSpec, RunUpSpec};
use crate::numerics::point_course::PointCourse;
use crate::propagate::InstructionSet;
use crate::propagate::varying_speed::{VaryingSpeed, VaryingSpeedError};
use std::f64::consts::TAU;
use std::sync::atomic::AtomicBool;

/// Number of mesh orders that are tracked by default.
const MESH_ORDERS: u32 = 5;

/// A point with its run-up.
#[derive(Debug)]
pub struct PointRunUp<'a> {
    /// The drive and its load.
    pub point: &'a PointSpec,
    /// The run-up.
    pub spec: &'a RunUpSpec,
    /// Structures and tables that points share.
    pub parts: &'a Prepared,
}

/// Reason why a run-up cannot be recorded.
#[derive(Debug, thiserror::Error)]
pub enum RunUpError {
    /// The drive cannot be built.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The kernel cannot vary its speed.
    #[error(transparent)]
    Kernel(#[from] VaryingSpeedError),
    /// A modal file has no rated torque.
    #[error(
        "a run-up with torques needs a rated torque, but a modal file has none; give the column `load`, a fraction of rated_force"
    )]
    NoRatedTorque,
    /// It is unknown where the torque acts that accelerates the drive.
    #[error(
        "the speed changes, but the modal file does not tell where the torque acts that accelerates the drive; add `torque_pinion`"
    )]
    NoPositionOfTorque,
    /// The run-up was interrupted.
    #[error("interrupted")]
    Interrupted,
}

impl PointRunUp<'_> {
    /// Runs the drive up. Returns its configuration and its record, which ends where the motion cannot continue.
    ///
    /// # Errors
    /// [`RunUpError`].
    pub fn record(&self, interrupt: &AtomicBool) -> Result<(RunUpConfig, RunUp), RunUpError> {
        let spec = self.spec;
        let mut config = RunUpConfig {
            speed: spec.speed.clone(),
            load: self.load()?,
            settle: spec.settle,
            sample_rate: f64::from(spec.sample_rate),
            revolutions: spec.revolutions,
            orders: spec.orders.clone().unwrap_or_default(),
            frequency_step: f64::from(spec.frequency_step),
            signals: spec.signals,
        };
        // Mesh and friction are those under the load of the point.
        let start = PointSpec {
            speed: config.speed_at(0.0),
            ..self.point.clone()
        };
        let model = self.parts.model(&start)?;
        let loaded = (model.under_load(config.load_at(0.0))).map_err(BuildError::from)?;
        let structure = self
            .parts
            .structure(&start.model)
            .map_err(BuildError::from)?;
        let kernel = VaryingSpeed::new(
            &structure,
            &model,
            start.run.event_limit,
            InstructionSet::best(),
        )?;
        let speeds = config.speed.points.iter().map(|point| point[1]);
        let varies = speeds
            .clone()
            .any(|speed| Some(speed) != speeds.clone().next());
        if varies && kernel.lacks_torque() {
            return Err(RunUpError::NoPositionOfTorque);
        }
        let teeth = kernel.cycles_per_radian() * TAU;
        if spec.orders.is_none() {
            config.orders = (1..=MESH_ORDERS)
                .map(|order| f64::from(order) * teeth)
                .collect();
        }
        let run = record(
            &kernel,
            &loaded.start(&start.run.initial),
            &config,
            interrupt,
        )
        .map_err(|Interrupted| RunUpError::Interrupted)?;
        Ok((config, run))
    }

    /// The load, as a fraction of the rated load.
    fn load(&self) -> Result<LoadLaw, RunUpError> {
        let Some(load) = &self.spec.load else {
            return Ok(LoadLaw::OverTime(PointCourse::constant(self.point.load)));
        };
        if !load.is_torque {
            return Ok(load.law.clone());
        }
        let rated = self.point.model.source.rated_torque();
        Ok(load
            .law
            .scaled(1.0 / rated.ok_or(RunUpError::NoRatedTorque)?))
    }
}
