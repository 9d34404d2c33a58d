//! Meshes of a train beside its first one, and what their flanks bear.

use super::speeds::sense;
use super::{GearPlace, TrainDrive, TrainError};
use crate::gear::MeshTableSpec;
use crate::structure::ContactLaw;
use serde::Serialize;

/// A further mesh: two contacts, where the first gear drives and where it coasts.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrainMesh {
    /// The driving gear and the driven one.
    pub gears: [GearPlace; 2],
    /// Operating pressure angle \[rad\].
    pub pressure_angle: f64,
    /// What its flanks bear.
    pub law: MeshLaw,
}

/// What the flanks of a further mesh bear.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum MeshLaw {
    /// What the first mesh bears, so many cycles ahead of it.
    OfFirst {
        /// Phase against the first mesh, in cycles.
        phase: f64,
    },
    /// That of the drive flanks and that of the coast flanks.
    Own(Box<[ContactLaw; 2]>),
    /// What the drawing says under the mean load of an operating point.
    Drawn(Box<DrawnLaw>),
}

/// A further mesh from the drawing of its gears.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DrawnLaw {
    /// How it follows from the drawing: of two gears of which the first turns forwards ([`TrainDrive::turn_helices`]).
    pub table: MeshTableSpec,
    /// Angle between the flanks in the plane of action before the load acts \[rad\].
    pub misalignment: f64,
    /// Coulomb friction coefficient μ.
    pub friction: f64,
    /// Mesh phase about which the coast flanks mirror the drive flanks, in cycles.
    pub symmetry: f64,
    /// Everything that the drawing does not say of the drive flanks: gap, damping, phase, imposed error.
    pub beside: ContactLaw,
}

impl MeshLaw {
    /// The same, so many cycles ahead.
    pub fn ahead(&self, cycles: f64) -> Self {
        let later = |law: &ContactLaw| ContactLaw {
            phase: law.phase + cycles,
            ..law.clone()
        };
        match self {
            Self::OfFirst { phase } => Self::OfFirst {
                phase: phase + cycles,
            },
            Self::Own(flanks) => Self::Own(Box::new(flanks.each_ref().map(later))),
            Self::Drawn(drawn) => Self::Drawn(Box::new(DrawnLaw {
                beside: later(&drawn.beside),
                ..DrawnLaw::clone(drawn)
            })),
        }
    }

    /// Whether its stiffness varies over the cycle by itself.
    pub(super) fn varies(&self) -> bool {
        match self {
            Self::OfFirst { .. } => false,
            Self::Own(flanks) => !flanks.iter().all(ContactLaw::is_constant),
            Self::Drawn(_) => true,
        }
    }
}

impl TrainDrive {
    /// The sense in which a gear rolls as its meshes see it, where the first gear rolls forwards: −1 or 1.
    ///
    /// # Errors
    /// [`TrainError`].
    pub fn rolling_sense(&self, gear: GearPlace) -> Result<f64, TrainError> {
        Ok(sense(self.layout()?.rolling[self.body_of(gear)]))
    }

    /// Gives drawn meshes whose first gear turns backwards the opposite helix. Seen from the other end of its shaft, where
    /// it turns forwards, the hand is the same, but places across the face change their sign; so do the lines of contact.
    ///
    /// # Errors
    /// [`TrainError`].
    pub fn turn_helices(&mut self) -> Result<(), TrainError> {
        let rolling = self.layout()?.rolling;
        for number in 0..self.meshes.len() {
            let body = self.body_of(self.meshes[number].gears[0]);
            if let (MeshLaw::Drawn(drawn), true) =
                (&mut self.meshes[number].law, rolling[body] < 0.0)
            {
                drawn.table.gears.helix_angle *= -1.0;
            }
        }
        Ok(())
    }
}
