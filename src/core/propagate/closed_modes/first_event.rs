//! Which event happens first on a block?

use super::ClosedModes;
use super::block_check::{BEYOND, BlockCheck, Rates, check_block_body};
use super::excitation::Drift;
use super::grid::NODES;
use super::lanes::{BlockPropagator, advance_to_body};
use super::search::{self, Interval, POINTS};
use super::system::System;
use super::workspace::{CyclePosition, WatchedContact, Workspace};
use crate::propagate::Counters;
use crate::propagate::vectors::{InstructionSet, Vector, for_each_set};
use std::marker::PhantomData;

/// The first event on a block.
#[derive(Debug, Clone, Copy)]
pub(super) struct BlockEvent {
    /// Time from its start \[s\].
    pub time: f64,
    /// The contact.
    pub contact: usize,
    /// Whether the contact is on its surface at that time.
    pub on_surface: bool,
}

impl ClosedModes<'_> {
    /// The first event on a block, up to some time \[s\] from its start.
    #[inline(always)]
    pub(super) fn first_event<V: Vector>(
        &self,
        place: &CyclePosition,
        rates: &Rates,
        left: f64,
        w: &mut Workspace,
        counters: &mut Counters,
    ) -> Option<BlockEvent> {
        let system = self.system(w.set);
        let count = ((left * self.per_step + (1.0 - 1e-9)) as usize).clamp(1, NODES);
        let mut check = BlockCheck {
            system,
            state: &w.states[..w.length],
            inputs: &w.inputs,
            lines: &w.lines,
            line_states: &mut w.line_states,
            watched: &mut w.watched,
            crossed: place.crossed,
            rates,
            amplitudes: &mut w.amplitudes,
            bounded: w.bounded,
            step: self.step,
            fastest: self.fastest(),
            count,
            half_gap: self.model.half_gap,
        };
        let open = check_block_body::<V>(&mut check);
        w.bounded = system.decays;
        w.spare_time = None;
        if open == 0 {
            counters.certified += 1;
            return None;
        }
        self.search::<V>(place, rates, left, (open, count), w, counters)
    }

    /// The first event in the intervals between nodes that the check has left open.
    #[inline(always)]
    fn search<V: Vector>(
        &self,
        place: &CyclePosition,
        rates: &Rates,
        left: f64,
        (open, count): (u32, usize),
        w: &mut Workspace,
        counters: &mut Counters,
    ) -> Option<BlockEvent> {
        if open & BEYOND != 0 {
            let beyond = w.watched.iter().find(|watched| watched.open & BEYOND != 0);
            return beyond.map(|watched| BlockEvent {
                time: 0.0,
                contact: watched.contact,
                on_surface: false,
            });
        }
        for n in (0..count).filter(|n| open >> n & 1 == 1) {
            let mut first: Option<BlockEvent> = None;
            for index in 0..w.watched.len() {
                let watched = w.watched[index];
                if watched.open >> n & 1 == 1
                    && let Some(time) = self.exit::<V>(&watched, n, place, rates, w, counters)
                    && time <= left
                    && first.is_none_or(|first| time < first.time)
                {
                    first = Some(BlockEvent {
                        time,
                        contact: watched.contact,
                        on_surface: true,
                    });
                }
            }
            if first.is_some() {
                return first;
            }
        }
        None
    }

    /// The first time at which a contact's margin becomes negative in an interval between nodes.
    #[inline(always)]
    fn exit<V: Vector>(
        &self,
        watched: &WatchedContact,
        interval: usize,
        place: &CyclePosition,
        rates: &Rates,
        w: &mut Workspace,
        counters: &mut Counters,
    ) -> Option<f64> {
        let line_state = w.line_states[watched.line];
        let crossed = interval == 0 && place.crossed.holds(watched.contact);
        let mut values = [watched.value(line_state.start); POINTS];
        for node in 0..NODES {
            values[node + 1] = watched.value(line_state.nodes.0[node]);
        }
        let end = values[interval + 1];
        let near_root = if end < 0.0 { search::near_root::<V>(&values, interval) } else { None };
        let interval = Interval {
            times: [
                interval as f64 * self.step,
                (interval + 1) as f64 * self.step,
            ],
            margins: [if crossed { 0.0 } else { values[interval] }, end],
            guess: near_root.map(|root| root * self.step),
        };
        let margin = ContactMargin {
            kernel: self,
            system: self.system(w.set),
            w,
            watched,
        };
        let mut at = Inlined(margin, PhantomData::<V>);
        if crossed {
            let rate = rates[watched.contact];
            search::exit_behind(&mut at, line_state.bounds, rate, interval, 0, counters)
        } else {
            search::exit(&mut at, line_state.bounds, interval, 0, counters)
        }
    }
}

