//! One trajectory at evenly spaced instants, with its events.
//!
//! A kernel gives polynomials, not samples. Values at the S instants `T j/S` of every mesh cycle are
//! evaluated on them, and δ' on the derivative of the series,
//!
//! ```text
//! δ = Σ a_n P_n(x),   δ' = 2/Δ Σ a_n P'_n(x),   x = 2 (t − t₀)/Δ − 1
//! ```
//!
//! so that sampling has no influence on the motion. An instant on the boundary between two windows belongs to
//! the later one: stiffness steps and entries show their new force.

use super::config::Signals;
use super::contact_jumps::ContactJumps;
use super::modal_series::{ModalMotion, padded};
use super::outputs::Outputs;
use super::{Nvh, NvhOutcome};
use crate::model::{ActiveSet, Model, TrajectoryState};
use crate::numerics::legendre::{derivative, evaluate};
use crate::propagate::{Counters, Event, Kernel, Observer, Stop, Window};

/// Settings of a trace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TraceConfig {
    /// Mesh cycles integrated before the recording.
    pub skip: u64,
    /// Mesh cycles recorded.
    pub cycles: u64,
    /// Samples per mesh cycle, the first at mesh phase 0.
    pub samples_per_cycle: u32,
    /// Whether samples contain the modal state.
    pub modal: bool,
    /// Outputs of the structure in the samples.
    pub outputs: Signals,
}

/// The trajectory at an instant.
#[derive(Debug, Clone, PartialEq)]
pub struct TraceSample {
    /// Mesh cycle, counted from the start of the simulation.
    pub cycle: u64,
    /// Mesh phase in \[0, 1).
    pub phase: f64,
    /// Time since the start of the simulation \[s\].
    pub time: f64,
    /// Mesh deflection δ \[m\].
    pub deflection: f64,
    /// Rate δ' of the mesh deflection \[m/s\].
    pub velocity: f64,
    /// Mesh force F \[N\].
    pub force: f64,
    /// The closed contacts.
    pub contact: ActiveSet,
    /// Modal state, if requested.
    pub modal: Option<ModalState>,
    /// The requested outputs, in the order of the model's outputs.
    pub outputs: Vec<f64>,
}

/// A modal state in the structure's basis, in the form of an initial state in a manifest.
#[derive(Debug, Clone, PartialEq)]
pub struct ModalState {
    /// Displacements \[m √kg\], one per mode.
    pub displacement: Vec<f64>,
    /// Velocities \[m √kg/s\], one per mode.
    pub velocity: Vec<f64>,
}

/// Receives samples and events as they occur, each kind in order of time.
pub trait TraceSink {
    /// Reason why the sink cannot take more.
    type Error;

    /// Takes a sample.
    ///
    /// # Errors
    /// An error ends the trace.
    fn sample(&mut self, sample: TraceSample) -> Result<(), Self::Error>;

    /// Takes an event.
    ///
    /// # Errors
    /// An error ends the trace.
    fn event(&mut self, event: &Event) -> Result<(), Self::Error>;
}

/// Result of a trace.
#[derive(Debug, Clone, PartialEq)]
pub struct TraceOutcome {
    /// Whole mesh cycles recorded.
    pub cycles: u64,
    /// Skipped mesh cycles that were not integrated one by one, because contact was certain to last.
    pub jumped: u64,
    /// Samples passed to the sink.
    pub samples: u64,
    /// Events passed to the sink.
    pub events: u64,
    /// Statistics of the recorded windows; `None` without windows.
    pub nvh: Option<NvhOutcome>,
    /// Why the kernel ended the trace early, if it did.
    pub stop: Option<Stop>,
}

