//! The excitation of a system at one operating point, and its steady responses.
//!
//! Inputs are 1 and (cos θ, sin θ) of each frequency of loads and transmission errors. The state of a system is
//! `z = y + Σ steady · inputs`, with `y' = G y`. The rest positions of very slow blocks are far away; these
//! blocks keep their constant input.

use super::basis::{Basis, padded};
use super::lanes::{self, FACTORS};
use super::sets::ContactClass;
use crate::model::{Block, DRIFT, Model, turned};
use crate::propagate::TableError;
use num_complex::{Complex64, c64};

/// Smallest `|det(iω I − G)|` of a block without resonance, relative to `ω₀² + ω²`; ω₀ is its natural
/// frequency.
const RESONANCE: f64 = 1e-7;

/// The frequencies of a model's excitation.
#[derive(Debug)]
pub struct Frequencies {
    /// Each frequency with its turns per mesh cycle, (rad/s, 1).
    pub all: Vec<[f64; 2]>,
}

impl Frequencies {
    /// The distinct frequencies of a model.
    pub fn new(model: &Model) -> Self {
        let load_frequencies =
            (model.ripple.iter()).map(|r| [r.angular_frequency, r.turns_per_cycle]);
        let error_frequencies =
            (model.transmission_errors()).map(|h| [h.angular_frequency, h.turns_per_cycle]);
        let mut all: Vec<[f64; 2]> = Vec::new();
        for frequency in load_frequencies.chain(error_frequencies) {
            if !all.contains(&frequency) {
                all.push(frequency);
            }
        }
        Self { all }
    }

    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        1 + 2 * self.all.len()
    }

    /// Writes the inputs' values at a time \[s\] of a mesh cycle.
    #[inline]
    pub fn write(&self, cycle: u64, time: f64, out: &mut [f64]) {
        out[0] = 1.0;
        for (pair, &[angular, turns]) in out[1..].chunks_exact_mut(2).zip(&self.all) {
            let (sin, cos) = turned(angular, turns, cycle, time).sin_cos();
            pair.copy_from_slice(&[cos, sin]);
        }
    }

    /// Advances the inputs' values by a time for which `turns` are (cos, sin) of all frequencies.
    #[inline]
    pub fn turn(turns: &[[f64; 2]], inputs: &mut [f64]) {
        for (pair, turn) in inputs[1..].chunks_exact_mut(2).zip(turns) {
            pair.copy_from_slice(&turned_over([pair[0], pair[1]], *turn));
        }
    }

    /// The inputs' values at another time: after the turns up to a node, if given, and after a time `rest` \[s\] as
    /// short as [`super::lanes::SHORT`], which may be negative.
    #[inline(always)]
    pub fn turn_to(&self, node: Option<&[[f64; 2]]>, rest: f64, inputs: &[f64], out: &mut [f64]) {
        let (pairs, out) = (
            inputs[1..].as_chunks::<2>().0,
            out[1..].as_chunks_mut::<2>().0,
        );
        for (h, [angular, _]) in self.all.iter().enumerate() {
            let there = match node {
                Some(turns) => turned_over(pairs[h], turns[h]),
                None => pairs[h],
            };
            out[h] = turned_by(there, angular * rest);
        }
    }

    /// Advances the inputs' values by a time as short as [`super::lanes::LITTLE`].
    #[inline(always)]
    pub fn turn_a_little(&self, time: f64, inputs: &mut [f64]) {
        let pairs = inputs[1..].as_chunks_mut::<2>().0;
        for (h, [angular, _]) in self.all.iter().enumerate() {
            let x = angular * time;
            pairs[h] = turned_over(pairs[h], [1.0 - 0.5 * x * x, x - x * x * x / 6.0]);
        }
    }

    /// (cos, sin) of all frequencies over a time \[s\].
    pub fn turns(&self, time: f64) -> Vec<[f64; 2]> {
        let over = |&[angular, _]: &[f64; 2]| {
            let (sin, cos) = (angular * time).sin_cos();
            [cos, sin]
        };
        self.all.iter().map(over).collect()
    }

    fn place(&self, frequency: [f64; 2]) -> usize {
        (self.all.iter().position(|known| *known == frequency)).unwrap_or(0)
    }
}

/// Cosine and sine of an angle that increases by x \[rad\]; |x| is below 1/2.
#[inline(always)]
fn turned_by(pair: [f64; 2], x: f64) -> [f64; 2] {
    let square = -x * x;
    let (mut cos, mut sin) = (FACTORS[2 * lanes::TERMS - 2], FACTORS[2 * lanes::TERMS - 1]);
    for k in (0..lanes::TERMS - 1).rev() {
        cos = FACTORS[2 * k] + square * cos;
        sin = FACTORS[2 * k + 1] + square * sin;
    }
    turned_over(pair, [cos, x * sin])
}