/// A time within a block in two parts: the time of the nearest node, and a short rest.
#[derive(Clone, Copy)]
pub(super) struct SplitTime<'s> {
    system: &'s System,
    /// Number of the node; 0 is the start of the block.
    node: usize,
    /// Time after the node, or negative before it \[s\].
    pub rest: f64,
}

impl<'s> SplitTime<'s> {
    #[inline(always)]
    pub fn new(kernel: &ClosedModes<'_>, system: &'s System, time: f64) -> Self {
        let node = ((time * kernel.per_step + 0.5) as usize).min(NODES);
        Self {
            system,
            node,
            rest: time - node as f64 * kernel.step,
        }
    }

    /// The map of a state to the node; `None` at the start of the block.
    #[inline(always)]
    pub fn map_to_node(&self) -> Option<&'s [BlockPropagator]> {
        if self.node == 0 { None } else { Some(self.system.moves_to(self.node)) }
    }

    /// A drifting block, and its displacement and rate due to the constant inputs.
    #[inline(always)]
    pub fn pushed(&self, index: usize) -> (&'s Drift, [f64; 2]) {
        let Self { system, node, rest } = *self;
        let (drift, pushes) = (&system.steady.drifts[index], &system.pushes[index]);
        let pushed_to_node = if node == 0 { [0.0; 2] } else { pushes[node - 1] };
        (drift, drift.pushed(pushed_to_node, rest))
    }

    /// The turns of the inputs up to the node; `None` at the start of the block.
    #[inline(always)]
    pub fn turns<'k>(&self, kernel: &'k ClosedModes<'_>) -> Option<&'k [[f64; 2]]> {
        if self.node == 0 { None } else { Some(&kernel.turns[self.node - 1]) }
    }
}

/// The margin of a contact at times within a block.
pub(super) struct ContactMargin<'a, 'm> {
    kernel: &'a ClosedModes<'m>,
    system: &'a System,
    w: &'a mut Workspace,
    watched: &'a WatchedContact,
}

/// The margin, inlined into functions that are compiled for the instruction set of V.
struct Inlined<'a, 'm, V>(ContactMargin<'a, 'm>, PhantomData<V>);

impl<V: Vector> search::Margin for Inlined<'_, '_, V> {
    #[inline(always)]
    fn at(&mut self, time: f64) -> [f64; 3] {
        margin_body::<V>(&mut self.0, time)
    }

    fn with_run_time_dispatch(&mut self) -> &mut dyn search::Margin {
        &mut self.0
    }
}

impl search::Margin for ContactMargin<'_, '_> {
    fn at(&mut self, time: f64) -> [f64; 3] {
        margin(self.kernel.instructions, self, time)
    }

    fn with_run_time_dispatch(&mut self) -> &mut dyn search::Margin {
        self
    }
}

for_each_set! {
    /// A margin with its rate and second derivative at a time.
    fn margin(of: &mut ContactMargin<'_, '_>, time: f64) -> [f64; 3] = margin_body
}

#[inline(always)]
fn margin_body<V: Vector>(of: &mut ContactMargin<'_, '_>, time: f64) -> [f64; 3] {
    let (kernel, system, watched) = (of.kernel, of.system, of.watched);
    let w = &mut *of.w;
    let view = &system.views[watched.line];
    let parts = SplitTime::new(kernel, system, time);
    let mut values = advance_to_body::<V>(
        &system.chunks,
        parts.map_to_node(),
        parts.rest,
        &view.rows,
        &w.states,
        &mut w.spare,
    );
    w.spare_time = Some(time);
    for index in 0..system.pushes.len() {
        let (drift, [x, y]) = parts.pushed(index);
        for order in 0..3 {
            let row = &view.rows[order];
            values[order] += row[drift.lane] * x + row[w.length / 2 + drift.lane] * y;
        }
    }
    let (turns, frequencies) = (parts.turns(kernel), &kernel.frequencies);
    frequencies.turn_to(turns, parts.rest, &w.inputs, &mut w.spare_inputs);
    let driven = view.driven(&w.spare_inputs);
    [
        watched.value(values[0] + driven[0]),
        watched.scale * (values[1] + driven[1]),
        watched.scale * (values[2] + driven[2]),
    ]
}
