//! What would be heard and felt: statistics of deflection, force and impacts.
//!
//! Every integral is taken from the windows' polynomials, none from samples:
//!
//! ```text
//! ∫ δ dt = Δ a₀,   ∫ δ² dt = Δ Σ a_n²/(2n+1),   ∫ δ³, δ⁴: Gauss rule exact for degree 95
//! ∫ δ e^{−iωt} dt = Σ a_n ∫ P_n e^{−iωt} dt     (Bessel series of the exponential)
//! ```
//!
//! Powers are taken about the mean of the first window: about zero, the spread of a mesh
//! that hardly moves under load would drown in the round-off of its mean.

use super::modal_series::{TERMS, padded};
use super::outcome::NvhOutcome;
use crate::model::Model;
use crate::numerics::exponential::{Complex, legendre_series, multiply};
use crate::numerics::legendre::{derivative, evaluate, polynomials, variation};
use crate::numerics::quadrature::GaussLegendre;
use crate::propagate::{Event, Observer, Window};

/// Nodes of the rule for third and fourth powers: exact to degree 95 ≥ 4·23.
const NODES: usize = 48;

/// Accumulates statistics while a trajectory is marched.
#[derive(Debug, Clone)]
pub struct Nvh {
    half_gap: f64,
    mesh_frequency: f64,
    /// Legendre polynomials at the nodes, and the weights.
    rule: Box<[[f64; NODES]; TERMS]>,
    weights: Box<[f64; NODES]>,
    time: f64,
    /// Mean δ \[m\] and F \[N\] of the first window: what powers are taken about.
    centre: [f64; 2],
    /// ∫ ((δ − centre)/b)^j dt, j = 1 … 4.
    moments: [f64; 4],
    smallest: f64,
    largest: f64,
    /// ∫ (F − centre)^j dt, j = 1, 2.
    force: [f64; 2],
    force_peak: f64,
    times: [f64; 3],
    impacts: u64,
    impact_speed: f64,
    harmonics: Vec<Complex>,
    /// Length of the last window, and the length that `kernels` are for: a length that comes
    /// twice running is the kernel's own and will come again, others are cuts.
    last_length: f64,
    kernel_length: f64,
    kernels: Vec<[Complex; TERMS]>,
}

impl Nvh {
    /// Statistics of a model with amplitudes at the first `harmonics` mesh orders.
    pub fn new(model: &Model, harmonics: usize) -> Self {
        let gauss = GaussLegendre::new(NODES);
        let mut rule = Box::new([[0.0; NODES]; TERMS]);
        let mut weights = Box::new([0.0; NODES]);
        let mut at_node = [0.0; TERMS];
        for j in 0..NODES {
            polynomials(gauss.nodes[j], &mut at_node);
            for (row, value) in rule.iter_mut().zip(at_node) {
                row[j] = value;
            }
            weights[j] = 0.5 * gauss.weights[j];
        }
        Self {
            half_gap: model.half_gap,
            mesh_frequency: std::f64::consts::TAU / model.period(),
            rule,
            weights,
            time: 0.0,
            centre: [0.0; 2],
            moments: [0.0; 4],
            smallest: f64::INFINITY,
            largest: f64::NEG_INFINITY,
            force: [0.0; 2],
            force_peak: 0.0,
            times: [0.0; 3],
            impacts: 0,
            impact_speed: 0.0,
            harmonics: vec![(0.0, 0.0); harmonics],
            last_length: 0.0,
            kernel_length: 0.0,
            kernels: vec![[(0.0, 0.0); TERMS]; harmonics],
        }
    }

    /// Forgets everything accumulated.
    pub fn restart(&mut self) {
        self.time = 0.0;
        self.moments = [0.0; 4];
        self.smallest = f64::INFINITY;
        self.largest = f64::NEG_INFINITY;
        self.force = [0.0; 2];
        self.force_peak = 0.0;
        self.times = [0.0; 3];
        self.impacts = 0;
        self.impact_speed = 0.0;
        self.harmonics.fill((0.0, 0.0));
    }

