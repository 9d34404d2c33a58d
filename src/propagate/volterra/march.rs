//! One mesh cycle: windows, events, breakpoints.
//!
//! A window starts on a cell boundary (`aligned`) or at an event. In contact it may not
//! pass the end of its segment, in free flight only the end of the cycle. Off the cell
//! grid, windows of full length follow one another until one would pass such a
//! breakpoint; that one is cut there, and the march is aligned again.

use super::feedback::Feedback;
use super::lanes::{self, LANES, Solution};
use super::partial::Cut;
use super::tables::{Closure, Series};
use super::varying::{Factors, Nodal};
use super::window_table::WindowTable;
use super::{TERMS, Volterra};
use crate::model::{Contact, Surface, TrajectoryState};
use crate::numerics::legendre;
use crate::propagate::{Counters, Event, Kernel, Observer, Stop, Tangents, Window, saltation};

/// Deflections beyond this many half gaps count as divergence.
const FARTHEST: f64 = 1e9;

/// Round-off of a sum of a hundred terms, in units of the sum of their sizes.
const ROUND_OFF: f64 = 16.0 * f64::EPSILON;

/// Scratch memory of the structured kernel.
#[derive(Debug)]
pub struct Workspace {
    /// First components, second components, inputs.
    state: Vec<f64>,
    next: Vec<f64>,
    /// Room for tangents; what one march made room for, later ones use.
    tangents: Vec<Vec<f64>>,
    /// Tangents in this march, the first of `tangents`.
    tangent_count: usize,
    /// The next state of a tangent.
    tangent_next: Vec<f64>,
    solution: Solution,
    cut: Cut,
    /// Of the present window, where its stiffness varies off the grid.
    factors: Factors,
}