/// Cosine and sine of an angle increased by another, which is given by its cosine and sine.
#[inline(always)]
fn turned_over([c, s]: [f64; 2], [cos, sin]: [f64; 2]) -> [f64; 2] {
    [c * cos - s * sin, s * cos + c * sin]
}

/// Transmission error of a line as amplitudes of all frequencies, `e = Re Σ e_h e^{iθ_h}` \[m\].
pub fn error_amplitudes(model: &Model, line: usize, frequencies: &Frequencies) -> Vec<Complex64> {
    let mut out = vec![Complex64::ZERO; frequencies.all.len()];
    for h in &model.lines[line].transmission_error {
        let place = frequencies.place([h.angular_frequency, h.turns_per_cycle]);
        out[place] += h.amplitude * Complex64::cis(h.phase);
    }
    out
}

/// A block that a constant input moves without limit, or to a distant rest position.
#[derive(Debug, Clone, Copy)]
pub struct Drift {
    /// Index of the block.
    pub lane: usize,
    /// Generator \[1/s\].
    pub generator: [[f64; 2]; 2],
    /// Constant input.
    pub input: [f64; 2],
    /// Number of significant terms of the series of its integral.
    pub terms: usize,
}

/// Largest number of terms of the series of a drift's integral. It suffices for times in which the block turns by
/// [`super::lanes::SHORT`].
const TERMS: usize = 16;

/// `1/(k + 2)`.
const INTEGRAL_SHARES: [f64; TERMS] = {
    let mut shares = [0.0; TERMS];
    let mut k = 0;
    while k < TERMS {
        shares[k] = 1.0 / (k + 2) as f64;
        k += 1;
    }
    shares
};

impl Drift {
    /// A block with its constant input.
    pub fn new(lane: usize, generator: [[f64; 2]; 2], input: [f64; 2]) -> Self {
        let [[a, b], [c, d]] = generator;
        let square = [a * a + b * c, a * b + b * d, c * a + d * c, c * b + d * d];
        // A rotation without drag has G² = 0.
        let terms = if square == [0.0; 4] { 2 } else { TERMS };
        Self {
            lane,
            generator,
            input,
            terms,
        }
    }

    /// `∫₀ᵗ e^{Gs} ds` times the input, for short times.
    pub fn push(&self, time: f64) -> [f64; 2] {
        let [[a, b], [c, d]] = self.generator;
        let mut sum = [0.0; 2];
        for share in INTEGRAL_SHARES[..self.terms].iter().rev() {
            let [x, y] = sum;
            let share = time * share;
            sum = [
                self.input[0] + share * (a * x + b * y),
                self.input[1] + share * (c * x + d * y),
            ];
        }
        let [x, y] = sum;
        [time * x, time * y]
    }

    /// Rates of the block's coordinates.
    #[inline(always)]
    pub fn rates(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let ([[a, b], [c, d]], [p, q]) = (self.generator, self.input);
        [a * x + b * y + p, c * x + d * y + q]
    }

    /// Displacement and rate after a short time under the input.
    pub fn pushed(&self, [x, y]: [f64; 2], time: f64) -> [f64; 2] {
        let moved = Self {
            input: self.rates([x, y]),
            ..*self
        };
        let [p, q] = moved.push(time);
        [x + p, y + q]
    }
}

/// The steady responses of a system to each input, one padded state per input.
#[derive(Debug)]
pub struct Steady {
    /// Padded states.
    pub responses: Vec<f64>,
    /// Blocks that keep their constant input.
    pub drifts: Vec<Drift>,
}

