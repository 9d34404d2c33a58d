//! Mesh cycles: blocks, events, stops.
//!
//! A block starts anywhere: at the end of the last one, at an event or at a stop, where a closed contact changes its class
//! or a contact its line. It ends at its eighth node, at the next event or at the next stop.

use super::ClosedModes;
use super::excitation::Frequencies;
use super::glance::Rates;
use super::grid::NODES;
use super::lanes;
use super::seen::{Found, Parts};
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
        self.advance_cycles(1, trajectory, tangents, workspace, observer, counters)
    }

    /// Stays in the coordinates of the systems from the first cycle to the last.
    fn advance_cycles<O: Observer>(
        &self,
        cycles: u64,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        workspace: &mut Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), End> {
        for passed in 0..cycles {
            let cycle = trajectory.cycle;
            match passed {
                0 => self.begin(trajectory, tangents, workspace),
                _ => self.go_on(trajectory, workspace),
            }
            .map_err(|error| End::Refused { cycle, error })?;
            self.pass(trajectory, workspace, observer, counters)?;
        }
        if cycles > 0 {
            self.end(trajectory, tangents, workspace);
        }
        Ok(())
    }
}

impl ClosedModes<'_> {
    /// Passes one cycle, in the coordinates of the systems.
    fn pass<O: Observer>(
        &self,
        trajectory: &mut TrajectoryState,
        w: &mut Workspace,
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
        self.plan(&place, w);
        while place.time < self.model.period() {
            if observer.called_off() {
                return Err(End::CalledOff { cycle: place.cycle });
            }
            changes.take(place.cycle, place.time, self.model.period())?;
            match self.block(&mut place, &rates, w, observer, counters)? {
                None => place.crossed = ActiveSet::FREE,
                Some(found) => {
                    let event = self.meet(found, &mut place, w)?;
                    changes.meet(&event, observer, counters)?;
                    let margin = Margin::new(
                        &self.model.contacts[found.contact],
                        found.contact,
                        event.closes(),
                    );
                    rates[found.contact] = margin.scale * event.rate;
                }
            }
        }
        trajectory.contact = place.active;
        trajectory.cycle += 1;
        counters.cycles += 1;
        Ok(())
    }

    /// Solves one block and moves to its end, to the next event, which it gives, or to a stop.
    fn block<O: Observer>(
        &self,
        place: &mut Place,
        rates: &Rates,
        w: &mut Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<Option<Found>, End> {
        let period = self.model.period();
        let limit = w.stop.map_or(period, |stop| stop.time);
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
        let duration = match found {
            Some(found) => found.time,
            None if fits => whole,
            None => left,
        };
        let at_once = found.is_some() && duration == 0.0;
        if O::WINDOWS && duration > 0.0 {
            self.show(place, duration, w, observer);
        }
        if found.is_none() && fits {
            self.move_whole(w);
            place.time += whole;
        } else if !at_once {
            self.move_to(duration, w);
            place.time += duration;
            counters.partial_windows += 1;
            if found.is_none() && w.stop.is_some() {
                self.see_start(w);
            }
        }
        if !at_once {
            counters.tangent_windows += (w.states.len() / w.length - 1) as u64;
            place.crossed = ActiveSet::FREE;
        }
        if found.is_some() {
            return Ok(found);
        }
        if left <= whole + ROUNDING * period {
            place.time = limit;
            if w.stop.is_some() {
                (self.pass_stops(place, limit, w)).map_err(|error| place.refused(error))?;
            }
        }
        Ok(None)
    }

    /// Lets an event happen where the states are.
    fn meet(&self, found: Found, place: &mut Place, w: &mut Workspace) -> Result<Event, End> {
        let contact = found.contact;
        self.see_start(w);
        let event = Event {
            cycle: place.cycle,
            time: place.time,
            from: place.active,
            to: place.active.toggled(contact),
            contact,
            rate: w.seen[w.line_of[contact]].rate,
        };
        let state = self
            .sets
            .closed_state(self.model, contact, place.cycle, place.time);
        if found.on_surface && w.states.len() > w.length {
            self.apply_saltation(contact, state, event.closes(), w);
        }
        (self.change(contact, if event.closes() { state } else { 0 }, w))
            .map_err(|error| place.refused(error))?;
        place.active = event.to;
        if place.crossed.holds(contact) != found.on_surface {
            place.crossed = place.crossed.toggled(contact);
        }
        w.watch(&self.model.contacts, place.active);
        self.plan(place, w);
        Ok(event)
    }

    /// Moves all states and inputs over a whole block.
    fn move_whole(&self, w: &mut Workspace) {
        let system = self.system(w.set);
        lanes::advance(self.instructions, &system.moves[NODES - 1], &mut w.states);
        let half = w.length / 2;
        for (drift, pushes) in system.steady.drifts.iter().zip(&system.pushes) {
            let [x, y] = pushes[NODES - 1];
            w.states[drift.lane] += x;
            w.states[half + drift.lane] += y;
        }
        Frequencies::turn(&self.turns[NODES - 1], &mut w.inputs);
        for &line in &w.lines {
            w.seen[line].start = w.seen[line].nodes.0[NODES - 1];
        }
    }

    /// Moves all states and inputs to a time within a block, where the next one starts.
    fn move_to(&self, time: f64, w: &mut Workspace) {
        let system = self.system(w.set);
        let parts = Parts::new(system, self.step, time);
        let beside = (w.tried.map(|tried| time - tried))
            .filter(|rest| rest.abs() * self.fastest() <= lanes::LITTLE);
        match beside {
            Some(rest) => {
                lanes::advance_little(self.instructions, &system.chunks, rest, &mut w.spare);
            }
            None => {
                // Nobody asks what is seen there.
                self.advance_to(&parts, &system.views[0].rows, w);
            }
        }
        std::mem::swap(&mut w.states, &mut w.spare);
        let half = w.length / 2;
        for (drift, [x, y]) in parts.pushed() {
            w.states[drift.lane] += x;
            w.states[half + drift.lane] += y;
        }
        (self.frequencies).turn_to(parts.turns(self), parts.rest, &mut w.inputs);
    }

    /// Moves all states to a time within a block, beside those at its start and without what constant inputs add; gives
    /// products of three rows with the trajectory there.
    pub(super) fn advance_to(
        &self,
        parts: &Parts<'_>,
        rows: &[Vec<f64>; 3],
        w: &mut Workspace,
    ) -> [f64; 3] {
        let chunks = &self.system(w.set).chunks;
        let (before, states) = (parts.before(), &w.states);
        lanes::advance_to(
            self.instructions,
            chunks,
            before,
            parts.rest,
            rows,
            states,
            &mut w.spare,
        )
    }

    /// Stops a motion that has left every range.
    fn check_range(&self, place: &Place, w: &Workspace) -> Result<(), End> {
        let near = |&line: &usize| w.seen[line].start.abs() <= self.farthest[line];
        if w.lines.iter().all(near) {
            Ok(())
        } else {
            Err(End::Diverged { cycle: place.cycle })
        }
    }
}
