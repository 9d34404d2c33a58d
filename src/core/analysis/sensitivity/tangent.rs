//! How does a trajectory change with a parameter?
//!
//! On a window, the derivative `y = ∂x/∂p` at fixed mesh phase obeys the equation of a tangent with
//! additional terms on the right. With T the mesh period,
//!
//! ```text
//! y'  = A y − Σ g f + A_p x + s_p + Σ r_p cos(…) − Σ g_p F + (T_p/T) x'
//! δ_p = Σ w y + w_p x − e_p
//! f   = F_p = k δ_p + c δ_p' + k_p (δ − s b) + c_p (δ' − s b') − k s b_p − c s (b_p)' − c (T_p/T) (δ' − s b')
//! ```
//!
//! The last term appears because all times of a window are proportional to T at fixed phase. A kernel's
//! window has x at its start, and δ and F as series. The series of x and y follow from these, and f from a
//! Volterra equation like that of the trajectory. If a contact closes or opens on its surface, y jumps by
//! `∓ c g (δ_p − s b_p)`. This is the saltation of a tangent, including the motion of the surface. If a
//! segment of a closed contact ends at a phase φ that depends on the parameter, y jumps by `(f⁻ − f⁺) T φ_p`,
//! with f the vector field.
//!
//! Only a kernel's windows and events are used, so that any exact kernel is suitable.

use super::derivative_observer::{DerivativeObserver, WindowDerivative};
use super::impulse::{IMPULSE_RESPONSE_TERMS, impulse_response, push};
use crate::analysis::modal_series::{Series, TERMS, cosine_series, padded};
use crate::model::{Block, Contact, Model, ModelDerivative, Segment};
use crate::numerics::convolution::convolution24;
use crate::numerics::legendre::{at_end, at_start, derivative, evaluate, transforms24};
use crate::numerics::linalg::solve;
use crate::numerics::pair_response::{PairResponse, PairSeries};
use crate::propagate::{Event, Observer, Window};
use faer::Mat;
use num_complex::Complex64;
use std::f64::consts::FRAC_PI_2;

/// Largest margin, relative to the half gap, of an event at which a contact opens or closes on its surface.
/// At an event with a larger margin, the force vanishes, or the gap or the line changes in a step.
const ON_SURFACE: f64 = 1e-7;

/// The derivative of a trajectory with respect to a parameter, window after window.
#[derive(Debug)]
pub struct ParameterTangent<'m, W> {
    model: &'m Model,
    by: &'m Model,
    /// Entries `(row, column, value)` of the derivative of the generator between different blocks.
    between_blocks: Vec<(usize, usize, f64)>,
    derivative: &'m ModelDerivative,
    /// y, first components of all blocks, then second ones.
    state: Vec<f64>,
    /// T_p/T.
    stretch: f64,
    /// x at the end of the last window.
    end: Vec<f64>,
    /// Closed contacts of the last window, with their segment and force at its end.
    closed: Vec<(usize, Segment, f64)>,
    cycle: u64,
    time: f64,
    /// Observes every window.
    pub witness: W,
}

/// A closed contact on a window.
struct Closed<'a> {
    contact: &'a Contact,
    by: &'a Contact,
    segment: Segment,
    change: &'a Segment,
    direction: usize,
    index: usize,
    deflection: Series,
    force: Series,
}

impl<'m, W: DerivativeObserver> ParameterTangent<'m, W> {
    /// The derivative of a trajectory that starts at `x`, with the initial value y = `start` (both of length
    /// 2N). `by` is the derivative of the model with respect to the parameter ([`Model::combined`]).
    pub fn new(
        model: &'m Model,
        by: &'m ModelDerivative,
        x: &[f64],
        start: Vec<f64>,
        witness: W,
    ) -> Self {
        Self {
            model,
            by: &by.numbers,
            between_blocks: by.entries_between_blocks(),
            derivative: by,
            state: start,
            stretch: by.numbers.period() / model.period(),
            end: x.to_vec(),
            closed: Vec::new(),
            cycle: 0,
            time: 0.0,
            witness,
        }
    }

    /// The derivative of a trajectory whose initial state has the components `x` at every value of the parameter. The
    /// basis of the components depends on the parameter. [`Self::numbers`] gives their derivative at later times.
    pub fn of_equal_numbers(
        model: &'m Model,
        by: &'m ModelDerivative,
        x: &[f64],
        witness: W,
    ) -> Self {
        Self::new(model, by, x, by.turned(x), witness)
    }

    /// y at the end of the last window.
    pub fn state(&self) -> &[f64] {
        &self.state
    }

    /// The derivative of the state's components at the end of the last window, in the basis that depends on the
    /// parameter.
    pub fn numbers(&self) -> Vec<f64> {
        let turned = self.derivative.turned(&self.end);
        self.state.iter().zip(turned).map(|(y, t)| y - t).collect()
    }

