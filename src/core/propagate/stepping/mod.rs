//! How does a method with small fixed steps, without event location, integrate the trajectory?
//!
//! Strang splitting (1968). Each step of length h is
//!
//! ```text
//! half a step of the free structure with its constant torques, exact;
//! impulse of mesh force and torque ripple at the middle, positions frozen;
//! half a step of the free structure, exact.
//! ```
//!
//! δ at the middle determines the contact state. With contact damping, the force decays during the impulse,
//! `F' = −λ F` with `λ = Σ (k w + c w A)·g`, so that its integral is `F₀ (1 − e^{−λh})/λ`. The method has order 2
//! while the contact state lasts, and order 1 where it changes.

mod cubic;
mod free_flow;
mod half_step_values;
mod mesh_state;
mod show;
mod tables;

use super::events::Changes;
use super::{Counters, Event, Kernel, Observer, Stop, Tangents};
use crate::model::{
    Line, MOST_CONTACTS, MOST_PARTS, Model, SEVERAL_CONTACTS, Segment, TrajectoryState, equal_parts,
};
use crate::numerics::linalg::add_scaled;
use free_flow::FreeFlow;
use mesh_state::{Change, MeshState};
use tables::{ContactTable, MidStepContact, Rows, dot};

/// The fixed-small-step kernel of one model.
#[derive(Debug, Clone)]
pub struct Stepping {
    period: f64,
    /// Steps per mesh cycle.
    steps: usize,
    /// Mesh cycles of a base period.
    base: usize,
    event_limit: u32,
    /// Step h \[s\].
    step: f64,
    half: FreeFlow,
    directions: Vec<Rows>,
    contacts: Vec<ContactTable>,
    /// Number of contacts that are springs of the flanks.
    flank_springs: usize,
    /// Transmission error \[m\] and its rate \[m/s\], per line, at every half step of a base period,
    /// including the end of each cycle. Empty if the errors do not repeat with the base period; orders of a
    /// shaft may not.
    transmission_error: Vec<Vec<[f64; 2]>>,
    lines: Vec<Line>,
    ripple: Vec<RippleTable>,
}

/// A tabulated torque ripple.
#[derive(Debug, Clone)]
struct RippleTable {
    /// The ripple, which gives the phase at the start of a cycle.
    source: crate::model::Ripple,
    /// Velocity change h · input, length 2N.
    kick: Vec<f64>,
    /// Cosine and sine of ω t at the middle of each step.
    wave: Vec<[f64; 2]>,
}

impl Stepping {
    /// The kernel with at least `steps` steps per mesh cycle, rounded up so that every segment boundary is a step
    /// boundary. If no grid of at most [`MOST_PARTS`] equal parts contains all boundaries, they move to the nearest
    /// step, a first-order error. A cycle with more than `event_limit` events ends the integration.
    pub fn new(model: &Model, steps: u32, event_limit: u32) -> Self {
        let period = model.period();
        let base = model.base_cycles();
        let ends: Vec<f64> = (0..base as u64)
            .flat_map(|cycle| model.segment_ends(cycle))
            .collect();
        let parts = equal_parts(&ends, MOST_PARTS).unwrap_or(1);
        let per_part = (steps.max(1) as usize).div_ceil(parts);
        let steps = per_part * parts;
        let step = period / steps as f64;

        let directions: Vec<_> = model.directions.iter().map(Rows::new).collect();
        let contacts = (model.contacts.iter())
            .map(|contact| ContactTable::new(model, contact, &directions, steps))
            .collect();
        let transmission_error = (model.lines.iter())
            .map(|line| {
                let repeats = (line.transmission_error.iter())
                    .all(|h| (h.turns_per_cycle * base as f64).fract() == 0.0);
                (0..if repeats { base as u64 } else { 0 })
                    .flat_map(|cycle| {
                        let at = move |i| 0.5 * step * i as f64;
                        (0..=2 * steps)
                            .map(move |i| line.transmission_error_at(cycle, at(i)).into())
                    })
                    .collect()
            })
            .collect();
        let ripple = model
            .ripple
            .iter()
            .map(|r| RippleTable {
                source: r.clone(),
                kick: (0..2)
                    .flat_map(|part| r.input.iter().map(move |input| step * input[part]))
                    .collect(),
                wave: (0..steps)
                    .map(|j| {
                        let middle = step * (j as f64 + 0.5);
                        let (sin, cos) = (r.angular_frequency * middle).sin_cos();
                        [cos, sin]
                    })
                    .collect(),
            })
            .collect();
        Self {
            period,
            steps,
            base,
            event_limit,
            step,
            half: FreeFlow::new(&model.blocks, 0.5 * step),
            directions,
            contacts,
            flank_springs: model.flank_springs,
            transmission_error,
            lines: model.lines.clone(),
            ripple,
        }
    }

