//! Changes from one system to another, at events and breakpoints, and conversions to modal states and back.

use super::ClosedModes;
use super::block_check;
use super::lanes;
use super::sets::CycleBreakpoint;
use super::workspace::{CyclePosition, Workspace};
use crate::model::TrajectoryState;
use crate::propagate::{TableError, Tangents};

impl ClosedModes<'_> {
    /// Converts trajectory and tangents to the coordinates of the present system at the start of a cycle.
    pub(super) fn begin(
        &self,
        trajectory: &TrajectoryState,
        tangents: &Tangents,
        w: &mut Workspace,
    ) -> Result<(), TableError> {
        let cycle = trajectory.cycle;
        self.frequencies.write(cycle, 0.0, &mut w.inputs);
        w.put(&trajectory.state, tangents);
        w.begin(&self.starts[(cycle % self.starts.len() as u64) as usize]);
        self.of_modes(self.sets.of(trajectory.contact, &w.closed), w)?;
        w.find_watched_contacts(&self.model.contacts, trajectory.contact);
        self.plan(cycle, 0.0, w);
        self.evaluate_start_states(w);
        Ok(())
    }

    /// Converts trajectory and tangents back to modal states.
    pub(super) fn end(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        w: &mut Workspace,
    ) {
        self.to_modes(w);
        w.take(trajectory, tangents);
    }

    /// Converts from the coordinates of the present system to modes.
    fn to_modes(&self, w: &mut Workspace) {
        let slot = self.slot(w.set);
        let responses = &slot.system.steady.responses;
        match slot.basis.to_modes() {
            Some(map) => self.map(map, [responses, &[]], w),
            None => self.add_steady_response(1.0, w),
        }
    }

    /// Converts from modes to the coordinates of a system.
    fn of_modes(&self, set: usize, w: &mut Workspace) -> Result<(), TableError> {
        let slot = self.slot_or_build(set)?;
        w.set = set;
        w.bounded = false;
        let responses = &slot.system.steady.responses;
        match slot.basis.of_modes() {
            Some(map) => self.map(map, [&[], responses], w),
            None => self.add_steady_response(-1.0, w),
        }
        Ok(())
    }

    /// Computes `states = map states`. The steady response of the first system is added to the trajectory
    /// before the map. That of the second system is subtracted after it.
    fn map(&self, columns: &[f64], responses: [&[f64]; 2], w: &mut Workspace) {
        lanes::map(
            self.instructions,
            columns,
            &self.mixed,
            responses,
            &w.inputs,
            &mut w.states,
            &mut w.spare,
        );
        std::mem::swap(&mut w.states, &mut w.spare);
    }

    /// Adds `factor` times the steady response to the trajectory's state.
    fn add_steady_response(&self, factor: f64, w: &mut Workspace) {
        let responses = &self.system(w.set).steady.responses;
        let state = &mut w.states[..w.length];
        lanes::add_responses(self.instructions, responses, &w.inputs, factor, state);
    }

    /// Changes the state of a contact.
    ///
    /// # Errors
    /// The new system has no table.
    pub(super) fn change(
        &self,
        contact: usize,
        state: usize,
        w: &mut Workspace,
    ) -> Result<(), TableError> {
        let old_slot = self.slot(w.set);
        if old_slot.states[contact] == state {
            return Ok(());
        }
        let to = self.sets.with(w.set, contact, state);
        let new_slot = self.slot_or_build(to)?;
        // The coordinates of free flight are modes, so the maps of the other system to and from modes
        // suffice.
        let direct = match (old_slot.basis.to_modes(), new_slot.basis.of_modes()) {
            (Some(_), Some(_)) => self.bases.change(w.set, contact, state),
            (leads, None) | (None, leads) => leads,
        };
        match direct {
            Some(map) => {
                let [before, after] =
                    [old_slot, new_slot].map(|slot| &slot.system.steady.responses[..]);
                self.map(map, [before, after], w);
                w.set = to;
                w.bounded = false;
                Ok(())
            }
            None => {
                self.to_modes(w);
                self.of_modes(to, w)
            }
        }
    }

    /// Deflections and their rates at the present time along the lines of all contacts.
    pub(super) fn evaluate_start_states(&self, w: &mut Workspace) {
        block_check::evaluate_line_states(
            self.instructions,
            self.system(w.set),
            &w.states[..w.length],
            &w.inputs,
            &w.lines,
            &mut w.line_states,
        );
    }

    /// The breakpoints of a cycle.
    fn breakpoints(&self, cycle: u64) -> &[CycleBreakpoint] {
        &self.breakpoints[(cycle % self.breakpoints.len() as u64) as usize]
    }

    /// Passes the breakpoints before `time` \[s\], none of which changes the present system. Then [`Workspace::closed`]
    /// has the state in which a contact closes at this time of a cycle.
    pub(super) fn pass_breakpoints_of_open_contacts(
        &self,
        cycle: u64,
        time: f64,
        w: &mut Workspace,
    ) {
        let breakpoints = self.breakpoints(cycle);
        while let Some(breakpoint) = breakpoints
            .get(w.next_breakpoint)
            .filter(|breakpoint| breakpoint.time < time)
        {
            w.closed[breakpoint.contact] = breakpoint.state;
            w.next_breakpoint += 1;
        }
    }

    /// Finds the next breakpoint of this cycle that concerns the present system.
    pub(super) fn plan(&self, cycle: u64, time: f64, w: &mut Workspace) {
        self.pass_breakpoints_of_open_contacts(cycle, time, w);
        let breakpoints = self.breakpoints(cycle);
        let states = &self.slot(w.set).states;
        let concerns = |breakpoint: &&CycleBreakpoint| {
            let now = states[breakpoint.contact];
            (now > 0 && now != breakpoint.state)
                || (breakpoint.turns && w.line_of[breakpoint.contact] != breakpoint.line)
        };
        w.breakpoint = breakpoints[w.next_breakpoint..]
            .iter()
            .find(concerns)
            .copied();
    }

    /// Gives contacts the stiffness class and the line of action that they have after a breakpoint of the mesh cycle.
    pub(super) fn pass_breakpoints(
        &self,
        place: &CyclePosition,
        time: f64,
        w: &mut Workspace,
    ) -> Result<(), TableError> {
        let breakpoints = self.breakpoints(place.cycle);
        let mut line_changes = false;
        while let Some(breakpoint) = breakpoints
            .get(w.next_breakpoint)
            .filter(|breakpoint| breakpoint.time <= time)
        {
            w.closed[breakpoint.contact] = breakpoint.state;
            if self.slot(w.set).states[breakpoint.contact] > 0 {
                self.change(breakpoint.contact, breakpoint.state, w)?;
            }
            if breakpoint.turns {
                w.line_of[breakpoint.contact] = breakpoint.line;
                line_changes = true;
            }
            w.next_breakpoint += 1;
        }
        if line_changes {
            w.find_watched_contacts(&self.model.contacts, place.active);
            self.evaluate_start_states(w);
        }
        self.plan(place.cycle, time, w);
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
        for tangent in w.states.chunks_exact_mut(w.length).skip(1) {
            lanes::kick(self.instructions, &view.rows[0], pull, damping, tangent);
        }
    }
}