impl Steady {
    /// The steady responses of a system with some closed contacts at the operating point of a model.
    pub fn new(
        model: &Model,
        basis: &Basis<'_>,
        closed: &[(usize, ContactClass)],
        frequencies: &Frequencies,
    ) -> Self {
        let n = model.modes();
        let padded = padded(n);
        let mut constant: Vec<[f64; 2]> = model.blocks.iter().map(|b| b.static_input).collect();
        let mut harmonic = vec![vec![[Complex64::ZERO; 2]; n]; frequencies.all.len()];
        for ripple in &model.ripple {
            let place = frequencies.place([ripple.angular_frequency, ripple.turns_per_cycle]);
            for (sums, input) in harmonic[place].iter_mut().zip(&ripple.input) {
                for (sum, input) in sums.iter_mut().zip(input) {
                    *sum += input * Complex64::cis(ripple.phase);
                }
            }
        }
        for (contact, class) in closed {
            let direction = &model.directions[class.direction];
            let contact = &model.contacts[*contact];
            let pull = class.stiffness * contact.side * contact.half_gap;
            let errors = error_amplitudes(model, direction.line, frequencies);
            for (i, gain) in direction.gains.iter().enumerate() {
                for (part, g) in gain.mesh_input.into_iter().enumerate() {
                    constant[i][part] += g * pull;
                    for ((sum, error), [omega, _]) in
                        harmonic.iter_mut().zip(&errors).zip(&frequencies.all)
                    {
                        sum[i][part] += g * c64(class.stiffness, class.damping * omega) * error;
                    }
                }
            }
        }
        let mut steady = Self {
            responses: vec![0.0; frequencies.inputs() * 2 * padded],
            drifts: Vec::new(),
        };
        let forced = |inputs: &[[f64; 2]]| -> Vec<[f64; 2]> {
            let input = basis.input(inputs);
            (0..n).map(|i| [input[i], input[padded + i]]).collect()
        };
        let slowest = DRIFT / model.period();
        for (i, input) in forced(&constant).into_iter().enumerate() {
            let block = basis.block(i);
            if block.natural_frequency() < slowest {
                steady.drifts.push(Drift::new(i, block.generator, input));
                continue;
            }
            let rest = solve(&block, Complex64::ZERO, input.map(|s| c64(s, 0.0)));
            let target = &mut steady.responses[..2 * padded];
            (target[i], target[padded + i]) = (rest[0].re, rest[1].re);
        }
        for (h, force) in harmonic.iter().enumerate() {
            let [omega, _] = frequencies.all[h];
            let parts = [|f: &Complex64| f.re, |f: &Complex64| f.im];
            let [re, im] = parts.map(|part| {
                let inputs: Vec<[f64; 2]> = force.iter().map(|f| f.each_ref().map(part)).collect();
                forced(&inputs)
            });
            let (cos, sin) = steady.responses[(1 + 2 * h) * 2 * padded..].split_at_mut(2 * padded);
            for i in 0..n {
                let block = basis.block(i);
                let input = [0, 1].map(|part| c64(re[i][part], im[i][part]));
                let response = solve(&block, c64(0.0, omega), input);
                for (part, x) in response.into_iter().enumerate() {
                    cos[part * padded + i] = x.re;
                    sin[part * padded + i] = -x.im;
                }
            }
        }
        steady
    }
}

/// `(s I − G)⁻¹ f`.
fn solve(block: &Block, s: Complex64, f: [Complex64; 2]) -> [Complex64; 2] {
    let [[a, b], [c, d]] = block.generator;
    let (p, q) = (s - a, s - d);
    let det = p * q - b * c;
    [(q * f[0] + b * f[1]) / det, (c * f[0] + p * f[1]) / det]
}

/// Whether an undamped block is in resonance with a harmonic \[rad/s\].
fn in_resonance(block: &Block, omega: f64) -> bool {
    let [[a, b], [c, d]] = block.generator;
    let s = c64(0.0, omega);
    let det = (s - a) * (s - d) - b * c;
    det.norm() < RESONANCE * (block.natural_frequency().powi(2) + omega * omega)
}

/// Refuses a system with an undamped block in resonance with a harmonic.
///
/// # Errors
/// [`TableError::Resonance`].
pub fn unresonant(
    model: &Model,
    basis: &Basis<'_>,
    frequencies: &Frequencies,
) -> Result<(), TableError> {
    let resonant =
        |&&[omega, _]: &&[f64; 2]| (0..model.modes()).any(|i| in_resonance(&basis.block(i), omega));
    match frequencies.all.iter().find(resonant) {
        Some(&[frequency, _]) => Err(TableError::Resonance { frequency }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_added() {
        for x in [-0.47, 1e-9, 0.3, 0.47_f64] {
            let [c, s] = turned_by([0.8, 0.6], x);
            let angle = 0.6_f64.asin() + x;
            assert!((c - angle.cos()).abs() < 4e-16 && (s - angle.sin()).abs() < 4e-16);
        }
    }

    /// A free rotation under a torque, and one with drag, compared with closed forms.
    #[test]
    fn drifts_are_those_of_constant_torques() {
        let free = Drift::new(0, [[0.0, 1.0], [0.0, 0.0]], [0.0, 3.0]);
        assert_eq!(free.terms, 2);
        let [x, v] = free.push(0.2);
        assert!((x - 0.06).abs() < 1e-16 && (v - 0.6).abs() < 1e-15);
        let drag = Drift::new(0, [[0.0, 1.0], [0.0, -2.0]], [0.0, 3.0]);
        let [x, v] = drag.push(0.2);
        let speed = 1.5 * (1.0 - (-0.4f64).exp());
        assert!((v - speed).abs() < 1e-15 && (x - (1.5 * 0.2 - 0.5 * speed)).abs() < 1e-15);
    }
}
