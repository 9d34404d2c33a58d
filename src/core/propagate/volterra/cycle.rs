//! One mesh cycle: windows, events, breakpoints.
//!
//! Windows lie on a schedule: in contact on that of the closed contact, in free flight on that of the first contact. A
//! window starts on a cell boundary (`aligned`), at an event, or where the last one ends. In contact it may not pass
//! the end of the contact's segment, in free flight only the end of the cycle. No window passes a time at which a line
//! or a gap jumps. Off the cell grid, windows of full length follow one another until one would pass such a breakpoint.
//! That window is cut there, and the integration is aligned again. There is no grid with several closed contacts
//! ([`super::joint`]), dry sliders ([`super::slide`]), rigid stops ([`super::impact`]) or dry friction
//! ([`super::stick`]).

use super::Volterra;
use super::contact_tables::ContactTables;
use super::feedback::ContactSolve;
use super::grid::ROUNDING;
use super::impact::ImpactContext;
use super::joint::JointWindow;
use super::joint_stretch::JointStretch;
use super::lanes;
use super::position::{Position, SAME_TIME, WindowSource, align};
use super::release::ContactCondition;
use super::search::VisiblePart;
use super::tables::{Schedule, phases};
use super::varying::{Factors, Nodal};
use super::window_stiffness::WindowStiffness;
use super::window_table::WindowTable;
use super::workspace::Workspace;
use crate::model::{ActiveSet, TrajectoryState};
use crate::propagate::events::Changes;
use crate::propagate::{Counters, Event, Kernel, Observer, Stop, Tangents};

impl Kernel for Volterra<'_> {
    type Workspace = Workspace;

    fn workspace(&self) -> Workspace {
        Workspace::new(&self.model, &self.tables)
    }

    fn advance_cycle<O: Observer>(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        workspace: &mut Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        workspace.load(trajectory, tangents);
        let mut active = trajectory.contact;
        let mut position = Position {
            cycle: trajectory.cycle,
            time: 0.0,
            aligned: Some(0),
            crossed: ActiveSet::FREE,
            forceless: ActiveSet::FREE,
        };
        let mut changes = Changes::new(self.event_limit, self.tables.most_windows());
        while position.time < self.model.period() {
            if observer.is_interrupted() {
                return Err(Stop::Interrupted {
                    cycle: position.cycle,
                });
            }
            changes.count_window(position.cycle, position.time, self.model.period())?;
            self.step(
                &mut position,
                &mut active,
                &mut changes,
                workspace,
                observer,
                counters,
            )?;
        }
        self.let_slide(active, position.cycle, self.model.period(), workspace);
        self.move_onto_constraints(active, &position, workspace);
        trajectory.contact = active;
        trajectory.cycle += 1;
        counters.cycles += 1;
        workspace.store(trajectory, tangents);
        Ok(())
    }
}

