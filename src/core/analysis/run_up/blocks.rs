//! Orders and levels over stretches of several revolutions. Successive stretches overlap by half.

use super::RunUpConfig;
use crate::model::FlankState;
use crate::numerics::fourier::hann;
use crate::propagate::varying_speed::MovingEvent;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Signals at evenly spaced mesh phases.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Phases {
    /// Samples per mesh cycle.
    pub per_cycle: u64,
    /// Number of the first sample, counted from mesh phase 0 of cycle 0.
    pub first: u64,
    /// Values by signal and sample.
    pub values: Vec<Vec<f64>>,
    /// Time of each sample \[s\].
    pub times: Vec<f64>,
    /// Closed flanks at each sample.
    pub contacts: Vec<FlankState>,
}

/// A signal at an order, at one speed of the run-up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrderPoint {
    /// Time \[s\].
    pub time: f64,
    /// Speed of the pinion \[rad/s\].
    pub speed: f64,
    /// The signal, counted from 0.
    pub signal: usize,
    /// Multiple of the pinion's rotation.
    pub order: f64,
    /// Peak value.
    pub amplitude: f64,
    /// Phase \[rad\]: the signal is `amplitude cos(order θ + phase)`, with θ the pinion's mean angle since
    /// mesh cycle 0.
    pub phase: f64,
}

/// Statistics of a signal at one speed of the run-up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Level {
    /// Time \[s\].
    pub time: f64,
    /// Speed of the pinion \[rad/s\].
    pub speed: f64,
    /// Load, as a fraction of the rated one.
    pub load: f64,
    /// The signal, counted from 0.
    pub signal: usize,
    /// Mean of the signal.
    pub mean: f64,
    /// Root mean square of the signal about its mean.
    pub rms: f64,
    /// Smallest and largest value.
    pub range: [f64; 2],
    /// Parts of the rotation on the drive flank alone, in free flight, on the coast flank alone, and on both.
    pub fractions: [f64; FlankState::COUNT],
    /// Number of contacts that close, per mesh cycle.
    pub closings: f64,
}

/// The stretches of a record.
pub(super) struct Blocks {
    /// Samples per stretch.
    length: usize,
    /// Mesh cycles per stretch.
    cycles: f64,
    /// The first sample of each stretch, and the time in its middle \[s\].
    starts: Vec<(usize, f64)>,
}

impl Blocks {
    pub(super) fn new(config: &RunUpConfig, phases: &Phases, cycles_per_turn: f64) -> Self {
        let cycles = (f64::from(config.revolutions) * cycles_per_turn)
            .round()
            .max(1.0);
        let length = cycles as usize * phases.per_cycle as usize;
        let count = phases.times.len();
        let starts = (0..count).step_by((length / 2).max(1));
        let whole = starts.take_while(|from| from + length < count);
        let middle = |from: usize| 0.5 * (phases.times[from] + phases.times[from + length]);
        Self {
            length,
            cycles,
            starts: whole.map(|from| (from, middle(from))).collect(),
        }
    }
}

/// The requested orders.
pub(super) fn orders(
    config: &RunUpConfig,
    phases: &Phases,
    blocks: &Blocks,
    cycles_per_turn: f64,
) -> Vec<OrderPoint> {
    let length = blocks.length;
    let window = hann(length);
    let mut out = Vec::new();
    let step = |order: f64| order / cycles_per_turn / phases.per_cycle as f64;
    let tables: Vec<Vec<Complex64>> = (config.orders.iter())
        .map(|order| {
            let turned = |(k, w): (usize, &f64)| {
                let turns = (k as f64 * step(*order)).fract();
                Complex64::from_polar(4.0 * w / length as f64, -TAU * turns)
            };
            window.iter().enumerate().map(turned).collect()
        })
        .collect();
    for &(from, time) in &blocks.starts {
        for (signal, values) in phases.values.iter().enumerate() {
            let values = &values[from..from + length];
            // The window has the mean 1/2.
            let weighted = values.iter().zip(&window).map(|(v, w)| v * w);
            let mean = 2.0 / length as f64 * weighted.sum::<f64>();
            for (order, table) in config.orders.iter().zip(&tables) {
                // At orders between multiples of the resolution, a part of the mean would leak through the
                // window.
                let rest = if *order == 0.0 { 0.0 } else { mean };
                let sum: Complex64 = values.iter().zip(table).map(|(v, t)| (v - rest) * t).sum();
                let turns = ((phases.first as usize + from) as f64 * step(*order)).fract();
                let value = sum * Complex64::cis(-TAU * turns);
                // At order 0 the value is the mean itself: it has no phase and no part at a negative
                // frequency.
                let value = if *order == 0.0 { 0.5 * value } else { value };
                out.push(OrderPoint {
                    time,
                    speed: config.speed_at(time),
                    signal,
                    order: *order,
                    amplitude: value.norm(),
                    phase: value.arg(),
                });
            }
        }
    }
    out
}

