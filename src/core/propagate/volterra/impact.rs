//! When is a rigid stop hit, when does the structure rest on it, and when does it leave?
//!
//! An impact reverses the speed of approach v to −ε v, where ε is the restitution. λ is the force that would hold the
//! structure just before the impact; ρ, g, w, r are those of [`crate::model::Stop`]. The saltation is
//!
//! ```text
//! dx⁺ = dx − (1 + ε) (r·dx / ρ − λ w·dx / v) g − (1 + ε) (w·dx / ρ) A g
//! ```
//!
//! If other stops hold the structure, they take part with impulses: g is then the sum over all impulses, and ρ its
//! effect on the rate. While a force λ > 0 would be needed, impacts accumulate. With the acceleration `a = ρ λ` towards
//! the stop the next flight takes `2 ε v / a`, and each later one takes ε times the one before. Their sum is
//! `τ = 2 ε v / (a (1 − ε))`. The kernel follows impacts one by one until the square of τ/ε, in units of the fastest
//! rate, is below round-off. The remaining impacts then change the state by the third power of τ only: the kernel sets
//! the velocity to zero, and the structure rests. This event has the time at which the impacts would have ended. It
//! removes two dimensions from the tangents, along g and `A g`. If the structure hits another stop within τ, the speeds
//! at both stops depend on each other. Impacts are then followed until round-off hides their speed.
//!
//! During a rest λ is the value of the line of the rest, a contact that exerts 1 N per unit. The rest ends when λ falls
//! to zero. δ then has a triple root, so it can return only after the next zeros of λ and of δ'. These are found first.

use super::Volterra;
use super::position::{Position, WindowSource};
use super::release::ContactCondition;
use super::shapes::{Series, TERMS};
use super::workspace::Workspace;
use crate::model::{ActiveSet, Constraint, Model, Stop};
use crate::numerics::legendre::{self, evaluate, transforms24};
use crate::propagate::events::{Changes, Crossing, ROUND_OFF};
use crate::propagate::{Counters, Event, Observer, Stop as End};

/// Quantities of a stop over a window.
struct StopSeries {
    /// Series of `δ − b` \[m\].
    depth: Series,
    /// Series of its derivative with respect to the position in the window \[m\].
    slope: Series,
    /// Series of the force that holds the structure, or would hold it \[N\].
    force: Series,
    /// Round-off of depth \[m\] and force \[N\].
    noise: [f64; 2],
}

impl StopSeries {
    /// Round-off of the slope \[m\].
    fn noise_of_slope(&self) -> f64 {
        TERMS as f64 * self.noise[0]
    }
}

/// The integration at an event of a stop, with its observer and counters.
pub(super) struct ImpactContext<'a, O> {
    pub model: &'a Model,
    pub position: &'a mut Position,
    pub active: &'a mut ActiveSet,
    pub changes: &'a mut Changes,
    pub observer: &'a mut O,
    pub counters: &'a mut Counters,
}

impl<O: Observer> ImpactContext<'_, O> {
    /// Opens or closes a contact at a time \[s\] of the mesh cycle, with the rate of its deflection \[m/s\].
    pub fn toggle(&mut self, contact: usize, rate: f64, time: f64) -> Result<(), End> {
        let to = self.model.toggled(*self.active, contact);
        let event = Event {
            cycle: self.position.cycle,
            time,
            from: *self.active,
            to,
            contact,
            rate,
        };
        *self.active = to;
        self.changes.meet(&event, self.observer, self.counters)
    }
}

