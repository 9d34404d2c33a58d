//! What are the elements of dry friction of a model?
//!
//! The speed of sliding is v = δ' − u. A slip exerts the constant force F sgn v. While v is 0, the constraint
//! δ'' = 0 exerts the force λ ([`super::Stop`] has its formula). The quantity of the stick's line is λ. While
//! the element slips, this quantity is `δ''/ρ`.

use super::error::{ModelError, check_in_range};
use super::stop::{Constraint, pushed};
use super::{Contact, Direction};
use crate::structure::{FrictionPart, ModalStructure};

/// A motion along a line is independent of the motions along other lines if the square of its independent
/// part, relative to the whole, exceeds this.
const SAME_LINE: f64 = 1e-10;

/// An element of dry friction of a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DryFriction {
    /// Index of its forward slip among the contacts. The backward slip and the stick follow.
    pub forwards: usize,
    /// Direction of its force along the line of δ, as an index among the model's directions.
    pub direction: usize,
    /// Change of the rate δ' by a unit impulse ρ \[1/kg\].
    pub push: f64,
    /// Force F of sliding friction \[N\].
    pub force: f64,
    /// Largest force F_s of static friction \[N\].
    pub static_force: f64,
    /// Speed u of the surface \[m/s\].
    pub belt_speed: f64,
}

/// Checks that the motion along no element follows from the motions along others, by elimination in the
/// matrix `ρ_ij = r_i·g_j`.
fn are_independent(all: &[DryFriction], directions: &[Direction]) -> Result<(), ModelError> {
    let gains = |friction: &DryFriction| &directions[friction.direction].gains[..];
    let mut rows: Vec<Vec<f64>> = (all.iter())
        .map(|friction| {
            (all.iter())
                .map(|other| {
                    pushed(gains(friction), gains(other)) / (friction.push * other.push).sqrt()
                })
                .collect()
        })
        .collect();
    for step in 0..all.len() {
        let (above, below) = rows.split_at_mut(step + 1);
        let top = &above[step];
        if top[step].is_nan() || top[step] <= SAME_LINE {
            return Err(ModelError::FrictionsAlike { element: step + 1 });
        }
        for row in below {
            let factor = row[step] / top[step];
            for (entry, above) in row.iter_mut().zip(top) {
                *entry -= factor * above;
            }
        }
    }
    Ok(())
}

impl DryFriction {
    /// The elements of a structure. `before` is the number of contacts before those of the structure.
    ///
    /// # Errors
    /// [`ModelError::OutOfRange`] if the static force is below that of sliding, the speed is not finite, or the force
    /// does not oppose the sliding; [`ModelError::FrictionWithStops`], [`ModelError::FrictionsAlike`].
    pub(super) fn of_structure(
        structure: &ModalStructure,
        before: usize,
        contacts: &[Contact],
        directions: &[Direction],
    ) -> Result<Vec<Self>, ModelError> {
        let mut all = Vec::new();
        for (contact, stick) in structure.contacts.iter().zip(before..) {
            let Some(FrictionPart::Stick {
                static_force,
                belt_speed,
            }) = contact.law.dry_friction
            else {
                continue;
            };
            let forwards = stick - 2;
            let segment = &contacts[forwards].cycles[0].segments[0];
            let force = segment.stiffness.mean();
            let (name, accepted) = (
                "static force of dry friction",
                "at least the force of sliding friction",
            );
            check_in_range(name, static_force, static_force >= force, accepted)?;
            check_in_range(
                "belt speed of dry friction",
                belt_speed,
                true,
                "a finite speed",
            )?;
            let gains = &directions[segment.direction].gains;
            let push = pushed(gains, gains);
            let name = "change of the sliding by its own friction";
            check_in_range(name, push, push > 0.0, "above 0 1/kg")?;
            all.push(Self {
                forwards,
                direction: segment.direction,
                push,
                force,
                static_force,
                belt_speed,
            });
        }
        if !all.is_empty() && structure.rigid_stops() > 0 {
            return Err(ModelError::FrictionWithStops);
        }
        are_independent(&all, directions)?;
        Ok(all)
    }

    /// Indices of its two slips among the contacts: forwards, backwards.
    pub fn slips(self) -> [usize; 2] {
        [self.forwards, self.forwards + 1]
    }

    /// Index of its stick among the contacts.
    pub fn stick(self) -> usize {
        self.forwards + 2
    }

    /// Index of the forward slip if `way` ≥ 0, otherwise of the backward slip.
    pub fn slip_towards(self, way: f64) -> usize {
        self.slips()[usize::from(way < 0.0)]
    }

    /// Whether a contact is one of its states.
    pub fn has(self, contact: usize) -> bool {
        (self.forwards..=self.stick()).contains(&contact)
    }

    /// The constraint while the element sticks.
    pub fn constraint(self) -> Constraint {
        Constraint {
            contact: self.stick(),
            direction: self.direction,
            push: self.push,
        }
    }
}