/// The levels of all signals.
pub(super) fn levels(
    config: &RunUpConfig,
    phases: &Phases,
    events: &[MovingEvent],
    blocks: &Blocks,
) -> Vec<Level> {
    let length = blocks.length;
    let mut out = Vec::new();
    for &(from, time) in &blocks.starts {
        let range = from..from + length;
        // Events are sorted by time.
        let [first, end] = [range.start, range.end].map(|at| {
            let until = phases.times[at];
            events.partition_point(|event| event.time < until)
        });
        let closes = |event: &&MovingEvent| event.to.holds(event.contact);
        let closings = events[first..end].iter().filter(closes).count();
        let mut fractions = [0.0; FlankState::COUNT];
        for flanks in &phases.contacts[range.clone()] {
            fractions[flanks.index()] += 1.0 / length as f64;
        }
        for (signal, values) in phases.values.iter().enumerate() {
            let values = &values[range.clone()];
            let mean = values.iter().sum::<f64>() / length as f64;
            let square: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
            let least = values.iter().copied().fold(f64::INFINITY, f64::min);
            let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            out.push(Level {
                time,
                speed: config.speed_at(time),
                load: config.load_at(time),
                signal,
                mean,
                rms: (square / length as f64).sqrt(),
                range: [least, most],
                fractions,
                closings: closings as f64 / blocks.cycles,
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

    /// A wave of order 3 of a pinion of 20 teeth, with a mean. The mean does not appear at orders between
    /// multiples of 1/`revolutions`.
    #[test]
    fn orders_and_levels_of_a_wave_are_its_own() {
        let config = RunUpConfig {
            speed: PointCourse::line([0.0, 100.0], [1.0, 100.0]),
            load: LoadLaw::OverTime(PointCourse::constant(0.1)),
            settle: 0.0,
            sample_rate: 1e3,
            revolutions: 2,
            orders: vec![0.0, 3.0, 5.0, 30.25],
            frequency_step: 10.0,
            signals: Signals::NONE,
        };
        let (per_cycle, teeth, first) = (64, 20.0, 37);
        let count = 64 * 20 * 7;
        let angle = |k: usize| TAU * (first + k) as f64 / 64.0 / teeth;
        let phases = Phases {
            per_cycle,
            first: first as u64,
            values: vec![
                (0..count)
                    .map(|k| 7.0 + 2.0 * (3.0 * angle(k) + 0.4).cos())
                    .collect(),
            ],
            times: (0..count).map(|k| k as f64 * 1e-4).collect(),
            contacts: vec![FlankState::Drive; count],
        };
        let blocks = Blocks::new(&config, &phases, teeth);
        let found = orders(&config, &phases, &blocks, teeth);
        assert_eq!(found.len(), 4 * 5);
        for point in &found {
            let exact = [7.0, 2.0, 0.0, 0.0][config
                .orders
                .iter()
                .position(|o| *o == point.order)
                .unwrap()];
            // The side lobes of the wave fall with the cube of the distance.
            let lobes = if point.order == 30.25 { 1e-4 } else { 1e-12 };
            assert!((point.amplitude - exact).abs() < lobes, "{point:?}");
            if point.order == 3.0 {
                assert!((point.phase - 0.4).abs() < 1e-12, "{point:?}");
            }
        }
        let found = levels(&config, &phases, &[], &blocks);
        assert!((found[0].mean - 7.0).abs() < 1e-12 && (found[0].rms - 2f64.sqrt()).abs() < 1e-12);
        assert!((found[0].fractions[0] - 1.0).abs() < 1e-12 && found[0].closings == 0.0);
    }
}
