//! One mesh cycle of any table kernel: stretches, events, breakpoints.
//!
//! A stretch starts on a cell boundary or at an event. The kernel's [`Method`] moves the state to the end of the
//! stretch or to the first event before it. In contact a stretch must not pass the end of its cell. In free flight, if
//! the method allows it, a stretch spans several cells, up to the end of the cycle, a change of direction or
//! [`Method::REACH`]. A method may also cross several cells in contact at once (a run).

use super::cell_model::{CellModel, Position};
use super::exits::{DeflectionAt, MarginAt};
use super::matrix::{Operator, dot, reach};
use super::show::{Picture, show};
use super::state_part::{Exit, StatePart};
use crate::model::{ActiveSet, TrajectoryState};
use crate::propagate::events::{Changes, Margin};
use crate::propagate::{Counters, Event, FARTHEST, Observer, Stop, Tangents, saltation};

/// How a table kernel crosses a stretch.
pub trait Method: Sync {
    /// Scratch memory.
    type Scratch;
    /// Largest product of the length of a cell, or of a stretch over several cells, and the fastest rate.
    const REACH: f64;
    /// Whether stretches in free flight may span cells.
    const FLIES: bool;

    /// All stored operators.
    fn operators(&self) -> impl Iterator<Item = &Operator>;

    /// Scratch memory for a model.
    fn scratch(&self, cell_model: &CellModel<'_>) -> Self::Scratch;

    /// Moves the state `z` to the first event of the stretch and returns this event, or to the end of the stretch.
    fn pass(
        &self,
        cell_model: &CellModel<'_>,
        stretch: &StatePart,
        z: &mut [f64],
        scratch: &mut Self::Scratch,
        counters: &mut Counters,
    ) -> Option<Exit>;

    /// Moves a tangent vector over the first `time` of the stretch just passed.
    fn follow(
        &self,
        cell_model: &CellModel<'_>,
        stretch: &StatePart,
        time: f64,
        x: &mut [f64],
        scratch: &mut Self::Scratch,
        counters: &mut Counters,
    );

    /// Moves the state over whole cells without an event, if it can certify that there is none; returns their number.
    fn run(
        &self,
        _: &CellModel<'_>,
        _: &StatePart,
        _: &mut [f64],
        _: &mut Self::Scratch,
        _: &mut Counters,
    ) -> Option<usize> {
        None
    }

    /// Moves a tangent vector over the cells of the last run.
    fn follow_run(&self, _: &mut [f64], _: &mut Self::Scratch, _: &mut Counters) {}
}

/// Scratch memory of a table kernel.
#[derive(Debug)]
pub struct Workspace<S> {
    state: Vec<f64>,
    start: Vec<f64>,
    tangents: Vec<Vec<f64>>,
    tangent_count: usize,
    picture: Picture,
    scratch: S,
}

impl CellModel<'_> {
    pub fn workspace<S>(&self, scratch: S) -> Workspace<S> {
        let padded = self.layout.padded();
        Workspace {
            state: vec![0.0; padded],
            start: vec![0.0; padded],
            tangents: Vec::new(),
            tangent_count: 0,
            picture: Picture::new(padded),
            scratch,
        }
    }

    /// Advances one mesh cycle.
    pub fn advance_cycle<M: Method, O: Observer>(
        &self,
        method: &M,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        workspace: &mut Workspace<M::Scratch>,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        let n = 2 * self.layout.modes;
        let w = workspace;
        w.state[..n].copy_from_slice(&trajectory.state);
        w.tangent_count = tangents.count();
        if w.tangents.len() < tangents.count() {
            let padded = self.layout.padded();
            (w.tangents).resize_with(tangents.count(), || vec![0.0; padded]);
        }
        for (i, x) in w.tangents[..w.tangent_count].iter_mut().enumerate() {
            x[..n].copy_from_slice(tangents.vector(i));
        }
        let mut position = Position {
            cycle: trajectory.cycle,
            time: 0.0,
            cell: 0,
            aligned: true,
            crossed: None,
        };
        let mut contact = trajectory.contact;
        // A stretch that ends at a time of the event grid without a change of contact is an additional window.
        let put_off = self.event_grid.unwrap_or(0) as usize;
        let mut changes = Changes::new(self.event_limit, self.grid.cells.len() + put_off);
        while position.cell < self.grid.cells.len() {
            if observer.is_interrupted() {
                return Err(Stop::Interrupted {
                    cycle: position.cycle,
                });
            }
            changes.count_window(position.cycle, position.time, self.grid.period)?;
            self.step(
                method,
                &mut position,
                &mut contact,
                &mut changes,
                w,
                observer,
                counters,
            )?;
        }
        if !w.state[..n].iter().all(|x| x.is_finite()) {
            return Err(Stop::Diverged {
                cycle: position.cycle,
            });
        }
        trajectory.state.copy_from_slice(&w.state[..n]);
        trajectory.contact = contact;
        trajectory.cycle += 1;
        for (i, x) in w.tangents[..w.tangent_count].iter().enumerate() {
            tangents.vector_mut(i).copy_from_slice(&x[..n]);
        }
        counters.cycles += 1;
        Ok(())
    }

