//! Meshes of a train besides its first one, and the force laws of their flanks.

use super::nodes::Assembled;
use super::speeds::sense;
use super::{GearPlace, ShaftCoupling, TrainDrive, TrainError};
use crate::gear::MeshTableSpec;
use crate::shaft::assembly::{AssembledMatrices, Freedom};
use crate::structure::ContactLaw;
use serde::Serialize;

/// A further mesh: two contacts, for driving and coasting of the first gear.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrainMesh {
    /// The driving gear and the driven one.
    pub gears: [GearPlace; 2],
    /// Operating pressure angle \[rad\].
    pub pressure_angle: f64,
    /// Force law of its flanks.
    pub law: MeshLaw,
}

/// Force law of the flanks of a further mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum MeshLaw {
    /// The law of the first mesh, with a phase lead.
    OfFirst {
        /// Phase lead over the first mesh, in cycles.
        phase: f64,
    },
    /// Separate laws of the drive and the coast flanks.
    Own(Box<[ContactLaw; 2]>),
    /// From the drawing, at the mean load of an operating point.
    Drawn(Box<DrawnLaw>),
}

/// A further mesh from the drawing of its gears.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DrawnLaw {
    /// Rules for the table, from a drawing whose first gear rotates forwards ([`TrainDrive::invert_backward_helices`]).
    pub table: MeshTableSpec,
    /// Angle between the flanks in the plane of action before the load acts \[rad\].
    pub misalignment: f64,
    /// Coulomb friction coefficient μ.
    pub friction: f64,
    /// Mesh phase about which the coast flanks mirror the drive flanks, in cycles.
    pub symmetry: f64,
    /// Properties of the drive flanks that are not in the drawing: gap, damping, phase, imposed error.
    pub undrawn_properties: ContactLaw,
}

impl MeshLaw {
    /// This law with a phase lead in cycles.
    pub fn with_phase_lead(&self, cycles: f64) -> Self {
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
                undrawn_properties: later(&drawn.undrawn_properties),
                ..DrawnLaw::clone(drawn)
            })),
        }
    }

    /// Whether the stiffness of the mesh varies over its cycle.
    pub(super) fn varies(&self) -> bool {
        match self {
            Self::OfFirst { .. } => false,
            Self::Own(flanks) => !flanks.iter().all(ContactLaw::is_constant),
            Self::Drawn(_) => true,
        }
    }
}

impl TrainDrive {
    /// Mass of the first mesh along the line of action \[kg\], `1/m = Σ (∂δ/∂θ)²/J` over the bodies with its gears:
    /// shafts that rotate as rigid bodies, with everything on them, or loose gears (m_red of ISO 6336-1). `None` if
    /// these bodies are the rigid modes of the train, or if none of them rotates.
    pub(super) fn mesh_mass(
        &self,
        matrices: &AssembledMatrices,
        assembled: &Assembled,
        mesh: &[(usize, Freedom, f64)],
    ) -> Option<f64> {
        let joined = |coupling: &ShaftCoupling| coupling.stiffness[3] > 0.0;
        if self.planetary.is_empty() && !self.couplings.iter().any(joined) {
            return None;
        }
        let deflection = matrices.functional(mesh);
        let of_body = |place: &GearPlace| {
            let body = self.body_of(*place);
            let nodes = match body.checked_sub(self.shafts.len()) {
                Some(number) => assembled.loose[number]..assembled.loose[number] + 1,
                None => assembled.independent_nodes(body),
            };
            let turning: Vec<_> = nodes.map(|node| (node, Freedom::RotationZ, 1.0)).collect();
            let turning = matrices.functional(&turning);
            let dot = |row: &[f64]| -> f64 { row.iter().zip(&turning).map(|(a, b)| a * b).sum() };
            let inertia = dot(&matrices.momentum(&turning));
            if inertia > 0.0 { dot(&deflection).powi(2) / inertia } else { 0.0 }
        };
        let inverse: f64 = self.gears.iter().map(of_body).sum();
        (inverse > 0.0).then(|| 1.0 / inverse)
    }

    /// Direction in which a gear rolls in its meshes if the first gear rolls forwards: −1 or 1.
    ///
    /// # Errors
    /// [`TrainError`].
    pub fn rolling_sense(&self, gear: GearPlace) -> Result<f64, TrainError> {
        Ok(sense(self.layout()?.mesh_speeds[self.body_of(gear)]))
    }

    /// Inverts the helix of drawn meshes whose first gear rotates backwards. Seen from the other end of its shaft, the
    /// gear rotates forwards. From there the hand of the helix is the same, but positions across the face change their
    /// sign. So does the slope of the lines of contact.
    ///
    /// # Errors
    /// [`TrainError`].
    pub fn invert_backward_helices(&mut self) -> Result<(), TrainError> {
        let mesh_speeds = self.layout()?.mesh_speeds;
        for number in 0..self.meshes.len() {
            let body = self.body_of(self.meshes[number].gears[0]);
            if let (MeshLaw::Drawn(drawn), true) =
                (&mut self.meshes[number].law, mesh_speeds[body] < 0.0)
            {
                drawn.table.gears.helix_angle *= -1.0;
            }
        }
        Ok(())
    }
}
