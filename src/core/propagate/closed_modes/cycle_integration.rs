//! Integration from one event to the next: blocks and breakpoints.
//!
//! A block starts at the end of the last one, at an event or at a breakpoint. At a breakpoint a closed
//! contact changes its class or a contact its line. A block ends at its eighth node, at the next event or at
//! the next breakpoint.

use super::ClosedModes;
use super::block_check::{Rates, evaluate_line_states_body};
use super::excitation::Frequencies;
use super::first_event::{BlockEvent, SplitTime};
use super::grid::NODES;
use super::lanes::{self, advance_body, advance_little_body, advance_to_body};
use super::workspace::{CyclePosition, Workspace};
use crate::model::ActiveSet;
use crate::propagate::events::{Changes, Margin};
use crate::propagate::vectors::{InstructionSet, Vector, for_each_set};
use crate::propagate::{Counters, Event, Stop as End};

/// Round-off of sums of times, as a part of a mesh period.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// The integration of a mesh cycle in progress.
pub struct CycleIntegration<'a, 'm> {
    /// The kernel.
    pub kernel: &'a ClosedModes<'m>,
    /// The present time and contacts.
    pub place: CyclePosition,
    /// Rates of the margins of those contacts that opened or closed at this instant \[m/s\].
    pub rates: Rates,
    /// Events and blocks so far.
    pub changes: Changes,
    /// The next block, already shown to observers but not yet integrated: the event at its end, and its
    /// length \[s\].
    pub next: Option<(Option<BlockEvent>, f64)>,
    /// Whether blocks are shown.
    pub shows: bool,
    /// The states.
    pub w: &'a mut Workspace,
    /// The work done.
    pub counters: &'a mut Counters,
}

/// Why the integration returns to its caller.
pub enum ReturnReason {
    /// A block of this length \[s\] is ready for observers.
    Window(f64),
    /// A contact has opened or closed.
    Event(Event),
    /// The cycle is over.
    End,
}

for_each_set! {
    /// Integrates up to the next block or event that observers may see, or to the end of the cycle.
    fn pass(integration: &mut CycleIntegration<'_, '_>) -> Result<ReturnReason, End> = pass_body
}

#[inline(always)]
fn pass_body<V: Vector>(integration: &mut CycleIntegration<'_, '_>) -> Result<ReturnReason, End> {
    let kernel = integration.kernel;
    let period = kernel.model.period();
    while integration.place.time < period {
        let (event, duration) = match integration.next.take() {
            Some(next) => next,
            None => {
                let CyclePosition { cycle, time, .. } = integration.place;
                integration.changes.count_window(cycle, time, period)?;
                let next = look_ahead::<V>(integration);
                kernel.check_range(&integration.place, integration.w)?;
                if integration.shows && next.1 > 0.0 {
                    integration.next = Some(next);
                    return Ok(ReturnReason::Window(next.1));
                }
                next
            }
        };
        let Some(event) = event else {
            to_the_end::<V>(integration, duration)?;
            continue;
        };
        if duration > 0.0 {
            kernel.move_to::<V>(duration, integration.w);
            integration.step_on(duration);
            integration.counters.partial_windows += 1;
        }
        return Ok(ReturnReason::Event(meet::<V>(integration, event)?));
    }
    Ok(ReturnReason::End)
}

/// The first event on the next block, and the time \[s\] until it or the end of the block.
#[inline(always)]
fn look_ahead<V: Vector>(integration: &mut CycleIntegration<'_, '_>) -> (Option<BlockEvent>, f64) {
    let kernel = integration.kernel;
    let left = integration.left();
    let whole = NODES as f64 * kernel.step;
    integration.counters.windows += 1;
    let event = if left > 0.0 {
        let CycleIntegration {
            place,
            rates,
            w,
            counters,
            ..
        } = integration;
        kernel.first_event::<V>(place, rates, left.min(whole), w, counters)
    } else {
        None
    };
    let duration = match event {
        Some(event) => event.time,
        None if integration.fits() => whole,
        None => left,
    };
    (event, duration)
}

/// Moves to the end of a block without an event.
#[inline(always)]
fn to_the_end<V: Vector>(
    integration: &mut CycleIntegration<'_, '_>,
    duration: f64,
) -> Result<(), End> {
    let kernel = integration.kernel;
    let arrives = integration.left() <= duration + ROUNDING * kernel.model.period();
    if integration.fits() {
        kernel.move_block::<V>(integration.w);
    } else {
        kernel.move_to::<V>(duration, integration.w);
        integration.counters.partial_windows += 1;
        if integration.w.breakpoint.is_some() {
            kernel.evaluate_lines::<V>(integration.w);
        }
    }
    let limit = integration.limit();
    integration.step_on(duration);
    if arrives {
        let place = &mut integration.place;
        place.time = limit;
        if integration.w.breakpoint.is_some() {
            (kernel.pass_breakpoints(place, limit, integration.w))
                .map_err(|error| place.refused(error))?;
        }
    }
    Ok(())
}

