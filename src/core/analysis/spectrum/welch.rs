//! Welch spectra of a motion that does not repeat.
//!
//! The windows' polynomials are sampled at equal intervals. Segments of whole mesh cycles overlap by half and
//! have a Hann window. Their powers are averaged (Welch 1967). The distance of lines is the inverse length of
//! a segment: 1/32 mesh order for 32 mesh cycles. A segment consists of whole periods of the excitation if
//! these are not much longer than requested. Mesh and shaft orders are then on lines.
//!
//! A line's amplitude is the peak value of a sine at the frequency of the line. A sine between two lines
//! appears in both, with a reduced amplitude: half-way, by 15 % (1.42 dB, scalloping loss). Broad-band motion
//! with the one-sided power density S gives lines of amplitude `√(2 B S)`, with
//! B the noise bandwidth, 1.5 lines (Harris 1978).

use crate::analysis::config::{Signals, SpectrumConfig};
use crate::analysis::modal_series::Series;
use crate::analysis::outcome::{Spectrum, SpectrumLine, SpectrumMethod};
use crate::analysis::recurrence::excitation_period;
use crate::analysis::signal::Signal;
use crate::model::Model;
use crate::numerics::fourier::hann;
use crate::numerics::instructions::portable;
use crate::numerics::legendre::evaluate;
use crate::numerics::plain;
use crate::propagate::Window;
use num_complex::Complex64;
use realfft::{RealFftPlanner, RealToComplex};
use std::sync::Arc;

/// Minimum number of samples per period of the highest order. Only components above three times that
/// order alias into the spectrum.
const SAMPLES_PER_TURN: usize = 4;

/// Maximum length of a segment that contains whole periods of the excitation, relative to the requested
/// length.
const LONGER: usize = 4;

/// Noise bandwidth of a Hann window, in lines.
const BANDWIDTH: f64 = 1.5;

/// Smallest number of segments that give a line a standard error.
const FEWEST_SEGMENTS: u32 = 8;

/// Variance of the mean power of segments that overlap by half, divided by the variance without overlap:
/// `1 + 2/6²`, because the amplitudes of neighbouring segments have the correlation 1/6 (Welch 1967).
const OVERLAP: f64 = 1.0 + 2.0 / 36.0;

/// Accumulates Welch spectra while a trajectory is integrated.
#[derive(Clone)]
pub struct Welch {
    /// Mesh period \[s\].
    period: f64,
    /// Number of mesh cycles in a segment.
    cycles: usize,
    /// Number of samples in a segment, a power of two.
    samples: usize,
    highest_order: usize,
    /// The cycle of the first window.
    first: Option<u64>,
    /// Samples taken since the start of this cycle.
    sample_count: u64,
    records: Vec<Record>,
    transform: Arc<dyn RealToComplex<f64>>,
    hann: Vec<f64>,
}

/// Pending samples of a signal, and sums over segments of the power of each line and of its square.
#[derive(Clone)]
struct Record {
    signal: Signal,
    samples: Vec<f64>,
    power: Vec<[f64; 2]>,
    segments: u32,
}

impl Record {
    fn new(signal: Signal, samples: usize, lines: usize) -> Self {
        Self {
            signal,
            samples: Vec::with_capacity(samples),
            power: vec![[0.0; 2]; lines],
            segments: 0,
        }
    }

    /// Amplitude of a line and its standard error, before division by the window's gain.
    fn line(&self, [sum, squares]: [f64; 2]) -> (f64, Option<f64>) {
        let count = f64::from(self.segments);
        let mean = sum / count;
        let spread = (squares / count - mean * mean).max(0.0);
        let error = (OVERLAP * spread / (count - 1.0)).sqrt();
        let has_error = self.segments >= FEWEST_SEGMENTS;
        // By error propagation, σ(A) = σ(A²)/2A.
        let stderr = has_error.then(|| if mean > 0.0 { 0.5 * error / mean.sqrt() } else { 0.0 });
        (mean.sqrt(), stderr)
    }
}

/// The transform of a segment; `None` if the length of the segment is not that of the plan. No other failure
/// is possible.
fn fourier_transform(plan: &dyn RealToComplex<f64>, mut input: Vec<f64>) -> Option<Vec<Complex64>> {
    if portable() {
        // The planner's choice depends on the processor.
        return Some(plain::transform(&input));
    }
    let mut output = vec![Complex64::default(); input.len() / 2 + 1];
    plan.process(&mut input, &mut output).ok()?;
    Some(output)
}

/// Mesh cycles in a segment.
fn segment(model: &Model, requested: usize) -> usize {
    match excitation_period(model) {
        Some(period) if period <= LONGER * requested => requested.div_ceil(period) * period,
        _ => requested,
    }
}

