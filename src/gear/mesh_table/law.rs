//! What the mesh does at one phase of its cycle, under every load of a table.

use super::super::friction::friction_direction;
use super::super::sharing::{Contact, Face, LoadSharing, MOST_PAIRS, SharingError, pairs_at};
use super::{MeshTableError, MeshTableInputs};
use crate::gear::flank_law::{FlankLaw, SecantContact};

/// The law that a table holds.
#[derive(Debug, Clone, Copy)]
pub(super) struct MeshLaw<'a, L> {
    pub flanks: &'a L,
    pub inputs: &'a MeshTableInputs,
}

/// All loads at one mesh phase, misalignment by misalignment.
pub(super) struct Column {
    pub phase: f64,
    pub cells: Vec<Cell>,
    /// Which formula bears each load: the law is smooth while this stays.
    pub regime: Vec<bool>,
}

/// What the mesh does at one phase under one load.
pub(super) struct Cell {
    pub stiffness: f64,
    pub centre: f64,
    pub transmission_error: f64,
    pub tangent_error: f64,
    pub friction: f64,
    pub friction_lever: f64,
    pub contact_fraction: f64,
    pub share: [f64; MOST_PAIRS],
    /// Distances from the kinks of the law (see [`LoadSharing::margins`]).
    pub margins: Vec<f64>,
    /// Line load on each slice; empty where it is not asked for.
    pub pattern: Vec<f64>,
}

/// A value of the law, and what its errors are held against.
#[derive(Debug, Clone, Copy)]
pub(super) struct Quantity {
    pub name: &'static str,
    pub value: f64,
    pub scale: f64,
}

impl<L: FlankLaw> MeshLaw<'_, L> {
    /// The law at a phase.
    pub fn column(&self, phase: f64) -> Result<Column, MeshTableError> {
        let cells =
            (self.cells(phase)).map_err(|source| MeshTableError::Sharing { phase, source })?;
        let regime = (cells.iter())
            .flat_map(|cell| cell.margins.iter().map(|margin| *margin >= 0.0))
            .collect();
        Ok(Column {
            phase,
            cells,
            regime,
        })
    }

    fn cells(&self, phase: f64) -> Result<Vec<Cell>, SharingError> {
        let Self { flanks, inputs } = *self;
        let face = Face {
            width: inputs.face_width,
            slices: inputs.slices,
        };
        let pairs = pairs_at(flanks, phase, face)?;
        let pitch_point = flanks.path().pitch_point;
        let positions: Vec<f64> = pairs.iter().map(|p| p.position - pitch_point).collect();
        let mut cells = Vec::with_capacity(inputs.misalignment.len() * inputs.torque.len());
        for &misalignment in &inputs.misalignment {
            let mut sharing = LoadSharing::new(&pairs, face, misalignment)?;
            for &torque in &inputs.torque {
                let force = torque / inputs.base_radius;
                match inputs.contact {
                    Contact::Linear => {}
                    Contact::Secant => {
                        let law = SecantContact {
                            law: flanks,
                            line_load: force / face.width,
                        };
                        let pairs = pairs_at(&law, phase, face)?;
                        sharing = LoadSharing::new(&pairs, face, misalignment)?;
                    }
                    Contact::LoadDependent => {
                        sharing = LoadSharing::under(flanks, phase, face, misalignment, force)?;
                    }
                }
                let load = sharing.bear(force);
                let friction = friction_direction(&positions, &load.share);
                let pattern = if inputs.pattern {
                    let pairs = sharing.pattern(force);
                    (0..inputs.slices)
                        .map(|slice| pairs.iter().skip(slice).step_by(inputs.slices).sum())
                        .collect()
                } else {
                    Vec::new()
                };
                cells.push(Cell {
                    stiffness: load.stiffness,
                    centre: load.centre,
                    transmission_error: load.deflection,
                    tangent_error: load.deflection - force / load.stiffness,
                    friction: friction.direction,
                    friction_lever: friction.lever,
                    contact_fraction: load.contact_fraction,
                    share: load.share,
                    margins: sharing.margins(load.deflection),
                    pattern,
                });
            }
        }
        Ok(cells)
    }

    /// All that has to follow the law: stiffness first. Lengths of deflection are held against
    /// what the load deflects the mesh by.
    pub fn quantities(&self, cell: &Cell) -> [Quantity; 7 + MOST_PAIRS] {
        let deflection = cell.transmission_error - cell.tangent_error;
        let (width, pitch) = (self.inputs.face_width, self.flanks.path().base_pitch);
        let share = |pair: usize| ("load share", cell.share[pair], 1.0);
        [
            ("stiffness", cell.stiffness, cell.stiffness),
            ("transmission error", cell.transmission_error, deflection),
            ("tangent error", cell.tangent_error, deflection),
            ("load centroid", cell.centre, width),
            ("friction direction", cell.friction, 1.0),
            ("friction lever", cell.friction_lever, pitch),
            ("loaded part", cell.contact_fraction, 1.0),
            share(0),
            share(1),
            share(2),
        ]
        .map(|(name, value, scale)| Quantity { name, value, scale })
    }
}
