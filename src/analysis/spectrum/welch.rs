//! Welch spectra of a motion that does not repeat.
//!
//! The windows' polynomials are read at [`SAMPLES_PER_CYCLE`] instants a mesh cycle.
//! Segments of [`CYCLES_PER_SEGMENT`] mesh cycles, overlapping by half, carry a Hann window;
//! their power is averaged (Welch 1967). A line's amplitude is the peak value of the sine
//! that would give it, where the sine lies on the line. Between two lines, 1/64 mesh order apart,
//! the window shows less of it, at most 15 % (1.42 dB) less half-way (scalloping loss), and a sine
//! is seen on the lines on both sides of it. Broad-band motion is that of a band of 1.5 lines.

use super::{HIGHEST_ORDER, signals};
use crate::analysis::modal_series::Series;
use crate::analysis::outcome::{Spectrum, SpectrumLine, SpectrumMethod};
use crate::model::Model;
use crate::numerics::instructions::portable;
use crate::numerics::legendre::evaluate;
use crate::numerics::linalg;
use crate::propagate::Window;
use num_complex::Complex64;
use realfft::{RealFftPlanner, RealToComplex};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Samples a mesh cycle.
const SAMPLES_PER_CYCLE: usize = 2 * HIGHEST_ORDER;

/// Mesh cycles in a segment: lines every 1/64 mesh order.
const CYCLES_PER_SEGMENT: usize = 64;

/// Samples in a segment.
const SEGMENT: usize = SAMPLES_PER_CYCLE * CYCLES_PER_SEGMENT;

/// Accumulates Welch spectra while a trajectory is integrated.
pub struct Welch {
    period: f64,
    next_sample: usize,
    /// Deflection, force, bearings.
    signals: Vec<Signal>,
    transform: Arc<dyn RealToComplex<f64>>,
    hann: Vec<f64>,
}

/// One signal's pending samples and averaged power.
struct Signal {
    name: String,
    samples: Vec<f64>,
    power: Vec<f64>,
    segments: u32,
}

impl Signal {
    fn new(name: String) -> Self {
        Self {
            name,
            samples: Vec::with_capacity(SEGMENT),
            power: vec![0.0; SEGMENT / 2 + 1],
            segments: 0,
        }
    }
}

/// The transform of a segment. None where its length is not that of the plan, which is the only
/// way this can fail.
fn transformed(plan: &dyn RealToComplex<f64>, mut input: Vec<f64>) -> Option<Vec<Complex64>> {
    if portable() {
        // The planner chooses by the processor.
        return Some(linalg::transform(&input));
    }
    let mut output = vec![Complex64::default(); SEGMENT / 2 + 1];
    plan.process(&mut input, &mut output).ok()?;
    Some(output)
}

impl Welch {
    /// Spectra of deflection and force of a model, and of its bearing forces where `bearings`.
    pub fn new(model: &Model, bearings: bool) -> Self {
        let signals = signals(model, bearings).into_iter();
        Self {
            period: model.period(),
            next_sample: 0,
            signals: signals.map(Signal::new).collect(),
            transform: RealFftPlanner::new().plan_fft_forward(SEGMENT),
            hann: (0..SEGMENT)
                .map(|i| 0.5 - 0.5 * (TAU * i as f64 / SEGMENT as f64).cos())
                .collect(),
        }
    }

    /// Forgets everything accumulated.
    pub fn restart(&mut self) {
        for signal in &mut self.signals {
            signal.samples.clear();
            signal.power.fill(0.0);
            signal.segments = 0;
        }
    }

    /// Instants of this cycle before a time \[s\] are read from one polynomial.
    fn take(&mut self, window: &Window<'_>, bearings: &[Series]) {
        let end = window.start + window.duration;
        while self.next_sample < SAMPLES_PER_CYCLE {
            let time = self.period * self.next_sample as f64 / SAMPLES_PER_CYCLE as f64;
            if time >= end {
                break;
            }
            let x = (2.0 * (time - window.start) / window.duration - 1.0).clamp(-1.0, 1.0);
            self.signals[0].samples.push(evaluate(window.deflection, x));
            self.signals[1].samples.push(evaluate(window.force, x));
            for (signal, force) in self.signals[2..].iter_mut().zip(bearings) {
                signal.samples.push(evaluate(force, x));
            }
            self.next_sample += 1;
            if self.signals[0].samples.len() == SEGMENT {
                self.transform_segments();
            }
        }
    }

    fn transform_segments(&mut self) {
        for signal in &mut self.signals {
            let mean = signal.samples.iter().sum::<f64>() / SEGMENT as f64;
            let input: Vec<f64> = signal
                .samples
                .iter()
                .zip(&self.hann)
                .map(|(s, w)| w * (s - mean))
                .collect();
            if let Some(output) = transformed(&*self.transform, input) {
                for (p, c) in signal.power.iter_mut().zip(&output) {
                    *p += c.norm_sqr();
                }
                signal.segments += 1;
            }
            signal.samples.drain(..SEGMENT / 2);
        }
    }

    /// Takes a window in, with the series of its bearing forces.
    pub fn window(&mut self, window: &Window<'_>, bearings: &[Series]) {
        if window.start == 0.0 {
            self.next_sample = 0;
        }
        self.take(window, bearings);
    }

    /// The spectra; empty before one whole segment.
    pub fn spectra(&self) -> Vec<Spectrum> {
        let gain: f64 = 0.5 * self.hann.iter().sum::<f64>();
        self.signals
            .iter()
            .filter(|s| s.segments > 0)
            .map(|signal| Spectrum {
                signal: signal.name.clone(),
                method: SpectrumMethod::Welch,
                lines: signal
                    .power
                    .iter()
                    .enumerate()
                    .map(|(i, p)| {
                        let order = i as f64 / CYCLES_PER_SEGMENT as f64;
                        SpectrumLine {
                            frequency: order / self.period,
                            order,
                            amplitude: (p / f64::from(signal.segments)).sqrt() / gain,
                        }
                    })
                    .collect(),
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::modal_series::cosine_series;
    use crate::model::fixtures::{constant_mesh, one_mode};

    #[test]
    fn a_sine_has_its_amplitude_at_its_order() {
        let point = crate::model::OperatingPoint {
            load: 0.0,
            speed: TAU,
        };
        let model = Model::new(&one_mode(1.0), &constant_mesh(1.0, 1.0), point).unwrap();
        let mut welch = Welch::new(&model, false);
        // Windows shorter than the sampling interval; the signal is 0.3 cos(2π 2 t).
        let windows = 100;
        for cycle in 0..128 {
            for w in 0..windows {
                let (start, tau) = (w as f64 / f64::from(windows), 1.0 / f64::from(windows));
                let mut sine = cosine_series(2.0 * TAU, 2.0 * TAU * start, tau);
                sine.iter_mut().for_each(|a| *a *= 0.3);
                let shown = Window {
                    cycle,
                    start,
                    duration: tau,
                    deflection: &sine,
                    force: &[0.0],
                    ..Window::default()
                };
                welch.window(&shown, &[]);
            }
        }
        let spectra = welch.spectra();
        let line = spectra[0].lines[2 * CYCLES_PER_SEGMENT];
        assert!((line.amplitude - 0.3).abs() < 1e-12, "{}", line.amplitude);
        assert!((line.order - 2.0).abs() < 1e-15 && (line.frequency - 2.0).abs() < 1e-12);
        assert!(spectra[0].lines[5 * CYCLES_PER_SEGMENT].amplitude < 1e-13);
        assert!(spectra[1].lines.iter().all(|l| l.amplitude == 0.0));
    }
}
