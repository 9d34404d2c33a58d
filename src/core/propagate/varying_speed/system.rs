//! A model in the form that windows need: matrices and participations in lanes, and a bound of the rates.

use super::responses::{DirectionResponses, ResponseInputs};
use super::rows::{Rows, rows};
use crate::model::{LOAD_TERMS, LoadTerms, Model};
use crate::propagate::Volterra;
use crate::propagate::vectors::{Aligned, LANES};
use std::f64::consts::TAU;

/// Coupling of the blocks and a contact along a direction.
#[derive(Debug, Clone)]
pub struct Gains {
    /// Deflection per unit of each component.
    pub deflection: Rows,
    /// Input g of the contact force: a force F changes the rates of the components by −g F.
    pub input: Rows,
}

/// The fixed part of the equations of motion.
#[derive(Debug, Clone)]
pub struct System {
    /// Number of blocks, rounded up to whole lane groups.
    pub padded: usize,
    /// Generators of the blocks: entries 00, 01, 10, 11.
    pub generator: [Aligned; 4],
    /// Whether blocks are modes: displacement and velocity, with forces on the velocity alone.
    pub modal: bool,
    /// Gains of every direction.
    pub directions: Vec<Gains>,
    /// Inputs per unit of each load term; `None` for a load without effect.
    pub loads: [Option<Rows>; LOAD_TERMS],
    /// Inputs of the ripples.
    pub ripples: Vec<Rows>,
    /// The distinct numbers of turns per mesh cycle of all waves.
    pub turns: Vec<f64>,
    /// The wave of every ripple, with factors of cosine and sine.
    pub ripple_waves: Vec<Wave>,
    /// The waves of every line's error.
    pub error_waves: Vec<Vec<Wave>>,
    /// Responses of the deflection along every direction.
    pub answers: Vec<DirectionResponses>,
    /// Upper bound of the rates of the structure with one contact closed, at least 1 \[1/s\].
    pub fastest: f64,
}

/// A harmonic: `cos` times the cosine of a wave plus `sin` times its sine.
#[derive(Debug, Clone, Copy)]
pub struct Wave {
    /// Index into [`System::turns`].
    pub wave: usize,
    /// Factor of the cosine.
    pub cos: f64,
    /// Factor of the sine.
    pub sin: f64,
}

impl System {
    /// The system of a model with its loads.
    pub fn new(model: &Model, loads: &LoadTerms) -> Self {
        let generator = |part: usize| rows(model.blocks.iter().map(|block| block.generator[part]));
        let ([a, b], [c, d]) = (generator(0), generator(1));
        let gains = model.directions.iter().map(|direction| Gains {
            deflection: rows(direction.gains.iter().map(|gain| gain.deflection)),
            input: rows(direction.gains.iter().map(|gain| gain.mesh_input)),
        });
        let some = |inputs: &Vec<[f64; 2]>| {
            let any = inputs.iter().flatten().any(|input| *input != 0.0);
            any.then(|| rows(inputs.iter().copied()))
        };
        let mut system = Self {
            padded: model.modes().next_multiple_of(LANES),
            generator: [a, b, c, d],
            modal: model.basis.coupled().is_none(),
            directions: gains.collect(),
            loads: loads.inputs.each_ref().map(some),
            ripples: (model.ripple.iter())
                .map(|ripple| rows(ripple.input.iter().copied()))
                .collect(),
            turns: Vec::new(),
            ripple_waves: Vec::new(),
            error_waves: Vec::new(),
            answers: Vec::new(),
            fastest: Volterra::fastest_structure_rate(model).max(1.0),
        };
        let structure = ResponseInputs {
            generator: &system.generator,
            rate: system.fastest,
            forces: system.directions.iter().map(|gains| &gains.input).collect(),
            loads: &system.loads,
            ripples: &system.ripples,
        };
        system.answers = (system.directions.iter())
            .map(|gains| DirectionResponses::new(&structure, &gains.deflection))
            .collect();
        system.ripple_waves = (model.ripple.iter())
            .map(|ripple| system.wave(ripple.turns_per_cycle, 1.0, ripple.phase))
            .collect();
        system.error_waves = (model.lines.iter())
            .map(|line| {
                let harmonics = line.transmission_error.iter();
                harmonics
                    .map(|h| system.wave(h.turns_per_cycle, h.amplitude, h.phase))
                    .collect()
            })
            .collect();
        system
    }

    /// The harmonic `amplitude cos(θ + phase)` of the wave with `turns` turns per mesh cycle; the phase is in
    /// rad.
    fn wave(&mut self, turns: f64, amplitude: f64, phase: f64) -> Wave {
        let known = self
            .turns
            .iter()
            .position(|known_turns| *known_turns == turns);
        let wave = known.unwrap_or_else(|| {
            self.turns.push(turns);
            self.turns.len() - 1
        });
        let (sin, cos) = phase.sin_cos();
        Wave {
            wave,
            cos: amplitude * cos,
            sin: -amplitude * sin,
        }
    }

    /// The fastest rate \[1/s\] at a number of mesh cycles per second.
    pub fn fastest_at(&self, cycles: f64) -> f64 {
        let waves = self.turns.iter().map(|turns| TAU * turns * cycles);
        waves.fold(self.fastest.max(cycles), f64::max)
    }
}
