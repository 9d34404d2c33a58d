//! Fourier integrals of the deflection at whole mesh orders and at fractions of them.
//!
//! `∫ δ e^{−iωt} dt = Σ a_n ∫ P_n e^{−iωt} dt`. Of few orders, integrals of P_n are kept for windows
//! of the kernel's own length; windows cut short are integrated by the Gauss rule, all
//! frequencies being powers of one slow exponential. Of many, and where an order turns too fast for
//! the rule, each order takes the same few operations ([`crate::numerics::fourier`]).

use super::rule::{LANES, LONG, Rule};
use super::stretches::{Stretches, Summable};
use crate::analysis::modal_series::TERMS;
use crate::analysis::recurring::Recurring;
use crate::numerics::exponential::{LARGEST_HALF_ARGUMENT, legendre_series};
use crate::numerics::fourier::{Stretch, add_lines, line_integrals};
use crate::numerics::legendre::polynomials;
use crate::numerics::quadrature::GaussLegendre;
use crate::propagate::Window;
use num_complex::{Complex64, c64};
use std::slice;
use std::sync::Arc;

/// Sub-orders looked at, in twelfths of the mesh frequency: 1/4, 1/3, 1/2, 2/3, 3/4.
const TWELFTHS: [usize; SUBORDERS] = [3, 4, 6, 8, 9];

/// How many they are.
pub(super) const SUBORDERS: usize = 5;

/// Their denominators: the motion must repeat after as many cycles to hold them.
const DENOMINATORS: [u32; SUBORDERS] = [4, 3, 2, 3, 4];

/// Mesh cycles over which the amplitude of a motion that does not repeat is taken; whole
/// periods of every sub-order.
pub(super) const SUBORDER_WINDOW: u64 = 24;

/// `∫ P_n e^{−iωt} dt` for eight frequencies, the lanes, by term.
#[derive(Debug, Clone)]
struct EightFrequencies {
    re: [[f64; LANES]; TERMS],
    im: [[f64; LANES]; TERMS],
}

/// The same for every frequency, in eights.
/// Shared, because a clone of the statistics is taken whenever they are looked at.
type Table = Arc<[EightFrequencies]>;

/// Writes `∫ δ e^{−iω t} dt` over a window, t from its start, for every frequency of a table.
/// The same on every instruction set: nothing is fused.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn integrals(table: &[EightFrequencies], series: &[f64; TERMS], out: &mut [Complex64]) {
    for (eight, out) in table.iter().zip(out.chunks_mut(LANES)) {
        // Even and odd terms apart: two short chains of sums instead of a long one.
        let mut sums = [Lanes::ZERO; 2];
        for n in (0..TERMS).step_by(2) {
            for (odd, sum) in sums.iter_mut().enumerate() {
                let a = series[n + odd];
                for i in 0..LANES {
                    sum.re[i] += a * eight.re[n + odd][i];
                    sum.im[i] += a * eight.im[n + odd][i];
                }
            }
        }
        for (i, value) in out.iter_mut().enumerate() {
            *value = c64(sums[0].re[i] + sums[1].re[i], sums[0].im[i] + sums[1].im[i]);
        }
    }
}

/// Fourier integrals at sub-orders and whole orders.
#[derive(Debug, Clone)]
pub(super) struct Fourier {
    mesh_frequency: f64,
    /// Sub-orders, then whole orders \[rad/s\].
    frequencies: Vec<f64>,
    /// Integrals of the Legendre polynomials on windows of the kernel's own lengths.
    known: Recurring<Table>,
    /// Room for the integrals at all frequencies.
    values: Vec<Complex64>,
    pub(super) suborders: Suborders,
}

impl Fourier {
    /// At sub-orders and the first `harmonics` whole orders.
    pub(super) fn new(mesh_frequency: f64, harmonics: usize) -> Self {
        let fractions = TWELFTHS.iter().map(|m| *m as f64 / 12.0);
        let orders = fractions.chain((1..=harmonics).map(|h| h as f64));
        let frequencies: Vec<f64> = orders.map(|order| order * mesh_frequency).collect();
        Self {
            mesh_frequency,
            values: vec![Complex64::ZERO; frequencies.len()],
            frequencies,
            known: Recurring::new(),
            suborders: Suborders::new(),
        }
    }

    /// Half turn \[rad\] over a window of the length `tau` \[s\] of the highest frequency that
    /// nodes may be asked for.
    pub(super) fn half_turn(&self, tau: f64) -> f64 {
        let highest = match self.many() {
            true => self.frequencies[SUBORDERS - 1],
            false => self.frequencies.last().copied().unwrap_or(0.0),
        };
        0.5 * highest * tau
    }

    /// Whether orders are too many for nodes and tables.
    fn many(&self) -> bool {
        self.frequencies.len() > SUBORDERS + MOST_AT_NODES
    }

