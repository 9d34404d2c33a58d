//! A model as a window needs it: matrices and participations in lanes, and how fast anything moves.

use super::answers::{Answers, Structure};
use super::rows::{Rows, rows};
use crate::model::{LOAD_TERMS, LoadTerms, Model};
use crate::propagate::Volterra;
use crate::propagate::vectors::{Aligned, LANES};
use std::f64::consts::TAU;

/// How a contact along a direction meets the blocks.
#[derive(Debug, Clone)]
pub struct Gains {
    /// What the deflection is of the components.
    pub deflection: Rows,
    /// What a unit force takes off the components' rates.
    pub input: Rows,
}

/// The fixed part of the equations of motion.
#[derive(Debug, Clone)]
pub struct System {
    /// Blocks, filled up to whole lane groups.
    pub padded: usize,
    /// Generators of the blocks: entries 00, 01, 10, 11.
    pub generator: [Aligned; 4],
    /// Whether blocks are modes: displacement and velocity, forces on the velocity alone.
    pub modal: bool,
    /// By direction.
    pub directions: Vec<Gains>,
    /// Inputs per unit of each load term; none where there is nothing.
    pub loads: [Option<Rows>; LOAD_TERMS],
    /// Inputs of the ripples.
    pub ripples: Vec<Rows>,
    /// Turns a mesh cycle of every wave, once each.
    pub turns: Vec<f64>,
    /// Of every ripple: its wave, and factors of the wave's cosine and sine.
    pub ripple_waves: Vec<Wave>,
    /// Of every line likewise.
    pub error_waves: Vec<Vec<Wave>>,
    /// Answers of deflections, by direction.
    pub answers: Vec<Answers>,
    /// At least 1: a bound of the rates of the structure with one contact closed \[1/s\].
    pub fastest: f64,
}

/// A part of something that repeats: `cos` times the cosine of a wave and `sin` times its sine.
#[derive(Debug, Clone, Copy)]
pub struct Wave {
    /// Among [`System::turns`].
    pub wave: usize,
    /// Factor of the cosine.
    pub cos: f64,
    /// Factor of the sine.
    pub sin: f64,
}

impl System {
    /// That of a model with some loads.
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
        let mut own = Self {
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
            fastest: Volterra::fastest_own_rate(model).max(1.0),
        };
        let structure = Structure {
            generator: &own.generator,
            rate: own.fastest,
            forces: own.directions.iter().map(|gains| &gains.input).collect(),
            loads: &own.loads,
            ripples: &own.ripples,
        };
        own.answers = (own.directions.iter())
            .map(|gains| Answers::new(&structure, &gains.deflection))
            .collect();
        own.ripple_waves = (model.ripple.iter())
            .map(|ripple| own.wave(ripple.turns_per_cycle, 1.0, ripple.phase))
            .collect();
        own.error_waves = (model.lines.iter())
            .map(|line| {
                let harmonics = line.transmission_error.iter();
                harmonics
                    .map(|h| own.wave(h.turns_per_cycle, h.amplitude, h.phase))
                    .collect()
            })
            .collect();
        own
    }

    /// A cosine of some amplitude and phase \[rad\] as part of a wave.
    fn wave(&mut self, turns: f64, amplitude: f64, phase: f64) -> Wave {
        let known = self.turns.iter().position(|own| *own == turns);
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

    /// The fastest rate \[1/s\] while so many mesh cycles pass a second.
    pub fn fastest_at(&self, cycles: f64) -> f64 {
        let waves = self.turns.iter().map(|turns| TAU * turns * cycles);
        waves.fold(self.fastest.max(cycles), f64::max)
    }
}
