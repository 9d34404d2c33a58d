//! A run-up or run-down: one motion with a changing speed, recorded as on a test bench.
//!
//! Signals are values of the windows' power series at evenly spaced instants and mesh phases, without
//! interpolation. On a test bench, signals at evenly spaced phases result from synchronous resampling.

mod blocks;
mod course;
mod instants;
mod record;
mod spectrogram;

pub use blocks::{Level, OrderPoint};
pub use course::LoadLaw;
pub use instants::Instants;
pub use record::record;
pub use spectrogram::SpectrumRow;

use super::config::Signals;
use crate::model::Model;
use crate::numerics::point_course::PointCourse;
use crate::propagate::Stop;
use crate::propagate::varying_speed::{MovingEvent, MovingSignal};

/// Settings of a run-up.
#[derive(Debug, Clone, PartialEq)]
pub struct RunUpConfig {
    /// Speed of the pinion \[rad/s\] over the time since the start \[s\], above 0 throughout.
    pub speed: PointCourse,
    /// The load.
    pub load: LoadLaw,
    /// Time before the start \[s\], at the constant first speed.
    pub settle: f64,
    /// Samples per second \[1/s\].
    pub sample_rate: f64,
    /// Revolutions of the pinion over which orders and levels are taken.
    pub revolutions: u32,
    /// Orders of the pinion's rotation.
    pub orders: Vec<f64>,
    /// Frequency step between lines of the spectrogram \[Hz\].
    pub frequency_step: f64,
    /// Recorded signals.
    pub signals: Signals,
}

/// The record of a run-up.
#[derive(Debug, Clone, PartialEq)]
pub struct RunUp {
    /// The signals, each with its unit.
    pub signals: Vec<[String; 2]>,
    /// Values at evenly spaced instants.
    pub instants: Instants,
    /// Amplitudes and phases of the signals at the requested orders, over the speed.
    pub orders: Vec<OrderPoint>,
    /// Means, RMS and other statistics of the signals, over the speed.
    pub levels: Vec<Level>,
    /// Spectra of the signals, over the time.
    pub spectra: Vec<SpectrumRow>,
    /// Openings and closings of contacts.
    pub events: Vec<MovingEvent>,
    /// Number of mesh cycles.
    pub cycles: f64,
    /// Why the run-up ended early, if it did.
    pub stop: Option<Stop>,
}

impl RunUpConfig {
    /// The requested signals that a model has: deflection and force of the first mesh, then outputs.
    pub fn signals_of(&self, model: &Model) -> Vec<MovingSignal> {
        let is_requested = |signal: &MovingSignal| match signal.first_mesh() {
            Some(deflection) if deflection => self.signals.deflection || self.signals.meshes,
            Some(_) => self.signals.force || self.signals.meshes,
            None => self.signals.has(signal.quantity),
        };
        MovingSignal::of_model(model)
            .into_iter()
            .filter(is_requested)
            .collect()
    }
}
