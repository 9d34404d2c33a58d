//! The modes of a train, and the values of sums of freedoms in them.

use super::contacts::FlankTerms;
use crate::shaft::assembly::{AssembledMatrices, Freedom};
use crate::shaft::modes::Modes;
use crate::structure::FlankParticipation;

/// Modes of a train before evaluation.
pub(super) struct Solved<'a> {
    pub matrices: &'a AssembledMatrices,
    pub modes: &'a Modes,
    /// Sign of each mode after the neutral rotation.
    pub signs: Vec<f64>,
    /// The neutral rotation in the rigid modes, a unit vector.
    pub neutral: Vec<f64>,
}

impl Solved<'_> {
    /// Values of a sum of freedoms in the structure's modes.
    pub fn participation(&self, terms: &[(usize, Freedom, f64)]) -> Vec<f64> {
        let mut column = self.modes.participation(&self.matrices.functional(terms));
        self.to_structure_modes(&mut column);
        column
    }

    /// Participation of a contact, which is zero in the neutral rotation.
    pub fn contact_participation(&self, terms: &[(usize, Freedom, f64)]) -> Vec<f64> {
        let mut column = self.participation(terms);
        column[0] = 0.0;
        column
    }

    pub fn flank(&self, terms: &FlankTerms) -> FlankParticipation {
        FlankParticipation {
            mesh: self.contact_participation(&terms.mesh),
            tilt: self.participation(&terms.tilt),
            friction: self.participation(&terms.friction),
            lever: self.participation(&terms.lever),
            residual_flexibility: 0.0,
        }
    }

    /// Rotates the rigid modes so that the first is the neutral rotation, by a Householder
    /// reflection, and applies the signs of the other modes.
    pub fn to_structure_modes(&self, column: &mut [f64]) {
        let side = if self.neutral[0] > 0.0 { -1.0 } else { 1.0 };
        let mut normal = self.neutral.clone();
        normal[0] -= side;
        let square: f64 = normal.iter().map(|v| v * v).sum();
        let along: f64 = normal.iter().zip(column.iter()).map(|(v, x)| v * x).sum();
        for (x, v) in column.iter_mut().zip(&normal) {
            *x -= 2.0 * along * v / square;
        }
        // The reflection maps the neutral rotation to `side` times the first axis.
        column[0] *= side;
        for (value, sign) in column[1..].iter_mut().zip(&self.signs) {
            *value *= sign;
        }
    }
}
