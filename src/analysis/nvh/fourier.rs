//! Fourier integrals of the deflection at whole mesh orders and at fractions of them.
//!
//! `∫ δ e^{−iωt} dt = Σ a_n ∫ P_n e^{−iωt} dt` on every window, the integrals of P_n from the
//! Bessel series of the exponential. Most windows have one length, whose integrals are kept.

use super::rule::{NODES, Rule};
use super::stretches::Stretches;
use crate::analysis::modal_series::TERMS;
use crate::numerics::exponential::{Complex, LARGEST_HALF_ARGUMENT, legendre_series, multiply};
use crate::numerics::legendre::polynomials;
use crate::numerics::quadrature::GaussLegendre;
use crate::propagate::Window;
use std::f64::consts::TAU;

/// Half turn \[rad\] of the highest harmonic over a window up to which the Gauss rule, exact
/// to degree 95, integrates it with 23rd-degree deflections to round-off.
const WIDEST_TURN: f64 = 8.0;

/// Sub-orders looked at, in twelfths of the mesh frequency: 1/4, 1/3, 1/2, 2/3, 3/4.
const TWELFTHS: [usize; SUBORDERS] = [3, 4, 6, 8, 9];

/// How many they are.
pub(super) const SUBORDERS: usize = 5;

/// Their denominators: the motion must repeat after as many cycles to hold them.
const DENOMINATORS: [u32; SUBORDERS] = [4, 3, 2, 3, 4];

/// Mesh cycles over which the amplitude of a motion that does not repeat is taken; whole
/// periods of every sub-order.
pub(super) const SUBORDER_WINDOW: u64 = 24;

/// Integrals of the Legendre polynomials against some exponentials, on windows of one length.
#[derive(Debug, Clone)]
struct Integrals {
    frequencies: Vec<f64>,
    /// Length of the last window, and the length that `table` is for: a length that comes
    /// twice running is the kernel's own and will come again, others are cuts.
    last_length: f64,
    length: f64,
    table: Vec<[Complex; TERMS]>,
}

impl Integrals {
    fn new(frequencies: Vec<f64>) -> Self {
        Self {
            last_length: 0.0,
            length: 0.0,
            table: vec![[(0.0, 0.0); TERMS]; frequencies.len()],
            frequencies,
        }
    }

    /// Whether the table is for windows of this length; makes it so where worth while.
    fn known(&mut self, length: f64) -> bool {
        if length != self.length && length == self.last_length {
            self.length = length;
            for (frequency, integrals) in self.frequencies.iter().zip(&mut self.table) {
                window_integrals(*frequency, length, integrals);
            }
        }
        self.last_length = length;
        length == self.length
    }

    /// `∫ δ e^{−iω t} dt` over a window, t from its start, for frequency `index`.
    fn on(&self, index: usize, known: bool, length: f64, series: &[f64; TERMS]) -> Complex {
        let mut cut = [(0.0, 0.0); TERMS];
        let integrals = if known {
            &self.table[index]
        } else {
            window_integrals(self.frequencies[index], length, &mut cut);
            &cut
        };
        let mut value = (0.0, 0.0);
        for (a, integral) in series.iter().zip(integrals) {
            value.0 += a * integral.0;
            value.1 += a * integral.1;
        }
        value
    }
}

/// Whole mesh orders 1, 2, ….
#[derive(Debug, Clone)]
pub(super) struct Harmonics {
    mesh_frequency: f64,
    integrals: Integrals,
}

impl Harmonics {
    pub(super) fn new(mesh_frequency: f64, count: usize) -> Self {
        let frequencies = (1..=count).map(|h| h as f64 * mesh_frequency).collect();
        Self {
            mesh_frequency,
            integrals: Integrals::new(frequencies),
        }
    }

    /// Adds a window to the sums; `values` is the series at the rule's nodes.
    pub(super) fn add(
        &mut self,
        window: &Window<'_>,
        series: &[f64; TERMS],
        rule: &Rule,
        values: &[f64; NODES],
        sums: &mut [Complex],
    ) {
        let tau = window.duration;
        let known = self.integrals.known(tau);
        let first = turn(self.mesh_frequency * window.start);
        let highest = 0.5 * sums.len() as f64 * self.mesh_frequency * tau;
        if !known && highest <= WIDEST_TURN {
            self.add_by_nodes(first, tau, rule, values, sums);
            return;
        }
        let mut rotation = first;
        for (index, sum) in sums.iter_mut().enumerate() {
            let value = multiply(rotation, self.integrals.on(index, known, tau, series));
            sum.0 += value.0;
            sum.1 += value.1;
            rotation = multiply(rotation, first);
        }
    }

    /// From the Gauss rule; `first` is the phase factor of order 1 at the window's start.
    fn add_by_nodes(
        &self,
        first: Complex,
        tau: f64,
        rule: &Rule,
        values: &[f64; NODES],
        sums: &mut [Complex],
    ) {
        let half = 0.5 * self.mesh_frequency * tau;
        for j in 0..NODES {
            let step = multiply(first, turn(half * (rule.place(j) + 1.0)));
            let amount = tau * rule.weights[j] * values[j];
            let mut rotation = step;
            for sum in sums.iter_mut() {
                sum.0 += amount * rotation.0;
                sum.1 += amount * rotation.1;
                rotation = multiply(rotation, step);
            }
        }
    }
}