/// What closes the mesh on a window in contact.
#[derive(Clone, Copy)]
enum Closed<'a> {
    /// A table's operator.
    Table(&'a Feedback),
    /// The factors of this window's own system.
    Factors(&'a Nodal, &'a Factors),
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
            state: vec![0.0; 2 * t.layout.padded + t.layout.inputs],
            next: vec![0.0; 2 * t.layout.padded + t.layout.inputs],
            tangents: Vec::new(),
            tangent_count: 0,
            tangent_next: vec![0.0; 2 * t.layout.padded],
            solution: Solution::ZERO,
            cut: Cut::new(t.layout.padded / LANES),
            factors: Factors::NONE,
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
        let cells = self.tables.grid.cells();
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
        let grid = &self.tables.grid;
        let segment = self.segment(clock);
        let table = self.tables.window(segment);
        let stop_cell = if contact.touching() {
            grid.segment_end_cell[segment]
        } else {
            grid.direction_end_cell[segment]
        };
        let stop = grid.time[stop_cell];
        if clock.aligned.is_none() && clock.time >= stop {
            clock.time = stop;
            clock.aligned = Some(stop_cell);
            return Ok(());
        }
        let fits = clock.aligned.is_some() || clock.time + table.delta <= stop;
        let limit = if fits {
            1.0
        } else {
            2.0 * (stop - clock.time) / table.delta - 1.0
        };

        self.set_inputs(clock, &mut workspace.state);
        let (set, gap) = (self.instructions, contact.sign() * self.model.half_gap);
        if contact.touching() {
            self.close(clock, segment, &mut workspace.factors, counters);
        }
        let closed = self.closed(clock, segment, *contact, &workspace.factors);
        let (state, solution) = (&workspace.state, &mut workspace.solution);
        match closed {
            Some(Closed::Factors(nodal, factors)) => {
                lanes::solve_varying(set, &table.rows, state, nodal, factors, gap, solution);
            }
            Some(Closed::Table(feedback)) => {
                lanes::solve(set, &table.rows, state, Some((feedback, gap)), solution);
            }
            None => lanes::solve(set, &table.rows, state, None, solution),
        }
        counters.windows += 1;
        let solution = &workspace.solution;
        let farthest = FARTHEST * self.model.half_gap;
        let bound = solution.deflection[0].abs() + solution.variation;
        // The series may run far beyond an event that ends the window long before; where the
        // window starts is where the trajectory is.
        if bound.is_nan() || bound > farthest {
            let start = legendre::at_start(&solution.deflection).abs();
            if !bound.is_finite() || start > farthest {
                return Err(Stop::Diverged { cycle: clock.cycle });
            }
        }
        let noise = ROUND_OFF * (solution.size + self.model.half_gap);
        let crossed = clock.crossed.take();
        let bound = solution.variation + noise;
        if crossed.is_none()
            && contact.clearance(solution.deflection[0], self.model.half_gap) > bound
        {
            counters.certified += 1;
        } else {
            let crossing = lanes::first_crossing(
                self.instructions,
                &solution.deflection,
                *contact,
                self.model.half_gap,
                crossed,
                limit,
                noise,
                counters,
            );
            if let Some(c) = crossing {
                let series = solution.deflection;
                let [deflection, slope, _] =
                    legendre::evaluate_with_derivatives::<_, false>(&series, c.x);
                // A start beyond the surface (a trajectory given in the wrong contact state)
                // is no root that may be divided out.
                let beyond = deflection - c.surface.sign() * self.model.half_gap;
                let on_surface = c.x > -1.0 || beyond.abs() <= noise;
                if c.x > -1.0 {
                    self.move_to_cut(c.x, clock, segment, *contact, workspace, observer, counters);
                    clock.aligned = None;
                }
                let to = contact.across(c.surface);
                observer.event(&Event {
                    cycle: clock.cycle,
                    time: clock.time,
                    from: *contact,
                    to,
                    surface: c.surface,
                    rate: 2.0 / table.delta * slope,
                });
                counters.events += 1;
                // A step of δ at a prescribed time leaves tangents as they are.
                if workspace.tangent_count > 0 && on_surface {
                    self.salt(self.segment(clock), to.touching(), workspace);
                }
                *contact = to;
                clock.crossed = on_surface.then_some(c.surface);
                return Ok(());
            }
        }
        if fits {
            self.move_full(clock, segment, *contact, workspace, observer, counters);
        } else {
            self.move_to_cut(
                limit, clock, segment, *contact, workspace, observer, counters,
            );
            clock.time = stop;
            clock.aligned = Some(stop_cell);
        }
        Ok(())
    }

    /// Writes the inputs' values at the clock into the extended state.
    fn set_inputs(&self, clock: &Clock, state: &mut [f64]) {
        let t = &self.tables;
        let (constant, harmonics) = state[2 * t.layout.padded..].split_at_mut(1);
        constant[0] = 1.0;
        let (ripples, rest) = harmonics.split_at_mut(2 * t.ripple.len());
        let errors = &mut rest[..2 * self.model.transmission_error.len()];
        for (pair, r) in ripples.chunks_exact_mut(2).zip(&self.model.ripple) {
            let (sin, cos) = r.phase_at(clock.cycle, clock.time).sin_cos();
            pair.copy_from_slice(&[cos, sin]);
        }
        if let Some(cell) = clock.aligned {
            errors.copy_from_slice(&t.cell_phases[cell * errors.len()..][..errors.len()]);
            return;
        }
        let harmonics = &self.model.transmission_error;
        for (pair, h) in errors.chunks_exact_mut(2).zip(harmonics) {
            let (sin, cos) = (h.angular_frequency * clock.time).sin_cos();
            pair.copy_from_slice(&[cos, sin]);
        }
    }

    /// Mesh segment in force at the clock.
    fn segment(&self, clock: &Clock) -> usize {
        match clock.aligned {
            Some(cell) => self.tables.grid.segment_of_cell[cell],
            None => {
                let ends = &self.tables.grid.segment_end_cell;
                let inside = |end: &usize| clock.time < self.tables.grid.time[*end];
                ends.iter().position(inside).unwrap_or(ends.len() - 1)
            }
        }
    }

    /// Moves trajectory and tangents over a full window.
    fn move_full<O: Observer>(
        &self,
        clock: &mut Clock,
        segment: usize,
        contact: Contact,
        workspace: &mut Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) {
        let (table, set) = (self.tables.window(segment), self.instructions);
        if O::WINDOWS {
            let force = match contact.touching() {
                true => workspace.solution.force,
                false => [0.0; TERMS],
            };
            let series = [workspace.solution.deflection, force];
            self.show(
                clock,
                segment,
                contact,
                table.delta,
                &series,
                workspace,
                observer,
            );
        }
        let w = workspace;
        let closed = self.closed(clock, segment, contact, &w.factors);
        for x in &mut w.tangents[..w.tangent_count] {
            let force = self.tangent_force(x, table, closed);
            lanes::advance(
                set,
                &table.moves,
                force.as_ref(),
                &[],
                x,
                &mut w.tangent_next,
            );
            std::mem::swap(x, &mut w.tangent_next);
            counters.tangent_windows += 1;
        }
        let force = contact.touching().then_some(&w.solution.force);
        let (x, inputs) = w.state.split_at(2 * self.tables.layout.padded);
        let inputs = &inputs[..self.tables.layout.acting];
        lanes::advance(set, &table.moves, force, inputs, x, &mut w.next);
        std::mem::swap(&mut w.state, &mut w.next);
        match &mut clock.aligned {
            Some(cell) => {
                *cell += 1;
                clock.time = self.tables.grid.time[*cell];
            }
            None => clock.time += table.delta,
        }
    }

    /// Moves trajectory and tangents to the place `end` of the present window.
    fn move_to_cut<O: Observer>(
        &self,
        end: f64,
        clock: &mut Clock,
        segment: usize,
        contact: Contact,
        workspace: &mut Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) {
        let table = self.tables.window(segment);
        let tau = self.prepare_cut(table, end, &mut workspace.cut);
        counters.partial_windows += 1;
        if O::WINDOWS {
            let series = self.cut_series(&workspace.cut, &workspace.solution, contact.touching());
            self.show(clock, segment, contact, tau, &series, workspace, observer);
        }
        let w = workspace;
        let closed = self.closed(clock, segment, contact, &w.factors);
        for x in &mut w.tangents[..w.tangent_count] {
            let force = self.tangent_force(x, table, closed);
            self.cut_tangent(table, &w.cut, force.as_ref(), x);
            counters.tangent_windows += 1;
        }
        let force = contact.touching().then_some(&w.solution.force);
        self.cut_trajectory(table, &w.cut, force, &mut w.state);
        clock.time += tau;
    }

    /// What the system of a window in contact is made of, where no table has it: the window
    /// starts off the grid, and its stiffness varies.
    fn own_system(&self, clock: &Clock, segment: usize) -> Option<&Nodal> {
        let varies = !self.model.cycle.segments[segment].stiffness.is_constant();
        let nodal = self.tables.window(segment).nodal.as_deref();
        nodal.filter(|_| clock.aligned.is_none() && varies)
    }

    /// Factorises the system of a window in contact that no table has.
    fn close(&self, clock: &Clock, segment: usize, factors: &mut Factors, counters: &mut Counters) {
        if let Some(nodal) = self.own_system(clock, segment) {
            let delta = self.tables.window(segment).delta;
            let segment = &self.model.cycle.segments[segment];
            let closure = Closure::new(self.model, segment, clock.time, delta);
            closure.factorise(self.instructions, nodal, factors);
            counters.factorised += 1;
        }
    }

    /// What closes the mesh on the window that starts at the clock; none in free flight.
    fn closed<'a>(
        &'a self,
        clock: &Clock,
        segment: usize,
        contact: Contact,
        factors: &'a Factors,
    ) -> Option<Closed<'a>> {
        if !contact.touching() {
            return None;
        }
        if let Some(nodal) = self.own_system(clock, segment) {
            return Some(Closed::Factors(nodal, factors));
        }
        // Off the grid the stiffness is constant, and every cell of the segment has its operator.
        let last = self.tables.grid.segment_end_cell[segment] - 1;
        let cell = clock.aligned.unwrap_or(last);
        Some(Closed::Table(self.tables.feedback(cell)))
    }

    /// The force series of a tangent vector; none in free flight.
    fn tangent_force(
        &self,
        x: &[f64],
        table: &WindowTable,
        closed: Option<Closed<'_>>,
    ) -> Option<Series> {
        let rows = &table.rows[..2 * self.tables.layout.padded];
        let set = self.instructions;
        closed.map(|closed| match closed {
            Closed::Table(feedback) => lanes::respond(set, rows, x, feedback),
            Closed::Factors(nodal, factors) => lanes::respond_varying(set, rows, x, nodal, factors),
        })
    }

    fn show<O: Observer>(
        &self,
        clock: &Clock,
        segment: usize,
        contact: Contact,
        duration: f64,
        [deflection, force]: &[Series; 2],
        workspace: &Workspace,
        observer: &mut O,
    ) {
        let (n, padded) = (self.model.modes(), self.tables.layout.padded);
        observer.window(&Window {
            cycle: clock.cycle,
            start: clock.time,
            duration,
            segment: &self.model.cycle.segments[segment],
            contact,
            deflection,
            force,
            first: &workspace.state[..n],
            second: &workspace.state[padded..padded + n],
        });
    }

    /// Applies the saltation matrix of an event to all tangents.
    fn salt(&self, segment: usize, entering: bool, workspace: &mut Workspace) {
        let segment = &self.model.cycle.segments[segment];
        let (gains, damping) = (self.model.gains(segment), segment.damping);
        for x in &mut workspace.tangents[..workspace.tangent_count] {
            let (first, second) = x.split_at_mut(self.tables.layout.padded);
            saltation::apply(gains, damping, entering, first, second);
        }
    }

    /// Copies trajectory and tangents into the padded layout.
    fn load(&self, trajectory: &TrajectoryState, tangents: &Tangents, workspace: &mut Workspace) {
        let (n, padded) = (self.model.modes(), self.tables.layout.padded);
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
        let (n, padded) = (self.model.modes(), self.tables.layout.padded);
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
