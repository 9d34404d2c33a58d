//! Which event happens first on a block?

use super::ClosedModes;
use super::block_check::{BEYOND, BlockCheck, Rates, check_block_body};
use super::excitation::Drift;
use super::grid::NODES;
use super::lanes::{BlockPropagator, advance_to};
use super::search::{self, Interval, POINTS};
use super::system::System;
use super::workspace::{CyclePosition, WatchedContact, Workspace};
use crate::propagate::Counters;
use crate::propagate::vectors::Vector;

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
        self.search(place, rates, left, (open, count), w, counters)
    }

    /// The first event in the open intervals between nodes.
    fn search(
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
                    && let Some(time) = self.exit(&watched, n, place, rates, w, counters)
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

    /// The first exit of a contact on an interval between nodes.
    fn exit(
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
        let values: [f64; POINTS] = std::array::from_fn(|k| {
            let before = k.checked_sub(1).map(|node| line_state.nodes.0[node]);
            watched.value(before.unwrap_or(line_state.start))
        });
        let [start, end] = [values[interval], values[interval + 1]];
        let start = if crossed { 0.0 } else { start };
        let interval = Interval {
            times: [interval, interval + 1].map(|n| n as f64 * self.step),
            margins: [start, end],
            guess: (end < 0.0)
                .then(|| search::near_root(self.instructions, &values, interval) * self.step),
        };
        let mut at = ContactMargin {
            kernel: self,
            system: self.system(w.set),
            w,
            watched,
        };
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
    /// Time after the node \[s\].
    pub rest: f64,
}

impl<'s> SplitTime<'s> {
    #[inline]
    pub fn new(kernel: &ClosedModes<'_>, system: &'s System, time: f64) -> Self {
        let node = ((time * kernel.per_step + 0.5) as usize).min(NODES);
        Self {
            system,
            node,
            rest: time - node as f64 * kernel.step,
        }
    }

    /// The map of a state to the node; `None` at the start of the block.
    #[inline]
    pub fn before(&self) -> Option<&'s [BlockPropagator]> {
        (self.node.checked_sub(1)).map(|node| &self.system.moves[node][..])
    }

    /// Contribution of the constant inputs to each drifting block.
    #[inline]
    pub fn pushed(&self) -> impl Iterator<Item = (&'s Drift, [f64; 2])> {
        let Self { system, node, rest } = *self;
        (system.steady.drifts.iter().zip(&system.pushes)).map(move |(drift, pushes)| {
            let before = node.checked_sub(1).map_or([0.0; 2], |node| pushes[node]);
            (drift, drift.pushed(before, rest))
        })
    }

    /// The turns of the inputs up to the node; `None` at the start of the block.
    #[inline]
    pub fn turns<'k>(&self, kernel: &'k ClosedModes<'_>) -> Option<&'k [[f64; 2]]> {
        (self.node.checked_sub(1)).map(|node| &kernel.turns[node][..])
    }
}

/// The margin of a contact at times within a block.
struct ContactMargin<'a, 'm> {
    kernel: &'a ClosedModes<'m>,
    system: &'a System,
    w: &'a mut Workspace,
    watched: &'a WatchedContact,
}

impl search::Margin for ContactMargin<'_, '_> {
    fn at(&mut self, time: f64) -> [f64; 3] {
        let (kernel, system, watched) = (self.kernel, self.system, self.watched);
        let w = &mut *self.w;
        let view = &system.views[watched.line];
        let parts = SplitTime::new(kernel, system, time);
        let mut values = advance_to(
            kernel.instructions,
            &system.chunks,
            parts.before(),
            parts.rest,
            &view.rows,
            &w.states,
            &mut w.spare,
        );
        w.spare_time = Some(time);
        for (drift, [x, y]) in parts.pushed() {
            for (value, row) in values.iter_mut().zip(&view.rows) {
                *value += row[drift.lane] * x + row[w.length / 2 + drift.lane] * y;
            }
        }
        let turns = parts.turns(kernel);
        let driven = (kernel.frequencies).driven(turns, parts.rest, &view.drives, &w.inputs);
        [
            watched.value(values[0] + driven[0]),
            watched.scale * (values[1] + driven[1]),
            watched.scale * (values[2] + driven[2]),
        ]
    }
}
