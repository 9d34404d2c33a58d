//! One mesh cycle: windows, events, breakpoints.
//!
//! A window starts on a cell boundary (`aligned`) or at an event. In contact it may not
//! pass the end of its segment, in free flight only the end of the cycle. Off the cell
//! grid, windows of full length follow one another until one would pass such a
//! breakpoint; that one is cut there, and the march is aligned again.

use super::partial::Cut;
use super::tables::Series;
use super::window::{Phases, Solution};
use super::{TERMS, Volterra};
use crate::model::{Contact, Surface, TrajectoryState};
use crate::numerics::legendre::{self, transforms16};
use crate::propagate::events::first_crossing;
use crate::propagate::{Counters, Event, Kernel, Observer, Stop, Tangents, Window, saltation};

/// Deflections beyond this many half gaps count as divergence.
const FARTHEST: f64 = 1e9;

/// Scratch memory of the structured kernel.
#[derive(Debug)]
pub struct Workspace {
    state: Vec<f64>,
    next: Vec<f64>,
    /// Room for tangents; what one march made room for, later ones use.
    tangents: Vec<Vec<f64>>,
    /// Tangents in this march, the first of `tangents`.
    tangent_count: usize,
    phases: Phases,
    cut: Cut,
}

/// Where a window starts.
#[derive(Debug, Clone, Copy)]
struct Clock {
    /// Mesh cycle.
    cycle: u64,
    /// Time within it \[s\].
    time: f64,
    /// The cell that starts here, when on the cell grid.
    aligned: Option<usize>,
    /// Surface just crossed, when an event happened here.
    crossed: Option<Surface>,
}

impl Kernel for Volterra<'_> {
    type Workspace = Workspace;

    fn workspace(&self) -> Workspace {
        let t = &self.tables;
        Workspace {
            state: vec![0.0; 2 * t.padded],
            next: vec![0.0; 2 * t.padded],
            tangents: Vec::new(),
            tangent_count: 0,
            phases: Phases {
                transmission_error: vec![(1.0, 0.0); t.transmission_error.len()],
                ripple: vec![(1.0, 0.0); t.ripple.len()],
            },
            cut: Cut::new(t.blocks.len()),
        }
    }

    fn march<O: Observer>(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        workspace: &mut Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        self.load(trajectory, tangents, workspace);
        let cells = self.tables.cells;
        let mut clock = Clock {
            cycle: trajectory.cycle,
            time: 0.0,
            aligned: Some(0),
            crossed: None,
        };
        let mut contact = trajectory.contact;
        let mut events = 0;
        while clock.aligned != Some(cells) {
            let before = contact;
            self.step(&mut clock, &mut contact, workspace, observer, counters)?;
            if contact != before {
                events += 1;
                if events > self.event_limit {
                    return Err(Stop::EventStorm {
                        cycle: clock.cycle,
                        limit: self.event_limit,
                    });
                }
            }
        }
        trajectory.contact = contact;
        trajectory.cycle += 1;
        counters.cycles += 1;
        self.store(trajectory, tangents, workspace);
        Ok(())
    }
}

