//! The fixed-small-step kernel: the trajectory as a method sees it that knows nothing of events.
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

mod cubic;
mod rotation;

use super::events::Changes;
use super::{Counters, Event, Kernel, Observer, Stop, Tangents, Window};
use crate::model::{Contact, MeshCycle, MeshGain, Model, Segment, TrajectoryState};
use cubic::{derivative, hermite};
use rotation::Rotation;

/// Most equal parts of the cycle on which segment boundaries are sought.
const MOST_PARTS: usize = 10_000;

/// The fixed-small-step kernel of one model.
#[derive(Debug, Clone)]
pub struct Stepping {
    cycle: MeshCycle,
    half_gap: f64,
    steps: usize,
    event_limit: u32,
    /// Whether direction or half gap change anywhere in the cycle.
    turns: bool,
    /// Step h \[s\].
    step: f64,
    half: Rotation,
    directions: Vec<Direction>,
    /// Per step: the mesh at its middle.
    middles: Vec<Middle>,
    /// Static transmission error and its rate at every half step, 0 ..= 2 steps.
    transmission_error: Vec<[f64; 2]>,
    ripple: Vec<RippleTable>,
}

/// Rows of δ and δ', column of the mesh force; length 2N each.
#[derive(Debug, Clone)]
struct Direction {
    deflection: Vec<f64>,
    rate: Vec<f64>,
    mesh_input: Vec<f64>,
}

/// The mesh at the middle of a step.
#[derive(Debug, Clone, Copy)]
struct Middle {
    /// Mesh segment.
    segment: usize,
    /// Stiffness \[N/m\].
    stiffness: f64,
    /// Impulse per unit force \[s\].
    impulse: f64,
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
struct MeshState {
    time: f64,
    deflection: f64,
    rate: f64,
    /// Half gap \[m\] and its rate \[m/s\].
    gap: [f64; 2],
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

        let directions: Vec<_> = (model.directions.iter())
            .map(|gains| {
                let columns = |entry: fn(&MeshGain) -> [f64; 2]| -> Vec<f64> {
                    let first = gains.iter().map(|gain| entry(gain)[0]);
                    let second = gains.iter().map(|gain| entry(gain)[1]);
                    first.chain(second).collect()
                };
                Direction {
                    deflection: columns(|gain| gain.deflection),
                    rate: columns(|gain| gain.rate),
                    mesh_input: columns(|gain| gain.mesh_input),
                }
            })
            .collect();
        let mut middles = Vec::with_capacity(steps);
        for (index, s) in cycle.segments.iter().enumerate() {
            let direction = &directions[s.direction];
            let direct = dot(&direction.deflection, &direction.mesh_input);
            let inertial = dot(&direction.rate, &direction.mesh_input);
            let end = (s.end * steps as f64).round() as usize;
            for j in middles.len()..end {
                let stiffness = s.stiffness_at((j as f64 + 0.5) / steps as f64);
                let decay = stiffness * direct + s.damping * inertial;
                let impulse = if decay == 0.0 {
                    step
                } else {
                    -(-decay * step).exp_m1() / decay
                };
                middles.push(Middle {
                    segment: index,
                    stiffness,
                    impulse,
                });
            }
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
            turns: cycle.ever_turns(),
            steps,
            event_limit,
            step,
            half: Rotation::new(&model.blocks, 0.5 * step),
            directions,
            middles,
            transmission_error,
            ripple,
            cycle,
        }
    }

    /// Steps a mesh cycle after rounding up.
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// Segment of step `j`.
    fn segment(&self, j: usize) -> &Segment {
        &self.cycle.segments[self.middles[j].segment]
    }

    /// Direction of step `j`.
    fn direction(&self, j: usize) -> &Direction {
        &self.directions[self.segment(j).direction]
    }

    /// The mesh at half step `index` of the cycle, as step `j` sees it.
    fn mesh_state(&self, state: &[f64], j: usize, index: usize) -> MeshState {
        let direction = self.direction(j);
        let [error, error_rate] = self.transmission_error[index];
        let phase = index as f64 / (2 * self.steps) as f64;
        let [lack, slope] = self.segment(j).error_at(phase);
        MeshState {
            time: 0.5 * self.step * index as f64,
            deflection: dot(&direction.deflection, state) - error,
            rate: dot(&direction.rate, state) - error_rate,
            gap: [self.half_gap + lack, slope / self.cycle.period],
        }
    }

