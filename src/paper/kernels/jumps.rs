//! Many mesh cycles of constant contact at once, by repeated squaring of the cycle's map.

use super::cell_model::CellModel;
use super::cycle::Method;
use super::exponential;
use super::matrix::Operator;
use super::spectral::SpectralTables;
use super::steady::cycle;
use super::{DenseError, TableSize};
use crate::model::{ActiveSet, Model, TrajectoryState};
use faer::Mat;
use std::f64::consts::TAU;

/// The maps Φ, Φ², Φ⁴, … of a cycle Φ in contact.
///
/// A jump ignores events: it is valid if contact persists throughout, which [`Fused`](super::Fused) certifies cycle by
/// cycle.
#[derive(Debug)]
pub struct PowerJumps<'m> {
    cell_model: CellModel<'m>,
    powers: Vec<Operator>,
    spare: Vec<f64>,
    state: Vec<f64>,
}

impl<'m> PowerJumps<'m> {
    /// Maps for jumps of up to `most` mesh cycles; longer jumps repeat them.
    ///
    /// # Errors
    /// [`DenseError`] if tables cannot represent the model, or the speed is too slow for them.
    pub fn new(model: &'m Model, most: u64) -> Result<Self, DenseError> {
        let cell_model = CellModel::new(model, 1, SpectralTables::REACH, 0, None)?;
        let grid = &cell_model.grid;
        let increments: Vec<Mat<f64>> = (cell_model.contact_generators.iter().zip(&grid.classes))
            .map(|(g, class)| exponential::increment(g, grid.rate, class.duration))
            .collect();
        let mut map = cycle(&cell_model, &increments);
        let mut powers = Vec::new();
        let mut cycles = 1u64;
        loop {
            turn_exactly(&cell_model, cycles, &mut map);
            powers.push(Operator::new(exponential::plus_one(map.clone()).as_ref()));
            match cycles.checked_mul(2) {
                Some(twice) if twice <= most => cycles = twice,
                _ => break,
            }
            map = exponential::after(&map, &map);
        }
        let padded = cell_model.layout.padded();
        Ok(Self {
            cell_model,
            powers,
            spare: vec![0.0; padded],
            state: vec![0.0; padded],
        })
    }

    /// Advances a trajectory in contact by `cycles` mesh cycles; returns the number of products. A trajectory in free
    /// flight is unchanged.
    pub fn jump(&mut self, trajectory: &mut TrajectoryState, cycles: u64) -> u64 {
        if trajectory.contact == ActiveSet::FREE {
            return 0;
        }
        let n = 2 * self.cell_model.layout.modes;
        self.state[..n].copy_from_slice(&trajectory.state);
        self.cell_model
            .start_cycle(trajectory.cycle, trajectory.contact, &mut self.state);
        let mut products = 0;
        let last = self.powers.len() - 1;
        let mut apply = |power: &Operator, state: &mut Vec<f64>| {
            power.apply(state, &mut self.spare);
            std::mem::swap(state, &mut self.spare);
            products += 1;
        };
        for (bit, power) in self.powers.iter().enumerate().take(last) {
            if cycles >> bit & 1 == 1 {
                apply(power, &mut self.state);
            }
        }
        for _ in 0..cycles >> last {
            apply(&self.powers[last], &mut self.state);
        }
        trajectory.state.copy_from_slice(&self.state[..n]);
        trajectory.cycle += cycles;
        products
    }

    /// Size of the tables.
    pub fn bytes(&self) -> TableSize {
        self.cell_model.bytes(self.powers.iter())
    }
}

/// Writes the rotation of the carried pairs over some cycles, minus the identity. Squaring would double its round-off
/// every time, and the exact rotation is known.
fn turn_exactly(cell_model: &CellModel<'_>, cycles: u64, map: &mut Mat<f64>) {
    let layout = &cell_model.layout;
    for pair in 0..layout.harmonics() {
        let turns = match cell_model.model.ripple.get(pair) {
            Some(ripple) => (cycles as f64 * ripple.turns_per_cycle).fract(),
            None => {
                let error = &cell_model.model.lines[0].transmission_error;
                let harmonic = &error[pair - layout.ripples];
                (cycles as f64 * harmonic.turns_per_cycle).fract()
            }
        };
        let (sin, cos) = (TAU * turns).sin_cos();
        let at = layout.pairs() + 2 * pair;
        map[(at, at)] = cos - 1.0;
        map[(at, at + 1)] = -sin;
        map[(at + 1, at)] = sin;
        map[(at + 1, at + 1)] = cos - 1.0;
    }
}