impl Volterra<'_> {
    /// Solves one window and moves to its end, to the next event or to a breakpoint.
    fn step<O: Observer>(
        &self,
        clock: &mut Clock,
        contact: &mut Contact,
        workspace: &mut Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        let t = &self.tables;
        let segment = self.segment(clock);
        let stop_cell = if contact.touching() {
            t.segment_end_cell[segment]
        } else {
            t.cells
        };
        let stop = t.cell_time[stop_cell];
        if clock.aligned.is_none() && clock.time >= stop {
            clock.time = stop;
            clock.aligned = Some(stop_cell);
            return Ok(());
        }
        let fits = clock.aligned.is_some() || clock.time + t.delta <= stop;
        let limit = if fits {
            1.0
        } else {
            2.0 * (stop - clock.time) / t.delta - 1.0
        };

        self.set_phases(clock.cycle, clock.time, &mut workspace.phases);
        let feedback = contact.touching().then(|| &t.feedback[segment]);
        let solution = self.solve(
            &workspace.state,
            &workspace.phases,
            feedback.map(|f| (f, contact.sign())),
        );
        counters.windows += 1;
        let size: f64 = solution.deflection.iter().map(|a| a.abs()).sum();
        if size.is_nan() || size > FARTHEST * self.model.half_gap {
            return Err(Stop::Diverged { cycle: clock.cycle });
        }
        let crossing = first_crossing(
            transforms16(),
            &solution.deflection,
            *contact,
            self.model.half_gap,
            clock.crossed.take(),
            limit,
            solution.noise,
            counters,
        );
        match crossing {
            Some(c) => {
                if c.x > -1.0 {
                    self.move_to_cut(
                        c.x, clock, *contact, &solution, workspace, observer, counters,
                    );
                    clock.aligned = None;
                }
                let slope = legendre::derivative(&solution.deflection);
                let to = contact.across(c.surface);
                observer.event(&Event {
                    cycle: clock.cycle,
                    time: clock.time,
                    from: *contact,
                    to,
                    surface: c.surface,
                    rate: 2.0 / t.delta * legendre::evaluate(&slope, c.x),
                });
                counters.events += 1;
                // A start beyond the surface (a trajectory given in the wrong contact state)
                // is no root that may be divided out.
                let side = c.surface.sign() * self.model.half_gap;
                let beyond = legendre::at_start(&solution.deflection) - side;
                let on_surface = c.x > -1.0 || beyond.abs() <= solution.noise;
                self.salt(self.segment(clock), to.touching(), workspace);
                *contact = to;
                clock.crossed = on_surface.then_some(c.surface);
            }
            None if fits => {
                self.move_full(clock, *contact, &solution, workspace, observer, counters)
            }
            None => {
                self.move_to_cut(
                    limit, clock, *contact, &solution, workspace, observer, counters,
                );
                clock.time = stop;
                clock.aligned = Some(stop_cell);
            }
        }
        Ok(())
    }

    /// Mesh segment in force at the clock.
    fn segment(&self, clock: &Clock) -> usize {
        match clock.aligned {
            Some(cell) => self.tables.segment_of_cell[cell],
            None => {
                let ends = &self.tables.segment_end_cell;
                let inside = |end: &usize| clock.time < self.tables.cell_time[*end];
                ends.iter().position(inside).unwrap_or(ends.len() - 1)
            }
        }
    }

    /// Moves trajectory and tangents over a full window.
    fn move_full<O: Observer>(
        &self,
        clock: &mut Clock,
        contact: Contact,
        solution: &Solution,
        workspace: &mut Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) {
        let t = &self.tables;
        if O::WINDOWS {
            let (d, f) = (solution.deflection, solution.force);
            self.show(clock, contact, t.delta, &d, &f, workspace, observer);
        }
        let segment = self.segment(clock);
        let feedback = contact.touching().then(|| &t.feedback[segment]);
        let set = self.instructions;
        for x in &mut workspace.tangents[..workspace.tangent_count] {
            let force = feedback.map(|f| self.solve_tangent(x, f));
            super::lanes::advance(set, &t.windows, force.as_ref(), x, &mut workspace.next);
            std::mem::swap(x, &mut workspace.next);
            counters.tangent_windows += 1;
        }
        let force = contact.touching().then_some(&solution.force);
        super::lanes::advance(
            set,
            &t.windows,
            force,
            &workspace.state,
            &mut workspace.next,
        );
        std::mem::swap(&mut workspace.state, &mut workspace.next);
        self.add_inputs(&workspace.phases, &mut workspace.state);
        match &mut clock.aligned {
            Some(cell) => {
                *cell += 1;
                clock.time = t.cell_time[*cell];
            }
            None => clock.time += t.delta,
        }
    }

    /// Moves trajectory and tangents to the place `end` of the present window.
    fn move_to_cut<O: Observer>(
        &self,
        end: f64,
        clock: &mut Clock,
        contact: Contact,
        solution: &Solution,
        workspace: &mut Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) {
        let tau = self.prepare_cut(end, &mut workspace.cut);
        counters.partial_windows += 1;
        if O::WINDOWS {
            let (d, f) = self.cut_series(&workspace.cut, solution);
            self.show(clock, contact, tau, &d, &f, workspace, observer);
        }
        let segment = self.segment(clock);
        let feedback = contact.touching().then(|| &self.tables.feedback[segment]);
        for i in 0..workspace.tangent_count {
            let x = &mut workspace.tangents[i];
            let force = feedback.map(|f| self.solve_tangent(x, f));
            self.cut_tangent(&workspace.cut, force.as_ref(), x);
            counters.tangent_windows += 1;
        }
        let force = contact.touching().then_some(&solution.force);
        self.cut_trajectory(
            &workspace.cut,
            force,
            &workspace.phases,
            &mut workspace.state,
        );
        clock.time += tau;
    }

    fn show<O: Observer>(
        &self,
        clock: &Clock,
        contact: Contact,
        duration: f64,
        deflection: &Series,
        force: &[f64; TERMS],
        workspace: &Workspace,
        observer: &mut O,
    ) {
        let (n, padded) = (self.model.modes(), self.tables.padded);
        observer.window(&Window {
            cycle: clock.cycle,
            start: clock.time,
            duration,
            segment: &self.model.cycle.segments[self.segment(clock)],
            contact,
            deflection,
            force,
            first: &workspace.state[..n],
            second: &workspace.state[padded..padded + n],
        });
    }

    /// Applies the saltation matrix of an event to all tangents.
    fn salt(&self, segment: usize, entering: bool, workspace: &mut Workspace) {
        let damping = self.tables.feedback[segment].damping;
        for x in &mut workspace.tangents[..workspace.tangent_count] {
            let (first, second) = x.split_at_mut(self.tables.padded);
            saltation::apply(&self.model.blocks, damping, entering, first, second);
        }
    }

    /// Copies trajectory and tangents into the padded layout.
    fn load(&self, trajectory: &TrajectoryState, tangents: &Tangents, workspace: &mut Workspace) {
        let (n, padded) = (self.model.modes(), self.tables.padded);
        let pad = |from: &[f64], to: &mut [f64]| {
            to[..n].copy_from_slice(&from[..n]);
            to[padded..padded + n].copy_from_slice(&from[n..]);
        };
        pad(&trajectory.state, &mut workspace.state);
        workspace.tangent_count = tangents.count();
        if workspace.tangents.len() < tangents.count() {
            workspace
                .tangents
                .resize_with(tangents.count(), || vec![0.0; 2 * padded]);
        }
        for i in 0..tangents.count() {
            pad(tangents.vector(i), &mut workspace.tangents[i]);
        }
    }

    /// Copies trajectory and tangents back.
    fn store(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        workspace: &Workspace,
    ) {
        let (n, padded) = (self.model.modes(), self.tables.padded);
        let unpad = |from: &[f64], to: &mut [f64]| {
            to[..n].copy_from_slice(&from[..n]);
            to[n..].copy_from_slice(&from[padded..padded + n]);
        };
        unpad(&workspace.state, &mut trajectory.state);
        for i in 0..tangents.count() {
            unpad(&workspace.tangents[i], tangents.vector_mut(i));
        }
    }
}
