//! The Taylor series of a trajectory on one step.

use super::DoubleDouble;
use super::root::evaluate;
use crate::model::{ActiveSet, Block, Line, MeshGain, Model, STIFFNESS_TERMS, Segment};

/// A model's blocks in extended precision, one list per direction.
#[derive(Debug, Clone)]
pub(super) struct Structure {
    directions: Vec<Vec<ExtendedBlock>>,
}

/// One block, `x' = A x − g F + s`. It contributes `w·x` to the deflection and `w A x` to its rate.
#[derive(Debug, Clone, Copy)]
struct ExtendedBlock {
    generator: [[f64; 2]; 2],
    mesh_input: [f64; 2],
    static_input: [f64; 2],
    deflection: [f64; 2],
    rate: [DoubleDouble; 2],
}

/// Start of a step.
pub(super) struct Instant<'a> {
    pub cycle: u64,
    /// Time within the mesh cycle \[s\].
    pub time: DoubleDouble,
    /// Elapsed time at the model's speed, as coefficients of `u` and its square \[s\].
    pub passed: [DoubleDouble; 2],
    /// The segment of every contact.
    pub segments: &'a [Segment],
    pub contact: ActiveSet,
}

/// Power series on a step in `u`, the fraction of its length.
pub(super) struct StepSeries {
    /// The order + 1 coefficients of each component of the state.
    states: Vec<Vec<DoubleDouble>>,
    /// Coefficients of δ along every line that a contact uses \[m\].
    pub deflections: Vec<Vec<DoubleDouble>>,
    /// Coefficients of the error of loaded flanks, for every contact \[m\]; a single 0 without such an error.
    pub gap_errors: Vec<Vec<DoubleDouble>>,
    /// Stiffness \[N/m\] and damping \[N s/m\] of every contact.
    laws: Vec<(Vec<DoubleDouble>, f64)>,
}

impl StepSeries {
    /// Coefficients of the push of a contact \[N\], `k (s δ − b) + c (s δ' − b')`, from the coefficients
    /// `indentation` of `s δ − b`, over a step of some length \[s\]. The result has one coefficient fewer than
    /// `indentation`.
    pub fn push(
        &self,
        contact: usize,
        indentation: &[DoubleDouble],
        length: DoubleDouble,
    ) -> Vec<DoubleDouble> {
        let (stiffness, damping) = &self.laws[contact];
        (1..indentation.len())
            .map(|next| {
                let rate = indentation[next] * next as f64 / length;
                let compressions = indentation[..next].iter().rev();
                (stiffness.iter().zip(compressions))
                    .fold(rate * *damping, |sum, (&k, &d)| sum + k * d)
            })
            .collect()
    }

    /// State at a fraction of the step.
    pub fn state_at(&self, fraction: DoubleDouble) -> Vec<DoubleDouble> {
        let at = |power: &Vec<DoubleDouble>| evaluate(power, fraction).0;
        self.states.iter().map(at).collect()
    }
}

impl Structure {
    pub fn new(model: &Model) -> Self {
        let extend = |(block, gain): (&Block, &MeshGain)| {
            let ([w1, w2], [a1, a2]) = (gain.deflection, block.generator);
            let entry =
                |i: usize| DoubleDouble::product(w1, a1[i]) + DoubleDouble::product(w2, a2[i]);
            ExtendedBlock {
                generator: block.generator,
                mesh_input: gain.mesh_input,
                static_input: block.static_input,
                deflection: gain.deflection,
                rate: [entry(0), entry(1)],
            }
        };
        let directions = (model.directions.iter())
            .map(|direction| {
                model
                    .blocks
                    .iter()
                    .zip(&direction.gains)
                    .map(extend)
                    .collect()
            })
            .collect();
        Self { directions }
    }

    /// Deflection \[m\] of a state along the line of a segment.
    pub fn deflection(
        &self,
        model: &Model,
        segment: &Segment,
        (cycle, time): (u64, DoubleDouble),
        state: &[DoubleDouble],
    ) -> DoubleDouble {
        let n = model.modes();
        let line = &model.lines[model.line(segment)];
        let error = error_harmonics(line, cycle, time, [DoubleDouble::ZERO; 2], 0);
        let blocks = self.directions[segment.direction].iter().enumerate();
        blocks.fold(-error[0], |sum, (i, block)| {
            sum + state[i] * block.deflection[0] + state[n + i] * block.deflection[1]
        })
    }

