//! The record of a run-up: its signals at evenly spaced instants and mesh phases.

use super::blocks::{Blocks, Phases, levels, orders};
use super::course::PARTS;
use super::instants::Instants;
use super::spectrogram::spectra;
use super::{RunUp, RunUpConfig};
use crate::analysis::Interrupted;
use crate::model::TrajectoryState;
use crate::propagate::varying_speed::{
    Instant, Motion, MotionObserver, MovingEvent, MovingSignal, SpeedInterval, VaryingSpeed,
    VaryingSpeedWindow, place_of, value,
};
use crate::propagate::{Counters, Stop};
use std::sync::atomic::AtomicBool;

/// Samples per mesh cycle, for orders and levels.
const PER_CYCLE: u64 = 64;

/// Tolerance of times, relative to a window. With it, a record contains the instant at its end.
const ROUNDING: f64 = 1e-9;

/// Runs a drive up from a trajectory at its first speed.
///
/// # Errors
/// [`Interrupted`] if the work was interrupted. If the motion cannot be continued, the record contains the part before.
pub fn record(
    kernel: &VaryingSpeed,
    start: &TrajectoryState,
    config: &RunUpConfig,
    interrupt: &AtomicBool,
) -> Result<RunUp, Interrupted> {
    let signals = config.signals_of(kernel.model());
    let mut motion = kernel.start(start);
    let length = config.settle / f64::from(PARTS);
    let settling = SpeedInterval::steady(length, config.speed_at(0.0), config.load_at(0.0));
    let settling = (0..PARTS).map(|_| settling);
    let mut stop = advance(kernel, settling, &mut motion, &mut (), interrupt)?;
    motion.time = 0.0;
    let begin = motion.cycle as f64 + motion.phase;
    let mut recorder = Recorder {
        signals: &signals,
        reads_states: signals.iter().any(MovingSignal::reads_states),
        look: Instant::new(kernel),
        rate: config.sample_rate,
        instants: vec![Vec::new(); signals.len()],
        instants_taken: 0,
        phases: Phases {
            per_cycle: PER_CYCLE,
            first: motion.cycle * PER_CYCLE + (motion.phase * PER_CYCLE as f64).ceil() as u64,
            values: vec![Vec::new(); signals.len()],
            times: Vec::new(),
            contacts: Vec::new(),
        },
        events: Vec::new(),
    };
    if stop.is_none() {
        let stretches = config.stretches().into_iter();
        let stretches = stretches.map(|stretch| stretch.accelerated(kernel));
        stop = advance(kernel, stretches, &mut motion, &mut recorder, interrupt)?;
    }
    let Recorder {
        instants,
        phases,
        events,
        ..
    } = recorder;
    let instants = Instants {
        rate: config.sample_rate,
        values: instants,
    };
    let cycles_per_turn = kernel.cycles_per_radian() * std::f64::consts::TAU;
    let blocks = Blocks::new(config, &phases, cycles_per_turn);
    Ok(RunUp {
        signals: signals.iter().map(MovingSignal::named).collect(),
        orders: orders(config, &phases, &blocks, cycles_per_turn),
        levels: levels(config, &phases, &events, &blocks),
        spectra: spectra(config, &instants),
        instants,
        events,
        cycles: motion.cycle as f64 + motion.phase - begin,
        stop,
    })
}

/// Advances a motion over stretches. Returns the reason if the motion cannot be continued.
fn advance<W: MotionObserver>(
    kernel: &VaryingSpeed,
    stretches: impl Iterator<Item = SpeedInterval>,
    motion: &mut Motion,
    watch: &mut W,
    interrupt: &AtomicBool,
) -> Result<Option<Stop>, Interrupted> {
    let (mut workspace, mut counters) = (kernel.workspace(), Counters::default());
    for stretch in stretches {
        Interrupted::check(interrupt)?;
        if let Err(stop) = kernel.advance(motion, &stretch, &mut workspace, watch, &mut counters) {
            return Ok(Some(stop));
        }
    }
    Ok(None)
}

/// Takes samples from windows.
struct Recorder<'a> {
    signals: &'a [MovingSignal],
    /// Whether any signal reads the states of the blocks.
    reads_states: bool,
    look: Instant,
    rate: f64,
    instants: Vec<Vec<f64>>,
    /// Number of instants whose samples were taken. There may be no signal.
    instants_taken: usize,
    phases: Phases,
    events: Vec<MovingEvent>,
}

impl MotionObserver for Recorder<'_> {
    fn window(&mut self, window: &VaryingSpeedWindow<'_>) {
        let per_cycle = self.phases.per_cycle as f64;
        let next_instant =
            |taken: usize| (taken as f64 / self.rate - window.time) / window.duration;
        let next_phase = |taken: usize| {
            let place = self.phases.first + taken as u64;
            // Whole cycles are subtracted first, so that the rest keeps all digits.
            let cycles = (place / self.phases.per_cycle) as f64 - window.cycle as f64;
            cycles + (place % self.phases.per_cycle) as f64 / per_cycle - window.phase
        };
        let passed = value(&window.cycles, window.part);
        let instants = (self.instants_taken..)
            .map(next_instant)
            .take_while(|place| *place <= 1.0 + ROUNDING)
            .map(|place| place.clamp(0.0, 1.0) * window.part);
        let phases = (self.phases.times.len()..)
            .map(next_phase)
            .take_while(|moment| *moment < passed)
            .map(|moment| place_of(&window.cycles, moment.max(0.0)).min(window.part));
        let (instants, phases): (Vec<f64>, Vec<f64>) = (instants.collect(), phases.collect());
        if instants.is_empty() && phases.is_empty() {
            return;
        }
        self.instants_taken += instants.len();
        for (places, targets) in [
            (&instants, &mut self.instants),
            (&phases, &mut self.phases.values),
        ] {
            for place in places {
                window.evaluate_at(*place, self.reads_states, &mut self.look);
                for (signal, values) in self.signals.iter().zip(targets.iter_mut()) {
                    values.push(signal.value(window, &self.look));
                }
            }
        }
        let time = |u: f64| window.time + window.duration * u / window.part;
        self.phases.times.extend(phases.iter().map(|u| time(*u)));
        let flanks = window.contact.flanks();
        self.phases.contacts.extend(phases.iter().map(|_| flanks));
    }

    fn event(&mut self, event: &MovingEvent) {
        self.events.push(*event);
    }
}