/// Fractions of the mesh frequency.
#[derive(Debug, Clone)]
pub(super) struct Suborders {
    mesh_frequency: f64,
    integrals: Integrals,
    /// Over all cycles.
    coherent: [Complex; SUBORDERS],
    /// Over the cycles of the present window of [`SUBORDER_WINDOW`].
    present: [Complex; SUBORDERS],
    filled: u64,
    /// Squares of amplitudes \[m²\], one a window.
    powers: Stretches<[f64; SUBORDERS]>,
}

impl Suborders {
    pub(super) fn new(mesh_frequency: f64) -> Self {
        let frequencies = TWELFTHS.map(|m| m as f64 / 12.0 * mesh_frequency);
        Self {
            mesh_frequency,
            integrals: Integrals::new(frequencies.to_vec()),
            coherent: [(0.0, 0.0); SUBORDERS],
            present: [(0.0, 0.0); SUBORDERS],
            filled: 0,
            powers: Stretches::new([0.0; SUBORDERS], 1),
        }
    }

    pub(super) fn restart(&mut self) {
        self.coherent = [(0.0, 0.0); SUBORDERS];
        self.present = [(0.0, 0.0); SUBORDERS];
        self.filled = 0;
        self.powers.restart();
    }

    /// Adds a window.
    pub(super) fn add(&mut self, window: &Window<'_>, series: &[f64; TERMS]) {
        let tau = window.duration;
        let known = self.integrals.known(tau);
        // A twelfth of the mesh frequency has its phase back after twelve cycles.
        let whole = TAU * (window.cycle % 12) as f64 / 12.0;
        let one = turn(whole + self.mesh_frequency / 12.0 * window.start);
        let three = multiply(one, multiply(one, one));
        let four = multiply(three, one);
        let six = multiply(three, three);
        let factors = [three, four, six, multiply(four, four), multiply(six, three)];
        for (index, factor) in factors.into_iter().enumerate() {
            let value = multiply(factor, self.integrals.on(index, known, tau, series));
            self.present[index].0 += value.0;
            self.present[index].1 += value.1;
        }
    }

    /// A cycle of the length `period` \[s\] is over.
    pub(super) fn advance(&mut self, period: f64) {
        self.filled += 1;
        if self.filled < SUBORDER_WINDOW {
            return;
        }
        let time = SUBORDER_WINDOW as f64 * period;
        let present = self.present;
        let power = present.map(|(re, im)| (2.0 * re.hypot(im) / time).powi(2));
        self.powers.open().copy_from_slice(&power);
        self.powers.advance();
        self.close();
    }

    fn close(&mut self) {
        for (sum, part) in self.coherent.iter_mut().zip(&mut self.present) {
            sum.0 += part.0;
            sum.1 += part.1;
            *part = (0.0, 0.0);
        }
        self.filled = 0;
    }

    /// Exact amplitudes of a motion that repeats after `period` cycles, from `time` \[s\] of
    /// whole periods. It holds a fraction of the mesh frequency only where the denominator
    /// divides its period.
    pub(super) fn of_periodic(&self, period: u32, time: f64) -> Vec<f64> {
        (0..SUBORDERS)
            .map(|i| {
                let (whole, part) = (self.coherent[i], self.present[i]);
                if period.is_multiple_of(DENOMINATORS[i]) {
                    2.0 * (whole.0 + part.0).hypot(whole.1 + part.1) / time
                } else {
                    0.0
                }
            })
            .collect()
    }

    /// Root mean square over windows of the amplitude; empty before one whole window. With
    /// `error`, its standard errors (Gauss: `σ(A²)/2A`).
    pub(super) fn of_windows(&self, error: impl Fn(&[f64]) -> f64) -> [Vec<f64>; 2] {
        let windows = self.powers.closed();
        if windows.is_empty() {
            return [Vec::new(), Vec::new()];
        }
        // Windows may have been joined; every entry then holds as many.
        let joined = self.powers.length() as f64;
        let amplitudes = (0..SUBORDERS).map(|i| {
            let powers: Vec<f64> = windows.iter().map(|w| w[i] / joined).collect();
            let mean = powers.iter().sum::<f64>() / powers.len() as f64;
            (mean.sqrt(), 0.5 * error(&powers) / mean.sqrt())
        });
        let (values, errors) = amplitudes.unzip();
        [values, errors]
    }
}

/// `e^{−i phase}`.
fn turn(phase: f64) -> Complex {
    let (sin, cos) = phase.sin_cos();
    (cos, -sin)
}

/// `∫₀^τ P_n(2t/τ − 1) e^{−iωt} dt` for n < 24; windows longer than the exponential series
/// allows are integrated by a Gauss rule with enough nodes.
fn window_integrals(omega: f64, tau: f64, out: &mut [Complex; TERMS]) {
    if 0.5 * omega * tau <= LARGEST_HALF_ARGUMENT {
        legendre_series((0.0, -omega), tau, out);
        for (n, value) in out.iter_mut().enumerate() {
            let factor = tau / (2 * n + 1) as f64;
            *value = (factor * value.0, factor * value.1);
        }
        return;
    }
    out.fill((0.0, 0.0));
    let nodes = NODES + (omega * tau) as usize;
    let gauss = GaussLegendre::new(nodes);
    let mut p = [0.0; TERMS];
    for (x, w) in gauss.nodes.iter().zip(&gauss.weights) {
        polynomials(*x, &mut p);
        let (cos, sin) = turn(0.5 * omega * tau * (x + 1.0));
        let weight = 0.5 * tau * w;
        for (value, p) in out.iter_mut().zip(&p) {
            value.0 += weight * p * cos;
            value.1 += weight * p * sin;
        }
    }
}
