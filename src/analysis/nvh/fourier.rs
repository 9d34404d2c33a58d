//! Fourier integrals of the deflection at whole mesh orders and at fractions of them.
//!
//! `∫ δ e^{−iωt} dt = Σ a_n ∫ P_n e^{−iωt} dt` on windows of the kernel's own length, whose
//! integrals of P_n (Bessel series of the exponential) are kept. Windows cut short are
//! integrated by the Gauss rule, all frequencies being powers of one slow exponential.

use super::rule::{NODES, Rule};
use super::stretches::Stretches;
use crate::analysis::modal_series::TERMS;
use crate::analysis::recurring::Recurring;
use crate::numerics::exponential::{Complex, LARGEST_HALF_ARGUMENT, legendre_series, multiply};
use crate::numerics::legendre::polynomials;
use crate::numerics::quadrature::GaussLegendre;
use crate::propagate::Window;
use std::f64::consts::TAU;
use std::sync::Arc;

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

/// `∫ P_n e^{−iωt} dt` for every frequency.
/// Shared, because a clone of the statistics is taken whenever they are looked at.
type Table = Arc<[[Complex; TERMS]]>;

/// `∫ δ e^{−iω t} dt` over a window, t from its start, given those of the polynomials.
fn integral(integrals: &[Complex; TERMS], series: &[f64; TERMS]) -> Complex {
    let mut value = (0.0, 0.0);
    for (a, integral) in series.iter().zip(integrals) {
        value.0 += a * integral.0;
        value.1 += a * integral.1;
    }
    value
}

/// Fourier integrals at sub-orders and whole orders.
#[derive(Debug, Clone)]
pub(super) struct Fourier {
    mesh_frequency: f64,
    /// Sub-orders, then whole orders \[rad/s\].
    frequencies: Vec<f64>,
    /// Integrals of the Legendre polynomials on windows of the kernel's own lengths.
    known: Recurring<Table>,
    pub(super) suborders: Suborders,
}

impl Fourier {
    /// At sub-orders and the first `harmonics` whole orders.
    pub(super) fn new(mesh_frequency: f64, harmonics: usize) -> Self {
        let fractions = TWELFTHS.iter().map(|m| *m as f64 / 12.0);
        let orders = fractions.chain((1..=harmonics).map(|h| h as f64));
        Self {
            mesh_frequency,
            frequencies: orders.map(|order| order * mesh_frequency).collect(),
            known: Recurring::new(),
            suborders: Suborders::new(),
        }
    }

    /// Adds a window; `weighted` is the series at the rule's nodes times their weights, and
    /// `sums` are those of the whole orders.
    pub(super) fn add(
        &mut self,
        window: &Window<'_>,
        series: &[f64; TERMS],
        rule: &Rule,
        weighted: &[f64; NODES],
        sums: &mut [Complex],
    ) {
        let tau = window.duration;
        let frequencies = &self.frequencies;
        let table = || -> Table {
            let of = |frequency: &f64| {
                let mut integrals = [(0.0, 0.0); TERMS];
                window_integrals(*frequency, tau, &mut integrals);
                integrals
            };
            frequencies.iter().map(of).collect()
        };
        let highest = 0.5 * sums.len() as f64 * self.mesh_frequency * tau;
        let computed;
        let table = match self.known.find(tau, table) {
            // Too many turns for the nodes: the table is worth while even for a cut.
            None if highest > WIDEST_TURN => {
                computed = table();
                Some(&computed)
            }
            known => known,
        };
        let mut below = [(0.0, 0.0); SUBORDERS];
        let start = turn(self.mesh_frequency * window.start);
        let mut rotation = start;
        let mut add = |sum: &mut Complex, value: Complex| {
            let value = multiply(rotation, value);
            sum.0 += value.0;
            sum.1 += value.1;
            rotation = multiply(rotation, start);
        };
        if let Some(table) = table {
            for (value, integrals) in below.iter_mut().zip(table.iter()) {
                *value = integral(integrals, series);
            }
            for (integrals, sum) in table[SUBORDERS..].iter().zip(sums) {
                add(sum, integral(integrals, series));
            }
        } else {
            let slowest = self.mesh_frequency * tau / 12.0;
            let mut whole = [(0.0, 0.0); MOST_AT_NODES];
            for (chunk, sums) in sums.chunks_mut(MOST_AT_NODES).enumerate() {
                let whole = &mut whole[..sums.len()];
                let skipped = chunk * MOST_AT_NODES;
                at_nodes(&rule.places, weighted, slowest, skipped, &mut below, whole);
                for (sum, value) in sums.iter_mut().zip(whole) {
                    add(sum, (tau * value.0, tau * value.1));
                }
            }
            below = below.map(|value| (tau * value.0, tau * value.1));
        }
        self.suborders
            .add(self.mesh_frequency, window.cycle, window.start, &below);
    }
}

/// Whole orders that are summed at the nodes in one go.
const MOST_AT_NODES: usize = 32;