impl Volterra<'_> {
    /// The first event on a window up to `limit`, including rigid stops. `first` is the first event of all other
    /// contacts.
    pub(super) fn first_with_stops(
        &self,
        (position, track): (&Position, WindowSource<'_>),
        active: ActiveSet,
        (limit, mut first): (f64, Option<(Crossing, ContactCondition)>),
        workspace: &Workspace,
        counters: &mut Counters,
    ) -> Option<(Crossing, ContactCondition)> {
        for &stop in &self.model.stops {
            let series_of_stop = self.series_of_stop(stop, track, workspace);
            let until = first.map_or(limit, |(crossing, _)| crossing.x);
            let crossing = if active.holds(stop.rest()) {
                let noise = series_of_stop.noise[1];
                let known = legendre::at_start(&series_of_stop.force).abs() <= noise;
                let x = self.exit(&series_of_stop.force, 1.0, noise, known, until, counters);
                x.map(|x| (x, stop.rest()))
            } else {
                let leaves = position.forceless.holds(stop.rest());
                self.hits((stop, leaves), &series_of_stop, until, counters)
            };
            if let Some((x, contact)) = crossing.filter(|(x, _)| *x < until || first.is_none()) {
                first = Some((Crossing { x, contact }, ContactCondition::Elsewhere));
            }
        }
        first
    }

    fn series_of_stop(
        &self,
        stop: Stop,
        track: WindowSource<'_>,
        workspace: &Workspace,
    ) -> StopSeries {
        let [own, rest] =
            [stop.impact, stop.rest()].map(|contact| &workspace.solutions[track.place_of(contact)]);
        let gap = self.model.contacts[stop.impact].half_gap;
        let mut depth = own.deflection;
        depth[0] -= gap;
        StopSeries {
            slope: legendre::derivative(&depth),
            depth,
            force: rest.deflection,
            noise: [ROUND_OFF * (own.size + gap.abs()), ROUND_OFF * rest.size],
        }
    }

    /// Position in the window where an open stop is hit or begins to hold the structure, and the contact that
    /// closes there. `leaves` means that the force of the stop has vanished at the start of the window.
    fn hits(
        &self,
        (stop, leaves): (Stop, bool),
        series_of_stop: &StopSeries,
        limit: f64,
        counters: &mut Counters,
    ) -> Option<(f64, usize)> {
        let [noise, of_force] = series_of_stop.noise;
        let (start, speed) = (
            legendre::at_start(&series_of_stop.depth),
            legendre::at_start(&series_of_stop.slope),
        );
        let hit = |x: f64| (x, stop.impact);
        let of_slope = series_of_stop.noise_of_slope();
        if start < -noise || speed < -of_slope {
            let known = start >= -noise;
            return (self.exit(&series_of_stop.depth, -1.0, noise, known, limit, counters))
                .map(hit);
        }
        if speed > of_slope {
            return Some(hit(-1.0));
        }
        let force = legendre::at_start(&series_of_stop.force);
        let grows = legendre::at_start(&legendre::derivative(&series_of_stop.force));
        let presses = force > of_force || (force >= -of_force && grows > TERMS as f64 * of_force);
        if presses && !leaves {
            return Some((-1.0, stop.rest()));
        }
        let known = leaves || force >= -of_force;
        let pressed = self.exit(
            &series_of_stop.force,
            -1.0,
            of_force,
            known,
            limit,
            counters,
        )?;
        let behind = |from: f64, series: &Series| {
            (from < limit).then(|| transforms24().restrict(series, from, limit))
        };
        let place = |from: f64, x: f64| from + 0.5 * (limit - from) * (x + 1.0);
        let slope = behind(pressed, &series_of_stop.slope)?;
        let turned = self.exit(&slope, -1.0, of_slope, false, 1.0, counters)?;
        let turned = place(pressed, turned);
        let depth = behind(turned, &series_of_stop.depth)?;
        let back = self.exit(&depth, -1.0, noise, false, 1.0, counters)?;
        Some(hit(place(turned, back)))
    }

    /// Moves to an event of a stop and applies it.
    pub(super) fn meet_stop<O: Observer>(
        &self,
        crossing: Crossing,
        track: WindowSource<'_>,
        mut context: ImpactContext<'_, O>,
        workspace: &mut Workspace,
    ) -> Result<(), End> {
        let Some(stop) = self.model.stop_of(crossing.contact) else {
            unreachable!("a contact of a stop has one");
        };
        self.move_to_event(crossing.x, track, &mut context, workspace);
        let time = context.position.time;
        if crossing.contact == stop.rest() {
            let held = context.active.union(ActiveSet::FREE.toggled(stop.rest()));
            self.move_onto_constraints(held, context.position, workspace);
            if context.active.holds(stop.rest()) {
                let forceless = context.position.forceless;
                context.position.forceless = forceless.union(ActiveSet::FREE.toggled(stop.rest()));
            }
            return context.toggle(stop.rest(), 0.0, time);
        }
        self.reflect((stop, crossing.x), track, &mut context, workspace)
    }

    /// Moves to the position of an event in a window.
    pub(super) fn move_to_event<O: Observer>(
        &self,
        x: f64,
        track: WindowSource<'_>,
        context: &mut ImpactContext<'_, O>,
        workspace: &mut Workspace,
    ) {
        if x > -1.0 {
            let listeners = (&mut *context.observer, &mut *context.counters);
            self.move_to_cut(
                x,
                context.position,
                track,
                *context.active,
                workspace,
                listeners,
            );
            context.position.aligned = None;
            context.position.crossed = ActiveSet::FREE;
            context.position.forceless = ActiveSet::FREE;
        }
    }

    /// Reflects trajectory and tangents from a stop.
    fn reflect<O: Observer>(
        &self,
        (stop, x): (Stop, f64),
        track: WindowSource<'_>,
        context: &mut ImpactContext<'_, O>,
        workspace: &mut Workspace,
    ) -> Result<(), End> {
        let model = &*self.model;
        let (cycle, time, active) = (
            context.position.cycle,
            context.position.time,
            *context.active,
        );
        let line = &model.lines[model.directions[stop.direction].line];
        let (_, error_rate) = line.transmission_error_at(cycle, time);
        let parts = workspace.components(model.modes());
        let speed = model.deflection_along(stop.direction, parts)[1] - error_rate;
        if speed <= 0.0 {
            // A touch without speed, within round-off.
            context.counters.grazings += 1;
            return Ok(());
        }
        let force_of = |workspace: &Workspace, hold: Constraint| {
            let solution = &workspace.solutions[track.place_of(hold.contact)];
            evaluate(&solution.deflection, x)
        };
        let force = force_of(workspace, stop.constraint());
        context.toggle(stop.impact, speed, time)?;
        let (rests, push) = model.impulses_at_rests(stop, active);
        let before = model.active_constraints(active);
        let held: Vec<Constraint> = rests.iter().map(|(other, _)| *other).collect();
        let mut released = Vec::new();
        for other in before.into_iter().filter(|other| !held.contains(other)) {
            released.push((other.direction, force_of(workspace, other)));
            context.toggle(other.contact, 0.0, time)?;
        }
        let factor = (1.0 + stop.restitution) / push;
        let segments = std::mem::take(&mut workspace.segments);
        let levels = model.levels(&held, cycle, time);
        for (index, [first, second]) in workspace.columns_in_parts().enumerate() {
            let [deflection, rate] = model.deflection_along(stop.direction, [&*first, &*second]);
            let closed = (active, &segments[..]);
            let (impulse, amount) = match index {
                0 => (factor * speed, 0.0),
                _ => (
                    factor * (rate - force * stop.push * deflection / speed),
                    factor * deflection,
                ),
            };
            if index > 0 {
                // The forces of stops that release the structure end with the impulse.
                for &(direction, force) in &released {
                    model.push_along(
                        direction,
                        -force * deflection / speed,
                        [&mut *first, &mut *second],
                    );
                }
            }
            for &(constraint, share) in rests.iter().chain(&[(stop.constraint(), 1.0)]) {
                let along = constraint.direction;
                model.shift_along(along, share * amount, closed, [&mut *first, &mut *second]);
                model.push_along(along, share * impulse, [&mut *first, &mut *second]);
            }
            let at_rest = |level: &(Option<f64>, f64)| if index == 0 { level.1 } else { 0.0 };
            let rates: Vec<f64> = levels.iter().map(at_rest).collect();
            model.set_rates(&held, &rates, [first, second]);
        }
        workspace.segments = segments;
        context.toggle(stop.impact, -stop.restitution * speed, time)?;
        let acceleration_change = (1.0 - stop.restitution) * force * stop.push;
        let lasts = 2.0 * stop.restitution * speed / acceleration_change;
        let short = 2.0 * speed / acceleration_change * self.fastest <= f64::EPSILON.sqrt();
        if acceleration_change > 0.0
            && short
            && !self.meets_another((stop, x), lasts, track, context, workspace)
        {
            let held = context.active.toggled(stop.rest());
            self.move_onto_constraints(held, context.position, workspace);
            context.toggle(stop.rest(), 0.0, (time + lasts).min(model.period()))?;
        }
        Ok(())
    }

    /// Whether the structure hits another stop during the last impacts on one, which end after `lasts` \[s\]. Impacts
    /// on each stop then drive those on the other, and only round-off ends them: see [`Volterra::hits`].
    fn meets_another<O>(
        &self,
        (stop, x): (Stop, f64),
        lasts: f64,
        track: WindowSource<'_>,
        context: &ImpactContext<'_, O>,
        workspace: &mut Workspace,
    ) -> bool {
        let open = self
            .model
            .stops
            .iter()
            .filter(|other| **other != stop && !context.active.holds(other.rest()));
        let mut open = open.copied();
        open.any(|other| {
            let series_of_stop = self.series_of_stop(other, track, workspace);
            let line = &self.model.lines[self.model.directions[other.direction].line];
            let (_, error_rate) =
                line.transmission_error_at(context.position.cycle, context.position.time);
            let parts = workspace.components(self.model.modes());
            let rate = self.model.deflection_along(other.direction, parts)[1] - error_rate;
            evaluate(&series_of_stop.depth, x) + rate.max(0.0) * lasts >= -series_of_stop.noise[0]
        })
    }

    /// Moves trajectory and tangents onto the stops that hold the structure, and sets their speeds there to zero. Also
    /// sets the speed of sliding of sticking dry friction to zero. These are changes at events, or round-off.
    pub(super) fn move_onto_constraints(
        &self,
        active: ActiveSet,
        position: &Position,
        workspace: &mut Workspace,
    ) {
        let model = &*self.model;
        let held = model.active_constraints(active);
        if held.is_empty() {
            return;
        }
        let mut levels = model.levels(&held, position.cycle, position.time);
        let segments = std::mem::take(&mut workspace.segments);
        for column in workspace.columns_in_parts() {
            model.move_to_levels(&held, &levels, (active, &segments[..]), column);
            levels.iter_mut().for_each(|(level, rate)| {
                *level = level.map(|_| 0.0);
                *rate = 0.0;
            });
        }
        workspace.segments = segments;
    }
}

#[cfg(test)]
mod tests;
