//! The mesh cycle in cells, the unit steps of the table kernels.

use super::DenseError;
use crate::model::{Contact, Model, Release};
use crate::propagate::Volterra;

/// Lengths closer than this, relative, are one.
const SAME_LENGTH: f64 = 1e-12;

/// A boundary this close to one of equal parts, in parts, lies on it.
const ON_BOUNDARY: f64 = 1e-9;

/// Most cells a cycle: their tables are dense.
const MOST_CELLS: f64 = 20_000.0;

/// One cell.
#[derive(Debug, Clone, Copy)]
pub struct Cell {
    /// Mesh segment.
    pub segment: usize,
    /// Among [`Grid::classes`].
    pub class: usize,
    /// Start within the mesh cycle \[s\].
    pub start: f64,
}

/// What cells with the same operators share.
#[derive(Debug, Clone, Copy)]
pub struct Class {
    /// A segment of this class.
    pub segment: usize,
    /// Length Δ \[s\].
    pub duration: f64,
    /// Among the flights: cells of one length and direction share the operators of free flight.
    pub flight: usize,
}

/// The cells of a mesh cycle.
#[derive(Debug, Clone)]
pub struct Grid {
    /// The cells, in order.
    pub cells: Vec<Cell>,
    /// Distinct (stiffness, damping, direction, length).
    pub classes: Vec<Class>,
    /// A class of each flight.
    pub flights: Vec<usize>,
    /// Mesh period \[s\].
    pub period: f64,
    /// Upper bound of the rates of the model \[rad/s\].
    pub rate: f64,
}

/// Whether the mean load of every block is in proportion to the rated one, as tables have it.
fn loads_are_rated(model: &Model) -> bool {
    (model.blocks.iter().zip(&model.rated_input))
        .all(|(block, rated)| block.static_input == rated.map(|input| input * model.load))
}

/// Whether a model's contacts are the two flanks of a mesh on one line of action, alike but for their
/// side.
fn one_line(model: &Model) -> bool {
    let [drive, coast] = &model.contacts[..] else {
        return false;
    };
    let alike = drive.cycles == coast.cycles && drive.half_gap == coast.half_gap;
    alike && drive.cycles.len() == 1 && drive.side == -coast.side
}

/// Whether tables fit a model at all, whatever its speed.
///
/// # Errors
/// Why they do not.
pub fn fits(model: &Model) -> Result<(), DenseError> {
    if model.basis.coupled().is_some() || !loads_are_rated(model) {
        return Err(DenseError::Coupled);
    }
    if model.blocks.iter().any(|block| block.spread().is_some()) {
        return Err(DenseError::Overdamped);
    }
    if !one_line(model) {
        return Err(DenseError::Contacts);
    }
    let by_force = |contact: &Contact| contact.release == Release::Force;
    if model.contacts.iter().any(by_force) {
        return Err(DenseError::Release);
    }
    let cycle = model.first_cycle();
    if cycle.has_error() {
        return Err(DenseError::FlankError);
    }
    match cycle.segments.iter().all(|s| s.stiffness.is_constant()) {
        true => Ok(()),
        false => Err(DenseError::VaryingStiffness),
    }
}

impl Grid {
    /// At least `cells` cells a cycle, whole numbers of equal ones in every segment, none of
    /// them longer than `reach` over the fastest rate.
    ///
    /// # Errors
    /// Stiffness that varies within a segment, or more cells than tables should have.
    pub fn new(model: &Model, cells: u32, reach: f64) -> Result<Self, DenseError> {
        fits(model)?;
        let cycle = model.first_cycle();
        let rate = Volterra::fastest_rate(model);
        let mut grid = Self {
            cells: Vec::new(),
            classes: Vec::new(),
            flights: Vec::new(),
            period: cycle.period,
            rate,
        };
        let fewest = f64::from(cells).max(rate * cycle.period / reach);
        if fewest.is_nan() || fewest > MOST_CELLS {
            return Err(DenseError::TooManyCells { cells: fewest });
        }
        for (segment, s) in cycle.segments.iter().enumerate() {
            let (start, end) = (cycle.start(segment), cycle.end(segment));
            let count = (fewest * (s.end - s.start) - ON_BOUNDARY).ceil().max(1.0);
            let class = grid.class(model, segment, (end - start) / count);
            grid.cells.extend((0..count as usize).map(|i| Cell {
                segment,
                class,
                start: start + (end - start) * (i as f64 / count),
            }));
        }
        Ok(grid)
    }

    /// The class of a segment's cells; a new one where none is known.
    fn class(&mut self, model: &Model, segment: usize, duration: f64) -> usize {
        let segments = &model.first_cycle().segments;
        let same_length =
            |known: &Class| (known.duration - duration).abs() <= SAME_LENGTH * duration;
        let turned =
            |known: &Class| segments[known.segment].direction == segments[segment].direction;
        let same_mesh = |known: &Class| {
            let (a, b) = (&segments[known.segment], &segments[segment]);
            a.stiffness == b.stiffness && a.damping == b.damping
        };
        let alike = |known: &&Class| same_length(known) && turned(known);
        if let Some(known) = (self.classes.iter()).position(|k| alike(&k) && same_mesh(k)) {
            return known;
        }
        let flight = self.classes.iter().find(alike).map(|known| known.flight);
        let class = self.classes.len();
        self.classes.push(Class {
            segment,
            duration,
            flight: flight.unwrap_or(self.flights.len()),
        });
        if flight.is_none() {
            self.flights.push(class);
        }
        class
    }

    /// Start of a cell, or the end of the cycle \[s\].
    pub fn time(&self, cell: usize) -> f64 {
        self.cells.get(cell).map_or(self.period, |cell| cell.start)
    }

    /// Length of a cell \[s\].
    pub fn duration(&self, cell: usize) -> f64 {
        self.classes[self.cells[cell].class].duration
    }
}
