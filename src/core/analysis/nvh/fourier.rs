//! Fourier integrals of the deflection at whole mesh orders and at fractions of them.
//!
//! `∫ δ e^{−iωt} dt = e^{−iφ} Σ a_n ∫ P_n e^{−iω(t − middle)} dt`, with φ the phase of the window's middle.
//! The integrals of even terms are real, those of odd ones imaginary. They are stored for the kernel's
//! regular window lengths. Other windows use the Gauss rule, with all frequencies as powers of one slow
//! exponential. If there are many orders, or they turn too fast for the rule, the integrals of the polynomials
//! are computed for the window.

use super::block_sums::{BlockSums, Summable};
use super::lanes::{self, Complex, FrequencyGroup, Integrals, WindowPhase};
use super::rule::NodeValues;
use crate::analysis::modal_series::TERMS;
use crate::analysis::window_cache::WindowCache;
use crate::propagate::vectors::{LANES, Lanes};
use crate::propagate::{InstructionSet, Window};
use num_complex::{Complex64, c64};
use std::f64::consts::PI;
use std::sync::Arc;

/// Sub-orders, in twelfths of the mesh frequency: 1/4, 1/3, 1/2, 2/3, 3/4.
const TWELFTHS: [usize; SUBORDERS] = [3, 4, 6, 8, 9];

/// Number of sub-orders.
pub(super) const SUBORDERS: usize = 5;

/// Denominators of the sub-orders. A periodic motion contains a sub-order only if its period is a multiple of
/// the denominator.
const DENOMINATORS: [u32; SUBORDERS] = [4, 3, 2, 3, 4];

/// Mesh cycles per amplitude of a motion that does not repeat: whole periods of every sub-order.
pub(super) const SUBORDER_WINDOW: u64 = 24;

/// Maximum number of whole orders for which nodes and tables are used. For more orders, integration order by
/// order needs less work.
const MOST_AT_NODES: usize = 32;

/// Integrals of the polynomials at every frequency. Shared, because every evaluation of the statistics clones
/// them.
type Table = Arc<[Integrals]>;

/// Fourier integrals at sub-orders and whole orders.
#[derive(Debug, Clone)]
pub(super) struct Fourier {
    set: InstructionSet,
    period: f64,
    harmonics: usize,
    /// Sub-orders, then whole orders, extended to an even number of groups of eight.
    frequencies: Vec<FrequencyGroup>,
    /// Integrals of the Legendre polynomials on windows of the kernel's regular lengths.
    known: WindowCache<Table>,
    /// Sums over the present mesh cycle.
    sums: Vec<Complex>,
    pub(super) suborders: Suborders,
}

impl Fourier {
    /// Integrals for sub-orders and the first `harmonics` whole orders.
    pub(super) fn new(set: InstructionSet, period: f64, harmonics: usize) -> Self {
        let eights = (SUBORDERS + harmonics).div_ceil(2 * LANES) * 2;
        let frequency = |index: usize| match TWELFTHS.get(index) {
            Some(&twelfths) => (twelfths as f64 / 12.0, 1.0),
            None => ((index - SUBORDERS + 1) as f64, 0.0),
        };
        let eight = |first: usize| -> FrequencyGroup {
            let lanes: [(f64, f64); LANES] = std::array::from_fn(|i| frequency(first + i));
            FrequencyGroup {
                orders: Lanes(lanes.map(|(order, _)| order)),
                fractions: Lanes(lanes.map(|(_, fraction)| fraction)),
            }
        };
        Self {
            set,
            period,
            harmonics,
            frequencies: (0..eights).map(|i| eight(i * LANES)).collect(),
            known: WindowCache::new(),
            sums: vec![[Lanes::ZERO; 2]; eights],
            suborders: Suborders::new(),
        }
    }

    /// Half the angle \[rad\] by which the highest frequency for nodes turns over a window of the length `tau`
    /// \[s\]; 0 if nodes are not used.
    pub(super) fn half_turn(&self, tau: f64) -> f64 {
        if self.many() { 0.0 } else { PI * self.harmonics as f64 * tau / self.period }
    }

    /// Whether there are too many orders for nodes and tables.
    fn many(&self) -> bool {
        self.harmonics > MOST_AT_NODES
    }

