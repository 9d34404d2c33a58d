//! Spectra over stretches of time with a Hann window. Successive stretches overlap by half.

use super::RunUpConfig;
use super::instants::Instants;
use crate::numerics::fourier::hann;
use num_complex::Complex64;
use realfft::RealFftPlanner;

/// Highest frequency in a spectrum, relative to the sample rate. Lines near half the rate may be aliases.
const HIGHEST_FREQUENCY: f64 = 0.4;

/// The spectrum of a signal over a stretch of time.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectrumRow {
    /// Time of the middle of the stretch \[s\].
    pub time: f64,
    /// Speed of the pinion at this time \[rad/s\].
    pub speed: f64,
    /// The signal, counted from 0.
    pub signal: usize,
    /// Distance of lines \[Hz\].
    pub step: f64,
    /// Amplitude (peak value) of each line, from frequency 0 on; at 0, the magnitude of the mean. The other lines omit
    /// the mean.
    pub amplitudes: Vec<f64>,
}

/// The spectrogram of all signals.
pub(super) fn spectra(config: &RunUpConfig, instants: &Instants) -> Vec<SpectrumRow> {
    let length = (instants.rate / config.frequency_step).round().max(2.0) as usize;
    let step = instants.rate / length as f64;
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(length);
    let window = hann(length);
    let lines = (HIGHEST_FREQUENCY * length as f64) as usize + 1;
    let count = instants.values.first().map_or(0, Vec::len);
    let (mut input, mut output) = (transform.make_input_vec(), transform.make_output_vec());
    let mut out = Vec::new();
    let starts = (0..count).step_by((length / 2).max(1));
    for from in starts.take_while(|from| from + length <= count) {
        let time = (from as f64 + 0.5 * length as f64) / instants.rate;
        for (signal, values) in instants.values.iter().enumerate() {
            let values = &values[from..from + length];
            // The window would put the mean on line 1, too.
            let mean = values.iter().sum::<f64>() / length as f64;
            for (input, (value, weight)) in input.iter_mut().zip(values.iter().zip(&window)) {
                *input = (value - mean) * weight;
            }
            // The lengths match the plan.
            if transform.process(&mut input, &mut output).is_err() {
                return out;
            }
            // The window halves an amplitude, and a sine is on both sides of 0 Hz.
            let amplitude = |value: &Complex64| 4.0 * value.norm() / length as f64;
            let amplitudes = output.iter().take(lines).skip(1).map(amplitude);
            out.push(SpectrumRow {
                time,
                speed: config.speed_at(time),
                signal,
                step,
                amplitudes: std::iter::once(mean.abs()).chain(amplitudes).collect(),
            });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::config::Signals;
    use crate::analysis::run_up::LoadLaw;
    use crate::numerics::point_course::PointCourse;
    use std::f64::consts::TAU;

    /// A sine at the frequency of a line has its amplitude on this line, half of it on both neighbouring lines, and
    /// zero on all others. The mean is on line 0 only.
    #[test]
    fn a_sine_has_its_amplitude() {
        let config = RunUpConfig {
            speed: PointCourse::line([0.0, 10.0], [2.0, 30.0]),
            load: LoadLaw::OverTime(PointCourse::constant(0.1)),
            settle: 0.0,
            sample_rate: 1000.0,
            revolutions: 1,
            orders: Vec::new(),
            frequency_step: 10.0,
            signals: Signals::NONE,
        };
        let wave = |k: usize| 0.5 + 3.0 * (TAU * 50.0 * k as f64 / 1000.0).cos();
        let instants = Instants {
            rate: 1000.0,
            values: vec![(0..2000).map(wave).collect()],
        };
        let found = spectra(&config, &instants);
        assert_eq!((found.len(), found[0].step), (39, 10.0));
        assert!((found[0].time - 0.05).abs() < 1e-15 && (found[0].speed - 10.5).abs() < 1e-12);
        for (line, amplitude) in found[7].amplitudes.iter().enumerate() {
            let exact = [(0, 0.5), (4, 1.5), (5, 3.0), (6, 1.5)];
            let exact = exact
                .iter()
                .find(|(own, _)| *own == line)
                .map_or(0.0, |(_, a)| *a);
            assert!((amplitude - exact).abs() < 1e-12, "{line}: {amplitude}");
        }
    }
}
