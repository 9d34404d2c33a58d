//! A run-up or run-down: one motion whose speed changes, and what a test bench records of it.
//!
//! Signals are values of the windows' power series at even instants and at even mesh phases. The second are what a bench
//! calls synchronous resampling; nothing is interpolated.

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

/// What is asked of a run-up.
#[derive(Debug, Clone, PartialEq)]
pub struct RunUpConfig {
    /// Speed of the pinion \[rad/s\] over the time since the start \[s\], above 0 throughout.
    pub speed: PointCourse,
    /// The load.
    pub load: LoadLaw,
    /// Time at the first speed before the start \[s\].
    pub settle: f64,
    /// Samples a second \[1/s\].
    pub sample_rate: f64,
    /// Revolutions of the pinion over which orders and levels are taken.
    pub revolutions: u32,
    /// Orders of the pinion's rotation.
    pub orders: Vec<f64>,
    /// Distance of lines of the spectrogram \[Hz\].
    pub frequency_step: f64,
    /// What is recorded.
    pub signals: Signals,
}

/// The record of a run-up.
#[derive(Debug, Clone, PartialEq)]
pub struct RunUp {
    /// The signals, each with its unit.
    pub signals: Vec<[String; 2]>,
    /// Values at even instants.
    pub instants: Instants,
    /// Orders over the speed.
    pub orders: Vec<OrderPoint>,
    /// Levels over the speed.
    pub levels: Vec<Level>,
    /// Spectra over the time.
    pub spectra: Vec<SpectrumRow>,
    /// Openings and closings of contacts.
    pub events: Vec<MovingEvent>,
    /// Mesh cycles that passed.
    pub cycles: f64,
    /// Why it ended early, where it did.
    pub stop: Option<Stop>,
}

impl RunUpConfig {
    /// The signals asked for that a model has: deflection and force of the first mesh, then outputs.
    pub fn signals_of(&self, model: &Model) -> Vec<MovingSignal> {
        let asked = |signal: &MovingSignal| match signal.first_mesh() {
            Some(deflection) if deflection => self.signals.deflection,
            Some(_) => self.signals.force,
            None => self.signals.has(signal.quantity),
        };
        MovingSignal::of_model(model)
            .into_iter()
            .filter(asked)
            .collect()
    }
}