    /// Steps per mesh cycle, rounded up.
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// Index of a mesh cycle within its base period.
    fn cycle_in_base_period(&self, cycle: u64) -> usize {
        (cycle % self.base as u64) as usize
    }

    /// A contact at the middle of step `j` of a mesh cycle.
    fn middle(&self, contact: usize, cycle: u64, j: usize) -> &MidStepContact {
        &self.contacts[contact].middles[self.cycle_in_base_period(cycle) * self.steps + j]
    }

    /// Segment of a contact on step `j` of a mesh cycle.
    fn segment(&self, contact: usize, cycle: u64, j: usize) -> &Segment {
        let segment = self.middle(contact, cycle, j).segment;
        &self.contacts[contact].contact.cycle(cycle).segments[segment]
    }

    /// Stiffness \[N/m\] and damping \[N s/m\] of a contact on step `j` of a mesh cycle.
    fn law(&self, contact: usize, cycle: u64, j: usize) -> [f64; 2] {
        let stiffness = self.middle(contact, cycle, j).stiffness;
        [stiffness, self.segment(contact, cycle, j).damping]
    }

    /// Direction of a contact on step `j` of a mesh cycle.
    fn direction(&self, contact: usize, cycle: u64, j: usize) -> &Rows {
        &self.directions[self.segment(contact, cycle, j).direction]
    }

    /// The states of the contacts at the start of step `j`; `last` if no line or gap changes there. If the line or the
    /// gap of a contact changes, the contact may open or close. The time of this change is prescribed, so tangents do
    /// not change.
    fn turn<O: Observer, const M: usize>(
        &self,
        trajectory: &mut TrajectoryState,
        j: usize,
        last: [MeshState; M],
        changes: &mut Changes,
        (observer, counters): (&mut O, &mut Counters),
    ) -> Result<[MeshState; M], Stop> {
        let cycle = trajectory.cycle;
        let mut contacts = 0..self.contacts.len();
        if !contacts.any(|contact| self.middle(contact, cycle, j).turned) {
            return Ok(last);
        }
        let mesh: [_; M] = self.mesh_states(&trajectory.state, cycle, j, 2 * j);
        let unmoved = &mut Tangents::none();
        self.follow(
            trajectory,
            unmoved,
            j,
            [&mesh, &mesh],
            changes,
            (observer, counters),
        )?;
        Ok(mesh)
    }

