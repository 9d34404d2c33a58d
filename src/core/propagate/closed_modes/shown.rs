//! Windows as observers see them: Legendre series of deflections and forces on a block, or on its part up to an event.

use super::ClosedModes;
use super::basis::{Basis, padded};

use super::grid::NODES;
use super::lanes;
use super::series::Series;
use super::sets::{MOST_CONTACTS, SAME_TIME};
use super::slot::Slot;
use super::system::System;
use super::workspace::{CyclePosition, Workspace};
use crate::model::{DRIVE_FLANK, SEVERAL_CONTACTS};
use crate::numerics::exponential::legendre_series;
use crate::numerics::legendre::{self, transforms24};
use crate::propagate::vectors::{Row, TERMS, interpolation};
use crate::propagate::volterra::lanes as windows;
use crate::propagate::{ClosedContact, Observer, Window};
use num_complex::{Complex64, c64};

impl ClosedModes<'_> {
    /// The series of the deflections of a system, one entry per line.
    pub(super) fn series_of(&self, slot: &Slot<'_>) -> Vec<Series> {
        (0..self.model.lines.len())
            .map(|line| self.series_along(&slot.basis, &slot.system, line))
            .collect()
    }

    fn series_along(&self, basis: &Basis<'_>, system: &System, line: usize) -> Series {
        let block_length = NODES as f64 * self.step;
        let n = self.model.modes();
        let padded = padded(n);
        // One more than there are inputs, because the workspace has a zero after them.
        let inputs = self.frequencies.inputs() + 1;
        let view = &system.views[line];
        let mut rows = vec![Row::ZERO; 2 * padded + inputs];
        let mut terms = [Complex64::ZERO; TERMS];
        for i in 0..n {
            let block = basis.block(i);
            let m = block.traceless();
            block.exponential(block_length, &mut terms);
            let w = [view.rows[0][i], view.rows[0][padded + i]];
            for (k, term) in terms.iter().enumerate() {
                let (even, odd) = (term.re, term.im);
                let traceless_row = [0, 1].map(|j| w[0] * m[0][j] + w[1] * m[1][j]);
                rows[i].0[k] = w[0] * even + traceless_row[0] * odd;
                rows[padded + i].0[k] = w[1] * even + traceless_row[1] * odd;
            }
        }
        let constant = &mut rows[2 * padded].0;
        constant[0] = view.drives[0][0];
        let rule = transforms24();
        for (drift, pushes) in system.steady.drifts.iter().zip(&system.pushes) {
            let w = [view.rows[0][drift.lane], view.rows[0][padded + drift.lane]];
            let values = rule.nodes().map(|x| {
                let time = 0.5 * (x + 1.0) * block_length;
                let node = (time / self.step).floor() as usize;
                let before = node.checked_sub(1).map_or([0.0; 2], |node| pushes[node]);
                let [x, y] = drift.pushed(before, time - node as f64 * self.step);
                w[0] * x + w[1] * y
            });
            for (sum, term) in constant.iter_mut().zip(rule.interpolate(&values)) {
                *sum += term;
            }
        }
        for (h, &[omega, _]) in self.frequencies.all.iter().enumerate() {
            legendre_series(c64(0.0, omega), block_length, &mut terms);
            let amplitude = c64(view.drives[0][1 + 2 * h], -view.drives[0][2 + 2 * h]);
            for (k, term) in terms.iter().enumerate() {
                let value = amplitude * term;
                rows[2 * padded + 1 + 2 * h].0[k] = value.re;
                rows[2 * padded + 2 + 2 * h].0[k] = -value.im;
            }
        }
        Series::new(&rows)
    }

    /// Passes a window to the observer. It starts at the present states and is `duration` \[s\] long.
    pub(super) fn show<O: Observer>(
        &self,
        place: &CyclePosition,
        duration: f64,
        w: &mut Workspace,
        observer: &mut O,
    ) {
        if observer.states() {
            self.show_state(w);
        }
        self.find_segments(place, w);
        let (state, inputs) = w.weights.split_at_mut(w.length);
        state.copy_from_slice(&w.states[..w.length]);
        inputs.copy_from_slice(&w.inputs);
        // Avoids memory for many contacts if it is not needed.
        match place.active.count() {
            0 | 1 => self.show_few::<O, 1>(place, duration, w, observer),
            2..=SEVERAL_CONTACTS => {
                self.show_few::<O, SEVERAL_CONTACTS>(place, duration, w, observer);
            }
            _ => self.show_few::<O, MOST_CONTACTS>(place, duration, w, observer),
        }
    }

    /// The segments of all contacts at the start of a window, updated if those of the last window have ended.
    fn find_segments(&self, place: &CyclePosition, w: &mut Workspace) {
        let time = place.time + SAME_TIME * self.model.period();
        if time < w.segments_end {
            return;
        }
        w.segments_end = f64::INFINITY;
        for (segment, contact) in w.segments.iter_mut().zip(&self.model.contacts) {
            let cycle = contact.cycle(place.cycle);
            *segment = *cycle.segment_at(time);
            w.segments_end = w.segments_end.min(cycle.period * segment.end);
        }
    }

    /// Computes the modal state at the start of a window.
    fn show_state(&self, w: &mut Workspace) {
        let set = self.instructions;
        let [blocks, modal] = &mut w.shown;
        blocks.copy_from_slice(&w.states[..w.length]);
        let slot = self.slot(w.set);
        let responses = [&slot.system.steady.responses[..], &[]];
        match slot.basis.to_modes() {
            Some(map) => {
                lanes::map(set, map, &self.mixed, responses, &w.inputs, blocks, modal);
            }
            None => {
                lanes::add_responses(set, responses[0], &w.inputs, 1.0, blocks);
                modal.copy_from_slice(blocks);
            }
        }
    }

    /// As [`Self::show`], with at most M contacts closed.
    fn show_few<O: Observer, const M: usize>(
        &self,
        place: &CyclePosition,
        duration: f64,
        w: &Workspace,
        observer: &mut O,
    ) {
        let (set, model) = (self.instructions, self.model);
        let (slot, series) = (self.slot(w.set), self.series(w.set));
        let whole = NODES as f64 * self.step;
        let is_part = duration < whole * (1.0 - 1e-12);
        let end = 2.0 * duration / whole - 1.0;
        let see = |line: usize, out: &mut Row| {
            lanes::series(set, &series[line].0, &w.weights, out);
            if is_part {
                let nodes = transforms24().nodes();
                windows::restrict_to(set, nodes, interpolation(), end, out);
            }
        };
        let mut mesh = Row::ZERO;
        see(w.line_of[DRIVE_FLANK], &mut mesh);
        let (mut contacts, mut forces) = ([0; M], [[0.0; TERMS]; M]);
        let mut others = [None; M];
        for (i, contact) in place.active.iter().enumerate() {
            contacts[i] = contact;
            if w.line_of[contact] != w.line_of[DRIVE_FLANK] {
                see(w.line_of[contact], others[i].insert(Row::ZERO));
            }
            let deflection = &others[i].as_ref().unwrap_or(&mesh).0;
            let contact_data = &model.contacts[contact];
            let class = self.sets.class(contact, slot.states[contact]);
            let slope = legendre::derivative(deflection);
            let damping = class.damping * 2.0 / duration;
            for ((force, a), slope) in forces[i].iter_mut().zip(deflection).zip(&slope) {
                *force = class.stiffness * a + damping * slope;
            }
            forces[i][0] -= class.stiffness * contact_data.side * contact_data.half_gap;
        }
        let closed: [ClosedContact<'_>; M] = std::array::from_fn(|i| ClosedContact {
            contact: contacts[i],
            deflection: &others[i].as_ref().unwrap_or(&mesh).0,
            force: &forces[i],
        });
        let [first, second] =
            if observer.states() { w.components(model.modes()) } else { [&[][..]; 2] };
        let window = Window {
            cycle: place.cycle,
            start: place.time,
            duration,
            segments: &w.segments,
            contact: place.active,
            deflection: &mesh.0,
            closed: &closed[..place.active.count()],
            first,
            second,
            ..Window::default()
        };
        window.show::<TERMS, O>(model.flank_springs, observer);
    }
}
