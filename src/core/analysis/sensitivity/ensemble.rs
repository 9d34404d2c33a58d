//! How do the averages of a chaotic motion change with a parameter?
//!
//! Tangents of a chaotic motion grow without bound. The derivative of a long average with respect to a
//! parameter is therefore not the average of derivatives. A difference quotient is computed instead. It uses
//! averages over many trajectories at two values of the parameter, from common starts, each over a stretch of
//! cycles after a transient. The scatter of the members of the ensemble gives the error. The slope is
//! unreliable if it is smaller than two of its errors. It is also unreliable if a step twice as large gives a
//! slope that differs by more than the errors.

use crate::analysis::interrupt::{EndedEarly, Interrupted};
use crate::analysis::modal_series::{integral, padded};
use crate::model::{Model, TrajectoryState};
use crate::numerics::legendre::evaluate;
use crate::numerics::legendre::transforms24;
use crate::propagate::{Counters, Kernel, Observer, Window};
use std::sync::atomic::AtomicBool;

/// Averages of a stretch of motion: mean and RMS of the deflection \[m\], mean of the mesh force \[N\] and of
/// its modulus.
pub const AVERAGES: [(&str, &str); 4] = [
    ("deflection_mean", "m"),
    ("deflection_rms", "m"),
    ("force_mean", "N"),
    ("force_modulus", "N"),
];

/// Size of an ensemble.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ensemble {
    /// Number of members.
    pub members: usize,
    /// Discarded cycles of each member.
    pub transient: u64,
    /// Measured cycles of each member.
    pub cycles: u64,
}

/// A slope, its error, and the slope with the doubled step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slope {
    /// Mean of the averages at both values of the parameter.
    pub value: f64,
    /// Derivative of this mean, per unit of the parameter.
    pub by_parameter: f64,
    /// Standard error of `by_parameter`.
    pub error: f64,
    /// The derivative and its error from a step twice as large.
    pub doubled: [f64; 2],
}

/// Number of standard errors by which the slopes of both steps may differ.
const AGREE: f64 = 3.0;

impl Slope {
    /// Why the slope is unreliable; `None` if it is reliable.
    pub fn unreliable_reason(&self) -> Option<&'static str> {
        let both = self.error.hypot(self.doubled[1]);
        if (self.by_parameter - self.doubled[0]).abs() > AGREE * both {
            return Some(
                "doubling the step changes the slope: the average is not linear in the parameter",
            );
        }
        (self.by_parameter.abs() < 2.0 * self.error)
            .then_some("the slope is within two standard errors of zero")
    }
}

/// Averages of every member at one value of the parameter.
///
/// # Errors
/// [`EndedEarly`] of the first member that ends early or is interrupted.
pub fn averages<K: Kernel>(
    model: &Model,
    kernel: &K,
    starts: &[TrajectoryState],
    settings: &Ensemble,
    interrupt: &AtomicBool,
) -> Result<Vec<[f64; 4]>, EndedEarly> {
    let mut workspace = kernel.workspace();
    (starts.iter())
        .map(|start| {
            Interrupted::check(interrupt)?;
            let mut state = TrajectoryState::new(model, start.state.clone(), start.cycle);
            kernel.advance(
                settings.transient,
                &mut state,
                &mut workspace,
                &mut (),
                &mut Counters::default(),
            )?;
            let mut sums = Averages::default();
            kernel.advance(
                settings.cycles,
                &mut state,
                &mut workspace,
                &mut sums,
                &mut Counters::default(),
            )?;
            Ok(sums.all())
        })
        .collect()
}

/// The slope of a quantity, from its values for the members at the parameter's displacements `−2, −1, 1, 2`
/// times `step`.
pub fn slope(members: [&[f64]; 4], step: f64) -> Slope {
    let of = |low: &[f64], high: &[f64], width: f64| {
        let slopes: Vec<f64> = low.iter().zip(high).map(|(a, b)| (b - a) / width).collect();
        let n = slopes.len() as f64;
        let mean = slopes.iter().sum::<f64>() / n;
        let square = slopes.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (n - 1.0);
        [mean, (square / n).sqrt()]
    };
    let [by_parameter, error] = of(members[1], members[2], 2.0 * step);
    let all = members[1].iter().chain(members[2]);
    let value = all.sum::<f64>() / (members[1].len() + members[2].len()) as f64;
    Slope {
        value,
        by_parameter,
        error,
        doubled: of(members[0], members[3], 4.0 * step),
    }
}

/// Integrals over a stretch.
#[derive(Debug, Default)]
struct Averages {
    time: f64,
    sums: [f64; 4],
}

impl Averages {
    fn all(&self) -> [f64; 4] {
        let [mean, square, force, modulus] = self.sums.map(|sum| sum / self.time);
        [mean, (square - mean * mean).max(0.0).sqrt(), force, modulus]
    }
}

impl Observer for Averages {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        let tau = window.duration;
        let (deflection, force) = (padded(window.deflection), padded(window.force));
        let (nodes, weights) = (transforms24().nodes(), transforms24().weights());
        let modulus: f64 = nodes
            .iter()
            .zip(weights)
            .map(|(x, w)| 0.5 * w * evaluate(&force, *x).abs())
            .sum();
        self.time += tau;
        let square = integral(&deflection, &deflection, tau);
        for (sum, value) in
            self.sums
                .iter_mut()
                .zip([tau * deflection[0], square, tau * force[0], tau * modulus])
        {
            *sum += value;
        }
    }
}
