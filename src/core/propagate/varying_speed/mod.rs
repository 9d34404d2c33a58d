//! How does a drive move while its speed varies?
//!
//! Mesh phase, transmission errors, stiffness and ripple follow the mean rotation. On a [`SpeedInterval`] the
//! rotation and the loads are polynomials of time. A motion may start and stop at any time. The mean rotation
//! is that of the whole drive as a rigid body, and mesh forces do not act on it.
//! [`SpeedInterval::accelerated`] gives the torque that accelerates it.
//!
//! The kernel integrates in power series of time. They do not depend on a fixed speed, so no table is rebuilt while
//! the speed varies.

mod advance;
mod motion_observer;
mod powers;
mod responses;
mod rows;
mod search;
mod speed_interval;
mod system;
mod window;

pub use advance::Workspace;
pub use motion_observer::{Instant, MotionObserver, MovingEvent, MovingSignal, VaryingSpeedWindow};
pub use powers::{COURSE_TERMS, Course, Powers, place_of, value};
pub use speed_interval::SpeedInterval;

use super::InstructionSet;
use crate::model::{ActiveSet, LOAD_TERMS, Model, TrajectoryState};
use crate::structure::ModalStructure;
use rows::{Rows, rows};
use std::f64::consts::TAU;
use system::System;

/// Reasons why a drive cannot run at a varying speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum VaryingSpeedError {
    /// Its modes change with the speed.
    #[error(
        "gyroscopic terms or a turning frame change the modes with the speed; leave them out (model.gyroscopic = false)"
    )]
    Gyroscopic,
    /// It has dry sliders.
    #[error(
        "a dry slider cannot be integrated at a speed that varies; replace it by a spring with a damper"
    )]
    Sliders,
    /// It has rigid stops.
    #[error(
        "a rigid stop cannot be integrated at a speed that varies; give contact.*.stiffness in place of contact.*.restitution"
    )]
    RigidStops,
    /// It has dry friction that sticks.
    #[error(
        "dry friction cannot be integrated at a speed that varies; replace `[[dry_friction]]` by a damper"
    )]
    DryFriction,
}

/// A motion of a drive whose speed varies.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// First components of all blocks, then second components: length 2N.
    pub state: Vec<f64>,
    /// The closed contacts.
    pub contact: ActiveSet,
    /// Mesh cycle.
    pub cycle: u64,
    /// Mesh phase in \[0, 1).
    pub phase: f64,
    /// Time \[s\].
    pub time: f64,
    /// Contacts with an event at this time, whose margins are therefore zero: first those on their surfaces, then
    /// those with zero force.
    pub standing: [ActiveSet; 2],
    /// Number of openings and closings in this mesh cycle.
    pub events: u32,
}

/// The kernel of a drive whose speed varies.
#[derive(Debug, Clone)]
pub struct VaryingSpeed {
    model: Model,
    system: System,
    /// Mesh cycles per radian of the pinion.
    cycles_per_radian: f64,
    /// Angular acceleration of the pinion per unit torque on each shaft \[1/(kg m²)\]; see
    /// [`crate::model::LoadTerms`].
    mobility: [Option<f64>; 2],
    on_bearings: Vec<[f64; LOAD_TERMS]>,
    outputs: Vec<Rows>,
    bearings: Vec<Rows>,
    /// Mesh phases at which a segment of any contact ends, one list per cycle of a base period.
    ends: Vec<Vec<f64>>,
    /// Largest deflection along every line. Beyond it, a motion has diverged.
    farthest: Vec<f64>,
    event_limit: u32,
    instructions: InstructionSet,
}

impl VaryingSpeed {
    /// The kernel of a model, built from its structure. The speed of the model does not matter.
    ///
    /// * `event_limit`: largest number of events in a mesh cycle before integration stops.
    ///
    /// # Errors
    /// [`VaryingSpeedError`] if modes change with the speed, or if there are dry sliders, rigid stops or dry
    /// friction.
    pub fn new(
        structure: &ModalStructure,
        model: &Model,
        event_limit: u32,
        instructions: InstructionSet,
    ) -> Result<Self, VaryingSpeedError> {
        let turns = model.basis.coupled().is_some_and(|coupled| coupled.turns);
        if turns || !structure.frame.stiffness.is_empty() {
            return Err(VaryingSpeedError::Gyroscopic);
        }
        if !model.sliders.is_empty() {
            return Err(VaryingSpeedError::Sliders);
        }
        if !model.stops.is_empty() {
            return Err(VaryingSpeedError::RigidStops);
        }
        if !model.frictions.is_empty() {
            return Err(VaryingSpeedError::DryFriction);
        }
        let loads = model.load_terms(structure);
        let system = System::new(model, &loads);
        let of_gain = |gain: &[[f64; 2]]| rows(gain.iter().copied());
        Ok(Self {
            cycles_per_radian: structure.cycles_per_turn() / TAU,
            mobility: loads.mobility,
            on_bearings: loads.on_bearings,
            outputs: (model.outputs.iter())
                .map(|output| of_gain(&output.gain))
                .collect(),
            bearings: (model.bearings.iter())
                .map(|bearing| of_gain(&bearing.gain))
                .collect(),
            ends: (0..model.base_cycles() as u64)
                .map(|cycle| model.segment_ends(cycle))
                .collect(),
            farthest: super::farthest(model),
            system,
            model: model.clone(),
            event_limit,
            instructions,
        })
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Mesh cycles per radian of the pinion.
    pub fn cycles_per_radian(&self) -> f64 {
        self.cycles_per_radian
    }

    /// Mean angular acceleration of the pinion \[rad/s²\] under torques \[N m\] on the pinion's and the
    /// wheel's shaft. Each torque is positive in its sense of rotation. `None` if the drive does not rotate
    /// freely, or if dampers slow it down.
    pub fn mean_acceleration(&self, torques: [f64; 2]) -> Option<f64> {
        let is_damped = |i: usize| !self.model.neutral.contains(&i);
        if self.model.free_rotations().any(is_damped) {
            return None;
        }
        let [pinion, wheel] = self.mobility;
        Some(pinion? * torques[0] + wheel? * torques[1])
    }

    /// Whether the drive has flanks and rotates freely, but the structure does not define how a torque on the
    /// pinion's shaft acts on it.
    pub fn lacks_torque(&self) -> bool {
        let rotates_freely =
            self.model.has_flanks() && self.model.free_rotations().next().is_some();
        rotates_freely && self.mobility[0].is_none()
    }

    /// A motion that continues a trajectory, at time 0.
    pub fn start(&self, trajectory: &TrajectoryState) -> Motion {
        Motion {
            state: trajectory.state.clone(),
            contact: trajectory.contact,
            cycle: trajectory.cycle,
            phase: 0.0,
            time: 0.0,
            standing: [ActiveSet::FREE; 2],
            events: 0,
        }
    }

    /// Scratch memory. With it, `advance` allocates nothing.
    pub fn workspace(&self) -> Workspace {
        self.prepare_search();
        Workspace::new(self)
    }
}

#[cfg(test)]
mod tests;
