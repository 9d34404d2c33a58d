//! One mesh cycle: windows, events, breakpoints.
//!
//! A window starts on a cell boundary (`aligned`) or at an event. In contact it may not
//! pass the end of its segment, in free flight only the end of the cycle. Off the cell
//! grid, windows of full length follow one another until one would pass such a
//! breakpoint; that one is cut there, and the integration is aligned again.

use super::Volterra;
use super::closure::Closure;
use super::feedback::Closed;
use super::lanes;
use super::shapes::{Lack, Series, TERMS};
use super::varying::{Factors, Nodal};
use super::workspace::Workspace;
use crate::model::{Contact, Surface, TrajectoryState};
use crate::numerics::legendre;
use crate::propagate::events::{Changes, ROUND_OFF, WindowDeflection};
use crate::propagate::{Counters, Event, Kernel, Observer, Stop, Tangents, Window};

/// Where a window starts.
#[derive(Debug, Clone, Copy)]
struct Position {
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
        Workspace::new(self.tables.layout)
    }

    fn advance_cycle<O: Observer>(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        workspace: &mut Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        workspace.load(trajectory, tangents);
        let cells = self.tables.grid.cells();
        let mut position = Position {
            cycle: trajectory.cycle,
            time: 0.0,
            aligned: Some(0),
            crossed: None,
        };
        let mut contact = trajectory.contact;
        let mut changes = Changes::new(self.event_limit);
        while position.aligned != Some(cells) {
            if observer.called_off() {
                return Err(Stop::CalledOff {
                    cycle: position.cycle,
                });
            }
            self.step(
                &mut position,
                &mut contact,
                &mut changes,
                workspace,
                observer,
                counters,
            )?;
        }
        trajectory.contact = contact;
        trajectory.cycle += 1;
        counters.cycles += 1;
        workspace.store(trajectory, tangents);
        Ok(())
    }
}

