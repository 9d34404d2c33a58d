//! An uneven rotation of a drive, imposed on one of its shafts.
//!
//! The rotation of the drive as a rigid body is `θ + ψ`, with `ψ = a cos(order θ_shaft + phase)`. The torque `J ψ''` on
//! the shaft accelerates it, where J is the inertia of all parts that rotate with the shaft, referred to it. A shaft of
//! large inertia (a flywheel, the end of a test bench) therefore follows ψ: its share of J tends to 1.

use super::error::ModelError;
use super::excitation::shaft_of;
use super::{ImposedMotion, TorqueRipple};
use crate::structure::ModalStructure;

/// The part of a participation in the rigid motions is round-off below this fraction of the norm of the
/// participation.
const NOISE: f64 = 1e-9;

impl ImposedMotion {
    /// The torque that imposes it at this mesh period \[s\]: `−J ω² a cos(ω t + phase)`.
    ///
    /// # Errors
    /// [`ModelError::UnknownShaft`], [`ModelError::DoesNotTurn`] if the torque accelerates no rigid rotation that
    /// leaves all contacts alone.
    pub(super) fn torque(
        &self,
        structure: &ModalStructure,
        period: f64,
    ) -> Result<TorqueRipple, ModelError> {
        let (shaft, participation, cycles_per_turn) = shaft_of(structure, self.shaft)?;
        let inertia = inertia(structure, participation).ok_or(ModelError::DoesNotTurn { shaft })?;
        let frequency = std::f64::consts::TAU * self.order / (cycles_per_turn * period);
        Ok(TorqueRipple {
            shaft: self.shaft,
            order: self.order,
            amplitude: -inertia * frequency * frequency * self.amplitude,
            phase: self.phase,
        })
    }
}

/// Inertia \[kg m²\] that a torque with this participation accelerates in the rigid motions that deflect no contact.
/// `None` if the torque accelerates no such motion.
fn inertia(structure: &ModalStructure, torque: &[f64]) -> Option<f64> {
    let rigid = |column: &[f64]| -> Vec<f64> {
        let modes = column.iter().zip(&structure.frequency);
        modes
            .filter(|(_, frequency)| **frequency == 0.0)
            .map(|(part, _)| *part)
            .collect()
    };
    let size = |column: &[f64]| column.iter().map(|part| part * part).sum::<f64>().sqrt();
    // The rigid motions that deflect contacts, as orthonormal directions.
    let mut deflecting: Vec<Vec<f64>> = Vec::new();
    let without = |deflecting: &[Vec<f64>], mut column: Vec<f64>| {
        for direction in deflecting {
            let along: f64 = direction.iter().zip(&column).map(|(a, b)| a * b).sum();
            let parts = column.iter_mut().zip(direction);
            parts.for_each(|(part, unit)| *part -= along * unit);
        }
        column
    };
    let coast = structure.coast.iter().map(|flank| &flank.mesh);
    let further = structure
        .contacts
        .iter()
        .map(|contact| &contact.participation);
    for column in std::iter::once(&structure.mesh).chain(coast).chain(further) {
        let rest = without(&deflecting, rigid(column));
        let length = size(&rest);
        if length > NOISE * size(column) {
            deflecting.push(rest.iter().map(|part| part / length).collect());
        }
    }
    let free = size(&without(&deflecting, rigid(torque)));
    (free > NOISE * size(torque)).then(|| 1.0 / (free * free))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::fixtures;

    /// Two inertias on gears. Their neutral rotation is a combination of two modes.
    #[test]
    fn the_inertia_is_that_of_the_whole_drive() {
        // Pinion 2 kg m² at r = 0.1 m, wheel 3 kg m² at r = 0.2 m: modes are the single rotations.
        let [one, two] = [2f64, 3.0].map(|inertia| 1.0 / inertia.sqrt());
        let mesh = [0.1 * one, -0.2 * two, 0.3];
        let structure = fixtures::structure(&[0.0, 0.0, 900.0], 0.01, &mesh, &mesh);
        let inertia_found = inertia(&structure, &[one, 0.0, 0.7]).unwrap();
        assert!(
            (inertia_found - (2.0 + 3.0 / 4.0)).abs() < 1e-13,
            "{inertia_found}"
        );
        let inertia_found = inertia(&structure, &[0.0, two, 0.7]).unwrap();
        assert!(
            (inertia_found - (3.0 + 2.0 * 4.0)).abs() < 1e-13,
            "{inertia_found}"
        );
        let held = fixtures::structure(&[0.0, 900.0], 0.01, &mesh[..2], &mesh[..2]);
        assert_eq!(inertia(&held, &[one, 0.2]), None);
    }
}
