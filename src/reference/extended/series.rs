//! The Taylor series of a trajectory on one step.

use super::DoubleDouble;
use super::root::evaluate;
use crate::model::{Contact, Model, Segment};

/// A model's blocks in extended precision, structure of arrays with one entry a block.
#[derive(Debug, Clone)]
pub(super) struct Structure {
    blocks: Vec<ExtendedBlock>,
}

/// One block: `x' = A x − g F + s`, `w·x` to the deflection, `w A x` to its rate.
#[derive(Debug, Clone, Copy)]
struct ExtendedBlock {
    generator: [[f64; 2]; 2],
    mesh_input: [f64; 2],
    static_input: [f64; 2],
    deflection: [f64; 2],
    rate: [DoubleDouble; 2],
}

/// Where and how a step starts.
pub(super) struct Instant<'a> {
    pub cycle: u64,
    /// Time within the mesh cycle \[s\].
    pub time: DoubleDouble,
    pub segment: &'a Segment,
    pub contact: Contact,
}

/// Coefficients on a step in `u`, the fraction of its length.
pub(super) struct StepSeries {
    /// Of each component of the state, order + 1 each.
    states: Vec<Vec<DoubleDouble>>,
    /// Of δ \[m\].
    pub deflection: Vec<DoubleDouble>,
}

impl StepSeries {
    /// State at a fraction of the step.
    pub fn state_at(&self, fraction: DoubleDouble) -> Vec<DoubleDouble> {
        let at = |power: &Vec<DoubleDouble>| evaluate(power, fraction).0;
        self.states.iter().map(at).collect()
    }
}

impl Structure {
    pub fn new(model: &Model) -> Self {
        let blocks = model
            .blocks
            .iter()
            .map(|b| {
                let ([w1, w2], [a1, a2]) = (b.deflection, b.generator);
                let entry =
                    |i: usize| DoubleDouble::product(w1, a1[i]) + DoubleDouble::product(w2, a2[i]);
                ExtendedBlock {
                    generator: b.generator,
                    mesh_input: b.mesh_input,
                    static_input: b.static_input,
                    deflection: b.deflection,
                    rate: [entry(0), entry(1)],
                }
            })
            .collect();
        Self { blocks }
    }

    /// The series of state and deflection from `state` over a step of the given length \[s\].
    pub fn expand(
        &self,
        model: &Model,
        instant: &Instant<'_>,
        state: &[DoubleDouble],
        length: DoubleDouble,
        order: usize,
    ) -> StepSeries {
        let n = self.blocks.len();
        let error = transmission_error(model, instant.time, length, order);
        let ripple: Vec<_> = model
            .ripple
            .iter()
            .map(|r| {
                let whole = DoubleDouble::product(instant.cycle as f64, r.turns_per_cycle);
                let turns = whole - whole.floor();
                let phase = DoubleDouble::exact(r.phase)
                    + DoubleDouble::HALF_PI * 4.0 * turns
                    + instant.time * r.angular_frequency;
                (cosine(phase, length * r.angular_frequency, order), &r.input)
            })
            .collect();

        let touching = instant.contact.touching();
        let (k, c) = (instant.segment.stiffness, instant.segment.damping);
        let offset = DoubleDouble::product(instant.contact.sign(), model.half_gap);
        let mut states: Vec<Vec<_>> = state.iter().map(|&x| vec![x]).collect();
        let mut deflection = Vec::with_capacity(order + 1);
        for j in 0..=order {
            let (mut d, mut rate) = (-error[j][0], -error[j][1]);
            for (i, block) in self.blocks.iter().enumerate() {
                let (x, y) = (states[i][j], states[n + i][j]);
                d += x * block.deflection[0];
                rate += y * block.rate[1];
                // Both are zero for a mode; adding them would cost half the time.
                if block.deflection[1] != 0.0 {
                    d += y * block.deflection[1];
                }
                if block.rate[0] != DoubleDouble::ZERO {
                    rate += x * block.rate[0];
                }
            }
            deflection.push(d);
            if j == order {
                break;
            }
            let mut force = DoubleDouble::ZERO;
            if touching {
                let compression = if j == 0 { d - offset } else { d };
                force = compression * k + rate * c;
            }
            let scale = length / DoubleDouble::exact((j + 1) as f64);
            for (i, block) in self.blocks.iter().enumerate() {
                let (x, y) = (states[i][j], states[n + i][j]);
                for part in 0..2 {
                    let [a, b] = block.generator[part];
                    let mut slope = y * b;
                    if a != 0.0 {
                        slope += x * a;
                    }
                    if block.mesh_input[part] != 0.0 {
                        slope += force * -block.mesh_input[part];
                    }
                    if j == 0 {
                        slope += DoubleDouble::exact(block.static_input[part]);
                    }
                    for (wave, input) in &ripple {
                        slope += wave[j] * input[i][part];
                    }
                    states[part * n + i].push(slope * scale);
                }
            }
        }
        StepSeries { states, deflection }
    }
}

/// Coefficients of the static transmission error and of its rate.
fn transmission_error(
    model: &Model,
    time: DoubleDouble,
    length: DoubleDouble,
    order: usize,
) -> Vec<[DoubleDouble; 2]> {
    let mut sum = vec![[DoubleDouble::ZERO; 2]; order + 1];
    for h in &model.transmission_error {
        let omega = h.angular_frequency;
        let phase = time * omega + DoubleDouble::exact(h.phase);
        // −sin φ is the cosine a quarter turn later.
        let value = cosine(phase, length * omega, order);
        let rate = cosine(phase + DoubleDouble::HALF_PI, length * omega, order);
        let speed = DoubleDouble::product(h.amplitude, omega);
        for (j, entry) in sum.iter_mut().enumerate() {
            entry[0] += value[j] * h.amplitude;
            entry[1] += rate[j] * speed;
        }
    }
    sum
}

/// Coefficients of `cos(phase + turn u)`.
fn cosine(phase: DoubleDouble, turn: DoubleDouble, order: usize) -> Vec<DoubleDouble> {
    let (sin, cos) = phase.sin_cos();
    let derivatives = [cos, -sin, -cos, sin];
    let mut power = DoubleDouble::ONE;
    (0..=order)
        .map(|j| {
            let coefficient = power * derivatives[j % 4];
            power = power * turn / DoubleDouble::exact((j + 1) as f64);
            coefficient
        })
        .collect()
}