    /// Adds a window; `at_nodes` is the series at the rule's nodes, and `sums` are those of
    /// the whole orders.
    pub(super) fn add<const M: usize>(
        &mut self,
        window: &Window<'_>,
        series: &[f64; TERMS],
        rule: &Rule<M>,
        at_nodes: &[f64; M],
        sums: &mut Vec<Complex64>,
    ) {
        let tau = window.duration;
        let (many, turned) = (self.many(), self.half_turn(tau));
        let frequencies = &self.frequencies;
        let known = match many {
            true => None,
            false => self.known.find(tau, || table(frequencies, tau)),
        };
        let whole_at_once = known.is_none() && (many || turned > Rule::<M>::WIDEST_TURN);
        let (below, whole) = self.values.split_at_mut(SUBORDERS);
        match known {
            Some(known) => integrals(known, series, &mut self.values),
            None => {
                let weighted = std::array::from_fn(|j| tau * rule.weights[j] * at_nodes[j]);
                let slowest = self.mesh_frequency * tau / 12.0;
                let whole = match whole_at_once {
                    true => &mut [],
                    false => whole,
                };
                sum_nodes(&rule.places, &weighted, slowest, below, whole);
            }
        }
        // A twelfth of the mesh frequency has its phase back after twelve cycles.
        let twelfth = turn(self.mesh_frequency / 12.0 * window.start);
        let twelfth = twelfth * TWELFTH_TURNS[(window.cycle % 12) as usize];
        let three = twelfth * (twelfth * twelfth);
        let six = three * three;
        let (below, whole) = self.values.split_at(SUBORDERS);
        if whole_at_once {
            let stretch = Stretch {
                duration: tau,
                half_turn: 0.5 * self.mesh_frequency * tau,
                phase: self.mesh_frequency * (window.start + 0.5 * tau),
            };
            add_lines(stretch, slice::from_ref(series), slice::from_mut(sums));
        } else {
            let start = six * six;
            let mut rotation = start;
            for (sum, value) in sums.iter_mut().zip(whole) {
                *sum += rotation * value;
                rotation *= start;
            }
        }
        let four = three * twelfth;
        let factors = [three, four, six, four * four, six * three];
        self.suborders.add(&factors, below);
    }
}

/// The integrals of the polynomials on windows of the length `tau` \[s\].
fn table(frequencies: &[f64], tau: f64) -> Table {
    let eight = |frequencies: &[f64]| {
        let mut out = EightFrequencies {
            re: [[0.0; LANES]; TERMS],
            im: [[0.0; LANES]; TERMS],
        };
        for (i, omega) in frequencies.iter().enumerate() {
            let mut integrals = [Complex64::ZERO; TERMS];
            window_integrals(*omega, tau, &mut integrals);
            for (n, integral) in integrals.into_iter().enumerate() {
                out.re[n][i] = integral.re;
                out.im[n][i] = integral.im;
            }
        }
        out
    };
    frequencies.chunks(LANES).map(eight).collect()
}

/// Most whole orders that nodes and tables are used for: beyond, integrals order by order take
/// less work.
const MOST_AT_NODES: usize = 32;

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

    fn total(&self) -> Complex64 {
        c64(self.re.iter().sum::<f64>(), self.im.iter().sum())
    }
}

