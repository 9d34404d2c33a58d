//! Windows as observers see them: Legendre series of deflections and forces on a block, or on its part up to an event.

use super::ClosedModes;
use super::basis::{Basis, padded};

use super::grid::NODES;
use super::lanes;
use super::sets::SAME_TIME;
use super::slot::{Series, Slot};
use super::system::System;
use super::workspace::{Place, Workspace};
use crate::model::{DRIVE_FLANK, MOST_CONTACTS};
use crate::numerics::exponential::legendre_series;
use crate::numerics::legendre::{self, transforms24};
use crate::propagate::observer::ShownContacts;
use crate::propagate::vectors::{Row, TERMS, interpolation};
use crate::propagate::volterra::lanes as windows;
use crate::propagate::{Observer, Window};
use num_complex::{Complex64, c64};

impl ClosedModes<'_> {
    /// The series of a system.
    pub(super) fn series_of(&self, slot: &Slot<'_>) -> Vec<Series> {
        (0..self.model.lines.len())
            .map(|line| self.series_along(&slot.basis, &slot.system, line))
            .collect()
    }

    fn series_along(&self, basis: &Basis<'_>, system: &System, line: usize) -> Series {
        let block_length = NODES as f64 * self.step;
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
            block.exponential(block_length, &mut terms);
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
        for (drift, pushes) in system.steady.drifts.iter().zip(&system.pushes) {
            let w = [sight.row[drift.lane], sight.row[padded + drift.lane]];
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
            let amplitude = c64(sight.drive[1 + 2 * h], -sight.drive[2 + 2 * h]);
            for (k, term) in terms.iter().enumerate() {
                let value = amplitude * term;
                rows[2 * padded + 1 + 2 * h].0[k] = value.re;
                rows[2 * padded + 2 + 2 * h].0[k] = -value.im;
            }
        }
        Series { rows }
    }

    /// Shows a window of some length \[s\] from where the states are.
    pub(super) fn show<O: Observer>(
        &self,
        place: &Place,
        duration: f64,
        w: &mut Workspace,
        observer: &mut O,
    ) {
        if observer.lines() {
            for (index, &line) in w.line_of.iter().enumerate() {
                if !w.line_of[..index].contains(&line) {
                    observer.line(line, &self.along(line, duration, w));
                }
            }
        }
        if observer.states() {
            self.show_state(w);
        }
        for (index, contact) in self.model.contacts.iter().enumerate() {
            let cycle = contact.cycle(place.cycle);
            w.segments[index] = *cycle.segment_at(place.time + SAME_TIME * cycle.period);
        }
        // Room for many is not made where it is not needed.
        match place.active.count() <= 1 {
            true => self.show_few::<O, 1>(place, duration, w, observer),
            false => self.show_few::<O, MOST_CONTACTS>(place, duration, w, observer),
        }
    }

    /// Writes the structure's state at the start of a window.
    fn show_state(&self, w: &mut Workspace) {
        let set = self.instructions;
        let [own, modal] = &mut w.shown;
        own.copy_from_slice(&w.states[..w.length]);
        let slot = self.slot(w.set);
        let responses = [&slot.system.steady.responses[..], &[]];
        match slot.basis.to_modes() {
            Some(map) => {
                let modes = self.model.modes();
                lanes::map(set, map, modes, responses, &w.inputs, own, modal);
            }
            None => {
                lanes::shift(set, responses[0], &w.inputs, 1.0, own);
                modal.copy_from_slice(own);
            }
        }
    }

    /// The deflection along a line on a window of some length \[s\] from where the states are.
    fn along(&self, line: usize, duration: f64, w: &Workspace) -> [f64; TERMS] {
        let set = self.instructions;
        let block_length = NODES as f64 * self.step;
        let (state, series) = (&w.states[..w.length], self.series(w.set));
        let mut out = [Row::ZERO];
        windows::free(set, &series[line].rows, &w.inputs, state, &mut out);
        if duration < block_length * (1.0 - 1e-12) {
            let end = 2.0 * duration / block_length - 1.0;
            let nodes = transforms24().nodes();
            windows::restrict_to(set, nodes, interpolation(), end, &mut out[0]);
        }
        out[0].0
    }

    /// As [`Self::show`], with at most M contacts closed.
    fn show_few<O: Observer, const M: usize>(
        &self,
        place: &Place,
        duration: f64,
        w: &Workspace,
        observer: &mut O,
    ) {
        let model = &*self.model;
        let along = |line: usize| self.along(line, duration, w);
        let mesh = along(w.line_of[DRIVE_FLANK]);
        let mut shown = ShownContacts::<TERMS, M>::new(mesh);
        for contact in place.active.iter() {
            let deflection = match w.line_of[contact] == w.line_of[DRIVE_FLANK] {
                true => mesh,
                false => along(w.line_of[contact]),
            };
            let own = &model.contacts[contact];
            let class = self.sets.class(contact, self.slot(w.set).states[contact]);
            let slope = legendre::derivative(&deflection);
            let damping = class.damping * 2.0 / duration;
            let mut force: [f64; TERMS] =
                std::array::from_fn(|k| class.stiffness * deflection[k] + damping * slope[k]);
            force[0] -= class.stiffness * own.side * own.half_gap;
            shown.push(contact, model.of_mesh(contact), deflection, force);
        }
        let [first, second] = match observer.states() {
            true => w.components(model.modes()),
            false => [&[][..]; 2],
        };
        shown.show(
            &Window {
                cycle: place.cycle,
                start: place.time,
                duration,
                segments: &w.segments,
                contact: place.active,
                first,
                second,
                ..Window::default()
            },
            observer,
        );
    }
}