impl Welch {
    /// The requested spectra of a model, if the outputs in `computed` are available.
    pub fn new(model: &Model, config: &SpectrumConfig, computed: Signals) -> Self {
        let cycles = segment(model, config.resolution as usize);
        let highest_order = config.highest_order as usize;
        let samples = (SAMPLES_PER_TURN * highest_order * cycles).next_power_of_two();
        let signals = Signal::requested(model, config.signals, computed).into_iter();
        Self {
            period: model.period(),
            cycles,
            samples,
            highest_order,
            first: None,
            sample_count: 0,
            records: signals
                .map(|signal| Record::new(signal, samples, highest_order * cycles))
                .collect(),
            transform: RealFftPlanner::new().plan_fft_forward(samples),
            hann: hann(samples),
        }
    }

    /// Forgets everything accumulated.
    pub fn restart(&mut self) {
        self.first = None;
        self.sample_count = 0;
        for record in &mut self.records {
            record.samples.clear();
            record.power.fill([0.0; 2]);
            record.segments = 0;
        }
    }

    /// Adds the segments of another trajectory of the same model to the averages. No segment contains parts
    /// of two trajectories: an unfinished one of the other record is omitted.
    pub fn append(&mut self, other: &Self) {
        // At the boundary of the records, segments do not overlap, so errors are slightly too large.
        for (record, other_record) in self.records.iter_mut().zip(&other.records) {
            let lines = record.power.iter_mut().zip(&other_record.power);
            for (sums, values) in lines {
                sums[0] += values[0];
                sums[1] += values[1];
            }
            record.segments += other_record.segments;
        }
    }

    /// Cycle, counted from the first, and phase of the next sample, both exact: the number of
    /// samples is a power of two.
    fn next_sample_time(&self) -> (u64, f64) {
        let sample_cycles = self.sample_count * self.cycles as u64;
        let samples = self.samples as u64;
        (
            sample_cycles / samples,
            (sample_cycles % samples) as f64 / self.samples as f64,
        )
    }

    /// Adds a window, with the series of the outputs.
    pub fn window(&mut self, window: &Window<'_>, outputs: &[Series]) {
        let here = window.cycle - *self.first.get_or_insert(window.cycle);
        let end = window.start + window.duration;
        let mut series: Vec<Series> = Vec::new();
        loop {
            let (cycle, phase) = self.next_sample_time();
            let time = phase * self.period;
            // A sample that round-off places after the last window of its cycle is read in the next one.
            if cycle > here || (cycle == here && time >= end) {
                return;
            }
            if series.is_empty() {
                let records = self.records.iter();
                series.extend(records.map(|record| record.signal.series(window, outputs)));
            }
            let x = if cycle == here {
                (2.0 * (time - window.start) / window.duration - 1.0).clamp(-1.0, 1.0)
            } else {
                -1.0
            };
            for (record, series) in self.records.iter_mut().zip(&series) {
                record.samples.push(evaluate(series, x));
            }
            self.sample_count += 1;
            let full = |record: &Record| record.samples.len() == self.samples;
            if self.records.iter().any(full) {
                self.transform_segments();
            }
        }
    }

    fn transform_segments(&mut self) {
        for record in &mut self.records {
            let mean = record.samples.iter().sum::<f64>() / self.samples as f64;
            let input: Vec<f64> = (record.samples.iter().zip(&self.hann))
                .map(|(s, w)| w * (s - mean))
                .collect();
            if let Some(output) = fourier_transform(&*self.transform, input) {
                for ([sum, squares], c) in record.power.iter_mut().zip(&output[1..]) {
                    let power = c.norm_sqr();
                    *sum += power;
                    *squares += power * power;
                }
                record.segments += 1;
            }
            record.samples.drain(..self.samples / 2);
        }
    }

    /// Whether every signal has a complete segment.
    pub fn has_segments(&self) -> bool {
        self.records.iter().all(|record| record.segments > 0)
    }

