//! The run-up of one operating point.

use super::build::BuildError;
use super::parts::Prepared;
use crate::analysis::CalledOff;
use crate::analysis::run_up::{RunUp, RunUpConfig, record};
use crate::manifest::{PointSpec, RunUpSpec};
use crate::propagate::InstructionSet;
use crate::propagate::varying_speed::{VaryingSpeed, VaryingSpeedError};
use std::f64::consts::TAU;
use std::sync::atomic::AtomicBool;

/// Orders of the mesh that are tracked where none is asked for.
const MESH_ORDERS: u32 = 5;

/// What is to be run up.
#[derive(Debug)]
pub struct PointRunUp<'a> {
    /// The drive and its load.
    pub point: &'a PointSpec,
    /// The run-up.
    pub spec: &'a RunUpSpec,
    /// Structures and tables at hand.
    pub parts: &'a Prepared,
}

/// Why a drive was not run up.
#[derive(Debug, thiserror::Error)]
pub enum RunUpError {
    /// There is no such drive.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// Its speed cannot vary.
    #[error(transparent)]
    Kernel(#[from] VaryingSpeedError),
    /// It was called off.
    #[error("interrupted")]
    CalledOff,
}

impl PointRunUp<'_> {
    /// Runs the drive up; where the motion cannot go on, what is recorded ends there.
    ///
    /// # Errors
    /// [`RunUpError`].
    pub fn record(&self, called_off: &AtomicBool) -> Result<(RunUpConfig, RunUp), RunUpError> {
        let spec = self.spec;
        let load = spec.load.unwrap_or([self.point.load; 2]);
        let start = PointSpec {
            speed: spec.speed[0],
            load: load[0],
            ..self.point.clone()
        };
        let model = self.parts.model(&start)?;
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
        let teeth = kernel.cycles_per_radian() * TAU;
        let of_mesh = || {
            (1..=MESH_ORDERS)
                .map(|order| f64::from(order) * teeth)
                .collect()
        };
        let config = RunUpConfig {
            speed: spec.speed,
            load,
            duration: spec.duration,
            settle: spec.settle,
            sample_rate: f64::from(spec.sample_rate),
            revolutions: spec.revolutions,
            orders: spec.orders.clone().unwrap_or_else(of_mesh),
            frequency_step: f64::from(spec.frequency_step),
            signals: spec.signals,
        };
        let run = record(
            &kernel,
            &model.start(&start.run.initial),
            &config,
            called_off,
        )
        .map_err(|CalledOff| RunUpError::CalledOff)?;
        Ok((config, run))
    }
}
