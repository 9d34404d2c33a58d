//! When does dry friction stick, and when does it slip?
//!
//! At a zero of the speed of sliding, the force that would hold the structure decides whether the element
//! sticks, or slips back at once.

use super::crossing::Margin;
use super::end_conditions::{EndCondition, SlidingDirection};
use super::integrator::Integration;
use crate::model::DryFriction;

/// Speed that counts as zero, as a fraction of the round-off that
/// [`Model::sliding_speed`](crate::model::Model::sliding_speed) returns.
const AT_REST: f64 = 0.1;

/// Round-off of a force, relative to the static force.
const OF_FORCE: f64 = 1e-13;

impl SlidingDirection {
    fn sign(self) -> f64 {
        match self {
            Self::Forwards => 1.0,
            Self::Backwards => -1.0,
        }
    }
}

impl Integration<'_> {
    /// Margin until a sticking element slips in one direction \[N\]: the largest static force minus the force of the
    /// element in this direction. With its rate \[N/s\].
    pub(super) fn room(
        &self,
        contact: usize,
        way: SlidingDirection,
        state: &[f64],
        time: f64,
    ) -> Margin {
        let held = self.holding_force(contact, state, time);
        let model = self.reference.model;
        let most = model
            .friction_of(contact)
            .map_or(0.0, |friction| friction.static_force);
        Margin {
            value: most - way.sign() * held.value,
            rate: -way.sign() * held.rate,
        }
    }

    /// Speed of sliding that counts as zero \[m/s\].
    pub(super) fn round_off_of_sliding(&self, friction: DryFriction, state: &[f64]) -> f64 {
        let model = self.reference.model;
        let (first, second) = state.split_at(model.modes());
        let [_, noise] = model.sliding_speed(friction, [first, second]);
        AT_REST * (noise + OF_FORCE * friction.static_force * friction.push * self.reference.step)
    }

    /// Ends the present state of an element of dry friction, at a time \[s\] of a mesh cycle.
    pub(super) fn meet_friction(
        &mut self,
        friction: DryFriction,
        watched: EndCondition,
        time: f64,
    ) {
        if let EndCondition::Limit(way) = watched {
            self.stop_sliding(time);
            self.cross(friction.slip_towards(way.sign()), time, 0.0);
            return;
        }
        let side = if self.contact.holds(friction.forwards) { 1.0 } else { -1.0 };
        self.cross(friction.slip_towards(side), time, 0.0);
        let force = self
            .holding_force(friction.stick(), &self.state.value, time)
            .value;
        if side * force < -friction.static_force {
            self.cross(friction.slip_towards(-side), time, 0.0);
            return;
        }
        self.stop_sliding(time);
    }

    /// Removes the round-off of the sliding speed of sticking elements.
    fn stop_sliding(&mut self, time: f64) {
        let model = self.reference.model;
        let (first, second) = self.state.value.split_at_mut(model.modes());
        let held = model.active_constraints(self.contact);
        let levels = model.levels(&held, self.cycle, time);
        let rates: Vec<f64> = levels.iter().map(|level| level.1).collect();
        model.set_rates(&held, &rates, [first, second]);
    }
}
