//! Windows as observers see them: Legendre series of deflections and forces on two blocks, or on their part up to an event.

use super::ClosedModes;
use super::basis::{Basis, padded};

use super::grid::NODES;
use super::lanes;
use super::sets::SAME_TIME;
use super::slot::{Series, Slot};
use super::system::System;
use super::workspace::{Open, Place, Workspace};
use crate::model::{DRIVE_FLANK, MOST_CONTACTS};
use crate::numerics::exponential::legendre_series;
use crate::numerics::legendre::{self, transforms24};
use crate::propagate::vectors::{Row, TERMS, interpolation};
use crate::propagate::volterra::lanes as windows;
use crate::propagate::{ClosedContact, Observer, Window};
use num_complex::{Complex64, c64};

/// Blocks of a window at most. From its middle to its ends the fastest wave turns by `NODES SHORT` = 3.76 then, and
/// what its series lacks is below `49 j₂₄(3.76)` = 6e-17 of it.
const MOST_BLOCKS: usize = 2;

impl ClosedModes<'_> {
    /// The series of a system.
    pub(super) fn series_of(&self, slot: &Slot<'_>) -> Vec<Series> {
        (0..self.model.lines.len())
            .map(|line| self.series_along(&slot.basis, &slot.system, line))
            .collect()
    }

    fn series_along(&self, basis: &Basis<'_>, system: &System, line: usize) -> Series {
        let length = MOST_BLOCKS as f64 * NODES as f64 * self.step;
        let n = self.model.modes();
        let padded = padded(n);
        // One more, as the workspace has them.
        let inputs = self.frequencies.inputs() + 1;
        let sight = &system.sights[line];
        let mut rows = vec![Row::ZERO; 2 * padded + inputs];
        let mut terms = [Complex64::ZERO; TERMS];
        for i in 0..n {
            let block = basis.block(i);
            let m = block.traceless();
            block.exponential(length, &mut terms);
            let w = [sight.row[i], sight.row[padded + i]];
            for (k, term) in terms.iter().enumerate() {
                let (even, odd) = (term.re, term.im);
                let turned = [0, 1].map(|j| w[0] * m[0][j] + w[1] * m[1][j]);
                rows[i].0[k] = w[0] * even + turned[0] * odd;
                rows[padded + i].0[k] = w[1] * even + turned[1] * odd;
            }
        }
        let constant = &mut rows[2 * padded].0;
        constant[0] = sight.drive[0];
        let rule = transforms24();
        for drift in &system.steady.drifts {
            let w = [sight.row[drift.lane], sight.row[padded + drift.lane]];
            let values = rule.nodes().map(|x| {
                let steps = 0.5 * (x + 1.0) * length / self.step;
                let before = (0..steps as usize).fold([0.0; 2], |before, _| drift.pushed(before, self.step));
                let [x, y] = drift.pushed(before, steps.fract() * self.step);
                w[0] * x + w[1] * y
            });
            for (sum, term) in constant.iter_mut().zip(rule.interpolate(&values)) {
                *sum += term;
            }
        }
        for (h, &[omega, _]) in self.frequencies.all.iter().enumerate() {
            legendre_series(c64(0.0, omega), length, &mut terms);
            let amplitude = c64(sight.drive[1 + 2 * h], -sight.drive[2 + 2 * h]);
            for (k, term) in terms.iter().enumerate() {
                let value = amplitude * term;
                rows[2 * padded + 1 + 2 * h].0[k] = value.re;
                rows[2 * padded + 2 + 2 * h].0[k] = -value.im;
            }
        }
        Series::new(&rows)
    }

    /// Moves the end of the open window on by some time \[s\] from where the states are, and shows it where it `ends` there or
    /// has no room for another block.
    pub(super) fn pass_window<O: Observer>(
        &self,
        place: &Place,
        duration: f64,
        ends: bool,
        w: &mut Workspace,
        observer: &mut O,
    ) {
        if w.window.length == 0.0 {
            w.window.start = place.time;
            let (state, inputs) = w.window.weights.split_at_mut(w.length);
            state.copy_from_slice(&w.states[..w.length]);
            inputs.copy_from_slice(&w.inputs);
        }
        w.window.length += duration;
        let is_full = w.window.length > (MOST_BLOCKS as f64 - 0.5) * NODES as f64 * self.step;
        if w.window.length == 0.0 || !(ends || is_full) {
            return;
        }
        if observer.states() {
            self.show_state(w);
        }
        self.find_segments(place.cycle, w);
        // Room for many is not made where it is not needed.
        match place.active.count() <= 1 {
            true => self.show_few::<O, 1>(place, w, observer),
            false => self.show_few::<O, MOST_CONTACTS>(place, w, observer),
        }
        w.window.length = 0.0;
    }

    /// The segments of all contacts at the start of a window, where those of the last one are over.
    fn find_segments(&self, cycle: u64, w: &mut Workspace) {
        let time = w.window.start + SAME_TIME * self.model.period();
        if time < w.segments_end {
            return;
        }
        w.segments_end = f64::INFINITY;
        for (segment, contact) in w.segments.iter_mut().zip(&self.model.contacts) {
            let cycle = contact.cycle(cycle);
            *segment = *cycle.segment_at(time);
            w.segments_end = w.segments_end.min(cycle.period * segment.end);
        }
    }

    /// Writes the structure's state at the start of a window.
    fn show_state(&self, w: &mut Workspace) {
        let set = self.instructions;
        let [own, modal] = &mut w.shown;
        let (state, inputs) = w.window.weights.split_at(w.length);
        own.copy_from_slice(state);
        let slot = self.slot(w.set);
        let responses = [&slot.system.steady.responses[..], &[]];
        match slot.basis.to_modes() {
            Some(map) => {
                let modes = self.model.modes();
                lanes::map(set, map, modes, responses, inputs, own, modal);
            }
            None => {
                lanes::shift(set, responses[0], inputs, 1.0, own);
                modal.copy_from_slice(own);
            }
        }
    }

    /// Shows the open window, with at most M contacts closed.
    fn show_few<O: Observer, const M: usize>(
        &self,
        place: &Place,
        w: &Workspace,
        observer: &mut O,
    ) {
        let (set, model) = (self.instructions, self.model);
        let Open {
            start,
            length: duration,
            weights,
        } = &w.window;
        let (slot, series) = (self.slot(w.set), self.series(w.set));
        let whole = MOST_BLOCKS as f64 * NODES as f64 * self.step;
        let is_part = *duration < whole * (1.0 - 1e-12);
        let end = 2.0 * duration / whole - 1.0;
        let see = |line: usize, out: &mut Row| {
            lanes::series(set, &series[line].0, weights, out);
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
            let own = &model.contacts[contact];
            let class = self.sets.class(contact, slot.states[contact]);
            let slope = legendre::derivative(deflection);
            let damping = class.damping * 2.0 / duration;
            for ((force, a), slope) in forces[i].iter_mut().zip(deflection).zip(&slope) {
                *force = class.stiffness * a + damping * slope;
            }
            forces[i][0] -= class.stiffness * own.side * own.half_gap;
        }
        let closed: [ClosedContact<'_>; M] = std::array::from_fn(|i| ClosedContact {
            contact: contacts[i],
            deflection: &others[i].as_ref().unwrap_or(&mesh).0,
            force: &forces[i],
        });
        let [first, second] = match observer.states() {
            true => w.components(model.modes()),
            false => [&[][..]; 2],
        };
        let window = Window {
            cycle: place.cycle,
            start: *start,
            duration: *duration,
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
