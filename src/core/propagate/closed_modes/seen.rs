//! What happens first on a block?

use super::ClosedModes;
use super::excitation::Drift;
use super::grid::NODES;
use super::lanes::{self, Move};
use super::search::{self, Interval, Known};
use super::sets::MOST_CONTACTS;
use super::system::{LineView, System};
use super::workspace::{Place, Seen, Workspace};
use crate::model::ActiveSet;
use crate::propagate::Counters;
use crate::propagate::events::{Margin, ROUND_OFF};
use crate::propagate::vectors::{InstructionSet, Lanes};

/// What comes first on a block.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    /// Time from its start \[s\].
    pub time: f64,
    /// The contact.
    pub contact: usize,
    /// Whether the contact stands on its surface there.
    pub on_surface: bool,
}

/// Rates of contacts that have just crossed their surfaces, positive away from it \[m/s\].
pub(super) type Rates = [f64; MOST_CONTACTS];

impl ClosedModes<'_> {
    /// What happens first on a block, up to some time \[s\] from its start.
    pub(super) fn first_event(
        &self,
        place: &Place,
        rates: &Rates,
        left: f64,
        w: &mut Workspace,
        counters: &mut Counters,
    ) -> Option<Found> {
        let set = self.instructions;
        let system = self.system(w.set);
        w.tried = None;
        for seen in &mut w.seen {
            seen.fresh = false;
        }
        let state = &w.states[..w.length];
        lanes::amplitudes(set, &system.balances, state, &mut w.amplitudes);
        let count = ((left / self.step - 1e-9).ceil() as usize).clamp(1, NODES);
        let mut open_intervals = [0u32; MOST_CONTACTS];
        let mut any = 0;
        for contact in 0..w.line_of.len() {
            let line = w.line_of[contact];
            if !w.seen[line].fresh {
                self.see(line, system, w);
            }
            if self.is_behind(contact, place.active, w) {
                continue;
            }
            let seen = &w.seen[line];
            let closed = place.active.holds(contact);
            let margin = Margin::new(&self.model.contacts[contact], contact, closed);
            let start = margin.scale * seen.start + margin.shift;
            let crossed = place.crossed.holds(contact);
            if !crossed && start < -seen.known.noise {
                return Some(Found {
                    time: 0.0,
                    contact,
                    on_surface: false,
                });
            }
            let sag = 0.125 * seen.known.curvature * self.step * self.step;
            let mut open = lanes::open(
                set,
                seen.start,
                &seen.nodes,
                [margin.scale, margin.shift],
                sag,
                seen.known.noise,
            );
            if crossed {
                let end = margin.scale * seen.nodes.0[0] + margin.shift;
                open &= !1;
                open |= u32::from(!search::rises(seen.known, rates[contact], end, self.step));
            }
            open &= (1 << count) - 1;
            open_intervals[contact] = open;
            any |= open;
        }
        if any == 0 {
            counters.certified += 1;
            return None;
        }
        for n in (0..count).filter(|n| any >> n & 1 == 1) {
            let mut first: Option<Found> = None;
            for contact in 0..w.line_of.len() {
                if open_intervals[contact] >> n & 1 == 1
                    && let Some(time) = self.exit(contact, n, place, rates, w, counters)
                    && time <= left
                    && first.is_none_or(|first| time < first.time)
                {
                    first = Some(Found {
                        time,
                        contact,
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

    /// Deflections of a line at the nodes, and their bounds.
    fn see(&self, line: usize, system: &System, w: &mut Workspace) {
        let set = self.instructions;
        let length = w.length;
        let view = &system.views[line];
        let state = &w.states[..length];
        let mut nodes = Lanes::ZERO;
        let [size, curved] = lanes::see(
            set,
            &view.nodes,
            [&view.size, &view.curvature],
            state,
            &w.inputs,
            &w.amplitudes,
            &mut nodes,
        );
        let others: f64 = (view.others.iter())
            .map(|(strayed, drift)| {
                let rates = drift.rates([state[drift.lane], state[length / 2 + drift.lane]]);
                strayed[0] * rates[0].abs() + strayed[1] * rates[1].abs()
            })
            .sum();
        let seen = &mut w.seen[line];
        seen.nodes = nodes;
        seen.fresh = true;
        seen.known = Known {
            curvature: curved + others + view.drive_curvature,
            noise: ROUND_OFF * (size + self.model.half_gap),
        };
    }

    /// Whether an open contact is out of reach while one on the other side of its line is closed.
    fn is_behind(&self, contact: usize, active: ActiveSet, w: &Workspace) -> bool {
        let contacts = &self.model.contacts;
        let opposite = |other: usize| {
            w.line_of[other] == w.line_of[contact]
                && contacts[other].side == -contacts[contact].side
        };
        !active.holds(contact) && active.iter().any(opposite)
    }

    /// The first exit of a contact on an interval between nodes.
    fn exit(
        &self,
        contact: usize,
        interval: usize,
        place: &Place,
        rates: &Rates,
        w: &mut Workspace,
        counters: &mut Counters,
    ) -> Option<f64> {
        let line = w.line_of[contact];
        let seen = w.seen[line];
        let closed = place.active.holds(contact);
        let margin = Margin::new(&self.model.contacts[contact], contact, closed);
        let value = |deflection: f64| margin.scale * deflection + margin.shift;
        let crossed = interval == 0 && place.crossed.holds(contact);
        let start = match (interval, crossed) {
            (0, true) => 0.0,
            (0, false) => value(seen.start),
            _ => value(seen.nodes.0[interval - 1]),
        };
        let own = Interval {
            times: [interval, interval + 1].map(|n| n as f64 * self.step),
            margins: [start, value(seen.nodes.0[interval])],
            guess: Some(self.guess(&seen, interval, &margin)),
        };
        let mut at = At {
            kernel: self,
            w,
            place,
            line,
            margin,
        };
        if crossed {
            search::exit_behind(&mut at, seen.known, rates[contact], own, 0, counters)
        } else {
            search::exit(&mut at, seen.known, own, 0, counters)
        }
    }

    /// Where a margin may pass zero on an interval, by the values at six places.
    fn guess(&self, seen: &Seen, interval: usize, margin: &Margin) -> f64 {
        let first = interval.saturating_sub(2).min(NODES - 5);
        let values = std::array::from_fn(|k| {
            let deflection = match (first + k).checked_sub(1) {
                None => seen.start,
                Some(node) => seen.nodes.0[node],
            };
            margin.scale * deflection + margin.shift
        });
        (first as f64 + search::near_root(values, interval - first)) * self.step
    }
}

/// Deflection and rate along a line, of a state under inputs.
#[inline]
pub(super) fn now(set: InstructionSet, view: &LineView, state: &[f64], inputs: &[f64]) -> [f64; 2] {
    let [deflection, rate] = lanes::two_products(set, state, &view.row, &view.rate);
    let [driven, driven_rate] = driven(view, inputs);
    [deflection + driven, rate + driven_rate]
}

/// What inputs add to deflection and rate.
#[inline]
fn driven(view: &LineView, inputs: &[f64]) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for ((input, drive), drive_rate) in inputs.iter().zip(&view.drive).zip(&view.drive_rate) {
        sums[0] += input * drive;
        sums[1] += input * drive_rate;
    }
    sums
}

/// A time within a block in two parts: those of the nearest node, and a short rest.
#[derive(Clone, Copy)]
pub(super) struct Parts<'s> {
    system: &'s System,
    /// How many nodes.
    node: usize,
    /// Time behind that \[s\].
    pub rest: f64,
}

impl<'s> Parts<'s> {
    #[inline]
    pub fn new(system: &'s System, step: f64, time: f64) -> Self {
        let node = ((time / step + 0.5) as usize).min(NODES);
        Self {
            system,
            node,
            rest: time - node as f64 * step,
        }
    }

    /// What moves a state to the node.
    #[inline]
    pub fn before(&self) -> Option<&'s [Move]> {
        (self.node.checked_sub(1)).map(|node| &self.system.moves[node][..])
    }

    /// What constant inputs add to each drifting block.
    #[inline]
    pub fn pushed(&self) -> impl Iterator<Item = (&'s Drift, [f64; 2])> {
        let Self { system, node, rest } = *self;
        (system.steady.drifts.iter().zip(&system.pushes)).map(move |(drift, pushes)| {
            let before = node.checked_sub(1).map_or([0.0; 2], |node| pushes[node]);
            (drift, drift.pushed(before, rest))
        })
    }
}

/// A margin at times of a block.
struct At<'a, 'm> {
    kernel: &'a ClosedModes<'m>,
    w: &'a mut Workspace,
    place: &'a Place,
    line: usize,
    margin: Margin,
}

impl search::Margin for At<'_, '_> {
    fn at(&mut self, time: f64) -> [f64; 2] {
        let (kernel, w) = (self.kernel, &mut *self.w);
        let set = kernel.instructions;
        let system = kernel.system(w.set);
        let view = &system.views[self.line];
        let seen = match kernel.beside_tried(time, w) {
            None => {
                kernel.try_at(time, self.place, w);
                now(set, view, &w.spare[..w.length], &w.trial)
            }
            Some(rest) => {
                let (state, half) = (&w.spare[..w.length], w.length / 2);
                let rows = [&view.row[..], &view.rate];
                let mut seen = lanes::products_near(set, &system.chunks, rest, state, rows);
                for drift in &system.steady.drifts {
                    let [x, y] = drift.push(rest);
                    for (seen, row) in seen.iter_mut().zip(rows) {
                        *seen += row[drift.lane] * x + row[half + drift.lane] * y;
                    }
                }
                let driven = (kernel.frequencies).driven_beside(
                    rest,
                    [&view.drive, &view.drive_rate],
                    &w.trial,
                );
                [seen[0] + driven[0], seen[1] + driven[1]]
            }
        };
        let Margin { scale, shift, .. } = self.margin;
        [scale * seen[0] + shift, scale * seen[1]]
    }
}
