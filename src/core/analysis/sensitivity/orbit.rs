//! How do the statistics of a periodic orbit change with a parameter?
//!
//! The orbit moves by `x_p = (I − M)⁻¹ P_p`, with M and P_p the exact derivatives of the map of its period.
//! Every average over mesh phase is differentiated under the integral. A jump of the mesh force at a time t*
//! that depends on the parameter adds `−(F⁺ − F⁻) t*_p`.

use super::derivative_observer::{DerivativeObserver, WindowDerivative};
use super::tangent::ParameterTangent;
use crate::analysis::modal_series::{Series, TERMS, integral};
use crate::analysis::norm::EnergyNorm;
use crate::analysis::orbits::floquet::monodromy;
use crate::model::{Model, ModelDerivative, TrajectoryState};
use crate::numerics::legendre::{at_end, at_start, derivative, evaluate, transforms24};
use crate::numerics::linalg::solve;
use crate::numerics::roots::sign_changes;
use crate::propagate::{Counters, Kernel, Stop};
use faer::Mat;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Quantities of an orbit, with the unit of each.
pub const QUANTITIES: [(&str, &str); 4] = [
    ("deflection_mean", "m"),
    ("deflection_rms", "m"),
    ("force_mean", "N"),
    ("force_peak", "N"),
];

/// Spread of the deflection, relative to its mean, below which the spread is round-off of `⟨δ²⟩ − ⟨δ⟩²`.
const NO_SPREAD: f64 = 1e-7;

/// Amplitude of a harmonic, relative to the deflection, below which the amplitude is round-off.
const NO_AMPLITUDE: f64 = 1e-13;

/// A quantity of an orbit and its derivative with respect to a parameter, per unit of the parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Derivative {
    /// Value of the quantity.
    pub value: f64,
    /// Derivative of the value. It is NaN for an RMS or an amplitude that is only round-off, because these
    /// have a kink at zero.
    pub by_parameter: f64,
}

/// The quantities of an orbit with their derivatives: those of [`QUANTITIES`], then the amplitudes of the
/// harmonics of the mesh frequency in the deflection \[m\], from the first on.
///
/// * `by`: the derivative of the model ([`Model::combined`]).
///
/// # Errors
/// [`Stop`] as for any integration.
pub fn derivatives<K: Kernel>(
    model: &Model,
    by: &ModelDerivative,
    kernel: &K,
    start: &TrajectoryState,
    period: u32,
    harmonics: usize,
) -> Result<Vec<Derivative>, Stop> {
    let mut workspace = kernel.workspace();
    let cycles = u64::from(period);
    let zero_state = vec![0.0; start.state.len()];
    let mut map = ParameterTangent::new(model, by, &start.state, zero_state, ());
    kernel.advance(
        cycles,
        &mut start.clone(),
        &mut workspace,
        &mut map,
        &mut Counters::default(),
    )?;
    let norm = EnergyNorm::new(model);
    let matrix = monodromy(
        model,
        kernel,
        &norm,
        &mut start.clone(),
        period,
        &mut workspace,
        &mut Counters::default(),
    )?;
    let zero = vec![0.0; start.state.len()];
    let moved = norm.difference(map.state(), &zero);
    let n = moved.len();
    let system = Mat::from_fn(n, n, |i, j| f64::from(u8::from(i == j)) - matrix[(i, j)]);
    let along = solve(system.as_ref(), &moved);
    let mut shifted = zero;
    for (&i, y) in norm.weighted_components().iter().zip(&along) {
        shifted[i] = y / norm.weights()[i];
    }
    let sums = Sums::new(model.period(), harmonics);
    let mut watch = ParameterTangent::new(model, by, &start.state, shifted, sums);
    kernel.advance(
        cycles,
        &mut start.clone(),
        &mut workspace,
        &mut watch,
        &mut Counters::default(),
    )?;
    Ok(watch.witness.derivatives())
}

/// Integrals along an orbit, each with its derivative.
#[derive(Debug)]
struct Sums {
    period: f64,
    time: f64,
    deflection: [f64; 2],
    square: [f64; 2],
    force: [f64; 2],
    /// Largest |F|, and the derivative of this value.
    peak: [f64; 2],
    /// If the peak is the end of a window: cycle, time, and the slope of F times its sign \[N/s\].
    peak_end: Option<(u64, f64, f64)>,
    /// The last jump of the force: cycle, time, and derivative of this time.
    jump: Option<(u64, f64, f64)>,
    harmonics: Vec<[Complex64; 2]>,
}

impl Sums {
    fn new(period: f64, harmonics: usize) -> Self {
        Self {
            period,
            time: 0.0,
            deflection: [0.0; 2],
            square: [0.0; 2],
            force: [0.0; 2],
            peak: [0.0; 2],
            peak_end: None,
            jump: None,
            harmonics: vec![[Complex64::ZERO; 2]; harmonics],
        }
    }