    /// The statistics so far; none before any window.
    pub fn outcome(&self) -> Option<NvhOutcome> {
        if self.time <= 0.0 {
            return None;
        }
        let b = self.half_gap;
        let [m1, m2, m3, m4] = self.moments.map(|m| m / self.time);
        let variance = (m2 - m1 * m1).max(0.0);
        let fourth = m4 - 4.0 * m1 * m3 + 6.0 * m1 * m1 * m2 - 3.0 * m1.powi(4);
        let (mean, rms) = (self.centre[0] + b * m1, b * variance.sqrt());
        let [force_first, force_square] = self.force.map(|f| f / self.time);
        let entries = self.impacts.max(1) as f64;
        Some(NvhOutcome {
            dte_mean: mean,
            dte_rms: rms,
            dte_pp: self.largest - self.smallest,
            dte_crest: ratio((self.largest - mean).max(mean - self.smallest), rms),
            dte_kurtosis: ratio(fourth, variance * variance),
            harmonics: self
                .harmonics
                .iter()
                .map(|(re, im)| 2.0 * re.hypot(*im) / self.time)
                .collect(),
            force_mean: self.centre[1] + force_first,
            force_std: (force_square - force_first * force_first).max(0.0).sqrt(),
            force_peak: self.force_peak,
            impact_rate: self.impacts as f64 / self.time,
            impact_velocity: self.impact_speed / entries,
            fractions: self.times.map(|t| t / self.time),
        })
    }

    fn add_harmonics(&mut self, window: &Window<'_>, series: &[f64; TERMS], values: &[f64; NODES]) {
        let tau = window.duration;
        if tau != self.kernel_length && tau == self.last_length {
            self.kernel_length = tau;
            for (h, kernel) in self.kernels.iter_mut().enumerate() {
                let omega = (h + 1) as f64 * self.mesh_frequency;
                window_integrals(omega, tau, kernel);
            }
        }
        self.last_length = tau;
        let (sin, cos) = (self.mesh_frequency * window.start).sin_cos();
        let first = (cos, -sin);
        let turn = 0.5 * self.harmonics.len() as f64 * self.mesh_frequency * tau;
        if tau == self.kernel_length {
            add_by_series(&mut self.harmonics, first, series, &self.kernels);
        } else if turn <= WIDEST_TURN {
            self.add_by_nodes(first, tau, values);
        } else {
            let kernels: Vec<_> = (1..=self.harmonics.len())
                .map(|h| {
                    let mut kernel = [(0.0, 0.0); TERMS];
                    window_integrals(h as f64 * self.mesh_frequency, tau, &mut kernel);
                    kernel
                })
                .collect();
            add_by_series(&mut self.harmonics, first, series, &kernels);
        }
    }

    /// Harmonics of a window from the Gauss rule; `first` is the phase factor of order 1 at
    /// its start.
    fn add_by_nodes(&mut self, first: Complex, tau: f64, values: &[f64; NODES]) {
        let half = 0.5 * self.mesh_frequency * tau;
        for j in 0..NODES {
            let (sin, cos) = (half * (self.rule[1][j] + 1.0)).sin_cos();
            let turn = multiply(first, (cos, -sin));
            let amount = tau * self.weights[j] * values[j];
            let mut rotation = turn;
            for sum in &mut self.harmonics {
                sum.0 += amount * rotation.0;
                sum.1 += amount * rotation.1;
                rotation = multiply(rotation, turn);
            }
        }
    }
}

/// Half turn \[rad\] of the highest harmonic over a window up to which the Gauss rule, exact
/// to degree 95, integrates it with 23rd-degree deflections to round-off.
const WIDEST_TURN: f64 = 8.0;

/// Adds a window's harmonics from its series and the integrals of the terms.
fn add_by_series(
    harmonics: &mut [Complex],
    first: Complex,
    series: &[f64; TERMS],
    kernels: &[[Complex; TERMS]],
) {
    let mut rotation = first;
    for (sum, kernel) in harmonics.iter_mut().zip(kernels) {
        let mut value = (0.0, 0.0);
        for (a, k) in series.iter().zip(kernel) {
            value.0 += a * k.0;
            value.1 += a * k.1;
        }
        let value = multiply(rotation, value);
        sum.0 += value.0;
        sum.1 += value.1;
        rotation = multiply(rotation, first);
    }
}

/// Values of a series at the nodes: the nodes are the lanes.
fn at_nodes(series: &[f64; TERMS], rule: &[[f64; NODES]; TERMS]) -> [f64; NODES] {
    let mut values = [0.0; NODES];
    for (a, row) in series.iter().zip(rule) {
        for (value, p) in values.iter_mut().zip(row) {
            *value += a * p;
        }
    }
    values
}

