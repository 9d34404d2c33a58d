//! What are the rigid stops of a model, and what do their impulses and forces do?
//!
//! With the gains r = wA of the rate, `δ' = r·x − e'`, an impulse J along g changes the state by −g J and the rate by
//! −ρ J, `ρ = r·g`. The force that holds δ at the gap follows from `δ'' = 0`:
//!
//! ```text
//! λ = (r·(A x + s) − Σ r·g_j F_j − e'') / ρ
//! ```
//!
//! Here s are the inputs and F_j the forces of other contacts. Like a deflection, λ is a weighted sum over
//! the state, but with a direct contribution of the inputs ([`super::Line::direct`]). The contact of the rest
//! has a separate line, whose quantity is λ. Its stiffness is 1, so that its force is λ.

use super::direction::{Directions, Line};
use super::error::{ModelError, check_in_range};
use super::{Block, Contact, Direction, MeshGain, TransmissionErrorHarmonic};
use crate::structure::{ModalStructure, StopPart};

/// A rigid stop of a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// Index of its impact among the contacts. The next contact is its rest.
    pub impact: usize,
    /// Coefficient of restitution ε.
    pub restitution: f64,
    /// Direction of its force along the line of δ, as an index among the model's directions.
    pub direction: usize,
    /// Change of the rate δ' by a unit impulse ρ \[1/kg\].
    pub push: f64,
}

/// A constraint that holds the structure along a line while its contact is closed: a rest on a rigid stop, or
/// sticking dry friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Constraint {
    /// Index of the contact. The quantity of its line is the force λ.
    pub contact: usize,
    /// Direction of the force along the line of δ, as an index among the model's directions.
    pub direction: usize,
    /// Change of the rate δ' by a unit impulse ρ \[1/kg\].
    pub push: f64,
}

/// Largest deviation from −1 of the cosine between two opposite lines.
const OPPOSITE: f64 = 1e-12;

/// Scalar product of a pair of gains and a pair of components.
pub(super) fn product(row: [f64; 2], [x, y]: [f64; 2]) -> f64 {
    row[0] * x + row[1] * y
}

/// `Σ r·g` of two directions \[1/kg\]: the reduction of δ'' along the first direction by a unit force along
/// the second.
pub(super) fn pushed(motion: &[MeshGain], force: &[MeshGain]) -> f64 {
    let pairs = motion.iter().zip(force);
    pairs.map(|(a, b)| product(a.rate, b.mesh_input)).sum()
}

impl Stop {
    /// The stops of a structure. `before` is the number of contacts before those of the structure.
    ///
    /// # Errors
    /// [`ModelError::OutOfRange`] if a restitution is not from 0 to 1, the force of a stop does not push its contact
    /// open, or the gaps of opposite stops leave no room between them.
    pub(super) fn of_structure(
        structure: &ModalStructure,
        before: usize,
        contacts: &[Contact],
        directions: &[Direction],
    ) -> Result<Vec<Self>, ModelError> {
        let mut all = Vec::new();
        for (contact, impact) in structure.contacts.iter().zip(before..) {
            let Some(StopPart::Impact { restitution }) = contact.law.stop else {
                continue;
            };
            let inside = (0.0..=1.0).contains(&restitution);
            check_in_range("restitution", restitution, inside, "from 0 to 1")?;
            let direction = contacts[impact].cycles[0].segments[0].direction;
            let gains = &directions[direction].gains;
            let push = pushed(gains, gains);
            let name = "opening of a rigid stop by its own force";
            check_in_range(name, push, push > 0.0, "above 0 1/kg")?;
            all.push(Self {
                impact,
                restitution,
                direction,
                push,
            });
        }
        for (place, stop) in all.iter().enumerate() {
            let mut before = all[..place].iter();
            before.try_for_each(|other| stop.leaves_room(*other, contacts, directions))?;
        }
        Ok(all)
    }

    /// Checks that there is clearance between two stops, if they face each other along one line.
    fn leaves_room(
        self,
        other: Self,
        contacts: &[Contact],
        directions: &[Direction],
    ) -> Result<(), ModelError> {
        let line = |stop: Self| directions[stop.direction].gains.iter();
        let both = |a: Self, b: Self| -> f64 {
            let pairs = line(a).zip(line(b));
            pairs
                .map(|(a, b)| product(a.deflection, b.deflection))
                .sum()
        };
        let [own, across, others] = [both(self, self), both(self, other), both(other, other)];
        let opposite = across <= -(1.0 - OPPOSITE) * (own * others).sqrt();
        let gap = |stop: Self| contacts[stop.impact].half_gap;
        let room = gap(self) + (own / others).sqrt() * gap(other);
        let name = "clearance between opposite rigid stops";
        check_in_range(name, room, !opposite || room >= 0.0, "at least 0 m")
    }

    /// Index of its rest among the contacts.
    pub fn rest(self) -> usize {
        self.impact + 1
    }

    /// The constraint while the structure rests on the stop.
    pub fn constraint(self) -> Constraint {
        Constraint {
            contact: self.rest(),
            direction: self.direction,
            push: self.push,
        }
    }
}

impl Directions {
    /// Adds the direction of a constraint and returns its index. The force of the constraint acts as a force
    /// along `gains`. The quantity of the direction's line is this force.
    pub fn add_stop_direction(
        &mut self,
        (gains, blocks): (&[MeshGain], &[Block]),
        error: &[TransmissionErrorHarmonic],
        on_bearings: Vec<f64>,
    ) -> usize {
        let push = pushed(gains, gains);
        let direct: Vec<[f64; 2]> = gains
            .iter()
            .map(|gain| gain.rate.map(|r| r / push))
            .collect();
        let of_block = |(block, (gain, direct)): (&Block, (&MeshGain, &[f64; 2]))| {
            let acceleration = MeshGain::new(block, *direct, gain.mesh_input).rate;
            MeshGain::new(block, acceleration, gain.mesh_input)
        };
        let resting = blocks.iter().zip(gains.iter().zip(&direct));
        let resting = resting.map(of_block).collect();
        let curved: Vec<TransmissionErrorHarmonic> = (error.iter())
            .map(|harmonic| TransmissionErrorHarmonic {
                amplitude: -harmonic.amplitude * harmonic.angular_frequency.powi(2) / push,
                ..*harmonic
            })
            .collect();
        let line = Line {
            transmission_error: curved,
            direct,
        };
        self.add_along(line, resting, 0.0, on_bearings)
    }
}