/// Applies an event at the present states.
#[inline(always)]
fn meet<V: Vector>(
    integration: &mut CycleIntegration<'_, '_>,
    block_event: BlockEvent,
) -> Result<Event, End> {
    let kernel = integration.kernel;
    let (place, w) = (&mut integration.place, &mut *integration.w);
    let contact = block_event.contact;
    kernel.evaluate_lines::<V>(w);
    let event = Event {
        cycle: place.cycle,
        time: place.time,
        from: place.active,
        to: place.active.toggled(contact),
        contact,
        rate: w.line_states[w.line_of[contact]].rate,
    };
    kernel.pass_breakpoints_of_open_contacts(place.cycle, place.time, w);
    let state = w.closed[contact];
    if block_event.on_surface && w.states.len() > w.length {
        kernel.apply_saltation(contact, state, event.closes(), w);
    }
    (kernel.change(contact, if event.closes() { state } else { 0 }, w))
        .map_err(|error| place.refused(error))?;
    place.active = event.to;
    if place.crossed.holds(contact) != block_event.on_surface {
        place.crossed = place.crossed.toggled(contact);
    }
    w.find_watched_contacts(&kernel.model.contacts, place.active);
    kernel.plan(place.cycle, place.time, w);
    let margin = Margin::new(&kernel.model.contacts[contact], contact, event.closes());
    integration.rates[contact] = margin.scale * event.rate;
    Ok(event)
}

impl CycleIntegration<'_, '_> {
    /// Time of the cycle \[s\] up to which the present system is valid, unless an event comes first.
    #[inline(always)]
    fn limit(&self) -> f64 {
        (self.w.breakpoint).map_or(self.kernel.model.period(), |breakpoint| breakpoint.time)
    }

    /// Time left until [`Self::limit`] \[s\].
    #[inline(always)]
    fn left(&self) -> f64 {
        self.limit() - self.place.time
    }

    /// Whether a whole block ends before [`Self::limit`].
    #[inline(always)]
    fn fits(&self) -> bool {
        let whole = NODES as f64 * self.kernel.step;
        self.left() >= whole - ROUNDING * self.kernel.model.period()
    }

    /// Updates position and counters after a move by some time \[s\].
    #[inline(always)]
    fn step_on(&mut self, duration: f64) {
        self.place.time += duration;
        self.place.crossed = ActiveSet::FREE;
        self.counters.tangent_windows += (self.w.states.len() / self.w.length - 1) as u64;
    }
}

impl ClosedModes<'_> {
    /// Moves all states and inputs over a whole block.
    #[inline(always)]
    fn move_block<V: Vector>(&self, w: &mut Workspace) {
        let system = self.system(w.set);
        advance_body::<V>(system.moves_to(NODES), &mut w.states);
        let half = w.length / 2;
        for (drift, pushes) in system.steady.drifts.iter().zip(&system.pushes) {
            let [x, y] = pushes[NODES - 1];
            w.states[drift.lane] += x;
            w.states[half + drift.lane] += y;
        }
        Frequencies::turn(&self.turns[NODES - 1], &mut w.inputs);
        for &line in &w.lines {
            w.line_states[line].start = w.line_states[line].nodes.0[NODES - 1];
        }
    }

    /// Moves all states and inputs to a time within a block. The next block starts there.
    #[inline(always)]
    fn move_to<V: Vector>(&self, time: f64, w: &mut Workspace) {
        let system = self.system(w.set);
        let parts = SplitTime::new(self, system, time);
        let remaining = match w.spare_time {
            Some(spare_time) => time - spare_time,
            None => f64::INFINITY,
        };
        if remaining.abs() * self.fastest() <= lanes::LITTLE {
            advance_little_body::<V>(&system.chunks, remaining, &mut w.spare);
            self.frequencies
                .turn_a_little(remaining, &mut w.spare_inputs);
        } else {
            // The rows do not matter: their products are not used.
            let (rows, map_to_node) = (&system.views[0].rows, parts.map_to_node());
            advance_to_body::<V>(
                &system.chunks,
                map_to_node,
                parts.rest,
                rows,
                &w.states,
                &mut w.spare,
            );
            let turns = parts.turns(self);
            (self.frequencies).turn_to(turns, parts.rest, &w.inputs, &mut w.spare_inputs);
        }
        std::mem::swap(&mut w.states, &mut w.spare);
        std::mem::swap(&mut w.inputs, &mut w.spare_inputs);
        w.spare_time = None;
        let half = w.length / 2;
        for index in 0..system.pushes.len() {
            let (drift, [x, y]) = parts.pushed(index);
            w.states[drift.lane] += x;
            w.states[half + drift.lane] += y;
        }
    }

    /// Deflections and their rates at the present time along the lines of all contacts.
    #[inline(always)]
    fn evaluate_lines<V: Vector>(&self, w: &mut Workspace) {
        let state = &w.states[..w.length];
        evaluate_line_states_body::<V>(
            self.system(w.set),
            state,
            &w.inputs,
            &w.lines,
            &mut w.line_states,
        );
    }

    /// Ends the integration of a motion whose deflections are out of range.
    #[inline(always)]
    fn check_range(&self, place: &CyclePosition, w: &Workspace) -> Result<(), End> {
        for &line in &w.lines {
            // False for NaN.
            let near = w.line_states[line].start.abs() <= self.farthest[line];
            if !near {
                return Err(End::Diverged { cycle: place.cycle });
            }
        }
        Ok(())
    }
}