    /// The closed contacts of a window with their derivatives.
    fn closed_on(&self, window: &Window<'_>) -> Vec<Closed<'m>> {
        let (model, change, cycle) = (self.model, self.by, window.cycle);
        (window.closed.iter())
            .map(|shown| {
                let contact = &model.contacts[shown.contact];
                let by = &change.contacts[shown.contact];
                let segment = window.segments[shown.contact];
                let segments = contact.cycle(cycle).segments.iter();
                let place = segments
                    .clone()
                    .position(|s| s.start == segment.start)
                    .unwrap_or(0);
                Closed {
                    contact,
                    by,
                    segment,
                    change: &by.cycle(cycle).segments[place],
                    direction: segment.direction,
                    index: shown.contact,
                    deflection: padded(shown.deflection),
                    force: padded(shown.force),
                }
            })
            .collect()
    }

    /// Derivative of the deflection along a direction, from the series of blocks and of their derivatives.
    fn along(
        &self,
        direction: usize,
        window: &Window<'_>,
        x: &[PairSeries<TERMS>],
        y: &[PairSeries<TERMS>],
    ) -> Series {
        let (direction, derivative) = (
            &self.model.directions[direction],
            &self.by.directions[direction],
        );
        let mut out = [0.0; TERMS];
        for (i, (gain, change)) in direction.gains.iter().zip(&derivative.gains).enumerate() {
            for row in 0..2 {
                let (w, w_p) = (gain.deflection[row], change.deflection[row]);
                for n in 0..TERMS {
                    out[n] += w * y[i][row][n] + w_p * x[i][row][n];
                }
            }
        }
        let line = &self.model.lines[direction.line].transmission_error;
        for (h, change) in line
            .iter()
            .zip(&self.by.lines[direction.line].transmission_error)
        {
            let phase = h.turned(window.cycle, window.start) + h.phase;
            let [cos, sin] = [0.0, -FRAC_PI_2]
                .map(|turn| cosine_series(h.angular_frequency, phase + turn, window.duration));
            for n in 0..TERMS {
                out[n] -= change.amplitude * cos[n] - h.amplitude * change.phase * sin[n];
            }
        }
        out
    }

    fn pass(&mut self, window: &Window<'_>) {
        let (tau, n) = (window.duration, self.model.modes());
        let closed = self.closed_on(window);
        self.cross_breakpoints(&closed);
        let ripples: Vec<[Series; 2]> = (self.model.ripple.iter())
            .map(|ripple| {
                let phase = ripple.phase_at(window.cycle, window.start);
                [0.0, -FRAC_PI_2]
                    .map(|turn| cosine_series(ripple.angular_frequency, phase + turn, tau))
            })
            .collect();
        let mut responses = Vec::with_capacity(n);
        let mut x: Vec<PairSeries<TERMS>> = Vec::with_capacity(n);
        let mut sources: Vec<PairSeries<TERMS>> = Vec::with_capacity(n);
        for (i, (block, by)) in self.model.blocks.iter().zip(&self.by.blocks).enumerate() {
            let response = PairResponse::new(&block.generator, tau);
            let mut input = [[0.0; TERMS]; 2];
            let mut source = [[0.0; TERMS]; 2];
            for row in 0..2 {
                input[row][0] += block.static_input[row];
                source[row][0] += by.static_input[row];
                for ((ripple, change), [cos, sin]) in
                    self.model.ripple.iter().zip(&self.by.ripple).zip(&ripples)
                {
                    let (r, r_p) = (ripple.input[i][row], change.input[i][row]);
                    for m in 0..TERMS {
                        input[row][m] += r * cos[m];
                        source[row][m] += r_p * cos[m] - r * change.phase * sin[m];
                    }
                }
                for contact in &closed {
                    let g = self.model.directions[contact.direction].gains[i].mesh_input[row];
                    let g_p = self.by.directions[contact.direction].gains[i].mesh_input[row];
                    for m in 0..TERMS {
                        input[row][m] -= g * contact.force[m];
                        source[row][m] -= g_p * contact.force[m];
                    }
                }
            }
            let motion = response.to([window.first[i], window.second[i]], &input);
            for row in 0..2 {
                let (a, a_p) = (block.generator[row], by.generator[row]);
                for m in 0..TERMS {
                    let rate = a[0] * motion[0][m] + a[1] * motion[1][m] + input[row][m];
                    source[row][m] +=
                        a_p[0] * motion[0][m] + a_p[1] * motion[1][m] + self.stretch * rate;
                }
            }
            x.push(motion);
            sources.push(source);
            responses.push(response);
        }
        for &(row, column, rate) in &self.between_blocks {
            let motion = &x[column % n][column / n];
            let source = &mut sources[row % n][row / n];
            for m in 0..TERMS {
                source[m] += rate * motion[m];
            }
        }
        let free: Vec<PairSeries<TERMS>> = (responses.iter().zip(&sources).enumerate())
            .map(|(i, (response, source))| response.to([self.state[i], self.state[n + i]], source))
            .collect();
        let forces = self.forces(window, &closed, &x, &free);
        let mut y = free;
        if !closed.is_empty() {
            for (i, source) in sources.iter_mut().enumerate() {
                for (contact, force) in closed.iter().zip(&forces) {
                    let g = self.model.directions[contact.direction].gains[i].mesh_input;
                    for row in 0..2 {
                        for m in 0..TERMS {
                            source[row][m] -= g[row] * force[m];
                        }
                    }
                }
                y[i] = responses[i].to([self.state[i], self.state[n + i]], source);
            }
        }
        let deflection = self.along(window.segments[0].direction, window, &x, &y);
        let mut force = [0.0; TERMS];
        let of_mesh = closed
            .iter()
            .zip(&forces)
            .filter(|(c, _)| self.model.of_mesh(c.index));
        for (_, series) in of_mesh {
            for m in 0..TERMS {
                force[m] += series[m];
            }
        }
        let ends = closed
            .iter()
            .map(|c| (c.index, c.segment, at_end(&c.force)))
            .collect();
        for i in 0..n {
            for row in 0..2 {
                self.state[row * n + i] = at_end(&y[i][row]);
                self.end[row * n + i] = at_end(&x[i][row]);
            }
        }
        self.closed = ends;
        self.cycle = window.cycle;
        self.time = window.start + tau;
        self.witness.window(&WindowDerivative {
            window,
            deflection: &deflection,
            force: &force,
        });
    }

    /// Adds the jumps of y at the phases where closed contacts pass from one segment to the next, if these
    /// phases depend on the parameter.
    fn cross_breakpoints(&mut self, closed: &[Closed<'_>]) {
        let n = self.model.modes();
        let mut kicks: Vec<(usize, f64)> = Vec::new();
        let mut jumps: Vec<(f64, f64)> = Vec::new();
        for contact in closed {
            let Some((_, before, force)) = self
                .closed
                .iter()
                .find(|(index, ..)| *index == contact.index)
            else {
                continue;
            };
            let moved = self.model.period() * contact.change.start;
            if *before != contact.segment && moved != 0.0 && contact.segment.start != 0.0 {
                // y jumps by (f⁻ − f⁺) · moved; f contains −g F.
                kicks.push((before.direction, -force * moved));
                kicks.push((contact.direction, at_start(&contact.force) * moved));
                if self.model.of_mesh(contact.index) {
                    jumps.push((moved, at_start(&contact.force) - force));
                }
            }
        }
        for (direction, kick) in kicks {
            push(&self.model.directions[direction], kick, n, &mut self.state);
        }
        for (moved, force_jump) in jumps {
            self.witness.jump(self.cycle, self.time, moved, force_jump);
        }
    }

    /// f of every closed contact.
    fn forces(
        &self,
        window: &Window<'_>,
        closed: &[Closed<'_>],
        x: &[PairSeries<TERMS>],
        free: &[PairSeries<TERMS>],
    ) -> Vec<Series> {
        if closed.is_empty() {
            return Vec::new();
        }
        let tau = window.duration;
        let period = self.model.period();
        let order = closed.len() * TERMS;
        let mut exponentials = vec![[Complex64::ZERO; IMPULSE_RESPONSE_TERMS]; self.model.modes()];
        Block::exponentials(&self.model.blocks, tau, &mut exponentials);
        let mut system = Mat::<f64>::identity(order, order);
        let mut right = vec![0.0; order];
        for (i, contact) in closed.iter().enumerate() {
            let nodes = transforms24().nodes();
            let phase = |x: f64| (window.start + 0.5 * tau * (1.0 + x)) / period;
            let stiffness: Series =
                std::array::from_fn(|j| contact.segment.stiffness_at(phase(nodes[j])));
            let c = contact.segment.damping;
            let law = |series: &Series| -> Series {
                let rate = derivative(series);
                let values = std::array::from_fn(|j| stiffness[j] * evaluate(series, nodes[j]));
                let mut out = transforms24().interpolate(&values);
                for m in 0..TERMS {
                    out[m] += c * 2.0 / tau * rate[m];
                }
                out
            };
            for (j, other) in closed.iter().enumerate() {
                let [observed, pushed] =
                    [contact, other].map(|c| &self.model.directions[c.direction]);
                let kernel =
                    impulse_response(&self.model.blocks, [observed, pushed], &exponentials);
                for (m, column) in convolution24().operator(&kernel, tau).iter().enumerate() {
                    for (n, value) in law(column).into_iter().enumerate() {
                        system[(i * TERMS + n, j * TERMS + m)] += value;
                    }
                }
            }
            let mut right_side = law(&self.along(contact.direction, window, x, free));
            let source = self.source(contact, &stiffness, phase, tau);
            for m in 0..TERMS {
                right_side[m] += source[m];
            }
            right[i * TERMS..][..TERMS].copy_from_slice(&right_side);
        }
        let solved = solve(system.as_ref(), &right);
        solved.chunks_exact(TERMS).map(padded).collect()
    }

    /// Contribution of the change of a closed contact's law to f.
    fn source(
        &self,
        contact: &Closed<'_>,
        stiffness: &Series,
        phase: impl Fn(f64) -> f64,
        tau: f64,
    ) -> Series {
        let nodes = transforms24().nodes();
        let side = contact.contact.side;
        let gap: Series = std::array::from_fn(|j| {
            contact.contact.half_gap + contact.segment.error_at(phase(nodes[j]))[0]
        });
        let gap = transforms24().interpolate(&gap);
        let changes: [[f64; 2]; TERMS] =
            std::array::from_fn(|j| contact.segment.change_at(contact.change, phase(nodes[j])));
        let widened =
            transforms24().interpolate(&changes.map(|[_, error]| contact.by.half_gap + error));
        let stretch: Series = std::array::from_fn(|m| contact.deflection[m] - side * gap[m]);
        let squeeze = derivative(&stretch);
        let widening = derivative(&widened);
        let values = std::array::from_fn(|j| {
            changes[j][0] * evaluate(&stretch, nodes[j])
                - stiffness[j] * side * evaluate(&widened, nodes[j])
        });
        let mut out = transforms24().interpolate(&values);
        let (c, c_p) = (contact.segment.damping, contact.change.damping);
        for m in 0..TERMS {
            out[m] += 2.0 / tau * ((c_p - c * self.stretch) * squeeze[m] - c * side * widening[m]);
        }
        out
    }

    /// δ_p − s b_p of a contact at its event, and the margin of the contact at the event.
    fn at_event(&self, event: &Event) -> (f64, f64) {
        let n = self.model.modes();
        let contact = &self.model.contacts[event.contact];
        let by = &self.by.contacts[event.contact];
        let cycle = contact.cycle(event.cycle);
        let phase = event.time / cycle.period;
        let place = (cycle.segments.iter())
            .position(|s| phase < s.end)
            .unwrap_or(cycle.segments.len() - 1);
        let (segment, change) = (
            &cycle.segments[place],
            &by.cycle(event.cycle).segments[place],
        );
        let (deflection, _) = self
            .model
            .deflection_on(segment, event.cycle, &self.end, event.time);
        let [gap, _] = contact.gap(segment, event.time);
        let direction = &self.model.directions[segment.direction];
        let mut moved = 0.0;
        for (i, (gain, change)) in direction
            .gains
            .iter()
            .zip(&self.by.directions[segment.direction].gains)
            .enumerate()
        {
            for row in 0..2 {
                moved += gain.deflection[row] * self.state[row * n + i]
                    + change.deflection[row] * self.end[row * n + i];
            }
        }
        let line = &self.model.lines[direction.line].transmission_error;
        for (h, change) in line
            .iter()
            .zip(&self.by.lines[direction.line].transmission_error)
        {
            let (sin, cos) = (h.turned(event.cycle, event.time) + h.phase).sin_cos();
            moved -= change.amplitude * cos - h.amplitude * change.phase * sin;
        }
        moved -= contact.side * (by.half_gap + segment.change_at(change, phase)[1]);
        let margin = (contact.side * deflection - gap) / self.model.half_gap;
        (moved, margin)
    }
}

impl<W: DerivativeObserver> Observer for ParameterTangent<'_, W> {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        self.pass(window);
    }

    fn event(&mut self, event: &Event) {
        let (moved, margin) = self.at_event(event);
        if margin.abs() > ON_SURFACE {
            return;
        }
        let n = self.model.modes();
        let mut force_jump = 0.0;
        for contact in event.changed() {
            let cycle = self.model.contacts[contact].cycle(event.cycle);
            let segment = cycle.segment_at(event.time);
            let closes = event.to.holds(contact);
            let damping = if closes { -segment.damping } else { segment.damping };
            let direction = &self.model.directions[segment.direction];
            push(direction, damping * moved, n, &mut self.state);
            if self.model.of_mesh(contact) {
                force_jump -= damping * event.rate;
            }
        }
        // The surface is reached later by −(δ_p − s b_p)/(δ' − s b').
        self.witness
            .jump(event.cycle, event.time, -moved / event.rate, force_jump);
    }
}