/// A quotient whose denominator may be zero (a motionless mesh): then 0.
fn ratio(numerator: f64, denominator: f64) -> f64 {
    if denominator > 0.0 {
        numerator / denominator
    } else {
        0.0
    }
}

/// `∫₀^τ P_n(2t/τ − 1) e^{−iωt} dt` for n < 24; windows longer than the exponential series
/// allows are integrated by halves of the Gauss rule's reach.
fn window_integrals(omega: f64, tau: f64, out: &mut [Complex; TERMS]) {
    use crate::numerics::exponential::LARGEST_HALF_ARGUMENT;
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
        let (sin, cos) = (0.5 * omega * tau * (x + 1.0)).sin_cos();
        let weight = 0.5 * tau * w;
        for (value, p) in out.iter_mut().zip(&p) {
            value.0 += weight * p * cos;
            value.1 -= weight * p * sin;
        }
    }
}

impl Observer for Nvh {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        let tau = window.duration;
        let deflection = padded(window.deflection);
        let force = padded(window.force);
        if self.time == 0.0 {
            self.centre = [deflection[0], force[0]];
        }
        self.time += tau;
        self.times[window.contact.index()] += tau;

        let (mut sums, mut low, mut high) = ([0.0; 4], (f64::INFINITY, 0), (f64::NEG_INFINITY, 0));
        let values = at_nodes(&deflection, &self.rule);
        for (j, &value) in values.iter().enumerate() {
            if value < low.0 {
                low = (value, j);
            }
            if value > high.0 {
                high = (value, j);
            }
            let u = (value - self.centre[0]) / self.half_gap;
            let w = self.weights[j];
            sums[0] += w * u;
            sums[1] += w * u * u;
            sums[2] += w * u * u * u;
            sums[3] += w * u * u * u * u;
        }
        for (moment, sum) in self.moments.iter_mut().zip(sums) {
            *moment += tau * sum;
        }
        // A window whose bound stays inside what was seen cannot hold a new extreme.
        let spread = variation(&deflection);
        if deflection[0] + spread > self.largest {
            let x = self.rule[1][high.1];
            self.largest = self.largest.max(maximum(&deflection, x));
        }
        if deflection[0] - spread < self.smallest {
            let x = self.rule[1][low.1];
            self.smallest = self.smallest.min(-maximum(&deflection.map(|a| -a), x));
        }
        let mut about = force;
        about[0] -= self.centre[1];
        self.force[0] += tau * about[0];
        for (n, f) in about.iter().enumerate() {
            self.force[1] += tau * f * f / (2 * n + 1) as f64;
        }
        if force[0].abs() + variation(&force) > self.force_peak {
            // Contact damping pulls before it lets go: either sign may be the larger.
            for towards in [force, force.map(|f| -f)] {
                self.force_peak = self.force_peak.max(search_maximum(&towards, &self.rule));
            }
        }
        if !self.harmonics.is_empty() {
            self.add_harmonics(window, &deflection, &values);
        }
    }

    fn event(&mut self, event: &Event) {
        if event.to.touching() {
            self.impacts += 1;
            self.impact_speed += event.rate.abs();
        }
    }
}

/// Largest value of a series, from its largest value at the nodes.
fn search_maximum(series: &[f64; TERMS], rule: &[[f64; NODES]; TERMS]) -> f64 {
    let values = at_nodes(series, rule);
    let mut best = 0;
    for j in 1..NODES {
        if values[j] > values[best] {
            best = j;
        }
    }
    maximum(series, rule[1][best])
}

/// Largest of a series' values at its ends and at the stationary point next to x.
fn maximum(series: &[f64; TERMS], mut x: f64) -> f64 {
    let slope = derivative(series);
    let curvature = derivative(&slope);
    let mut best = evaluate(series, x)
        .max(evaluate(series, -1.0))
        .max(evaluate(series, 1.0));
    for _ in 0..4 {
        let c = evaluate(&curvature, x);
        if c >= 0.0 {
            break;
        }
        x = (x - evaluate(&slope, x) / c).clamp(-1.0, 1.0);
        best = best.max(evaluate(series, x));
    }
    best
}
