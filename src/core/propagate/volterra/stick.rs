//! When does dry friction begin to slip, when does it stick, and when does it slip back?
//!
//! Slipping ends when the speed of sliding v vanishes. The force λ that would hold the structure then
//! decides: the element sticks, unless |λ| exceeds the static force F_s. Sticking ends when |λ| reaches F_s.
//! A trajectory that differs by the tangent dx reaches the event later, by dt. The force f that the element
//! loses changes the tangent:
//!
//! ```text
//! dx⁺ = dx − (f⁻ − f⁺) g dt
//! dt = −(r·dx) / δ''     where a slip ends: to stick, where this leaves r·dx⁺ = 0, or to slip back, f⁺ = −f⁻
//! dt = −dλ / λ'          where a stick ends: f⁻ = ±F_s, f⁺ = ±F
//! ```
//!
//! with g, r of [`crate::model::Constraint`]. Other sticking elements move along, so the tangents have no
//! speed there. If an event frees another element at once, by a step of its force, dt is that of the event.
//!
//! Right after a stick with F_s = F the speed has a double root. It can return to zero only after the next zero of δ''.
//! That zero is found first, with the known root divided out.

use super::Volterra;
use super::impact::ImpactContext;
use super::position::WindowSource;
use super::release::ContactCondition;
use super::shapes::{Series, TERMS};
use super::workspace::Workspace;
use crate::model::{ActiveSet, DryFriction};
use crate::numerics::legendre::{self, evaluate, transforms24};
use crate::propagate::events::{Crossing, ROUND_OFF};
use crate::propagate::{Counters, Observer, Stop as End};

/// Quantities of an element of dry friction over a window.
struct Sliding {
    /// Series of the speed v, times half the window \[m\].
    speed: Series,
    /// Series of the force that holds the structure; during a slip, of δ''/ρ \[N\].
    force: Series,
    /// Round-off of both.
    noise: [f64; 2],
}