/// Writes the sums of `weighted` over the nodes at `places` times `e^{−imθ}`: m the sub-orders' twelfths
/// (`below`) and 12, 24, … (`whole`), θ growing from 0 to `slowest` over the window. The same on every instruction set: nothing is fused.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn sum_nodes<const M: usize>(
    places: &[f64; M],
    weighted: &[f64; M],
    slowest: f64,
    below: &mut [Complex64],
    whole: &mut [Complex64],
) {
    let mut parts = [Lanes::ZERO; SUBORDERS];
    let mut orders = [Lanes::ZERO; MOST_AT_NODES];
    for base in (0..M).step_by(LANES) {
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
    coherent: [Complex64; SUBORDERS],
    /// Over the cycles of the present window of [`SUBORDER_WINDOW`].
    present: [Complex64; SUBORDERS],
    filled: u64,
    /// Squares of amplitudes \[m²\], one a window.
    powers: Stretches<[f64; SUBORDERS]>,
}

impl Suborders {
    fn new() -> Self {
        Self {
            coherent: [Complex64::ZERO; SUBORDERS],
            present: [Complex64::ZERO; SUBORDERS],
            filled: 0,
            powers: Stretches::new([0.0; SUBORDERS], 1),
        }
    }

    pub(super) fn restart(&mut self) {
        self.coherent = [Complex64::ZERO; SUBORDERS];
        self.present = [Complex64::ZERO; SUBORDERS];
        self.filled = 0;
        self.powers.restart();
    }

    /// Adds the integrals of a window, turned by `factors` to its place in time.
    fn add(&mut self, factors: &[Complex64; SUBORDERS], window: &[Complex64]) {
        for ((sum, factor), value) in self.present.iter_mut().zip(factors).zip(window) {
            *sum += factor * value;
        }
    }

    /// A cycle of the length `period` \[s\] is over.
    pub(super) fn advance(&mut self, period: f64) {
        self.filled += 1;
        if self.filled < SUBORDER_WINDOW {
            return;
        }
        let time = SUBORDER_WINDOW as f64 * period;
        let power = self.present.map(|sum| (2.0 * sum.norm() / time).powi(2));
        self.powers.open().add(&power);
        self.powers.advance();
        self.close();
    }

    fn close(&mut self) {
        for (sum, part) in self.coherent.iter_mut().zip(&mut self.present) {
            *sum += std::mem::take(part);
        }
        self.filled = 0;
    }

    /// Adds the record of another trajectory behind this one. Unfinished windows of both are
    /// dropped: no window holds parts of two trajectories.
    pub(super) fn append(&mut self, other: &Self) {
        self.present = [Complex64::ZERO; SUBORDERS];
        self.filled = 0;
        self.powers.append(&other.powers);
    }

    /// Exact amplitudes of a motion that repeats after `period` cycles, from `time` \[s\] of
    /// whole periods. It holds a fraction of the mesh frequency only where the denominator
    /// divides its period.
    pub(super) fn of_periodic(&self, period: u32, time: f64) -> Vec<f64> {
        (0..SUBORDERS)
            .map(|i| {
                if period.is_multiple_of(DENOMINATORS[i]) {
                    2.0 * (self.coherent[i] + self.present[i]).norm() / time
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

/// `e^{−i 2π n/12}`.
const TWELFTH_TURNS: [Complex64; 12] = {
    const R: f64 = 0.866_025_403_784_438_6;
    [
        Complex64::new(1.0, 0.0),
        Complex64::new(R, -0.5),
        Complex64::new(0.5, -R),
        Complex64::new(0.0, -1.0),
        Complex64::new(-0.5, -R),
        Complex64::new(-R, -0.5),
        Complex64::new(-1.0, 0.0),
        Complex64::new(-R, 0.5),
        Complex64::new(-0.5, R),
        Complex64::new(0.0, 1.0),
        Complex64::new(0.5, R),
        Complex64::new(R, 0.5),
    ]
};

/// `e^{−i phase}`.
fn turn(phase: f64) -> Complex64 {
    Complex64::cis(phase).conj()
}

/// `∫₀^τ P_n(2t/τ − 1) e^{−iωt} dt` for n < 24: by the series of the exponential, by a Gauss
/// rule, and by Bessel functions, the faster it turns.
fn window_integrals(omega: f64, tau: f64, out: &mut [Complex64; TERMS]) {
    let turned = 0.5 * omega * tau;
    if turned <= LARGEST_HALF_ARGUMENT {
        legendre_series(c64(0.0, -omega), tau, out);
        for (n, value) in out.iter_mut().enumerate() {
            *value *= tau / (2 * n + 1) as f64;
        }
        return;
    }
    if turned > Rule::<LONG>::WIDEST_TURN {
        line_integrals(turned, tau, out);
        return;
    }
    out.fill(Complex64::ZERO);
    let nodes = LONG + (omega * tau) as usize;
    let gauss = GaussLegendre::new(nodes);
    let mut p = [0.0; TERMS];
    for (x, w) in gauss.nodes.iter().zip(&gauss.weights) {
        polynomials(*x, &mut p);
        let turn = turn(0.5 * omega * tau * (x + 1.0));
        let weight = 0.5 * tau * w;
        for (value, p) in out.iter_mut().zip(&p) {
            *value += weight * p * turn;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wave of half the mesh frequency keeps its amplitude where windows are joined to bound the memory.
    #[test]
    fn sub_orders_of_long_records_keep_their_amplitude() {
        let period = 0.01;
        let amplitude = 3e-6;
        let mut suborders = Suborders::new();
        // ∫ A cos(ωt) e^{−iωt} over a cycle, at its own frequency alone.
        let one = Complex64::from(0.5 * amplitude * period);
        let mut window = [Complex64::ZERO; SUBORDERS];
        window[0] = one;
        for cycles in [SUBORDER_WINDOW * 100, SUBORDER_WINDOW * 9000] {
            for _ in 0..cycles {
                suborders.add(&[Complex64::ONE; SUBORDERS], &window);
                suborders.advance(period);
            }
            let [values, _] = suborders.of_windows(|_| 0.0);
            assert!((values[0] / amplitude - 1.0).abs() < 1e-12, "{values:?}");
        }
    }
}
