//! The map of the first slice of the grid, over the first two axes with several values.
//!
//! If the grid has more points than the map has cells, a cell shows the greatest [`Cell`] of its points. All
//! other axes have their first value. For a refined grid, each place of the plane shows the point that
//! represents it.

use super::point::{Axis, CHAOTIC, PointSummary, TRANSIENT_CHAOS, varied};
use super::refined::Plane;
use super::tied::Tied;
use crate::store::RefinedColumns;
use std::collections::BTreeSet;

/// Largest number of rows and of columns.
const MOST_CELLS: [usize; 2] = [24, 64];

/// Content of a cell. The order of the variants matters: a cell with several points shows the greatest.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub(super) enum Cell {
    Missing,
    Unclassified,
    SteadyContact,
    Periodic(u64),
    Failed,
    NotConverged,
    QuasiPeriodic,
    TransientChaos(f64),
    Chaotic(f64),
}

impl Cell {
    fn of(point: &PointSummary) -> Self {
        match (&*point.status, point.class.as_deref()) {
            ("diverged" | "event_storm" | "failed" | "inaccurate", _) => Self::Failed,
            (_, Some(CHAOTIC)) => Self::Chaotic(point.lambda.unwrap_or(0.0)),
            (_, Some(TRANSIENT_CHAOS)) => Self::TransientChaos(point.lambda.unwrap_or(0.0)),
            (_, Some("quasi_periodic")) => Self::QuasiPeriodic,
            (_, Some("steady_contact")) => Self::SteadyContact,
            (_, Some("periodic")) => Self::Periodic(point.period.unwrap_or(0)),
            ("not_converged", _) | (_, Some("not_converged")) => Self::NotConverged,
            _ => Self::Unclassified,
        }
    }
}

/// The cells of the map.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// The axes of the rows and of the columns.
    pub(super) down: Option<usize>,
    pub(super) across: usize,
    /// Further axes with several values.
    pub(super) further: Vec<usize>,
    pub(super) cells: Vec<Vec<Cell>>,
    pub(super) rows: Bins,
    pub(super) columns: Bins,
    /// Largest exponent in the map.
    pub(super) largest: f64,
    /// Directions of the sweeps in the map. With two directions, every place has two points.
    pub(super) directions: BTreeSet<Option<String>>,
}

impl Map {
    /// An empty map over some axes; `None` if no axis has several values.
    pub(super) fn new(
        axes: &[Axis],
        tied: &Tied,
        refined: Option<&RefinedColumns>,
    ) -> Option<Self> {
        let place = |name: &String| axes.iter().position(|axis| axis.name == *name);
        let varied: Vec<usize> = varied(axes).collect();
        let spanning = tied.free(axes.len()).into_iter();
        let spanning: Vec<usize> = spanning.filter(|axis| varied.contains(axis)).collect();
        let (down, across) = match refined.map(|refined| refined.axes.each_ref().map(place)) {
            Some([down, across]) => (Some(down?), across?),
            None => match spanning[..] {
                [] => return None,
                [across] => (None, across),
                [down, across, ..] => (Some(down), across),
            },
        };
        let shown: Vec<usize> = down.into_iter().chain([across]).collect();
        let held = tied.fixed_axes(axes.len(), &shown).into_iter();
        let further = held.filter(|axis| varied.contains(axis)).collect();
        let rows = Bins::new(
            down.map_or(1, |axis| axes[axis].values.len()),
            MOST_CELLS[0],
        );
        let columns = Bins::new(axes[across].values.len(), MOST_CELLS[1]);
        Some(Self {
            down,
            across,
            further,
            cells: vec![vec![Cell::Missing; columns.count]; rows.count],
            rows,
            columns,
            largest: 0.0,
            directions: BTreeSet::new(),
        })
    }

    /// Adds a point to the map if it lies in the first slice.
    pub(super) fn add(&mut self, axes: &[Axis], point: &PointSummary) {
        let elsewhere = |&axis: &usize| axes[axis].values.first() != point.axis_values.get(axis);
        if self.further.iter().any(elsewhere) {
            return;
        }
        let across = self.across;
        let place = |index: usize| axes[index].place(point.axis_values[index]);
        let column = self.columns.of(place(across));
        let row = self.down.map_or(0, |down| self.rows.of(place(down)));
        if !self.directions.contains(&point.direction) {
            self.directions.insert(point.direction.clone());
        }
        self.show(row, column, Cell::of(point));
    }

    /// Fills the map with the plane of a refined grid.
    pub(super) fn fill(&mut self, plane: &Plane, points: &[PointSummary]) {
        let cells: Vec<Cell> = points.iter().map(Cell::of).collect();
        let [rows, columns] = plane.sides;
        for row in 0..rows {
            for column in 0..columns {
                if let Some(index) = plane.at(row, column) {
                    let (row, column) = (self.rows.of(row), self.columns.of(column));
                    self.show(row, column, cells[index]);
                }
            }
        }
    }

    fn show(&mut self, row: usize, column: usize, cell: Cell) {
        if let Cell::Chaotic(lambda) | Cell::TransientChaos(lambda) = cell {
            self.largest = self.largest.max(lambda);
        }
        let there = &mut self.cells[row][column];
        if cell >= *there {
            *there = cell;
        }
    }
}

/// A range of indices, cut into `count` bins of `size` indices each.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Bins {
    pub(super) size: usize,
    pub(super) count: usize,
}

impl Bins {
    fn new(length: usize, most: usize) -> Self {
        let size = length.div_ceil(most).max(1);
        Self {
            size,
            count: length.div_ceil(size),
        }
    }

    fn of(&self, index: usize) -> usize {
        index / self.size
    }

    pub(super) fn first(&self, bin: usize) -> usize {
        bin * self.size
    }
}
