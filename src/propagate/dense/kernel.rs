//! What all table kernels are: a course, and tables that cross its pieces.

use super::course::Course;
use super::generator::Generator;
use super::march::{Method, Piece, Workspace};
use super::{DenseError, TableSize};
use crate::model::TrajectoryState;
use crate::propagate::{Counters, Kernel, Observer, Stop, Tangents};

/// A table kernel for one model.
#[derive(Debug)]
pub struct Dense<'m, M> {
    pub(super) course: Course<'m>,
    pub(super) tables: M,
}

impl<M: Method> Dense<'_, M> {
    /// Size of the tables.
    pub fn bytes(&self) -> TableSize {
        self.course.bytes(self.tables.operators())
    }
}

impl<M: Method> Kernel for Dense<'_, M> {
    type Workspace = Workspace<M::Scratch>;

    fn workspace(&self) -> Self::Workspace {
        self.course.workspace(self.tables.scratch(&self.course))
    }

    fn exact(&self) -> bool {
        self.course.event_grid.is_none()
    }

    fn march<O: Observer>(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        workspace: &mut Self::Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        self.course.march(
            &self.tables,
            trajectory,
            tangents,
            workspace,
            observer,
            counters,
        )
    }
}

/// One table a class of cells in contact, one a flight.
#[derive(Debug)]
pub struct Stock<T> {
    contact: Vec<T>,
    flight: Vec<T>,
}

impl<T> Stock<T> {
    /// Tables made one by one of a generator, a class of its cells, and whether it is of contact;
    /// contact first.
    pub(super) fn new(
        course: &Course<'_>,
        mut make: impl FnMut(&Generator, usize, bool) -> Result<T, DenseError>,
    ) -> Result<Self, DenseError> {
        let contact = course.contact.iter().enumerate();
        let contact = contact
            .map(|(class, g)| make(g, class, true))
            .collect::<Result<_, _>>()?;
        let flight = course.flight.iter().zip(&course.grid.flights);
        let flight = flight
            .map(|(g, &class)| make(g, class, false))
            .collect::<Result<_, _>>()?;
        Ok(Self { contact, flight })
    }

    /// The table of a piece, and its place: whether it is of contact, and which.
    pub(super) fn of(&self, course: &Course<'_>, piece: &Piece) -> (&T, (bool, usize)) {
        let class = course.grid.cells[piece.cell].class;
        match piece.contact.touching() {
            true => (&self.contact[class], (true, class)),
            false => {
                let flight = course.grid.classes[class].flight;
                (&self.flight[flight], (false, flight))
            }
        }
    }

    /// All tables, contact first.
    pub fn all(&self) -> impl Iterator<Item = &T> {
        self.contact.iter().chain(&self.flight)
    }
}
