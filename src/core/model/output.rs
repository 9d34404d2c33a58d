//! Outputs of the structure besides the mesh: forces, torques, accelerations and rotations at given points.

use super::basis::Basis;
use super::{COAST_FLANK, DRIVE_FLANK};
use crate::structure::{ModalStructure, MotionKind, PlaceMotion, TorqueGain};

/// Kind of an output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Force of a shaft on a bearing \[N\].
    BearingForce,
    /// Torque in a shaft or a coupling \[N m\].
    Torque,
    /// Acceleration of a point \[m/s²\].
    Acceleration,
    /// Angular acceleration of a body \[rad/s²\].
    AngularAcceleration,
    /// Rotation of a gear relative to the mean rotation \[rad\].
    Rotation,
    /// Deflection of a mesh along the line of its drive flank \[m\].
    MeshDeflection,
    /// Force of a mesh \[N\], positive on its drive flank, negative on its coast flank.
    MeshForce,
}

impl Quantity {
    /// The first words of the names of its signals.
    pub fn name(self) -> &'static str {
        match self {
            Self::BearingForce => "bearing",
            Self::Torque => "torque",
            Self::Acceleration => "acceleration",
            Self::AngularAcceleration => "angular acceleration",
            Self::Rotation => "rotation",
            Self::MeshDeflection => "mesh deflection",
            Self::MeshForce => "mesh force",
        }
    }

    /// Its unit.
    pub fn unit(self) -> &'static str {
        match self {
            Self::BearingForce => "N",
            Self::Torque => "N m",
            Self::Acceleration => "m/s^2",
            Self::AngularAcceleration => "rad/s^2",
            Self::Rotation => "rad",
            Self::MeshDeflection => "m",
            Self::MeshForce => "N",
        }
    }

    /// Whether an output of this kind is the time derivative of `Σ gain q + Σ rate_gain q'`.
    pub fn is_rate(self) -> bool {
        matches!(self, Self::Acceleration | Self::AngularAcceleration)
    }
}

/// A mesh of the structure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedMesh {
    /// Names of its gears.
    pub name: String,
    /// Its drive flank and its coast flank, as indices of the model's contacts.
    pub flanks: [usize; 2],
    /// Its cycles, `[p, q]`: p cycles in q cycles of the first mesh.
    pub cycles: [u32; 2],
}

impl NamedMesh {
    /// The meshes of a structure. `flank_springs` is the number of contacts of the first mesh's flanks.
    pub(super) fn of_structure(structure: &ModalStructure, flank_springs: usize) -> Vec<Self> {
        let of_mesh = |(number, name): (usize, String)| match number.checked_sub(1) {
            None => Self {
                name,
                flanks: [DRIVE_FLANK, COAST_FLANK],
                cycles: [1, 1],
            },
            Some(further) => Self {
                name,
                flanks: [0, 1].map(|flank| flank_springs + 2 * further + flank),
                cycles: structure.contacts[2 * further].cycles,
            },
        };
        (structure.mesh_names().into_iter().enumerate())
            .map(of_mesh)
            .collect()
    }

    /// Sign of a contact's force in the force of its mesh. It is −1 for the coast flank of a further mesh, which acts
    /// along a separate line.
    pub fn sign(&self, contact: usize) -> f64 {
        let [drive, coast] = self.flanks;
        if drive != DRIVE_FLANK && contact == coast { -1.0 } else { 1.0 }
    }
}

/// `Σ gain·x` over the blocks, or its rate ([`Quantity::is_rate`]).
#[derive(Debug, Clone, PartialEq)]
pub struct Output {
    /// Position and direction.
    pub name: String,
    /// Its kind.
    pub quantity: Quantity,
    /// Value per unit of both components of each block.
    pub gain: Vec<[f64; 2]>,
}

impl Output {
    /// The outputs of a structure besides its bearing forces: torques, accelerations, angular
    /// accelerations, rotations.
    pub(super) fn of_structure(structure: &ModalStructure, basis: &Basis) -> Vec<Self> {
        let torques = structure.torques.iter();
        let torques = torques.map(|torque| Self::torque(torque, basis));
        let kinds = [MotionKind::Place, MotionKind::Body, MotionKind::Gear].into_iter();
        let motions = kinds.flat_map(|kind| {
            let motions = structure.motions.iter();
            motions.filter(move |motion| motion.kind == kind)
        });
        let motions = motions.map(|motion| Self::motion(motion, basis));
        torques.chain(motions).collect()
    }

    fn torque(torque: &TorqueGain, basis: &Basis) -> Self {
        Self {
            name: torque.name.clone(),
            quantity: Quantity::Torque,
            gain: basis.output_of(&torque.gain, &torque.rate_gain),
        }
    }

    fn motion(motion: &PlaceMotion, basis: &Basis) -> Self {
        let [displacement, velocity] = basis.output(&basis.turn(&motion.gain));
        let (quantity, gain) = match motion.kind {
            MotionKind::Place => (Quantity::Acceleration, velocity),
            MotionKind::Body => (Quantity::AngularAcceleration, velocity),
            MotionKind::Gear => (Quantity::Rotation, displacement),
        };
        Self {
            name: motion.name.clone(),
            quantity,
            gain,
        }
    }
}