    /// Updates the closed contacts between two instants of step `j`. Every contact that opens or closes is an
    /// event and changes the tangents by its saltation. Openings come before closings, each in the order of
    /// time.
    fn follow<O: Observer>(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        j: usize,
        [before, after]: [&[MeshState]; 2],
        changes: &mut Changes,
        (observer, counters): (&mut O, &mut Counters),
    ) -> Result<(), Stop> {
        loop {
            let mut first: Option<(Change, usize)> = None;
            for contact in 0..self.contacts.len() {
                let change = Change::between(
                    [&before[contact], &after[contact]],
                    &self.contacts[contact].contact,
                    trajectory.contact.holds(contact),
                    self.law(contact, trajectory.cycle, j),
                );
                let Some(change) = change else { continue };
                let order = |change: &Change| (change.closes, change.fraction);
                if first.is_none_or(|(earlier, _)| order(&change) < order(&earlier)) {
                    first = Some((change, contact));
                }
            }
            let Some((change, contact)) = first else {
                return Ok(());
            };
            let fraction = change.fraction;
            let [old, new] = [&before[contact], &after[contact]];
            let side = self.contacts[contact].contact.side;
            let rate = |mesh: &MeshState| mesh.rate - side * mesh.gap[1];
            let event = Event {
                cycle: trajectory.cycle,
                time: old.time + fraction * (new.time - old.time),
                from: trajectory.contact,
                to: trajectory.contact.toggled(contact),
                contact,
                rate: rate(old) + fraction * (rate(new) - rate(old)),
            };
            changes.meet(&event, observer, counters)?;
            // I ∓ c g w: minus on entry, plus on release; no jump if no force acts.
            let [_, damping] = self.law(contact, trajectory.cycle, j);
            let direction = self.direction(contact, trajectory.cycle, j);
            let jump = match (change.on_surface, change.closes) {
                (false, _) => 0.0,
                (true, true) => damping,
                (true, false) => -damping,
            };
            for index in 0..tangents.count() {
                let tangent = tangents.vector_mut(index);
                let push = jump * dot(&direction.deflection, tangent);
                add_scaled(tangent, -push, &direction.mesh_input);
            }
            trajectory.contact = event.to;
        }
    }

    /// The impulse of contact forces and ripple at the middle of step `j`. Impulses of several closed contacts are
    /// applied in a symmetric order, each for half the step.
    fn kick(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        j: usize,
        mesh: &[MeshState],
        turned: &[[f64; 2]],
    ) {
        let active = trajectory.contact;
        if let Some(contact) = active.only() {
            self.push(trajectory, tangents, j, contact, &mesh[contact], self.step);
        } else {
            let back = (0..self.contacts.len()).rev();
            let back = back.filter(|&contact| active.holds(contact));
            for contact in active.iter().chain(back) {
                let mut mesh = mesh[contact];
                let direction = self.direction(contact, trajectory.cycle, j);
                // The other impulses have changed the rate.
                let [_, error_rate] = self.error_at(direction.line, trajectory.cycle, 2 * j + 1);
                mesh.rate = dot(&direction.rate, &trajectory.state) - error_rate;
                self.push(trajectory, tangents, j, contact, &mesh, 0.5 * self.step);
            }
        }
        for (ripple, start) in self.ripple.iter().zip(turned) {
            let [cos, sin] = ripple.wave[j];
            add_scaled(
                &mut trajectory.state,
                cos * start[0] - sin * start[1],
                &ripple.kick,
            );
        }
    }

    /// The impulse of one contact's force over a time \[s\].
    fn push(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        j: usize,
        contact: usize,
        mesh: &MeshState,
        time: f64,
    ) {
        let direction = self.direction(contact, trajectory.cycle, j);
        let middle = self.middle(contact, trajectory.cycle, j);
        let [k, c] = self.law(contact, trajectory.cycle, j);
        let impulse = middle.impulse(time);
        let force = mesh.force(self.contacts[contact].contact.side, [k, c]);
        add_scaled(
            &mut trajectory.state,
            -impulse * force,
            &direction.mesh_input,
        );
        for index in 0..tangents.count() {
            let tangent = tangents.vector_mut(index);
            let force = k * dot(&direction.deflection, tangent) + c * dot(&direction.rate, tangent);
            add_scaled(tangent, -impulse * force, &direction.mesh_input);
        }
    }
}

/// Scratch memory of [`Stepping`].
#[derive(Debug, Clone)]
pub struct SteppingWorkspace {
    /// State at the start of the observed step.
    start: Vec<f64>,
    /// The segment of every contact, for the observer.
    segments: Vec<Segment>,
    /// Cosine and sine of every ripple's phase at the start of the cycle.
    turned: Vec<[f64; 2]>,
}

impl Kernel for Stepping {
    const FARTHEST: f64 = 1e6;

    type Workspace = SteppingWorkspace;

    fn workspace(&self) -> SteppingWorkspace {
        SteppingWorkspace {
            start: vec![0.0; self.directions[0].deflection.len()],
            segments: (0..self.contacts.len())
                .map(|contact| *self.segment(contact, 0, 0))
                .collect(),
            turned: vec![[0.0; 2]; self.ripple.len()],
        }
    }