    /// The mesh at the start of step `j`. Where direction or half gap change the contact state may
    /// step: at a prescribed time, so that tangents go on as they are.
    fn turn<O: Observer>(
        &self,
        trajectory: &mut TrajectoryState,
        j: usize,
        last: MeshState,
        changes: &mut Changes,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<MeshState, Stop> {
        let segment = self.middles[j].segment;
        let starts = j == 0 || self.middles[j - 1].segment != segment;
        if !(starts && self.cycle.turns(segment)) {
            return Ok(last);
        }
        let mesh = self.mesh_state(&trajectory.state, j, 2 * j);
        let unmoved = &mut Tangents::none();
        self.follow(
            trajectory,
            unmoved,
            j,
            [mesh, mesh],
            changes,
            observer,
            counters,
        )?;
        Ok(mesh)
    }

    /// Carries the contact state from one state of step `j` to the next: an event, with its
    /// saltation, for every surface between the two.
    fn follow<O: Observer>(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        j: usize,
        [before, after]: [MeshState; 2],
        changes: &mut Changes,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        let (direction, damping) = (self.direction(j), self.segment(j).damping);
        let target = Contact::classify(after.deflection, after.rate, after.gap);
        while trajectory.contact != target {
            let from = trajectory.contact;
            let Some(surface) = from.towards(target) else {
                break;
            };
            let to = from.across(surface);
            let [level, goal] = [before, after].map(|mesh| surface.sign() * mesh.gap[0]);
            let change = (after.deflection - before.deflection) - (goal - level);
            let fraction = if change == 0.0 {
                1.0
            } else {
                ((level - before.deflection) / change).clamp(0.0, 1.0)
            };
            let rate = |mesh: MeshState| mesh.rate - surface.sign() * mesh.gap[1];
            let event = Event {
                cycle: trajectory.cycle,
                time: before.time + fraction * (after.time - before.time),
                from,
                to,
                surface,
                rate: rate(before) + fraction * (rate(after) - rate(before)),
            };
            changes.meet(&event, observer, counters)?;
            // I ∓ c g w: minus on entry, plus on release.
            let jump = if to.touching() { damping } else { -damping };
            for index in 0..tangents.count() {
                let tangent = tangents.vector_mut(index);
                let push = jump * dot(&direction.deflection, tangent);
                add_scaled(tangent, -push, &direction.mesh_input);
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
        mesh: MeshState,
        turned: &[[f64; 2]],
    ) {
        let (direction, middle) = (self.direction(j), self.middles[j]);
        let (k, c) = (middle.stiffness, self.segment(j).damping);
        let contact = trajectory.contact;
        if contact.touching() {
            let [gap, opening] = mesh.gap.map(|value| contact.sign() * value);
            let force = k * (mesh.deflection - gap) + c * (mesh.rate - opening);
            let push = -middle.impulse * force;
            add_scaled(&mut trajectory.state, push, &direction.mesh_input);
            for index in 0..tangents.count() {
                let tangent = tangents.vector_mut(index);
                let force =
                    k * dot(&direction.deflection, tangent) + c * dot(&direction.rate, tangent);
                add_scaled(tangent, -middle.impulse * force, &direction.mesh_input);
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
        [left, right]: [MeshState; 2],
        start: &[f64],
        observer: &mut O,
    ) {
        let (segment, stiffness) = (self.segment(j), self.middles[j].stiffness);
        let contact = trajectory.contact;
        let motion = [left, right].map(|mesh| [mesh.deflection, mesh.rate]);
        let deflection = hermite(motion[0], motion[1], self.step);
        let mut force = [0.0; 4];
        if contact.touching() {
            let rate = derivative(deflection, self.step);
            for i in 0..4 {
                force[i] = stiffness * deflection[i] + segment.damping * rate[i];
            }
            let gap = hermite(left.gap, right.gap, self.step);
            let opening = derivative(gap, self.step);
            for i in 0..4 {
                force[i] -= contact.sign() * (stiffness * gap[i] + segment.damping * opening[i]);
            }
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
    const FARTHEST: f64 = 1e6;

    type Workspace = SteppingWorkspace;

    fn workspace(&self) -> SteppingWorkspace {
        SteppingWorkspace {
            start: vec![0.0; self.directions[0].deflection.len()],
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
        for (turned, ripple) in workspace.turned.iter_mut().zip(&self.ripple) {
            let (sin, cos) = ripple.source.phase_at(trajectory.cycle, 0.0).sin_cos();
            *turned = [cos, sin];
        }
        let mut changes = Changes::new(self.event_limit);
        let mut last = self.mesh_state(&trajectory.state, 0, 0);
        let mut left = last;
        for j in 0..self.steps {
            if observer.called_off() {
                let cycle = trajectory.cycle;
                return Err(Stop::CalledOff { cycle });
            }
            if self.turns {
                if j > 0 {
                    let end = self.mesh_state(&trajectory.state, j - 1, 2 * j);
                    self.follow(
                        trajectory,
                        tangents,
                        j - 1,
                        [last, end],
                        &mut changes,
                        observer,
                        counters,
                    )?;
                    last = end;
                }
                last = self.turn(trajectory, j, last, &mut changes, observer, counters)?;
                left = last;
            }
            if O::WINDOWS {
                workspace.start.copy_from_slice(&trajectory.state);
            }
            self.half.advance(&mut trajectory.state);
            for index in 0..tangents.count() {
                self.half.advance_tangent(tangents.vector_mut(index));
            }
            let mesh = self.mesh_state(&trajectory.state, j, 2 * j + 1);
            self.follow(
                trajectory,
                tangents,
                j,
                [last, mesh],
                &mut changes,
                observer,
                counters,
            )?;
            self.kick(trajectory, tangents, j, mesh, &workspace.turned);
            self.half.advance(&mut trajectory.state);
            for index in 0..tangents.count() {
                self.half.advance_tangent(tangents.vector_mut(index));
            }
            if O::WINDOWS {
                let right = self.mesh_state(&trajectory.state, j, 2 * j + 2);
                self.show(trajectory, j, [left, right], &workspace.start, observer);
                left = right;
            }
            last = mesh;
        }
        // The contact state that goes into the next cycle is that of the state itself.
        let end = self.mesh_state(&trajectory.state, self.steps - 1, 2 * self.steps);
        let reach = end.deflection.abs() + end.rate.abs() * self.step;
        if reach.is_nan() || reach > Self::FARTHEST * self.half_gap {
            return Err(Stop::Diverged {
                cycle: trajectory.cycle,
            });
        }
        self.follow(
            trajectory,
            tangents,
            self.steps - 1,
            [last, end],
            &mut changes,
            observer,
            counters,
        )?;
        counters.cycles += 1;
        counters.windows += self.steps as u64;
        counters.tangent_windows += (self.steps * tangents.count()) as u64;
        trajectory.cycle += 1;
        Ok(())
    }
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