    /// Passes one stretch.
    #[expect(
        clippy::too_many_arguments,
        reason = "the state of the published algorithms"
    )]
    fn step<M: Method, O: Observer>(
        &self,
        method: &M,
        position: &mut Position,
        contact: &mut ActiveSet,
        changes: &mut Changes,
        w: &mut Workspace<M::Scratch>,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        let stop = self.stop_cell::<M>(position, *contact);
        let end = self.grid.time(stop);
        if position.time >= end {
            self.align(position, stop);
            return Ok(());
        }
        self.set_carried(position, *contact, &mut w.state);
        let generator = self.generator(position.cell, *contact);
        let deflection = dot(&generator.deflection, &w.state);
        if deflection.is_nan() || deflection.abs() > FARTHEST * self.model.half_gap {
            return Err(Stop::Diverged {
                cycle: position.cycle,
            });
        }
        let whole = position.aligned && stop == position.cell + 1;
        let duration = if whole { self.grid.duration(position.cell) } else { end - position.time };
        let size = reach(&generator.magnitude, &w.state);
        let stretch = StatePart {
            cell: position.cell,
            contact: *contact,
            duration,
            whole,
            crossed: position.crossed.take(),
            noise: self.round_off * (size + self.model.half_gap),
        };
        if O::WINDOWS {
            w.start.copy_from_slice(&w.state);
        }
        if whole
            && let Some(cells) = method.run(self, &stretch, &mut w.state, &mut w.scratch, counters)
        {
            counters.windows += cells as u64;
            if O::WINDOWS {
                self.show_run(&stretch, cells, position.cycle, w, observer);
            }
            for x in &mut w.tangents[..w.tangent_count] {
                method.follow_run(x, &mut w.scratch, counters);
                counters.tangent_windows += 1;
            }
            self.align(position, position.cell + cells);
            return Ok(());
        }
        if let Some(crossed) = self.outside(&stretch, deflection) {
            // δ jumps across the surface at a prescribed time: tangents are unchanged.
            return self.switch(
                position, contact, crossed, changes, &w.state, observer, counters,
            );
        }
        counters.windows += 1;
        counters.partial_windows += u64::from(!whole);
        let mut exit = method.pass(self, &stretch, &mut w.state, &mut w.scratch, counters);
        let mut passed = exit.map_or(duration, |exit| exit.time);
        if let (Some(parts), Some(found)) = (self.event_grid, exit) {
            let grid = self.grid.period / f64::from(parts);
            let late = ((position.time + found.time) / grid).ceil() * grid - position.time;
            let rest = late.min(duration) - found.time;
            if rest > 0.0 {
                passed = found.time + rest;
                let crossing = Position {
                    time: position.time + found.time,
                    aligned: false,
                    ..*position
                };
                self.set_carried(&crossing, *contact, &mut w.state);
                method.follow(self, &stretch, rest, &mut w.state, &mut w.scratch, counters);
            }
            exit = Some(Exit {
                time: passed,
                ..found
            });
        }
        if O::WINDOWS && passed > 0.0 {
            show(
                self,
                &stretch,
                position.cycle,
                position.time,
                passed,
                &w.start,
                &mut w.picture,
                observer,
            );
        }
        if passed > 0.0 {
            for x in &mut w.tangents[..w.tangent_count] {
                method.follow(self, &stretch, passed, x, &mut w.scratch, counters);
                counters.tangent_windows += 1;
            }
        }
        let Some(exit) = exit else {
            self.align(position, stop);
            return Ok(());
        };
        if passed > 0.0 {
            position.time += passed;
            position.aligned = false;
            while position.time >= self.grid.time(position.cell + 1) && position.cell + 1 < stop {
                position.cell += 1;
            }
        }
        self.set_carried(position, *contact, &mut w.state);
        let crossed = match self.event_grid {
            None => Some(exit.contact),
            Some(_) => self.contact_to_switch(position, *contact, &w.state),
        };
        let Some(crossed) = crossed else {
            return Ok(());
        };
        let entering = !contact.holds(crossed);
        let segment = &self.model.first_cycle().segments[self.grid.cells[position.cell].segment];
        for x in &mut w.tangents[..w.tangent_count] {
            let (first, second) = x[..2 * self.layout.modes].split_at_mut(self.layout.modes);
            saltation::apply(
                self.model.gains(segment),
                segment.damping,
                entering,
                first,
                second,
            );
        }
        self.switch(
            position, contact, crossed, changes, &w.state, observer, counters,
        )?;
        position.crossed = self.event_grid.is_none().then_some(crossed);
        Ok(())
    }

    /// Index of the last cell boundary that a stretch may reach.
    fn stop_cell<M: Method>(&self, position: &Position, contact: ActiveSet) -> usize {
        let mut stop = position.cell + 1;
        if contact.touching() || !M::FLIES {
            return stop;
        }
        let cells = &self.grid.cells;
        let direction =
            |cell: usize| self.model.first_cycle().segments[cells[cell].segment].direction;
        let farthest = position.time + M::REACH / self.grid.rate;
        while stop < cells.len()
            && direction(stop) == direction(position.cell)
            && self.grid.time(stop + 1) <= farthest
        {
            stop += 1;
        }
        stop
    }

    /// The first contact whose margin is negative at the start of a stretch, by more than round-off; `None` if there is
    /// none.
    fn outside(&self, stretch: &StatePart, deflection: f64) -> Option<usize> {
        let here = DeflectionAt {
            time: 0.0,
            deflection: [deflection, 0.0, 0.0],
        };
        Margin::of(&self.model.contacts, stretch.contact)
            // The contact that was just crossed is on its surface, to the round-off of the location.
            .filter(|margin| stretch.crossed != Some(margin.contact))
            .find(|margin| MarginAt::of(margin, &here).value < -stretch.noise)
            .map(|margin| margin.contact)
    }

    /// The contact that opens or closes first to agree with δ and δ'; `None` if all agree.
    fn contact_to_switch(
        &self,
        position: &Position,
        contact: ActiveSet,
        z: &[f64],
    ) -> Option<usize> {
        let generator = self.generator(position.cell, contact);
        let (deflection, rate) = (dot(&generator.deflection, z), dot(&generator.rate, z));
        let changes = |index: &usize| {
            let contact_data = &self.model.contacts[*index];
            contact.holds(*index)
                != contact_data.is_reached(deflection, rate, [contact_data.half_gap, 0.0])
        };
        // A closed contact must open before the other closes.
        let mut changing = (0..self.model.contacts.len()).filter(changes);
        let closed = changing.clone().find(|index| contact.holds(*index));
        closed.or_else(|| changing.next())
    }

    #[expect(
        clippy::too_many_arguments,
        reason = "the state of the published algorithms"
    )]
    fn switch<O: Observer>(
        &self,
        position: &Position,
        active: &mut ActiveSet,
        contact: usize,
        changes: &mut Changes,
        z: &[f64],
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        let from = *active;
        *active = from.toggled(contact);
        let event = Event {
            cycle: position.cycle,
            time: position.time,
            from,
            to: *active,
            contact,
            rate: dot(&self.generator(position.cell, from).rate, z),
        };
        changes.meet(&event, observer, counters)
    }

    /// Passes the cells of a run to the observer one by one. The start state of each follows from the Taylor series of
    /// the cell before.
    fn show_run<O: Observer, S>(
        &self,
        stretch: &StatePart,
        cells: usize,
        cycle: u64,
        w: &mut Workspace<S>,
        observer: &mut O,
    ) {
        for cell in stretch.cell..stretch.cell + cells {
            let one = StatePart {
                cell,
                duration: self.grid.duration(cell),
                ..*stretch
            };
            let start = self.grid.time(cell);
            show(
                self,
                &one,
                cycle,
                start,
                one.duration,
                &w.start,
                &mut w.picture,
                observer,
            );
            w.start.copy_from_slice(w.picture.last_state());
        }
    }
}