    fn exact(&self) -> bool {
        false
    }

    fn advance_cycle<O: Observer>(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        workspace: &mut SteppingWorkspace,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        let shown = (observer, counters);
        // Avoids the larger arrays if there are few contacts.
        if self.contacts.len() <= SEVERAL_CONTACTS {
            self.pass::<O, SEVERAL_CONTACTS>(trajectory, tangents, workspace, shown)
        } else {
            self.pass::<O, MOST_CONTACTS>(trajectory, tangents, workspace, shown)
        }
    }
}

impl Stepping {
    /// Integrates a cycle with at most M contacts.
    fn pass<O: Observer, const M: usize>(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        workspace: &mut SteppingWorkspace,
        (observer, counters): (&mut O, &mut Counters),
    ) -> Result<(), Stop> {
        for (turned, ripple) in workspace.turned.iter_mut().zip(&self.ripple) {
            let (sin, cos) = ripple.source.phase_at(trajectory.cycle, 0.0).sin_cos();
            *turned = [cos, sin];
        }
        let cycle = trajectory.cycle;
        let turns = self.contacts.iter().any(|contact| contact.turns);
        let mut changes = Changes::new(self.event_limit, self.steps);
        let mut last: [_; M] = self.mesh_states(&trajectory.state, cycle, 0, 0);
        let mut left = last;
        for j in 0..self.steps {
            if observer.is_interrupted() {
                return Err(Stop::Interrupted { cycle });
            }
            if turns {
                if j > 0 {
                    let end: [_; M] = self.mesh_states(&trajectory.state, cycle, j - 1, 2 * j);
                    self.follow(
                        trajectory,
                        tangents,
                        j - 1,
                        [&last, &end],
                        &mut changes,
                        (&mut *observer, &mut *counters),
                    )?;
                    last = end;
                }
                last = self.turn(
                    trajectory,
                    j,
                    last,
                    &mut changes,
                    (&mut *observer, &mut *counters),
                )?;
                left = last;
            }
            if O::WINDOWS {
                workspace.start.copy_from_slice(&trajectory.state);
            }
            self.half.advance(&mut trajectory.state);
            for index in 0..tangents.count() {
                self.half.advance_tangent(tangents.vector_mut(index));
            }
            let mesh: [_; M] = self.mesh_states(&trajectory.state, cycle, j, 2 * j + 1);
            self.follow(
                trajectory,
                tangents,
                j,
                [&last, &mesh],
                &mut changes,
                (&mut *observer, &mut *counters),
            )?;
            self.kick(trajectory, tangents, j, &mesh, &workspace.turned);
            self.half.advance(&mut trajectory.state);
            for index in 0..tangents.count() {
                self.half.advance_tangent(tangents.vector_mut(index));
            }
            if O::WINDOWS {
                let right = self.mesh_states(&trajectory.state, cycle, j, 2 * j + 2);
                let shown = (&workspace.start[..], &mut workspace.segments[..]);
                self.show(trajectory, j, [&left, &right], shown, observer);
                left = right;
            }
            last = mesh;
        }
        // The state at the end determines the closed contacts of the next cycle.
        let end: [_; M] =
            self.mesh_states(&trajectory.state, cycle, self.steps - 1, 2 * self.steps);
        for (at_end, table) in end.iter().zip(&self.contacts) {
            let reach = at_end.deflection.abs() + at_end.rate.abs() * self.step;
            if reach.is_nan() || reach > Self::FARTHEST * table.gap {
                return Err(Stop::Diverged { cycle });
            }
        }
        self.follow(
            trajectory,
            tangents,
            self.steps - 1,
            [&last, &end],
            &mut changes,
            (&mut *observer, &mut *counters),
        )?;
        counters.cycles += 1;
        counters.windows += self.steps as u64;
        counters.tangent_windows += (self.steps * tangents.count()) as u64;
        trajectory.cycle += 1;
        Ok(())
    }
}

#[cfg(test)]
mod tests;
