//! One mesh cycle: blocks, events, stops.
//!
//! A block starts anywhere: at the end of the last one, at an event or at a stop, where a closed contact changes its class
//! or a contact its line. It ends at its eighth node, at the next event or at the next stop.

use super::ClosedModes;
use super::excitation::Frequencies;
use super::grid::NODES;
use super::lanes;
use super::seen::{Found, Parts, Rates};
use super::sets::MOST_CONTACTS;
use super::workspace::{Place, Workspace};
use crate::model::{ActiveSet, TrajectoryState};
use crate::propagate::events::{Changes, Margin};
use crate::propagate::{Counters, Event, Kernel, Observer, Stop as End, Tangents};

/// Part of a mesh period that sums of times are rounded by.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

impl Kernel for ClosedModes<'_> {
    type Workspace = Workspace;

    fn workspace(&self) -> Workspace {
        Workspace::new(self)
    }

    fn advance_cycle<O: Observer>(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        workspace: &mut Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), End> {
        let cycle = trajectory.cycle;
        (self.begin(trajectory, tangents, workspace))
            .map_err(|error| End::Refused { cycle, error })?;
        self.pass(trajectory, workspace, observer, counters)?;
        self.end(trajectory, tangents, workspace);
        Ok(())
    }
}

impl ClosedModes<'_> {
    /// Passes one cycle, in the coordinates of the systems.
    fn pass<O: Observer>(
        &self,
        trajectory: &mut TrajectoryState,
        workspace: &mut Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), End> {
        let mut place = Place {
            cycle: trajectory.cycle,
            time: 0.0,
            active: trajectory.contact,
            crossed: ActiveSet::FREE,
        };
        let mut changes = Changes::new(self.event_limit, self.planned);
        let mut rates = [0.0; MOST_CONTACTS];
        while place.time < self.model.period() {
            if observer.called_off() {
                return Err(End::CalledOff { cycle: place.cycle });
            }
            changes.take(place.cycle, place.time, self.model.period())?;
            self.block(
                &mut place,
                &mut rates,
                &mut changes,
                workspace,
                observer,
                counters,
            )?;
        }
        trajectory.contact = place.active;
        trajectory.cycle += 1;
        counters.cycles += 1;
        Ok(())
    }

    /// Solves one block and moves to its end, to the next event or to a stop.
    fn block<O: Observer>(
        &self,
        place: &mut Place,
        rates: &mut Rates,
        changes: &mut Changes,
        w: &mut Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), End> {
        let period = self.model.period();
        let stop = self.next_stop(place, w);
        let limit = stop.map_or(period, |stop| stop.time);
        let left = limit - place.time;
        let whole = NODES as f64 * self.step;
        let fits = left >= whole - ROUNDING * period;
        counters.windows += 1;
        let found = if left > 0.0 {
            self.first_event(place, rates, left.min(whole), w, counters)
        } else {
            None
        };
        self.check_range(place, w)?;
        let Some(found) = found else {
            let duration = if fits { whole } else { left };
            if O::WINDOWS && duration > 0.0 {
                self.show(place, duration, w, observer);
            }
            if fits {
                self.move_whole(w);
            } else {
                self.move_to(duration, place, w);
            }
            counters.partial_windows += u64::from(!fits);
            counters.tangent_windows += (w.states.len() / w.length - 1) as u64;
            let arrives = left <= whole + ROUNDING * period;
            if fits {
                place.time += whole;
            }
            if arrives {
                place.time = limit;
            }
            place.crossed = ActiveSet::FREE;
            if fits {
                Frequencies::turn(&self.turns, &mut w.inputs);
                for seen in w.seen.iter_mut().filter(|seen| seen.fresh) {
                    seen.start = seen.nodes.0[NODES - 1];
                }
            } else {
                self.see_start(w);
            }
            if arrives && stop.is_some() {
                (self.pass_stops(place, limit, w)).map_err(|error| place.refused(error))?;
            }
            return Ok(());
        };
        self.meet(found, place, rates, changes, w, (observer, counters))
    }

    /// Moves to an event and lets it happen.
    fn meet<O: Observer>(
        &self,
        found: Found,
        place: &mut Place,
        rates: &mut Rates,
        changes: &mut Changes,
        w: &mut Workspace,
        (observer, counters): (&mut O, &mut Counters),
    ) -> Result<(), End> {
        let contact = found.contact;
        if found.time > 0.0 {
            if O::WINDOWS {
                self.show(place, found.time, w, observer);
            }
            self.move_to(found.time, place, w);
            counters.partial_windows += 1;
            counters.tangent_windows += (w.states.len() / w.length - 1) as u64;
            place.crossed = ActiveSet::FREE;
        }
        self.see_start(w);
        let rate = w.seen[w.line_of[contact]].rate;
        let to = place.active.toggled(contact);
        let event = Event {
            cycle: place.cycle,
            time: place.time,
            from: place.active,
            to,
            contact,
            rate,
        };
        changes.meet(&event, observer, counters)?;
        let state = self
            .sets
            .closed_state(self.model, contact, place.cycle, place.time);
        if found.on_surface && w.states.len() > w.length {
            self.apply_saltation(contact, state, event.closes(), w);
        }
        (self.change(contact, if event.closes() { state } else { 0 }, w))
            .map_err(|error| place.refused(error))?;
        place.active = to;
        if place.crossed.holds(contact) != found.on_surface {
            place.crossed = place.crossed.toggled(contact);
        }
        let margin = Margin::new(&self.model.contacts[contact], contact, event.closes());
        rates[contact] = margin.scale * rate;
        Ok(())
    }

    /// Moves all states over a whole block.
    fn move_whole(&self, w: &mut Workspace) {
        let system = self.system(w.set);
        lanes::advance(self.instructions, &system.moves[NODES - 1], &mut w.states);
        let half = w.length / 2;
        for (drift, pushes) in system.steady.drifts.iter().zip(&system.pushes) {
            let [x, y] = pushes[NODES - 1];
            w.states[drift.lane] += x;
            w.states[half + drift.lane] += y;
        }
    }

    /// Moves all states and inputs to a time within a block, where the next one starts.
    fn move_to(&self, time: f64, place: &mut Place, w: &mut Workspace) {
        let set = self.instructions;
        let system = self.system(w.set);
        match self.beside_tried(time, w) {
            None => self.try_at(time, place, w),
            Some(rest) => {
                let own = &mut w.spare[..w.length];
                lanes::advance_near(set, &system.chunks, rest, own);
                for drift in &system.steady.drifts {
                    let [x, y] = drift.push(rest);
                    own[drift.lane] += x;
                    own[w.length / 2 + drift.lane] += y;
                }
                self.frequencies.turn_little(rest, &mut w.trial);
            }
        }
        let (tangents, moved) = (&w.states[w.length..], &mut w.spare[w.length..]);
        if !tangents.is_empty() {
            let parts = Parts::new(system, self.step, time);
            let (chunks, before) = (&system.chunks, parts.before());
            lanes::advance_by(set, chunks, before, parts.rest, tangents, moved);
        }
        std::mem::swap(&mut w.states, &mut w.spare);
        std::mem::swap(&mut w.inputs, &mut w.trial);
        w.tried = None;
        place.time += time;
    }

    /// Moves the trajectory and the inputs to a time within a block, beside those at its start.
    pub(super) fn try_at(&self, time: f64, place: &Place, w: &mut Workspace) {
        let system = self.system(w.set);
        let parts = Parts::new(system, self.step, time);
        let (chunks, before) = (&system.chunks, parts.before());
        let (state, own) = (&w.states[..w.length], &mut w.spare[..w.length]);
        lanes::advance_by(self.instructions, chunks, before, parts.rest, state, own);
        for (drift, [x, y]) in parts.pushed() {
            own[drift.lane] += x;
            own[w.length / 2 + drift.lane] += y;
        }
        let Place {
            cycle, time: start, ..
        } = *place;
        self.frequencies.write(cycle, start + time, &mut w.trial);
        w.tried = Some(time);
    }

    /// How far a time lies behind the one that was tried last, where that is near.
    pub(super) fn beside_tried(&self, time: f64, w: &Workspace) -> Option<f64> {
        let rest = time - w.tried?;
        (rest.abs() <= 0.5 * lanes::NEAR * self.step).then_some(rest)
    }

    /// Stops a motion that has left every range.
    fn check_range(&self, place: &Place, w: &Workspace) -> Result<(), End> {
        let near = |&line: &usize| w.seen[line].start.abs() <= self.farthest[line];
        if w.line_of.iter().all(near) {
            Ok(())
        } else {
            Err(End::Diverged { cycle: place.cycle })
        }
    }
}