    /// The spectra; empty before one complete segment.
    pub fn spectra(&self) -> Vec<Spectrum> {
        let gain: f64 = 0.5 * self.hann.iter().sum::<f64>();
        let step = 1.0 / self.cycles as f64;
        let line = |record: &Record, number: u32, sums: [f64; 2]| {
            let (amplitude, stderr) = record.line(sums);
            let order = f64::from(number) / self.cycles as f64;
            SpectrumLine {
                frequency: order / self.period,
                order,
                amplitude: amplitude / gain,
                stderr: stderr.map(|error| error / gain),
            }
        };
        (self.records.iter())
            .filter(|record| record.segments > 0)
            .map(|record| Spectrum {
                signal: record.signal.name.clone(),
                unit: record.signal.unit.to_owned(),
                method: SpectrumMethod::Welch,
                bandwidth: Some(BANDWIDTH * step / self.period),
                lines: (1..)
                    .zip(&record.power)
                    .take(self.highest_order * self.cycles)
                    .map(|(number, sums)| line(record, number, *sums))
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
    use crate::model::{Drive, DriveShaft, TorqueRipple};
    use crate::numerics::random::Stream;
    use crate::structure::ModalStructure;
    use std::f64::consts::TAU;

    fn config(resolution: u32) -> SpectrumConfig {
        SpectrumConfig {
            signals: Signals {
                deflection: true,
                force: true,
                ..Signals::NONE
            },
            highest_order: 5,
            resolution,
        }
    }

    fn point() -> crate::model::OperatingPoint {
        crate::model::OperatingPoint {
            load: 0.0,
            speed: TAU,
        }
    }

    /// Shows a sine of an order as deflection, in windows, over mesh cycles of one second.
    fn show(welch: &mut Welch, order: f64, amplitude: f64, phase: f64, cycles: [u64; 2]) {
        let windows = 100;
        for cycle in cycles[0]..cycles[1] {
            for w in 0..windows {
                let (start, tau) = (w as f64 / f64::from(windows), 1.0 / f64::from(windows));
                let sample_cycles = TAU * order * (cycle as f64 + start) + phase;
                let mut sine = cosine_series(TAU * order, sample_cycles, tau);
                sine.iter_mut().for_each(|a| *a *= amplitude);
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
    }

    #[test]
    fn a_sine_has_its_amplitude_at_its_order() {
        let model = Model::new(&one_mode(1.0), &constant_mesh(1.0, 1.0), point()).unwrap();
        let mut welch = Welch::new(&model, &config(64), Signals::NONE);
        show(&mut welch, 2.0, 0.3, 0.0, [3, 131]);
        let spectra = welch.spectra();
        assert_eq!(spectra[0].lines.len(), 5 * 64);
        let line = spectra[0].lines[2 * 64 - 1];
        assert!((line.amplitude - 0.3).abs() < 1e-12, "{}", line.amplitude);
        assert!((line.order - 2.0).abs() < 1e-15 && (line.frequency - 2.0).abs() < 1e-12);
        assert_eq!(line.stderr, None, "three segments tell no error");
        assert!(spectra[0].lines[4 * 64].amplitude < 1e-13);
        assert!(spectra[1].lines.iter().all(|l| l.amplitude == 0.0));
        assert_eq!(spectra[0].bandwidth, Some(1.5 / 64.0));
    }

    /// A restart discards all samples before it, including those of an incomplete segment.
    #[test]
    fn a_restart_forgets_everything() {
        let model = Model::new(&one_mode(1.0), &constant_mesh(1.0, 1.0), point()).unwrap();
        let [mut fresh, mut again] =
            [(), ()].map(|()| Welch::new(&model, &config(16), Signals::NONE));
        show(&mut again, 1.3, 5.0, 0.4, [3, 44]);
        again.restart();
        for welch in [&mut fresh, &mut again] {
            show(welch, 2.0, 0.3, 0.1, [50, 130]);
        }
        let (fresh, again) = (fresh.spectra(), again.spectra());
        assert_eq!(fresh.len(), again.len());
        for (a, b) in fresh.iter().zip(&again) {
            assert_eq!(a.lines, b.lines);
        }
    }

    /// Half-way between two lines, a line shows 8/(3π) of the amplitude of a sine, 1.42 dB less. An order of
    /// the excitation is on a line.
    #[test]
    fn an_order_of_the_excitation_loses_nothing() {
        let structure = ModalStructure {
            teeth: 23,
            pinion_torque: Some(vec![1.0]),
            ..one_mode(1.0)
        };
        let ripple = |order: f64| TorqueRipple {
            shaft: DriveShaft::Pinion,
            order,
            amplitude: 1.0,
            phase: 0.0,
        };
        let without = constant_mesh(1.0, 1.0);
        let with = Drive {
            torque_ripple: vec![ripple(2.0)],
            ..constant_mesh(1.0, 1.0)
        };
        let speed = crate::model::OperatingPoint {
            speed: TAU / 23.0,
            ..point()
        };
        let amplitude = |drive: &Drive, resolution: u32, order: f64| {
            let model = Model::new(&structure, drive, speed).unwrap();
            let mut welch = Welch::new(&model, &config(resolution), Signals::NONE);
            show(&mut welch, order, 1.0, 0.7, [0, 300]);
            let lines = &welch.spectra()[0].lines;
            let largest = lines.iter().map(|line| line.amplitude);
            (lines.len(), largest.fold(0.0, f64::max))
        };
        let (count, found) = amplitude(&with, 32, 2.0 / 23.0);
        assert_eq!(count, 5 * 46);
        assert!((found - 1.0).abs() < 1e-12, "{found}");
        let (count, found) = amplitude(&without, 64, 32.5 / 64.0);
        assert_eq!(count, 5 * 64);
        let half_way = 8.0 / (3.0 * std::f64::consts::PI);
        assert!((found / half_way - 1.0).abs() < 2e-3, "{found}");
        // Periods of 23 are too long for segments of 4.
        assert_eq!(amplitude(&with, 5, 1.0).0, 25);
    }

    /// The power of noise is exact, and the errors cover its spread. The noise is a new random value every
    /// sixteenth of a cycle, and every value is sampled twice.
    #[test]
    fn noise_has_its_density_and_its_error_bars() {
        let model = Model::new(&one_mode(1.0), &constant_mesh(1.0, 1.0), point()).unwrap();
        let mut welch = Welch::new(&model, &config(16), Signals::NONE);
        let mut stream = Stream::new(1, 2, 3);
        let steps = 16;
        for cycle in 0..2000 {
            for step in 0..steps {
                let shown = Window {
                    cycle,
                    start: f64::from(step) / f64::from(steps),
                    duration: 1.0 / f64::from(steps),
                    deflection: &[stream.normal()],
                    force: &[0.0],
                    ..Window::default()
                };
                welch.window(&shown, &[]);
            }
        }
        let spectrum = &welch.spectra()[0];
        let bandwidth = spectrum.bandwidth.unwrap();
        let mut outside = 0;
        let mut count = 0;
        for line in &spectrum.lines[8..] {
            // One-sided density of steps of the length τ read twice each: 2 τ cos²(π f τ/2).
            let tau = 1.0 / f64::from(steps);
            let turn = 0.5 * std::f64::consts::PI * line.frequency * tau;
            let exact = (2.0 * bandwidth * 2.0 * tau * turn.cos().powi(2)).sqrt();
            let error = line.stderr.unwrap();
            assert!((0.02..0.15).contains(&(error / line.amplitude)), "{error}");
            outside += u32::from((line.amplitude - exact).abs() > 2.0 * error);
            count += 1;
        }
        let share = f64::from(outside) / f64::from(count);
        assert!((0.005..0.12).contains(&share), "{outside} of {count}");
    }

    /// The spectrum of two records of noise has the averages of both records, and smaller errors.
    #[test]
    fn segments_of_two_trajectories_are_averaged() {
        let model = Model::new(&one_mode(1.0), &constant_mesh(1.0, 1.0), point()).unwrap();
        let record = |seed: u64, cycles: u64| {
            let mut welch = Welch::new(&model, &config(16), Signals::NONE);
            let mut stream = Stream::new(seed, 2, 3);
            for cycle in 0..cycles {
                for step in 0..16 {
                    let shown = Window {
                        cycle,
                        start: f64::from(step) / 16.0,
                        duration: 1.0 / 16.0,
                        deflection: &[stream.normal()],
                        force: &[0.0],
                        ..Window::default()
                    };
                    welch.window(&shown, &[]);
                }
            }
            welch
        };
        // The records have 24 and 49 segments. The unfinished segment of the first record is kept.
        let [first, second] = [record(1, 205), record(2, 400)];
        let mut both = first.clone();
        both.append(&second);
        let [first, second, both] = [first, second, both].map(|welch| {
            let count = f64::from(welch.records[0].segments);
            (count, welch.spectra().swap_remove(0).lines)
        });
        assert_eq!([first.0, second.0, both.0], [24.0, 49.0, 73.0]);
        for ((a, b), all) in first.1.iter().zip(&second.1).zip(&both.1) {
            let power = (24.0 * a.amplitude.powi(2) + 49.0 * b.amplitude.powi(2)) / 73.0;
            assert!((all.amplitude / power.sqrt() - 1.0).abs() < 1e-12);
        }
        let mean = |lines: &[SpectrumLine]| {
            let errors = lines.iter().map(|line| line.stderr.unwrap());
            errors.sum::<f64>() / lines.len() as f64
        };
        let gain = mean(&both.1) / mean(&second.1);
        assert!(
            (gain / (49.0_f64 / 73.0).sqrt() - 1.0).abs() < 0.1,
            "{gain}"
        );
    }
}
