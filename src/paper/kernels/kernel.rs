//! The common form of all table kernels: a model on cells, and tables that cross its stretches.

use super::cell_model::CellModel;
use super::cycle::{Method, Workspace};
use super::generator::Generator;
use super::state_part::StatePart;
use super::{DenseError, TableSize};
use crate::model::TrajectoryState;
use crate::propagate::{Counters, Kernel, Observer, Stop, Tangents};

/// A table kernel for one model.
#[derive(Debug)]
pub struct Dense<'m, M> {
    pub(super) cell_model: CellModel<'m>,
    pub(super) tables: M,
}

impl<M: Method> Dense<'_, M> {
    /// Size of the tables.
    pub fn bytes(&self) -> TableSize {
        self.cell_model.bytes(self.tables.operators())
    }
}

impl<M: Method> Kernel for Dense<'_, M> {
    type Workspace = Workspace<M::Scratch>;

    fn workspace(&self) -> Self::Workspace {
        self.cell_model
            .workspace(self.tables.scratch(&self.cell_model))
    }

    fn exact(&self) -> bool {
        self.cell_model.event_grid.is_none()
    }

    fn advance_cycle<O: Observer>(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        workspace: &mut Self::Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        self.cell_model.advance_cycle(
            &self.tables,
            trajectory,
            tangents,
            workspace,
            observer,
            counters,
        )
    }
}

/// One table per class of cells in contact, and one per flight (length and direction of cells) in free flight.
#[derive(Debug)]
pub struct ClassTables<T> {
    contact: Vec<T>,
    flight: Vec<T>,
}

impl<T> ClassTables<T> {
    /// Makes the tables one by one from a generator, a class of its cells, and whether it is in contact; contact first.
    pub(super) fn new(
        cell_model: &CellModel<'_>,
        mut make: impl FnMut(&Generator, usize, bool) -> Result<T, DenseError>,
    ) -> Result<Self, DenseError> {
        let contact = cell_model.contact_generators.iter().enumerate();
        let contact = contact
            .map(|(class, g)| make(g, class, true))
            .collect::<Result<_, _>>()?;
        let flight = cell_model
            .flight_generators
            .iter()
            .zip(&cell_model.grid.flights);
        let flight = flight
            .map(|(g, &class)| make(g, class, false))
            .collect::<Result<_, _>>()?;
        Ok(Self { contact, flight })
    }

    /// The table of a stretch, and its index: whether it belongs to contact, and its number.
    pub(super) fn of(
        &self,
        cell_model: &CellModel<'_>,
        stretch: &StatePart,
    ) -> (&T, (bool, usize)) {
        let class = cell_model.grid.cells[stretch.cell].class;
        if stretch.contact.touching() {
            (&self.contact[class], (true, class))
        } else {
            let flight = cell_model.grid.classes[class].flight;
            (&self.flight[flight], (false, flight))
        }
    }

    /// All tables, contact first.
    pub fn all(&self) -> impl Iterator<Item = &T> + Clone {
        self.contact.iter().chain(&self.flight)
    }
}
