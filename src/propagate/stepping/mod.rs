//! The fixed-small-step kernel: what does the trajectory look like to a method that knows
//! nothing of events? The oracle of the other kernels.
//!
//! Strang splitting (1968). Each step of length h is
//!
//! ```text
//! half a step of the free structure with its constant torques, exact;
//! impulse of mesh force and torque ripple at the middle, positions frozen;
//! half a step of the free structure, exact.
//! ```
//!
//! The contact state is read off δ at the middle. With contact damping the force decays
//! during the impulse, `F' = −λ F` with `λ = Σ (k w + c w A)·g`, so that its integral is
//! `F₀ (1 − e^{−λh})/λ`. The method is of order 2 while the contact state lasts and of
//! order 1 where it changes.

mod rotation;

use super::{Counters, Event, Kernel, Observer, Stop, Tangents, Window};
use crate::model::{Contact, MeshCycle, Model, Surface, TrajectoryState};
use rotation::Rotation;

/// A deflection of so many half gaps is no longer a gear mesh.
const RANGE: f64 = 1e6;

/// Most equal parts of the cycle on which segment boundaries are sought.
const MOST_PARTS: usize = 10_000;

/// The fixed-small-step kernel of one model.
#[derive(Debug, Clone)]
pub struct Stepping {
    cycle: MeshCycle,
    half_gap: f64,
    steps: usize,
    event_limit: u32,
    /// Step h \[s\].
    step: f64,
    half: Rotation,
    /// Rows of δ and δ', column of the mesh force; length 2N each.
    deflection: Vec<f64>,
    rate: Vec<f64>,
    mesh_input: Vec<f64>,
    /// Per step: the mesh segment at its middle.
    segment: Vec<u32>,
    /// Per mesh segment: impulse per unit force at the middle \[s\].
    impulse: Vec<f64>,
    /// Static transmission error and its rate at every half step, 0 ..= 2 steps.
    transmission_error: Vec<[f64; 2]>,
    ripple: Vec<RippleTable>,
}

/// One torque ripple, tabulated.
#[derive(Debug, Clone)]
struct RippleTable {
    /// Phase at the start of cycle 0 and turns per cycle.
    source: crate::model::Ripple,
    /// Velocity change h · input, length 2N.
    kick: Vec<f64>,
    /// Cosine and sine of ω t at the middle of each step.
    wave: Vec<[f64; 2]>,
}

/// What the mesh looks like at one instant.
#[derive(Debug, Clone, Copy)]
struct Sight {
    time: f64,
    deflection: f64,
    rate: f64,
}