impl Volterra<'_> {
    /// Solves one window and moves to its end, to the next event or to a breakpoint.
    fn step<O: Observer>(
        &self,
        position: &mut Position,
        contact: &mut Contact,
        changes: &mut Changes,
        workspace: &mut Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        let grid = &self.tables.grid;
        let segment = self.segment(position);
        let table = self.tables.window(segment);
        let stop_cell = if contact.touching() {
            grid.segment_end_cell[segment]
        } else {
            grid.flight_end_cell[segment]
        };
        let stop = grid.time[stop_cell];
        if position.aligned.is_none() && position.time >= stop {
            self.align(position, stop_cell);
            return Ok(());
        }
        let fits = position.aligned.is_some() || position.time + table.delta <= stop;
        let limit = if fits {
            1.0
        } else {
            2.0 * (stop - position.time) / table.delta - 1.0
        };

        self.set_inputs(position, &mut workspace.inputs);
        if contact.touching() {
            self.close(position, segment, &mut workspace.factors, counters);
        }
        let lack = (self.tables).lack(self.model, segment, position.time, position.aligned);
        // In contact it is found with the force, on the side that touches; a free flight has it on
        // both sides.
        let touching = contact.touching();
        let own = (lack.filter(|_| touching)).map(|lack| lack.map(|a| contact.sign() * a));
        let widening = (lack.filter(|_| !touching)).map(|lack| padded(&lack));
        let gap = contact.sign() * self.model.half_gap;
        let (inputs, columns, factors, forces, solution) = workspace.solving();
        let closed = self.closed(position, segment, *contact, factors);
        lanes::solve(
            self.instructions,
            &table.rows,
            inputs,
            columns,
            closed.map(|closed| (closed, gap, own.as_ref())),
            forces,
            solution,
        );
        counters.windows += 1;
        let solution = &workspace.solution;
        let farthest = Self::FARTHEST * self.model.half_gap;
        let bound = solution.deflection[0].abs() + solution.variation;
        // The series may run far beyond an event that ends the window long before; where the
        // window starts is where the trajectory is.
        if bound.is_nan() || bound > farthest {
            let start = legendre::at_start(&solution.deflection).abs();
            if !bound.is_finite() || start > farthest {
                return Err(Stop::Diverged {
                    cycle: position.cycle,
                });
            }
        }
        let noise = ROUND_OFF * (solution.size + self.model.half_gap);
        let crossed = position.crossed.take();
        let mut bound = solution.variation + noise;
        if let Some(widening) = &widening {
            bound += legendre::variation(widening) - widening[0];
        }
        if crossed.is_none()
            && contact.clearance(solution.deflection[0], self.model.half_gap) > bound
        {
            counters.certified += 1;
        } else {
            let deflection = WindowDeflection {
                series: &solution.deflection,
                contact: *contact,
                crossed,
                noise,
                widening: widening.as_ref(),
            };
            let (set, half_gap) = (self.instructions, self.model.half_gap);
            let crossing = lanes::first_crossing(set, deflection, half_gap, limit, counters);
            if let Some(c) = crossing {
                // Against the surface, which moves where the half gap does.
                let mut series = solution.deflection;
                for (term, a) in series.iter_mut().zip(widening.iter().flatten()) {
                    *term -= c.surface.sign() * a;
                }
                let [deflection, slope, _] =
                    legendre::evaluate_with_derivatives::<_, false>(&series, c.x);
                // A start beyond the surface (a trajectory given in the wrong contact state)
                // is no root that may be divided out.
                let beyond = deflection - c.surface.sign() * self.model.half_gap;
                let on_surface = c.x > -1.0 || beyond.abs() <= noise;
                workspace.solution.restore(own.as_ref());
                if c.x > -1.0 {
                    self.move_to_cut(
                        c.x, position, segment, *contact, workspace, observer, counters,
                    );
                    position.aligned = None;
                }
                let to = contact.across(c.surface);
                let event = Event {
                    cycle: position.cycle,
                    time: position.time,
                    from: *contact,
                    to,
                    surface: c.surface,
                    rate: 2.0 / table.delta * slope,
                };
                changes.meet(&event, observer, counters)?;
                // A step of δ at a prescribed time leaves tangents as they are.
                if workspace.tangents() > 0 && on_surface {
                    self.salt(self.segment(position), to.touching(), workspace);
                }
                *contact = to;
                position.crossed = on_surface.then_some(c.surface);
                return Ok(());
            }
        }
        workspace.solution.restore(own.as_ref());
        if fits {
            self.move_full(position, segment, *contact, workspace, observer, counters);
        } else {
            self.move_to_cut(
                limit, position, segment, *contact, workspace, observer, counters,
            );
            self.align(position, stop_cell);
        }
        Ok(())
    }

    /// Takes up the cell grid again at a breakpoint. Beyond a change of the half gap or of the
    /// direction nothing stands on a surface any more.
    fn align(&self, position: &mut Position, cell: usize) {
        let grid = &self.tables.grid;
        position.time = grid.time[cell];
        position.aligned = Some(cell);
        let segment = grid.segment_of_cell.get(cell).copied().unwrap_or(0);
        if self.model.cycle.turns(segment) {
            position.crossed = None;
        }
    }

    /// Writes the inputs' values where a window starts.
    fn set_inputs(&self, position: &Position, inputs: &mut [f64]) {
        let t = &self.tables;
        let (constant, harmonics) = inputs.split_at_mut(1);
        constant[0] = 1.0;
        let (ripples, rest) = harmonics.split_at_mut(2 * t.ripple.len());
        let errors = &mut rest[..2 * self.model.transmission_error.len()];
        for (pair, r) in ripples.chunks_exact_mut(2).zip(&self.model.ripple) {
            let (sin, cos) = r.phase_at(position.cycle, position.time).sin_cos();
            pair.copy_from_slice(&[cos, sin]);
        }
        if let Some(cell) = position.aligned {
            errors.copy_from_slice(&t.cell_phases[cell * errors.len()..][..errors.len()]);
            return;
        }
        let harmonics = &self.model.transmission_error;
        for (pair, h) in errors.chunks_exact_mut(2).zip(harmonics) {
            let (sin, cos) = (h.angular_frequency * position.time).sin_cos();
            pair.copy_from_slice(&[cos, sin]);
        }
    }

    /// Mesh segment in force there.
    fn segment(&self, position: &Position) -> usize {
        match position.aligned {
            Some(cell) => self.tables.grid.segment_of_cell[cell],
            None => {
                let ends = &self.tables.grid.segment_end_cell;
                let inside = |end: &usize| position.time < self.tables.grid.time[*end];
                ends.iter().position(inside).unwrap_or(ends.len() - 1)
            }
        }
    }

    /// Moves trajectory and tangents over a full window.
    fn move_full<O: Observer>(
        &self,
        position: &mut Position,
        segment: usize,
        contact: Contact,
        workspace: &mut Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) {
        let table = self.tables.window(segment);
        if O::WINDOWS {
            let force = match contact.touching() {
                true => workspace.forces[0].0,
                false => [0.0; TERMS],
            };
            let series = [workspace.solution.deflection, force];
            self.show(
                position,
                segment,
                contact,
                table.delta,
                &series,
                workspace,
                observer,
            );
        }
        counters.tangent_windows += workspace.tangents() as u64;
        let (columns, forces, inputs, _) = workspace.moving(contact.touching());
        let inputs = &inputs[..self.tables.layout.acting];
        lanes::advance(self.instructions, &table.moves, forces, inputs, columns);
        match &mut position.aligned {
            Some(cell) => {
                *cell += 1;
                position.time = self.tables.grid.time[*cell];
            }
            None => position.time += table.delta,
        }
    }

    /// Moves trajectory and tangents to the place `end` of the present window.
    fn move_to_cut<O: Observer>(
        &self,
        end: f64,
        position: &mut Position,
        segment: usize,
        contact: Contact,
        workspace: &mut Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) {
        let table = self.tables.window(segment);
        let with_nodes = O::WINDOWS || contact.touching();
        let tau = self.prepare_cut(table, end, with_nodes, &mut workspace.cut);
        counters.partial_windows += 1;
        if O::WINDOWS {
            let force = match contact.touching() {
                true => self.cut_series(&workspace.cut, &workspace.forces[0].0),
                false => [0.0; TERMS],
            };
            let deflection = self.cut_series(&workspace.cut, &workspace.solution.deflection);
            let series = [deflection, force];
            self.show(
                position, segment, contact, tau, &series, workspace, observer,
            );
        }
        counters.tangent_windows += workspace.tangents() as u64;
        let (columns, forces, inputs, cut) = workspace.moving(contact.touching());
        self.cut(table, cut, forces, inputs, columns);
        position.time += tau;
    }

    /// What the system of a window in contact is made of, where no table has it: the window
    /// starts off the grid, and its stiffness varies.
    fn own_system(&self, position: &Position, segment: usize) -> Option<&Nodal> {
        let varies = !self.model.cycle.segments[segment].stiffness.is_constant();
        let nodal = self.tables.window(segment).nodal.as_deref();
        nodal.filter(|_| position.aligned.is_none() && varies)
    }

    /// Factorises the system of a window in contact that no table has.
    fn close(
        &self,
        position: &Position,
        segment: usize,
        factors: &mut Factors,
        counters: &mut Counters,
    ) {
        if let Some(nodal) = self.own_system(position, segment) {
            let delta = self.tables.window(segment).delta;
            let segment = &self.model.cycle.segments[segment];
            let closure = Closure::new(self.model, segment, position.time, delta);
            closure.factorise(self.instructions, nodal, factors);
            counters.factorised += 1;
        }
    }

    /// What closes the mesh on the window that starts there; none in free flight.
    fn closed<'a>(
        &'a self,
        position: &Position,
        segment: usize,
        contact: Contact,
        factors: &'a Factors,
    ) -> Option<Closed<'a>> {
        if !contact.touching() {
            return None;
        }
        if let Some(nodal) = self.own_system(position, segment) {
            return Some(Closed::Factors(nodal, factors));
        }
        // Off the grid the stiffness is constant, and every cell of the segment has its operator.
        let last = self.tables.grid.segment_end_cell[segment] - 1;
        let cell = position.aligned.unwrap_or(last);
        Some(Closed::Table(self.tables.feedback(cell)))
    }

    fn show<O: Observer>(
        &self,
        position: &Position,
        segment: usize,
        contact: Contact,
        duration: f64,
        [deflection, force]: &[Series; 2],
        workspace: &Workspace,
        observer: &mut O,
    ) {
        let [first, second] = workspace.components(self.model.modes());
        observer.window(&Window {
            cycle: position.cycle,
            start: position.time,
            duration,
            segment: &self.model.cycle.segments[segment],
            contact,
            deflection,
            force,
            first,
            second,
        });
    }

    /// Applies the saltation matrix of an event to all tangents.
    fn salt(&self, segment: usize, entering: bool, workspace: &mut Workspace) {
        let segment = &self.model.cycle.segments[segment];
        let damping = if entering {
            segment.damping
        } else {
            -segment.damping
        };
        let blocks = &self.tables.blocks[segment.direction];
        lanes::salt(self.instructions, blocks, damping, workspace.tangents_mut());
    }
}

/// A short series as one of a window.
fn padded(lack: &Lack) -> Series {
    let mut out = [0.0; TERMS];
    out[..lack.len()].copy_from_slice(lack);
    out
}