impl Volterra<'_> {
    /// The schedule of windows while at most one contact is closed.
    fn schedule(&self, active: ActiveSet, cycle: u64) -> usize {
        self.tables.course_of(active.only().unwrap_or(0), cycle)
    }

    /// The schedule or joint stretch of the window at a position, the breakpoint that the window may not pass
    /// \[s\], and the cell that starts at this breakpoint.
    fn track(
        &self,
        position: &Position,
        active: ActiveSet,
    ) -> (WindowSource<'_>, f64, Option<usize>) {
        if active.count() > 1 || self.of_parts.touching() {
            let stretch = self.joint_stretch(position);
            return (WindowSource::Joint(stretch), stretch.end, None);
        }
        let schedule = self.tables.schedule(self.schedule(active, position.cycle));
        let stretch = schedule.stretch(position.aligned, position.time);
        let stop_cell = if active.touching() {
            schedule.grid.stretch_end_cell[stretch]
        } else {
            schedule.grid.flight_end_cell[stretch]
        };
        let stop = schedule.grid.time[stop_cell];
        (
            WindowSource::Schedule(schedule, stretch),
            stop,
            Some(stop_cell),
        )
    }

    /// The part of the mesh cycle at a position on which no contact changes its segment.
    fn joint_stretch(&self, position: &Position) -> &JointStretch {
        let stretches = &self.tables.joint;
        let stretches = &stretches[(position.cycle % stretches.len() as u64) as usize];
        let index = stretches.partition_point(|stretch| stretch.end <= position.time);
        &stretches[index.min(stretches.len() - 1)]
    }

    /// Solves one window and moves to its end, to the next event or to a breakpoint.
    fn step<O: Observer>(
        &self,
        position: &mut Position,
        active: &mut ActiveSet,
        changes: &mut Changes,
        workspace: &mut Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        let (track, stop, stop_cell) = self.track(position, *active);
        if position.aligned.is_none() && position.time >= stop - self.on_breakpoint {
            align(position, track, stop, stop_cell);
            return Ok(());
        }
        let table = &self.tables.windows[track.views()[0].window];
        let aligned = position.aligned.is_some() && !track.is_joint();
        let end = position.time + table.delta;
        let fits = aligned
            || if track.is_joint() {
                // A window that ends within rounding of the breakpoint is cut there. Otherwise the next
                // window would be as short as round-off, and its slopes would be the round-off of its values.
                end < stop - ROUNDING * self.model.period()
            } else {
                end <= stop
            };
        let limit = if fits {
            1.0
        } else {
            (2.0 * (stop - position.time) / table.delta - 1.0).min(1.0)
        };
        self.set_segments(position, track, *active, O::WINDOWS, workspace);
        self.set_inputs(position, track, &mut workspace.inputs);
        match track {
            WindowSource::Schedule(schedule, stretch) => {
                self.solve(
                    position,
                    (schedule, stretch),
                    table,
                    *active,
                    workspace,
                    counters,
                );
                if track.views().len() > 1 {
                    let observed = [O::WINDOWS, O::LINES];
                    self.see_other_lines(position, track, table, *active, observed, workspace);
                }
            }
            WindowSource::Joint(stretch) => {
                self.solve_jointly(position, stretch, *active, workspace)
            }
        }
        counters.windows += 1;
        self.check_range(position, track, workspace)?;
        let crossing = self.first_event(position, track, *active, limit, workspace, counters);
        let Some((found, place)) = crossing else {
            position.crossed = ActiveSet::FREE;
            position.forceless = ActiveSet::FREE;
            if fits && !track.is_joint() {
                self.move_full(position, track, *active, workspace, observer, counters);
            } else {
                self.move_to_cut(
                    limit,
                    position,
                    track,
                    *active,
                    workspace,
                    (observer, counters),
                );
                if !fits {
                    align(position, track, stop, stop_cell);
                }
            }
            return Ok(());
        };
        if self.of_parts.holds(found.contact) && !self.model.is_of_slider(found.contact) {
            let context = ImpactContext {
                model: &self.model,
                position,
                active,
                changes,
                observer,
                counters,
            };
            return self.meet_part(found, track, context, workspace);
        }
        let contact_at_crossing = self.contact_at(&found, position, track, *active, workspace);
        if found.x > -1.0 {
            self.move_to_cut(
                found.x,
                position,
                track,
                *active,
                workspace,
                (observer, counters),
            );
            position.aligned = None;
            // The integration has moved in time, so earlier openings and closings no longer count.
            position.crossed = ActiveSet::FREE;
            position.forceless = ActiveSet::FREE;
        }
        let on_surface = contact_at_crossing.on_surface && place == ContactCondition::Surface;
        let to = self.model.toggled(*active, found.contact);
        self.let_slide(active.without(to), position.cycle, position.time, workspace);
        let event = Event {
            cycle: position.cycle,
            time: position.time,
            from: *active,
            to,
            contact: found.contact,
            rate: contact_at_crossing.rate,
        };
        changes.meet(&event, observer, counters)?;
        // A step of δ at a prescribed time does not change tangents. Neither does a force that vanishes as the contact
        // opens.
        if workspace.tangents() > 0 && on_surface {
            self.apply_saltation(&event, workspace);
        }
        let joint = to.count() > 1 || active.count() > 1;
        if joint || self.schedule(to, event.cycle) != self.schedule(*active, event.cycle) {
            position.aligned = None;
        }
        *active = to;
        // The force of a damper jumps at the event, and so does the force of a stop that holds the structure.
        self.move_onto_constraints(to, position, workspace);
        if position.crossed.holds(found.contact) != on_surface {
            position.crossed = position.crossed.toggled(found.contact);
        }
        if position.forceless.holds(found.contact) != (place == ContactCondition::NoForce) {
            position.forceless = position.forceless.toggled(found.contact);
        }
        Ok(())
    }

    /// Solves a window with at most one contact closed, along the line of its force.
    fn solve(
        &self,
        position: &Position,
        (schedule, stretch): (&Schedule, usize),
        table: &WindowTable,
        active: ActiveSet,
        workspace: &mut Workspace,
        counters: &mut Counters,
    ) {
        let set = self.instructions;
        let Some(contact) = active.only() else {
            let (inputs, columns, _, forces, solution) = workspace.solving();
            lanes::solve(set, &table.rows, inputs, columns, None, forces, solution);
            return;
        };
        let segment = workspace.segments[contact];
        let contact_data = &self.model.contacts[contact];
        // Off the grid there is no operator for a varying stiffness.
        let tables = table.contact(set);
        let system = match (&tables.nodal, position.aligned) {
            (Some(nodal), None) if !segment.stiffness.is_constant() => Some(&**nodal),
            _ => None,
        };
        if let Some(nodal) = system {
            let closure = WindowStiffness::new(&self.model, &segment, position.time, table.delta);
            closure.factorise(set, nodal, &mut workspace.factors);
            counters.factorised += 1;
        }
        // The solver takes the gap error times the contact's side, s e.
        let track = WindowSource::Schedule(schedule, stretch);
        let gap_error = (self.tables.gap_errors[contact])
            .then(|| self.gap_error(position, contact, track, workspace))
            .map(|gap_error| gap_error.map(|a| contact_data.side * a));
        let (inputs, columns, factors, forces, solution) = workspace.solving();
        let closed = closed(
            (schedule, stretch),
            tables,
            position.aligned,
            system,
            factors,
        );
        lanes::solve(
            set,
            &table.rows,
            inputs,
            columns,
            Some((
                closed,
                contact_data.side * contact_data.half_gap,
                gap_error.as_ref(),
            )),
            forces,
            solution,
        );
        solution.add_gap_error(gap_error.as_ref());
    }

    /// Solves a window on a joint stretch.
    fn solve_jointly(
        &self,
        position: &Position,
        stretch: &JointStretch,
        active: ActiveSet,
        workspace: &mut Workspace,
    ) {
        let segments = std::mem::take(&mut workspace.segments);
        let window = JointWindow {
            model: &self.model,
            tables: &self.tables,
            set: self.instructions,
            stretch,
            segments: &segments,
            active,
            time: position.time,
            delta: self.tables.windows[stretch.windows[0]].delta,
        };
        let (inputs, columns, joint, solutions, count) = workspace.joining();
        window.solve(inputs, columns, count, joint, solutions);
        workspace.segments = segments;
    }

    /// Writes the segment of every contact on a window. It is exact for contacts whose segment the window may not
    /// leave. Segments of open contacts without gap errors are for observers only (`observed`).
    fn set_segments(
        &self,
        position: &Position,
        track: WindowSource<'_>,
        active: ActiveSet,
        observed: bool,
        workspace: &mut Workspace,
    ) {
        let contacts = self.model.contacts.iter().enumerate();
        for ((index, contact), segment) in contacts.zip(&mut workspace.segments) {
            let cycle = contact.cycle(position.cycle);
            *segment = match track {
                WindowSource::Joint(stretch) => cycle.segments[stretch.segments[index]],
                WindowSource::Schedule(schedule, stretch) if active.holds(index) => {
                    cycle.segments[schedule.grid.segment_of_stretch[stretch]]
                }
                // A time on a boundary is exact only to rounding.
                WindowSource::Schedule(..) if observed || self.tables.gap_errors[index] => {
                    *cycle.segment_at(position.time + SAME_TIME * cycle.period)
                }
                WindowSource::Schedule(..) => continue,
            };
        }
    }

    /// Writes the inputs' values at the start of a window.
    fn set_inputs(&self, position: &Position, track: WindowSource<'_>, inputs: &mut [f64]) {
        let t = &self.tables;
        let (constant, harmonics) = inputs.split_at_mut(1);
        constant[0] = 1.0;
        let (ripples, rest) = harmonics.split_at_mut(2 * t.ripple.len());
        let errors = &mut rest[..2 * t.frequencies.len()];
        for (pair, r) in ripples.chunks_exact_mut(2).zip(&self.model.ripple) {
            let (sin, cos) = r.phase_at(position.cycle, position.time).sin_cos();
            pair.copy_from_slice(&[cos, sin]);
        }
        if let (WindowSource::Schedule(schedule, _), Some(cell)) = (track, position.aligned)
            && t.errors_recur
        {
            errors.copy_from_slice(&schedule.cell_phases[cell * errors.len()..][..errors.len()]);
            return;
        }
        for (pair, &frequency) in errors.chunks_exact_mut(2).zip(&t.frequencies) {
            pair.copy_from_slice(&phases(frequency, position.cycle, position.time));
        }
    }

    /// Moves trajectory and tangents over a full window.
    fn move_full<O: Observer>(
        &self,
        position: &mut Position,
        track: WindowSource<'_>,
        active: ActiveSet,
        workspace: &mut Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) {
        let table = &self.tables.windows[track.views()[0].window];
        if O::WINDOWS {
            let view = VisiblePart {
                position,
                track,
                active,
                duration: table.delta,
                cut: None,
                along: &[],
            };
            self.show(view, workspace, observer);
        }
        counters.tangent_windows += workspace.tangents() as u64;
        let (columns, forces, inputs, ..) = workspace.cutting(active.touching());
        let inputs = &inputs[..self.tables.layout.acting];
        lanes::advance(self.instructions, &table.moves, forces, inputs, columns);
        match (&mut position.aligned, track) {
            (Some(cell), WindowSource::Schedule(schedule, _)) => {
                *cell += 1;
                position.time = schedule.grid.time[*cell];
            }
            _ => position.time += table.delta,
        }
    }

    /// Moves trajectory and tangents to `end`, a position in the present window.
    pub(super) fn move_to_cut<O: Observer>(
        &self,
        end: f64,
        position: &mut Position,
        track: WindowSource<'_>,
        active: ActiveSet,
        workspace: &mut Workspace,
        (observer, counters): (&mut O, &mut Counters),
    ) {
        let first = match track {
            WindowSource::Schedule(..) => track.views()[0].window,
            WindowSource::Joint(stretch) => stretch.windows[active.iter().next().unwrap_or(0)],
        };
        let table = &self.tables.windows[first];
        let with_nodes = O::WINDOWS || active.touching();
        let tau = self.prepare_cut(table, end, with_nodes, &mut workspace.cut);
        counters.partial_windows += 1;
        if O::WINDOWS {
            let view = VisiblePart {
                position,
                track,
                active,
                duration: tau,
                cut: Some(&workspace.cut),
                along: &[],
            };
            self.show(view, workspace, observer);
        }
        counters.tangent_windows += workspace.tangents() as u64;
        let (columns, forces, inputs, cut, joint) = workspace.cutting(active.touching());
        match track {
            WindowSource::Joint(stretch) if !forces.is_empty() => {
                let count = forces.len();
                forces.copy_from_slice(&joint.forces[..count]);
                self.cut(table, cut, forces, inputs, columns);
                let others = joint.forces.chunks_exact_mut(count);
                for (contact, forces) in active.iter().zip(others).skip(1) {
                    let table = &self.tables.windows[stretch.windows[contact]];
                    self.add_force_of_contact(table, cut, forces, columns);
                }
            }
            _ => self.cut(table, cut, forces, inputs, columns),
        }
        position.time += tau;
    }

    /// Applies the saltation matrix of an event to all tangents.
    fn apply_saltation(&self, event: &Event, workspace: &mut Workspace) {
        for contact in event.changed() {
            let cycle = self.model.contacts[contact].cycle(event.cycle);
            let segment = cycle.segment_at(event.time + SAME_TIME * cycle.period);
            let closes = event.to.holds(contact);
            let damping = if closes { segment.damping } else { -segment.damping };
            let blocks = &self.tables.blocks[segment.direction];
            lanes::apply_saltation(self.instructions, blocks, damping, workspace.tangents_mut());
        }
    }
}

/// The solution operator of the closed contact on the window.
fn closed<'a>(
    (schedule, stretch): (&Schedule, usize),
    tables: &'a ContactTables,
    aligned: Option<usize>,
    system: Option<&'a Nodal>,
    factors: &'a Factors,
) -> ContactSolve<'a> {
    if let Some(nodal) = system {
        return ContactSolve::Factors(nodal, factors);
    }
    // Off the grid the stiffness is constant, so the operator of any cell of the stretch is valid.
    let cell = aligned.unwrap_or(schedule.grid.stretch_end_cell[stretch] - 1);
    ContactSolve::Table(&tables.feedback[schedule.feedback_of_cell[cell]])
}