    /// Adds a window, with its deflection at nodes.
    pub(super) fn add(&mut self, window: &Window<'_>, at_nodes: &NodeValues<'_>) {
        let NodeValues { rule, series, .. } = at_nodes;
        let tau = window.duration;
        let stretch = WindowPhase {
            duration: tau,
            cycles: tau / self.period,
            middle: (window.start + 0.5 * tau) / self.period,
            // A twelfth of the mesh frequency returns to its phase after twelve cycles.
            before: (window.cycle % 12) as f64,
        };
        let (many, turned) = (self.many(), self.half_turn(tau));
        let (set, frequencies) = (self.set, &self.frequencies);
        let known = if many {
            None
        } else {
            self.known.get_or_insert_recurring(tau, || {
                let mut window_integrals = vec![[Lanes::ZERO; TERMS]; frequencies.len()];
                lanes::integrate(set, frequencies, &stretch, &mut window_integrals);
                window_integrals.into()
            })
        };
        let sums = &mut self.sums;
        if let Some(known) = known {
            lanes::add_by_terms(set, frequencies, known, series, &stretch, sums);
        } else if many || turned > rule.widest_turn {
            for (group, sums) in frequencies.chunks_exact(2).zip(sums.chunks_exact_mut(2)) {
                let mut integrals = [[Lanes::ZERO; TERMS]; 2];
                lanes::integrate(set, group, &stretch, &mut integrals);
                lanes::add_by_terms(set, group, &integrals, series, &stretch, sums);
            }
        } else {
            let (places, weights, parts) = (&rule.places, &rule.weights, at_nodes.parts());
            lanes::add_by_nodes(set, frequencies, places, weights, parts, &stretch, sums);
        }
    }

    /// Ends a mesh cycle, and adds the integrals of the whole orders over it to `harmonics`.
    pub(super) fn advance(&mut self, harmonics: &mut [Complex64]) {
        let value = |index: usize| {
            let [re, im] = &self.sums[index / LANES];
            c64(re.0[index % LANES], im.0[index % LANES])
        };
        self.suborders.add(&std::array::from_fn(value));
        for (h, sum) in harmonics.iter_mut().enumerate() {
            *sum += value(SUBORDERS + h);
        }
        self.sums.fill([Lanes::ZERO; 2]);
        self.suborders.advance(self.period);
    }

    /// Forgets everything accumulated.
    pub(super) fn restart(&mut self) {
        self.sums.fill([Lanes::ZERO; 2]);
        self.suborders.restart();
    }
}

/// Amplitudes of the deflection at fractions of the mesh frequency.
#[derive(Debug, Clone)]
pub(super) struct Suborders {
    /// Fourier integrals over all complete windows of [`SUBORDER_WINDOW`] cycles.
    coherent: [Complex64; SUBORDERS],
    /// Fourier integrals over the cycles of the present window.
    present: [Complex64; SUBORDERS],
    filled: u64,
    /// Squares of amplitudes \[m²\], one per window.
    powers: BlockSums<[f64; SUBORDERS]>,
}

impl Suborders {
    fn new() -> Self {
        Self {
            coherent: [Complex64::ZERO; SUBORDERS],
            present: [Complex64::ZERO; SUBORDERS],
            filled: 0,
            powers: BlockSums::new([0.0; SUBORDERS], 1),
        }
    }

    pub(super) fn restart(&mut self) {
        self.coherent = [Complex64::ZERO; SUBORDERS];
        self.present = [Complex64::ZERO; SUBORDERS];
        self.filled = 0;
        self.powers.restart();
    }

    /// Adds the integrals over a mesh cycle.
    fn add(&mut self, cycle: &[Complex64; SUBORDERS]) {
        for (sum, value) in self.present.iter_mut().zip(cycle) {
            *sum += value;
        }
    }

    /// Ends a cycle of the length `period` \[s\].
    pub(super) fn advance(&mut self, period: f64) {
        self.filled += 1;
        if self.filled < SUBORDER_WINDOW {
            return;
        }
        let time = SUBORDER_WINDOW as f64 * period;
        let power = self.present.map(|sum| (2.0 * sum.norm() / time).powi(2));
        self.powers.current().add(&power);
        self.powers.advance();
        self.close();
    }

    fn close(&mut self) {
        for (sum, part) in self.coherent.iter_mut().zip(&mut self.present) {
            *sum += std::mem::take(part);
        }
        self.filled = 0;
    }

    /// Appends the record of another trajectory. Incomplete windows of both records are omitted: no window
    /// contains parts of two trajectories.
    pub(super) fn append(&mut self, other: &Self) {
        self.present = [Complex64::ZERO; SUBORDERS];
        self.filled = 0;
        self.powers.append(&other.powers);
    }

    /// Exact amplitudes of a motion that repeats after `period` cycles, measured over the `time` \[s\] of
    /// whole periods. The motion contains a fraction of the mesh frequency only if the denominator of the
    /// fraction divides `period`.
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

