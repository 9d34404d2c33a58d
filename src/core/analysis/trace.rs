//! One trajectory at evenly spaced instants, with its events.
//!
//! A kernel shows polynomials, not samples: values at the instants `T j/S` of every mesh
//! cycle are read off them, δ' from the derivative of the series,
//!
//! ```text
//! δ = Σ a_n P_n(x),   δ' = 2/Δ Σ a_n P'_n(x),   x = 2 (t − t₀)/Δ − 1
//! ```
//!
//! so that sampling has no influence on the motion. An instant that falls on the joint of
//! two windows is read off the later one: stiffness steps and entries show their new force.

use super::config::Signals;
use super::contact_jumps::ContactJumps;
use super::modal_series::{ModalMotion, padded};
use super::outputs::Outputs;
use super::{Nvh, NvhOutcome};
use crate::model::{ActiveSet, Model, TrajectoryState};
use crate::numerics::legendre::{derivative, evaluate};
use crate::propagate::{Counters, Event, Kernel, Observer, Stop, Window};

/// What is traced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TraceConfig {
    /// Mesh cycles integrated before anything is recorded.
    pub skip: u64,
    /// Mesh cycles recorded.
    pub cycles: u64,
    /// Samples a mesh cycle, the first at mesh phase 0.
    pub samples_per_cycle: u32,
    /// Whether samples carry the modal state.
    pub modal: bool,
    /// Outputs of the structure that they carry.
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
    /// Its rate δ' \[m/s\].
    pub velocity: f64,
    /// Mesh force F \[N\].
    pub force: f64,
    /// The contacts that are closed.
    pub contact: ActiveSet,
    /// Modal state, where asked for.
    pub modal: Option<ModalState>,
    /// The outputs asked for, in the order of the model's.
    pub outputs: Vec<f64>,
}

/// A modal state in the structure's own basis, as manifests take it for an initial state.
#[derive(Debug, Clone, PartialEq)]
pub struct ModalState {
    /// Displacements \[m √kg\], one a mode.
    pub displacement: Vec<f64>,
    /// Velocities \[m √kg/s\], one a mode.
    pub velocity: Vec<f64>,
}

/// Takes samples and events as they come, each kind in order of time.
pub trait TraceSink {
    /// Why it cannot take more.
    type Error;

    /// Takes a sample.
    ///
    /// # Errors
    /// The trace ends with it.
    fn sample(&mut self, sample: TraceSample) -> Result<(), Self::Error>;

    /// Takes an event.
    ///
    /// # Errors
    /// The trace ends with it.
    fn event(&mut self, event: &Event) -> Result<(), Self::Error>;
}

/// What a trace amounts to.
#[derive(Debug, Clone, PartialEq)]
pub struct TraceOutcome {
    /// Whole mesh cycles recorded.
    pub cycles: u64,
    /// Mesh cycles before them that were not integrated one by one: contact was certain to last.
    pub jumped: u64,
    /// Samples handed to the sink.
    pub samples: u64,
    /// Events handed to the sink.
    pub events: u64,
    /// Statistics of the recorded windows; none where there is none.
    pub nvh: Option<NvhOutcome>,
    /// Why the kernel ended the trace early, where it did.
    pub stop: Option<Stop>,
}

/// Traces a trajectory from `start`. Cycles that are skipped are not integrated one by one where
/// contact is certain to last. What was recorded before the kernel gave up is with
/// the sink, and the outcome says why it did.
///
/// # Errors
/// The sink's own error.
pub fn trace<K: Kernel, S: TraceSink>(
    model: &Model,
    kernel: &K,
    start: TrajectoryState,
    question: &TraceConfig,
    sink: &mut S,
) -> Result<TraceOutcome, S::Error> {
    let mut trajectory = start;
    let mut workspace = kernel.workspace();
    let mut counters = Counters::default();
    let mut watch = (
        Recorder {
            model,
            motion: ModalMotion::new(model),
            outputs: Outputs::new(model, question.outputs),
            question,
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
        let mut left = question.skip;
        while left > 0 && stop.is_none() {
            let leap = jumps.jump(kernel, &mut trajectory, left, &mut workspace);
            (jumped, left) = (jumped + leap, left - leap);
            if left > 0 {
                stop = kernel
                    .advance(1, &mut trajectory, &mut workspace, &mut (), &mut counters)
                    .err();
                jumps.marched();
                left -= 1;
            }
        }
    }
    let wanted = match stop {
        None => question.cycles,
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

/// Reads samples off the windows of one cycle after another.
struct Recorder<'a, S: TraceSink> {
    model: &'a Model,
    motion: ModalMotion<'a>,
    outputs: Option<Outputs>,
    question: &'a TraceConfig,
    sink: &'a mut S,
    /// The next instant of the present mesh cycle.
    next: u32,
    samples: u64,
    events: u64,
    /// The sink's first error; nothing is handed to it afterwards.
    refused: Option<S::Error>,
}

/// A joint of windows is known to a few units in the last place of the mesh period.
const JOINT: f64 = 8.0 * f64::EPSILON;

impl<S: TraceSink> Recorder<'_, S> {
    /// The samples that fall into a window.
    fn read(&mut self, window: &Window<'_>) -> Vec<TraceSample> {
        let period = self.model.period();
        let count = self.question.samples_per_cycle;
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
        if self.question.modal {
            for (sample, state) in samples.iter_mut().zip(self.modal(window, &places)) {
                sample.modal = Some(state);
            }
        }
        if let Some(outputs) = &mut self.outputs {
            let series = outputs.rebuild(window);
            for (sample, (_, x)) in samples.iter_mut().zip(&places) {
                sample.outputs = series.iter().map(|own| evaluate(own, *x)).collect();
            }
        }
        samples
    }

    /// The modal states at some places of a window.
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