    /// The series of state and deflections from `state` over a step of the given length \[s\].
    pub fn expand(
        &self,
        model: &Model,
        instant: &Instant<'_>,
        state: &[DoubleDouble],
        length: DoubleDouble,
        order: usize,
    ) -> StepSeries {
        let n = model.modes();
        let ripple: Vec<_> = model
            .ripple
            .iter()
            .map(|r| {
                let whole = DoubleDouble::product(instant.cycle as f64, r.turns_per_cycle);
                let turns = whole - whole.floor();
                let phase = DoubleDouble::exact(r.phase)
                    + DoubleDouble::HALF_PI * 4.0 * turns
                    + instant.time * r.angular_frequency;
                (
                    cosine(phase, turns_by(instant.passed, r.angular_frequency), order),
                    &r.input,
                )
            })
            .collect();
        let errors: Vec<_> = (model.lines.iter())
            .map(|line| transmission_error(line, instant, length, order))
            .collect();
        let on_step = |segment: &Segment, series| on_step(model, instant, segment, series);
        let gap_errors: Vec<_> = (instant.segments.iter())
            .map(|segment| on_step(segment, segment.error.coefficients()))
            .collect();
        // Use one direction for every line that a contact has.
        let mut lines: Vec<(usize, usize)> = Vec::new();
        for segment in instant.segments {
            let line = model.line(segment);
            if lines.iter().all(|(known, _)| *known != line) {
                lines.push((line, segment.direction));
            }
        }
        let closed: Vec<_> = (instant.contact.iter())
            .map(|contact| {
                let segment = &instant.segments[contact];
                let mut gap = gap_errors[contact].clone();
                gap[0] += DoubleDouble::exact(model.contacts[contact].half_gap);
                ClosedSeries {
                    line: model.line(segment),
                    blocks: &self.directions[segment.direction],
                    side: model.contacts[contact].side,
                    damping: segment.damping,
                    stiffness: on_step(segment, segment.stiffness.coefficients()),
                    gap,
                    limit: model.contacts[contact].constant_force(segment),
                }
            })
            .collect();
        let mut states: Vec<Vec<_>> = state.iter().map(|&x| vec![x]).collect();
        let mut deflections = vec![Vec::new(); model.lines.len()];
        let mut rates = vec![DoubleDouble::ZERO; model.lines.len()];
        for j in 0..=order {
            for &(line, direction) in &lines {
                let (mut d, mut rate) = (-errors[line][j][0], -errors[line][j][1]);
                for (i, block) in self.directions[direction].iter().enumerate() {
                    let (x, y) = (states[i][j], states[n + i][j]);
                    d += x * block.deflection[0];
                    rate += y * block.rate[1];
                    // Both terms are zero for an uncoupled mode. Skipping them saves half the time.
                    if block.deflection[1] != 0.0 {
                        d += y * block.deflection[1];
                    }
                    if block.rate[0] != DoubleDouble::ZERO {
                        rate += x * block.rate[0];
                    }
                }
                deflections[line].push(d);
                rates[line] = rate;
            }
            if j == order {
                break;
            }
            let forces: Vec<_> = (closed.iter())
                .map(|contact| {
                    contact.force(j, &deflections[contact.line], rates[contact.line], length)
                })
                .collect();
            let scale = length / DoubleDouble::exact((j + 1) as f64);
            for (i, block) in self.directions[0].iter().enumerate() {
                let (x, y) = (states[i][j], states[n + i][j]);
                for part in 0..2 {
                    let [a, b] = block.generator[part];
                    let mut slope = y * b;
                    if a != 0.0 {
                        slope += x * a;
                    }
                    for (contact, force) in closed.iter().zip(&forces) {
                        let input = contact.blocks[i].mesh_input[part];
                        if input != 0.0 {
                            slope += *force * -input;
                        }
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
        let laws = (instant.segments.iter())
            .map(|segment| {
                let stiffness = on_step(segment, segment.stiffness.coefficients());
                (stiffness, segment.damping)
            })
            .collect();
        StepSeries {
            states,
            deflections,
            gap_errors,
            laws,
        }
    }
}

/// A closed contact on a step.
struct ClosedSeries<'a> {
    line: usize,
    blocks: &'a [ExtendedBlock],
    side: f64,
    damping: f64,
    stiffness: Vec<DoubleDouble>,
    /// The half gap plus the error of loaded flanks.
    gap: Vec<DoubleDouble>,
    /// Force of a slipping slider \[N\].
    limit: Option<f64>,
}

impl ClosedSeries<'_> {
    /// Coefficient j of the force, from the coefficients of the deflection up to j, and coefficient j of its
    /// rate.
    fn force(
        &self,
        j: usize,
        deflection: &[DoubleDouble],
        mut rate: DoubleDouble,
        length: DoubleDouble,
    ) -> DoubleDouble {
        if let Some(limit) = self.limit {
            return DoubleDouble::exact(if j == 0 { limit } else { 0.0 });
        }
        if let Some(&next) = self.gap.get(j + 1) {
            rate += next * (-self.side * (j + 1) as f64) / length;
        }
        let mut force = rate * self.damping;
        for (m, &k) in self.stiffness.iter().enumerate().take(j + 1) {
            let mut compression = deflection[j - m];
            if let Some(&gap) = self.gap.get(j - m) {
                compression += gap * -self.side;
            }
            force += compression * k;
        }
        force
    }
}

/// Converts a Legendre series over the segment to a power series on the step. The position within the segment
/// is `x = x₀ + σ₁ u + σ₂ u²`. The coefficients of `Σ a_n P_n(x)` follow by Legendre's recurrence.
fn on_step(
    model: &Model,
    instant: &Instant<'_>,
    segment: &Segment,
    series: &[f64; STIFFNESS_TERMS],
) -> Vec<DoubleDouble> {
    let terms = series.iter().rposition(|&a| a != 0.0).map_or(1, |n| n + 1);
    let one = DoubleDouble::ONE;
    let (start, end) = (
        DoubleDouble::exact(segment.start),
        DoubleDouble::exact(segment.end),
    );
    let width = end - start;
    let period = DoubleDouble::exact(model.period());
    let x = (instant.time / period - start) * 2.0 / width - one;
    let places = instant.passed.map(|passed| passed * 2.0 / (period * width));
    let place = [x, places[0], places[1]];
    let even = places[1].value() == 0.0;
    let length = if even { terms } else { 2 * terms - 1 };
    // polynomials[n][m]: coefficient m of P_n(x(u)).
    let mut polynomials = vec![vec![DoubleDouble::ZERO; length]; terms];
    polynomials[0][0] = one;
    for n in 1..terms {
        let k = n as f64;
        for m in 0..length {
            let mut value = DoubleDouble::ZERO;
            for (power, factor) in place.iter().enumerate().take(m + 1) {
                value += polynomials[n - 1][m - power] * *factor;
            }
            value = value * (2.0 * k - 1.0);
            if n > 1 {
                value = value - polynomials[n - 2][m] * (k - 1.0);
            }
            polynomials[n][m] = value / DoubleDouble::exact(k);
        }
    }
    (0..length)
        .map(|m| {
            let column = polynomials.iter().zip(series);
            column.fold(DoubleDouble::ZERO, |sum, (p, &a)| sum + p[m] * a)
        })
        .collect()
}

/// Coefficients of the transmission error of a line and of its rate over a step of some length \[s\].
fn transmission_error(
    line: &Line,
    instant: &Instant<'_>,
    length: DoubleDouble,
    order: usize,
) -> Vec<[DoubleDouble; 2]> {
    let error = error_harmonics(line, instant.cycle, instant.time, instant.passed, order + 1);
    let pairs = error.windows(2).enumerate();
    pairs
        .map(|(j, pair)| [pair[0], pair[1] * (j + 1) as f64 / length])
        .collect()
}

/// Coefficients of the transmission error of a line.
fn error_harmonics(
    line: &Line,
    cycle: u64,
    time: DoubleDouble,
    passed: [DoubleDouble; 2],
    order: usize,
) -> Vec<DoubleDouble> {
    let mut sum = vec![DoubleDouble::ZERO; order + 1];
    for h in &line.transmission_error {
        let whole = DoubleDouble::product(cycle as f64, h.turns_per_cycle);
        let turns = whole - whole.floor();
        let omega = h.angular_frequency;
        let phase =
            DoubleDouble::HALF_PI * 4.0 * turns + time * omega + DoubleDouble::exact(h.phase);
        let value = cosine(phase, turns_by(passed, omega), order);
        for (entry, value) in sum.iter_mut().zip(value) {
            *entry += value * h.amplitude;
        }
    }
    sum
}

/// Change of the phase of a harmonic with an angular frequency \[rad/s\] on a step, as coefficients of `u`
/// and its square.
fn turns_by(passed: [DoubleDouble; 2], omega: f64) -> [DoubleDouble; 2] {
    passed.map(|passed| passed * omega)
}

/// Coefficients of `cos φ` with `φ = phase + first u + second u²`, by recurrence from `(cos φ)' = −φ' sin φ`
/// and `(sin φ)' = φ' cos φ`.
fn cosine(
    phase: DoubleDouble,
    [first, second]: [DoubleDouble; 2],
    order: usize,
) -> Vec<DoubleDouble> {
    let (sin, cos) = phase.sin_cos();
    let (mut sines, mut cosines) = (vec![sin], vec![cos]);
    for j in 0..order {
        let slope = |terms: &[DoubleDouble]| {
            let further = j.checked_sub(1).map(|before| terms[before] * 2.0 * second);
            let sum = terms[j] * first + further.unwrap_or(DoubleDouble::ZERO);
            sum / DoubleDouble::exact((j + 1) as f64)
        };
        let (c, s) = (-slope(&sines), slope(&cosines));
        cosines.push(c);
        sines.push(s);
    }
    cosines
}
