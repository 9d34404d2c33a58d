//! Fourier lines of a motion that repeats after k mesh cycles. It has lines only at multiples of 1/k of the
//! mesh frequency.
//!
//! Each line is the exact integral `2/T |∫ f e^{−iωt} dt|` of the windows' series over whole
//! periods; nothing is sampled, and nothing leaks from one line into another.

use crate::analysis::config::{Signals, SpectrumConfig};
use crate::analysis::modal_series::Series;
use crate::analysis::outcome::{Spectrum, SpectrumLine, SpectrumMethod};
use crate::analysis::signal::Signal;
use crate::model::Model;
use crate::numerics::fourier::{ScaledWindow, add_lines};
use crate::propagate::Window;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Maximum number of lines of a signal. For a long period the highest orders are omitted.
const MOST_LINES: usize = 8192;

/// Accumulates the lines while whole periods are integrated.
#[derive(Clone)]
pub struct Lines {
    /// Mesh period \[s\].
    mesh_period: f64,
    /// Mesh cycles after which the motion repeats.
    repeats: u32,
    signals: Vec<Signal>,
    /// First and present mesh cycle; `None` before any window.
    cycles: Option<[u64; 2]>,
    /// The present window's signals.
    series: Vec<Series>,
    /// `∫ f e^{−iωt} dt` of every signal, from the lowest frequency on.
    sums: Vec<Vec<Complex64>>,
}

impl Lines {
    /// The requested lines of a model. The outputs in `computed` are available, and the motion repeats after
    /// `repeats` mesh cycles.
    pub fn new(model: &Model, config: &SpectrumConfig, computed: Signals, repeats: u32) -> Self {
        let signals = Signal::requested(model, config.signals, computed);
        let count = (config.highest_order as usize * repeats as usize).min(MOST_LINES);
        Self {
            mesh_period: model.period(),
            repeats,
            cycles: None,
            series: Vec::with_capacity(signals.len()),
            sums: vec![vec![Complex64::ZERO; count]; signals.len()],
            signals,
        }
    }

    /// Forgets everything accumulated.
    pub fn restart(&mut self) {
        self.cycles = None;
        for sums in &mut self.sums {
            sums.fill(Complex64::ZERO);
        }
    }

    /// Adds a window, with the series of the outputs.
    pub fn window(&mut self, window: &Window<'_>, outputs: &[Series]) {
        let first = self.cycles.map_or(window.cycle, |[first, _]| first);
        self.cycles = Some([first, window.cycle]);
        self.series.clear();
        (self.series).extend((self.signals.iter()).map(|signal| signal.series(window, outputs)));
        let slowest = TAU / (f64::from(self.repeats) * self.mesh_period);
        let cycle = (window.cycle - first) % u64::from(self.repeats);
        let stretch = ScaledWindow {
            duration: window.duration,
            half_turn: 0.5 * slowest * window.duration,
            phase: slowest
                * (cycle as f64 * self.mesh_period + window.start + 0.5 * window.duration),
        };
        add_lines(stretch, &self.series, &mut self.sums);
    }

    /// The spectra after whole periods; empty before any window.
    pub fn spectra(&self) -> Vec<Spectrum> {
        let Some([first, present]) = self.cycles else {
            return Vec::new();
        };
        let time = (present - first + 1) as f64 * self.mesh_period;
        let spectrum = |(signal, sums): (&Signal, &Vec<Complex64>)| Spectrum {
            signal: signal.name.clone(),
            unit: signal.unit.to_owned(),
            method: SpectrumMethod::Fourier,
            bandwidth: None,
            lines: (sums.iter().zip(1_u32..))
                .map(|(sum, m)| {
                    let order = f64::from(m) / f64::from(self.repeats);
                    SpectrumLine {
                        frequency: order / self.mesh_period,
                        order,
                        amplitude: 2.0 * sum.norm() / time,
                        stderr: None,
                    }
                })
                .collect(),
        };
        self.signals.iter().zip(&self.sums).map(spectrum).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::modal_series::cosine_series;
    use crate::model::OperatingPoint;
    use crate::model::fixtures::{constant_mesh, one_mode};
    use crate::structure::{BearingGain, ModalStructure, OmittedModeForces};

    fn config() -> SpectrumConfig {
        SpectrumConfig {
            signals: Signals {
                deflection: true,
                force: true,
                bearings: true,
                ..Signals::NONE
            },
            highest_order: 9,
            resolution: 32,
        }
    }

    fn model() -> Model {
        let structure = ModalStructure {
            bearings: vec![BearingGain {
                name: "pinion 1 y".into(),
                gain: vec![1.0],
                rate_gain: Vec::new(),
                left_out: OmittedModeForces::default(),
            }],
            ..one_mode(1.0)
        };
        let point = OperatingPoint {
            load: 0.0,
            speed: TAU,
        };
        Model::new(&structure, &constant_mesh(1.0, 1.0), point).unwrap()
    }

    /// A motion of period 3, observed from its second cycle on over two periods: every signal has the lines of
    /// its sines and no others.
    #[test]
    fn every_sine_is_one_line() {
        let model = model();
        let mut lines = Lines::new(&model, &config(), config().signals, 3);
        // Order, amplitude and phase of deflection, force and bearing force.
        let signals = [
            [(2.0 / 3.0, 0.3, 0.1), (1.0, 0.02, 2.0)],
            [(1.0 / 3.0, 40.0, 0.7), (7.0 / 3.0, 1.0, 0.0)],
            [(5.0 / 3.0, 6.0, 1.1), (4.0 / 3.0, 0.5, 0.3)],
        ];
        let places = [0.0, 0.13, 0.2, 0.21, 0.45, 0.68, 0.9, 1.0];
        // Cycles before a restart are forgotten.
        for cycle in [20, 21, 1, 2, 3, 4, 5, 6] {
            if cycle == 1 {
                lines.restart();
                assert!(lines.spectra().is_empty());
            }
            for ends in places.windows(2) {
                let tau = ends[1] - ends[0];
                let series = signals.map(|sines| {
                    let mut sum = [0.0; 24];
                    for (order, amplitude, phase) in sines {
                        let turned = TAU * order * (cycle as f64 + ends[0]) + phase;
                        let sine = cosine_series(TAU * order, turned, tau);
                        for (sum, a) in sum.iter_mut().zip(sine) {
                            *sum += amplitude * a;
                        }
                    }
                    sum
                });
                let window = Window {
                    cycle,
                    start: ends[0],
                    duration: tau,
                    deflection: &series[0],
                    force: &series[1],
                    ..Window::default()
                };
                lines.window(&window, &series[2..]);
            }
        }
        let spectra = lines.spectra();
        let names: Vec<&str> = spectra.iter().map(|s| s.signal.as_str()).collect();
        assert_eq!(names, ["deflection", "force", "bearing pinion 1 y"]);
        for (spectrum, sines) in spectra.iter().zip(signals) {
            assert_eq!(spectrum.lines.len(), 3 * 9);
            for (m, line) in (1..).zip(&spectrum.lines) {
                assert_eq!(
                    (line.order, line.frequency),
                    (f64::from(m) / 3.0, line.order)
                );
                let own = sines.iter().find(|(order, _, _)| *order == line.order);
                let exact = own.map_or(0.0, |(_, amplitude, _)| *amplitude);
                let error = (line.amplitude - exact).abs() / sines[0].1;
                assert!(
                    error < 4e-15,
                    "{} {}: {error:e}",
                    spectrum.signal,
                    line.order
                );
            }
        }
    }
}