impl Volterra<'_> {
    /// The first event on a window up to `limit`, including dry friction. `first` is the first event of all other
    /// contacts.
    pub(super) fn first_with_frictions(
        &self,
        track: WindowSource<'_>,
        active: ActiveSet,
        (limit, mut first): (f64, Option<(Crossing, ContactCondition)>),
        workspace: &Workspace,
        counters: &mut Counters,
    ) -> Option<(Crossing, ContactCondition)> {
        for &friction in &self.model.frictions {
            let sliding = self.sliding(friction, track, workspace);
            for (slip, side) in friction.slips().into_iter().zip([1.0, -1.0]) {
                let until = first.map_or(limit, |(crossing, _)| crossing.x);
                let crossing = if active.holds(slip) {
                    self.stops_sliding(side, &sliding, until, counters)
                } else if active.holds(friction.stick()) {
                    let mut room = sliding.force.map(|a| -side * a);
                    room[0] += friction.static_force;
                    let known = legendre::at_start(&room).abs() <= sliding.noise[1];
                    self.exit(&room, 1.0, sliding.noise[1], known, until, counters)
                } else {
                    None
                };
                if let Some(x) = crossing.filter(|x| *x < until || first.is_none()) {
                    first = Some((Crossing { x, contact: slip }, ContactCondition::Elsewhere));
                }
            }
        }
        first
    }

    fn sliding(
        &self,
        friction: DryFriction,
        track: WindowSource<'_>,
        workspace: &Workspace,
    ) -> Sliding {
        let [motion, stick] = [friction.forwards, friction.stick()]
            .map(|contact| &workspace.solutions[track.place_of(contact)]);
        let half = 0.5 * self.tables.windows[track.views()[0].window].delta;
        let mut speed = legendre::derivative(&motion.deflection);
        speed[0] -= friction.belt_speed * half;
        let of_speed = TERMS as f64 * motion.size + (friction.belt_speed * half).abs();
        Sliding {
            speed,
            force: stick.deflection,
            noise: [
                ROUND_OFF * of_speed,
                ROUND_OFF * (stick.size + friction.static_force),
            ],
        }
    }

    /// Position in the window where a slip in the direction `side` ends.
    fn stops_sliding(
        &self,
        side: f64,
        sliding: &Sliding,
        limit: f64,
        counters: &mut Counters,
    ) -> Option<f64> {
        let [noise, of_force] = sliding.noise;
        let starts = side * legendre::at_start(&sliding.speed) <= noise;
        let quickens = side * legendre::at_start(&sliding.force);
        if !starts || quickens.abs() > TERMS as f64 * of_force {
            return self.exit(&sliding.speed, side, noise, starts, limit, counters);
        }
        let turn = self.exit(&sliding.force, side, of_force, true, limit, counters)?;
        if turn >= limit {
            return None;
        }
        let rest = transforms24().restrict(&sliding.speed, turn, limit);
        let x = self.exit(&rest, side, noise, false, 1.0, counters)?;
        Some(turn + 0.5 * (limit - turn) * (x + 1.0))
    }

    /// Moves to an event of a stop or of dry friction and applies it.
    pub(super) fn meet_part<O: Observer>(
        &self,
        crossing: Crossing,
        track: WindowSource<'_>,
        context: ImpactContext<'_, O>,
        workspace: &mut Workspace,
    ) -> Result<(), End> {
        match self.model.friction_of(crossing.contact) {
            Some(friction) => self.meet_friction((friction, crossing), track, context, workspace),
            None => self.meet_stop(crossing, track, context, workspace),
        }
    }

    /// Moves to an event of dry friction and applies it.
    fn meet_friction<O: Observer>(
        &self,
        (friction, found): (DryFriction, Crossing),
        track: WindowSource<'_>,
        mut context: ImpactContext<'_, O>,
        workspace: &mut Workspace,
    ) -> Result<(), End> {
        let side = self.model.contacts[found.contact].side;
        let sliding = self.sliding(friction, track, workspace);
        let sticks = context.active.holds(friction.stick());
        let force = evaluate(&sliding.force, found.x);
        if sticks && (found.x > -1.0 || self.is_at_limit(friction, side, &sliding)) {
            let half = 0.5 * self.tables.windows[track.views()[0].window].delta;
            let rate = evaluate(&legendre::derivative(&sliding.force), found.x) / half;
            let changes = self.changes_of_force(friction, *context.active, found.x, workspace);
            workspace.delays = changes.iter().map(|change| -change / rate).collect();
        } else if workspace.delays_from != (context.position.cycle, context.position.time) {
            workspace.delays.clear();
        }
        self.move_to_event(found.x, track, &mut context, workspace);
        let time = context.position.time;
        workspace.delays_from = (context.position.cycle, time);
        context.toggle(found.contact, 0.0, time)?;
        let mut lost = force - side * friction.force;
        if !sticks {
            workspace.delays = self.delays(friction, force, workspace);
            lost = 0.0;
            if side * self.force_to_stick(friction, &context, workspace) < -friction.static_force {
                lost = 2.0 * side * friction.force;
                context.toggle(friction.slip_towards(-side), 0.0, time)?;
            }
        }
        if lost != 0.0 {
            self.shift(friction, lost, workspace);
        }
        // At the start of a stick this is the saltation.
        self.move_onto_constraints(*context.active, context.position, workspace);
        Ok(())
    }

    /// Delay of the end of a slip for every tangent \[s\]. `quickening` is `δ''/ρ` there \[N\].
    fn delays(
        &self,
        friction: DryFriction,
        quickening: f64,
        workspace: &mut Workspace,
    ) -> Vec<f64> {
        let tangents = workspace.columns_in_parts().skip(1);
        let delay = |[first, second]: [&mut [f64]; 2]| {
            let [_, rate] = (self.model).deflection_along(friction.direction, [&*first, &*second]);
            -rate / (friction.push * quickening)
        };
        tangents.map(delay).collect()
    }

    /// Changes every tangent by the force \[N\] that an element loses at an event, times the delay of the
    /// tangent.
    fn shift(&self, friction: DryFriction, lost: f64, workspace: &mut Workspace) {
        let delays = std::mem::take(&mut workspace.delays);
        let tangents = workspace.columns_in_parts().skip(1);
        for (column, delay) in tangents.zip(&delays) {
            self.model
                .push_along(friction.direction, lost * delay, column);
        }
        workspace.delays = delays;
    }

    /// Whether a stick is at the limit of static friction at the start of a window.
    fn is_at_limit(&self, friction: DryFriction, side: f64, sliding: &Sliding) -> bool {
        let force = side * legendre::at_start(&sliding.force);
        (friction.static_force - force).abs() <= sliding.noise[1]
    }

    /// Change of the force of a stick for every tangent at a position in a window \[N\].
    fn changes_of_force(
        &self,
        friction: DryFriction,
        active: ActiveSet,
        x: f64,
        workspace: &Workspace,
    ) -> Vec<f64> {
        let columns = workspace.tangents() + 1;
        let index = active.iter().position(|closed| closed == friction.stick());
        let forces = &workspace.joint.forces[index.unwrap_or(0) * columns..][..columns];
        (forces[1..].iter())
            .map(|force| evaluate(&force.0, x))
            .collect()
    }

    /// The force \[N\] of a sticking element in the present state.
    fn force_to_stick<O: Observer>(
        &self,
        friction: DryFriction,
        context: &ImpactContext<'_, O>,
        workspace: &Workspace,
    ) -> f64 {
        let model = &*self.model;
        let at = (context.position.cycle, context.position.time);
        let state = workspace.components(model.modes()).concat();
        let forces = model.forces_of_constraints(&workspace.segments, *context.active, at, &state);
        let place = model
            .constraints()
            .position(|hold| hold.contact == friction.stick());
        forces[place.unwrap_or(0)]
    }
}