/// Nodes worked on at a time.
const LANES: usize = 8;

/// Complex numbers, one a lane.
#[derive(Debug, Clone, Copy)]
struct Lanes {
    re: [f64; LANES],
    im: [f64; LANES],
}

impl Lanes {
    const ZERO: Self = Self {
        re: [0.0; LANES],
        im: [0.0; LANES],
    };

    /// `e^{−iθ}` for 0 ≤ θ ≤ 0.6 by its series: 2π/12 is the most a window turns, and
    /// `0.6¹⁶/16!` is below round-off.
    #[inline(always)]
    fn slow_turn(theta: [f64; LANES]) -> Self {
        let mut out = Self {
            re: [1.0; LANES],
            im: [1.0; LANES],
        };
        let mut n = 14.0;
        while n > 0.0 {
            let (even, odd) = (-1.0 / (n * (n - 1.0)), -1.0 / (n * (n + 1.0)));
            for i in 0..LANES {
                let square = theta[i] * theta[i];
                out.re[i] = 1.0 + even * square * out.re[i];
                out.im[i] = 1.0 + odd * square * out.im[i];
            }
            n -= 2.0;
        }
        for i in 0..LANES {
            out.im[i] *= -theta[i];
        }
        out
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        let mut out = Self::ZERO;
        for i in 0..LANES {
            out.re[i] = self.re[i] * other.re[i] - self.im[i] * other.im[i];
            out.im[i] = self.re[i] * other.im[i] + self.im[i] * other.re[i];
        }
        out
    }

    /// Adds real multiples of other lanes.
    #[inline(always)]
    fn add(&mut self, amounts: &[f64; LANES], other: Self) {
        for i in 0..LANES {
            self.re[i] += amounts[i] * other.re[i];
            self.im[i] += amounts[i] * other.im[i];
        }
    }

    fn total(&self) -> Complex {
        (self.re.iter().sum(), self.im.iter().sum())
    }
}

/// Sums of `weighted` over the nodes at `places` times `e^{−imθ}`: m the sub-orders' twelfths
/// (`below`) and 12, 24, … (`whole`, from order `skipped` + 1 on), θ growing from 0 to
/// `slowest` over the window. The same on every instruction set: nothing is fused.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn at_nodes(
    places: &[f64; NODES],
    weighted: &[f64; NODES],
    slowest: f64,
    skipped: usize,
    below: &mut [Complex; SUBORDERS],
    whole: &mut [Complex],
) {
    let mut parts = [Lanes::ZERO; SUBORDERS];
    let mut orders = [Lanes::ZERO; MOST_AT_NODES];
    for base in (0..NODES).step_by(LANES) {
        let mut theta = [0.0; LANES];
        let mut amounts = [0.0; LANES];
        for i in 0..LANES {
            theta[i] = 0.5 * slowest * (places[base + i] + 1.0);
            amounts[i] = weighted[base + i];
        }
        let one = Lanes::slow_turn(theta);
        let three = one.times(one).times(one);
        let four = three.times(one);
        let six = three.times(three);
        let powers = [three, four, six, four.times(four), six.times(three)];
        for (part, z) in parts.iter_mut().zip(powers) {
            part.add(&amounts, z);
        }
        let twelve = six.times(six);
        let mut z = twelve;
        for _ in 0..skipped {
            z = z.times(twelve);
        }
        for order in orders.iter_mut().take(whole.len()) {
            order.add(&amounts, z);
            z = z.times(twelve);
        }
    }
    for (value, part) in below.iter_mut().zip(&parts) {
        *value = part.total();
    }
    for (value, order) in whole.iter_mut().zip(&orders) {
        *value = order.total();
    }
}

/// Fractions of the mesh frequency.
#[derive(Debug, Clone)]
pub(super) struct Suborders {
    /// Over all cycles.
    coherent: [Complex; SUBORDERS],
    /// Over the cycles of the present window of [`SUBORDER_WINDOW`].
    present: [Complex; SUBORDERS],
    filled: u64,
    /// Squares of amplitudes \[m²\], one a window.
    powers: Stretches<[f64; SUBORDERS]>,
}

impl Suborders {
    fn new() -> Self {
        Self {
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

    /// Adds the integrals of a window that starts at `start` \[s\] of a mesh cycle.
    fn add(&mut self, mesh_frequency: f64, cycle: u64, start: f64, window: &[Complex; SUBORDERS]) {
        // A twelfth of the mesh frequency has its phase back after twelve cycles.
        let whole = TAU * (cycle % 12) as f64 / 12.0;
        let one = turn(whole + mesh_frequency / 12.0 * start);
        let three = multiply(one, multiply(one, one));
        let four = multiply(three, one);
        let six = multiply(three, three);
        let factors = [three, four, six, multiply(four, four), multiply(six, three)];
        for ((sum, factor), value) in self.present.iter_mut().zip(factors).zip(window) {
            let value = multiply(factor, *value);
            sum.0 += value.0;
            sum.1 += value.1;
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