    /// Root mean square of the amplitude over windows, and its standard errors by error propagation,
    /// `σ(A) = σ(A²)/2A`. `error` gives the standard error of a series. Empty before one complete window.
    pub(super) fn of_windows(&self, error: impl Fn(&[f64]) -> f64) -> [Vec<f64>; 2] {
        let windows = self.powers.complete();
        if windows.is_empty() {
            return [Vec::new(), Vec::new()];
        }
        // Windows may be joined; every entry then contains `joined` of them.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::nvh::rule::Rules;
    use crate::numerics::legendre::evaluate;
    use crate::numerics::quadrature::GaussLegendre;

    /// `∫ δ e^{−iωt} dt` over a window by many nodes; ω is `order` times the mesh frequency.
    fn by_many_nodes(order: f64, period: f64, window: &Window<'_>, series: &[f64]) -> Complex64 {
        let rule = GaussLegendre::new(200);
        let nodes = rule.nodes.iter().zip(&rule.weights);
        nodes
            .map(|(x, w)| {
                let time = window.start + 0.5 * (x + 1.0) * window.duration;
                // In whole mesh cycles, a whole order turns by whole turns.
                let turns = order * (time / period) + (order * window.cycle as f64).fract();
                let weight = 0.5 * window.duration * w * evaluate(series, *x);
                weight * Complex64::cis(-2.0 * PI * turns)
            })
            .sum()
    }

    /// All methods of integration agree, with few orders and with many, on windows of any length. With
    /// few orders, the first window of a length is integrated by nodes or term by term, later ones by stored integrals.
    #[test]
    fn all_ways_agree_with_quadrature() {
        let (period, rules) = (0.7, Rules::shared());
        // The terms of one series decrease as in a smooth motion, those of the other as slowly as the long rule allows.
        let series: [[f64; TERMS]; 2] = [0.3_f64, 0.9]
            .map(|ratio| std::array::from_fn(|n| ratio.powi(n as i32) * (1.3 * n as f64).cos()));
        for set in InstructionSet::available() {
            for (harmonics, share) in [1, 4, 10, 11, 28, 32, 60]
                .into_iter()
                .flat_map(|h| [1e-7, 0.013, 0.2, 0.37, 0.8, 1.0].map(|share| (h, share)))
            {
                for (smooth, series) in series.iter().enumerate().map(|(i, s)| (i == 0, s)) {
                    let mut fourier = Fourier::new(set, period, harmonics);
                    let window = Window {
                        cycle: 31,
                        start: 0.15 * (1.0 - share) * period,
                        duration: share * period,
                        ..Window::default()
                    };
                    assert_eq!(smooth, rules.sizes(set, series).falls_off(0.0));
                    let turn = fourier.half_turn(window.duration);
                    let node_values = rules.evaluate_at_nodes(set, series, series[0], turn);
                    let mut measured = vec![Complex64::ZERO; SUBORDERS + harmonics];
                    for round in 0..3 {
                        fourier.add(&window, &node_values);
                        let suborders = std::mem::take(&mut fourier.suborders.present);
                        let mut whole = vec![Complex64::ZERO; harmonics];
                        fourier.advance(&mut whole);
                        let present = fourier.suborders.present;
                        assert_eq!(suborders, [Complex64::ZERO; SUBORDERS]);
                        fourier.suborders.restart();
                        measured[..SUBORDERS].copy_from_slice(&present);
                        measured[SUBORDERS..].copy_from_slice(&whole);
                        let below = TWELFTHS.map(|m| m as f64 / 12.0);
                        let orders = below.into_iter().chain((1..=harmonics).map(|h| h as f64));
                        for (order, found) in orders.zip(&measured) {
                            let exact = by_many_nodes(order, period, &window, series);
                            let error = (found - exact).norm() / window.duration;
                            assert!(
                                error < 2e-14 + 2e-15 * order,
                                "order {order} of {harmonics}, {share} of a cycle, round {round}: {error:e}"
                            );
                        }
                    }
                }
            }
        }
    }

    /// A wave of a quarter of the mesh frequency keeps its amplitude when windows are joined to bound the memory.
    #[test]
    fn sub_orders_of_long_records_keep_their_amplitude() {
        let period = 0.01;
        let amplitude = 3e-6;
        let mut suborders = Suborders::new();
        // ∫ A cos(ωt) e^{−iωt} over a cycle, which is not zero only at the frequency of the wave.
        let one = Complex64::from(0.5 * amplitude * period);
        let mut window = [Complex64::ZERO; SUBORDERS];
        window[0] = one;
        for cycles in [SUBORDER_WINDOW * 100, SUBORDER_WINDOW * 9000] {
            for _ in 0..cycles {
                suborders.add(&window);
                suborders.advance(period);
            }
            let [values, _] = suborders.of_windows(|_| 0.0);
            assert!((values[0] / amplitude - 1.0).abs() < 1e-12, "{values:?}");
        }
    }
}
