//! From one system to another: at events and stops, and to modal states and back.

use super::ClosedModes;
use super::lanes;
use super::seen::now;
use super::sets::Stop;
use super::workspace::{Place, Workspace};
use crate::model::TrajectoryState;
use crate::propagate::{TableError, Tangents};

impl ClosedModes<'_> {
    /// Takes trajectory and tangents to the coordinates of the system in force at the start of a cycle.
    pub(super) fn begin(
        &self,
        trajectory: &TrajectoryState,
        tangents: &Tangents,
        w: &mut Workspace,
    ) -> Result<(), TableError> {
        let (model, cycle) = (self.model, trajectory.cycle);
        w.set = self.sets.at(model, trajectory.contact, cycle, 0.0);
        let slot = self.enter(w.set)?;
        self.frequencies.write(cycle, 0.0, &mut w.inputs);
        w.put(&trajectory.state, tangents);
        let responses = &slot.system.steady.responses;
        match slot.basis.of_modes() {
            Some(map) => self.map(map, [&[], responses], w),
            None => self.shift(-1.0, w),
        }
        let contacts = model.contacts.iter();
        w.begin(contacts.map(|contact| model.line(contact.cycle(cycle).segment_at(0.0))));
        self.see_start(w);
        Ok(())
    }

    /// Takes trajectory and tangents back to modal states.
    pub(super) fn end(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        w: &mut Workspace,
    ) {
        let slot = self.slot(w.set);
        let responses = &slot.system.steady.responses;
        match slot.basis.to_modes() {
            Some(map) => self.map(map, [responses, &[]], w),
            None => self.shift(1.0, w),
        }
        w.take(trajectory, tangents);
    }

    /// `states = map states`, the trajectory's behind the steady response of the first and before that of the second.
    fn map(&self, columns: &[f64], responses: [&[f64]; 2], w: &mut Workspace) {
        lanes::map(
            self.instructions,
            columns,
            self.model.modes(),
            responses,
            &w.inputs,
            &mut w.states,
            &mut w.spare,
        );
        std::mem::swap(&mut w.states, &mut w.spare);
        w.tried = None;
    }

    /// Adds `factor` times the steady response to the trajectory's state.
    fn shift(&self, factor: f64, w: &mut Workspace) {
        let responses = &self.system(w.set).steady.responses;
        let state = &mut w.states[..w.length];
        lanes::shift(self.instructions, responses, &w.inputs, factor, state);
    }

    /// Gives a contact another state.
    ///
    /// # Errors
    /// The system behind has no table.
    pub(super) fn change(
        &self,
        contact: usize,
        state: usize,
        w: &mut Workspace,
    ) -> Result<(), TableError> {
        if self.slot(w.set).states[contact] == state {
            return Ok(());
        }
        let to = self.sets.with(w.set, contact, state);
        let (own, behind) = (self.slot(w.set), self.enter(to)?);
        let [before, after] = [own, behind].map(|slot| &slot.system.steady.responses[..]);
        // Free flight is in modes: other systems have what leads there and back.
        match (own.basis.to_modes(), behind.basis.of_modes()) {
            (Some(to_modes), Some(of_modes)) => match self.bases.change(w.set, contact, state) {
                Some(map) => self.map(map, [before, after], w),
                None => {
                    self.map(to_modes, [before, &[]], w);
                    self.map(of_modes, [&[], after], w);
                }
            },
            (Some(map), None) | (None, Some(map)) => self.map(map, [before, after], w),
            (None, None) => unreachable!("one of two systems has a closed contact"),
        }
        w.set = to;
        Ok(())
    }

    /// Deflections and rates now along the lines of all contacts.
    pub(super) fn see_start(&self, w: &mut Workspace) {
        let system = self.system(w.set);
        let state = &w.states[..w.length];
        for (contact, &line) in w.line_of.iter().enumerate() {
            if !w.line_of[..contact].contains(&line) {
                let view = &system.views[line];
                let seen = &mut w.seen[line];
                [seen.start, seen.rate] = now(self.instructions, view, state, &w.inputs);
            }
        }
    }

    /// The next stop of this cycle that concerns the present system.
    pub(super) fn next_stop(&self, place: &Place, w: &mut Workspace) -> Option<Stop> {
        let stops = &self.stops[(place.cycle % self.stops.len() as u64) as usize];
        let past = |stop: &Stop| stop.time < place.time;
        while stops.get(w.next_stop).is_some_and(past) {
            w.next_stop += 1;
        }
        let concerns = |stop: &&Stop| {
            let now = self.slot(w.set).states[stop.contact];
            (now > 0 && now != stop.state) || (stop.turns && w.line_of[stop.contact] != stop.line)
        };
        stops[w.next_stop..].iter().find(concerns).copied()
    }

    /// Takes contacts to their classes and lines behind a stop.
    pub(super) fn pass_stops(
        &self,
        place: &Place,
        time: f64,
        w: &mut Workspace,
    ) -> Result<(), TableError> {
        let stops = &self.stops[(place.cycle % self.stops.len() as u64) as usize];
        let mut turned = false;
        while let Some(stop) = stops.get(w.next_stop).filter(|stop| stop.time <= time) {
            if self.slot(w.set).states[stop.contact] > 0 {
                self.change(stop.contact, stop.state, w)?;
            }
            if stop.turns {
                w.line_of[stop.contact] = stop.line;
                turned = true;
            }
            w.next_stop += 1;
        }
        if turned {
            self.see_start(w);
        }
        Ok(())
    }

    /// Applies the saltation matrix of an event to all tangents, before the coordinates change.
    pub(super) fn apply_saltation(
        &self,
        contact: usize,
        state: usize,
        closes: bool,
        w: &mut Workspace,
    ) {
        let class = self.sets.class(contact, state);
        let system = self.system(w.set);
        let pull = &system.pulls[class.direction];
        let view = &system.views[self.model.directions[class.direction].line];
        let damping = if closes { -class.damping } else { class.damping };
        let length = w.length;
        for tangent in w.states.chunks_exact_mut(length).skip(1) {
            let seen: f64 = tangent.iter().zip(&view.row).map(|(x, r)| x * r).sum();
            for (x, g) in tangent.iter_mut().zip(pull) {
                *x += damping * seen * g;
            }
        }
    }
}