    fn derivatives(&self) -> Vec<Derivative> {
        let [mean, mean_p] = self.deflection.map(|s| s / self.time);
        let [square, square_p] = self.square.map(|s| s / self.time);
        let [force, force_p] = self.force.map(|s| s / self.time);
        let rms = (square - mean * mean).max(0.0).sqrt();
        let rms_p = if rms > NO_SPREAD * mean.abs() {
            (0.5 * square_p - mean * mean_p) / rms
        } else {
            f64::NAN
        };
        let least = NO_AMPLITUDE * square.sqrt();
        let amplitudes = self.harmonics.iter().map(|[c, c_p]| {
            let scale = 2.0 / self.time;
            let value = scale * c.norm();
            [
                value,
                if value > least { scale * (c.conj() * c_p).re / c.norm() } else { f64::NAN },
            ]
        });
        [[mean, mean_p], [rms, rms_p], [force, force_p], self.peak]
            .into_iter()
            .chain(amplitudes)
            .map(|[value, by_parameter]| Derivative {
                value,
                by_parameter,
            })
            .collect()
    }

    /// Takes a position on a window at which |F| may be largest. If it is the start of the window, `moved` is
    /// the derivative of its time \[s\] with respect to the parameter. The derivative of the end's time
    /// follows from the next jump.
    fn highest(&mut self, shown: &WindowDerivative<'_>, force: &Series, x: f64, moved: f64) {
        let value = evaluate(force, x);
        if value.abs() > self.peak[0] {
            let window = shown.window;
            let slope = 2.0 / window.duration * evaluate(&derivative(force), x);
            self.peak = [
                value.abs(),
                value.signum() * (evaluate(shown.force, x) + slope * moved),
            ];
            let end = window.start + window.duration;
            self.peak_end = (x == 1.0).then_some((window.cycle, end, value.signum() * slope));
        }
    }

    /// Whether two times, each with its cycle, are equal.
    fn is_same_time(&self, a: (u64, f64), b: (u64, f64)) -> bool {
        a.0 == b.0 && (a.1 - b.1).abs() < 1e-9 * self.period
    }
}

impl DerivativeObserver for Sums {
    fn window(&mut self, shown: &WindowDerivative<'_>) {
        let window = shown.window;
        let tau = window.duration;
        let pad = crate::analysis::modal_series::padded;
        let (deflection, force) = (pad(window.deflection), pad(window.force));
        self.time += tau;
        for (sum, series) in [
            (&mut self.deflection, [&deflection, shown.deflection]),
            (&mut self.force, [&force, shown.force]),
        ] {
            sum[0] += tau * series[0][0];
            sum[1] += tau * series[1][0];
        }
        self.square[0] += integral(&deflection, &deflection, tau);
        self.square[1] += 2.0 * integral(&deflection, shown.deflection, tau);
        let (nodes, weights) = (transforms24().nodes(), transforms24().weights());
        for j in 0..TERMS {
            let phase = TAU * (window.start + 0.5 * tau * (1.0 + nodes[j])) / self.period;
            let values = [&deflection, shown.deflection]
                .map(|s| 0.5 * tau * weights[j] * evaluate(s, nodes[j]));
            for (m, sums) in (1..).zip(&mut self.harmonics) {
                let wave = Complex64::cis(-f64::from(m) * phase);
                for (sum, value) in sums.iter_mut().zip(values) {
                    *sum += value * wave;
                }
            }
        }
        let begin = (window.cycle, window.start);
        let just = (self.jump).filter(|&(cycle, time, _)| self.is_same_time((cycle, time), begin));
        if at_start(&force) != 0.0 {
            self.highest(shown, &force, -1.0, just.map_or(0.0, |(.., moved)| moved));
        }
        let slope = derivative(&force);
        let mut rising = Some(evaluate(&slope, -1.0) > 0.0);
        let noise = 1e-12 * force.iter().map(|a| a.abs()).sum::<f64>();
        let mut places = Vec::new();
        sign_changes(transforms24(), &slope, noise, &mut rising, |x, _| {
            places.push(x)
        });
        for x in places {
            self.highest(shown, &force, x, 0.0);
        }
        if at_end(&force) != 0.0 {
            self.highest(shown, &force, 1.0, 0.0);
        }
    }

    fn jump(&mut self, cycle: u64, time: f64, moved: f64, force_jump: f64) {
        self.force[1] -= force_jump * moved;
        // The end of the window moves only once, even if several contacts jump at this time.
        let ends =
            (self.peak_end).filter(|&(at, end, _)| self.is_same_time((at, end), (cycle, time)));
        if let Some((.., slope)) = ends {
            self.peak[1] += slope * moved;
            self.peak_end = None;
        }
        self.jump = Some((cycle, time, moved));
    }
}