impl Stepping {
    /// The kernel with at least `steps` steps a mesh cycle: rounded up so that every
    /// segment boundary falls on a step boundary. A boundary that no grid of at most 10 000
    /// parts meets is moved to the nearest step, an error of order 1. A cycle with more than
    /// `event_limit` events is given up.
    pub fn new(model: &Model, steps: u32, event_limit: u32) -> Self {
        let cycle = model.cycle.clone();
        let parts = cycle.equal_parts(MOST_PARTS).unwrap_or(1);
        let per_part = (steps.max(1) as usize).div_ceil(parts);
        let steps = per_part * parts;
        let step = cycle.period / steps as f64;

        let columns = |entry: fn(&crate::model::Block) -> [f64; 2]| -> Vec<f64> {
            let first = model.blocks.iter().map(|b| entry(b)[0]);
            let second = model.blocks.iter().map(|b| entry(b)[1]);
            first.chain(second).collect()
        };
        let deflection = columns(|b| b.deflection);
        let rate = columns(|b| b.rate());
        let mesh_input = columns(|b| b.mesh_input);
        let (direct, inertial) = (dot(&deflection, &mesh_input), dot(&rate, &mesh_input));
        let impulse = cycle
            .segments
            .iter()
            .map(|s| {
                let decay = s.stiffness * direct + s.damping * inertial;
                if decay == 0.0 {
                    step
                } else {
                    -(-decay * step).exp_m1() / decay
                }
            })
            .collect();
        let mut segment = Vec::with_capacity(steps);
        for (index, s) in cycle.segments.iter().enumerate() {
            let end = (s.end * steps as f64).round() as usize;
            segment.resize(end, index as u32);
        }
        let transmission_error = (0..=2 * steps)
            .map(|i| model.transmission_error_at(0.5 * step * i as f64).into())
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
            half_gap: model.half_gap,
            steps,
            event_limit,
            step,
            half: Rotation::new(&model.blocks, 0.5 * step),
            deflection,
            rate,
            mesh_input,
            segment,
            impulse,
            transmission_error,
            ripple,
            cycle,
        }
    }

    /// Steps a mesh cycle after rounding up.
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// The mesh at half step `index` of the cycle.
    fn sight(&self, state: &[f64], index: usize) -> Sight {
        let [error, error_rate] = self.transmission_error[index];
        Sight {
            time: 0.5 * self.step * index as f64,
            deflection: dot(&self.deflection, state) - error,
            rate: dot(&self.rate, state) - error_rate,
        }
    }

    /// Carries the contact state from one sight to the next: an event, with its saltation,
    /// for every surface between the two.
    fn follow<O: Observer>(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        damping: f64,
        [before, after]: [Sight; 2],
        events: &mut u32,
        observer: &mut O,
    ) -> Result<(), Stop> {
        let target = Contact::classify(after.deflection, after.rate, self.half_gap);
        while trajectory.contact != target {
            let from = trajectory.contact;
            let surface = match (from, target) {
                (Contact::Drive, _) | (Contact::Free, Contact::Drive) => Surface::Drive,
                _ => Surface::Coast,
            };
            let to = from.across(surface);
            let level = surface.sign() * self.half_gap;
            let change = after.deflection - before.deflection;
            let fraction = if change == 0.0 {
                1.0
            } else {
                ((level - before.deflection) / change).clamp(0.0, 1.0)
            };
            *events += 1;
            if *events > self.event_limit {
                return Err(Stop::EventStorm {
                    cycle: trajectory.cycle,
                    limit: self.event_limit,
                });
            }
            observer.event(&Event {
                cycle: trajectory.cycle,
                time: before.time + fraction * (after.time - before.time),
                from,
                to,
                surface,
                rate: before.rate + fraction * (after.rate - before.rate),
            });
            // I ∓ c g w: minus on entry, plus on release.
            let jump = if to.touching() { damping } else { -damping };
            for index in 0..tangents.count() {
                let tangent = tangents.vector_mut(index);
                let push = jump * dot(&self.deflection, tangent);
                add_scaled(tangent, -push, &self.mesh_input);
            }
            trajectory.contact = to;
        }
        Ok(())
    }

    /// The impulse of mesh force and ripple at the middle of step `j`.
    fn kick(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        j: usize,
        sight: Sight,
        turned: &[[f64; 2]],
    ) {
        let index = self.segment[j] as usize;
        let segment = &self.cycle.segments[index];
        let contact = trajectory.contact;
        if contact.touching() {
            let force = segment.stiffness * (sight.deflection - contact.sign() * self.half_gap)
                + segment.damping * sight.rate;
            let impulse = self.impulse[index];
            add_scaled(&mut trajectory.state, -impulse * force, &self.mesh_input);
            for index in 0..tangents.count() {
                let tangent = tangents.vector_mut(index);
                let force = segment.stiffness * dot(&self.deflection, tangent)
                    + segment.damping * dot(&self.rate, tangent);
                add_scaled(tangent, -impulse * force, &self.mesh_input);
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

    /// Shows a step to the observer: δ as the cubic through values and rates at its ends,
    /// F as the force of that cubic.
    fn show<O: Observer>(
        &self,
        trajectory: &TrajectoryState,
        j: usize,
        [left, right]: [Sight; 2],
        start: &[f64],
        observer: &mut O,
    ) {
        let segment = &self.cycle.segments[self.segment[j] as usize];
        let contact = trajectory.contact;
        let deflection = hermite(left, right, self.step);
        let mut force = [0.0; 4];
        if contact.touching() {
            let rate = derivative(deflection, self.step);
            for i in 0..4 {
                force[i] = segment.stiffness * deflection[i] + segment.damping * rate[i];
            }
            force[0] -= segment.stiffness * contact.sign() * self.half_gap;
        }
        let (first, second) = start.split_at(start.len() / 2);
        observer.window(&Window {
            cycle: trajectory.cycle,
            start: left.time,
            duration: self.step,
            segment,
            contact,
            deflection: &deflection,
            force: &force,
            first,
            second,
        });
    }
}

/// Scratch memory of [`Stepping`].
#[derive(Debug, Clone)]
pub struct SteppingWorkspace {
    /// State at the start of the step that is shown to an observer.
    start: Vec<f64>,
    /// Cosine and sine of every ripple's phase at the start of the cycle.
    turned: Vec<[f64; 2]>,
}

impl Kernel for Stepping {
    type Workspace = SteppingWorkspace;

    fn workspace(&self) -> SteppingWorkspace {
        SteppingWorkspace {
            start: vec![0.0; self.deflection.len()],
            turned: vec![[0.0; 2]; self.ripple.len()],
        }
    }

    fn march<O: Observer>(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        workspace: &mut SteppingWorkspace,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        for (turned, ripple) in workspace.turned.iter_mut().zip(&self.ripple) {
            let (sin, cos) = ripple.source.phase_at(trajectory.cycle, 0.0).sin_cos();
            *turned = [cos, sin];
        }
        let mut events = 0;
        let mut last = self.sight(&trajectory.state, 0);
        let mut left = last;
        for j in 0..self.steps {
            if O::WINDOWS {
                workspace.start.copy_from_slice(&trajectory.state);
            }
            self.half.advance(&mut trajectory.state);
            for index in 0..tangents.count() {
                self.half.advance_tangent(tangents.vector_mut(index));
            }
            let sight = self.sight(&trajectory.state, 2 * j + 1);
            let damping = self.cycle.segments[self.segment[j] as usize].damping;
            self.follow(
                trajectory,
                tangents,
                damping,
                [last, sight],
                &mut events,
                observer,
            )?;
            self.kick(trajectory, tangents, j, sight, &workspace.turned);
            self.half.advance(&mut trajectory.state);
            for index in 0..tangents.count() {
                self.half.advance_tangent(tangents.vector_mut(index));
            }
            if O::WINDOWS {
                let right = self.sight(&trajectory.state, 2 * j + 2);
                self.show(trajectory, j, [left, right], &workspace.start, observer);
                left = right;
            }
            last = sight;
        }
        // The contact state that goes into the next cycle is that of the state itself.
        let end = self.sight(&trajectory.state, 2 * self.steps);
        let reach = end.deflection.abs() + end.rate.abs() * self.step;
        if reach.is_nan() || reach > RANGE * self.half_gap {
            return Err(Stop::Diverged {
                cycle: trajectory.cycle,
            });
        }
        let damping = self.cycle.segments[self.cycle.segments.len() - 1].damping;
        self.follow(
            trajectory,
            tangents,
            damping,
            [last, end],
            &mut events,
            observer,
        )?;
        counters.cycles += 1;
        counters.windows += self.steps as u64;
        counters.tangent_windows += (self.steps * tangents.count()) as u64;
        counters.events += u64::from(events);
        trajectory.cycle += 1;
        Ok(())
    }
}

/// Legendre coefficients of the cubic through δ and δ' at both ends of a window.
///
/// From `p(±1) = a₀ ± a₁ + a₂ ± a₃` and `p'(±1) = a₁ ± 3 a₂ + 6 a₃`.
fn hermite(left: Sight, right: Sight, duration: f64) -> [f64; 4] {
    let (p, q) = (left.deflection, right.deflection);
    let (s, t) = (0.5 * duration * left.rate, 0.5 * duration * right.rate);
    let a2 = (t - s) / 6.0;
    let a3 = (0.5 * (s + t) - 0.5 * (q - p)) / 5.0;
    [0.5 * (p + q) - a2, 0.5 * (q - p) - a3, a2, a3]
}

/// Legendre coefficients of the time derivative of a cubic.
fn derivative(a: [f64; 4], duration: f64) -> [f64; 4] {
    let scale = 2.0 / duration;
    [
        scale * (a[1] + a[3]),
        scale * 3.0 * a[2],
        scale * 5.0 * a[3],
        0.0,
    ]
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    // Eight running sums, so that the additions need not wait for one another.
    let mut sums = [0.0; 8];
    let (a_chunks, a_rest) = a.as_chunks::<8>();
    let (b_chunks, b_rest) = b.as_chunks::<8>();
    for (x, y) in a_chunks.iter().zip(b_chunks) {
        for lane in 0..8 {
            sums[lane] += x[lane] * y[lane];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(x, y)| x * y).sum();
    sums.iter().sum::<f64>() + rest
}

fn add_scaled(to: &mut [f64], scale: f64, by: &[f64]) {
    for (value, b) in to.iter_mut().zip(by) {
        *value += scale * b;
    }
}

#[cfg(test)]
mod tests;
