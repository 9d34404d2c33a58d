//! How do rigid stops change a state, and with what force do they hold it?
//!
//! Impacts are computed one by one until the duration of the remaining impacts is so short that its third power is
//! below round-off. Then the velocity is set to zero, and the structure rests on the stop.

use super::crossing::Margin;
use super::integrator::Integration;
use super::push::round_off;
use crate::model::{ActiveSet, Stop};

/// Largest duration of the omitted impacts, times the fastest rate. The first value holds if the force of the stop
/// hardly changes during them, the second otherwise.
const SHORT: [f64; 2] = [1e-6, 3e-8];

/// Largest relative change of a force that hardly changes.
const NEGLIGIBLE_CHANGE: f64 = 1e-5;

/// Speed, in units of its round-off, below which impacts are omitted if another stop is reached at the same time.
const AT_SEVERAL: f64 = 1e3;

/// Step of the difference quotient for the rate of a force, as a fraction of the longest step.
const DIFFERENCE_STEP: f64 = 1e-4;

impl Integration<'_> {
    /// Applies an impact on a stop, or the end of a rest, at a time \[s\] of a mesh cycle.
    pub(super) fn meet_stop(&mut self, stop: Stop, contact: usize, time: f64) {
        let model = self.reference.model;
        if contact == stop.rest() {
            self.cross(contact, time, 0.0);
            self.leaving = self.leaving.union(ActiveSet::FREE.toggled(stop.impact));
            return;
        }
        let leaving = self.leaving.union(ActiveSet::FREE.toggled(stop.impact));
        self.leaving = ActiveSet::FREE;
        let segment = self.segments[stop.impact];
        let state = &self.state.value;
        let (_, speed) = model.deflection_on(&segment, self.cycle, state, time);
        if speed <= 0.0 {
            self.leaving = leaving;
            return;
        }
        let noise = round_off(model, stop.impact, state) / self.reference.step;
        let slow = if stop.restitution > 0.0 && self.meets_another(stop, time, 0.0) {
            AT_SEVERAL * noise
        } else {
            noise
        };
        if speed <= slow && self.force(stop, time) > 0.0 {
            self.subtract_rate(stop, speed);
            self.cross(stop.rest(), time, 0.0);
            return;
        }
        self.cross(stop.impact, time, speed);
        let (rests, push) = model.impulses_at_rests(stop, self.contact);
        for other in model.active_constraints(self.contact) {
            if !rests.iter().any(|(constraint, _)| *constraint == other) {
                self.cross(other.contact, time, 0.0);
            }
        }
        let impulse = (1.0 + stop.restitution) * speed / push;
        for (constraint, share) in rests.iter().copied().chain([(stop.constraint(), 1.0)]) {
            self.push(constraint.direction, share * impulse);
        }
        self.cross(stop.impact, time, -stop.restitution * speed);
        let force = self.force(stop, time);
        let acceleration_change = (1.0 - stop.restitution) * force * stop.push;
        let rebound = stop.restitution * speed;
        let lasts = 2.0 * rebound / acceleration_change;
        let held = self.holding_force(stop.rest(), &self.state.value, time);
        let steady = (held.rate * lasts).abs() <= NEGLIGIBLE_CHANGE * held.value;
        let short = SHORT[usize::from(!steady)] * self.reference.step;
        if acceleration_change > 0.0 && lasts <= short && !self.meets_another(stop, time, lasts) {
            self.subtract_rate(stop, -rebound);
            self.cross(stop.rest(), (time + lasts).min(model.period()), 0.0);
        } else if rebound == 0.0 {
            self.leaving = leaving;
        }
    }

    /// Force \[N\] with which a stop holds the structure, or would hold it if the structure rested on it.
    fn force(&self, stop: Stop, time: f64) -> f64 {
        let model = self.reference.model;
        let at = (self.cycle, time);
        let forces =
            model.forces_of_constraints(&self.segments, self.contact, at, &self.state.value);
        let mut holding = model
            .constraints()
            .zip(forces)
            .filter(|(constraint, _)| *constraint == stop.constraint());
        holding.next().map_or(0.0, |(_, force)| force)
    }

    /// Subtracts a rate \[m/s\] at a stop from the state, by an impulse of the stop and those of the closed
    /// rests.
    fn subtract_rate(&mut self, stop: Stop, rate: f64) {
        let (rests, push) = self.reference.model.impulses_at_rests(stop, self.contact);
        for (constraint, share) in rests.into_iter().chain([(stop.constraint(), 1.0)]) {
            self.push(constraint.direction, share * rate / push);
        }
    }

    /// Penetration of a stop on which the structure does not rest \[m\], rate of approach \[m/s\] and round-off of the
    /// penetration \[m\]; `None` if the structure rests on the stop.
    fn overshoot(&self, stop: Stop, time: f64) -> Option<[f64; 3]> {
        let (model, state) = (self.reference.model, &self.state.value);
        let (contact, segment) = (stop.impact, &self.segments[stop.impact]);
        let (deflection, rate) = model.deflection_on(segment, self.cycle, state, time);
        let [gap, _] = model.contacts[contact].gap(segment, time);
        let open = !self.contact.holds(stop.rest());
        open.then(|| [deflection - gap, rate, round_off(model, contact, state)])
    }

    /// A stop that the structure has reached and still approaches, and on which it does not rest yet.
    pub(super) fn reached_stop(&self, time: f64) -> Option<Stop> {
        let mut stops = self.reference.model.stops.iter().copied();
        stops.find(|stop| {
            self.overshoot(*stop, time)
                .is_some_and(|[beyond, rate, noise]| {
                    beyond >= -noise && rate * self.reference.step > noise
                })
        })
    }

    /// Whether the structure reaches another stop within a duration \[s\] at its present speed. Stops on which it rests
    /// do not count.
    fn meets_another(&self, stop: Stop, time: f64, lasts: f64) -> bool {
        let mut others = self
            .reference
            .model
            .stops
            .iter()
            .filter(|other| **other != stop);
        others.any(|other| {
            self.overshoot(*other, time)
                .is_some_and(|[beyond, rate, noise]| beyond + rate.max(0.0) * lasts >= -noise)
        })
    }

    fn push(&mut self, direction: usize, impulse: f64) {
        let (first, second) = self.state.value.split_at_mut(self.reference.model.modes());
        (self.reference.model).push_along(direction, impulse, [first, second]);
    }

    /// Force \[N\] with which a constraint holds the structure in a state, and its rate \[N/s\].
    pub(super) fn holding_force(&self, contact: usize, state: &[f64], time: f64) -> Margin {
        let model = self.reference.model;
        let place = model
            .constraints()
            .position(|constraint| constraint.contact == contact);
        let force = |state: &[f64], time: f64| {
            let at = (self.cycle, time);
            model.forces_of_constraints(&self.segments, self.contact, at, state)[place.unwrap_or(0)]
        };
        let slope = self.slope(state, time);
        let [behind, ahead] = [-1.0, 1.0].map(|sense| {
            let offset = sense * DIFFERENCE_STEP * self.reference.step;
            let moved: Vec<f64> = state
                .iter()
                .zip(&slope)
                .map(|(x, v)| x + offset * v)
                .collect();
            force(&moved, time + offset)
        });
        Margin {
            value: force(state, time),
            rate: (ahead - behind) / (2.0 * DIFFERENCE_STEP * self.reference.step),
        }
    }
}