/// Traces a trajectory from `start`. Skipped cycles are not integrated one by one if contact is certain to
/// last. If the kernel stops early, the sink keeps the recorded part, and the outcome has the reason.
///
/// # Errors
/// The error of the sink.
pub fn trace<K: Kernel, S: TraceSink>(
    model: &Model,
    kernel: &K,
    start: TrajectoryState,
    config: &TraceConfig,
    sink: &mut S,
) -> Result<TraceOutcome, S::Error> {
    let mut trajectory = start;
    let mut workspace = kernel.workspace();
    let mut counters = Counters::default();
    let mut watch = (
        Recorder {
            model,
            motion: ModalMotion::new(model),
            outputs: Outputs::new(model, config.outputs),
            config,
            sink,
            next: 0,
            samples: 0,
            events: 0,
            refused: None,
        },
        Nvh::new(model, 0),
    );
    let mut cycles = 0;
    let mut stop = kernel.accepts(model, &trajectory).err();
    let mut jumps = ContactJumps::new(model);
    let mut jumped = 0;
    if stop.is_none() {
        let mut left = config.skip;
        while left > 0 && stop.is_none() {
            let leap = jumps.jump(kernel, &mut trajectory, left, &mut workspace);
            (jumped, left) = (jumped + leap, left - leap);
            if left > 0 {
                stop = kernel
                    .advance(1, &mut trajectory, &mut workspace, &mut (), &mut counters)
                    .err();
                jumps.count_integrated_cycle();
                left -= 1;
            }
        }
    }
    let wanted = match stop {
        None => config.cycles,
        Some(_) => 0,
    };
    for _ in 0..wanted {
        watch.0.next = 0;
        let result = kernel.advance(
            1,
            &mut trajectory,
            &mut workspace,
            &mut watch,
            &mut counters,
        );
        if let Some(refusal) = watch.0.refused.take() {
            return Err(refusal);
        }
        if let Err(reason) = result {
            stop = Some(reason);
            break;
        }
        cycles += 1;
    }
    Ok(TraceOutcome {
        cycles,
        jumped,
        samples: watch.0.samples,
        events: watch.0.events,
        nvh: watch.1.outcome(),
        stop,
    })
}

/// Evaluates samples on the windows of successive cycles.
struct Recorder<'a, S: TraceSink> {
    model: &'a Model,
    motion: ModalMotion<'a>,
    outputs: Option<Outputs>,
    config: &'a TraceConfig,
    sink: &'a mut S,
    /// The next instant of the present mesh cycle.
    next: u32,
    samples: u64,
    events: u64,
    /// The sink's first error; the sink gets nothing afterwards.
    refused: Option<S::Error>,
}

/// Tolerance on the boundary between two windows, in mesh periods: a few units in the last place.
const JOINT: f64 = 8.0 * f64::EPSILON;

impl<S: TraceSink> Recorder<'_, S> {
    /// The samples within a window.
    fn read(&mut self, window: &Window<'_>) -> Vec<TraceSample> {
        let period = self.model.period();
        let count = self.config.samples_per_cycle;
        let tau = window.duration;
        let end = window.start + tau - JOINT * period;
        let mut places = Vec::new();
        while self.next < count {
            let phase = f64::from(self.next) / f64::from(count);
            if phase * period >= end {
                break;
            }
            let x = (2.0 * (phase * period - window.start) / tau - 1.0).clamp(-1.0, 1.0);
            places.push((phase, x));
            self.next += 1;
        }
        if places.is_empty() {
            return Vec::new();
        }
        let slope = derivative(&padded(window.deflection));
        let mut samples: Vec<TraceSample> = places
            .iter()
            .map(|&(phase, x)| TraceSample {
                cycle: window.cycle,
                phase,
                time: (window.cycle as f64 + phase) * period,
                deflection: evaluate(window.deflection, x),
                velocity: 2.0 / tau * evaluate(&slope, x),
                force: evaluate(window.force, x),
                contact: window.contact,
                modal: None,
                outputs: Vec::new(),
            })
            .collect();
        if self.config.modal {
            for (sample, state) in samples.iter_mut().zip(self.modal(window, &places)) {
                sample.modal = Some(state);
            }
        }
        if let Some(outputs) = &mut self.outputs {
            let series = outputs.rebuild(window);
            for (sample, (_, x)) in samples.iter_mut().zip(&places) {
                sample.outputs = series.iter().map(|signal| evaluate(signal, *x)).collect();
            }
        }
        samples
    }

    /// The modal states at positions in a window.
    fn modal(&mut self, window: &Window<'_>, places: &[(f64, f64)]) -> Vec<ModalState> {
        let modes = self.model.modes();
        let series = self.motion.on(window);
        let mut states = vec![[vec![0.0; modes], vec![0.0; modes]]; places.len()];
        for i in 0..modes {
            for row in 0..2 {
                let component = series.component(i, row);
                for (state, (_, x)) in states.iter_mut().zip(places) {
                    state[row][i] = evaluate(&component, *x);
                }
            }
        }
        states
            .iter()
            .map(|halves| {
                let [displacement, velocity] = self.model.basis.modes(&halves.concat());
                ModalState {
                    displacement,
                    velocity,
                }
            })
            .collect()
    }
}

impl<S: TraceSink> Observer for Recorder<'_, S> {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        if self.refused.is_some() {
            return;
        }
        for sample in self.read(window) {
            if let Err(refusal) = self.sink.sample(sample) {
                self.refused = Some(refusal);
                return;
            }
            self.samples += 1;
        }
    }

    fn event(&mut self, event: &Event) {
        if self.refused.is_some() {
            return;
        }
        match self.sink.event(event) {
            Ok(()) => self.events += 1,
            Err(refusal) => self.refused = Some(refusal),
        }
    }
}
