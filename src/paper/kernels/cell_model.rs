//! The model in the form for all table kernels, and the position on its cycle.

use super::generator::{Generator, Layout};
use super::grid::Grid;
use super::matrix::Operator;
use super::{DenseError, TableSize};
use crate::model::{ActiveSet, Model};
use crate::propagate::events::ROUND_OFF;

/// The model in the form for all table kernels.
#[derive(Debug)]
pub struct CellModel<'m> {
    pub model: &'m Model,
    pub layout: Layout,
    pub grid: Grid,
    /// Generators in contact, one per class of [`Grid::classes`].
    pub contact_generators: Vec<Generator>,
    /// Generators of free flight, one per flight.
    pub flight_generators: Vec<Generator>,
    /// (cos, sin) of the transmission error's harmonics at the start of every cell.
    phases: Vec<f64>,
    /// Whether these phases are the same in every mesh cycle.
    repeats: bool,
    pub event_limit: u32,
    /// Relative round-off of δ.
    pub round_off: f64,
    /// Number of equal parts of the cycle; events are delayed to the start of the next part.
    pub event_grid: Option<u32>,
}

/// Position on the mesh cycle where a stretch starts.
#[derive(Debug, Clone, Copy)]
pub struct Position {
    /// Mesh cycle.
    pub cycle: u64,
    /// Time within the cycle \[s\].
    pub time: f64,
    /// The present cell.
    pub cell: usize,
    /// Whether the cell starts now.
    pub aligned: bool,
    /// The contact that opened or closed here.
    pub crossed: Option<usize>,
}

impl<'m> CellModel<'m> {
    /// A model on cells no longer than `reach` divided by its fastest rate; see [`Grid::new`].
    pub fn new(
        model: &'m Model,
        cells: u32,
        reach: f64,
        event_limit: u32,
        event_grid: Option<u32>,
    ) -> Result<Self, DenseError> {
        let grid = Grid::new(model, cells, reach)?;
        let segment = |class: usize| &model.first_cycle().segments[grid.classes[class].segment];
        let contact_generators = (0..grid.classes.len())
            .map(|class| Generator::new(model, segment(class), true))
            .collect();
        let flight_generators = (grid.flights.iter())
            .map(|&class| Generator::new(model, segment(class), false))
            .collect();
        let phases = (grid.cells.iter())
            .flat_map(|cell| {
                (model.lines[0].transmission_error.iter()).flat_map(|h| {
                    let (sin, cos) = (h.angular_frequency * cell.start).sin_cos();
                    [cos, sin]
                })
            })
            .collect();
        Ok(Self {
            model,
            layout: Layout::new(model),
            contact_generators,
            flight_generators,
            phases,
            repeats: (model.lines[0].transmission_error.iter())
                .all(|h| h.turns_per_cycle.fract() == 0.0),
            event_limit,
            round_off: ROUND_OFF,
            event_grid,
            grid,
        })
    }

    /// Size of tables of these operators.
    pub fn bytes<'o>(&self, operators: impl Iterator<Item = &'o Operator>) -> TableSize {
        let (mut count, mut bytes) = (0, 0);
        for operator in operators {
            count += 1;
            bytes += operator.bytes();
        }
        TableSize {
            operators: count,
            bytes,
            cells: self.grid.cells.len(),
        }
    }

    /// The generator on a cell.
    pub fn generator(&self, cell: usize, contact: ActiveSet) -> &Generator {
        let class = self.grid.cells[cell].class;
        if contact.touching() {
            &self.contact_generators[class]
        } else {
            &self.flight_generators[self.grid.classes[class].flight]
        }
    }

    /// Moves to a cell boundary.
    pub fn align(&self, position: &mut Position, cell: usize) {
        position.time = self.grid.time(cell);
        position.cell = cell;
        position.aligned = true;
    }

    /// Writes the carried entries at the start of a cycle.
    pub fn start_cycle(&self, cycle: u64, contact: ActiveSet, z: &mut [f64]) {
        let position = Position {
            cycle,
            time: 0.0,
            cell: 0,
            aligned: true,
            crossed: None,
        };
        self.set_carried(&position, contact, z);
    }

    /// Writes the carried entries of the augmented state.
    pub fn set_carried(&self, position: &Position, contact: ActiveSet, z: &mut [f64]) {
        let layout = &self.layout;
        z[layout.constant()] = self.model.load;
        z[layout.side()] = contact.sign() * self.model.half_gap;
        let (ripples, errors) =
            z[layout.pairs()..layout.dimension()].split_at_mut(2 * layout.ripples);
        for (pair, r) in ripples.chunks_exact_mut(2).zip(&self.model.ripple) {
            let (sin, cos) = r.phase_at(position.cycle, position.time).sin_cos();
            pair.copy_from_slice(&[cos, sin]);
        }
        if position.aligned && self.repeats {
            errors.copy_from_slice(&self.phases[position.cell * errors.len()..][..errors.len()]);
            return;
        }
        for (pair, h) in errors
            .chunks_exact_mut(2)
            .zip(&self.model.lines[0].transmission_error)
        {
            let (sin, cos) = h.turned(position.cycle, position.time).sin_cos();
            pair.copy_from_slice(&[cos, sin]);
        }
    }
}
