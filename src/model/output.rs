//! What may be told of the structure beside the mesh: forces, torques and accelerations at places.

use super::basis::Basis;
use crate::shaft::{ModalStructure, PlaceMotion, TorqueGain};

/// What an output is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Force of a shaft on a bearing \[N\].
    BearingForce,
    /// Torque in a shaft or a coupling \[N m\].
    Torque,
    /// Acceleration of a place \[m/s²\].
    Acceleration,
    /// Angular acceleration of a body \[rad/s²\].
    AngularAcceleration,
}

impl Quantity {
    /// The word that its signals begin with.
    pub fn name(self) -> &'static str {
        match self {
            Self::BearingForce => "bearing",
            Self::Torque => "torque",
            Self::Acceleration => "acceleration",
            Self::AngularAcceleration => "angular acceleration",
        }
    }

    /// Its unit.
    pub fn unit(self) -> &'static str {
        match self {
            Self::BearingForce => "N",
            Self::Torque => "N m",
            Self::Acceleration => "m/s^2",
            Self::AngularAcceleration => "rad/s^2",
        }
    }

    /// Whether it is the rate of the sum that its gains give.
    pub fn is_rate(self) -> bool {
        matches!(self, Self::Acceleration | Self::AngularAcceleration)
    }
}

/// `Σ gain·x` over the blocks, or the rate of it ([`Quantity::is_rate`]).
#[derive(Debug, Clone, PartialEq)]
pub struct Output {
    /// Place and direction.
    pub name: String,
    /// What it is.
    pub quantity: Quantity,
    /// Value per unit of both components of each block.
    pub gain: Vec<[f64; 2]>,
}

impl Output {
    /// Those of a structure beside its bearing forces: torques, accelerations, angular accelerations.
    pub(super) fn of_structure(structure: &ModalStructure, basis: &Basis) -> Vec<Self> {
        let torques = structure.torques.iter();
        let torques = torques.map(|torque| Self::torque(torque, basis));
        let [displacements, rotations] = [false, true].map(|rotation| {
            let motions = structure.motions.iter();
            motions.filter(move |motion| motion.rotation == rotation)
        });
        let motions = displacements.chain(rotations);
        let motions = motions.map(|motion| Self::acceleration(motion, basis));
        torques.chain(motions).collect()
    }

    fn torque(torque: &TorqueGain, basis: &Basis) -> Self {
        let [mut gain, _] = basis.output(&basis.turn(&torque.gain));
        if !torque.rate_gain.is_empty() {
            let [_, by_velocity] = basis.output(&basis.turn(&torque.rate_gain));
            for (gain, own) in gain.iter_mut().zip(by_velocity) {
                *gain = [gain[0] + own[0], gain[1] + own[1]];
            }
        }
        Self {
            name: torque.name.clone(),
            quantity: Quantity::Torque,
            gain,
        }
    }

    fn acceleration(motion: &PlaceMotion, basis: &Basis) -> Self {
        let [_, velocity] = basis.output(&basis.turn(&motion.gain));
        Self {
            name: motion.name.clone(),
            quantity: match motion.rotation {
                true => Quantity::AngularAcceleration,
                false => Quantity::Acceleration,
            },
            gain: velocity,
        }
    }
}
