//! Which forces do the blocks and the omitted modes exert on the bearings?

use super::basis::Basis;
use super::{DriveShaft, OperatingPoint, TorqueRipple};
use crate::structure::{BearingGain, ModalStructure, OmittedModeForces};

/// The force of a bearing's springs and dampers in one direction, `Σ gain·x` \[N\]. Omitted modes follow
/// their loads statically. They add a constant, an amplitude per ripple, and a share of every contact force
/// ([`super::Direction::on_bearings`]).
#[derive(Debug, Clone, PartialEq)]
pub struct BearingOutput {
    /// Shaft, bearing and direction.
    pub name: String,
    /// Force per unit of both components of each block.
    pub gain: Vec<[f64; 2]>,
    /// Static force of the omitted modes under the mean load \[N\].
    pub constant: f64,
    /// Change of `constant` by rated load \[N\]: its derivative with respect to the load.
    pub(super) by_load: f64,
    /// Amplitude of the static force of the omitted modes under each of [`super::Model::ripple`] \[N\].
    pub by_ripple: Vec<f64>,
}

impl BearingOutput {
    /// The output of a bearing of a structure.
    pub(super) fn new(
        bearing: &BearingGain,
        structure: &ModalStructure,
        torques: &[TorqueRipple],
        point: OperatingPoint,
        basis: &Basis,
    ) -> Self {
        let share = &bearing.left_out;
        let [pinion, wheel] = share.shaft_torques;
        let by_torque = torques.iter().map(|ripple| {
            ripple.amplitude
                * match ripple.shaft {
                    DriveShaft::Pinion => pinion,
                    DriveShaft::Wheel => wheel,
                }
        });
        let by_load = share.torque * structure.rated_force;
        Self {
            name: bearing.name.clone(),
            gain: basis.output_of(&bearing.gain, &bearing.rate_gain),
            by_load,
            constant: by_load * point.load
                + share.constant_load
                + share.load_by_speed * point.speed
                + share.frame_load * point.speed * point.speed,
            by_ripple: by_torque
                .chain(share.harmonic_loads.iter().copied())
                .collect(),
        }
    }
}

/// Static forces on every bearing per unit force of one kind of contact; empty if no mode is omitted.
pub(super) fn on_each<T>(
    structure: &ModalStructure,
    pick: impl Fn(&OmittedModeForces) -> T,
) -> Vec<T> {
    let nothing = OmittedModeForces::default();
    let omitted_forces = structure.bearings.iter().map(|bearing| &bearing.left_out);
    if omitted_forces.clone().all(|share| *share == nothing) {
        Vec::new()
    } else {
        omitted_forces.map(pick).collect()
    }
}
